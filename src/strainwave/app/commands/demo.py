"""`strainwave demo`: the main job on the article's drive and on a real catalogue drive."""

from importlib.resources import as_file, files
from pathlib import Path

from ...files.reading import read_project
from ..console import to_json
from .analysis.analyze import finished, printed

DRIVES = ("article", "CSG-40-50")


def run(folder: Path, as_json: bool) -> str:
    """Analyse both drives into subfolders and return what is printed.

    Raises
    ------
    KeyboardInterrupt
        With the sentence that says what was finished, if the user stops it.
    """
    projects = {}
    for name in DRIVES:
        with as_file(files("strainwave.app") / "projects" / f"{name}.yaml") as path:
            projects[name] = read_project(path)
    reports = finished(projects, folder)
    if as_json:
        return to_json({name: report.results for name, report in reports.items()})
    return "\n\n".join(printed(report, folder / name) for name, report in reports.items())
