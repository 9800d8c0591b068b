"""`strainwave move`, `design` and `speed-map`: a drive on a profile, gears for an axis, allowed speeds under loads."""

from pathlib import Path
from typing import Any

import click
import numpy as np

from ...base.facts import data
from ...base.units import RPM
from ...drive.asked import MotorLimits
from ...drive.project import Project
from ...files.design import design_text, read_specification
from ...files.fields.kinds import Kind, Place, Wrong
from ...files.fields.kinds import read as read_value
from ...files.fields.schema import PART, PAYLOAD
from ...files.reading import read_project
from ...files.scan_file import read_profile
from ...files.variants.scatter import scattered
from ...files.yaml_text import name, read
from ...plot.panels import named
from ...plot.studies import move_panels
from ...plot.svg import stacked
from ...study.design.design import design as designed
from ...study.design.result import Design
from ...study.move.move import move as moved
from ...study.move.postures import move_postures
from ...study.move.result import Move
from ...study.speed_map.result import SpeedMap
from ...study.speed_map.speed_map import speed_map as mapped
from ..console import WHAT_X_IS, Progress, as_csv, finished, reported, slug, write_all
from ..view import quantity, span
from .options import dialect_options, file_type, json_option, limit_option, output_option, project_argument

CSV, SVG, JSON = "move.csv", "move.svg", "move.json"


@click.command()
@project_argument
@click.argument("profile", nargs=-1)
@output_option("Folder for move.csv, move.svg and move.json.", required=True)
@click.option("--start", help='Angle of the load at the begin, as "-45 deg".')
@click.option("--payload", help='What the load carries, as "mass: 5 kg, radius: 0.4 m, phase: 90 deg".')
@click.option("--window", help='Largest distance of a settled load from rest, as "30 arcsec".')
@click.option(
    "--band", "bands", nargs=2, multiple=True, metavar="LOW HIGH",
    help='Motor speeds to avoid, as "1200 rpm" "1500 rpm"; repeatable.',
)  # fmt: skip
@click.option("--limited", is_flag=True, help="Keep torque and speed command of the motor within their limits.")
@click.option("--avoid", is_flag=True, help="Take the speeds to avoid of the analysis too, which takes its time.")
@click.option("--postures", is_flag=True, help="Move in every posture of the file; only move.json is written.")
@dialect_options
@json_option
def move(
    project: Path, profile: tuple[str, ...], output: Path, start: str | None, payload: str | None, window: str | None,
    bands: tuple[tuple[str, str], ...], limited: bool, avoid: bool, postures: bool, delimiter: str | None,
    decimal: str | None,
    as_json: bool,
) -> None:  # fmt: skip
    """Move the load along PROFILE: error, settling, torques.

    Computes bearing life and energy too.
    PROFILE is one part or several, one after the other: a CSV file with the columns time [s] and angle [deg], or fields
    as in the group `move` of a project file: "trapezoid, angle: 90 deg, time: 0.6 s", "s_curve, angle: -90 deg, time:
    0.6 s", "dwell, time: 0.4 s". Without it the profile of the project file is taken.
    """
    drive = read_project(project)
    parts = [profile_part(text, delimiter=delimiter, decimal=decimal) for text in profile]
    angles = {"start": (start, "any"), "window": (window, "positive")}
    options: dict[str, Any] = {
        name: quantity(f"--{name}", text, "rad", sign) for name, (text, sign) in angles.items() if text is not None
    }
    if payload is not None:
        options["payload"] = _read(payload, f"{{{payload}}}", PAYLOAD, "payload")
    avoided = [span("--band", ends, "rad/s", 'for example "500 rpm" "700 rpm"') for ends in bands]
    with Progress(drive.title) as progress:
        if avoid:
            analysed = drive.analyze(lambda what, share: progress.show(what, 0.5 * share)).avoid
            avoided += [] if analysed is None else list(analysed.bands)
        progress.show("move", 0.5)
        options["limited"] = limited
        if postures:
            options["progress"] = lambda share: progress.show("move", share)
            rows = move_postures(drive, parts or None, bands=avoided, **options)
            write_all(output, {JSON: reported(drive.title, rows.facts(), True)})
            click.echo(reported(drive.title, rows.facts(), as_json, f"written: {output / JSON}"))
            return
        result = moved(drive, parts or None, bands=avoided, **options)
        progress.show("writing", 0.9)
        _write(drive, result, output)
    written = f"written: {', '.join(str(output / file) for file in (CSV, SVG, JSON))}"
    click.echo(reported(drive.title, result.facts(), as_json, written))


