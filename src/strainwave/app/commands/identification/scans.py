"""`strainwave order-scan`: orders of logged quantities, and lines of a measured kinematic error."""

from collections.abc import Iterable, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import click
import numpy as np

from ....base.number_text import counted
from ....base.units import ARCSEC
from ....files.logs.read import read_log as log_of
from ....files.logs.scan_file import is_scan, read_scan
from ....files.yaml_text import FileError, Problem, complaint
from ....model.orders import Turn, order_map
from ....plot.fits import order_scan_panels
from ....plot.svg import WIDTH, stacked
from ....study.identification.channels import channels_of, with_torsion
from ....study.identification.log import Log
from ....study.identification.orders.error_scan import error_scan as error_scanned
from ....study.identification.orders.order_result import OrderLine, OrderScan
from ....study.identification.orders.order_scan import order_scan as orders_scanned
from ....study.identification.run import FEWEST_SAMPLES, Run
from ...console import echo, to_json, write_all
from ..options import file_type, json_option, output_option, reading_options

SHAFTS: dict[str, Turn] = {"load_angle": "output", "motor_angle": "motor"}
SHAFT = click.Choice(("motor", "output"))
LIKELY = ("torsion", "error", "torque", "motor_torque", "torque_from_current", "current", "load_torque")
SHOWN_IN_PROJECT = 64
NINETY_FIVE = 1.96  # deviations: half of an interval of 95 %
COLUMNS = ("angle", "error", "backward", "ate")  # of a scan file
OF_SCAN = ("error", "backward", "ate", "back", "shaft", "turn")  # options
CSV, JSON, SVG = "orders.csv", "orders.json", "orders.svg"


def _print_scan(
    files: tuple[Path, ...], of_scan: dict[str, Any], of_logs: dict[str, Any], dialect: dict[str, Any],
    search: dict[str, Any], ratio: float | None, as_json: bool,
) -> None:  # fmt: skip
    """Find and print the lines of a scan file."""
    given = [name for name, value in of_logs.items() if value not in (None, {})]
    if len(files) > 1 or given:
        what = f"--{given[0]} is for logs" if given else f"{len(files)} files are given"
        raise ValueError(f"{what}; a scan (angle and error without time) is one file; its backward run is --back")
    (file,), back = files, of_scan["back"]
    shaft: Turn = of_scan["shaft"] or "motor"
    turn: Turn = of_scan["turn"] or shaft
    columns = dialect | {name: of_scan[name] for name in COLUMNS}
    factor = _factor(shaft, turn, ratio)
    forward = read_scan(file, **columns)
    backward = None
    if back is not None:
        if forward.backward is not None:
            raise ValueError(f"{file} already has a column for the backward run; remove {back} or the column")
        run = read_scan(back, **columns, reverse=True)
        backward = (factor * run.angle, run.error)
    elif forward.backward is not None:
        backward = (factor * forward.angle, forward.backward)
    try:
        scan = error_scanned(factor * forward.angle, forward.error, backward=backward, ratio=ratio, turn=turn, **search)
    except ValueError as error:
        raise FileError(complaint(file, [Problem(forward.last, 1, "angle", str(error))])) from None
    if as_json:
        about = {"file": file.name, "turn": turn, "unit": "rad"} | asdict(scan)
        echo(to_json(about | {"peak_to_peak": scan.peak_to_peak}))
        return
    echo(f"{file.name}: {counted(len(scan.lines), 'line')}, orders per turn of the {turn}\n{scan}")
    if scan.aliases:
        echo("no lines for a project file: these angles do not determine the orders")
    elif scan.lines:
        echo(block(scan.lines))


def _factor(shaft: str, turn: str, ratio: float | None) -> float:
    """Turns of the base angle per turn of the file's shaft."""
    if shaft == turn:
        return 1.0
    if ratio is None:
        raise ValueError(f"the angle is that of the {shaft}, the orders are per {turn} turn; add --ratio")
    N = order_map(ratio).N
    return float(N) if shaft == "output" else 1.0 / N


def project_lines(lines: Iterable[Any], once: float = 1.0) -> str:
    """The strongest lines of an angle [rad] as the field `kinematic_error` and its source.

    `once` is the order of one line a turn of the motor.
    """
    rows = ["  kinematic_error:"]
    strongest = sorted(lines, key=lambda line: -line.amplitude)[:SHOWN_IN_PROJECT]
    for line in sorted(strongest, key=lambda line: line.order):
        size = f"amplitude: {line.amplitude / ARCSEC:.6g} arcsec, phase: {line.phase:.5g} rad"
        j, k = getattr(line, "pair", None) or (round(line.order / once), 0)
        order = f"{{wave_generator: {j}, output: {k}}}" if k else f"{j}"
        rows.append(f"    - {{order: {order}, {size}}}")
    return "\n".join([*rows, "sources: {excitation.kinematic_error: measured}"])


