"""`strainwave error-scan`: a measured kinematic error as lines with their uncertainty."""

from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click

from ....base.units import ARCSEC
from ....files.scan_file import ScanFile, read_scan
from ....files.yaml_text import FileError, Problem, complaint
from ....model.orders import order_map
from ....study.identification.orders.error_result import ErrorScan
from ....study.identification.orders.error_scan import error_scan as scanned
from ...console import to_json
from ..options import dialect_options, file_type, json_option

SHAFTS = click.Choice(("motor", "output"))
SHOWN_IN_PROJECT = 64


def _orders(_ctx: click.Context, _option: click.Parameter, text: str | None) -> list[int] | None:
    """Read orders such as 1,2,4."""
    if text is None:
        return None
    parts = [part.strip() for part in text.split(",")]
    if not all(part.isascii() and part.isdigit() for part in parts):
        raise click.BadParameter(f"{text!r} is no list of orders; write for example 1,2,4")
    return [int(part) for part in parts]


@click.command("error-scan")
@click.argument("file", type=file_type)
@click.option("--back", type=file_type, help="CSV of the run in the backward direction.")
@click.option("--shaft", type=SHAFTS, default="motor", help="Shaft of the file's angle.")
@click.option("--turn", type=SHAFTS, help="Shaft whose turn the orders count on; the same by default.")
@click.option("--ratio", type=int, help="Ratio of the gear, where --shaft and --turn differ.")
@click.option("--orders", callback=_orders, help="Fit these orders, as 1,2,4, in place of a search.")
@click.option("--highest", type=int, help="Highest order sought.")
@click.option("--false-alarm", type=float, default=0.01, help="Probability that noise gives a line.")
@click.option("--angle", default="angle", help='Column of the angle, as "Winkel [deg]".')
@click.option("--error", help='Column of the error, as "Fehler [arcsec]"; "error" or "ate" by default.')
@click.option("--backward", help='Column of the error on the way back; "backward" by default.')
@click.option("--ate", is_flag=True, help="The error is the vendors', output minus motor/ratio.")
@dialect_options
@json_option
def error_scan(
    file: Path, back: Path | None, shaft: Any, turn: Any, ratio: int | None, orders: list[int] | None,
    highest: int | None, false_alarm: float, as_json: bool, **columns: Any,
) -> None:  # fmt: skip
    """Find the lines of a measured kinematic error."""
    factor = _factor(shaft, turn or shaft, ratio)
    forward = read_scan(file, **columns)
    backward = None
    if back is not None:
        if forward.backward is not None:
            raise ValueError(f"{file} has a column for the way back already; leave out {back} or the column")
        run = read_scan(back, **columns, reverse=True)
        backward = (factor * run.angle, run.error)
    elif forward.backward is not None:
        backward = (factor * forward.angle, forward.backward)
    search = {"orders": orders, "highest": highest, "false_alarm": false_alarm}
    scan = _scan(file, forward, factor, backward, search)
    if as_json:
        told = {"file": file.name, "turn": turn or shaft, "unit": "rad"} | asdict(scan)
        click.echo(to_json(told | {"peak_to_peak": scan.peak_to_peak}))
        return
    click.echo(f"{file.name}: {len(scan.lines)} lines, orders per turn of the {turn or shaft}\n{scan}")
    if scan.lines:
        click.echo(f"for a project file:\n{project_lines(scan.lines)}")


def _factor(shaft: str, turn: str, ratio: int | None) -> float:
    """Turns of the base angle per turn of the file's shaft."""
    if shaft == turn:
        return 1.0
    if ratio is None:
        raise ValueError(f"the angle is the {shaft}'s and the orders count on the {turn}'s turn; give --ratio")
    N = order_map(ratio).N
    return float(N) if shaft == "output" else 1.0 / N


def _scan(
    file: Path, run: ScanFile, factor: float, backward: tuple[Any, Any] | None, search: dict[str, Any]
) -> ErrorScan:
    try:
        return scanned(factor * run.angle, run.error, backward=backward, **search)
    except ValueError as error:
        raise FileError(complaint(file, [Problem(run.last, 1, "angle", str(error))])) from None


def project_lines(lines: Iterable[Any]) -> str:
    """The strongest lines of an angle [rad], by their orders, as the field `kinematic_error` of a project file."""
    rows = ["  kinematic_error:"]
    strongest = sorted(lines, key=lambda line: -line.amplitude)[:SHOWN_IN_PROJECT]
    for line in sorted(strongest, key=lambda line: line.order):
        size = f"amplitude: {line.amplitude / ARCSEC:.6g} arcsec, phase: {line.phase:.5g} rad"
        rows.append(f"    - {{order: {round(line.order)}, {size}}}")
    return "\n".join(rows)
