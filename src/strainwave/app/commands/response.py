"""`strainwave response`: the computed response of a project's whole drive as numbers, CSV or figure."""

import math
from pathlib import Path
from typing import Any

import click
import numpy as np

from ...base.units import ARCSEC
from ...compile.jit import light_as_python
from ...drive.drive_response import DriveResponse
from ...drive.loop_margin import motor_name
from ...drive.project import Project
from ...files.notes import load_remark
from ...files.reading import read_project
from ...plot import axes
from ...plot.drive import HEIGHT, drive_panels
from ...plot.svg import WIDTH, stacked
from ..console import WHAT_X_IS, Progress, number, to_json
from ..output import staged, write_csv
from ..report.curve_files import drive_columns
from ..report.sections.opening import CONVENTIONS
from ..report.sections.speed_range import curve_data
from ..view import angle_unit
from .equation import remarks
from .options import json_option, output_option, project_argument, written_type

FIGURES = (".svg", ".png")
JUMPS = {"jumps up": "jump_up_speed", "drops": "jump_down_speed"}


def _known_suffix(_context: click.Context, _option: click.Parameter, output: Path | None) -> Path | None:
    """Refuse a file name whose ending says nothing."""
    if output is not None and output.suffix not in (".csv", *FIGURES):
        raise click.BadParameter(f"{output.name!r} must end in .csv, .svg or .png")
    return output


@click.command()
@project_argument
@output_option(
    "File for the curve: .csv, or .svg or .png for a figure of error and torque.",
    type=written_type,
    callback=_known_suffix,
)
@json_option
def response(project: Path, output: Path | None, as_json: bool) -> None:
    """Follow the pointing error of the whole drive through the project's speeds: stability, folds, jumps."""
    drive = read_project(project)
    if output is not None and output.suffix == ".png":
        axes.check()
    with Progress(drive.title) as progress:
        progress.show("response curve", 0.0)
        with light_as_python():
            found = drive.response()
        if output is not None:
            progress.show("writing", 0.8)
            _write(drive, found, output)
    data = {"title": drive.title, "shaft": drive.speeds.shaft, "motor": _motor(drive)} | _in_shaft(drive, found)
    data |= _asked(drive, found)
    data |= curve_data(drive.speeds, found.response) | {"conventions": CONVENTIONS, "remarks": _remarks(drive)}
    click.echo(to_json(data) if as_json else _summary(drive, data, output))


def _write(project: Project, found: DriveResponse, output: Path) -> None:
    """Write the curve as CSV, or as a figure; the file appears when it is complete."""
    with staged(output.parent) as folder:
        part = folder / output.name
        if output.suffix in FIGURES:
            y = angle_unit(float(np.max(found.peak))).axis(f"oscillation of the {found.name}")
            panels = drive_panels(found, project, y)
            panels[-1].caption = [f"{WHAT_X_IS}.", *_remarks(project)]
            if output.suffix == ".svg":
                text = stacked(panels, HEIGHT, "error and torque against speed", WIDTH)
                part.write_text(text + "\n", encoding="utf-8")
            else:
                axes.write(panels, part)
        else:
            write_csv(part, drive_columns(project.speeds, found))


def _asked(project: Project, found: DriveResponse) -> dict[str, Any]:
    """Whether the drive passes, the torques of gear and motor, and their limits."""
    judged = project.judged(found)
    motor = judged.motor
    return {
        "passes": judged.passes,
        "load_has_a_range": project.load_torques[0] < project.load_torques[1],
        "limit_arcsec": None if project.limit is None else project.limit / ARCSEC,
        "gear_torque_N_m": judged.used.peak_torque,
        "required_motor": None
        if motor is None
        else {
            "speed": project.speeds.own(motor.at), "torque_N_m": motor.torque, "holding_torque_N_m": motor.holding,
        },
        "limits": [one.data() for one in judged.findings],
        "failures": judged.failures,
        "beyond_limits": judged.remarks,
    }  # fmt: skip


def _remarks(project: Project) -> list[str]:
    """What a reader must know about the curve: `remarks`, and its range where the file gives none."""
    said, speeds = [*remarks(project), *load_remark(project)], project.speeds
    if speeds.single:
        low, high = (number(speeds.own(omega), 5) for omega in speeds.limits)
        said.append(
            f"The file gives single speeds: the curve goes from {low} to {high} {speeds.own_unit}, a fifth beyond them."
        )
    return said


def _motor(project: Project) -> str:
    """What drives the motor, in words."""
    return project.motor if project.train is None else motor_name(project.train.motor.control, project.loop_inertia)