def block(lines: Sequence[Any], once: float = 1.0) -> str:
    """The lines for a project file, those apart whose amplitude or phase the data do not tell."""
    large = [line for line in lines if 2.0 * NINETY_FIVE * line.amplitude_error < line.amplitude]
    sure = [line for line in large if NINETY_FIVE * line.phase_error < 0.5 * np.pi]
    out = ", ".join(f"{line.order / once:g}" for line in lines if line not in sure)
    refused = f"not for a project file, because the intervals exceed the amplitudes: orders {out}\n" if out else ""
    return (refused + (f"for a project file:\n{project_lines(sure, once)}" if sure else "")).rstrip()


@click.command("order-scan")
@click.argument("files", nargs=-1, required=True, type=file_type)
@click.option("--channel", help="Quantity to analyse. Default: the first of torsion, error, torque, current.")
@click.option(
    "--angle",
    help="Channel of the angle for the orders. Default: motor_angle with --ratio, else load_angle. For a scan "
    'file: its column, as "Winkel [deg]".',
)
@click.option("--orders", help="Orders to fit, as 100,200,202.5. Default: those detected.")
@click.option("--highest", type=float, help="Highest order to search.")
@click.option("--false-alarm", type=float, default=0.01, help="Probability that noise is reported as an order.")
@click.option("--error", help='Column of a scan file, as "Fehler [arcsec]"; "error" or "ate" by default.')
@click.option("--backward", help='Column of the error in the backward run; "backward" by default.')
@click.option("--back", type=file_type, help="Scan file of the run in the backward direction.")
@click.option("--ate", is_flag=True, help="The error has the vendors' sign: output minus motor/ratio.")
@click.option("--shaft", type=SHAFT, help="Shaft of a scan's angle; the motor by default.")
@click.option("--turn", type=SHAFT, help="Shaft per whose turn the orders count; --shaft by default.")
@output_option("Folder for orders.csv, orders.json and orders.svg.")
@reading_options
@json_option
def order_scan(
    files: tuple[Path, ...], channel: str | None, angle: str | None, orders: str | None, highest: float | None,
    false_alarm: float, output: Path | None, as_json: bool, **reading: Any,
) -> None:  # fmt: skip
    """Find the orders of logs, or of a measured error in a scan.

    FILES are logs as `strainwave read-log` reads them; all their stretches of constant speed are used. Two
    speeds separate an order from a frequency, and a delay from a phase. A table of angle and error without time is
    read as a scan over whole turns.
    """
    of_scan = {name: reading.pop(name) for name in OF_SCAN}
    chosen = None if orders is None else _orders(orders)
    search: dict[str, Any] = {"orders": chosen, "highest": highest and _plain(highest), "false_alarm": false_alarm}
    logs, ratio = list[Log](), reading["ratio"]
    dialect = {name: reading[name] for name in ("delimiter", "decimal")}
    try:
        if not any(of_scan.values()):
            logs = [_with_torsion(log_of(file, keep=True, **reading), ratio) for file in files]
    except FileError:
        if not is_scan(files[0], **dialect):
            raise
    if not logs:
        of_logs = {"channel": channel, "output": output, "column": reading["columns"], "unit": reading["units"]}
        of_logs |= {name: reading[name] for name in ("joint", "rate", "trim")}
        _print_scan(files, of_scan | {"angle": angle or "angle"}, of_logs, dialect, search, ratio, as_json)
        return
    channel = channel or _likely(logs[0], files[0])
    if ratio is not None and "motor_angle" in logs[0].channels:
        angle = angle or "motor_angle"  # the load's has the error in it
    runs = [run for log in logs for run in _runs(log, channel, angle)]
    turned = angle or ("load_angle" if "load_angle" in logs[0].channels else "motor_angle")
    ratio = ratio if turned in SHAFTS and (ratio or 0.5) % 1.0 == 0.0 else None
    shaft = SHAFTS.get(turned, "motor") if ratio else "motor"
    scan = orders_scanned(runs, ratio=ratio, shaft=shaft, **search)
    numbers = to_json(data(scan, channel))
    if output is not None:
        figure = stacked(order_scan_panels(scan, channel), 320.0, "lines of an order scan", WIDTH)
        write_all(output, {CSV: _columns(scan), JSON: numbers, SVG: figure})
    if as_json:
        echo(numbers)
        return
    echo(f"{channel}: {scan}")
    if scan.unit == "rad" and scan.varying:
        echo("no lines for a project file: the amplitude differs between the runs")
    elif scan.unit == "rad" and turned == "load_angle" and not ratio:
        echo("a project file counts orders per motor turn: add --ratio to print its lines")
    elif scan.unit == "rad":
        once = float(ratio) if ratio and turned == "load_angle" else 1.0
        possible = [line for line in scan.lines if is_error_line(line, once)]
        echo(block(possible, once) or "no line for a project file")
    if output is not None:
        echo(f"written: {output / CSV}, {JSON}, {SVG}")