def profile_part(text: str, **table: str | None) -> Any:
    """One part of a profile: of a CSV file, or of fields such as "trapezoid, angle: 90 deg, time: 0.6 s"."""
    if text.lower().endswith(".csv"):
        return read_profile(text, **table)
    return _read(text, f"{{type: {text}}}", PART, "profile")


def _read(text: str, fields: str, kind: Kind, subject: str) -> Any:
    """Read fields in the form of a project file (click.BadParameter where the text is wrong)."""
    located, errors = read(f"{subject}: {fields}"), list[Wrong]()
    problems = [(problem.field, problem.sentence) for problem in located.problems]
    if not problems and located.content is not None:
        value = read_value(kind, located.content[subject], Place((), errors))
        if not errors:
            return value
        problems = [(name(wrong.keys), wrong.sentence) for wrong in errors if wrong.sentence]
    reasons = "; ".join(sentence if field == "file" else f"{field}: {sentence}" for field, sentence in problems)
    raise click.BadParameter(f"the {subject} {text!r} is wrong: {reasons}")


def _write(project: Project, result: Move, output: Path) -> None:
    columns = [
        ("time_s", result.time), ("reference_rad", result.reference), ("pointing_error_rad", result.pointing_error),
        ("motor_speed_rad_per_s", result.motor_speed), ("motor_torque_N_m", result.motor_torque),
        ("gear_torque_N_m", result.gear_torque),
    ]  # fmt: skip
    panels = named(move_panels(result, project.gear, project.motor_limits or MotorLimits()), project.title)
    drawn = stacked(panels, 215.0, "a move over the time")
    write_all(output, {CSV: columns, SVG: drawn, JSON: reported(project.title, result.facts(), True)})


DESIGNS, REJECTED, DESIGNS_SVG, DESIGN_JSON = "designs.csv", "rejected.csv", "designs.svg", "design.json"
MOST_FILES = 10  # project files of the front


@click.command()
@click.argument("specification", type=file_type)
@output_option(
    "Folder for designs.csv, rejected.csv, designs.svg, design.json and the best designs as project files.",
    required=True,
)
@json_option
def design(specification: Path, output: Path, as_json: bool) -> None:
    """Find gears and motors for the SPECIFICATION of an axis."""
    request = read_specification(specification)
    with Progress(request.title) as progress:
        result, stop = finished(lambda: designed(request, progress=progress.show))
        progress.show("writing", 0.98)
        written = _write_designs(result, output)
    files = f"written: {', '.join(str(output / file) for file in written)}"
    click.echo(reported(request.title, result.facts(), as_json, files))
    if stop is not None:
        raise stop


def _write_designs(result: Design, output: Path) -> list[str]:
    """Write tables, figure, JSON and the front as project files, and return their names."""
    feasible = data(result.facts())["feasible"]
    texts = {
        DESIGNS: as_csv(list(feasible[0]) if feasible else ["gear"], [row.values() for row in feasible]),
        REJECTED: as_csv(["gear", "reason"], result.rejected.items()),
        DESIGN_JSON: reported(result.specification.title, result.facts(), True),
    }
    if result.feasible:
        texts[DESIGNS_SVG] = stacked(result.panels(), 360.0, "feasible designs, oscillation over inertia")
    for i, c in enumerate(result.pareto[:MOST_FILES], 1):
        texts[f"{i:02d}-{slug(c.gear)}.yaml"] = design_text(result.specification, c)
    write_all(output, texts)
    return list(texts)


MOST_LOADS = 1000  # of a range


