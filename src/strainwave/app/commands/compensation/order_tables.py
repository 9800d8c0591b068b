"""Order tables for drives: what a compensation adds to angle or torque, and the error that each table leaves."""

from collections.abc import Iterable
from dataclasses import replace
from math import atan2, cos, hypot, pi, sin
from typing import Any, NamedTuple

import numpy as np

from ....base.protocols import terms_of
from ....base.units import ARCSEC, RPM
from ....files.order_table import OrderTable
from ....model.controllers.adaptive import AdaptiveCancellation
from ....model.controllers.feedforward import AngleFeedforward, TorqueTable
from ....model.excitation import Harmonic, Harmonics, KinematicError, Line, mean_torque
from ....numerics.ensemble.loops import LoopRun, loop_ensemble
from ....study.compensation.bench import Bench
from ....study.compensation.gains import learning_rate, motor_lag_of, times_of
from ....study.compensation.result import Compensation

DIGITS = 12  # of a delay [s], behind which is rounding


class TableAlone(NamedTuple):
    """An order table, and the rms of the pointing error [rad] under the plain loop with this table alone."""

    table: OrderTable
    rms: float


def written_tables(bench: Bench, case: Compensation) -> tuple[tuple[str, TableAlone], ...]:
    """Tables of a controller by signal, whose `source` has the rms that each leaves alone, and all of them together.

    Of an error equation there are none: the phase of a forcing is no angle that a drive controller knows.
    """
    if bench.equation:
        return ()
    bench, speed = bench.at_speed(case.speed), case.speed
    tables = tables_of(bench, case)
    joint = rms_under(bench, tables.values(), speed) / ARCSEC if len(tables) > 1 else 0.0
    alone = []
    for name, table in tables.items():
        rms = rms_under(bench, [table], speed)
        source = (
            f"{table.source}; this table alone reduces the rms pointing error from {case.before.rms / ARCSEC:.3g} "
            f"to {rms / ARCSEC:.3g} arcsec"
        )
        others = " and ".join(f"order-table-{other}.json" for other in tables if other != name)
        source += f"; together with {others} to {joint:.3g} arcsec" if others else ""
        alone.append((name, TableAlone(replace(table, source=source), rms)))
    return tuple(alone)


def rms_under(bench: Bench, tables: Iterable[OrderTable], speed: float) -> float:
    """Rms of the pointing error [rad] about its mean at a motor speed [rad/s], under the plain loop and tables."""
    controller = bench.loop
    for table in tables:
        turns = 1.0 / bench.model.N if table.turn == "output" else 1.0
        at_speed = table.at_speed(turns * abs(speed))
        lines = at_speed.backward if speed < 0.0 and at_speed.backward is not None else at_speed.lines
        if table.unit == "rad":
            error = KinematicError(tuple(line._replace(order=turns * line.order) for line in lines))
            controller = AngleFeedforward(controller, error, bench.model.N)
        else:
            terms = tuple(Harmonic(line.amplitude, line.order, line.phase) for line in lines)
            controller = TorqueTable(controller, Harmonics(terms), turns=turns)
    settle, end = times_of(bench, speed)
    return float(loop_ensemble(bench.closed(controller, speed), {}, end, settle=settle, y0=bench.start(speed)).rms[0])


def tables_of(bench: Bench, case: Compensation) -> dict[str, OrderTable]:
    """Tables of a controller by the signal they are added to, "angle" or "torque"; adapted ones after convergence.

    A torque holds at the speed of the result alone, in its direction and under the mean torque on its load; it has that
    of the motor's inertia along a corrected angle. An angle without a torque is read ahead by the time until a sample's
    torque acts.
    """
    about: dict[str, Any] = {"ratio": bench.model.N, "source": f"{case.name} at {case.speed / RPM:.4g} rpm"}
    held = about | {
        "speeds": (abs(case.speed), abs(case.speed)),
        "direction": "forward" if case.speed > 0.0 else "backward",
        "load": mean_torque(bench.plant.load.end().excitation),
    }
    tables: dict[str, OrderTable] = {}
    controller, lines = _adapted_lines(bench, case)
    adapted = bool(lines)
    if isinstance(controller, TorqueTable):
        table, controller = controller, controller.loop
        if adapted:
            ahead = table.lead * case.speed
            lines += [Line(h.order, h.amplitude, h.phase + h.order * ahead) for h in terms_of(table.table)]
        else:
            turn = "motor" if table.turns == 1.0 else "output"
            tables["torque"] = OrderTable.of(table.table, turn=turn, delay=table.lead, **held)
    if isinstance(controller, AngleFeedforward):
        lines += _of_inertia(controller, case.speed) if adapted else []
        delay = 0.0 if adapted else round(bench.lead, DIGITS)
        one_way = {} if bench.backward is None else {"direction": held["direction"]}
        tables["angle"] = OrderTable.of(controller.error, delay=delay, **about, **one_way)
    if adapted:
        tables["torque"] = OrderTable.of(lines[::-1], unit="N*m", **held)
    return tables


def _adapted_lines(bench: Bench, case: Compensation) -> tuple[Any, list[Line]]:
    """The controller within those that adapt, and the torque lines [N*m] of these, after convergence."""
    controller, lines = case.controller, list[Line]()
    if not isinstance(controller, AdaptiveCancellation):
        return controller, lines
    settle, _ = times_of(bench, case.speed, learning_rate(bench, case.speed, controller))
    run = bench.run(controller, case.speed, settle)
    memory: Any = run.memory.state
    while isinstance(controller, AdaptiveCancellation):
        memory, a, b, _ = memory
        ripple_a, ripple_b = _ripple(bench, controller, run, case.speed)
        a, b = a - ripple_a, b - ripple_b
        lines.append(Line(controller.order, hypot(a, b), atan2(-b, a)))
        controller = controller.loop
    return controller, lines


def _of_inertia(controller: AngleFeedforward, speed: float) -> list[Line]:
    """Torque lines [N*m] that move the motor's inertia along a corrected angle at a steady motor speed [rad/s]."""
    ahead, size = controller.lead * speed, controller.J * controller.N * speed * speed
    lines = controller.error.lines if size else ()
    return [Line(line.order, -size * line.order**2 * line.amplitude, line.phase + line.order * ahead) for line in lines]


def _ripple(bench: Bench, controller: AdaptiveCancellation, run: LoopRun, speed: float) -> tuple[float, float]:
    """Ripple of both amplitudes [N*m] at the end of a run, due to the mean y of the measured error.

    a' = -g y cos(k theta + phi) and b' = -g y sin(k theta + phi) of a constant y are waves about the converged values.
    """
    error = run.error if controller.on_load else motor_lag_of(bench)(run.states)
    turn = round(2.0 * pi / abs(speed) / bench.sampling.period)
    step = controller.order * speed * bench.sampling.period
    size = controller.period * controller.gain * float(np.mean(error[-turn:])) / (2.0 * sin(0.5 * step))
    late = step * (len(run.time) - 0.5) + (controller.phase if speed > 0.0 else -controller.phase)
    return -size * sin(late), size * cos(late)
