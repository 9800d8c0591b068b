"""Torsion of the gear itself: its hysteresis loop, and the resonances of a stiffness that varies."""

from typing import Any

from ....plot.panels import BLACK, BLUE, Axis, Panel
from ....plot.svg import figure
from ....theory.parametric import ParametricResonance
from ...view import View, sizes
from ..section import Part, Table

HILL = (
    "Speeds at which the stiffness varies at 2/n times the natural frequency (Hill's equation). Small vibrations about "
    "the operating point grow where the growth rate is positive."
)
LOOPS = (
    "Left: datasheet measurement at full load; the hysteresis loss is the width of the loop at zero torque. Right: "
    "lost motion. Below: loop of the motion with the largest error; its area is the energy lost per cycle."
)
MEETS_NONE = "The varying stiffness excites no parametric resonance in the speed range."


def parametric_resonances(view: View) -> Part:
    """Speeds at which a varying stiffness makes small motions grow: a row for each in the range."""
    rows, varies = [_row(view, r) for r in view.analysis.parametric], view.project.stiffness is not None
    columns = "cause omega_rad_per_s unstable growth_per_s low_rad_per_s high_rad_per_s damping_ratio damping_needed"
    data = {"parametric_resonances": rows, "stiffness_varies": varies}
    sentence = HILL if rows else MEETS_NONE * varies
    return Part("Parametric resonances", data, [sentence], [Table(rows, columns)])


def _row(view: View, r: ParametricResonance) -> dict[str, Any]:
    return {
        **view.speed_data(r.omega),
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


def hysteresis(view: View) -> Part:
    """The datasheet's measurements on the law, and the loop of the case with the largest error.

    Of a gear without a loop there is no text: its data say so.
    """
    loop, torsion, torque = view.analysis.loop, view.angle.axis("torsion"), Axis("torque", "N*m")
    if loop is None:
        return Part(data={"hysteresis": None})
    data = {
        "full_load_Nm": loop.torque,
        "full_load_is_rated": loop.rated,
        **sizes(loop.full.loss, "hysteresis_loss"),
        "torsion_from_end_to_end_rad": loop.full.span,
        "dissipated_J_per_cycle": loop.full.energy,
        **sizes(loop.small.span, "lost_motion"),
    }
    rows: list[list[Panel]] = [[]]
    small = "the same up to ±4 % of the torque T"
    for title, side in (("input locked, torque slowly 0, +T, −T, +T", loop.full), (small, loop.small)):
        rows[0].append(Panel(title, torsion, torque))
        rows[0][-1].line(side.torsion, side.torque, BLUE)
    if cycles := [case.cycle for case in view.analysis.cases if case.cycle is not None]:
        cycle = max(cycles, key=lambda c: c.peak)
        below = Panel("steady motion with the largest |x|, damping included", torsion, torque)
        below.line(cycle.u, cycle.torque, BLACK, width=1.3)
        rows.append([below])
    rated = "the rated torque" if loop.rated else "the largest torque of the steady motions"
    drawn = figure(rows, 260.0, "hysteresis loop"), f"Full load is {rated}. {LOOPS}"
    return Part("Hysteresis of the gear", {"hysteresis": data}, tables=[Table([data])], figures=[drawn], appendix=True)
