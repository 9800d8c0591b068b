"""The hysteresis loop of a gear whose law has friction or memory."""

from typing import Any

from ....plot.colours import BLACK, BLUE
from ....plot.panels import Axis, Panel
from ....plot.svg import figure
from ...view import View, sizes


class Hysteresis:
    """The datasheet's measurements on the law, and the loop of the case with the largest error."""

    heading = "Hysteresis of the gear"
    appendix = True

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
        loop, torsion, torque = view.analysis.loop, view.angle.axis("torsion"), Axis("torque", "N*m")
        if loop is None:
            return []
        rows: list[list[Panel]] = [[]]
        small = "the same up to 4 % of that torque"
        for title, side in (("input locked, slowly 0, +T, −T, +T", loop.full), (small, loop.small)):
            rows[0].append(Panel(title, torsion, torque))
            rows[0][-1].line(side.torsion, side.torque, BLUE)
        if cycles := [case.cycle for case in view.analysis.cases if case.cycle is not None]:
            cycle = max(cycles, key=lambda c: c.peak)
            below = Panel("steady motion, largest |x| of the cases, damping included", torsion, torque)
            below.line(cycle.u, cycle.torque, BLACK, width=1.3)
            rows.append([below])
        return [figure(rows, 260.0, "hysteresis loop")]
