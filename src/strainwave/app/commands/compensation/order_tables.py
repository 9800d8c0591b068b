"""Order tables of a controller: the angle or the torque that it adds, as drives and controls read them."""

from math import atan2, cos, hypot, pi, sin
from typing import Any

import numpy as np

from ....files.order_tables.order_table import OrderTable
from ....model.controllers.adaptive import AdaptiveCancellation
from ....model.controllers.feedforward import AngleFeedforward, TorqueTable
from ....model.excitation import Line
from ....numerics.sampled.loops import run_loop
from ....numerics.sampled.result import LoopRun
from ....study.compensation.bench import Bench
from ....study.compensation.designs import COMPENSATORS
from ....study.compensation.gains import behind_of, times_of
from ....study.compensation.result import Compensation
from ....theory.lyapunov import mean_torque
from ....units import RPM


def tables_of(bench: Bench, found: Compensation) -> dict[str, OrderTable]:
    """Tables of a controller by what they are added to, "angle" or "torque"; of one that adapts, what it has found.

    A torque holds at the speed of the result alone, in its direction and under the mean torque on its load.
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
        tables["angle"] = OrderTable.of(controller.error, **about)
    if isinstance(controller, TorqueTable):
        tables["torque"] = OrderTable.of(controller.table, delay=controller.lead, **held)
    elif lines:
        tables["torque"] = OrderTable.of(lines[::-1], unit="N*m", **held)
    return tables


def _adapted(bench: Bench, found: Compensation) -> LoopRun:
    """Run until the controller has converged."""
    design = COMPENSATORS[found.name]
    settle, _ = times_of(bench, found.speed, design.adapts(bench, found.speed) if design.adapts else 0.0)
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
