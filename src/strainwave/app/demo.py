"""`strainwave demo`: the main job on the article's drive and on a real catalogue drive, both at once."""

import json
import subprocess
import sys
from importlib.resources import as_file, files
from pathlib import Path
from typing import Any

from .console import to_json
from .job import analyse
from .project import load
from .report import summary

HERE, BESIDE = "CSG-40-50", "article"  # the second one runs in a process of its own


def run(folder: Path, as_json: bool) -> str:
    """Analyse both drives into subfolders and return what is printed.

    Raises
    ------
    KeyboardInterrupt
        With the sentence that says what was finished, if the user stops it.
    RuntimeError
        If one of the two runs fails.
    """
    reports = {name: folder / name / "report.html" for name in (BESIDE, HERE)}
    before = {name: _written(report) for name, report in reports.items()}
    projects = files("strainwave.app") / "projects"
    with as_file(projects / f"{BESIDE}.yaml") as other, as_file(projects / f"{HERE}.yaml") as mine:
        command = [sys.executable, "-m", "strainwave", "analyze", str(other), "-o", str(folder / BESIDE), "--json"]
        child = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, encoding="utf-8")
        try:
            results = {HERE: analyse(load(mine), folder / HERE)}
            printed, complaints = child.communicate()
        except KeyboardInterrupt:
            _stop(child)
            kept = [str(report) for name, report in reports.items() if _written(report) != before[name]]
            said = f"kept: {', '.join(kept)}" if kept else "nothing was written"
            raise KeyboardInterrupt(f"interrupted; {said}") from None
        except BaseException:
            _stop(child)
            raise
    if child.returncode != 0:
        raise RuntimeError(
            f"the analysis of the {BESIDE} drive failed: {complaints.strip().splitlines()[-1:] or child.returncode}"
        )
    results[BESIDE] = json.loads(printed)
    return _printed({name: results[name] for name in (BESIDE, HERE)}, reports, as_json)


def _printed(results: dict[str, dict[str, Any]], reports: dict[str, Path], as_json: bool) -> str:
    if as_json:
        return to_json(results)
    return "\n\n".join(f"{summary(results[name])}\n  report: {reports[name]}" for name in results)


def _written(report: Path) -> int | None:
    """When a report was written last [ns], None where there is none."""
    return report.stat().st_mtime_ns if report.exists() else None


def _stop(child: "subprocess.Popen[str]") -> None:
    """End the other run and wait until it has cleaned up."""
    child.terminate()
    child.communicate()
