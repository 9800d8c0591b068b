"""Parametric resonances of a stiffness that varies with the base angle."""

from typing import Any

from ....study.gear.parametric import ParametricResonance
from ...view import View


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
