"""Reduction of the error at the resonance by controllers of the motor."""

from typing import TYPE_CHECKING, Any

from ....plot.svg import figure
from ...view import View, sizes, speed_data
from ..section import Part, Table

if TYPE_CHECKING:
    from ....study.compensation.result import Compensation as Found

TURNS = "Two turns of the {}, after the transients have decayed, at {}."
BLIND, SEEING = "inverse", "adaptive-inverse"  # without and with an encoder on the load


def compensation(view: View) -> Part:
    """The plain loop, the linear inverse, and one that also adapts to the load's encoder, at the resonance.

    Errors before and after, torque, and the same on other gears; None without a group `controller`.
    """
    heading, speeds = "Error reduction by controllers", view.project.speeds
    if view.project.sampling is None:
        return Part(data={"compensation": None})
    from ....plot.compensation import error_panels, motion
    from ....study.compensation.bench import steady_bench_of
    from ....study.compensation.compensate import compensate

    try:
        bench, results = steady_bench_of(view.project), [compensate(view.project, name) for name in _names(view)]
    except ValueError as error:
        sentences = [f"compensation was not computed: {error}"]
        data = {"not_computed": str(error), "controllers": [], "remarks": []}
        return Part(heading, {"compensation": data}, sentences, lines=sentences)
    controllers, first = [_controller_row(result) for result in results], results[0]
    speed, before = first.axis.said(first.speed), sizes(first.before.rms, "rms_before")
    remarks = list(dict.fromkeys(text for result in results for text in (*result.warnings, *result.remarks)))
    body = {"not_computed": "", "speed": speed, **speed_data(speeds, first.speed), **before, "controllers": controllers}
    others = [{"controller": c["title"]} | gear for c in controllers for gear in c["other_gears"]]
    plain = motion(bench, "loop", first.speed, "plain loop")
    panels = error_panels(plain, [motion(bench, name, first.speed, name) for name in _names(view)])
    return Part(
        heading,
        {"compensation": body | {"remarks": remarks}},
        tables=[
            Table(controllers, "title rms_after_rad reduction_dB peak_torque_Nm stable excluded"),
            Table(others, "controller stiffness rms_before_rad rms_after_rad", "With a different gear stiffness"),
        ],
        notes=remarks,
        figures=[(figure([panels], 180.0, "pointing error before and after"), TURNS.format(speeds.base, speed))],
        lines=[f"controller {result.name} at {speed}: {result.rms_text}" for result in results],
    )


def _names(view: View) -> tuple[str, ...]:
    seeing = view.project.sampling is not None and view.project.sampling.load_encoder
    return (BLIND, SEEING) if seeing else (BLIND,)


def _controller_row(result: "Found") -> dict[str, Any]:
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
