"""What `strainwave log` takes."""

from pathlib import Path
from typing import Any

import click

from .commands import reading


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "-o", "--output", type=click.Path(file_okay=False, path_type=Path), help="Folder for log.csv and log.svg."
)
@click.option("--columns", "names", help='All columns in their order, as "time,load_angle,-,torque"; - leaves one out.')
@reading
@click.option("--json", "as_json", is_flag=True, help="Print the result as JSON.")
def log(file: Path, output: Path | None, as_json: bool, **given: Any) -> None:
    """Read a log of measured channels and say what is in it: units, rate, gaps, segments, doubts.

    FILE is CSV in any dialect, .npz, .mat, .parquet or .mf4. Angles and speeds of the load count on the output shaft.
    """
    from .log_summary import show

    show(file, output, given, as_json)
