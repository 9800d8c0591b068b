"""`strainwave read-log`, `identify-drive`, `fit-bode` and `fit-loop`: channels of a log, and what fits it."""

from dataclasses import replace
from pathlib import Path
from shlex import quote
from typing import Any, get_args

import click
import numpy as np

from ....base.results import Floats, SolveError
from ....compile.tree import part
from ....drive.project import Project
from ....files.logs.frd import read_frd
from ....files.logs.names import named as name_and_unit
from ....files.logs.read import read_log as log_of
from ....files.project_text import project_text
from ....files.reading import read_project
from ....files.variants.identify_drive import IdentifiedDrive, with_torsion
from ....files.variants.identify_drive import identify_drive as identified
from ....files.yaml_text import FileError, Problem, complaint
from ....plot.fits import log_panels, torsion_panels
from ....plot.panels import named
from ....plot.svg import WIDTH, figure, stacked
from ....study.identification.identified import channels_of
from ....study.identification.log import Log, LogSegment
from ....study.identification.loops.loop_fit import fit_loop as loop_fitted
from ....study.identification.loops.loop_model import LoopFit
from ....study.identification.response_curve.bode_fit import BodeFit
from ....study.identification.response_curve.bode_fit import fit_bode as bode_fitted
from ....study.identification.response_curve.measured_bode import Estimator, Quantity
from ...console import Progress, in_options, number, print_table, reported, staged, to_json, write_all
from ...view import quantity as value_of
from ...view import sign
from ..options import (
    dialect_options,
    file_type,
    json_option,
    output_option,
    pairs_option,
    project_argument,
    reading_options,
)


@click.command()
@project_argument
@click.argument("file", type=file_type)
@click.option("--free", help='Numbers to fit, as J_m,K; "" compares alone. Default: J_m, J_l, K, B, delay.')
@click.option("--quantity", type=click.Choice(get_args(Quantity)), help="What was measured. Default: by the names.")
@click.option("--estimator", type=click.Choice(get_args(Estimator)), default="unknown", help="How it was estimated.")
@click.option("--speed", default="0 rpm", help="Speed of the motor at which it was measured.")
@click.option("--amplitude", type=float, help="Amplitude of the excitation, for --second.")
@click.option("--second", type=file_type, help="File measured with another amplitude.")
@click.option("--second-amplitude", type=float, help="Its amplitude.")
@pairs_option(
    "--column", "columns", "CHANNEL=COLUMN",
    "Column of frequency, size, phase, real, imaginary, or of records; repeatable.",
)  # fmt: skip
@pairs_option("--unit", "units", "CHANNEL=UNIT", "Unit, as frequency=Hz, size=dB or phase=deg; repeatable.")
@dialect_options
@output_option("Folder for bode.svg, bode.csv and bode.json.")
@json_option
def fit_bode(
    project: Path, file: Path, free: str | None, speed: str, amplitude: float | None, second: Path | None,
    second_amplitude: float | None, output: Path | None, as_json: bool, **reading: Any,
) -> None:  # fmt: skip
    """Fit numbers of a drive to a measured Bode plot.

    FILE has frequencies with size and phase, or real and imaginary part; or time, reference, torque and speed.
    """
    drive = read_project(project)
    measured = [read_frd(file, amplitude=amplitude, **reading)]
    if second is not None:
        measured.append(read_frd(second, amplitude=second_amplitude, **reading))
    names = None if free is None else tuple(name.strip() for name in free.split(",") if name.strip())
    fit = bode_fitted(measured, drive, free=names, speed=value_of("--speed", speed, "rad/s"))
    if output is not None:
        _write(drive.title, fit, output)
    written = [f"for a project file, into its groups:\n{fit.yaml}".rstrip()] if fit.yaml else []
    written += [] if output is None else [f"written: {output}/bode.svg, bode.csv, bode.json"]
    click.echo(reported(drive.title, fit.facts(), as_json, *written))


def _write(title: str, fit: BodeFit, folder: Path) -> None:
    responses = {"measured": fit.measured.value, "drive": fit.model, "fitted": fit.computed}
    columns = [("omega_rad_per_s", fit.measured.omega)]
    for name, values in responses.items():
        columns += [(f"{name}_real", np.real(values)), (f"{name}_imaginary", np.imag(values))]
    figure = stacked(named(fit.panels(), title), 260.0, "a measured Bode plot and that of the drive")
    write_all(folder, {"bode.csv": columns, "bode.svg": figure, "bode.json": reported(title, fit.facts(), True)})


