"""Order tables of a controller: the angle or the torque that it adds, as drives and controls read them."""

from collections.abc import Iterable
from dataclasses import replace
from math import atan2, cos, hypot, pi, sin
from typing import Any, NamedTuple

import numpy as np

from ....files.order_tables.order_table import OrderTable
from ....model.controllers.adaptive import AdaptiveCancellation
from ....model.controllers.feedforward import AngleFeedforward, TorqueTable
from ....model.excitation import Harmonic, Harmonics, KinematicError, Line
from ....numerics.sampled.loops import loop_ensemble, run_loop
from ....numerics.sampled.result import LoopRun
from ....study.compensation.bench import Bench
from ....study.compensation.gains import behind_of, times_of
from ....study.compensation.given import own_rate
from ....study.compensation.result import Compensation
from ....theory.lyapunov import mean_torque
from ....units import ARCSEC, RPM

DIGITS = 12  # of a delay [s], behind which is rounding


class Alone(NamedTuple):
    """An order table, and the rms of the pointing error [rad] that it leaves without the rest of its controller."""

    table: OrderTable
    rms: float


def stated(bench: Bench, found: Compensation) -> tuple[tuple[str, Alone], ...]:
    """As `tables_of`; what each leaves alone, and all together, is run and stands in its `source`."""
    tables, speed = tables_of(bench, found), found.speed
    every = left(bench, tables.values(), speed) / ARCSEC if len(tables) > 1 else 0.0
    told = []
    for name, table in tables.items():
        rms = left(bench, [table], speed)
        source = (
            f"{table.source}; used alone it leaves {rms / ARCSEC:.3g} of {found.before.rms / ARCSEC:.3g} arcsec rms of "
            "the pointing error there"
        )
        others = " and ".join(f"order-table-{other}.json" for other in tables if other != name)
        source += f", with {others} {every:.3g}" if others else ""
        told.append((name, Alone(replace(table, source=source), rms)))
    return tuple(told)


def left(bench: Bench, tables: Iterable[OrderTable], speed: float) -> float:
    """Rms of the pointing error [rad] about its mean at a motor speed [rad/s], under the plain loop and tables."""
    controller = bench.loop
    for table in tables:
        now = table.at_speed(abs(speed))
        lines = now.backward if speed < 0.0 and now.backward is not None else now.lines
        if table.unit == "rad":
            controller = AngleFeedforward(controller, KinematicError(lines), bench.model.N)
        else:
            terms = tuple(Harmonic(line.amplitude, line.order, line.phase) for line in lines)
            controller = TorqueTable(controller, Harmonics(terms))
    settle, end = times_of(bench, speed)
    return float(loop_ensemble(bench.closed(controller, speed), {}, end, settle=settle, y0=bench.start(speed)).rms[0])


def tables_of(bench: Bench, found: Compensation) -> dict[str, OrderTable]:
    """Tables of a controller by what they are added to, "angle" or "torque"; of one that adapts, what it has found.

    A torque holds at the speed of the result alone, in its direction and under the mean torque on its load; it has that
    of the motor's inertia along a corrected angle. An angle without a torque is read ahead by the time until a sample's
    torque acts.
    """
    about: dict[str, Any] = {"ratio": bench.model.N, "source": f"{found.name} at {found.speed / RPM:.4g} rpm"}
    held = about | {
        "speeds": (abs(found.speed), abs(found.speed)),
        "direction": "forward" if found.speed > 0.0 else "backward",
        "load": mean_torque(bench.plant.load.end().excitation),
    }
    tables: dict[str, OrderTable] = {}
    controller, lines = found.controller, list[Line]()
    run = _adapted(bench, found) if isinstance(controller, AdaptiveCancellation) else None
    memory: Any = run and run.memory.state
    while run is not None and isinstance(controller, AdaptiveCancellation):
        memory, a, b, _ = memory
        a, b = (x - y for x, y in zip((a, b), _ripple(bench, controller, run, found.speed), strict=True))
        lines.append(Line(controller.order, hypot(a, b), atan2(-b, a)))
        controller = controller.loop
    if isinstance(controller, AngleFeedforward):
        lines += _of_inertia(controller, found.speed) if lines else []
        ahead = 0.0 if lines else round(bench.sampling.lead, DIGITS)
        tables["angle"] = OrderTable.of(controller.error, delay=ahead, **about)
    if isinstance(controller, TorqueTable):
        tables["torque"] = OrderTable.of(controller.table, delay=controller.lead, **held)
    elif lines:
        tables["torque"] = OrderTable.of(lines[::-1], unit="N*m", **held)
    return tables


def _of_inertia(controller: AngleFeedforward, speed: float) -> list[Line]:
    """Torque lines [N*m] that move the motor's inertia along a corrected angle at a steady motor speed [rad/s]."""
    ahead, size = controller.lead * speed, controller.J * controller.N * speed * speed
    lines = controller.error.lines if size else ()
    return [Line(line.order, -size * line.order**2 * line.amplitude, line.phase + line.order * ahead) for line in lines]


def _adapted(bench: Bench, found: Compensation) -> LoopRun:
    """Run until the controller has converged."""
    settle, _ = times_of(bench, found.speed, own_rate(bench, found.speed, found.controller))
    return run_loop(bench.closed(found.controller, found.speed), settle, y0=bench.start(found.speed))


def _ripple(bench: Bench, controller: AdaptiveCancellation, run: LoopRun, speed: float) -> tuple[float, float]:
    """What the mean of the measured error makes of both amplitudes [N*m] at the end of a run, at its place in the turn.

    a' = -g y cos(k theta + phi) and b' = -g y sin(k theta + phi) of a constant y are waves about what has been found.
    """
    seen = run.error if controller.on_load else behind_of(bench)(run.states)
    turn = round(2.0 * pi / abs(speed) / bench.sampling.period)
    step = controller.order * speed * bench.sampling.period
    size = controller.period * controller.gain * float(np.mean(seen[-turn:])) / (2.0 * sin(0.5 * step))
    late = step * (len(run.time) - 0.5) + (controller.phase if speed > 0.0 else -controller.phase)
    return -size * sin(late), size * cos(late)
