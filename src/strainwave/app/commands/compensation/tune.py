"""`strainwave tune`: the best gains of a motor's loop, as numbers, CSV, figure and project file."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from ....drive.project import Project
from ....files.project_text import project_text
from ....files.reading import read_project
from ....files.variants.scatter import scattered
from ....plot.panels import named
from ....plot.svg import stacked
from ....study.tuning.cost import GOALS
from ....study.tuning.result import TunedLoop
from ....study.tuning.tune import tune as tuned
from ...console import Progress, columns, echo, reported, write_all
from ..options import json_option, output_option, project_argument, quantity

CSV, SVG, JSON, YAML, NOTCHED = "tune.csv", "tune.svg", "tune.json", "tuned.yaml", "tuned-with-notch.yaml"


@click.command()
@project_argument
@click.option(
    "--goal", "goals", multiple=True, type=click.Choice(list(GOALS)),
    help="Goal to minimise; of several, the geometric mean of their ratios to the present values. "
    "Default: pointing, with compliance and settling no worse.",
)  # fmt: skip
@click.option("--gain", "gains", multiple=True, help="Gain to tune, for example K_p; repeatable. Default: all.")
@click.option("--peak-sensitivity", type=float, help="Largest |1/(1 + L)|, L the open loop. Default: 2.")
@click.option("--gain-margin", type=float, help="Smallest gain margin, as a factor.")
@click.option("--phase-margin", help='Smallest phase margin, for example "45 deg".')
@click.option(
    "--load", "loads", multiple=True, help='Torque on the load, as "-40 N*m"; repeatable. Default: the file\'s.'
)
@click.option("--units", type=click.IntRange(0, 5000), default=0, help="Additional drives, drawn from the scatter.")
@click.option("--seed", type=click.IntRange(0), default=0, help="Seed of the random drives.")
@click.option("--share", type=float, default=1.0, help="Fraction of the drives that must meet goals and limits.")
@click.option("--notch", is_flag=True, help="Also try a notch filter at the resonance with a free motor.")
@output_option(f"Folder for {YAML} with the recommended gains, {CSV}, {SVG} and {JSON}.")
@json_option
def tune(
    project: Path, goals: tuple[str, ...], gains: tuple[str, ...], peak_sensitivity: float | None,
    gain_margin: float | None, phase_margin: str | None, loads: tuple[str, ...], units: int, seed: int, share: float,
    notch: bool, output: Path | None, as_json: bool,
) -> None:  # fmt: skip
    """Find loop gains for a small error and given stability margins."""
    drive = read_project(project)
    margin = None if phase_margin is None else quantity("--phase-margin", phase_margin, "rad", "positive")
    torques = [quantity("--load", text, "N*m") for text in loads] or None
    profiles = () if drive.move is None else [name for name in drive.move.files if name]  # that both files name
    if output is not None and (name := next(filter({CSV, SVG, JSON, YAML, NOTCHED}.__contains__, profiles), "")):
        raise ValueError(f"the profile {name!r} has the name of an output file of this command; rename the profile")
    with Progress(drive.title) as progress:
        more = tuple(scattered(drive, units, seed)) if units else ()
        result = tuned(
            drive, goals=goals or None, gains=gains or None, peak_sensitivity=peak_sensitivity, gain_margin=gain_margin,
            phase_margin=margin, loads=torques, units=more, share=share, notch=notch, progress=progress.show,
        )  # fmt: skip
        progress.show("writing", 0.99)
        fault = None if output is None else _write(drive, result, output, profiles)
    echo(reported(drive.title, result.facts(), as_json, *([] if output is None else [f"written: {output}"])))
    if fault:
        raise fault


def _write(project: Project, tuned: TunedLoop, output: Path, profiles: Sequence[str]) -> ValueError | None:
    """Write the files; why there is no project file, where one cannot hold the result."""
    label = "response before and after, goal over peak sensitivity"
    drawn = stacked(named(tuned.panels(), project.title), 280.0, label)
    files: dict[str, Any] = {name: (project.path.parent / name).read_bytes() for name in profiles}
    files |= {CSV: columns(tuned.variables()), SVG: drawn, JSON: reported(project.title, tuned.facts(), True)}
    fault = None
    try:
        files[YAML] = project_text(tuned.applied(project))
        if tuned.notch is not None:
            files[NOTCHED] = project_text(tuned.applied(project, notch=True))
    except ValueError as error:
        fault = error
    write_all(output, files)
    return fault
