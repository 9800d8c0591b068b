"""Views of a project for the page, as plain data in the units of the user: rpm of the motor, arcsec, N*m, s."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from ...base.facts import lines
from ...base.results import SolveError
from ...base.sentences import Sentence, Speed, told
from ...base.terminal import Progress
from ...base.units import ARCSEC, RPM
from ...drive.demands.motor_limits import MotorLimits
from ...drive.drive_response import DriveResponse
from ...drive.project import Project
from ...files.notes import curve_remark, load_remark, move_note, unsaid
from ...study.analysis.time_domain.drive_motion import drive_motion
from ...study.analysis.verdict import Judged
from ...study.analysis.verdict_words import ranges
from ...study.move.move import move
from ...study.move.profiles import SCurve
from ...study.speed_map.speed_map import speed_map
from ..console import number
from ..console.library_words import without_calls
from ..curves import beat_facts, ranged, sizes_said, torques_said
from ..view import AngleUnit, angle_unit, writer

POINTS = 40  # about, of the curve that follows a slider
MOST_SHOWN = 4000  # samples of a run
HELD = (
    "The motor is ideal, with constant speed. A real loop can change the oscillation tenfold; gravity and hysteresis "
    "also change the result. Add a loop and gravity on the page, hysteresis in a project file."
)
FIXED_LOAD = (
    "Here the torque on the load is constant. A torque that depends on the load's angle, such as gravity, varies N "
    "times more slowly than the motor turns."
)
USUAL_MOVE = SCurve(np.pi / 2.0, 0.6)
MOVED = "duration_s", "window_rad", "pointing_error_rad"  # of a move: what its view is asked for
IN_ARCSEC = AngleUnit("arcsec", 1.0 / ARCSEC)  # as the pictures have it


def sentences(texts: Iterable[str]) -> str:
    """Lines of results as sentences."""
    return " ".join(f"{text[:1].upper()}{text[1:]}." for text in map(without_calls, texts))


def solved(project: Project, separate: bool = False) -> DriveResponse:
    """The response with machine code; `separate` looks for motions that do not join the curve, too, at more points."""
    return project.response() if separate else project.response(coexisting=False, points=POINTS)


def response(project: Project, separate: bool = False) -> dict[str, Any]:
    """Oscillation and torque over the speed, with stability, folds, jumps, bands to avoid and limits."""
    motions, speeds = solved(project, separate), project.speeds
    judged = project.judged(motions)
    write = writer(project, angle_unit(motions.oscillation[motions.top]), speeds.unit, speeds.scale)
    avoided = [told(Sentence("avoid {}", ranges(band)), write)] if (band := judged.verdict.speeds) else []
    sizes = sizes_said(project, motions, judged.covered, IN_ARCSEC)
    return {
        "said": sentences([*sizes, *lines(beat_facts(project, motions)), *avoided]),
        "torque_said": f"Largest torque: {torques_said(project, judged)}.",
        "title": project.title, "speed_name": speeds.name, "speed_unit": speeds.unit, "error_name": motions.name,
        "passes": judged.passes, "assumed": bool(project.assumed), "failures": told(list(judged.failures), write),
        "message": without_calls(told(motions.message, write)),
        "remarks": [
            f"Results are {curve_remark(separate and motions.curve.beat is None)}.",
            *([HELD] if project.train is None and project.motor == "held" else []),
            *judged.remarks, *unsaid(project.notes, judged.remarks), *move_note(project), *load_remark(project),
        ],
        "whole": separate, "digits": project.digits(),
    } | _curves(project, motions) | _limits(project, judged)  # fmt: skip


def _curves(project: Project, motions: DriveResponse) -> dict[str, Any]:
    """Points of a response, its folds and jumps, and its largest oscillation."""
    scale, curve, top, sizes = project.speeds.scale, motions.curve, motions.top, motions.oscillation / ARCSEC
    speed, bands = scale * motions.omega, motions.sweep.bands if motions.sweep else ()
    folds = ((fold.omega, np.argmin(np.abs(motions.omega - fold.omega))) for fold in curve.folds)
    return {
        "speed": speed, "oscillation_arcsec": sizes, "peak_arcsec": motions.peak / ARCSEC, "torque": motions.torque,
        "mean_torque": motions.mean_torque, "stable": motions.stable,
        "smallest_arcsec": None if curve.beat is None or curve.envelope is None else curve.envelope[:, 1] / ARCSEC,
        "folds": [{"speed": scale * omega, "oscillation_arcsec": sizes[i]} for omega, i in folds],
        "jumps": [{"low": scale * b.low, "high": scale * b.high, "whole": b.whole} for b in bands],
        "largest": {
            "speed": float(speed[top]), "oscillation_arcsec": float(sizes[top]), "torque": motions.usage.peak_torque,
        },
    }  # fmt: skip


def _limits(project: Project, judged: Judged) -> dict[str, Any]:
    """Limits of oscillation, gear and motor, the demand on them, and the speeds that they forbid."""
    speeds, motor, sheet = project.speeds, judged.motor, project.motor_limits or MotorLimits()
    low, high = project.other_loads
    return {
        "avoid": [(low * speeds.scale, high * speeds.scale) for low, high in judged.verdict.speeds],
        "limit_arcsec": None if project.limit is None else project.limit / ARCSEC,
        "torque_limits": _torque_limits(project), "load_torques": [low, project.mean_load_torque, high],
        "limits": [cap.data() for cap in judged.findings],
        "required_motor": None if motor is None else {
            "torque": motor.torque, "holding_torque": motor.holding, "speed": speeds.scale * motor.at,
            "largest_speed": speeds.scale * speeds.given[-1], "max_torque": sheet.most,
            "max_speed": sheet.fastest * speeds.scale,
        },
    }  # fmt: skip


def sureness(project: Project) -> dict[str, Any]:
    """Band of assumed numbers and curve of the held motor, which the page adds to the response after a pause."""
    sure, scale, limit, curve = project.sureness, project.speeds.scale, project.limit, project.held_response(POINTS)
    texts = [*sure.sentences(limit), *([project.loop.weak] if project.loop and project.loop.weak else [])]
    within = limit is not None and sure.largest[1] <= limit and not (sure.load and project.has_memory)
    return {
        "how_sure": [f"{text[:1].upper()}{text[1:]}" for text in texts],
        "together": sure.together(limit) if sure.doubts else "",
        "load": sure.load, "met": within or not sure.doubts,
        "held": None if curve is None else {
            "speed": scale * curve.omega, "oscillation_arcsec": curve.oscillation / ARCSEC,
        },
        "speed": scale * sure.omega,
        "low_arcsec": sure.low / ARCSEC, "high_arcsec": sure.high / ARCSEC,
    }  # fmt: skip


def allowed_under_every_load(project: Project) -> dict[str, Any] | None:
    """Speeds that every torque of the load allows, by the speed map; None where the load has one torque alone."""
    if not ranged(project):
        return None
    try:
        chart = speed_map(project, threads=1)
    except (ValueError, SolveError) as error:
        return {"why": str(error), "passes": None}
    whole = len(chart.windows) == 1 and bool(np.allclose(chart.windows[0], chart.speeds[[0, -1]], rtol=1e-9))
    unknown = whole and project.limit is None
    return {
        "said": sentences([chart.allowed_text]), "allowed": chart.windows * project.speeds.scale, "whole": whole,
        "failures": chart.failures, "passes": None if unknown else whole and not chart.failures,
    }  # fmt: skip


def _torque_limits(project: Project) -> list[dict[str, Any]]:
    gear = project.gear
    named = {"rated torque": project.rated_torque}
    if gear is not None:
        named |= {"repeated peak torque": gear.repeated_peak_torque, "momentary torque": gear.momentary_torque}
    return [{"name": name, "torque": value} for name, value in named.items() if value is not None]


def motion(project: Project, rpm: float) -> dict[str, Any]:
    """The error of the drive over time and its phase portrait at a speed, from rest and settled."""
    scale, unit = project.speeds.scale, project.speeds.unit
    low, high = project.speeds.limits
    if not 0.2 * low <= rpm / scale <= 5.0 * high:
        raise ValueError(
            f"a speed of {rpm:g} {unit} is far outside the range of the project; write one between "
            f"{0.2 * low * scale:.4g} and {5.0 * high * scale:.4g} {unit}"
        )
    run = drive_motion(project, rpm / scale)
    begun, x, v = run.begun, run.error / ARCSEC, run.rate / ARCSEC
    every = max(1, len(begun.t) // MOST_SHOWN)
    low, high = project.load_torques
    write = writer(project, IN_ARCSEC, unit, scale)
    under = f", {number(run.load_torque)} N·m on the load" * (low < high)
    at = Sentence("{} at {}{}: {}", run.name, Speed(run.omega), under, run.sizes_text)
    torque = f"largest torque in the gear {number(run.peak_torque, project.digits())} N·m"
    return {
        "said": sentences([told(at, write) + f", {torque}"]),
        "speed": rpm,
        "error_name": run.name,
        "transient": {"time": begun.t[::every], "error_arcsec": begun.y[0][::every] / ARCSEC},
        "time": run.t,
        "error_arcsec": x,
        "rate_arcsec_per_s": v,
        "poincare": {
            "error_arcsec": x[: -1 : run.per_turn], "rate_arcsec_per_s": v[: -1 : run.per_turn],
        },
        "oscillation_arcsec": run.oscillation / ARCSEC,
        "torque": run.peak_torque,
        "load_torque": run.load_torque,
        "load_torques": [low, high],
        "remarks": [
            f"integrated from rest under the mean torques; shown after the first {run.turns} turns, with one point per "
            "turn; a drive with jumps may settle on another motion from another start",
            *([run.remark] if run.remark else []),
            *([FIXED_LOAD] if low < high else []),
            *([HELD] if project.train is None and project.motor == "held" else []),
        ],
    }  # fmt: skip


def moved(project: Project) -> dict[str, Any]:
    """The project's move, or a quarter turn in 0.6 s."""
    run = move(project, None if project.move is not None else USUAL_MOVE)
    usual = [] if project.move is not None else ["the project has no move; shown: S-curve, 90 deg in 0.6 s"]
    curves = {
        "time": run.time, "reference_deg": np.degrees(run.reference), "error_arcsec": run.pointing_error / ARCSEC,
        "motor_torque": run.motor_torque, "gear_torque": run.gear_torque, "motor_speed": run.motor_speed / RPM,
    }  # fmt: skip
    above = project.limit is not None and run.peak_error > project.limit
    against = [f"the error in the move exceeds the limit of {IN_ARCSEC.text(project.limit or 0.0)}"] if above else []
    answers = [fact for fact in run.facts() if fact.key.partition(".")[0] in MOVED]
    return {name: values[:: max(1, len(run.time) // MOST_SHOWN)] for name, values in curves.items()} | {
        "said": sentences([*lines(answers), *against]),
        "duration": run.duration,
        "settling_time": run.settling_time,
        "window_arcsec": run.window / ARCSEC,
        "rest_arcsec": run.rest_error / ARCSEC,
        "limit_arcsec": None if project.limit is None else project.limit / ARCSEC,
        "most_motor_torque": None if project.motor_limits is None else project.motor_limits.most,
        "peak_arcsec": run.peak_error / ARCSEC,
        "rms_arcsec": run.rms_error / ARCSEC,
        "passes": run.within_limits,
        "failures": list(run.failures),
        "limits": [one.data() for one in run.findings],
        "numbers": without_calls(str(run)),
        "remarks": [*usual, *(w for w in run.warnings if w not in run.failures), *map(str, run.remarks)],
    }


def mapped(project: Project, search: bool, loads: list[float], progress: Progress) -> dict[str, Any]:
    """The speed map under loads [N*m] or those of the project, as `speed_map` takes them.

    `search` looks for motions apart from the curves.
    """
    chart = speed_map(project, loads=loads or None, search=search, threads=1, progress=progress)
    return {
        "speed": chart.speeds * project.speeds.scale,
        "speed_unit": project.speeds.unit, "speed_name": project.speeds.name,
        "load": chart.loads,
        "load_name": chart.load_name,
        "load_unit": chart.load_unit,
        "oscillation_arcsec": chart.oscillation / ARCSEC,
        "torque": chart.torque,
        "forbidden": [band * project.speeds.scale for band in chart.forbidden],
        "allowed": chart.windows * project.speeds.scale,
        "said": sentences([chart.allowed_text]), "rule": chart.rule, "numbers": without_calls(str(chart)),
        "failures": list(chart.failures),
        "remarks": list(chart.remarks),
    }  # fmt: skip
