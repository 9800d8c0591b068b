"""Figures of a compensation: the error in time, controllers over the speed, orders before and after, many units."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ..base.results import Floats
from ..base.sentences import number
from ..base.units import RPM
from ..numerics.sampled.loops import run_loop
from ..study.compensation.bench import Bench
from ..study.compensation.designs import COMPENSATORS, own_rate
from ..study.compensation.gains import times_of
from ..study.compensation.monitoring import Monitored
from ..study.compensation.moves import CompensatedMove
from ..study.compensation.prediction import PredictionTable
from ..study.compensation.result import Compensation, CompensationBench, Units
from ..study.compensation.runup import CompensatedRunup
from .colours import BLACK, BLUE, DASHES, DOT_DASH, DOTS, GREEN, GREY, LOOKS, ORANGE
from .panels import MOTOR, TIME, Axis, Panel, angle, panels_of

TURNS = 2  # of the motor that are shown
PLAIN = "loop"
AFTER = ((BLUE, "", 1.8), (BLACK, DOT_DASH, 1.3), (GREEN, DOTS, 1.3))  # of the controllers of one figure
PARTED = 0.07  # of an order: distance of the stems of one order


class Motion(NamedTuple):
    """Pointing error [rad] about its mean over turns of the motor, and what made it, in words."""

    name: str
    turns: Floats
    error: Floats


def motion(bench: Bench, controller: str, speed: float, name: str) -> Motion:
    """The last turns under a controller, by its name in `COMPENSATORS`, at a motor speed [rad/s]."""
    built = COMPENSATORS[controller].on(bench, speed)
    settle, _ = times_of(bench, speed, own_rate(bench, speed, built))
    turn = 2.0 * np.pi / abs(speed)
    run = run_loop(bench.closed(built, speed), settle + TURNS * turn, y0=bench.start(speed))
    late = run.time >= run.time[-1] - TURNS * turn
    time, error = run.time[late], run.error[late]
    return Motion(name, (time - time[0]) / turn, error - np.mean(error))


def error_panels(before: Motion, after: Sequence[Motion]) -> list[Panel]:
    """The error before and after on one scale, and what is left on its own."""
    x, ends = Axis("turns of the motor"), (0.0, float(TURNS))
    above = Panel("pointing error of the load about its mean", x, angle("", before.error), xlim=ends)
    below = Panel("what is left of it", x, angle("", [one.error for one in after]), xlim=ends)
    above.line(before.turns, before.error, ORANGE, before.name, DASHES)
    for one, (colour, dash, width) in zip(after, AFTER, strict=False):
        for panel in (above, below):
            panel.line(one.turns, one.error, colour, one.name, dash, width)
    return [above, below]


@panels_of.register
def bench_panels(found: CompensationBench) -> list[Panel]:
    """Residual rms over the speed: of controllers without an encoder on the load, and of those with one."""
    return [panel for seeing in (False, True) for panel in speed_panels(found, load_encoder=seeing)]


def speed_panels(found: CompensationBench, *, load_encoder: bool) -> list[Panel]:
    """Residual rms over the speed, of controllers with or without an encoder on the load; none where there is none."""
    every = [[one for one in row if np.isfinite(one.after.rms) and one.after.rms > 0.0] for row in found.results]
    rows = [row for row in every if row and row[0].load_encoder == load_encoder and row[0].name != PLAIN]
    if not rows:
        return []
    before = [one.before.rms for one in found.results[0]]
    title = "with an encoder on the load" if load_encoder else "without an encoder on the load"
    panel = Panel(title, MOTOR, angle("rms of the error", before), log=True, xlog=True)
    low, high = float(np.min(found.speeds)), float(np.max(found.speeds))
    panel.xlim = (low - 0.1 * abs(low), high + 0.1 * abs(high))
    panel.line(found.speeds, before, BLACK, "plain loop", "", 2.6)
    for i, row in enumerate(rows):
        (colour, dash), places = LOOKS[i % len(LOOKS)], _places(row)
        panel.line(*places, colour, row[0].name, dash)
        panel.points(*places, colour)
    out = [one for row in rows for one in row if one.excluded or not one.stable]
    panel.points(*_places(out), BLACK, "limit met, or error grew", "v", BLACK)
    return [panel]


def _places(found: Sequence[Compensation]) -> tuple[list[float], list[float]]:
    return [one.speed for one in found], [one.after.rms for one in found]


@panels_of.register
def compensation_panels(found: Compensation) -> list[Panel]:
    """Amplitudes of the error by order of the motor's angle, before and after."""
    return order_panels([found])


