"""What a visitor takes along: the project file, the Python script of a view, the report, what is in a log."""

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from ...files.logs.read import read_log
from ...files.project import Project
from ...study.identification.logs.log import Log
from ...study.identification.orders.order_scan import order_scan
from ...units import RPM
from ..report.report import write
from .state import Refused, yaml_of

SUFFIXES = (".csv", ".txt", ".dat", ".npz", ".mat", ".parquet", ".mf4")
MOST_SHOWN, MOST_SEGMENTS, MOST_LINES = 2000, 100, 12
HIGHEST = 60.0  # order that a log is searched for

SCRIPT = '''"""{title}: the pointing error over the speed, as `strainwave app` shows it."""

from pathlib import Path

import numpy as np
import strainwave as sw

PROJECT = """\\
{text}"""


def main() -> None:
    file = Path("project.yaml")
    file.write_text(PROJECT, encoding="utf-8")
    project = sw.read_project(file)
    found = project.response(coexisting=False)
    top = found.visited()[np.argmax(found.oscillation[found.visited()])]
    print(f"largest oscillation {{np.degrees(found.oscillation[top]) * 3600:.6g}} arcsec")
    print(f"at {{found.omega[top] * project.speeds.scale:.6g}} {{project.speeds.unit}}")


if __name__ == "__main__":
    main()
'''


def script_of(project: Project) -> str:
    """A Python script that computes what the page shows."""
    text = yaml_of(project).replace("\\", "\\\\").replace('"""', '\\"\\"\\"')
    title = " ".join(project.title.split()).replace("\\", "").replace('"', "'")
    return SCRIPT.format(title=title, text=text if text.endswith("\n") else text + "\n")


def report_of(project: Project, progress: Callable[[str, float], None]) -> str:
    """The report as one HTML page."""
    with tempfile.TemporaryDirectory() as folder:
        write(project, Path(folder) / "report", progress=progress)
        return (Path(folder) / "report" / "report.html").read_text(encoding="utf-8")


def log_of(name: str, content: bytes) -> dict[str, Any]:
    """What is in a log: channels, segments, orders of the deviation (Refused)."""
    suffix = Path(name).suffix.lower()
    if suffix not in SUFFIXES:
        raise Refused(f"a log ends in {', '.join(SUFFIXES)}; this name ends in {suffix[:20]!r}")
    if not content:
        raise Refused("the log is empty")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"log{suffix}"
        path.write_bytes(content)
        try:
            log = read_log(path)
        except (ValueError, RuntimeError) as error:
            raise Refused(" ".join(str(error).replace(str(path), "log").split())) from None
    return _told(log)


def _told(log: Log) -> dict[str, Any]:
    every = max(1, len(log) // MOST_SHOWN)
    segments = log.segments()[:MOST_SEGMENTS] if log.moving else ()
    return {
        "samples": len(log),
        "rate_Hz": log.rate,
        "from_s": log.time[0],
        "to_s": log.time[-1],
        "gaps": len(log.gaps),
        "ratio": log.ratio,
        "time": log.time[::every],
        "channels": [
            {"name": name, "unit": log.units[name], "low": np.min(v), "high": np.max(v), "values": v[::every]}
            for name, v in log.channels.items()
        ],
        "segments": [
            {"kind": part.kind, "start": part.start, "stop": part.stop, "rpm": part.speed / RPM} for part in segments
        ],
        "orders": _orders(log),
        "notes": [*log.notes, *log.doubts],
    }


def _orders(log: Log) -> dict[str, Any]:
    """Lines of the error between both shafts, or of the torque, over the angle; why there are none."""
    channels = log.channels
    angle = next((name for name in ("motor_angle", "load_angle") if name in channels), None)
    value = next((n for n in channels if n.endswith(("error", "torque", "current", "torsion"))), None)
    if angle is None or value is None:
        return {"lines": [], "why": "orders need an angle and an error, a torque or a current in the log"}
    turning = [part for part in log.segments() if part.kind == "constant speed"]
    try:
        runs = [log.run(value, angle, part=part) for part in turning[:8]] or [log.run(value, angle)]
        found = order_scan(runs, highest=HIGHEST)
    except ValueError as error:
        return {"lines": [], "why": " ".join(str(error).split())}
    lines = sorted(found.lines, key=lambda line: -line.amplitude)[:MOST_LINES]
    return {
        "of": value,
        "over": angle,
        "unit": found.unit,
        "lines": [
            {"order": ln.order, "amplitude": ln.amplitude, "error": ln.amplitude_error, "kind": ln.kind} for ln in lines
        ],
        "why": "" if lines else "no line stands out of the noise",
    }
