"""Figures of a compensation: the error in time, controllers over the speed, orders before and after, many units.

They are narrow, so that their text is read on a telephone too; what colour tells apart, dashes or markers do too.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ...base.results import Floats
from ...base.units import RPM
from ...numerics.sampled.loops import run_loop
from ...study.compensation.bench import Bench
from ...study.compensation.designs import COMPENSATORS, own_rate
from ...study.compensation.gains import times_of
from ...study.compensation.moves import CompensatedMove
from ...study.compensation.result import Compensation, CompensationBench, Units
from ...study.compensation.runup import CompensatedRunup
from ..console import number
from ..view import angle_unit
from .curves import BLACK, BLUE, DASHES, DOT_DASH, GREY, ORANGE, thin
from .svg import Panel, figure

WIDTH, HEIGHT = 430.0, 240.0  # of a figure and of a panel [px]
TALL = 300.0  # of a panel with many curves [px]
TURNS = 2  # of the motor that are shown
GREEN, PINK = "#009E73", "#CC79A7"
LOOKS = (
    (BLUE, ""), (ORANGE, DASHES), (GREEN, "2 2"), (PINK, "10 3"), (GREY, ""), (BLUE, "2 2"), (ORANGE, DOT_DASH),
    (GREEN, ""), (PINK, DASHES), (GREY, "2 2"),
)  # fmt: skip
PLAIN = "loop"
AFTER = ((BLUE, "", 1.8), (BLACK, DOT_DASH, 1.3), (GREEN, "2 2", 1.3))  # of the controllers of one figure
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
    unit = angle_unit(float(np.max(np.abs(before.error))))
    fine = angle_unit(max(float(np.max(np.abs(one.error))) for one in after))
    above = Panel("pointing error of the load about its mean", "", unit.name, xlim=(0.0, float(TURNS)))
    below = Panel("what is left of it", "turns of the motor", fine.name, xlim=(0.0, float(TURNS)))
    above.line(before.turns, before.error * unit.factor, ORANGE, before.name, DASHES, 1.6)
    for one, (colour, dash, width) in zip(after, AFTER, strict=False):
        above.line(one.turns, one.error * unit.factor, colour, one.name, dash, width)
        below.line(one.turns, one.error * fine.factor, colour, one.name, dash, width)
    return [above, below]


def error_figure(before: Motion, after: Sequence[Motion], *, wide: bool = False) -> str:
    """The error over turns of the motor as SVG; wide is for a page, its panels side by side."""
    panels, label = error_panels(before, after), "pointing error before and after"
    if wide:
        panels[0].xlabel = panels[1].xlabel
        return figure([panels], HEIGHT, label)
    return figure([[panel] for panel in panels], HEIGHT, label, WIDTH)


def speed_panel(found: CompensationBench, *, load_encoder: bool) -> Panel | None:
    """Residual rms over the speed, of controllers with or without an encoder on the load; None where there is none."""
    every = [[one for one in row if np.isfinite(one.after.rms) and one.after.rms > 0.0] for row in found.results]
    rows = [row for row in every if row and row[0].load_encoder == load_encoder and row[0].name != PLAIN]
    if not rows:
        return None
    plain = found.results[0]
    unit = angle_unit(max(one.before.rms for one in plain))
    title = "with an encoder on the load" if load_encoder else "without an encoder on the load"
    panel = Panel(title, "motor speed (rpm)", f"rms of the error ({unit.name})", log=True, xlog=True)
    low, high = float(np.min(found.speeds)) / RPM, float(np.max(found.speeds)) / RPM
    panel.xlim = (low - 0.1 * abs(low), high + 0.1 * abs(high))
    panel.line(found.speeds / RPM, [one.before.rms * unit.factor for one in plain], BLACK, "plain loop", "", 2.6)
    for i, row in enumerate(rows):
        colour, dash = LOOKS[i % len(LOOKS)]
        rpm, size = [_rpm(one) for one in row], [one.after.rms * unit.factor for one in row]
        panel.line(rpm, size, colour, row[0].name, dash)
        panel.points(rpm, size, colour, "", "o", "#ffffff")
    out = [one for row in rows for one in row if one.excluded or not one.stable]
    if out:
        sizes = [one.after.rms * unit.factor for one in out]
        panel.points([_rpm(one) for one in out], sizes, BLACK, "limit met, or error grew", "v", BLACK)
    return panel


def _rpm(one: Compensation) -> float:
    return one.speed / RPM


def speed_figure(found: CompensationBench, *, load_encoder: bool) -> str:
    """Controllers over the speed as SVG; empty where there is none of them."""
    panel = speed_panel(found, load_encoder=load_encoder)
    return "" if panel is None else figure([[panel]], TALL, "residual error over the speed", WIDTH)


def order_panel(found: Sequence[Compensation]) -> Panel:
    """Amplitudes of the error by order of the motor's angle, before and after."""
    first = found[0]
    every = [first.amplitude_before, *(one.amplitude_after for one in found)]
    good = np.concatenate([sizes[sizes > 0.0] for sizes in every])
    unit = angle_unit(float(np.max(good)))
    low, high = 0.5 * float(np.min(good)) * unit.factor, 2.0 * float(np.max(good)) * unit.factor
    title = f"amplitudes of the error at {number(first.speed / RPM)} rpm"
    panel = Panel(title, "order of the motor's angle", unit.name, log=True, ylim=(low, high))
    panel.xlim = (0.0, float(np.max(first.orders)) + 1.0)
    looks = [("plain loop", ORANGE, DASHES, 2.2, "o")]
    looks += [(one.name, colour, dash, 2.2, "^") for one, (colour, dash, _) in zip(found, AFTER, strict=False)]
    for i, ((name, colour, dash, width, marker), sizes) in enumerate(zip(looks, every, strict=True)):
        at = first.orders + PARTED * np.max(first.orders) * (i - 0.5 * (len(looks) - 1))
        for x, size in zip(at.tolist(), (sizes * unit.factor).tolist(), strict=True):
            if size > 0.0:
                panel.line([x, x], [low, size], colour, name, dash, width)
                panel.points([x], [size], colour, "", marker, colour)
    return panel


