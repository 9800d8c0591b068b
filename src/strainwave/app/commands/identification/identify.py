"""`strainwave identify`: the numbers of a joint from its logs, and a project file with them."""

from pathlib import Path
from shlex import quote
from typing import Any

import click
import numpy as np

from ....base.facts import data, lines
from ....base.results import SolveError
from ....base.units import ARCSEC, parse
from ....drive.project import Project
from ....files.logs.read import read_log as log_of
from ....files.project_text import project_text
from ....files.reading import read_project
from ....files.variants.identify_log import identify_log as identified
from ....files.variants.scatter import scattered
from ....plot.fits import identified_log_rows
from ....plot.svg import figure
from ...console import Progress, echo, to_json, write_all
from ...report.section import rendered_part
from ...report.sections.opening import opening
from ...view import View
from ..options import file_type, json_option, output_option, reading_options

YAML, JSON, SVG = "identified.yaml", "identified.json", "identified.svg"
PROJECTS = (".yaml", ".yml")
DRAWN = 40  # drives by the intervals


@click.command()
@click.argument("files", nargs=-1, required=True, type=file_type)
@click.option("--gear", help="Name of a gear of the catalogue, instead of a project file.")
@click.option("--load-inertia", help='Inertia of the load, "2.9 kg*m^2". Default: the project file\'s.')
@click.option("--torque-constant", help='Torque constant of the motor, "0.12 N*m/A". Default: the project file\'s.')
@output_option("Folder for identified.yaml, a project file with the results, identified.json and identified.svg.")
@reading_options
@json_option
def identify(
    files: tuple[Path, ...], gear: str | None, load_inertia: str | None, torque_constant: str | None,
    output: Path | None, as_json: bool, **reading: Any,
) -> None:  # fmt: skip
    """Find stiffness, damping and error of a joint in its logs.

    FILES are logs as `strainwave read-log` reads them, with a time, motor_angle and load_angle. A project file (.yaml)
    or a gear of the catalogue gives the start values. With a current or a motor_torque, the motor's inertia and
    friction are identified too. Time steps may be uneven and rows may be missing. Numbers that a log does not
    determine are named, with the motion that determines them.
    """
    projects = [file for file in files if file.suffix.lower() in PROJECTS]
    if len(projects) > 1 or (bool(projects) == (gear is not None)):
        raise click.UsageError("give one project file (.yaml) or --gear NAME, and the logs")
    inertia = None if load_inertia is None else parse(load_inertia, "kg*m**2")
    constant = None if torque_constant is None else parse(torque_constant, "N*m/A")
    guess = read_project(projects[0]) if projects else None
    reading |= {"trim": reading["trim"] or 0.0}  # the run-up tells more than a constant speed
    logs = [log_of(file, keep=True, **reading) for file in files if file not in projects]
    if not logs:
        raise click.UsageError("give at least one log of the joint")
    with Progress(gear or (guess.title if guess else "")) as progress:
        result = identified(logs, gear, guess, inertia, torque_constant=constant, progress=progress.show)
    numbers = to_json(data(result.facts()))
    if output is not None:
        contents = {SVG: figure(identified_log_rows(result), 230.0, "measured and predicted torsion"), JSON: numbers}
        if result.project is not None:
            contents |= {YAML: project_text(result.project)}
        write_all(output, contents)
        if result.project is None:
            (output / YAML).unlink(missing_ok=True)  # of an earlier log: it would pass for this one's
    doubts = [f"note: {sentence}" for log in logs for sentence in (*log.doubts, *log.notes)]
    echo(numbers if as_json else "\n".join([*lines(result.facts()), *dict.fromkeys(doubts)]))
    if not result.usable:
        raise SolveError(f"no project file is written: {result.headline()}")
    if output is not None and not as_json:
        written = f"{output / YAML}, {JSON}, {SVG}"
        echo(f"written: {written}; next: strainwave analyze {quote(str(output / YAML))} -o report")
    if result.project is not None and not as_json:
        echo("\n".join(verdict(result.project)))


def verdict(project: Project) -> list[str]:
    """The verdict of `analyze` on the drive that was found, and the range of its oscillation by the intervals."""
    try:
        with Progress(project.title) as progress:
            text = rendered_part(opening, View.of(project, project.analyze(progress.show, advice=False))).lines
    except (SolveError, ValueError) as error:
        return [f"No verdict: {error}"]
    return [*text, oscillation_range(project)]


def oscillation_range(project: Project) -> str:
    """Range of the oscillation of drives that are drawn by the intervals, or why there is none."""
    if project.has_memory:  # each of its responses is an integration
        return "No response range for the intervals: a gear with hysteresis needs a time integration per response."
    try:
        peaks = [float(np.max(one.response().oscillation)) for one in scattered(project, DRAWN)]
    except (SolveError, ValueError) as error:
        return f"No response range for the intervals: {error}"
    low, high = (f"{size / ARCSEC:.4g}" for size in np.quantile(peaks, (0.025, 0.975)))
    return f"Largest oscillation within the confidence intervals: {low} to {high} arcsec (95 % of {DRAWN} drives)."
