"""The report: results as plain data, CSV files of every curve, and one self-contained HTML page."""

import math
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from .. import __version__
from ..model.drive import HDC_40_050, HDC_40_050_WARNING
from ..study.analysis import Analysis
from ..study.exact import ExactResponse
from ..study.regimes import Regime
from ..study.time_case import TimeCase
from ..theory.slow_results import Certificate
from . import curve_files, curves, plots
from .console import number, to_json
from .facts import ARCSEC, RPM, facts
from .project import Project


def write(project: Project, analysis: Analysis, folder: Path) -> dict[str, Any]:
    """Write report.html, results.json and the CSV files into a folder and return the results as plain data."""
    results = collect(project, analysis)
    results["files"] = [*curve_files.write(project, analysis, folder), "results.json", "report.html"]
    (folder / "results.json").write_text(to_json(results) + "\n", encoding="utf-8")
    (folder / "report.html").write_text(page(project, analysis, results), encoding="utf-8")
    return results


def collect(project: Project, analysis: Analysis) -> dict[str, Any]:
    """Gather every number of the report with its unit; None stands for a number that does not exist."""
    proof = analysis.stability
    return {
        "strainwave": __version__,
        "title": project.title,
        "project": project.text,
        "motor": project.motor,
        "base_angle": "forcing phase" if project.shaft == "forcing" else "motor (wave-generator) angle",
        "conventions": (
            "x = theta_m/N - theta_l [rad, output side]; amplitudes are 0-to-peak; omega is the speed of the base angle"
        ),
        "drive": {
            "law": repr(project.drive.law),
            "gear": project.gear.name if project.gear else None,
            "source": project.gear.source if project.gear else None,
        },
        "derived": [fact._asdict() for fact in facts(project, analysis)],
        "stability": {
            "holds": proof.holds,
            "scope": proof.scope,
            "claim": proof.claim,
            "region": str(proof.region or "none"),
            "reason": proof.reason,
        },
        "speed_range_rad_per_s": list(analysis.speeds),
        "resonances": [_resonance(project, i, regime) for i, regime in enumerate(analysis.regimes, 1)],
        "exact_response": exact_response_data(project, analysis.exact),
        "largest_error": _largest(project, analysis),
        "run_up": _run_up(project, analysis),
        "cases": [_case(project, case) for case in analysis.cases],
        "warnings": warnings(project, analysis),
    }


def warnings(project: Project, analysis: Analysis) -> list[str]:
    """What the reader must know before using the numbers."""
    said = list(project.notes)
    article = (HDC_40_050.law, HDC_40_050.J_m, HDC_40_050.J_l)
    if (project.drive.law, project.drive.J_m, project.drive.J_l) == article:
        said.insert(0, HDC_40_050_WARNING)
    said += analysis.warnings
    sweep = analysis.exact.sweep
    if sweep is not None and sweep.width > 0.0:
        ends = sorted((sweep.jump_up, sweep.jump_down))
        first, last = ({"omega_rad_per_s": w, "motor_speed_rpm": _rpm(project, w)} for w in ends)
        said.append(
            f"Run-up and coast-down differ between {_speed(first).split()[0]} and {_speed(last)}: two stable motions "
            "exist there, and which one the drive is on depends on its history; pass through that band quickly or keep "
            "out of it."
        )
    return said


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
        "sentence": certificate.sentence,
    }


def exact_response_data(project: Project, exact: ExactResponse) -> dict[str, Any]:
    """Key numbers of the exact response: folds, jumps, accuracy."""
    curve, sweep = exact.curve, exact.sweep
    return {
        "method": "harmonic balance",
        "harmonics": curve.coefficients.shape[1] // 2,
        "last_harmonics_relative": curve.tail,
        "complete": bool(curve.status),
        "message": curve.message,
        "folds": [_place(project, fold.omega) | _angle_of("peak", fold.peak) for fold in curve.folds],
        "jump_up": _jump(project, sweep.jump_up if sweep else math.nan),
        "jump_down": _jump(project, sweep.jump_down if sweep else math.nan),
        "hysteresis_rad_per_s": sweep.width if sweep else None,
        "sweep": sweep.sentence if sweep else "no motion on the curve is stable",
    }


def _place(project: Project, omega: float) -> dict[str, Any]:
    return {"omega_rad_per_s": omega, "motor_speed_rpm": _rpm(project, omega)}


def _angle_of(name: str, rad: float) -> dict[str, Any]:
    return {f"{name}_rad": rad, f"{name}_arcsec": rad * ARCSEC}


def _jump(project: Project, omega: float) -> dict[str, Any] | None:
    return _place(project, omega) if math.isfinite(omega) else None


