"""`strainwave identify`: a project file with parameters identified from logs of its drive."""

from pathlib import Path
from shlex import quote
from typing import Any

import click
import numpy as np

from ....base.results import SolveError
from ....compile.tree import part
from ....drive.project import Project
from ....files.logs.read import read_log as log_of
from ....files.project_text import project_text
from ....files.reading import read_project
from ....files.variants.identify_drive import IdentifiedDrive, with_torsion
from ....files.variants.identify_drive import identify_drive as identified
from ....plot.fits import torsion_panels
from ....plot.panels import named
from ....plot.svg import figure
from ....study.identification.identified import channels_of
from ...console import Progress, number, print_table, to_json, write_all
from ...view import sign
from ..options import file_type, json_option, output_option, project_argument, reading_options

YAML, JSON, SVG = "identified.yaml", "identified.json", "identified.svg"
UNLIKE = "the model does not explain the motion; check that log and project are of one drive, or improve the project"


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
    """Find numbers of a drive in logs of its two angles.

    PROJECT is a project file with the first guess; FILES are logs as `strainwave read-log` reads them, with a time,
    motor_angle and load_angle. The project file that is written has the numbers found, and their uncertainty as its
    scatter.
    """
    guess = read_project(project)
    logs = [log_of(file, **reading) for file in files]
    names = None if free is None else tuple(filter(None, map(str.strip, free.split(","))))
    with Progress(guess.title) as progress:
        result = identified(guess, logs, names, between=between, progress=progress.show)
    torsions = [with_torsion(channels_of(log), guess.drive.N)["torsion"] for log in logs]
    numbers = to_json(data(result))
    rows = torsion_panels(result.found, torsions)
    panels = [named(rows[0], guess.title), *rows[1:]]
    contents = {SVG: figure(panels, 230.0, "measured and computed torsion")}
    if result.usable:
        contents |= {YAML: project_text(result.project), JSON: numbers}
    write_all(output, contents)
    if not result.usable:
        for old in (YAML, JSON):  # of an earlier log: they would pass for this one's
            (output / old).unlink(missing_ok=True)
    if as_json:
        click.echo(numbers)
    else:
        _print(guess, result)
    if not result.usable:
        raise SolveError(f"no project file is written, only {output / SVG}: {UNLIKE}")
    if not as_json:
        written = f"{output / YAML}, {JSON}, {SVG}"
        click.echo(f"written: {written}; next: strainwave analyze {quote(str(output / YAML))} -o report")


def data(result: IdentifiedDrive) -> dict[str, Any]:
    """The numbers with their intervals, in SI."""
    discrepancy, deviations = result.found.discrepancy, np.sqrt(np.diag(result.found.covariance))
    return {
        "headline": result.headline(),
        "usable": result.usable,
        "unexplained": result.unexplained,
        "numbers": {
            name: {"value": result.value(name), "low": result.interval(name).low, "high": result.interval(name).high}
            for name in result.names
        },
        "correlation": result.found.covariance / np.outer(deviations, deviations),
        "residual_rms_rad": float(result.found.rms[0]),
        "torsion_rms_rad": float(result.found.size[0]),
        "samples": result.found.residual.shape[1],
        "between": result.found.between,
        "residual_white": discrepancy.white,
        "terms_lacking": list(discrepancy.flagged),
        "remarks": list(result.remarks),
    }


def _print(guess: Project, result: IdentifiedDrive) -> None:
    rows = []
    for name, path in zip(result.names, result.found.names, strict=True):
        first = "" if path.startswith(("x.", "reference.", "load.excitation.")) else number(part(guess.whole, path), 5)
        sizes = (number(size, 6) for size in (result.value(name), *result.interval(name)))
        rows.append((name, first, *sizes, sign(result.unit(name))))
    click.echo(result.headline())
    columns = ("number", "given", "found", "from", "to", "unit")
    print_table(f"{guess.title}: {len(rows)} numbers", columns, rows, "interval of 95 %, if the model is right")
    for line in result.quality()[1:]:
        click.echo(line)
