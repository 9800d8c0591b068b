"""The CSV files beside the report: every curve with the units in its column names."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ...base.results import Branch, Floats
from ...base.units import Speeds
from ...drive.drive_response import DriveResponse
from ..console import number
from ..output import slug, write_csv
from ..view import View


def write(view: View, folder: Path) -> list[str]:
    """Write the CSV files of the run-up, the response curves and the time responses; return their names."""
    tables = {name: columns for name, columns in _tables(view) if len(columns[0][1])}
    for name, columns in tables.items():
        write_csv(folder / f"{name}.csv", columns)
    return [f"{name}.csv" for name in tables]


def _tables(view: View) -> Iterator[tuple[str, list[tuple[str, Floats]]]]:
    """Names of the files without their ending, and their columns."""
    analysis, speeds, exact = view.analysis, view.speeds, view.analysis.exact.curve
    for name, motions in (("run-up", analysis.run_up.up), ("run-down", analysis.run_up.down)):
        good = [m for m in motions if m.status]
        sizes = {"peak_x_rad": [m.peak for m in good], "periodic": [m.closed for m in good]}
        columns = speed_columns(speeds, np.array([m.omega for m in good]))
        yield name, columns + [(key, np.array(values, float)) for key, values in sizes.items()]
    of_equation = {"oscillation_of_x_rad": exact.oscillation, "peak_x_rad": exact.peak}
    yield "exact-response", _columns(speeds, exact, of_equation)
    for torque, found in analysis.curves:
        under = "" if torque is None else f"-at-{number(torque, 5).replace('−', '-')}-Nm"
        yield f"drive-response{under}", drive_columns(speeds, found)
    for regime in analysis.regimes:
        for i, branch in enumerate(regime.response.branches if regime.response else ()):
            polar = ("amplitude_rad", branch.amplitude), ("phase_rad", branch.phase)
            columns = [("omega_rad_per_s", branch.omega), *polar, ("stable", branch.stable.astype(float))]
            yield f"response-{slug(regime.label)}{'' if i == 0 else f'-branch-{i + 1}'}", columns
    for i, case in enumerate(analysis.cases, 1):
        name, c = f"case-{i}-{slug(case.name)}", case.cycle
        theory = [] if case.comparison is None else [("x_multiple_scales_rad", case.comparison.theory.x)]
        yield f"{name}-from-rest", [("t_s", case.transient.t), ("x_integration_rad", case.transient.y[0]), *theory]
        if c is not None:
            steady = [("t_s", c.t), ("x_rad", c.x), ("v_rad_per_s", c.v), ("u_rad", c.u), ("torque_Nm", c.torque)]
            yield f"{name}-steady", steady


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
