"""`strainwave compensate-move` and `compensate-run-up`: controllers in closed loop through many speeds."""

from pathlib import Path

import click

from ....base.results import Floats
from ....base.units import ARCSEC, RPM
from ....files.reading import read_project
from ....plot.panels import named
from ....plot.svg import stacked
from ....study.compensation.moves import WINDOW
from ....study.compensation.moves import compensate_move as compensated_move
from ....study.compensation.result import OnTheWay
from ....study.compensation.runup import compensate_run_up as compensated_runup
from ...console import Progress, reported
from ...output import write_all
from ...view import quantity
from ..move import profile_part
from ..options import json_option, output_option, project_argument
from .compensate import plant_of, plant_options

USUAL = ("loop", "inverse")
MOST_ROWS = 20_000  # of a CSV file
FIGURES = {"move": (240.0, "a move"), "run-up": (300.0, "a run-up and a run-down")}  # height of a panel [px], label


@click.command("compensate-move")
@project_argument
@click.argument("profile", nargs=-1)
@click.option("--controller", "controllers", multiple=True, help="Name; repeatable. Default: loop and inverse.")
@click.option(
    "--shaping",
    multiple=True,
    type=click.Choice(["ZV", "ZVD"]),
    help="Shape the reference of the plain loop; repeatable.",
)
@click.option("--window", help="Largest distance of a settled load from rest. Default: 1 arcmin.")
@plant_options
@output_option("Folder for move.csv, move.json and move.svg.")
@json_option
def compensate_move(
    project: Path, profile: tuple[str, ...], controllers: tuple[str, ...], shaping: tuple[str, ...], window: str | None,
    plant: Path | None, softer: str | None, output: Path | None, as_json: bool,
) -> None:  # fmt: skip
    """Move the load in closed loop, with several controllers.

    PROFILE is one part or several, as of `strainwave move`: "trapezoid, angle: 20 deg, time: 0.4 s". Without it the
    profile of the project file is taken.
    """
    drive = read_project(project)
    parts = [profile_part(text) for text in profile] or (drive.move and list(drive.move.profile))
    if not parts:
        raise ValueError(
            f"{project.name} has no move; write 'trapezoid, angle: 20 deg, time: 0.4 s' after it, or a group"
        )
    within = WINDOW if window is None else quantity("--window", window, "rad")
    with Progress(drive.title) as progress:
        progress.show("move", 0.1)
        move = compensated_move(
            drive, parts, controllers or USUAL, shaping=shaping, window=within, plant=plant_of(drive, plant, softer)
        )
    rows = slice(None, None, -(-len(move.time) // MOST_ROWS))
    curves = {"error_arcsec": move.error[:, rows] / ARCSEC, "motor_torque_N_m": move.torque[:, rows]}
    _tell("move", drive.title, move, ("time_s", move.time[rows]), curves, output, as_json)


@click.command("compensate-run-up")
@project_argument
@click.option("--from", "low", help='Lowest speed of the motor, as "300 rpm". Default: that of the file.')
@click.option("--to", "high", help="Highest speed of the motor. Default: that of the file.")
@click.option(
    "--load-angle", help='Of the load, at which gravity is held while jumps are looked for. Default: "0 deg".'
)
@click.option("--time", "duration", default="10 s", help="Of the run-up, and of the run-down.")
@click.option("--controller", "controllers", multiple=True, help="Name; repeatable. Default: loop and inverse.")
@plant_options
@output_option("Folder for run-up.csv, run-up.json and run-up.svg.")
@json_option
def compensate_run_up(
    project: Path, low: str | None, high: str | None, load_angle: str | None, duration: str,
    controllers: tuple[str, ...], plant: Path | None, softer: str | None, output: Path | None, as_json: bool,
) -> None:  # fmt: skip
    """Run up and down in closed loop: errors and jumps."""
    drive = read_project(project)
    ends = drive.speeds.limits
    first = ends[0] if low is None else quantity("--from", low, "rad/s")
    last = ends[1] if high is None else quantity("--to", high, "rad/s")
    time = quantity("--time", duration, "s")
    angle = None if load_angle is None else quantity("--load-angle", load_angle, "rad")
    with Progress(drive.title) as progress:
        progress.show("run-up and run-down", 0.1)
        runup = compensated_runup(
            drive, (first, last), time, controllers or USUAL, plant=plant_of(drive, plant, softer), load_angle=angle
        )
    curves = {"up_arcsec": runup.up / ARCSEC, "down_arcsec": runup.down / ARCSEC}
    _tell("run-up", drive.title, runup, ("motor_speed_rpm", runup.speed / RPM), curves, output, as_json)


def _tell(
    stem: str, title: str, result: OnTheWay, axis: tuple[str, Floats], curves: dict[str, Floats], output: Path | None,
    as_json: bool,
) -> None:  # fmt: skip
    """Write table, figure and numbers where a folder is given, and print."""
    written = []
    if output is not None:
        columns = [(f"{unit} {name}", row[i]) for i, name in enumerate(result.names) for unit, row in curves.items()]
        height, label = FIGURES[stem]
        drawn = stacked(named(result.panels(), title), height, f"{label} under several controllers")
        contents = {"csv": [axis, *columns], "json": reported(title, result.facts(), True), "svg": drawn}
        write_all(output, {f"{stem}.{ending}": content for ending, content in contents.items()})
        written.append(f"written: {output / stem}.csv, {stem}.json, {stem}.svg")
    click.echo(reported(title, result.facts(), as_json, *written))
