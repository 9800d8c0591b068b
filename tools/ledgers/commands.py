"""Every command of the command line, by what it prints with `--json`."""

import json
import runpy
import sys
from contextlib import redirect_stderr, redirect_stdout
from functools import cache
from io import StringIO
from pathlib import Path
from unittest.mock import patch

import numpy as np
from twelve_projects import PROJECTS

from .drives import AXIS_FILE, EXACT
from .files import ANGLE
from .measured import drive_record, guessed, loop_record, noisy_run, scan_record

PRINTED = 1e-6  # extremes over curves among them
LEFT_OUT = {
    "provenance",
    "versions",
    "file",
    "files",
    "folder",
    "output",
    "command",
    "curve",
    "title",
    "project",
    "derived",
    "conventions",
    "source",
}
OTHER_UNITS = ("_rpm", "_arcsec", "hertz")


def csv(path, **columns):
    """A file of columns."""
    head = ",".join(columns)
    np.savetxt(path, np.column_stack(list(columns.values())), delimiter=",", header=head, comments="", fmt="%.12g")


@cache
def prepared():
    """Files that the commands read."""
    Path("axis.yaml").write_text(AXIS_FILE, encoding="utf-8")
    for i, text in enumerate(PROJECTS.values()):
        Path(f"p{i}.yaml").write_text(text, encoding="utf-8")
    elbow = Path(__file__).resolve().parents[2] / "examples" / "projects" / "elbow.yaml"
    Path("elbow.yaml").write_text(elbow.read_text(encoding="utf-8"), encoding="utf-8")
    torsion, torque = loop_record()
    csv("loop.csv", **{"torsion [rad]": torsion, "torque [N*m]": torque})
    angle, forward, back = scan_record()
    csv("error.csv", **{"angle [rad]": angle, "error [rad]": forward, "backward [rad]": back})
    runs = [noisy_run(60.0, 0), noisy_run(90.0, 1)]
    for i, run in enumerate(runs):
        csv(f"run{i}.csv", **{"time [s]": run.time, "load_angle [rad]": run.angle, "torque [N*m]": run.value})
    ANGLE.write("table.json", "json")
    record = drive_record(guessed())
    csv("record.csv", **{"time [s]": record["time"], "motor_angle [rad]": record["motor_angle"],
                         "load_angle [rad]": record["load_angle"]})  # fmt: skip


def said(*words):
    """What a command prints as JSON, or its exit code and its sentence."""
    prepared()
    out, complaint, code = StringIO(), StringIO(), 0
    with patch.object(sys, "argv", ["strainwave", *words]), redirect_stdout(out), redirect_stderr(complaint):
        try:
            runpy.run_module("strainwave", run_name="__main__")
        except SystemExit as end:
            code = end.code or 0
    if code:
        return {"code": code, "sentence": complaint.getvalue().splitlines()[-1:]}
    return json.loads(out.getvalue()) if words[-1] == "--json" else out.getvalue().splitlines()


def short(data):
    """Data without what tells of the machine or says a number again in another unit; of long lists both ends."""
    if isinstance(data, dict):
        return {k: short(v) for k, v in data.items() if k not in LEFT_OUT and not k.endswith(OTHER_UNITS)}
    if isinstance(data, list) and len(data) > 2 and not isinstance(data[0], float):
        return {"length": len(data)} | {str(i): short(data[i]) for i in (0, len(data) - 1)}
    return [short(value) for value in data] if isinstance(data, list) else data


def analyze():
    """The analysis of every project."""
    for i, name in enumerate(PROJECTS):
        yield name, short(said("analyze", f"p{i}.yaml", "-o", f"out{i}", "--json")), PRINTED


def reproduce():
    """Cells of the article's tables, recomputed."""
    cells = said("reproduce", "--json")["cells"]
    yield "values", [cell["value"] for cell in cells], PRINTED
    yield "verdicts", [cell["verdict"] for cell in cells], EXACT


def command():
    """Every other command that gives numbers."""
    move = "trapezoid, angle: 20 deg, time: 0.4 s"
    for words in (
        "response axis.yaml", "speed-map axis.yaml -o map --loads 0|N*m,-60|N*m", "catalogue CSG-40-50",
        "catalogue --series CSG --ratio 100", "compare axis.yaml p0.yaml -o compared",
        "compensate axis.yaml --controller inverse --controller adaptive --speed 1200|rpm",
        "derive", "design elbow.yaml -o elbow",
        "order-scan error.csv", "export p0.yaml --to c -o axis.c",
        "identify guessed.yaml record.csv -o found", "read-log record.csv", "fit-loop loop.csv --rated-torque 87|N*m",
        f"move axis.yaml {move.replace(' ', '|')} -o moved --window 60|arcsec", "order-scan run0.csv run1.csv",
        "order-table table.json table.h",
        "sweep p0.yaml --grid omega=120:160:3 --measure peak --measure rms -o sweep",
        "sweep axis.yaml --grid load.inertia=1|kg*m^2,1.2|kg*m^2 -o sweep2", "exceedance axis.yaml --count 32",
        "analyze axis.yaml --check", "response no.yaml",
    ):  # fmt: skip
        parts = [word.replace("|", " ") for word in words.split()]
        yield words, short(said(*parts, *(() if "--check" in parts else ("--json",)))), PRINTED
