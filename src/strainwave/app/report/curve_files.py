"""CSV files of a report: run-up, response curves and motions in time."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ...base.results import Floats
from ..console import number, slug, write_csv
from ..curves import curve_columns, drive_columns, speed_columns
from ..view import View


def write_curves(view: View, folder: Path) -> list[str]:
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
    yield "exact-response", curve_columns(speeds, exact, of_equation)
    for torque, response in analysis.curves:
        under = "" if torque is None else f"-at-{number(torque, 5).replace('−', '-')}-Nm"
        yield f"drive-response{under}", drive_columns(speeds, response)
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
