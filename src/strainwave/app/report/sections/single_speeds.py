"""Single speeds in time: from rest to the steady motion, its torque and energies, multiple scales beside it."""

from typing import Any

from ....study.analysis.time_case import TimeCase
from ...figures.plots import time_figure
from ...units import sizes
from ...view import View


class SingleSpeeds:
    """The speeds that the project names, or the main resonances and a place away from them."""

    heading = "Single speeds in time"
    appendix = True

    def data(self, view: View) -> dict[str, Any]:
        """A row for each, and why a part of the analysis is missing."""
        return {"cases": [_case(view, case) for case in view.analysis.cases], "remarks": list(view.analysis.remarks)}

    def figures(self, view: View) -> list[str]:
        """A figure for each."""
        return [time_figure(case, view.angle) for case in view.analysis.cases]


def _case(view: View, case: TimeCase) -> dict[str, Any]:
    cycle, compared = case.cycle, case.comparison
    theory, simulated = case.amplitudes
    return {
        "name": case.name,
        **view.place(case.omega),
        "regime": str(case.resonance),
        **sizes(case.peak_from_rest if case.transient.status else None, "peak_from_rest"),
        "peak_multiple_scales_rad": compared.peak_theory if compared else None,
        "rms_difference": compared.rms_difference if compared else None,
        "window_s": list(compared.window) if compared else None,
        "component_multiple_scales_rad": theory,
        "component_integration_rad": simulated,
        "steady_periodic": case.steady.closed,
        "status": case.transient.message if not case.transient.status else case.steady.message,
        "reason": case.reason,
        **sizes(None if cycle is None else cycle.peak),
        **sizes(None if cycle is None else cycle.peak_to_peak, "peak_to_peak"),
        "peak_torque_Nm": cycle and cycle.peak_torque,
        "mean_torque_Nm": cycle and cycle.mean_torque,
        "dissipated_J_per_turn": cycle and cycle.dissipated,
        "work_J_per_turn": cycle and cycle.work,
        "loss_W": cycle and cycle.power,
    }
