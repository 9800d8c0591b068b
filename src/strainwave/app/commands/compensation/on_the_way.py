"""`strainwave compensate-move` and `compensate-run-up`: controllers in closed loop through many speeds."""

from pathlib import Path
from typing import Any

import click
import numpy as np

from ....base.units import ARCSEC, RPM
from ....files.reading import read_project
from ....plot.svg import stacked
from ....study.compensation.moves import WINDOW, compensated_move
from ....study.compensation.runup import compensated_runup
from ...console import Progress, to_json
from ...output import staged, write_csv
from ...view import quantity
from ..move import profile_part
from ..options import json_option, output_option, project_argument
from .compensate import plant_of, plant_options

USUAL = ("loop", "inverse")
CSV = {"delimiter": ",", "decimal": "."}
MOST_ROWS = 20_000  # of a CSV file


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
    """Move the load along PROFILE in closed loop, under several controllers and with shaped references.

    PROFILE is one part or several, as of `strainwave move`: "trapezoid, angle: 20 deg, time: 0.4 s". Without it the
    profile of the project file is taken.
    """
    drive = read_project(project)
    parts = [profile_part(text, CSV) for text in profile] or (drive.move and list(drive.move.profile))
    if not parts:
        raise ValueError(
            f"{project.name} has no move; write 'trapezoid, angle: 20 deg, time: 0.4 s' after it, or a group"
        )
    within = WINDOW if window is None else quantity("--window", window, "rad")
    with Progress(drive.title) as progress:
        progress.show("move", 0.1)
        found = compensated_move(
            drive, parts, controllers or USUAL, shaping=shaping, window=within, plant=plant_of(drive, plant, softer)
        )
    data = {
        "title": drive.title,
        "duration_s": found.duration,
        "window_arcsec": found.window / ARCSEC,
        "controllers": [
            {
                "controller": s.name, "settling_time_s": s.settling_time, "rms_arcsec": s.rms / ARCSEC,
                "peak_arcsec": s.peak / ARCSEC, "rest_arcsec": s.rest_error / ARCSEC, "motor_torque_peak_N_m": s.torque,
                "at_limit_share": s.limited,
            }
            for s in found.scores
        ],
        "remarks": list(found.remarks),
    }  # fmt: skip
    take = slice(None, None, -(-len(found.time) // MOST_ROWS))
    columns: list[tuple[str, Any]] = [("time_s", found.time[take])]
    for name, error, torque in zip(found.names, found.error, found.torque, strict=True):
        columns += [(f"error_arcsec {name}", error[take] / ARCSEC), (f"motor_torque_N_m {name}", torque[take])]
    _done(
        "move",
        columns,
        stacked(found.panels(), 240.0, "a move under several controllers"),
        data,
        str(found),
        output,
        as_json,
    )


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
    """Run through a range of speeds and back in closed loop: largest errors, and whether the drive still jumps."""
    drive = read_project(project)
    ends = drive.speeds.limits
    first = ends[0] if low is None else quantity("--from", low, "rad/s")
    last = ends[1] if high is None else quantity("--to", high, "rad/s")
    time = quantity("--time", duration, "s")
    angle = None if load_angle is None else quantity("--load-angle", load_angle, "rad")
    with Progress(drive.title) as progress:
        progress.show("run-up and run-down", 0.1)
        found = compensated_runup(
            drive, (first, last), time, controllers or USUAL, plant=plant_of(drive, plant, softer), load_angle=angle
        )
    data = {
        "title": drive.title,
        "acceleration_rpm_per_s": found.acceleration / RPM,
        "controllers": [
            {
                "controller": name, "largest_up_arcsec": np.max(up) / ARCSEC,
                "largest_down_arcsec": np.max(down) / ARCSEC,
                "jumps": bool(np.isfinite(jump)), "two_motions_at_rpm": None if np.isnan(jump) else jump / RPM,
            }
            for name, up, down, jump in zip(found.names, found.up, found.down, found.jump, strict=True)
        ],
        "remarks": list(found.remarks),
    }  # fmt: skip
    columns: list[tuple[str, Any]] = [("motor_speed_rpm", found.speed / RPM)]
    for name, up, down in zip(found.names, found.up, found.down, strict=True):
        columns += [(f"up_arcsec {name}", up / ARCSEC), (f"down_arcsec {name}", down / ARCSEC)]
    _done(
        "run-up",
        columns,
        stacked(found.panels(), 300.0, "a run-up and a run-down under several controllers"),
        data,
        str(found),
        output,
        as_json,
    )


def _done(
    stem: str, columns: list[tuple[str, Any]], drawn: str, data: dict[str, Any], said: str, output: Path | None,
    as_json: bool,
) -> None:  # fmt: skip
    """Write table, figure and numbers where a folder is given, and print."""
    if output is not None:
        with staged(output) as folder:
            write_csv(folder / f"{stem}.csv", columns)
            (folder / f"{stem}.svg").write_text(drawn + "\n", encoding="utf-8")
            (folder / f"{stem}.json").write_text(to_json(data) + "\n", encoding="utf-8")
    click.echo(to_json(data) if as_json else said)
    if output is not None and not as_json:
        click.echo(f"  written: {output / stem}.csv, {stem}.json, {stem}.svg")
