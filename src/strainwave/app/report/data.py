"""Every number of the report as plain data with its unit."""

import math
from typing import Any

from ... import __version__
from ...files.project import Project
from ...results import Status
from ...speeds import Speeds
from ...study.analysis.analysis import Analysis
from ...study.analysis.time_case import TimeCase
from ...study.response.response import ExactResponse
from ...units import ARCSEC, RPM
from ..units import angle_unit
from .facts import facts, natural_frequencies
from .resonances import place, resonances
from .train import run_data

NO_STIFFNESS = (
    "the law has no stiffness where the mean torque holds the drive (backlash), or nothing excites the drive."
)
CONVENTIONS = (
    "x = theta_m/N - theta_l [rad, output side], the error between motor and load; the motor's own deviation from its "
    "reference is not in it; peak is the largest |x|, the mean included; amplitudes of single harmonics are 0-to-peak; "
    "omega is the speed of the base angle"
)


def collect(project: Project, analysis: Analysis) -> dict[str, Any]:
    """Gather every number of the report with its unit; None stands for a number that does not exist."""
    proof, largest = analysis.stability, _largest(project, analysis)
    return {
        "strainwave": __version__,
        "title": project.title,
        "project": project.text,
        "motor": project.motor,
        "base_angle": project.speeds.base_angle,
        "conventions": CONVENTIONS,
        "drive": {
            "law": repr(project.drive.law),
            "gear": project.gear.name if project.gear else None,
            "source": project.gear.source if project.gear else None,
            "notes": list(project.gear.notes) if project.gear else [],
            "has_memory": project.has_memory,
        },
        "natural_frequencies": natural_frequencies(project, analysis),
        "derived": [fact._asdict() for fact in facts(project, analysis, angle_unit(largest["peak_rad"]))],
        "stability": {
            "holds": proof.holds,
            "scope": proof.scope,
            "claim": proof.claim,
            "region": str(proof.region or "none"),
            "reason": proof.reason,
            "obstacle": proof.obstacle,
        },
        "speed_range_rad_per_s": list(analysis.speeds),
        "resonances": resonances(project.speeds, analysis),
        "resonance_remark": "" if analysis.regimes else NO_STIFFNESS,
        "exact_response": exact_response_data(project.speeds, analysis.exact),
        "largest_error": largest,
        "largest_torque": _largest_torque(project, analysis),
        "limits": [
            {"limit": f.limit, "value": f.value, "bound": f.bound, "unit": f.unit, "exceeded": f.exceeded}
            for f in analysis.limits
        ],
        "run_up": _run_up(project, analysis),
        "cases": [_case(project, case) for case in analysis.cases],
    }


def exact_response_data(speeds: Speeds, exact: ExactResponse) -> dict[str, Any]:
    """Key numbers of a response curve: folds, jumps, accuracy."""
    curve, sweep = exact.curve, exact.sweep
    return {
        "method": exact.method,
        "harmonics": curve.coefficients.shape[1] // 2,
        "left_out_relative": curve.tail,
        "complete": curve.status.found,
        "rough": curve.status is Status.TRUNCATED,
        "message": curve.message,
        "folds": [place(speeds, fold.omega) | _angle_of("peak", fold.peak) for fold in curve.folds],
        "jump_up": _jump(speeds, sweep.jump_up if sweep else math.nan),
        "jump_down": _jump(speeds, sweep.jump_down if sweep else math.nan),
        "bands": [
            {
                "low": place(speeds, band.low),
                "high": place(speeds, band.high),
                "jump_up": _jump(speeds, band.jump_up),
                "jump_down": _jump(speeds, band.jump_down),
                "whole": band.whole,
            }
            for band in (sweep.bands if sweep else ())
        ],
        "hysteresis_rad_per_s": sweep.width if sweep else None,
        "sweep": sweep.sentence if sweep else "no motion on the curve is stable",
    }


def _angle_of(name: str, rad: float) -> dict[str, Any]:
    return {f"{name}_rad": rad, f"{name}_arcsec": rad / ARCSEC}


def _jump(speeds: Speeds, omega: float) -> dict[str, Any] | None:
    return place(speeds, omega) if math.isfinite(omega) else None


def _largest(project: Project, analysis: Analysis) -> dict[str, Any]:
    """Largest steady |x| that a sweep meets: on the curve, or by simulation where there is no such curve.

    Of the whole train where there is one: steady, or in the run-up where no motion of it repeats.
    """
    run = _run_instead(analysis)
    if run is not None:
        found = place(project.speeds, run["at_rpm"] * RPM) | _angle_of("peak", run["largest_error_rad"])
        return found | {"method": "integration", "of": "run-up of the whole drive train"}
    of = {"of": "error equation" if analysis.train_curve is None else "whole drive train"}
    at, worst = analysis.response.largest(), analysis.run_up.worst()
    curve = analysis.response.curve
    if analysis.train_curve is None and (at is None or curve.peak[at] < 0.999 * worst.peak):
        return place(project.speeds, worst.omega) | _angle_of("peak", worst.peak) | {"method": "integration"} | of
    assert at is not None
    here = place(project.speeds, float(curve.omega[at]))
    return here | _angle_of("peak", float(curve.peak[at])) | {"method": analysis.response.method} | of


def _run_instead(analysis: Analysis) -> dict[str, Any] | None:
    """The run-up of a train that has no steady curve with all its torques; None else."""
    study = analysis.beyond.train
    return run_data(study) if study is not None and study.run_alone else None


def _largest_torque(project: Project, analysis: Analysis) -> dict[str, Any]:
    """Largest torque through the gear in a steady motion, or the run-up in its place, beside the gear's limits."""
    omega, torque = analysis.usage.at_peak, analysis.usage.peak_torque
    if (run := _run_instead(analysis)) is not None:
        omega, torque = run["largest_torque_at_rpm"] * RPM, run["largest_torque_Nm"]
    gear = project.gear
    return place(project.speeds, omega) | {
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
                | place(project.speeds, motion.omega)
                | {
                    "peak_rad": motion.peak if fine else None,
                    "peak_arcsec": motion.peak / ARCSEC if fine else None,
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
        "motor_speed_rpm": project.speeds.rpm(case.omega),
        "regime": str(case.resonance),
        "peak_from_rest_rad": case.peak_from_rest if case.transient.status else None,
        "peak_from_rest_arcsec": case.peak_from_rest / ARCSEC if case.transient.status else None,
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
    in_arcsec = {"peak_arcsec": cycle.peak / ARCSEC, "peak_to_peak_arcsec": cycle.peak_to_peak / ARCSEC}
    return row | dict(zip(names, values, strict=True)) | in_arcsec