def order_figure(found: Sequence[Compensation]) -> str:
    """Amplitudes by order as SVG."""
    return figure([[order_panel(found)]], HEIGHT, "amplitudes by order before and after", WIDTH)


def units_panel(found: Mapping[str, Units]) -> Panel:
    """Shares of the units whose rms is below a value, under the plain loop and under controllers, by name."""
    first = next(iter(found.values()))
    rows = {"plain loop": first.before.rms} | {name: units.after.rms for name, units in found.items()}
    every = np.concatenate([rms[np.isfinite(rms)] for rms in rows.values()])
    unit = angle_unit(float(np.max(every)))
    title = f"{len(first.after.rms)} units"
    panel = Panel(title, f"rms of the error ({unit.name})", "share of the units (%)", xlog=True)
    looks = ((ORANGE, DASHES), *((colour, dash) for colour, dash, _ in AFTER))
    for (name, rms), (colour, dash) in zip(rows.items(), looks, strict=False):
        good = np.sort(rms[np.isfinite(rms)]) * unit.factor
        share = 100.0 * np.arange(1, len(good) + 1) / len(rms)
        panel.line(np.repeat(good, 2), [0.0, *np.repeat(share, 2)[:-1]], colour, name, dash, 1.8)
    panel.ylim = (0.0, 103.0)
    panel.xlim = (0.8 * float(np.min(every)) * unit.factor, 1.25 * float(np.max(every)) * unit.factor)
    return panel


def units_figure(found: Mapping[str, Units]) -> str:
    """Residuals of many units as SVG."""
    return figure([[units_panel(found)]], HEIGHT, "residual errors of many units", WIDTH)


def move_figure(found: CompensatedMove) -> str:
    """Error of the load and torque of the motor over the time, under each controller, as SVG."""
    unit = angle_unit(float(np.max(np.abs(found.error))))
    error = Panel("angle of the load in the profile less its angle", "", unit.name)
    torque = Panel("torque of the motor", "time (s)", "N·m")
    for i, name in enumerate(found.names):
        colour, dash = (BLACK, "") if i == 0 else LOOKS[(i - 1) % len(LOOKS)]
        error.line(*thin(found.time, found.error[i] * unit.factor), colour, name, dash)
        torque.line(*thin(found.time, found.torque[i]), colour, "", dash)
    for panel in (error, torque):
        low, high = panel.limits()[1]
        panel.line([found.duration] * 2, [low, high], GREY, "", "1 3", 1.0)
    return figure([[error], [torque]], HEIGHT, "a move under several controllers", WIDTH)


def run_up_figure(found: CompensatedRunup) -> str:
    """Largest error over the speed on the way up and down, under each controller, as SVG."""
    unit = angle_unit(float(max(np.max(found.up), np.max(found.down))))
    panel = Panel("largest pointing error about its mean", "motor speed (rpm)", unit.name, log=True)
    for i, name in enumerate(found.names):
        colour = BLACK if i == 0 else LOOKS[(i - 1) % len(LOOKS)][0]
        for sizes, way, dash in ((found.up, "up", ""), (found.down, "down", "5 3")):
            panel.line(found.speed / RPM, sizes[i] * unit.factor, colour, f"{name}, {way}", dash, 1.8)
    return figure([[panel]], TALL, "a run-up and a run-down under several controllers", WIDTH)
