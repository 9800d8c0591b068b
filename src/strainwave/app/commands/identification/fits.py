"""`strainwave fit-bode` and `fit-loop`: numbers of a drive from a Bode plot, and a gear's law from a loop."""

from dataclasses import replace
from pathlib import Path
from typing import Any, get_args

import click
import numpy as np

from ....base.facts import Fact, data, lines
from ....files.frd import read_frd
from ....files.logs.names import named as name_and_unit
from ....files.logs.read import read_log as log_of
from ....files.reading import read_project
from ....files.yaml_text import FileError, Problem, complaint
from ....plot.panels import named
from ....plot.svg import stacked
from ....study.identification.bode.bode_fit import BodeFit
from ....study.identification.bode.bode_fit import fit_bode as bode_fitted
from ....study.identification.bode.measured_bode import Estimator, Quantity
from ....study.identification.log import Log
from ....study.identification.loops.loop_fit import fit_loop as loop_fitted
from ...console import echo, reported, to_json, write_all
from ..options import dialect_options, file_type, json_option, output_option, pairs_option, project_argument
from ..options import quantity as value_of


@click.command()
@project_argument
@click.argument("file", type=file_type)
@click.option("--free", help='Numbers to fit, as J_m,K; "" compares without fit. Default: J_m, J_l, K, B, delay.')
@click.option("--quantity", type=click.Choice(get_args(Quantity)), help="Measured quantity. Default: by column names.")
@click.option("--estimator", type=click.Choice(get_args(Estimator)), default="unknown", help="Estimator of the data.")
@click.option("--speed", default="0 rpm", help="Speed of the motor in the measurement.")
@click.option("--amplitude", type=float, help="Amplitude of the excitation, for --second.")
@click.option("--second", type=file_type, help="File measured with another amplitude.")
@click.option("--second-amplitude", type=float, help="Amplitude in the --second file.")
@pairs_option(
    "--column", "columns", "CHANNEL=COLUMN",
    "Column of frequency, size, phase, real, imaginary, or of records; repeatable.",
)  # fmt: skip
@pairs_option("--unit", "units", "CHANNEL=UNIT", "Unit, as frequency=Hz, size=dB or phase=deg; repeatable.")
@click.option(
    "--margins", is_flag=True, help="Judge the measured loop: its phase and gain margins and its sensitivity."
)
@dialect_options
@output_option("Folder for bode.svg, bode.csv and bode.json.")
@json_option
def fit_bode(
    project: Path, file: Path, free: str | None, speed: str, amplitude: float | None, second: Path | None,
    second_amplitude: float | None, output: Path | None, margins: bool, as_json: bool, **reading: Any,
) -> None:  # fmt: skip
    """Fit numbers of a drive to a measured Bode plot.

    FILE has frequencies with size and phase, or real and imaginary part; or time, reference, torque and speed.
    """
    drive = read_project(project)
    measured = [read_frd(file, amplitude=amplitude, **reading)]
    if second is not None:
        measured.append(read_frd(second, amplitude=second_amplitude, **reading))
    judged = measured[0].margins().facts() if margins else ()
    names = None if free is None else tuple(filter(None, map(str.strip, free.split(","))))
    fit = bode_fitted(measured, drive, free=names, speed=value_of("--speed", speed, "rad/s"))
    if output is not None:
        _write(drive.title, fit, (*judged, *fit.facts()), output)
    written = [f"lines for the groups of a project file:\n{fit.yaml}".rstrip()] if fit.yaml else []
    written += [] if output is None else [f"written: {output}/bode.svg, bode.csv, bode.json"]
    echo(reported(drive.title, (*judged, *fit.facts()), as_json, *written))


def _write(title: str, fit: BodeFit, facts: tuple[Fact, ...], folder: Path) -> None:
    responses = {"measured": fit.measured.value, "drive": fit.model, "fitted": fit.computed}
    columns = [("omega_rad_per_s", fit.measured.omega)]
    for name, values in responses.items():
        columns += [(f"{name}_real", np.real(values)), (f"{name}_imaginary", np.imag(values))]
    figure = stacked(named(fit.panels(), title), 260.0, "measured Bode plot and Bode plot of the drive")
    write_all(folder, {"bode.csv": columns, "bode.svg": figure, "bode.json": reported(title, facts, True)})


@click.command()
@click.argument("file", type=file_type)
@click.option("--rated-torque", help='Rated torque, as "67 N*m". Default: the largest measured torque.')
@click.option("--ratio", type=float, help="Ratio of the gear, for the block of a project file.")
@click.option("--torsion", default="torsion", help='Column of the torsion, as "Winkel [arcmin]".')
@click.option("--torque", default="torque", help='Column of the torque, as "Moment [N*m]".')
@dialect_options
@output_option("Folder for loop.svg, loop.csv, loop.json and gear.yaml, the block of a project file.")
@json_option
def fit_loop(
    file: Path, rated_torque: str | None, ratio: float | None, torsion: str, torque: str, output: Path | None,
    as_json: bool, **dialect: str | None,
) -> None:  # fmt: skip
    """Fit the torsion law of a gear to a measured hysteresis loop.

    FILE is a log as `strainwave read-log` reads it (CSV, .npz, .mat, .parquet, .mf4); it needs no time column.
    """
    rated = None if rated_torque is None else value_of("--rated-torque", rated_torque, "N*m")
    log = read_loop_file(file, {"torsion": torsion, "torque": torque}, dialect)
    try:
        fit = loop_fitted(log.channels["torsion"], log.channels["torque"], rated_torque=rated, ratio=ratio)
    except ValueError as error:
        raise FileError(complaint(file, [Problem(1, 1, "loop", str(error))])) from None
    fit = replace(fit, remarks=(*log.notes, *fit.remarks))
    numbers = to_json({"file": file.name} | data(fit.facts()))
    if output is not None:
        columns = [("torsion_rad", fit.torsion), ("torque_N_m", fit.torque), ("fitted_N_m", fit.fitted)]
        figure = stacked(fit.panels(), 300.0, "measured loop and fitted law", 560.0)
        contents = {"loop.svg": figure, "gear.yaml": fit.yaml, "loop.json": numbers, "loop.csv": columns}
        write_all(output, contents)
    written = [] if output is None else [f"written: {output}/loop.svg, loop.csv, loop.json, gear.yaml"]
    text = [file.name, *lines(fit.facts()), f"for a project file:\n{fit.yaml}".rstrip(), *written]
    echo(numbers if as_json else "\n".join(text))


def read_loop_file(file: Path, wanted: dict[str, str], dialect: dict[str, str | None]) -> Log:
    """Log of the channels torsion and torque in the order of the samples; errors as `read_log`."""
    named = {channel: name_and_unit(text) for channel, text in wanted.items()}
    columns = {channel: name for channel, (name, _) in named.items()}
    units = {channel: unit for channel, (_, unit) in named.items() if unit}
    options: dict[str, Any] = {"trim": 0.0, "unwrap": False} | dialect
    try:
        return log_of(file, columns, units, rate=1.0, **options)
    except FileError:
        raise
    except ValueError:  # the file has a time of its own
        return log_of(file, columns, units, **options)
