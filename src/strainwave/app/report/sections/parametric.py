"""The torsion of the gear itself: its hysteresis loop, and the resonances of a stiffness that varies."""

from typing import Any

from ....plot.colours import BLACK, BLUE
from ....plot.panels import Axis, Panel
from ....plot.svg import figure
from ....study.gear.parametric import ParametricResonance
from ...view import View, sizes


class ParametricResonances:
    """Speeds at which a varying stiffness makes small motions grow."""

    heading = "Parametric resonances"

    def data(self, view: View) -> dict[str, Any]:
        """A row for each in the range."""
        return {
            "parametric_resonances": [_row(view, r) for r in view.analysis.parametric],
            "stiffness_varies": view.project.stiffness is not None,
        }


def _row(view: View, r: ParametricResonance) -> dict[str, Any]:
    return {
        **view.place(r.omega),
        "cause": r.cause.replace("omega_0", "ω₀"),
        "growth_per_s": r.growth,
        "unstable": r.unstable,
        "low_rad_per_s": r.low,
        "high_rad_per_s": r.high,
        "low_rpm": view.speeds.rpm(r.low),
        "high_rpm": view.speeds.rpm(r.high),
        "damping_ratio": r.damping_ratio,
        "damping_needed": r.damping_needed,
    }


class Hysteresis:
    """The datasheet's measurements on the law, and the loop of the case with the largest error."""

    heading = "Hysteresis of the gear"
    template = "hysteresis.html.j2"
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
