"""`strainwave demo`: the main job on the article's drive and on a real catalogue drive."""

from importlib.resources import as_file, files
from pathlib import Path
from typing import Any


from .console import to_json
from .job import analyse
from .project import load
from .report import summary

DRIVES = ("article", "CSG-40-50")


def run(folder: Path, as_json: bool) -> str:
    """Analyse both drives into subfolders and return what is printed.

    Raises
    ------
    KeyboardInterrupt
        With the sentence that says what was finished, if the user stops it.
    """
    done: dict[str, dict[str, Any]] = {}
    for name in DRIVES:
        try:
            with as_file(files("strainwave.app") / "projects" / f"{name}.yaml") as path:
                done[name] = analyse(load(path), folder / name)
        except KeyboardInterrupt:
            kept = [str(folder / finished / "report.html") for finished in done]
            raise KeyboardInterrupt(f"interrupted; {'kept: ' + ', '.join(kept) if kept else 'nothing was written'}") from None
    if as_json:
        return to_json(done)
    parts = [f"{summary(results)}\n  report: {folder / name / 'report.html'}" for name, results in done.items()]
    return "\n\n".join(parts)
