"""Figures of a compensation: the error in time, controllers over the speed, orders before and after, many units."""

from collections.abc import Mapping, Sequence
from itertools import cycle
from math import ceil
from typing import NamedTuple

import numpy as np

from ..base.results import Floats
from ..study.compensation.bench import Bench
from ..study.compensation.designs import COMPENSATORS
from ..study.compensation.gains import learning_rate, times_of
from ..study.compensation.monitoring import Monitored
from ..study.compensation.prediction import PredictionTable
from ..study.compensation.result import Compensation, CompensationBench, Units
from .panels import BLACK, DASHES, DOT_DASH, LOOKS, ORANGE, TIME, Axis, Panel, angle, of_speeds, panels_of

TURNS = 2  # of the motor that are shown, or those of a beat
PLAIN = "loop"
AFTER = ((*LOOKS[0], 1.8), (BLACK, DOT_DASH, 1.3), (*LOOKS[2], 1.3))  # of the controllers of one figure
PARTED = 0.07  # of an order: distance of the stems of one order


class Motion(NamedTuple):
    """Pointing error [rad] about its mean over turns of a shaft, under the controller of this name."""

    name: str
    turns: Floats
    error: Floats
    shaft: str = "motor"


def motion(bench: Bench, controller: str, speed: float, name: str) -> Motion:
    """The last turns under a controller, by its name in `COMPENSATORS`, at a motor speed [rad/s]."""
    bench = bench.at_speed(speed)
    built = COMPENSATORS[controller].controller_on(bench, speed)
    settle, _ = times_of(bench, speed, learning_rate(bench, speed, built))
    turn, turns = 2.0 * np.pi / abs(speed), max(TURNS, ceil(bench.repeat))
    run = bench.run(built, speed, settle + turns * turn)
    late = run.time >= run.time[-1] - turns * turn
    time, error = run.time[late], run.error[late]
    return Motion(name, (time - time[0]) / turn, error - np.mean(error), bench.speeds.base)


def error_panels(before: Motion, after: Sequence[Motion]) -> list[Panel]:
    """The error before and after on one scale, and the residual error alone."""
    x, ends = Axis(f"turns of the {before.shaft}"), (0.0, float(np.round(before.turns[-1])))
    error = Panel("pointing error of the load about its mean", x, angle("", before.error), xlim=ends)
    residual = Panel("residual pointing error", x, angle("", np.concatenate([run.error for run in after])), xlim=ends)
    error.line(before.turns, before.error, ORANGE, before.name, DASHES)
    for run, (colour, dash, width) in zip(after, AFTER, strict=False):
        for panel in (error, residual):
            panel.line(run.turns, run.error, colour, run.name, dash, width)
    return [error, residual]


@panels_of.register
def bench_panels(bench: CompensationBench) -> list[Panel]:
    """Residual rms over the speed: of controllers without an encoder on the load, and of those with one."""
    return [panel for seeing in (False, True) for panel in speed_panels(bench, load_encoder=seeing)]


def speed_panels(bench: CompensationBench, *, load_encoder: bool) -> list[Panel]:
    """Residual rms over the speed, of controllers with or without an encoder on the load; empty without such."""
    finite = [[case for case in row if np.isfinite(case.after.rms) and case.after.rms > 0.0] for row in bench.results]
    rows = [row for row in finite if row and row[0].load_encoder == load_encoder and row[0].name != PLAIN]
    if not rows:
        return []
    before = [case.before.rms for case in bench.results[0]]
    title = "with an encoder on the load" if load_encoder else "without an encoder on the load"
    panel = Panel(title, of_speeds(bench.axis), angle("rms of the error", before), log=True, xlog=True)
    low, high = float(np.min(bench.speeds)), float(np.max(bench.speeds))
    panel.xlim = (low - 0.1 * abs(low), high + 0.1 * abs(high))
    panel.line(bench.speeds, before, BLACK, "plain loop", "", 2.6)
    for i, row in enumerate(rows):
        (colour, dash), points = LOOKS[i % len(LOOKS)], _rms_over_speed(row)
        panel.line(*points, colour, row[0].name, dash)
        panel.points(*points, colour)
    limited = [case for row in rows for case in row if case.excluded or not case.stable]
    panel.points(*_rms_over_speed(limited), BLACK, "motor limit reached, or error grew", "v", BLACK)
    return [panel]


