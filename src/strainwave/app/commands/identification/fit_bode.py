"""`strainwave fit-bode`: a measured Bode plot over that of a drive, and the drive's numbers that fit it."""

from pathlib import Path
from typing import Any, get_args

import click
import numpy as np

from ....files.logs.frd import read_frd
from ....files.reading import read_project
from ....plot.panels import named
from ....plot.svg import stacked
from ....study.identification.response_curve.bode_fit import BodeFit
from ....study.identification.response_curve.bode_fit import fit_bode as fitted
from ....study.identification.response_curve.measured_bode import Estimator, Quantity
from ...console import reported
from ...output import write_all
from ...view import quantity as value_of
from ..options import dialect_options, file_type, json_option, output_option, pairs, project_argument


@click.command()
@project_argument
@click.argument("file", type=file_type)
@click.option("--free", help='Numbers to fit, as J_m,K; "" compares alone. Default: J_m, J_l, K, B, delay.')
@click.option("--quantity", type=click.Choice(get_args(Quantity)), help="What was measured. Default: by the names.")
@click.option("--estimator", type=click.Choice(get_args(Estimator)), default="unknown", help="How it was estimated.")
@click.option("--speed", default="0 rpm", help="Speed of the motor at which it was measured.")
@click.option("--amplitude", type=float, help="Amplitude of the excitation, for --second.")
@click.option("--second", type=file_type, help="File measured with another amplitude.")
@click.option("--second-amplitude", type=float, help="Its amplitude.")
@click.option(
    "--column", "columns", multiple=True, callback=pairs, metavar="CHANNEL=COLUMN",
    help="Column of frequency, size, phase, real, imaginary, or of records; repeatable.",
)  # fmt: skip
@click.option(
    "--unit", "units", multiple=True, callback=pairs, metavar="CHANNEL=UNIT",
    help="Unit, as frequency=Hz, size=dB or phase=deg; repeatable.",
)  # fmt: skip
@dialect_options
@output_option("Folder for bode.svg, bode.csv and bode.json.")
@json_option
def fit_bode(
    project: Path, file: Path, free: str | None, speed: str, amplitude: float | None, second: Path | None,
    second_amplitude: float | None, output: Path | None, as_json: bool, **reading: Any,
) -> None:  # fmt: skip
    """Fit numbers of a drive to a measured Bode plot.

    FILE has frequencies with size and phase, or real and imaginary part; or time, reference, torque and speed.
    """
    drive = read_project(project)
    measured = [read_frd(file, amplitude=amplitude, **reading)]
    if second is not None:
        measured.append(read_frd(second, amplitude=second_amplitude, **reading))
    names = None if free is None else tuple(name.strip() for name in free.split(",") if name.strip())
    fit = fitted(measured, drive, free=names, speed=value_of("--speed", speed, "rad/s"))
    if output is not None:
        _write(drive.title, fit, output)
    written = [] if output is None else [f"written: {output}/bode.svg, bode.csv, bode.json"]
    click.echo(reported(drive.title, fit.facts(), as_json, *written))


def _write(title: str, fit: BodeFit, folder: Path) -> None:
    responses = {"measured": fit.measured.value, "drive": fit.model, "fitted": fit.computed}
    columns = [("omega_rad_per_s", fit.measured.omega)]
    for name, values in responses.items():
        columns += [(f"{name}_real", np.real(values)), (f"{name}_imaginary", np.imag(values))]
    figure = stacked(named(fit.panels(), title), 260.0, "a measured Bode plot and that of the drive")
    write_all(folder, {"bode.csv": columns, "bode.svg": figure, "bode.json": reported(title, fit.facts(), True)})
