"""The CSV files beside the report: every curve with the units in its column names."""

from pathlib import Path

import numpy as np

from ...base.results import Branch, Floats
from ...base.units import Speeds
from ...drive.drive_response import DriveResponse
from ...study.analysis.time_case import TimeCase
from ..console import number
from ..output import slug, write_csv
from ..view import View


def write(view: View, folder: Path) -> list[str]:
    """Write the CSV files of the run-up, the response curves and the time responses; return their names."""
    analysis, speeds, names = view.analysis, view.speeds, list[str]()
    for name, motions in (("run-up.csv", analysis.run_up.up), ("run-down.csv", analysis.run_up.down)):
        good = [m for m in motions if m.status]
        if good:
            columns = speed_columns(speeds, np.array([m.omega for m in good]))
            columns += [("peak_x_rad", np.array([m.peak for m in good]))]
            write_csv(folder / name, [*columns, ("periodic", np.array([m.closed for m in good], float))])
            names.append(name)
    exact = analysis.exact.curve
    sizes = {"oscillation_of_x_rad": exact.oscillation, "peak_x_rad": exact.peak}
    curves = [("exact-response.csv", _columns(speeds, exact, sizes))]
    curves += [(f"drive-response{_under(load)}.csv", drive_columns(speeds, found)) for load, found in analysis.curves]
    for name, table in curves:
        if len(table[0][1]):
            write_csv(folder / name, table)
            names.append(name)
    for regime in analysis.regimes:
        for i, branch in enumerate(regime.response.branches if regime.response else ()):
            name = f"response-{slug(regime.label)}{'' if i == 0 else f'-branch-{i + 1}'}.csv"
            polar = ("amplitude_rad", branch.amplitude), ("phase_rad", branch.phase)
            stable = ("stable", branch.stable.astype(float))
            write_csv(folder / name, [("omega_rad_per_s", branch.omega), *polar, stable])
            names.append(name)
    for i, case in enumerate(analysis.cases, 1):
        names += _write_case(folder, f"case-{i}-{slug(case.name)}", case)
    return names


def speed_columns(speeds: Speeds, omega: Floats) -> list[tuple[str, Floats]]:
    """Speed of the base angle, and of the motor where the base angle is its own."""
    named = [("omega_rad_per_s", omega)]
    return [*named, ("motor_speed_rpm", speeds.scale * omega)] if speeds.by_motor else named


def drive_columns(speeds: Speeds, drive: DriveResponse) -> list[tuple[str, Floats]]:
    """Columns of the motions of a drive in arc order; the error is the pointing error, or x without a reference."""
    error = "pointing_error" if drive.has_reference else "x"
    sizes = {
        f"oscillation_of_{error}_rad": drive.oscillation, f"peak_{error}_rad": drive.peak,
        "peak_x_across_gear_rad": drive.across, "peak_torque_in_gear_Nm": drive.torque,
    }  # fmt: skip
    if drive.curve.envelope is not None:
        sizes[f"smallest_oscillation_of_{error}_rad"] = drive.curve.envelope[:, 1]
    sizes_of_motor = {"peak": drive.motor_torque, "rms": drive.motor_rms}
    motor = [(f"{name}_torque_of_motor_Nm", size) for name, size in sizes_of_motor.items() if size is not None]
    return [*_columns(speeds, drive.curve, sizes), *motor]


def _columns(speeds: Speeds, curve: Branch, sizes: dict[str, Floats]) -> list[tuple[str, Floats]]:
    """Columns of a response curve in arc order: speed, sizes, first harmonics of x, stability."""
    harmonics = range(1, min(9, curve.coefficients.shape[1] // 2) + 1)
    amplitudes = [(f"amplitude_{k}_rad", curve.amplitude(k)) for k in harmonics]
    return [
        *speed_columns(speeds, curve.omega), *sizes.items(), *amplitudes, ("stable", curve.stable.astype(float)),
    ]  # fmt: skip


def _under(torque: float | None) -> str:
    """End of a file's name for a torque of the load."""
    return "" if torque is None else f"-at-{number(torque, 5).replace('−', '-')}-Nm"


def _write_case(folder: Path, name: str, case: TimeCase) -> list[str]:
    run, compared = case.transient, case.comparison
    columns = [("t_s", run.t), ("x_integration_rad", run.y[0])]
    if compared is not None:
        columns.append(("x_multiple_scales_rad", compared.theory.x))
    write_csv(folder / f"{name}-from-rest.csv", columns)
    names = [f"{name}-from-rest.csv"]
    if case.cycle is not None:
        c = case.cycle
        steady = [("t_s", c.t), ("x_rad", c.x), ("v_rad_per_s", c.v), ("u_rad", c.u), ("torque_Nm", c.torque)]
        write_csv(folder / f"{name}-steady.csv", steady)
        names.append(f"{name}-steady.csv")
    return names