def _rms_over_speed(cases: Sequence[Compensation]) -> tuple[list[float], list[float]]:
    return [case.speed for case in cases], [case.after.rms for case in cases]


@panels_of.register
def compensation_panels(result: Compensation) -> list[Panel]:
    """Amplitudes of the error by order of the motor's angle, before and after."""
    return order_panels([result])


def order_panels(cases: Sequence[Compensation]) -> list[Panel]:
    """Amplitudes of the error by order of the motor's angle, before and after under each controller."""
    first = cases[0]
    amplitudes = [first.amplitude_before, *(case.amplitude_after for case in cases)]
    good = np.concatenate([sizes[sizes > 0.0] for sizes in amplitudes])
    title = f"amplitudes of the error at {first.axis.said(first.speed)}"
    panel = Panel(title, Axis(f"order of the {first.axis.base_angle}"), angle("", good), log=True)
    panel.xlim, panel.ylim = (0.0, float(np.max(first.orders)) + 1.0), (0.5 * float(np.min(good)), 2.0 * np.max(good))
    looks = [("plain loop", ORANGE, DASHES, "o")]
    looks += [(case.name, colour, dash, "^") for case, (colour, dash, _) in zip(cases, AFTER, strict=False)]
    for i, ((name, colour, dash, marker), sizes) in enumerate(zip(looks, amplitudes, strict=True)):
        abscissas = first.orders + PARTED * np.max(first.orders) * (i - 0.5 * (len(looks) - 1))
        for x, size in zip(abscissas[sizes > 0.0].tolist(), sizes[sizes > 0.0].tolist(), strict=True):
            panel.line([x, x], [panel.ylim[0], size], colour, name, dash, 2.2)
            panel.points([x], [size], colour, "", marker, colour)
    return [panel]


@panels_of.register
def own_units_panels(result: Units) -> list[Panel]:
    """Shares of the units whose rms is below a value, under the plain loop and under the controller."""
    return units_panels({"controller": result})


def units_panels(results: Mapping[str, Units]) -> list[Panel]:
    """Shares of the units whose rms is below a value, under the plain loop and under controllers, by name."""
    first = next(iter(results.values()))
    rows = {"plain loop": first.before.rms} | {name: units.after.rms for name, units in results.items()}
    values = np.concatenate([rms[np.isfinite(rms)] for rms in rows.values()])
    x, y = angle("rms of the error", values), Axis("fraction of the units", "%")
    panel = Panel(f"{len(first.after.rms)} units", x, y, xlog=True, ylim=(0.0, 103.0))
    panel.xlim = (0.8 * float(np.min(values)), 1.25 * float(np.max(values)))
    looks = ((ORANGE, DASHES), *((colour, dash) for colour, dash, _ in AFTER))
    for (name, rms), (colour, dash) in zip(rows.items(), looks, strict=False):
        panel.share(rms, colour, name, dash)
    return [panel]


@panels_of.register
def monitored_panels(monitored: Monitored) -> list[Panel]:
    """The amplitudes of the orders over the time, from where they have settled on."""
    late = monitored.time >= monitored.settled_from
    samples = late if np.any(late) else slice(None)
    panel = Panel("", TIME, Axis("amplitude", "units of the signal"))
    for (colour, dash), order, row in zip(cycle(LOOKS), monitored.orders, monitored.amplitude, strict=False):
        panel.line(monitored.time[samples], row[samples], colour, f"order {order:g}", dash, 1.1)
    return [panel]


@panels_of.register
def prediction_panels(table: PredictionTable) -> list[Panel]:
    """The amplitudes of the orders over the speed, dotted where not stable; valid closed forms are dots."""
    sizes = np.abs(table.amplitudes)
    panel = Panel("", of_speeds(table.axis), angle("amplitude of the error", sizes), log=True)
    for i, (order, row) in enumerate(zip(table.orders, sizes, strict=True)):
        colour = LOOKS[i % len(LOOKS)][0]
        panel.line(table.omega, row, colour, dash="1 3", width=1.0)
        for a, b in table.runs():
            panel.line(table.omega[a:b], row[a:b], colour, f"order {order}", width=1.4)
        if table.closed is not None and table.valid is not None:
            closed = np.abs(table.closed[i, table.valid])
            panel.points(table.omega[table.valid], closed, colour, "", ".", colour)
    return [panel]