def order_panels(found: Sequence[Compensation]) -> list[Panel]:
    """Amplitudes of the error by order of the motor's angle, before and after under each controller."""
    first = found[0]
    every = [first.amplitude_before, *(one.amplitude_after for one in found)]
    good = np.concatenate([sizes[sizes > 0.0] for sizes in every])
    title = f"amplitudes of the error at {number(first.speed / RPM)} rpm"
    panel = Panel(title, Axis("order of the motor's angle"), angle("", good), log=True)
    panel.xlim, panel.ylim = (0.0, float(np.max(first.orders)) + 1.0), (0.5 * float(np.min(good)), 2.0 * np.max(good))
    looks = [("plain loop", ORANGE, DASHES, "o")]
    looks += [(one.name, colour, dash, "^") for one, (colour, dash, _) in zip(found, AFTER, strict=False)]
    for i, ((name, colour, dash, marker), sizes) in enumerate(zip(looks, every, strict=True)):
        at = first.orders + PARTED * np.max(first.orders) * (i - 0.5 * (len(looks) - 1))
        for x, size in zip(at[sizes > 0.0].tolist(), sizes[sizes > 0.0].tolist(), strict=True):
            panel.line([x, x], [panel.ylim[0], size], colour, name, dash, 2.2)
            panel.points([x], [size], colour, "", marker, colour)
    return [panel]


@panels_of.register
def own_units_panels(found: Units) -> list[Panel]:
    """Shares of the units whose rms is below a value, under the plain loop and under the controller."""
    return units_panels({"controller": found})


def units_panels(found: Mapping[str, Units]) -> list[Panel]:
    """Shares of the units whose rms is below a value, under the plain loop and under controllers, by name."""
    first = next(iter(found.values()))
    rows = {"plain loop": first.before.rms} | {name: units.after.rms for name, units in found.items()}
    every = np.concatenate([rms[np.isfinite(rms)] for rms in rows.values()])
    x, y = angle("rms of the error", every), Axis("share of the units", "%")
    panel = Panel(f"{len(first.after.rms)} units", x, y, xlog=True, ylim=(0.0, 103.0))
    panel.xlim = (0.8 * float(np.min(every)), 1.25 * float(np.max(every)))
    looks = ((ORANGE, DASHES), *((colour, dash) for colour, dash, _ in AFTER))
    for (name, rms), (colour, dash) in zip(rows.items(), looks, strict=False):
        panel.share(rms, colour, name, dash)
    return [panel]


@panels_of.register
def compensated_move_panels(found: CompensatedMove) -> list[Panel]:
    """Error of the load and torque of the motor over the time, under each controller."""
    error = Panel("angle of the load in the profile less its angle", TIME, angle("", found.error))
    torque = Panel("torque of the motor", TIME, Axis("", "N*m"))
    for i, name in enumerate(found.names):
        colour, dash = (BLACK, "") if i == 0 else LOOKS[(i - 1) % len(LOOKS)]
        error.line(found.time, found.error[i], colour, name, dash)
        torque.line(found.time, found.torque[i], colour, "", dash)
    for panel in (error, torque):
        panel.upright(found.duration, GREY, "", "1 3", 1.0)
    return [error, torque]


@panels_of.register
def compensated_runup_panels(found: CompensatedRunup) -> list[Panel]:
    """Largest error over the speed on the way up and down, under each controller."""
    y = angle("", [found.up, found.down])
    panel = Panel("largest pointing error about its mean", MOTOR, y, log=True)
    for i, name in enumerate(found.names):
        colour = BLACK if i == 0 else LOOKS[(i - 1) % len(LOOKS)][0]
        for sizes, way, dash in ((found.up, "up", ""), (found.down, "down", "5 3")):
            panel.line(found.speed, sizes[i], colour, f"{name}, {way}", dash, 1.8)
    return [panel]


@panels_of.register
def monitored_panels(found: Monitored) -> list[Panel]:
    """The amplitudes of the orders over the time, from where they have settled on."""
    late = found.time >= found.settled_from
    shown = late if np.any(late) else slice(None)
    panel = Panel("", TIME, Axis("amplitude", "units of the signal"))
    for i, (order, row) in enumerate(zip(found.orders, found.amplitude, strict=True)):
        colour, dash = LOOKS[i % len(LOOKS)]
        panel.line(found.time[shown], row[shown], colour, f"order {order:g}", dash, 1.1)
    return [panel]


@panels_of.register
def prediction_panels(found: PredictionTable) -> list[Panel]:
    """The amplitudes of the orders over the speed, dotted where not stable; valid closed forms are dots."""
    sizes = np.abs(found.amplitudes)
    panel = Panel("", MOTOR, angle("amplitude of the error", sizes), log=True)
    for i, (order, row) in enumerate(zip(found.orders, sizes, strict=True)):
        colour = LOOKS[i % len(LOOKS)][0]
        panel.line(found.omega, row, colour, dash="1 3", width=1.0)
        for a, b in found.runs():
            panel.line(found.omega[a:b], row[a:b], colour, f"order {order}", width=1.4)
        if found.closed is not None and found.valid is not None:
            at = found.valid
            panel.points(found.omega[at], np.abs(found.closed[i, at]), colour, "", ".", colour)
    return [panel]
