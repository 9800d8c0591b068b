"""The hysteresis loop of a gear whose law has friction or memory."""

from typing import Any

from ....study.analysis.gear_studies import GearLoop
from ...figures.plots import BLACK, BLUE, ORANGE
from ...figures.svg import Panel, figure
from ...units import sizes
from ...view import View


class Hysteresis:
    """The datasheet's measurements on the law, and the loop of the case with the largest error."""

    heading = "Hysteresis of the gear"

    def data(self, view: View) -> dict[str, Any]:
        """Hysteresis loss and lost motion; None without a loop."""
        loop = view.analysis.loop
        return {"hysteresis": None if loop is None else _loop_data(loop)}

    def figures(self, view: View) -> list[str]:
        """The loop at full load and at 4 % of it, and that of the steady motion."""
        loop, factor, torsion = view.analysis.loop, view.angle.factor, f"torsion ({view.angle.name})"
        if loop is None:
            return []
        left = Panel("input locked, torque slowly 0, +T, −T, +T", torsion, "torque (N·m)")
        left.line(loop.full.torsion * factor, loop.full.torque, BLUE, "full load")
        left.line(loop.small.torsion * factor, loop.small.torque, ORANGE, "4 % of full load", width=2.2)
        panels, cycles = [left], [case.cycle for case in view.analysis.cases if case.cycle is not None]
        if cycles:
            cycle = max(cycles, key=lambda c: c.peak)
            right = Panel("steady motion, largest |x| of the cases", torsion, "torque in the gear (N·m)")
            right.line(cycle.u * factor, cycle.torque, BLACK, "steady motion, damping included", width=1.3)
            panels.append(right)
        return [figure([panels], 300.0, "hysteresis loop")]


def _loop_data(loop: GearLoop) -> dict[str, Any]:
    return {
        "full_load_Nm": loop.torque,
        "full_load_is_rated": loop.rated,
        **sizes(loop.full.loss, "hysteresis_loss"),
        "torsion_from_end_to_end_rad": loop.full.span,
        "dissipated_J_per_cycle": loop.full.energy,
        **sizes(loop.small.span, "lost_motion"),
    }