@click.command()
@click.argument("file", type=file_type)
@click.option("--rated-torque", help='For lost motion and hysteresis loss, as "67 N*m". Default: the largest measured.')
@click.option("--ratio", type=float, help="Ratio of the gear, for the block of a project file.")
@click.option("--torsion", default="torsion", help='Column of the torsion, as "Winkel [arcmin]".')
@click.option("--torque", default="torque", help='Column of the torque, as "Moment [N*m]".')
@dialect_options
@output_option("Folder for loop.svg, loop.csv, loop.json and gear.yaml, the block of a project file.")
@json_option
def fit_loop(
    file: Path, rated_torque: str | None, ratio: float | None, torsion: str, torque: str, delimiter: str | None,
    decimal: str | None, output: Path | None, as_json: bool,
) -> None:  # fmt: skip
    """Fit the law of a gear to a measured loop of torque.

    FILE is what `strainwave read-log` reads: CSV in any dialect, .npz, .mat, .parquet or .mf4; it needs no time.
    """
    rated = None if rated_torque is None else value_of("--rated-torque", rated_torque, "N*m")
    log = read_loop_file(file, {"torsion": torsion, "torque": torque}, delimiter, decimal)
    try:
        found = loop_fitted(log.channels["torsion"], log.channels["torque"], rated_torque=rated, ratio=ratio)
    except ValueError as error:
        raise FileError(complaint(file, [Problem(1, 1, "loop", str(error))])) from None
    found = replace(found, remarks=(*log.notes, *found.remarks))
    numbers = to_json({"file": file.name} | data(found))
    if output is not None:
        columns = [("torsion_rad", found.torsion), ("torque_N_m", found.torque), ("fitted_N_m", found.fitted)]
        figure = stacked(found.panels(), 300.0, "a measured loop and its law", 560.0)
        contents = {"loop.svg": figure, "gear.yaml": found.yaml, "loop.json": numbers, "loop.csv": columns}
        write_all(output, contents)
    click.echo(numbers) if as_json else _print(file, found, output)


def read_loop_file(file: Path, wanted: dict[str, str], delimiter: str | None, decimal: str | None) -> Log:
    """Log of the channels torsion and torque in the order of the samples; errors as `read_log`."""
    found = {channel: name_and_unit(text) for channel, text in wanted.items()}
    columns = {channel: name for channel, (name, _) in found.items()}
    units = {channel: unit for channel, (_, unit) in found.items() if unit}
    given: dict[str, Any] = {"trim": 0.0, "unwrap": False, "delimiter": delimiter, "decimal": decimal}
    try:
        return log_of(file, columns, units, rate=1.0, **given)
    except FileError:
        raise
    except ValueError:  # the file has a time of its own
        return log_of(file, columns, units, **given)


def data(found: LoopFit) -> dict[str, Any]:
    """The numbers with their intervals, in SI."""
    lack = found.lack_of_fit
    numbers = {
        name: {"value": value, "low": found.interval(name).low, "high": found.interval(name).high}
        for name, value in found.values.items()
    }
    return {
        "numbers": numbers,
        "unidentified": found.unidentified,
        "comparison": [row._asdict() for row in found.comparison],
        "reason": found.reason,
        "rated_torque_N_m": found.rated_torque,
        "cycles": found.cycles,
        "energy_J": found.energy,
        "residual_rms_N_m": found.residual_rms,
        "samples": len(found.torque),
        "lack_of_fit": lack and {
            "found": lack.found, "noise_N_m": lack.pure, "missed_N_m": lack.missed, "ratio": lack.ratio,
            "probability": lack.probability,
        },
        "remarks": found.remarks,
        "project": found.yaml,
    }  # fmt: skip


def _print(file: Path, found: LoopFit, output: Path | None) -> None:
    rows = [(name, size, number(low, 5), number(high, 5), sign(unit)) for name, size, low, high, unit in found.table()]
    if found.misses:
        click.echo(f"{found.misses[:1].upper()}{found.misses[1:]}.")
    print_table(
        f"{file.name}: {len(found.torque)} samples, {found.cycles:.3g} cycles",
        ("number", "value", "from", "to", "unit"), rows, "interval of 95 %",
    )  # fmt: skip
    candidates = [(r.name, r.unknowns, number(r.error, 4), "taken" * bool(r.chosen)) for r in found.comparison]
    print_table("candidates, by their error in blocks of samples left out", ("law", "unknowns", "N·m", ""), candidates)
    for sentence in found.sentences():
        click.echo(f"{sentence[:1].upper()}{sentence[1:]}.")
    click.echo(f"The cycles dissipate {number(found.energy)} J; the residual is {number(found.residual_rms)} N·m rms.")
    click.echo(f"for a project file:\n{found.yaml}".rstrip())
    if output is not None:
        click.echo(f"written: {output}/loop.svg, loop.csv, loop.json, gear.yaml")


