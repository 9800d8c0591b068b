"""The report: results as plain data, CSV files of every curve, and one self-contained HTML page."""

import math
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from .. import __version__
from ..model.drive import HDC_40_050, HDC_40_050_WARNING
from ..study.analysis import Analysis
from ..study.regimes import Regime
from ..study.time_case import TimeCase
from ..theory.slow_results import Certificate
from . import plots
from .console import number, to_json
from .facts import ARCSEC, RPM, facts
from .output import slug, write_csv
from .project import Project


def write(project: Project, analysis: Analysis, folder: Path) -> dict[str, Any]:
    """Write report.html, results.json and the CSV files into a folder and return the results as plain data."""
    results = collect(project, analysis)
    results["files"] = [*write_curves(project, analysis, folder), "results.json", "report.html"]
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
    jumps = analysis.run_up.hysteresis()
    if jumps and project.drive.B > 0.0:
        first, last = ({"omega_rad_per_s": w, "motor_speed_rpm": _rpm(project, w)} for w in (jumps[0], jumps[-1]))
        where = f"between {_speed(first).split()[0]} and {_speed(last)}" if len(jumps) > 1 else f"at {_speed(first)}"
        said.append(
            f"Run-up and coast-down differ {where}: two stable motions exist there, and which one the drive is "
            f"on depends on its "
            "history; pass through that band quickly or keep out of it."
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


def _run_up(project: Project, analysis: Analysis) -> list[dict[str, Any]]:
    sweep = analysis.run_up
    rows = []
    for direction, motions in (("up", sweep.up), ("down", sweep.down)):
        for omega, motion in zip(sweep.omega, motions, strict=True):
            fine = bool(motion.status)
            rows.append(
                {
                    "direction": direction,
                    "omega_rad_per_s": float(omega),
                    "motor_speed_rpm": _rpm(project, float(omega)),
                    "peak_rad": motion.peak if fine else None,
                    "peak_arcsec": motion.peak * ARCSEC if fine else None,
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


def write_curves(project: Project, analysis: Analysis, folder: Path) -> list[str]:
    """Write the CSV files of the run-up, the response curves and the time responses; return their names."""
    names = ["run-up.csv"]
    sweep = analysis.run_up
    good_up = [m.peak if m.status else np.nan for m in sweep.up]
    good_down = [m.peak if m.status else np.nan for m in sweep.down]
    keep = ~(np.isnan(good_up) | np.isnan(good_down))
    speeds = sweep.omega[keep]
    columns = [("omega_rad_per_s", speeds)] + (
        [] if project.shaft == "forcing" else [("motor_speed_rpm", speeds * RPM)]
    )
    up, down = np.array(good_up)[keep], np.array(good_down)[keep]
    write_csv(folder / names[0], [*columns, ("peak_x_up_rad", up), ("peak_x_down_rad", down)])
    for regime in analysis.regimes:
        for i, branch in enumerate(regime.response.branches if regime.response else ()):
            name = f"response-{slug(regime.label)}{'' if i == 0 else f'-branch-{i + 1}'}.csv"
            columns = [
                ("omega_rad_per_s", branch.omega),
                ("amplitude_rad", branch.amplitude),
                ("phase_rad", branch.phase),
                ("stable", branch.stable.astype(float)),
            ]
            write_csv(folder / name, columns)
            names.append(name)
    for i, case in enumerate(analysis.cases, 1):
        names += _write_case(folder, f"case-{i}-{slug(case.name)}", case)
    return names


def _write_case(folder: Path, name: str, case: TimeCase) -> list[str]:
    run, compared = case.transient, case.comparison
    columns = [("t_s", run.t), ("x_integration_rad", run.y[0])]
    if compared is not None:
        columns.append(("x_multiple_scales_rad", compared.theory.x))
    write_csv(folder / f"{name}-from-rest.csv", columns)
    names = [f"{name}-from-rest.csv"]
    cycle = case.cycle
    if cycle is not None:
        steady = [
            ("t_s", cycle.t),
            ("x_rad", cycle.x),
            ("v_rad_per_s", cycle.v),
            ("u_rad", cycle.u),
            ("torque_Nm", cycle.torque),
        ]
        write_csv(folder / f"{name}-steady.csv", steady)
        names.append(f"{name}-steady.csv")
    return names


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
        figures = {
            "range": plots.svg(plots.speed_range(project, analysis), "largest error against speed"),
            "responses": [
                (i, regime, plots.svg(plots.response(project, analysis, regime), f"response curve, {regime.label}"))
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
    good = [row for row in results["run_up"] if row["peak_rad"] is not None]
    worst = max(good, key=lambda row: row["peak_rad"])
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