def _in_shaft(project: Project, found: DriveResponse) -> dict[str, Any]:
    """Fold and jump speeds on the project's own shaft."""
    curve, sweep = found.curve, found.response.sweep
    top = found.response.largest()
    most = found.visited()[int(np.argmax(found.oscillation[found.visited()]))]

    def own(omega: float | None) -> float | None:
        return None if omega is None else project.speeds.own(omega)

    return {
        "unit": project.speeds.own_unit,
        "fold_speeds": [own(fold.omega) for fold in curve.folds],
        "jump_up_speed": own(sweep.jump_up) if sweep else None,
        "jump_down_speed": own(sweep.jump_down) if sweep else None,
        "hysteresis_bands": [
            {
                "from_speed": own(band.low),
                "to_speed": own(band.high),
                "jump_up_speed": own(band.jump_up),
                "jump_down_speed": own(band.jump_down),
                "whole": band.whole,
            }
            for band in (sweep.bands if sweep else ())
        ],
        "error": found.name,
        "oscillation": {
            "speed": own(float(curve.omega[most])),
            "oscillation_arcsec": float(found.oscillation[most]) / ARCSEC,
        },
        "largest": None
        if top is None
        else {"speed": own(float(curve.omega[top])), "peak_arcsec": float(curve.peak[top]) / ARCSEC},
    }


def _against(data: dict[str, Any]) -> str:
    """The largest oscillation against its limit; nothing without one."""
    limit = data["limit_arcsec"]
    if limit is None:
        return ""
    where = "above" if data["oscillation"]["oscillation_arcsec"] > limit else "within"
    alone = " under this load alone" if data["load_has_a_range"] else ""
    return f", {where} the limit of {angle_unit(limit * ARCSEC).text(limit * ARCSEC)}{alone}"


def _torques(data: dict[str, Any]) -> str:
    """What gear and motor take: under a range of loads at least, for their vibration under the others is not known."""
    gear, motor, ranged = number(data["gear_torque_N_m"]), data["required_motor"], data["load_has_a_range"]
    said = f"in the gear at {'least' if ranged else 'most'} {gear} N·m"
    if motor:
        said += f", of the motor {number(motor['torque_N_m'])} N·m"
        said += "" if ranged else f", {number(motor['holding_torque_N_m'])} N·m of it at steady speed"
    return f"{said}: all loads without vibration, and this one with it; analyze follows each" if ranged else said


def _summary(project: Project, data: dict[str, Any], output: Path | None) -> str:
    unit = data["unit"]
    lines = [f"{project.title}: response, motor: {data['motor']}, {data['message']}"]
    lines += [f"  FAIL: {sentence}" for sentence in data["failures"]]
    if data["largest"]:
        peak, at = data["largest"]["peak_arcsec"] * ARCSEC, data["largest"]["speed"]
        size, fast = data["oscillation"]["oscillation_arcsec"] * ARCSEC, data["oscillation"]["speed"]
        text = angle_unit(peak).text(size)
        lines.append(f"  {data['error']}, largest oscillation: {text} at {number(fast, 5)} {unit}{_against(data)}")
        lines.append(f"  with its mean: at most {angle_unit(peak).text(peak)} at {number(at, 5)} {unit}")
    else:
        lines.append(f"  {data['sweep']}")
    lines.append(f"  torque {_torques(data)}")
    folds = ", ".join(number(speed, 5) for speed in data["fold_speeds"])
    lines.append(f"  folds, where the curve turns: {f'{folds} {unit}' if folds else 'none'}")
    for band in data["hysteresis_bands"]:
        ends = f"{number(band['from_speed'], 5)} to {number(band['to_speed'], 5)} {unit}"
        ways = [f"{way} at {number(band[key], 5)}" for way, key in JUMPS.items() if math.isfinite(band[key])]
        beyond = "" if band["whole"] else "; a jump lies outside the range"
        lines.append(f"  hysteresis: {ends}{', the error ' if ways else ''}{' and '.join(ways)}{beyond}")
    if not data["hysteresis_bands"]:
        lines.append("  no bistable range: a run-up and a run-down meet the same motions")
    share = number(data["left_out_relative"], 2)
    lines.append(f"  {data['harmonics']} harmonics; share of those left out {share} (truncation, not accuracy)")
    lines += [f"  {WHAT_X_IS}"]
    lines += [f"  note: {remark}" for remark in (*data["beyond_limits"], *data["remarks"])]
    return "\n".join(lines if output is None else [*lines, f"  written: {output}"])
