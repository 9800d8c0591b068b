"""`strainwave identify`: a project file with the numbers that logs of its drive tell."""

from pathlib import Path
from shlex import quote
from typing import Any

import click
import numpy as np

from ....compile.tree import part
from ....files.identified.identify_drive import IdentifiedDrive, identify_drive, with_torsion
from ....files.logs.read import read_log
from ....files.project_text import project_text
from ....files.reading import read_project
from ....plot.fits import torsion_panels
from ....plot.svg import figure
from ....study.identification.identified import channels_of
from ...console import Progress, number, print_table, to_json
from ...output import staged
from ...view import sign
from ..options import file_type, json_option, output_option, project_argument, reading_options

YAML, JSON, SVG = "identified.yaml", "identified.json", "identified.svg"


@click.command()
@project_argument
@click.argument("files", nargs=-1, required=True, type=file_type)
@output_option(
    "Folder for identified.yaml, the project file with what was found, identified.json and identified.svg.",
    required=True,
)
@click.option(
    "--free",
    help='Numbers to find, by their names in the file: "gear.K1, damping.B, torsion.offset". Default: usual ones.',
)
@click.option(
    "--between", type=click.Choice(["band-limited", "linear", "held"]), default="band-limited",
    help="What the motor's angle does between samples.",
)  # fmt: skip
@reading_options
@json_option
def identify(
    project: Path, files: tuple[Path, ...], free: str | None, between: Any, output: Path, as_json: bool, **reading: Any
) -> None:
    """Find numbers of a drive from logs of the angles of its motor and its load.

    PROJECT is a project file with the first guess; FILES are logs as `strainwave log` reads them, with a time,
    motor_angle and load_angle. The project file that is written has the numbers found, and their uncertainty as its
    scatter.
    """
    given = read_project(project)
    logs = [read_log(file, **reading) for file in files]
    names = None if free is None else tuple(name.strip() for name in free.split(",") if name.strip())
    with Progress(given.title) as progress:
        found = identify_drive(given, logs, names, between=between, progress=progress.show)
    torsions = [with_torsion(channels_of(log), given.drive.N)["torsion"] for log in logs]
    with staged(output) as folder:
        if found.usable:
            (folder / YAML).write_text(project_text(found.project), encoding="utf-8")
            (folder / JSON).write_text(to_json(data(found)) + "\n", encoding="utf-8")
        (folder / SVG).write_text(
            figure(torsion_panels(found.found, torsions), 230.0, "measured and computed torsion") + "\n",
            encoding="utf-8",
        )
    if not found.usable:
        for old in (YAML, JSON):  # of an earlier log: they would pass for this one's
            (output / old).unlink(missing_ok=True)
    if as_json:
        click.echo(to_json(data(found)))
        return
    _print(given, found)
    if found.usable:
        told = f"{output / YAML}, {JSON}, {SVG}; next: strainwave analyze {quote(str(output / YAML))} -o report"
    else:
        told = f"{output / SVG}; no file of numbers is: find what the model lacks first"
    click.echo(f"written: {told}")


def data(found: IdentifiedDrive) -> dict[str, Any]:
    """The numbers with their intervals, in SI."""
    rest = found.found.discrepancy
    return {
        "headline": found.headline(),
        "usable": found.usable,
        "unexplained": found.unexplained,
        "numbers": {
            name: {"value": found.value(name), "low": found.interval(name).low, "high": found.interval(name).high}
            for name in found.names
        },
        "correlation": _correlation(found.found.covariance),
        "residual_rms_rad": float(found.found.rms[0]),
        "torsion_rms_rad": float(found.found.size[0]),
        "samples": found.found.residual.shape[1],
        "between": found.found.between,
        "residual_white": rest.white,
        "terms_lacking": list(rest.flagged),
        "remarks": list(found.remarks),
    }


def _correlation(covariance: Any) -> list[list[float]]:
    deviations = np.sqrt(np.diag(covariance))
    rows: list[list[float]] = (covariance / np.outer(deviations, deviations)).tolist()
    return rows


def _print(given: Any, found: IdentifiedDrive) -> None:
    rows = []
    for name, path in zip(found.names, found.found.names, strict=True):
        low, high = found.interval(name)
        first = "" if path.startswith(("x.", "reference.", "load.excitation.")) else number(part(given.whole, path), 5)
        rows.append(
            (name, first, number(found.value(name), 6), number(low, 6), number(high, 6), sign(found.unit(name)))
        )
    click.echo(found.headline())
    columns = ("number", "given", "found", "from", "to", "unit")
    print_table(f"{given.title}: {len(rows)} numbers", columns, rows, "interval of 95 %, if the model is right")
    for line in found.quality()[1:]:
        click.echo(line)