DRIVE_YAML, DRIVE_JSON, DRIVE_SVG = "identified.yaml", "identified.json", "identified.svg"
UNLIKE = "the model does not explain the motion; check that log and project are of one drive, or improve the project"


@click.command()
@project_argument
@click.argument("files", nargs=-1, required=True, type=file_type)
@output_option(
    "Folder for identified.yaml, the project file with what was found, identified.json and identified.svg.",
    required=True,
)
@click.option(
    "--free",
    help='Numbers to find, by their names in the file: "gear.K1, damping.B, torsion.offset". Default: usual ones.',
)
@click.option(
    "--between", type=click.Choice(["band-limited", "linear", "held"]), default="band-limited",
    help="What the motor's angle does between samples.",
)  # fmt: skip
@reading_options
@json_option
def identify_drive(
    project: Path, files: tuple[Path, ...], free: str | None, between: Any, output: Path, as_json: bool, **reading: Any
) -> None:
    """Find numbers of a drive in logs of its two angles.

    PROJECT is a project file with the first guess; FILES are logs as `strainwave read-log` reads them, with a time,
    motor_angle and load_angle. The project file that is written has the numbers found, and their uncertainty as its
    scatter.
    """
    guess = read_project(project)
    logs = [log_of(file, **reading) for file in files]
    names = None if free is None else tuple(name.strip() for name in free.split(",") if name.strip())
    with Progress(guess.title) as progress:
        result = identified(guess, logs, names, between=between, progress=progress.show)
    torsions = [with_torsion(channels_of(log), guess.drive.N)["torsion"] for log in logs]
    numbers = to_json(data_of_drive(result))
    rows = torsion_panels(result.found, torsions)
    panels = [named(rows[0], guess.title), *rows[1:]]
    contents = {DRIVE_SVG: figure(panels, 230.0, "measured and computed torsion")}
    if result.usable:
        contents |= {DRIVE_YAML: project_text(result.project), DRIVE_JSON: numbers}
    write_all(output, contents)
    if not result.usable:
        for old in (DRIVE_YAML, DRIVE_JSON):  # of an earlier log: they would pass for this one's
            (output / old).unlink(missing_ok=True)
    if as_json:
        click.echo(numbers)
    else:
        _print_drive(guess, result)
    if not result.usable:
        raise SolveError(f"no project file is written, only {output / DRIVE_SVG}: {UNLIKE}")
    if not as_json:
        written = f"{output / DRIVE_YAML}, {DRIVE_JSON}, {DRIVE_SVG}"
        click.echo(f"written: {written}; next: strainwave analyze {quote(str(output / DRIVE_YAML))} -o report")


def data_of_drive(result: IdentifiedDrive) -> dict[str, Any]:
    """The numbers with their intervals, in SI."""
    discrepancy, deviations = result.found.discrepancy, np.sqrt(np.diag(result.found.covariance))
    return {
        "headline": result.headline(),
        "usable": result.usable,
        "unexplained": result.unexplained,
        "numbers": {
            name: {"value": result.value(name), "low": result.interval(name).low, "high": result.interval(name).high}
            for name in result.names
        },
        "correlation": result.found.covariance / np.outer(deviations, deviations),
        "residual_rms_rad": float(result.found.rms[0]),
        "torsion_rms_rad": float(result.found.size[0]),
        "samples": result.found.residual.shape[1],
        "between": result.found.between,
        "residual_white": discrepancy.white,
        "terms_lacking": list(discrepancy.flagged),
        "remarks": list(result.remarks),
    }


def _print_drive(guess: Project, result: IdentifiedDrive) -> None:
    rows = []
    for name, path in zip(result.names, result.found.names, strict=True):
        first = "" if path.startswith(("x.", "reference.", "load.excitation.")) else number(part(guess.whole, path), 5)
        sizes = (number(size, 6) for size in (result.value(name), *result.interval(name)))
        rows.append((name, first, *sizes, sign(result.unit(name))))
    click.echo(result.headline())
    columns = ("number", "given", "found", "from", "to", "unit")
    print_table(f"{guess.title}: {len(rows)} numbers", columns, rows, "interval of 95 %, if the model is right")
    for line in result.quality()[1:]:
        click.echo(line)


