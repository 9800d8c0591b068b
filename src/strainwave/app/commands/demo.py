"""`strainwave demo`: the main job on the article's drive and on a real catalogue drive."""

from importlib.resources import as_file, files
from pathlib import Path
from typing import Any

from ...files.project import load
from ..console import to_json
from ..report.words import summary
from .analyze import analyse

DRIVES = ("article", "CSG-40-50")


def run(folder: Path, as_json: bool) -> str:
    """Analyse both drives into subfolders and return what is printed.

    Raises
    ------
    KeyboardInterrupt
        With the sentence that says what was finished, if the user stops it.
    """
    projects = files("strainwave.app") / "projects"
    reports = {name: folder / name / "report.html" for name in DRIVES}
    results: dict[str, dict[str, Any]] = {}
    for name in DRIVES:
        with as_file(projects / f"{name}.yaml") as path:
            try:
                results[name] = analyse(load(path), folder / name)
            except KeyboardInterrupt:
                kept = ", ".join(str(reports[done]) for done in results)
                raise KeyboardInterrupt(f"interrupted; {f'kept: {kept}' if kept else 'nothing was written'}") from None
    return _printed(results, reports, as_json)


def _printed(results: dict[str, dict[str, Any]], reports: dict[str, Path], as_json: bool) -> str:
    if as_json:
        return to_json(results)
    return "\n\n".join(f"{summary(results[name])}\n  report: {reports[name]}" for name in results)
