"""Every number of the report as plain data with its unit."""

import math
from typing import Any

from .. import __version__
from ..study.analysis import Analysis
from ..study.exact import ExactResponse
from ..study.regimes import Regime
from ..study.time_case import TimeCase
from ..theory.slow_results import Certificate
from .facts import ARCSEC, RPM, angle_unit, facts
from .project import Project

NO_STIFFNESS = "the law has no stiffness where the mean torque holds the drive (play), or nothing excites the drive."


def collect(project: Project, analysis: Analysis) -> dict[str, Any]:
    """Gather every number of the report with its unit; None stands for a number that does not exist."""
    proof, largest = analysis.stability, _largest(project, analysis)
    return {
        "strainwave": __version__,
        "title": project.title,
        "project": project.text,
        "motor": project.motor,
        "base_angle": "forcing phase" if project.shaft == "forcing" else "motor (wave-generator) angle",
        "conventions": (
            "x = theta_m/N - theta_l [rad, output side]; peak is the largest |x|, the mean included; amplitudes of "
            "single harmonics are 0-to-peak; omega is the speed of the base angle"
        ),
        "drive": {
            "law": repr(project.drive.law),
            "gear": project.gear.name if project.gear else None,
            "source": project.gear.source if project.gear else None,
            "notes": list(project.gear.notes) if project.gear else [],
            "has_memory": project.has_memory,
        },
        "derived": [fact._asdict() for fact in facts(project, analysis, angle_unit(largest["peak_rad"]))],
        "stability": {
            "holds": proof.holds,
            "scope": proof.scope,
            "claim": proof.claim,
            "region": str(proof.region or "none"),
            "reason": proof.reason,
        },
        "speed_range_rad_per_s": list(analysis.speeds),
        "resonances": [_resonance(project, i, regime) for i, regime in enumerate(analysis.regimes, 1)],
        "resonance_remark": "" if analysis.regimes else NO_STIFFNESS,
        "exact_response": exact_response_data(project, analysis.exact),
        "largest_error": largest,
        "largest_torque": _largest_torque(project, analysis),
        "limits": [
            {"limit": f.limit, "value": f.value, "bound": f.bound, "unit": f.unit, "exceeded": f.exceeded}
            for f in analysis.limits
        ],
        "run_up": _run_up(project, analysis),
        "cases": [_case(project, case) for case in analysis.cases],
    }


def _rpm(project: Project, omega: float) -> float | None:
    return None if project.shaft == "forcing" else omega * RPM


def _resonance(project: Project, index: int, regime: Regime) -> dict[str, Any]:
    curve = regime.response
    folds = [] if curve is None else list(zip(curve.folds, curve.fold_amplitudes, strict=True))
    return {
        "number": index,
        "name": regime.name,
        "order": regime.order,
        "resonance": f"{regime.resonance.p}:{regime.resonance.q}",
        "omega_rad_per_s": regime.omega,
        "motor_speed_rpm": _rpm(project, regime.omega),
        "inside_range": regime.inside,
        "steady_amplitudes_rad": [{"value": s.amplitude, "stable": s.stable} for s in regime.states],
        "existence": regime.existence,
        "certificate": _certificate(regime.certificate),
        "certificate_at_peak": _certificate(regime.at_peak),
        "peak": None
        if curve is None or not curve.branches
        else {
            "omega_rad_per_s": curve.peak[0],
            "motor_speed_rpm": _rpm(project, curve.peak[0]),
            "amplitude_rad": curve.peak[1],
            "amplitude_arcsec": curve.peak[1] * ARCSEC,
        },
        "folds": [
            {
                "omega_rad_per_s": w,
                "motor_speed_rpm": _rpm(project, w),
                "amplitude_rad": a,
                "amplitude_arcsec": a * ARCSEC,
            }
            for w, a in folds
        ],
        "response": "" if curve is None else curve.message,
        "reason": regime.reason,
    }


def _certificate(certificate: Certificate | None) -> dict[str, Any] | None:
    if certificate is None:
        return None
    return {
        "valid": certificate.valid,
        "predicted_error": certificate.predicted_error,
        "error_at_speed": certificate.error_at_speed,
        "speed_error": abs(certificate.frequency_shift),
        "sentence": certificate.sentence,
    }


def exact_response_data(project: Project, exact: ExactResponse) -> dict[str, Any]:
    """Key numbers of the exact response: folds, jumps, accuracy."""
    curve, sweep = exact.curve, exact.sweep
    return {
        "method": exact.method,
        "harmonics": curve.coefficients.shape[1] // 2,
        "last_harmonics_relative": curve.tail,
        "complete": bool(curve.status),
        "message": curve.message,
        "folds": [place(project, fold.omega) | _angle_of("peak", fold.peak) for fold in curve.folds],
        "jump_up": _jump(project, sweep.jump_up if sweep else math.nan),
        "jump_down": _jump(project, sweep.jump_down if sweep else math.nan),
        "hysteresis_rad_per_s": sweep.width if sweep else None,
        "sweep": sweep.sentence if sweep else "no motion on the curve is stable",
    }


