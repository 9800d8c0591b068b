"""What `strainwave log` takes."""

from pathlib import Path
from typing import Any

import click

from .texts import pairs


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "-o", "--output", type=click.Path(file_okay=False, path_type=Path), help="Folder for log.csv and log.svg."
)
@click.option(
    "--column", "columns", multiple=True, callback=pairs, metavar="CHANNEL=COLUMN",
    help="Name or place (0 is the first) of the column of a channel: load_angle=pos, torque=3; repeatable.",
)  # fmt: skip
@click.option("--columns", "names", help='All columns in their order, as "time,load_angle,-,torque"; - leaves one out.')
@click.option(
    "--unit", "units", multiple=True, callback=pairs, metavar="CHANNEL=UNIT",
    help='Unit of a channel, as load_angle=deg, or the size of 1: "load_angle=0.088 deg"; repeatable.',
)  # fmt: skip
@click.option("--rate", type=float, help="Samples per second of a file without a time.")
@click.option("--ratio", type=float, help="Ratio of the gear: the log of another one is refused.")
@click.option("--trim", type=float, help="Seconds to leave out at the begin; 0 keeps all. Default: a transient.")
@click.option("--delimiter", help='Column separator; " " for any number of blanks. Default: found.')
@click.option("--decimal", help="Decimal separator. Default: found.")
@click.option("--json", "as_json", is_flag=True, help="Print the result as JSON.")
def log(file: Path, output: Path | None, as_json: bool, **given: Any) -> None:
    """Read a log of measured channels and say what is in it: units, rate, gaps, segments, doubts.

    FILE is CSV in any dialect, .npz, .mat, .parquet or .mf4. Angles and speeds of the load count on the output shaft.
    """
    from .log_summary import show

    show(file, output, given, as_json)
