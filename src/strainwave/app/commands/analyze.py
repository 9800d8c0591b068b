"""`strainwave analyze`: from a project file to a folder with the report, results.json and CSV files."""

from dataclasses import replace
from pathlib import Path
from typing import Any

from ...files.project import Project, load
from ...study.analysis.analysis import Analysis, analyze
from ...study.analysis.remedies import CHANGE
from ..console import Progress, to_json
from ..output import staged
from ..report.report import write
from ..report.words import summary


def run(path: Path, folder: Path, as_json: bool) -> str:
    """Analyse a project file and return what is printed."""
    return print_out(analyse(load(path), folder), folder, as_json)


def analyse(project: Project, folder: Path) -> dict[str, Any]:
    """Analyse a project, write everything into `folder`, and return the results as plain data."""
    with staged(folder) as part, Progress(project.title) as progress:
        analysis = _analysis(project, progress)
        progress.show("writing the report", 0.99)
        return write(project, analysis, part)


def _analysis(project: Project, progress: Progress) -> Analysis:
    return analyze(
        project.system(reduced=True),
        project.speeds,
        gear=project.gear,
        train=project.train,
        rated_torque=project.rated_torque,
        limit=project.limit,
        loads=tuple((share, _with_load(project, share)) for share in (CHANGE, -CHANGE)),
        progress=progress.show,
    )


def _with_load(project: Project, share: float) -> Any:
    """The error equation with the load's inertia changed by a share of it."""
    drive = project.drive._replace(J_l=(1.0 + share) * project.drive.J_l)
    return replace(project, drive=drive).system(reduced=True)


def print_out(results: dict[str, Any], folder: Path, as_json: bool) -> str:
    """Return the JSON of the results, or their summary with the place of the report."""
    return to_json(results) if as_json else f"{summary(results)}\n  report: {folder / 'report.html'}"
