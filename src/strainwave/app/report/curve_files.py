"""The CSV files beside the report: every curve with the units in its column names."""

from pathlib import Path

import numpy as np

from ...files.project import Project
from ...results import Branch, Floats
from ...speeds import Speeds
from ...study.analysis.analysis import Analysis
from ...study.analysis.time_case import TimeCase
from ..output import slug, write_csv


def write(project: Project, analysis: Analysis, folder: Path) -> list[str]:
    """Write the CSV files of the run-up, the response curves and the time responses; return their names."""
    names = []
    for name, motions in (("run-up.csv", analysis.run_up.up), ("run-down.csv", analysis.run_up.down)):
        good = [m for m in motions if m.status]
        if good:
            speeds = speed_columns(project.speeds, np.array([m.omega for m in good]))
            write_csv(folder / name, [*speeds, ("peak_x_rad", np.array([m.peak for m in good]))])
            names.append(name)
    if len(analysis.exact.curve):
        write_csv(folder / "exact-response.csv", exact_columns(project.speeds, analysis.exact.curve))
        names.append("exact-response.csv")
    if analysis.train_curve is not None:
        write_csv(folder / "train-response.csv", exact_columns(project.speeds, analysis.train_curve.response.curve))
        names.append("train-response.csv")
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


def speed_columns(speeds: Speeds, omega: Floats) -> list[tuple[str, Floats]]:
    """Speed of the base angle, and of the motor where the base angle is its own."""
    named = [("omega_rad_per_s", omega)]
    return [*named, ("motor_speed_rpm", speeds.scale * omega)] if speeds.by_motor else named


def exact_columns(speeds: Speeds, curve: Branch) -> list[tuple[str, Floats]]:
    """Columns of a response curve in arc order: speed, largest |x|, first harmonics of x, stability."""
    most = min(9, curve.coefficients.shape[1] // 2)
    harmonics = [(f"amplitude_{k}_rad", curve.amplitude(k)) for k in range(1, most + 1)]
    stable = ("stable", curve.stable.astype(float))
    return [*speed_columns(speeds, curve.omega), ("peak_x_rad", curve.peak), *harmonics, stable]


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
