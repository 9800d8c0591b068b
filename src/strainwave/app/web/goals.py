"""Remedies: numbers that meet the limit, gains of the motor's loop, a controller."""

import math
from collections.abc import Callable
from functools import cache, partial
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.optimize import brentq

from ...base.number_text import unit_text
from ...base.results import SolveError
from ...base.terminal import Progress
from ...base.units import ARCSEC
from ...drive.drive_response import DriveResponse
from ...drive.loops.loop_curves import loop_curves
from ...drive.project import Project
from ...files.variants.replaced import replaced
from ...study.compensation.compensate import benches_of, compensate
from ...study.compensation.gains import learning_rate, times_of
from ...study.tuning.result import gain_unit
from ...study.tuning.tune import tune
from ..console import number
from ..console.library_words import without_calls
from .parameters import parameters
from .requests import Refused
from .state import yaml_of
from .views import sentences, solved

AT_RESONANCE = (
    "Simulated at the speed where the strongest order excites the resonance of the load on the gear (motor held), "
    "under the mean load torque."
)
SHOWN_TURNS = 4  # of the motor, under a controller
STEPS = 5  # to each end of a slider
SHARP = 1e-3  # relative distance of a value from the one that meets the limit


def goal(project: Project, name: str) -> dict[str, Any]:
    """The value of a number at which the largest oscillation is the limit: the nearest on its slider.

    None where the search, in steps to both ends of the slider, meets no such value, or one that rounding leaves above.
    """
    row = next((one for one in parameters(project) if one["name"] == name), None)
    if row is None or not row["log"]:
        raise Refused(f"{name!r} is not a positive number of this project")
    if project.limit is None:
        raise Refused("the project has no limit of the oscillation; add one")
    excess = cache(partial(_excess, project, name, row["unit"]))
    now, ends = math.log(row["value"]), (math.log(row["low"]), math.log(row["high"]))
    crossings = [value for end in ends if (value := _crossing(excess, now, end)) is not None]
    nearest = min(crossings, key=lambda value: abs(math.log(value) - now), default=None)
    return {"name": name, "value": nearest, "unit": row["unit"]}


def _excess(project: Project, name: str, unit: str, x: float) -> float:
    """Logarithm of the largest oscillation over the limit, of the number exp(x); infinite where there is no motion."""
    try:
        motions = solved(replaced(project, {name: f"{math.exp(x)!r} {unit}".strip()}, retune=True))
        return math.log(float(motions.oscillation[motions.top]) / (project.limit or math.inf))
    except (ValueError, SolveError):  # no drive, or none with a motion
        return math.inf


def _crossing(excess: Callable[[float], float], begin: float, end: float) -> float | None:
    """The first number on the way, of four digits, that meets the limit beside one that does not; None without one."""
    for x, y in pairwise(begin + (end - begin) * step / STEPS for step in range(STEPS + 1)):
        before, after = excess(x), excess(y)
        if math.isfinite(before) and math.isfinite(after) and (before <= 0.0) != (after <= 0.0):
            return _met(excess, x, y)
    return None


def _met(excess: Callable[[float], float], begin: float, end: float) -> float | None:
    """The last number within the limit on the way to the crossing, rounded away from that; None if this is above."""
    good, bad = (begin, end) if excess(begin) <= 0.0 else (end, begin)
    met = [good]

    def kept(y: float) -> float:
        if excess(y) <= 0.0:
            met.append(y)
        return excess(y)

    brentq(kept, begin, end, xtol=SHARP, rtol=SHARP)
    exact = math.exp(min(met, key=lambda y: abs(y - bad)))
    digit = 10.0 ** (math.floor(math.log10(exact)) - 3)
    value = float(f"{digit * (math.floor if good < bad else math.ceil)(exact / digit):.4g}")
    return value if excess(math.log(value)) <= 0.0 else None


