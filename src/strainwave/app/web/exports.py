"""Files that the page exports: the Python script of a session, and the report."""

import tempfile
from pathlib import Path
from textwrap import indent

from ...base.terminal import Progress
from ...drive.project import Project
from ..report.report import write
from .first_project import first_sources
from .requests import Action, Refused, ScriptRequest, Seen, State
from .state import project_of, yaml_of

FRAME = '''"""{title}: the session of `strainwave app`, a line an action. With a file name, as picture.svg, it draws."""

import sys
from pathlib import Path

import numpy as np
import strainwave as sw
from strainwave.files.reading import from_text

PROJECT = """\\
{text}"""


def main():
    project = drive = from_text(PROJECT, Path("project.yaml"))  # in memory: no file is written
{body}
    return found


if __name__ == "__main__":
    shown = main()
    if len(sys.argv) > 1:
        shown.plot().figure.savefig(sys.argv[1])
'''
RESPONSE = """\
top = found.top
print(f"largest oscillation {np.degrees(found.oscillation[top]) * 3600:.6g} arcsec")
print(f"at {found.omega[top] * project.speeds.scale:.6g} {project.speeds.unit}")"""
MOTION = """\
x = np.degrees(found.error) * 3600
print(f"the {found.name} lies between {x.min():.6g} and {x.max():.6g} arcsec")
print(f"and oscillates by {np.degrees(found.oscillation) * 3600:.6g} arcsec about its mean")
found = found.begun"""
MOVE = 'print(f"largest pointing error {np.degrees(found.peak_error) * 3600:.6g} arcsec in {found.duration:.6g} s")'
SPEED_MAP = """\
for low, high in found.windows * found.axis.scale:
    print(f"allowed: {low:.6g} to {high:.6g} {found.axis.unit}")"""
COMPENSATION = """\
for name, rest in (("before", found.before), ("after", found.after)):
    print(f"{name}: {np.degrees(rest.rms) * 3600:.6g} arcsec rms")
print(*found.warnings, *found.remarks, sep="\\n")"""
VIEWS = {  # a view's call, and what the last one prints
    "response": ("project.response(coexisting=False)", RESPONSE),
    "motion": ("sw.drive_motion(project, {speed!r} / project.speeds.scale)", MOTION),
    "move": ('sw.move(project, None if project.move else "s_curve, angle: 90 deg, time: 0.6 s")', MOVE),
    "speed-map": ("sw.speed_map(project, loads={loads!r}, search={search!r})", SPEED_MAP),
    "compensation": ("sw.compensate(project)", COMPENSATION),
    "tuning": ("sw.tune(project)", "print(found)"),
}


def script_of(request: ScriptRequest) -> str:
    """Python script that repeats a session: a line for each change of the drive and for each view of it (Refused)."""
    base, title = State(gear=request.state.gear, project=request.state.project), project_of(request.state).title
    text = yaml_of(project_of(base)).replace("\\", "\\\\").replace('"""', '\\"\\"\\"')
    lines, values = list[str](), dict[str, str]()
    for action in (*request.before, request):
        if (now := action.values if isinstance(action, Action) else request.state.values) != values:
            values = now
            changed = values | first_sources(project_of(base), values)
            lines.append(f"project = sw.replaced(drive, {changed!r}, retune=True)" if values else "project = drive")
        if action.view:
            lines.append(f"found = {_call(action)}")
    body = "\n".join([*lines, VIEWS[request.view][1]])
    title = " ".join(title.split()).replace("\\", "").replace('"', "'")
    return FRAME.format(title=title, text=text.rstrip("\n") + "\n", body=indent(body, "    "))


def _call(action: Seen) -> str:
    """Call that computes a view (Refused)."""
    if action.view == "motion" and action.speed is None:
        raise Refused("the script of a motion needs its speed")
    return VIEWS[action.view][0].format(speed=action.speed, loads=list(action.loads) or None, search=action.search)


def report_of(project: Project, progress: Progress) -> str:
    """The report as one HTML page, its appendix below it."""
    with tempfile.TemporaryDirectory() as folder:
        write(project, Path(folder) / "report", progress=progress)
        report = (Path(folder) / "report" / "report.html").read_text(encoding="utf-8")
        appendix = (Path(folder) / "report" / "appendix.html").read_text(encoding="utf-8")
    main = appendix[appendix.index("<main>") : appendix.index("</body>")].replace('"report.html"', '"#"')
    main = main.replace("<main>", '<main id="appendix">')
    return report.replace('"appendix.html"', '"#appendix"').replace("</body>", main + "</body>")
