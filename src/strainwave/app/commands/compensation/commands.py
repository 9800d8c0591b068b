"""What the commands of compensation take; their work is imported inside, so that `--help` answers at once."""

from pathlib import Path
from typing import Any

import click

FILE, FOLDER = click.Path(path_type=Path), click.Path(file_okay=False, path_type=Path)
json_option = click.option("--json", "as_json", is_flag=True, help="Print the result as JSON.")
plant_options = (
    click.option("--plant", type=FILE, help="Project file of the drive that is run, if another."),
    click.option("--softer", help='Run a drive whose gear is softer than the file says, as "20 %".'),
)


def with_plant(command: Any) -> Any:
    """Options of the drive that is run."""
    for option in reversed(plant_options):
        command = option(command)
    return command


@click.command()
@click.argument("project", type=FILE)
@click.option("--controller", "controllers", multiple=True, help="Name, as inverse; repeatable. Default: all.")
@click.option("--speed", "speeds", multiple=True, help='Of the motor, as "450 rpm"; repeatable. Default: five.')
@click.option(
    "--load-angle", "load_angles", multiple=True,
    help='Of the load, at which gravity is held, as "90 deg"; repeatable: the worst of them counts. Default: 0 deg.',
)  # fmt: skip
@click.option("--units", type=click.IntRange(0, 100_000), default=0, help="Units of the type, drawn at random.")
@click.option("--seed", type=click.IntRange(0), default=1, show_default=True, help="Seed of these units.")
@with_plant
@click.option("-o", "--output", type=FOLDER, help="Folder for tables, figures and order tables.")
@json_option
def compensate(project: Path, **given: Any) -> None:
    """Cancel the error with controllers designed on the project, each in closed loop against the plain loop.

    Without --speed, five speeds about the resonance are run, within those of the file. Ctrl-C keeps what is finished.
    """
    from .compensate import show

    show(project, **given)


@click.command("compensate-move")
@click.argument("project", type=FILE)
@click.argument("profile", nargs=-1)
@click.option("--controller", "controllers", multiple=True, help="Name; repeatable. Default: loop and inverse.")
@click.option(
    "--shaping",
    multiple=True,
    type=click.Choice(["ZV", "ZVD"]),
    help="Shape the reference of the plain loop; repeatable.",
)
@click.option("--window", help="Largest distance of a settled load from rest. Default: 1 arcmin.")
@with_plant
@click.option("-o", "--output", type=FOLDER, help="Folder for move.csv, move.json and move.svg.")
@json_option
def compensate_move(project: Path, profile: tuple[str, ...], **given: Any) -> None:
    """Move the load along PROFILE in closed loop, under several controllers and with shaped references.

    PROFILE is one part or several, as of `strainwave move`: "trapezoid, angle: 20 deg, time: 0.4 s". Without it the
    profile of the project file is taken.
    """
    from .on_the_way import show_move

    show_move(project, profile, **given)


@click.command("compensate-run-up")
@click.argument("project", type=FILE)
@click.option("--from", "low", help='Lowest speed of the motor, as "300 rpm". Default: that of the file.')
@click.option("--to", "high", help="Highest speed of the motor. Default: that of the file.")
@click.option(
    "--load-angle", help='Of the load, at which gravity is held while jumps are looked for. Default: "0 deg".'
)
@click.option("--time", "duration", default="10 s", show_default=True, help="Of the run-up, and of the run-down.")
@click.option("--controller", "controllers", multiple=True, help="Name; repeatable. Default: loop and inverse.")
@with_plant
@click.option("-o", "--output", type=FOLDER, help="Folder for run-up.csv, run-up.json and run-up.svg.")
@json_option
def compensate_run_up(project: Path, **given: Any) -> None:
    """Run through a range of speeds and back in closed loop: largest errors, and whether the drive still jumps."""
    from .on_the_way import show_run_up

    show_run_up(project, **given)
