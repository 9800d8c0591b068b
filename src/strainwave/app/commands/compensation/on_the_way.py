"""`strainwave compensate-move` and `compensate-run-up`: controllers in closed loop through many speeds."""

from pathlib import Path
from typing import Any

import click
import numpy as np

from ....files.reading import read_project
from ....study.compensation.moves import WINDOW, compensated_move
from ....study.compensation.runup import compensated_runup
from ....units import ARCSEC, RPM
from ...console import Progress, to_json
from ...figures.on_the_way import move_figure, run_up_figure
from ...output import staged, write_csv
from ...units import quantity
from ..move import profile_part
from .compensate import plant_of

USUAL = ("loop", "inverse")
CSV = {"delimiter": ",", "decimal": "."}
MOST_ROWS = 20_000  # of a CSV file


def show_move(
    path: Path, profile: tuple[str, ...], controllers: tuple[str, ...], shaping: tuple[str, ...], window: str | None,
    plant: Path | None, softer: str | None, output: Path | None, as_json: bool,
) -> None:  # fmt: skip
    """Run a move in closed loop, write it and print the scores; errors as of `compensated_move`."""
    project = read_project(path)
    parts = [profile_part(text, CSV) for text in profile] or (project.move and list(project.move.profile))
    if not parts:
        raise ValueError(f"{path.name} has no move; write 'trapezoid, angle: 20 deg, time: 0.4 s' after it, or a group")
    within = WINDOW if window is None else quantity("--window", window, "rad")
    with Progress(project.title) as progress:
        progress.show("move", 0.1)
        found = compensated_move(
            project, parts, controllers or USUAL, shaping=shaping, window=within, plant=plant_of(project, plant, softer)
        )
    data = {
        "title": project.title,
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
    _done("move", columns, move_figure(found), data, str(found), output, as_json)


def show_run_up(
    path: Path, low: str | None, high: str | None, load_angle: str | None, duration: str, controllers: tuple[str, ...],
    plant: Path | None, softer: str | None, output: Path | None, as_json: bool,
) -> None:  # fmt: skip
    """Run a run-up and a run-down in closed loop, write them and print what they met; errors as `compensated_runup`."""
    project = read_project(path)
    ends = project.speeds.limits
    first = ends[0] if low is None else quantity("--from", low, "rad/s")
    last = ends[1] if high is None else quantity("--to", high, "rad/s")
    time = quantity("--time", duration, "s")
    angle = None if load_angle is None else quantity("--load-angle", load_angle, "rad")
    with Progress(project.title) as progress:
        progress.show("run-up and run-down", 0.1)
        found = compensated_runup(
            project, (first, last), time, controllers or USUAL, plant=plant_of(project, plant, softer), load_angle=angle
        )
    data = {
        "title": project.title,
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
    _done("run-up", columns, run_up_figure(found), data, str(found), output, as_json)


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