def tuned(project: Project, progress: Progress) -> dict[str, Any]:
    """The gains of the loop that make the pointing error small, before and after, and the project that has them."""
    result = tune(project, progress=progress)
    points = {"file": result.before, "rule": result.rule, "recommended": result.recommended}
    size = [number(point.pointing / ARCSEC, project.digits()) for point in (result.before, result.recommended)]
    binds = [f"limit reached: {', '.join(result.binding)}"] if result.binding else []
    return {
        "said": sentences([f"largest oscillation {' → '.join(size)} arcsec with the recommended gains", *binds]),
        "gains": {name: unit_text(gain_unit(result.control, name)) for name in result.gains},
        "points": [
            {
                "name": name, "gains": point.gains, "oscillation_arcsec": point.pointing / ARCSEC,
                "compliance_arcsec_per_N_m": point.figures.compliance / ARCSEC, "settling_s": point.figures.settling,
                "move_settling_s": point.move_settling,
                "peak_sensitivity": point.figures.peak_sensitivity, "gain_margin": point.figures.gain_margin,
                "phase_margin_deg": math.degrees(point.figures.phase_margin), "motor_torque": point.motor_torque,
            }
            for name, point in points.items()
        ],
        "speed_unit": project.speeds.unit,
        "steps": {"before": _steps(project), "after": _steps(result.applied(project))},
        "before": _curve(result.response_before, project.speeds.scale),
        "after": _curve(result.response_after, project.speeds.scale),
        "limit_arcsec": None if project.limit is None else project.limit / ARCSEC,
        "project": yaml_of(result.applied(project)),
        "numbers": without_calls(str(result)),
        "remarks": result.remarks,
    }  # fmt: skip


def _steps(project: Project) -> dict[str, Any]:
    """Speed of the load after a step of the reference, angle after one of torque, over the time; empty if unstable."""
    assert project.loop is not None  # one that is tuned
    found = loop_curves(project.loop)
    return {"time": found.time, "reference": found.speeds[1], "torque": found.angles[1] / ARCSEC}


def compensated(project: Project, progress: Progress) -> dict[str, Any]:
    """The error before and after compensation, what is assumed, and the error on other gears."""
    result = compensate(project, progress=progress)
    (bench,) = benches_of(project).values()
    bench, turn = bench.at_speed(result.speed), 2.0 * np.pi / abs(result.speed)
    settle, _ = times_of(bench, result.speed, learning_rate(bench, result.speed, result.controller))
    controllers, duration = (bench.loop, result.controller), settle + SHOWN_TURNS * turn
    runs = [bench.run(controller, result.speed, duration) for controller in controllers]
    last = runs[0].time >= settle
    torque = f"motor torque up to {number(result.torque.peak, 3)} N·m"
    not_counted = [f"this result is excluded: {result.excluded}"] if result.excluded else []
    grows = [] if result.stable or result.excluded else ["the error grows"]
    at = f"{result.title}, at {result.axis.said(result.speed)}: {result.rms_text}"
    return {
        "said": sentences([at, *map(str, result.robustness), torque, *not_counted, *grows]),
        "time": runs[0].time[last] - settle,
        "before_arcsec": runs[0].error[last] / ARCSEC,
        "after_arcsec": runs[1].error[last] / ARCSEC,
        "speed": result.axis.scale * result.speed,
        "speed_unit": result.axis.unit,
        **{
            name: {f"{key}_arcsec": value / ARCSEC for key, value in getattr(result, name)._asdict().items()}
            for name in ("before", "after")
        },
        "torque": result.torque.peak,
        "stable": result.stable,
        "excluded": result.excluded,
        "other_gears": [
            {"stiffness": r.stiffness, "before_rms_arcsec": r.before / ARCSEC, "after_rms_arcsec": r.after / ARCSEC}
            for r in result.robustness
        ],
        "numbers": without_calls(str(result)),
        "assumed": [AT_RESONANCE, *map(without_calls, result.remarks)],
        "remarks": [*result.warnings, result.condition],
    }


def _curve(response: DriveResponse | None, scale: float) -> dict[str, Any] | None:
    if response is None:
        return None
    stable = np.where(response.stable, response.oscillation / ARCSEC, np.nan)
    return {"speed": scale * response.omega, "oscillation_arcsec": stable}
