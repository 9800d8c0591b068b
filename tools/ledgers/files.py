"""Files: exports, compiled and run; order tables; archives; logs and projects that are read."""

import ctypes
import dataclasses
import re
import shutil
import subprocess
import zipfile
from pathlib import Path
from typing import NamedTuple

import numpy as np

import strainwave as sw

from .drives import ARCSEC, BOUC_WEN, CLOSED, DRIVE, DUFFING, ERROR, EXACT, GEAR, answer, projects

ANGLE = sw.OrderTable(
    (sw.Line(1, 4 * ARCSEC, -1.0), sw.Line(2, 23 * ARCSEC, 0.3), sw.Line(4, 2 * ARCSEC, 2.0)), ratio=120.0, zero=0.4
)
PLANTS = {
    "piecewise": DRIVE.train(kinematic_error=ERROR),
    "Bouc-Wen": DRIVE._replace(law=BOUC_WEN).train(kinematic_error=ERROR, load_drag=sw.train.AngleTorque(12.0)),
    "friction": DRIVE.train(
        motor_drag=sw.laws.LuGre(3.0, 0.02, 1e-3, 0.03, 0.05, 0.3), friction=sw.laws.LoadFriction(0.08)
    ),
}


class Seen(NamedTuple):
    """What the controller of the export sees."""

    reference: float
    angle: float


class Proportional(NamedTuple):
    """PI with a limit."""

    K_p: float
    K_i: float

    def start(self):
        """State at the begin."""
        return (0.0,)

    def update(self, state, seen):
        """Next state and torque."""
        error = seen.reference - seen.angle
        return (state[0] + self.K_i * error,), np.maximum(self.K_p * error + state[0], -3.0)


def digits(text):
    """Numbers in a text, and the text without them."""
    numbers = re.findall(r"-?\d+\.\d+(?:e[-+]?\d+)?", text)
    return np.array(numbers, float), re.sub(r"-?\d+\.\d+(?:e[-+]?\d+)?", "#", text)


def run_in_c(source, name, steps):
    """Outputs of an exported plant after so many steps under a constant torque, compiled by `cc`."""
    flags = ["-std=c99", "-O2", "-ffp-contract=off", "-shared", "-fPIC"]
    subprocess.run(["cc", *flags, source, "-lm", "-o", source.with_suffix(".so")], check=True)
    library = ctypes.CDLL(str(source.with_suffix(".so").resolve()))
    state, inputs, outputs = (ctypes.c_double * 64)(), (ctypes.c_double * 2)(0.35, -2.0), (ctypes.c_double * 6)()
    numbers = ctypes.byref(ctypes.c_double.in_dll(library, f"{name}_default"))
    library[f"{name}_init"](state)
    for _ in range(steps):
        library[f"{name}_step"](numbers, state, inputs, outputs)
    return np.array(outputs)


def export():
    """C, compiled and run; texts of functional mock-up units and of joints."""
    for i, (name, train) in enumerate(PLANTS.items()):
        path = sw.export(train, f"plant{i}.c", to="c", step=1e-4).path
        yield f"c/{name}/numbers", digits(path.read_text(encoding="utf-8"))[0], CLOSED
        if shutil.which("cc"):
            yield f"c/{name}/run", run_in_c(Path(path), f"plant{i}", 2000), CLOSED
    path = sw.export(Proportional(40.0, 0.05), "loop.c", to="c", measurement=Seen(0.0, 0.0)).path
    yield "c/controller", path.read_text(encoding="utf-8").splitlines(), EXACT
    for kind in ("fmu2", "fmu3"):
        path = sw.export(PLANTS["piecewise"], f"{kind}.fmu", to=kind, step=1e-4).path
        described = zipfile.ZipFile(path).read("modelDescription.xml").decode()
        variables = re.findall(r'name="([^"]*)"', described)
        starts = re.findall(r'start="([-+.\de]+)"', described)
        yield kind, [sorted(set(variables)), np.array(starts, float)], CLOSED
    path = sw.export(PLANTS["piecewise"], "joint.xml", to="mjcf").path
    numbers, words = digits(path.read_text(encoding="utf-8"))
    yield "mjcf", [numbers, words], CLOSED
    for name, project in projects().items():
        refused = answer(lambda project=project: sw.export(project, "project.c", to="c").notes)
        yield f"project/{name}", refused, EXACT


