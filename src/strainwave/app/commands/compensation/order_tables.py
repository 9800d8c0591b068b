"""Order tables of a controller: the angle or the torque that it adds, as drives and controls read them."""

from math import atan2, hypot
from typing import Any

from ....files.order_tables.order_table import OrderTable
from ....model.controllers.adaptive import AdaptiveCancellation
from ....model.controllers.feedforward import AngleFeedforward, TorqueTable
from ....model.excitation import Line
from ....numerics.sampled.loops import run_loop
from ....study.compensation.bench import Bench
from ....study.compensation.designs import COMPENSATORS
from ....study.compensation.gains import times_of
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
    memory: Any = _adapted(bench, found) if isinstance(controller, AdaptiveCancellation) else None
    while isinstance(controller, AdaptiveCancellation):
        memory, a, b, _ = memory
        lines.append(Line(controller.order, hypot(a, b), atan2(-b, a)))
        controller = controller.loop
    if isinstance(controller, AngleFeedforward):
        tables["angle"] = OrderTable.of(controller.error, **about)
    if isinstance(controller, TorqueTable):
        tables["torque"] = OrderTable.of(controller.table, delay=controller.lead, **held)
    elif lines:
        tables["torque"] = OrderTable.of(lines[::-1], unit="N*m", **held)
    return tables


def _adapted(bench: Bench, found: Compensation) -> Any:
    """Memory of the controller when it has converged."""
    design = COMPENSATORS[found.name]
    settle, _ = times_of(bench, found.speed, design.adapts(bench, found.speed) if design.adapts else 0.0)
    run = run_loop(bench.closed(found.controller, found.speed), settle, y0=bench.start(found.speed), every=1000)
    return run.memory.state