LOG_CSV, LOG_SVG = "log.csv", "log.svg"
SIZES = ("least", "largest", "mean", "rms")  # of a channel


@click.command()
@click.argument("file", type=file_type)
@output_option("Folder for log.csv and log.svg.")
@click.option("--columns", "names", help='All columns in their order, as "time,load_angle,-,torque"; - leaves one out.')
@reading_options
@json_option
def read_log(
    file: Path, output: Path | None, names: str | None, columns: dict[str, str], as_json: bool, **reading: Any
) -> None:
    """Read a log and say what is in it, and what is doubtful.

    FILE is CSV in any dialect, .npz, .mat, .parquet or .mf4. Angles and speeds of the load count on the output shaft.
    """
    if names is not None and columns:
        raise click.UsageError("--columns names all columns and --column some of them; give one of the two")
    listed = None if names is None else [None if n.strip() == "-" else n.strip() for n in names.split(",")]
    placed = {channel: int(column) if column.isdecimal() else column for channel, column in columns.items()}
    read = log_of(file, listed or placed or None, **reading)
    parts = read.segments() if read.moving else ()
    if output is not None:
        with staged(output) as folder:
            read.save(folder / LOG_CSV)
            (folder / LOG_SVG).write_text(
                stacked(log_panels(read, parts), 165.0, "a log over the time", WIDTH) + "\n", encoding="utf-8"
            )
    if as_json:
        click.echo(to_json(_log_data(file, read, parts)))
        return
    _print_log(file, read, parts)
    if output is not None:
        click.echo(f"written: {output / LOG_CSV}, {output / LOG_SVG}")


def _sizes(values: Floats) -> list[float]:
    """Least and largest value, mean and root mean square."""
    return [float(size) for size in (np.min(values), np.max(values), np.mean(values), np.sqrt(np.mean(values**2)))]


def _log_data(file: Path, log: Log, parts: tuple[LogSegment, ...]) -> dict[str, Any]:
    return {
        "file": file.name,
        "samples": len(log),
        "start_s": log.time[0],
        "stop_s": log.time[-1],
        "rate_hz": log.rate,
        "jitter_s": log.jitter,
        "ratio": log.ratio,
        "channels": {
            name: {"unit": log.units[name], **dict(zip(SIZES, _sizes(values), strict=True))}
            for name, values in log.channels.items()
        },
        "gaps": [gap._asdict() for gap in log.gaps],
        "segments": [
            {
                "kind": part.kind, "start_s": part.start, "stop_s": part.stop, "speed_rad_per_s": part.speed,
                "acceleration_rad_per_s2": part.acceleration,
            }
            for part in parts
        ],
        "notes": list(map(in_options, log.notes)),
        "doubts": list(map(in_options, log.doubts)),
    }  # fmt: skip


def _print_log(file: Path, log: Log, parts: tuple[LogSegment, ...]) -> None:
    rows = [(name, sign(log.units[name]) or "–", *_sizes(values)) for name, values in log.channels.items()]
    title = f"{file.name}: {len(log)} samples, {log.time[0]:.6g} to {log.time[-1]:.6g} s, {number(log.rate, 6)} Hz"
    print_table(title, ("channel", "unit", *SIZES), rows)
    if parts:
        body = [(part.kind, part.start, part.stop, part.speed, part.acceleration) for part in parts]
        shaft = "load" if {"load_angle", "load_speed"} & set(log.channels) else "motor"
        columns = ("segment", "from (s)", "to (s)", f"{shaft} speed (rad/s)", "acceleration (rad/s²)")
        print_table("", columns, body)
    if log.ratio is not None:
        click.echo(f"the motor turns {number(log.ratio, 6)} times as far as the load")
    gaps = [f"{gap.start:.6g} to {gap.stop:.6g} s" for gap in log.gaps[:5]]
    gaps += [f"{len(log.gaps) - 5} more"] if len(log.gaps) > 5 else []
    for kind, texts in {"gap": gaps, "note": log.notes, "doubt": log.doubts}.items():
        for text in texts:
            click.echo(f"{kind}: {in_options(text)}")
