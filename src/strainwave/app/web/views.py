"""What the page shows of a project, as plain data in the units of the user: rpm of the motor, arcsec, N*m, s."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ...files.notes import load_remark
from ...files.project import Project
from ...files.variants.replaced import replaced, tuning
from ...numerics.integration.methods import Dopri5
from ...numerics.integration.simulate import simulate
from ...results import SolveError
from ...study.analysis.avoid import without_stable
from ...study.analysis.drive_response import DriveResponse
from ...study.compensation.compensate import compensate
from ...study.move.demands import MotorLimits
from ...study.move.move import move
from ...study.move.profiles import SCurve
from ...study.response.resonances import operating_point
from ...study.speed_map.speed_map import speed_map
from ...units import ARCSEC, RPM
from ..units import finding_data
from .curve import solved

Progress = Callable[[str, float], None]
TURNS, SETTLE, SAMPLES = 12, 60, 96  # shown periods, periods before, samples of one
MOST_SHOWN = 4000  # samples of a run
HELD = (
    "The motor is ideally held at its speed; this drive has no loop, gravity or hysteresis; they change the answer. "
    "The page adds a loop and gravity, a project file hysteresis."
)
USUAL_MOVE = SCurve(np.pi / 2.0, 0.6)


def response(project: Project, whole: bool = False) -> dict[str, Any]:
    """Oscillation and torque over the speed, with stability, folds, jumps, bands to avoid and limits."""
    found, own, scale = solved(project, whole)
    speeds, curve = project.speeds, found.curve
    visited = found.visited()
    top = visited[int(np.argmax(found.oscillation[visited]))]
    sweep, limit, motor_limits = found.response.sweep, project.limit, project.motor_limits or MotorLimits()
    unstable = [(low * scale, high * scale) for low, high in without_stable(found.response)]
    low, high = project.load_torques
    judged = own.judged(found, round(speeds.scale / scale))
    motor, torque = judged.motor, found.usage.peak_torque
    limits = [one for one in _torque_limits(project) if one["name"] != "rated torque"]
    carried = judged.used.peak_torque
    exceeded = next((one | {"reached": carried} for one in limits if carried > one["torque"]), None)
    return {
        "title": project.title,
        "speed_name": speeds.name,
        "speed_unit": speeds.unit,
        "error_name": found.name,
        "speed": scale * found.omega,
        "oscillation_arcsec": found.oscillation / ARCSEC,
        "peak_arcsec": found.peak / ARCSEC,
        "torque": found.torque,
        "mean_torque": found.mean_torque,
        "stable": found.stable,
        "folds": [{"speed": scale * fold.omega, "oscillation_arcsec": _at(found, fold.omega)} for fold in curve.folds],
        "jumps": []
        if sweep is None
        else [{"low": scale * b.low, "high": scale * b.high, "whole": b.whole} for b in sweep.bands],
        "avoid": [(low * scale, high * scale) for low, high in judged.verdict.speeds],
        "unstable": unstable,
        "limit_arcsec": None if limit is None else limit / ARCSEC,
        "largest": {
            "speed": float(scale * found.omega[top]),
            "oscillation_arcsec": float(found.oscillation[top] / ARCSEC),
            "torque": torque,
        },
        "torque_limits": _torque_limits(project),
        "torque_exceeded": exceeded,
        "load_torques": [low, project.mean_load_torque, high],
        "passes": judged.passes,
        "failures": list(judged.failures),
        "limits": [finding_data(one) for one in judged.findings],
        "required_motor": None
        if motor is None
        else {
            "torque": motor.torque, "holding_torque": motor.holding, "speed": scale * motor.at,
            "largest_speed": speeds.scale * speeds.given[-1], "max_torque": motor_limits.torque,
            "max_speed": motor_limits.speed * speeds.scale,
        },
        "message": found.message,
        "remarks": [
            *([HELD] if project.train is None and project.motor == "held" else []),
            *judged.remarks,
            *project.notes,
            *load_remark(project),
        ],
        "whole": whole,
    }  # fmt: skip


def _at(found: DriveResponse, omega: float) -> float:
    return float(found.oscillation[int(np.argmin(np.abs(found.omega - omega)))] / ARCSEC)


def _torque_limits(project: Project) -> list[dict[str, Any]]:
    gear = project.gear
    named = {"rated torque": project.rated_torque}
    if gear is not None:
        named |= {"repeated peak torque": gear.repeated_peak_torque, "momentary torque": gear.momentary_torque}
    return [{"name": name, "torque": value} for name, value in named.items() if value is not None]


def motion(project: Project, rpm: float) -> dict[str, Any]:
    """The error over time and its phase portrait at a speed, after the transient has died away."""
    scale = project.speeds.scale
    omega = rpm / scale
    low, high = project.speeds.limits
    if not 0.2 * low <= omega <= 5.0 * high:
        unit = project.speeds.unit
        raise ValueError(
            f"a speed of {rpm:g} {unit} is far outside the range of the project; write one between "
            f"{0.2 * low * scale:.4g} and {5.0 * high * scale:.4g} {unit}"
        )
    system: Any = project.system(omega, reduced=True)
    period = 2.0 * np.pi / omega
    t = np.linspace(0.0, (SETTLE + TURNS) * period, (SETTLE + TURNS) * SAMPLES + 1)
    start = operating_point(system).start
    run = simulate(system, start, t, method=Dopri5(rtol=1e-7, atol=1e-11))
    if not run.status:
        raise SolveError(f"the motion at {rpm:g} {project.speeds.unit} could not be integrated: {run.status}")
    late = run.t >= SETTLE * period * (1.0 - 1e-12)
    poincare = np.flatnonzero(late)[::SAMPLES]
    x, v = run.y[0] / ARCSEC, run.y[1] / ARCSEC
    every = max(1, len(t) // MOST_SHOWN)
    return {
        "speed": rpm,
        "transient": {"time": run.t[::every], "error_arcsec": x[::every]},
        "time": run.t[late] - run.t[late][0],
        "error_arcsec": x[late],
        "rate_arcsec_per_s": v[late],
        "poincare": {"error_arcsec": x[poincare], "rate_arcsec_per_s": v[poincare]},
        "remarks": [
            f"from rest at the operating point; the steady part is after {SETTLE} periods of the base angle, "
            f"points once in each of the last {TURNS}",
            *([f"the error equation leaves out {', '.join(project.left_out)}"] if project.left_out else []),
        ],
    }


def moved(project: Project) -> dict[str, Any]:
    """The project's move, or a quarter turn in 0.6 s."""
    found = move(project, None if project.move is not None else USUAL_MOVE)
    every = max(1, len(found.time) // MOST_SHOWN)
    usual = [] if project.move is not None else ["the project has no move: a quarter turn in 0.6 s along an S-curve"]
    return {
        "time": found.time[::every],
        "reference_deg": np.degrees(found.reference)[::every],
        "error_arcsec": found.pointing_error[::every] / ARCSEC,
        "motor_torque": found.motor_torque[::every],
        "gear_torque": found.gear_torque[::every],
        "motor_speed": found.motor_speed[::every] / RPM,
        "duration": found.duration,
        "settling_time": found.settling_time,
        "window_arcsec": found.window / ARCSEC,
        "peak_arcsec": found.peak_error / ARCSEC,
        "rms_arcsec": found.rms_error / ARCSEC,
        "passes": found.within_limits,
        "failures": list(found.failures),
        "limits": [finding_data(one) for one in found.findings],
        "remarks": [*usual, *(w for w in found.warnings if w not in found.failures), *map(str, found.remarks)],
    }


def mapped(project: Project, search: bool, progress: Progress) -> dict[str, Any]:
    """The speed map with the Campbell diagram, under five loads; `search` looks for motions apart from the curves."""
    low, high = project.load_torques
    rated = project.rated_torque or 0.0
    loads = np.linspace(low, high, 5) if low < high else np.unique([high, -0.25 * rated, -0.5 * rated, -rated])
    found = speed_map(project, loads=loads, search=search, threads=1, progress=progress)
    return {
        "speed": found.speeds / RPM,
        "load": found.loads,
        "load_name": found.load_name,
        "load_unit": found.load_unit,
        "oscillation_arcsec": found.oscillation / ARCSEC,
        "torque": found.torque,
        "forbidden": [band / RPM for band in found.forbidden],
        "allowed": found.windows / RPM,
        "lines": [
            {
                "load": line.load, "order": line.order, "mode": line.mode, "excited": line.excited,
                "speed": line.speed / RPM, "amplitude_arcsec": line.amplitude / ARCSEC,
            }
            for line in found.lines
        ],
        "rule": found.rule,
        "failures": list(found.failures),
        "remarks": list(found.remarks),
    }  # fmt: skip


def compensated(project: Project, progress: Progress) -> dict[str, Any]:
    """The error before and after compensation at the drive's worst speed."""
    found = compensate(project, robust=False, progress=progress)
    return {
        "title": found.title,
        "speed": found.speed / RPM,
        "before": _residual(found.before),
        "after": _residual(found.after),
        "remarks": list(map(str, getattr(found, "warnings", ()))),
    }


def _residual(residual: Any) -> dict[str, float]:
    return {f"{name}_arcsec": value / ARCSEC for name, value in residual._asdict().items()}


def two_parameters(project: Project, axes: list[tuple[str, list[str]]], progress: Progress) -> dict[str, Any]:
    """Largest oscillation over two numbers of the project, row by row; points without a motion are None."""
    (first, across), (second, along) = axes
    rows: list[list[float | None]] = []
    why: dict[str, int] = {}
    for i, b in enumerate(along):
        row: list[float | None] = []
        for j, a in enumerate(across):
            progress("two-parameter map", (i * len(across) + j) / (len(across) * len(along)))
            try:
                found = solved(replaced(project, {first: a, second: b}, retune=True)).found  # as a slider does
                row.append(float(np.max(found.oscillation[found.visited()]) / ARCSEC))
            except (ValueError, SolveError) as error:
                row.append(None)
                why[str(error)] = why.get(str(error), 0) + 1
        rows.append(row)
    missing = [f"{count} points have no value: {sentence}" for sentence, count in why.items()]
    return {
        "axes": [{"name": first, "values": across}, {"name": second, "values": along}],
        "largest_oscillation_arcsec": rows,
        "remarks": [*filter(None, [tuning(project, (first, second), True)]), *missing],
    }
