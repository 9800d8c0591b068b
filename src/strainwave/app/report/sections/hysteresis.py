"""The hysteresis loop of a gear whose law has friction or memory."""

from typing import Any

from ...figures.curves import BLACK, BLUE
from ...figures.svg import Panel, figure
from ...view import View, sizes


class Hysteresis:
    """The datasheet's measurements on the law, and the loop of the case with the largest error."""

    heading = "Hysteresis of the gear"

    def data(self, view: View) -> dict[str, Any]:
        """Hysteresis loss and lost motion; None without a loop."""
        loop = view.analysis.loop
        if loop is None:
            return {"hysteresis": None}
        full = {"full_load_Nm": loop.torque, "full_load_is_rated": loop.rated} | sizes(
            loop.full.loss, "hysteresis_loss"
        )
        full |= {"torsion_from_end_to_end_rad": loop.full.span, "dissipated_J_per_cycle": loop.full.energy}
        return {"hysteresis": full | sizes(loop.small.span, "lost_motion")}

    def figures(self, view: View) -> list[str]:
        """The loop at full load and at 4 % of it, and that of the steady motion."""
        loop, factor, torsion = view.analysis.loop, view.angle.factor, f"torsion ({view.angle.name})"
        if loop is None:
            return []
        rows: list[list[Panel]] = [[]]
        for title, side in (("input locked, slowly 0, +T, −T, +T", loop.full), ("the same at 4 % of it", loop.small)):
            rows[0].append(Panel(title, torsion, "torque (N·m)"))
            rows[0][-1].line(side.torsion * factor, side.torque, BLUE)
        if cycles := [case.cycle for case in view.analysis.cases if case.cycle is not None]:
            cycle = max(cycles, key=lambda c: c.peak)
            below = Panel("steady motion, largest |x| of the cases, damping included", torsion, "torque (N·m)")
            below.line(cycle.u * factor, cycle.torque, BLACK, width=1.3)
            rows.append([below])
        return [figure(rows, 260.0, "hysteresis loop")]