@click.command("speed-map")
@project_argument
@output_option("Folder for cells.csv, bands.csv, campbell.csv and speed-map.svg. Default: nothing is written.")
@click.option("--loads", help='Mean torques on the load, "LOW:HIGH:COUNT" or "V1,V2": "-60 N*m:0 N*m:9".')
@click.option("--load-inertias", "inertias", help='Inertias of the load in place of torques: "1 kg*m^2:3 kg*m^2:9".')
@click.option("--speeds", help='Range of the motor speed, "LOW:HIGH": "500 rpm:4000 rpm". Default: that of the file.')
@limit_option
@click.option("--amplification", type=float, help="Largest oscillation relative to that of quasi-static rotation.")
@click.option("--margin", type=float, help="Separation margin from every resonance, 0.1 for 10 %.")
@click.option("--units", type=click.IntRange(0, 5000), default=0, help="Drives drawn by the scatter of the file.")
@click.option("--seed", type=click.IntRange(0), default=0, help="Seed of these drives.")
@json_option
def speed_map(
    project: Path, output: Path | None, loads: str | None, inertias: str | None, speeds: str | None, limit: str | None,
    amplification: float | None, margin: float | None, units: int, seed: int, as_json: bool,
) -> None:  # fmt: skip
    """Say which motor speeds are allowed under every load."""
    drive = read_project(project)
    options = {
        "loads": _range("--loads", loads, "N*m"),
        "load_inertias": _range("--load-inertias", inertias, "kg*m**2", "positive"),
        "limit": None if limit is None else quantity("--limit", limit, "rad", "positive"),
    }
    example = 'for example "500 rpm:4000 rpm"'
    ends = None if speeds is None else span("--speeds", speeds.split(":"), "rad/s", example, "positive")
    with Progress(drive.title) as progress:
        drives = scattered(drive, units, seed) if units else ()
        options |= {"speeds": ends, "amplification": amplification, "margin": margin, "units": drives}
        progress.show("motions", 0.0)
        result, stop = finished(lambda: mapped(drive, **options, progress=progress.show))
        if output is not None:
            progress.show("writing", 1.0)
            write(result, output, drive.title)
    written = () if output is None else (f"written: {output}",)
    click.echo(reported(drive.title, result.facts(), as_json, *written))
    if stop is not None:
        raise stop


def write(result: SpeedMap, folder: Path, name: str = "") -> None:
    """Write cells, bands, lines and the figure; the files appear when they are complete."""
    load, speed = np.meshgrid(result.loads, result.speeds, indexing="ij")
    of_load = {"load torque": "load_N_m", "load inertia": "load_kg_m2"}.get(result.load_name, result.load_name)
    cells = [
        (of_load, load.ravel()), ("motor_speed_rpm", speed.ravel() / RPM),
        ("oscillation_rad", result.oscillation.ravel()), ("gear_torque_N_m", result.torque.ravel()),
        *([] if result.smallest is None else [("smallest_oscillation_rad", result.smallest.ravel())]),
        ("stable_motions", result.motions.ravel()), ("subharmonic", result.subharmonic.ravel()),
    ]  # fmt: skip
    if result.scatter is not None:
        cells += [
            (f"oscillation_{100.0 * share:.0f}_percent_of_units_rad", rows.ravel())
            for share, rows in zip(result.scatter.shares, result.scatter.oscillation, strict=True)
        ]
        cells += [
            ("oscillation_worst_unit_rad", result.scatter.worst.ravel()),
            ("share_of_units_forbidden", result.scatter.forbidden.ravel()),
        ]
    bands = np.array(
        [(result.loads[i], kind, low / RPM, high / RPM)
         for kind, kinds in enumerate((result.forbidden, result.allowed)) for i, load_bands in enumerate(kinds)
         for low, high in load_bands]
    ).reshape(-1, 4)  # fmt: skip
    lines = [
        (line.load, line.order, line.mode, a, w / RPM)
        for line in result.lines
        for a, w in zip(line.amplitude, line.speed, strict=True)
    ]
    table = np.array(lines).reshape(-1, 5)
    names = (of_load, "order", "resonance", "torsion_amplitude_rad", "motor_speed_rpm")
    panels = named(result.panels(), name)
    panels[-1].caption = [_sentence(text) for text in (result.rule, WHAT_X_IS, *result.remarks)]
    write_all(folder, {
        "cells.csv": cells,
        "bands.csv": list(zip((of_load, "allowed", "from_rpm", "to_rpm"), bands.T, strict=True)),
        "campbell.csv": list(zip(names, table.T, strict=True)),
        "speed-map.svg": stacked(panels, 260.0, "forbidden speeds, oscillation, Campbell diagram"),
    })  # fmt: skip


def _sentence(text: str) -> str:
    """A text as a sentence."""
    return text[0].upper() + text[1:].removesuffix(".") + "."


def _range(option: str, text: str | None, unit: str, sign: str = "any") -> Any:
    """Values of LOW:HIGH:COUNT or V1,V2,..., with their unit; None of none."""
    if text is None:
        return None
    if ":" not in text:
        return [quantity(option, part, unit, sign) for part in text.split(",")]
    low, _, after = text.partition(":")
    high, _, count = after.partition(":")
    if not count.strip().isdecimal() or not 1 <= int(count) <= MOST_LOADS:
        reason = f"{text!r} has no number of values, 1 to {MOST_LOADS}"
        raise click.BadParameter(f'{option}: {reason}; write for example "-60 N*m:0 N*m:9"')
    return np.linspace(quantity(option, low, unit, sign), quantity(option, high, unit, sign), int(count))
