"""`strainwave fit-loop`: a measured loop of torque over torsion as a torsion law with its intervals."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from ....files.logs.names import named
from ....files.logs.read import read_log
from ....files.yaml_text import FileError, Problem, complaint
from ....plot.svg import stacked
from ....study.identification.law_fit import LackOfFit
from ....study.identification.log import Log
from ....study.identification.loops.loop_fit import fit_loop as fitted
from ....study.identification.loops.loop_model import LoopFit
from ...console import number, print_table, to_json
from ...output import staged, write_csv
from ...view import quantity, sign
from ..options import dialect_options, file_type, json_option, output_option


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
    rated = None if rated_torque is None else quantity("--rated-torque", rated_torque, "N*m")
    log = read_loop_file(file, {"torsion": torsion, "torque": torque}, delimiter, decimal)
    try:
        found = fitted(log.channels["torsion"], log.channels["torque"], rated_torque=rated, ratio=ratio)
    except ValueError as error:
        raise FileError(complaint(file, [Problem(1, 1, "loop", str(error))])) from None
    found = replace(found, remarks=(*log.notes, *found.remarks))
    if output is not None:
        write(file, found, output)
    click.echo(to_json({"file": file.name} | data(found))) if as_json else _print(file, found, output)


def read_loop_file(file: Path, wanted: dict[str, str], delimiter: str | None, decimal: str | None) -> Log:
    """Log of the channels torsion and torque in the order of the samples; errors as `read_log`."""
    found = {channel: named(text) for channel, text in wanted.items()}
    columns = {channel: name for channel, (name, _) in found.items()}
    units = {channel: unit for channel, (_, unit) in found.items() if unit}
    given: dict[str, Any] = {"trim": 0.0, "unwrap": False, "delimiter": delimiter, "decimal": decimal}
    try:
        return read_log(file, columns, units, rate=1.0, **given)
    except FileError:
        raise
    except ValueError:  # the file has a time of its own
        return read_log(file, columns, units, **given)


def data(found: LoopFit) -> dict[str, Any]:
    """The numbers with their intervals, in SI."""
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
        "lack_of_fit": _lack(found.lack_of_fit),
        "remarks": found.remarks,
        "project": found.yaml,
    }


def _lack(lack: LackOfFit | None) -> dict[str, Any] | None:
    if lack is None:
        return None
    numbers = {"noise_N_m": lack.pure, "missed_N_m": lack.missed, "ratio": lack.ratio, "probability": lack.probability}
    return {"found": lack.found} | numbers


def write(file: Path, found: LoopFit, folder: Path) -> None:
    """Write figure, samples, numbers and the block of a project file; they appear when they are complete."""
    with staged(folder) as part:
        (part / "loop.svg").write_text(
            stacked(found.panels(), 300.0, "a measured loop and its law", 560.0), encoding="utf-8"
        )
        (part / "gear.yaml").write_text(found.yaml, encoding="utf-8")
        (part / "loop.json").write_text(to_json({"file": file.name} | data(found)) + "\n", encoding="utf-8")
        columns = [("torsion_rad", found.torsion), ("torque_N_m", found.torque), ("fitted_N_m", found.fitted)]
        write_csv(part / "loop.csv", columns)


def _print(file: Path, found: LoopFit, output: Path | None) -> None:
    rows = [
        (name, value, number(low, 5), number(high, 5), sign(unit)) for name, value, low, high, unit in found.table()
    ]
    if found.misses:
        click.echo(f"{found.misses[:1].upper()}{found.misses[1:]}.")
    print_table(
        f"{file.name}: {len(found.torque)} samples, {found.cycles:.3g} cycles",
        ("number", "value", "from", "to", "unit"), rows, "interval of 95 %",
    )  # fmt: skip
    candidates = [
        (row.name, row.unknowns, number(row.error, 4), "taken" if row.chosen else "") for row in found.comparison
    ]
    print_table("candidates, by their error in blocks of samples left out", ("law", "unknowns", "N·m", ""), candidates)
    for sentence in found.sentences():
        click.echo(f"{sentence[:1].upper()}{sentence[1:]}.")
    click.echo(f"The cycles dissipate {number(found.energy)} J; the residual is {number(found.residual_rms)} N·m rms.")
    click.echo(f"for a project file:\n{found.yaml}".rstrip())
    if output is not None:
        click.echo(f"written: {output}/loop.svg, loop.csv, loop.json, gear.yaml")
