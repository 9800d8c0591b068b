"""What the commands of identification take; their work is imported inside, so that `--help` answers at once."""

from pathlib import Path
from typing import Any

import click

from .texts import pairs

PATH = click.Path(path_type=Path)
FOLDER = click.Path(file_okay=False, path_type=Path)


def reading(command: Any) -> Any:
    """Options of a command that reads logs."""
    options = (
        click.option(
            "--column", "columns", multiple=True, callback=pairs, metavar="CHANNEL=COLUMN",
            help="Name or place (0 is the first) of the column of a channel: load_angle=pos, torque=3; repeatable.",
        ),
        click.option(
            "--unit", "units", multiple=True, callback=pairs, metavar="CHANNEL=UNIT",
            help='Unit of a channel, as load_angle=deg, or the size of 1: "load_angle=0.088 deg"; repeatable.',
        ),
        click.option("--rate", type=float, help="Samples per second of a file without a time."),
        click.option("--ratio", type=float, help="Ratio of the gear: the log of another one is refused."),
        click.option("--trim", type=float, help="Seconds left out at the begin; 0 keeps all. Default: a transient."),
        click.option("--delimiter", help='Column separator; " " for any number of blanks. Default: found.'),
        click.option("--decimal", help="Decimal separator. Default: found."),
    )  # fmt: skip
    for option in reversed(options):
        command = option(command)
    return command


@click.command("loop-scan")
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--rated-torque", help='For lost motion and hysteresis loss, as "67 N*m". Default: the largest measured.')
@click.option("--ratio", type=float, help="Ratio of the gear, for the block of a project file.")
@click.option("--torsion", default="torsion", show_default=True, help='Column of the torsion, as "Winkel [arcmin]".')
@click.option("--torque", default="torque", show_default=True, help='Column of the torque, as "Moment [N*m]".')
@click.option("--delimiter", help='Column separator; " " for any number of blanks. Default: found.')
@click.option("--decimal", help="Decimal separator. Default: found.")
@click.option(
    "-o", "--output", type=click.Path(file_okay=False, path_type=Path),
    help="Folder for loop.svg, loop.csv, loop.json and gear.yaml, the block of a project file.",
)  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Print the result as JSON.")
def loop_scan(**given: Any) -> None:
    """Identify the torsion law of a gear from a measured loop of torque over torsion, with intervals of 95 %.

    FILE is what `strainwave log` reads: CSV in any dialect, .npz, .mat, .parquet or .mf4; it needs no time.
    """
    from .loop_scan import show

    show(**given)


@click.command()
@click.argument("project", type=PATH)
@click.argument("files", nargs=-1, required=True, type=PATH)
@click.option(
    "-o", "--output", required=True, type=FOLDER,
    help="Folder for identified.yaml, the project file with what was found, identified.json and identified.svg.",
)  # fmt: skip
@click.option(
    "--free",
    help='Numbers to find, by their names in the file: "gear.K1, damping.B, torsion.offset". Default: usual ones.',
)
@click.option(
    "--between", type=click.Choice(["band-limited", "linear", "held"]), default="band-limited", show_default=True,
    help="What the motor's angle does between samples.",
)  # fmt: skip
@reading
@click.option("--json", "as_json", is_flag=True, help="Print the result as JSON.")
def identify(
    project: Path, files: tuple[Path, ...], free: str | None, between: str, output: Path, as_json: bool, **given: Any
) -> None:
    """Find numbers of a drive from logs of the angles of its motor and its load.

    PROJECT is a project file with the first guess; FILES are logs as `strainwave log` reads them, with a time,
    motor_angle and load_angle. The project file that is written has the numbers found, and their uncertainty as its
    scatter.
    """
    from .identify import show

    show(project, files, free, between, output, given, as_json)


@click.command("order-scan")
@click.argument("files", nargs=-1, required=True, type=PATH)
@click.option(
    "--channel", help="Quantity whose lines are sought. Default: torsion, error, torque or current, the first."
)
@click.option("--angle", help="Channel of the angle that the orders count on. Default: load_angle, else motor_angle.")
@click.option("--orders", help="Orders to fit, as 100,200,202.5. Default: those found.")
@click.option("--highest", type=float, help="Highest order looked for.")
@click.option("-o", "--output", type=FOLDER, help="Folder for orders.csv, orders.json and orders.svg.")
@reading
@click.option("--json", "as_json", is_flag=True, help="Print the result as JSON.")
def order_scan(files: tuple[Path, ...], output: Path | None, as_json: bool, **given: Any) -> None:
    """Find the orders of a quantity that was logged while a shaft turned, and tell orders from frequencies.

    FILES are logs as `strainwave log` reads them; their stretches of constant speed are taken, all together. Two
    speeds tell an order from a frequency, and a delay from a phase.
    """
    from .order_scan import show

    show(files, output, given, as_json)