def place(project: Project, omega: float) -> dict[str, Any]:
    """Speed of the base angle and of the motor; None where the base angle is a forcing phase."""
    return {"omega_rad_per_s": omega, "motor_speed_rpm": _rpm(project, omega)}


def _angle_of(name: str, rad: float) -> dict[str, Any]:
    return {f"{name}_rad": rad, f"{name}_arcsec": rad * ARCSEC}


def _jump(project: Project, omega: float) -> dict[str, Any] | None:
    return place(project, omega) if math.isfinite(omega) else None


def _largest(project: Project, analysis: Analysis) -> dict[str, Any]:
    """Largest steady |x| that a sweep meets: on the exact curve, or by simulation where there is no such curve."""
    at, worst = analysis.exact.largest(), analysis.run_up.worst()
    curve = analysis.exact.curve
    if at is None or curve.peak[at] < 0.999 * worst.peak:
        return place(project, worst.omega) | _angle_of("peak", worst.peak) | {"method": "integration"}
    here = place(project, float(curve.omega[at]))
    return here | _angle_of("peak", float(curve.peak[at])) | {"method": analysis.exact.method}


def peak_torque(analysis: Analysis) -> tuple[float, float]:
    """Speed [rad/s] and size [N*m] of the largest torque through the gear in any steady motion that was found."""
    return analysis.usage.at_peak, analysis.usage.peak_torque


def _largest_torque(project: Project, analysis: Analysis) -> dict[str, Any]:
    """Largest torque through the gear in a steady motion, beside the gear's limits."""
    omega, torque = peak_torque(analysis)
    gear = project.gear
    return place(project, omega) | {
        "torque_Nm": torque,
        "repeated_peak_torque_Nm": gear.repeated_peak_torque if gear else None,
        "momentary_torque_Nm": gear.momentary_torque if gear else None,
    }


def _run_up(project: Project, analysis: Analysis) -> list[dict[str, Any]]:
    run, rows = analysis.run_up, []
    for direction, motions, exact in (("up", run.up, run.curve_up), ("down", run.down, run.curve_down)):
        for motion, curve in zip(motions, exact, strict=True):
            fine = bool(motion.status)
            rows.append(
                {"direction": direction}
                | place(project, motion.omega)
                | {
                    "peak_rad": motion.peak if fine else None,
                    "peak_arcsec": motion.peak * ARCSEC if fine else None,
                    "exact_peak_rad": float(curve),
                    "amplitude_at_omega_rad": motion.amplitude(1) if fine else None,
                    "periodic": motion.closed,
                    "period_in_turns": motion.period,
                    "message": "" if fine else motion.message,
                }
            )
    return rows


def _case(project: Project, case: TimeCase) -> dict[str, Any]:
    cycle, compared = case.cycle, case.comparison
    theory, simulated = case.amplitudes
    row: dict[str, Any] = {
        "name": case.name,
        "omega_rad_per_s": case.omega,
        "motor_speed_rpm": _rpm(project, case.omega),
        "regime": str(case.resonance),
        "peak_from_rest_rad": case.peak_from_rest if case.transient.status else None,
        "peak_from_rest_arcsec": case.peak_from_rest * ARCSEC if case.transient.status else None,
        "peak_multiple_scales_rad": compared.peak_theory if compared else None,
        "rms_difference": compared.rms_difference if compared else None,
        "window_s": list(compared.window) if compared else None,
        "component_multiple_scales_rad": theory,
        "component_integration_rad": simulated,
        "steady_periodic": case.steady.closed,
        "status": case.transient.message if not case.transient.status else case.steady.message,
        "reason": case.reason,
    }
    names = (
        "peak_rad",
        "peak_to_peak_rad",
        "peak_torque_Nm",
        "mean_torque_Nm",
        "dissipated_J_per_turn",
        "work_J_per_turn",
        "loss_W",
    )
    if cycle is None:
        return row | dict.fromkeys(names) | {"peak_arcsec": None, "peak_to_peak_arcsec": None}
    values = (
        cycle.peak,
        cycle.peak_to_peak,
        cycle.peak_torque,
        cycle.mean_torque,
        cycle.dissipated,
        cycle.work,
        cycle.power,
    )
    in_arcsec = {"peak_arcsec": cycle.peak * ARCSEC, "peak_to_peak_arcsec": cycle.peak_to_peak * ARCSEC}
    return row | dict(zip(names, values, strict=True)) | in_arcsec
