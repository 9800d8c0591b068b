"""What the commands of identification take; their work is imported inside, so that `--help` answers at once."""

from pathlib import Path
from typing import Any

import click


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