def _largest(project: Project, analysis: Analysis) -> dict[str, Any]:
    """Largest steady |x| that a sweep meets: on the exact curve, or by simulation where there is no such curve."""
    at, worst = analysis.exact.largest(), analysis.run_up.worst()
    curve = analysis.exact.curve
    if at is None or curve.peak[at] < 0.999 * worst.peak:
        return _place(project, worst.omega) | _angle_of("peak", worst.peak) | {"method": "integration"}
    place = _place(project, float(curve.omega[at]))
    return place | _angle_of("peak", float(curve.peak[at])) | {"method": "harmonic balance"}


def _run_up(project: Project, analysis: Analysis) -> list[dict[str, Any]]:
    run, rows = analysis.run_up, []
    for direction, motions, exact in (("up", run.up, run.curve_up), ("down", run.down, run.curve_down)):
        for motion, curve in zip(motions, exact, strict=True):
            fine = bool(motion.status)
            rows.append(
                {"direction": direction}
                | _place(project, motion.omega)
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


def page(project: Project, analysis: Analysis, results: dict[str, Any]) -> str:
    """Render the HTML page.

    Raises
    ------
    RuntimeError
        If jinja2 is not installed.
    """
    try:
        import jinja2
    except ModuleNotFoundError as error:
        raise RuntimeError("the report needs jinja2; pip install 'strainwave[report]'") from error
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent / "templates"),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters["number"] = number
    environment.filters["sentence"] = lambda text: text[:1].upper() + text[1:].rstrip(".") + "." if text else ""
    environment.filters["arcsec"] = lambda rad: number(None if rad is None else rad * ARCSEC)
    environment.filters["angle"] = _angle
    with plots.style():
        range_figure = curves.speed_range(project, analysis.exact, analysis.regimes, analysis.speeds, analysis.run_up)
        figures = {
            "range": plots.svg(range_figure, "largest error against speed"),
            "responses": [
                (i, regime, plots.svg(curves.response(project, analysis, regime), f"response curve, {regime.label}"))
                for i, regime in enumerate(analysis.regimes, 1)
                if regime.response is not None and regime.response.branches
            ],
            "cases": [plots.svg(plots.time_figure(case), f"time response, {case.name}") for case in analysis.cases],
        }
    template = environment.get_template("report.html.j2")
    return template.render(
        r=results, figures=figures, forcing=project.shaft == "forcing", software=_software(), project=project
    )


def _angle(rad: float) -> str:
    unit, factor = plots.angle_unit(rad)
    return f"{number(rad * factor)} {unit}"


def _software() -> str:
    parts = [f"strainwave {__version__}"]
    for package in ("numpy", "scipy", "numba"):
        try:
            parts.append(f"{package} {version(package)}")
        except PackageNotFoundError:
            continue
    return ", ".join(parts)


def summary(results: dict[str, Any]) -> str:
    """Key numbers in a few lines."""
    lines = [results["title"]]
    free = {(f["name"], f["unit"]): f["value"] for f in results["derived"]}
    for mode in ("free", "held"):
        omega_0 = free.get((f"Natural frequency, motor {mode}", "rad/s"))
        used = ", used here" if mode == results["motor"] else ""
        if omega_0:
            hertz = number(omega_0 / (2.0 * math.pi))
            lines.append(f"  natural frequency, motor {mode}{used}: {number(omega_0)} rad/s ({hertz} Hz)")
    for row in results["resonances"]:
        if row["inside_range"] and row["name"] == "primary":
            lines.append("  " + _resonance_line(row))
    worst = results["largest_error"]
    lines.append(f"  largest steady error: {_angle(worst['peak_rad'])} (0-to-peak, at the load) at {_speed(worst)}")
    lines.append(f"  stability: {results['stability']['scope']}; {results['stability']['claim']}")
    if results["warnings"]:
        lines.append(f"  {len(results['warnings'])} warning(s) in the report")
    return "\n".join(lines)


def _resonance_line(row: dict[str, Any]) -> str:
    text = f"{row['name']} resonance of order {row['order']} at {_speed(row)}"
    if row["peak"]:
        text += f", peak {_angle(row['peak']['amplitude_rad'])} by multiple scales"
    if row["folds"]:
        text += f", jumps at {' and '.join(_speed(fold) for fold in row['folds'])}"
    return text


def _speed(row: dict[str, Any]) -> str:
    if row["motor_speed_rpm"] is None:
        return f"{number(row['omega_rad_per_s'], 5)} rad/s"
    return f"{number(row['motor_speed_rpm'], 5)} rpm at the motor"
