"""Files that the page exports: the Python script of a view, and the report."""

import re
import tempfile
from collections.abc import Callable
from pathlib import Path

from ...drive.project import Project
from ..report.report import write
from .state import Refused, ScriptRequest, project_of, yaml_of

FRAME = '''"""{title}: {what}, as `strainwave app` shows it. With the name of a file, as picture.svg, it draws."""

import sys
from pathlib import Path

import numpy as np
import strainwave as sw
from strainwave.files.reading import from_text

PROJECT = """\\
{text}"""


def main():
    project = from_text(PROJECT, Path("project.yaml"))  # in memory: no file is written
{body}

if __name__ == "__main__":
    shown = main()
    if len(sys.argv) > 1:
        shown.plot().figure.savefig(sys.argv[1])
'''
RESPONSE = """\
    found = project.response(coexisting=False)
    top = found.top
    print(f"largest oscillation {np.degrees(found.oscillation[top]) * 3600:.6g} arcsec")
    print(f"at {found.omega[top] * project.speeds.scale:.6g} {project.speeds.unit}")
    return found
"""
MOTION = """\
    found = sw.drive_motion(project, SPEED / project.speeds.scale)
    x = np.degrees(found.error) * 3600
    print(f"the {found.name} lies between {x.min():.6g} and {x.max():.6g} arcsec")
    print(f"and oscillates by {np.degrees(found.oscillation) * 3600:.6g} arcsec about its mean")
    return found.begun
"""
MOVE = """\
    profile = None if project.move is not None else sw.SCurve(np.pi / 2, 0.6)
    found = sw.move(project, profile)
    print(f"largest pointing error {np.degrees(found.peak_error) * 3600:.6g} arcsec in {found.duration:.6g} s")
    return found
"""
SPEED_MAP = """\
    found = sw.speed_map(project, loads=LOADS, search=SEARCH)
    for low, high in found.windows * found.axis.scale:
        print(f"allowed: {low:.6g} to {high:.6g} {found.axis.unit}")
    return found
"""
COMPENSATION = """\
    found = sw.compensate(project)
    for name, rest in (("before", found.before), ("after", found.after)):
        print(f"{name}: {np.degrees(rest.rms) * 3600:.6g} arcsec rms")
    print(*found.warnings, *found.remarks, sep="\\n")
    return found
"""
PLACEHOLDER = re.compile(r"\b(?:SPEED|SEARCH|LOADS)\b")
VIEWS = {
    "response": ("the pointing error over the speed", RESPONSE),
    "motion": ("the motion at a speed", MOTION),
    "move": ("the move", MOVE),
    "speed-map": ("the speed map", SPEED_MAP),
    "compensation": ("the error before and after compensation", COMPENSATION),
}


def script_of(request: ScriptRequest) -> str:
    """Python script that computes the data of a view (Refused)."""
    project = project_of(request.state)
    text = yaml_of(project).replace("\\", "\\\\").replace('"""', '\\"\\"\\"')
    title = " ".join(project.title.split()).replace("\\", "").replace('"', "'")
    subject, body = VIEWS[request.view]
    values: dict[str, object] = {}
    if request.view == "motion":
        if request.speed is None:
            raise Refused("the script of a motion needs its speed")
        values = {"SPEED": request.speed}
    elif request.view == "speed-map":
        values = {"SEARCH": request.search, "LOADS": list(request.loads) or None}
    body = PLACEHOLDER.sub(lambda name: repr(values[name[0]]), body)  # one pass: values are never looked at again
    return FRAME.format(title=title, what=subject, text=text.rstrip("\n") + "\n", body=body)


def report_of(project: Project, progress: Callable[[str, float], None]) -> str:
    """The report as one HTML page, its appendix below it."""
    with tempfile.TemporaryDirectory() as folder:
        write(project, Path(folder) / "report", progress=progress)
        report = (Path(folder) / "report" / "report.html").read_text(encoding="utf-8")
        appendix = (Path(folder) / "report" / "appendix.html").read_text(encoding="utf-8")
    main = appendix[appendix.index("<main>") : appendix.index("</body>")].replace('"report.html"', '"#"')
    main = main.replace("<main>", '<main id="appendix">')
    return report.replace('"appendix.html"', '"#appendix"').replace("</body>", main + "</body>")
