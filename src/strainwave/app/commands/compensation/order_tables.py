"""Order tables of a controller: the angle or the torque that it adds, as drives and controls read them."""

from math import atan2, hypot
from typing import Any

from ....files.order_tables.order_table import OrderTable
from ....model.controllers.adaptive import AdaptiveCancellation
from ....model.controllers.feedforward import AngleFeedforward, TorqueTable
from ....model.excitation import Line
from ....numerics.sampled.loops import run_loop
from ....study.compensation.bench import Bench
from ....study.compensation.designs import COMPENSATORS, times_of
from ....study.compensation.result import Compensation
from ....units import RPM


def tables_of(bench: Bench, found: Compensation) -> dict[str, OrderTable]:
    """Tables of a controller by what they are added to, "angle" or "torque"; of one that adapts, what it has found.

    A torque holds at the speed of the result alone.
    """
    about = {
        "ratio": bench.model.N,
        "speeds": (found.speed, found.speed),
        "source": f"{found.name} at {found.speed / RPM:.4g} rpm",
    }
    tables: dict[str, OrderTable] = {}
    controller, lines = found.controller, list[Line]()
    memory: Any = _adapted(bench, found) if isinstance(controller, AdaptiveCancellation) else None
    while isinstance(controller, AdaptiveCancellation):
        memory, a, b, _ = memory
        lines.append(Line(controller.order, hypot(a, b), atan2(-b, a)))
        controller = controller.loop
    if isinstance(controller, AngleFeedforward):
        tables["angle"] = OrderTable.of(controller.error, **(about | {"speeds": None}))
    if isinstance(controller, TorqueTable):
        tables["torque"] = OrderTable.of(controller.table, delay=controller.lead, **about)
    elif lines:
        tables["torque"] = OrderTable.of(lines[::-1], unit="N*m", **about)
    return tables


def _adapted(bench: Bench, found: Compensation) -> Any:
    """Memory of the controller when it has converged."""
    design = COMPENSATORS[found.name]
    settle, _ = times_of(bench, found.speed, design.adapts(bench, found.speed) if design.adapts else 0.0)
    run = run_loop(bench.closed(found.controller, found.speed), settle, y0=bench.start(found.speed), every=1000)
    return run.memory.state
