"""`strainwave analyze`: from a project file to a folder with the report, results.json and CSV files."""

from pathlib import Path

from ...files.project import Project
from ...files.reading import read_project
from ..console import Progress, to_json
from ..report.report import Report, write


def run(path: Path, folder: Path, as_json: bool) -> str:
    """Analyse a project file and return what is printed."""
    report = analyse(read_project(path), folder)
    return to_json(report.results) if as_json else printed(report, folder)


def checked(path: Path, as_json: bool) -> str:
    """Read a project file and return what is printed: that it is valid, and what looks wrong."""
    project = read_project(path)
    if as_json:
        return to_json({"valid": True, "title": project.title, "notes": project.notes})
    return "\n".join([f"{path}: valid", str(project), *(f"  note: {note}" for note in project.notes)])


def analyse(project: Project, folder: Path) -> Report:
    """Write the report of a project into a folder, with its progress on stderr."""
    with Progress(project.title) as progress:
        return write(project, folder, progress=progress.show)


def printed(report: Report, folder: Path) -> str:
    """The summary of a report with its place."""
    return f"{report.summary}\n  report: {folder / 'report.html'}"