def order_table():
    """Order tables in every format, read back."""
    for name in ("json", "csv", "c"):
        ANGLE.write("table.txt", name)
        back = sw.OrderTable.read("table.txt")
        yield f"{name}/back", [(line.order, line.amplitude) for line in back.lines], 1e-8
    ANGLE.write("table.json")
    text = Path("table.json").read_text(encoding="utf-8")
    yield "json/file", [len(text.splitlines()), digits(text)[0]], 1e-6
    yield "changed", [dataclasses.replace(ANGLE, delay=1e-3).at_speed(100.0).value(0.7)], CLOSED


def archive():
    """Results written and read back: equal to the bit."""
    results = {
        "branch": sw.frequency_response(DUFFING, (0.9, 1.4), harmonics=5),
        "trajectory": sw.simulate(DUFFING, (0.1, 0.0), np.linspace(0.0, 3.0, 11)),
    }
    for name, result in results.items():
        again = sw.load(result.save(f"{name}.nc"))
        same = result.to_xarray().drop_attrs().identical(again.to_xarray().drop_attrs())
        yield f"{name}.nc", [same, type(again).__name__], EXACT
        yield f"{name}/table", sorted(map(str, result.to_dataframe().columns)), EXACT


def read():
    """Projects, gears, profiles, logs and scans that are read."""
    for name, project in projects().items():
        facts = {key: getattr(project, key) for key in ("J", "omega_0", "damping_ratio", "load_torques", "notes")}
        yield f"project/{name}", facts | {"left out": project.left_out, "motors": list(project.motors())}, CLOSED
        train = project.whole
        if train is not None:
            yield f"text/{name}", answer(lambda t=train: digits(sw.project_text(t, (100.0, 200.0)))[0]), CLOSED
    yield "entry", sw.project_entry(GEAR.law), EXACT
    Path("gears.csv").write_text("name,ratio,K1 [N*m/rad],rated_torque [N*m]\nown,80,2e4,40\n", encoding="utf-8")
    yield "gears", answer(lambda: sw.read_gears("gears.csv")), CLOSED
    Path("path.csv").write_text("time [s],angle [deg]\n0,0\n0.2,3\n0.5,10\n0.8,10\n", encoding="utf-8")
    yield "profile", sw.read_profile("path.csv"), CLOSED
    t = np.arange(0.0, 8.0, 0.01)
    speed = np.interp(t, [0.0, 1.0, 2.0, 6.0, 7.0, 8.0], [0.0, 0.0, 0.8, 0.8, 0.0, 0.0])
    rows = zip(t, np.degrees(np.cumsum(speed) * 0.01) % 360.0, 20.0 + 3.0 * np.sign(speed), strict=True)
    text = "Zeit [s];Winkel [deg];Moment [N*m]\n" + "\n".join(f"{a:.3f};{b:.4f};{c:.3f}" for a, b, c in rows)
    Path("log.csv").write_text(text.replace(".", ","), encoding="utf-8")
    log = sw.read_log("log.csv")
    yield "log", [log.channels, log.rate, log.notes, log.doubts], CLOSED
    yield "log/segments", [(part.kind, part.start, part.stop, part.speed) for part in log.segments()], 1e-8
    Path("scan.csv").write_text("angle [deg],error [arcsec]\n" + "\n".join(f"{a},{a % 7}" for a in range(360)))
    yield "scan", sw.read_scan("scan.csv"), CLOSED