def _orders(text: str) -> list[float]:
    try:
        return [_plain(float(part)) for part in text.split(",")]
    except ValueError:
        raise click.BadParameter(f"{text!r} is no list of orders; write for example 100,200,202.5") from None


def _plain(value: float) -> float:
    return int(value) if value.is_integer() else value


def _with_torsion(log: Log, ratio: float | None) -> Log:
    """The log with the torsion of a gear of that ratio, at the times of the load's angle where that has its own."""
    if ratio is None or "torsion" in log.channels or not {"motor_angle", "load_angle"} <= set(log.channels):
        return log
    torsion = with_torsion(channels_of(log), ratio)["torsion"]
    separate = dict(log.own)
    if "load_angle" in separate:
        time, load = separate["load_angle"]
        motor = np.interp(time, *separate.get("motor_angle", (log.time, log.channels["motor_angle"])))
        separate["torsion"] = time, with_torsion({"motor_angle": motor, "load_angle": load}, ratio)["torsion"]
    return replace(log, channels={**log.channels, "torsion": torsion}, own=separate)


def _likely(log: Log, file: Path) -> str:
    if name := next(filter(log.channels.__contains__, LIKELY), ""):
        return name
    raise ValueError(
        f"{file.name} has {', '.join(log.channels)}; name one of these with --channel, or give --ratio for the torsion "
        "between motor_angle and load_angle"
    )


def _runs(log: Log, channel: str, angle: str | None) -> list[Run]:
    """Stretches of constant speed; the whole log where there is none."""
    times = log.own[channel][0] if channel in log.own else log.time
    parts = [part for part in log.segments() if part.kind == "constant speed"] if log.moving else []
    parts = [part for part in parts if np.count_nonzero((times >= part.start) & (times <= part.stop)) >= FEWEST_SAMPLES]
    return [log.run(channel, angle, part=part) for part in parts] or [log.run(channel, angle)]


def data(scan: OrderScan, channel: str) -> dict[str, Any]:
    """The lines with their intervals, in SI."""
    return {
        "channel": channel,
        "unit": scan.unit,
        "speeds_rad_per_s": scan.speeds,
        **{key: list(map(_line, getattr(scan, key))) for key in ("lines", "forward", "backward")},
        "delay_s": scan.delay,
        "delay_error_s": scan.delay_error,
        "residual_rms": scan.residual,
        "multiples_of": scan.base or None,
        "notes": list(scan.notes),
    }


def _line(line: OrderLine) -> dict[str, Any]:
    low, high = line.interval()
    return {
        "order": line.order, "order_error": line.order_error, "kind": line.kind, "why": line.why,
        "amplitude": line.amplitude, "amplitude_low": low, "amplitude_high": high, "phase_rad": line.phase,
        "phase_error_rad": line.phase_error, "false_alarm": line.false_alarm,
        "pairs": line.pairs, "frequency_hz": line.frequency,
    }  # fmt: skip


def _columns(scan: OrderScan) -> list[tuple[str, Any]]:
    names = ("order", "order_error", "amplitude", "amplitude_error", "phase", "phase_error", "false_alarm")
    columns = [(name, np.array([getattr(line, name) for line in scan.lines])) for name in names]
    return [*columns, ("stays_with_angle", np.array([float(line.kind == "order") for line in scan.lines]))]


def is_error_line(line: OrderLine, once: float = 1.0) -> bool:
    """True for a possible line of a kinematic error: a pair of both turns, or a whole order of the motor."""
    if line.pair is not None:
        return line.kind != "frequency" and line.pair[0] > 0
    order, error = line.order / once, max(line.order_error / once, 1e-6)
    return line.kind != "frequency" and round(order) > 0 and abs(order - round(order)) <= error
