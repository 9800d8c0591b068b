"""Reduction of the error by a controller, where the project file has a controller."""

from collections.abc import Iterable
from typing import Any

from ....base.units import RPM
from ....plot.compensation import error_panels, motion
from ....plot.svg import figure
from ....study.compensation.bench import steady_bench_of
from ....study.compensation.compensate import compensate
from ....study.compensation.result import Compensation as Found
from ...console import number
from ...view import View, sizes

BLIND, SEEING = "inverse", "adaptive-inverse"  # without and with an encoder on the load


class Compensation:
    """The plain loop, the linear inverse, and one that also adapts to the load's encoder, at the resonance."""

    heading = "What a controller can take away"

    def data(self, view: View) -> dict[str, Any]:
        """Errors before and after, torque, and the same on other gears; None without a group `controller`."""
        if view.project.sampling is None:
            return {"compensation": None}
        try:
            results = [compensate(view.project, name) for name in _names(view)]
        except ValueError as error:
            return {"compensation": {"not_computed": str(error), "controllers": [], "remarks": []}}
        controllers = [_row(result) for result in results]
        first = results[0]
        place = {"motor_speed_rpm": first.speed / RPM, **sizes(first.before.rms, "rms_before")}
        remarks = list(dict.fromkeys(text for result in results for text in (*result.warnings, *result.remarks)))
        return {"compensation": {"not_computed": "", **place, "controllers": controllers, "remarks": remarks}}

    def figures(self, view: View) -> list[str]:
        """The error over two turns of the motor, before and after."""
        if view.project.sampling is None:
            return []
        try:
            bench, speed = steady_bench_of(view.project), compensate(view.project, BLIND, robust=False).speed
        except ValueError:
            return []
        before = motion(bench, "loop", speed, "plain loop")
        panels = error_panels(before, [motion(bench, name, speed, name) for name in _names(view)])
        return [figure([panels], 240.0, "pointing error before and after")]

    def lines(self, _view: View, data: dict[str, Any]) -> Iterable[str]:
        """One line for each controller."""
        compensation = data["compensation"]
        if not compensation:
            return
        if compensation["not_computed"]:
            yield f"compensation was not computed: {compensation['not_computed']}"
        for c in compensation["controllers"]:
            yield (
                f"controller {c['name']} at {number(compensation['motor_speed_rpm'])} rpm: rms of the pointing error "
                f"{number(compensation['rms_before_arcsec'], 3)} → {number(c['rms_after_arcsec'], 3)} arcsec"
            )


def _names(view: View) -> tuple[str, ...]:
    seeing = view.project.sampling is not None and view.project.sampling.load_encoder
    return (BLIND, SEEING) if seeing else (BLIND,)


def _row(result: Found) -> dict[str, Any]:
    return {
        "name": result.name,
        "title": result.title,
        **sizes(result.after.rms, "rms_after"),
        "reduction_dB": result.reduction,
        "peak_torque_Nm": result.torque.peak,
        "stable": result.stable,
        "excluded": result.excluded,
        "other_gears": [
            {"stiffness": r.stiffness, **sizes(r.before, "rms_before"), **sizes(r.after, "rms_after")}
            for r in result.robustness
        ],
    }
