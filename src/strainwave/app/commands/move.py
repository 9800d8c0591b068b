"""`strainwave move`: a project's drive on a profile, as numbers, CSV and figure."""

from pathlib import Path
from typing import Any

import click

from ...base.facts import Fact
from ...drive.demands.motor_limits import MotorLimits
from ...drive.project import Project
from ...files.fields.profile_text import WrongText, of_fields, profile_part
from ...files.fields.schema import PAYLOAD
from ...files.reading import read_project
from ...plot.moves import move_panels
from ...plot.panels import named
from ...plot.svg import stacked
from ...study.move.move import move as moved
from ...study.move.postures import move_postures
from ...study.move.result import Move
from ..console import Progress, columns, echo, reported, write_all
from .options import dialect_options, json_option, output_option, project_argument, quantity, span

CSV, SVG, JSON = "move.csv", "move.svg", "move.json"


@click.command()
@project_argument
@click.argument("profile", nargs=-1)
@output_option("Folder for move.csv, move.svg and move.json.", required=True)
@click.option("--start", help='Angle of the load at the start, for example "-45 deg".')
@click.option("--payload", help='Payload, for example "mass: 5 kg, radius: 0.4 m, phase: 90 deg".')
@click.option("--window", help='Settling window about the final angle, for example "30 arcsec".')
@click.option(
    "--band", "bands", nargs=2, multiple=True, metavar="LOW HIGH",
    help='Motor speeds to avoid, as "1200 rpm" "1500 rpm"; repeatable.',
)  # fmt: skip
@click.option("--limited", is_flag=True, help="Limit the motor torque and the commanded speed in the simulation.")
@click.option("--avoid", is_flag=True, help="Also avoid the speeds that `analyze` forbids (longer computation).")
@click.option("--postures", is_flag=True, help="Simulate every posture of the project file; writes move.json only.")
@dialect_options
@json_option
def move(
    project: Path, profile: tuple[str, ...], output: Path, start: str | None, payload: str | None, window: str | None,
    bands: tuple[tuple[str, str], ...], limited: bool, avoid: bool, postures: bool, as_json: bool,
    **dialect: str | None,
) -> None:  # fmt: skip
    """Simulate a move along PROFILE: error, settling, torques.

    Bearing life and energy are computed too.
    PROFILE is one part or several, one after the other: a CSV file with the columns time [s] and angle [deg], or fields
    as in the group `move` of a project file: "trapezoid, angle: 90 deg, time: 0.6 s", "s_curve, angle: -90 deg, time:
    0.6 s", "dwell, time: 0.4 s". Without PROFILE, that of the project file is used.
    """
    drive = read_project(project)
    try:
        parts = [profile_part(text, **dialect) for text in profile]
        carried = {} if payload is None else {"payload": of_fields(payload, f"{{{payload}}}", PAYLOAD, "payload")}
    except WrongText as error:
        raise click.BadParameter(str(error)) from None
    angles = {"start": (start, "any"), "window": (window, "positive")}
    options: dict[str, Any] = carried | {
        name: quantity(f"--{name}", text, "rad", sign) for name, (text, sign) in angles.items() if text is not None
    }
    avoided = [span("--band", ends, "rad/s", 'for example "500 rpm" "700 rpm"') for ends in bands]
    with Progress(drive.title) as progress:
        if avoid:
            analysed = drive.analyze(lambda what, share: progress.show(what, 0.5 * share)).avoid
            avoided += [] if analysed is None else list(analysed.bands)
        progress.show("move", 0.5)
        options["limited"] = limited
        if postures:
            options["progress"] = lambda share: progress.show("move", share)
            rows = move_postures(drive, parts or None, bands=avoided, **options)
            write_all(output, {JSON: reported(drive.title, rows.facts(), True)})
            echo(reported(drive.title, rows.facts(), as_json, f"written: {output / JSON}"))
            return
        result = moved(drive, parts or None, bands=avoided, **options)
        progress.show("writing", 0.9)
        facts = (*result.facts(), *(drive.loop.facts() if drive.loop else ()))
        _write(drive, result, facts, output)
    written = f"written: {', '.join(str(output / file) for file in (CSV, SVG, JSON))}"
    echo(reported(drive.title, facts, as_json, written))


def _write(project: Project, result: Move, facts: tuple[Fact, ...], output: Path) -> None:
    panels = named(move_panels(result, project.gear, project.motor_limits or MotorLimits()), project.title)
    drawn = stacked(panels, 215.0, "a move over time")
    table = columns(result.coordinates(), result.variables())
    write_all(output, {CSV: table, SVG: drawn, JSON: reported(project.title, facts, True)})
