"""The sheet of a motor in a project file: numbers, curves inline or of a CSV file, and what is refused."""

from dataclasses import fields, replace

import numpy as np
import pytest
from twelve_projects import PROJECTS

import strainwave as sw
from strainwave.base.units import RPM
from strainwave.compile.tree import is_model
from strainwave.files.reading import ProjectError

PROJECT = """\
title: Joint
gear: SHG-25-100
motor: {{loop: {{bandwidth: 30 Hz}}, {motor}}}
load: {{inertia: 0.5 kg*m^2}}
damping: {{B: 5 N*m*s/rad}}
speed: {{from: 100 rpm, to: 4000 rpm, shaft: {shaft}}}
excitation: {{kinematic_error: [{{order: 2, amplitude: 10 arcsec}}]}}
"""
PEAK = "[[0 rpm, 3 N*m], [4000 rpm, 3 N*m], [6000 rpm, 1.5 N*m]]"
NUMBERS = "rms_torque: 1.1 N*m, rated_speed: 3000 rpm, brake: 2 N*m, K_t: 120 mN*m/A"
TABLE = "speed [rpm];continuous [N*m];peak [N*m]\n0;1,3;3\n4000;1,2;3\n6000;0,6;1,5\n"


def project(folder, motor, table=TABLE, shaft="motor"):
    (folder / "motor.csv").write_text(table, encoding="utf-8")
    (folder / "joint.yaml").write_text(PROJECT.format(motor=motor, shaft=shaft), encoding="utf-8")
    return sw.read_project(folder / "joint.yaml")


def test_a_sheet_is_read_in_si_from_numbers_points_and_a_file_and_written_back(tmp_path):
    found = project(tmp_path, f"{NUMBERS}, peak_torque: {PEAK}, continuous_torque: motor.csv")
    sheet = found.motor_limits
    np.testing.assert_allclose(sheet.peak_torque, [(0.0, 3.0), (4000.0 * RPM, 3.0), (6000.0 * RPM, 1.5)])
    np.testing.assert_allclose(sheet.continuous_torque, [(0.0, 1.3), (4000.0 * RPM, 1.2), (6000.0 * RPM, 0.6)])
    assert sheet[4:] == (1.1, pytest.approx(3000.0 * RPM), 2.0, pytest.approx(0.12))
    assert sheet.fastest == pytest.approx(6000.0 * RPM)
    assert sheet.at("motor torque", [-5000.0 * RPM, 9000.0 * RPM]).tolist() == pytest.approx([2.25, 1.5])
    assert sheet.at("motor rms torque", [0.0, 5000.0 * RPM]).tolist() == pytest.approx([1.1, 0.9])
    assert project(tmp_path, "peak_torque: motor.csv").motor_limits.peak_torque == sheet.peak_torque
    (tmp_path / "again.yaml").write_text(sw.project_text(replace(found, title="Changed")), encoding="utf-8")
    assert sw.read_project(tmp_path / "again.yaml").motor_limits == sheet


WRONG = [
    ("peak_torque: [[100 rpm, 1 N*m], [200 rpm, 1 N*m]]", "motor.peak_torque: begins at 100 rpm; give the torque at"),
    ("peak_torque: [[0 rpm, 1 N*m]]", "motor.peak_torque: has fewer than two points"),
    ("peak_torque: [[0 rpm, 1 N*m], [9 rpm, 1 N*m], [8 rpm, 1 N*m]]", "has 8 rpm after 9 rpm; give speeds that ascend"),
    ("peak_torque: [[0 rpm, 1 N*m], [9 rpm, -1 N*m]]", "has -1 N*m at 9 rpm; give torques from 0 on"),
    ("peak_torque: [[0 rpm], [9 rpm, 1 N*m]]", "motor.peak_torque[0]: is no pair of a speed and a torque"),
    ("peak_torque: 3 N*m/rpm", "'3 N*m/rpm' is no plain file name"),
    (f"peak_torque: {PEAK}, continuous_torque: [[0 rpm, 3 N*m], [6000 rpm, 2 N*m]]",
     "motor.continuous_torque: is 2 N*m at 6000 rpm, above the peak torque of 1.5 N*m; swap"),
    ("continuous_torque: gone.csv", "gone.csv:1:1: file: does not exist"),
    ("K_t: 0.1 N*m", "motor.K_t: '0.1 N*m' is not"),
]  # fmt: skip
TABLES = [
    ("speed [rpm],torque [N*m]\n0,1\n9,-1\n", "has -1 N*m at 9 rpm; give torques from 0 on"),
    ("speed [rpm],torque\n0,1\n9,1\n", "column 'torque' has no unit"),
    ("speed [rpm],moment [N*m]\n0,1\n9,1\n", "has no single column 'torque'"),
]


@pytest.mark.parametrize(
    ("motor", "table", "said"),
    [(motor, TABLE, said) for motor, said in WRONG] + [("peak_torque: motor.csv", *row) for row in TABLES],
)
def test_a_curve_with_holes_is_refused_in_one_sentence(tmp_path, motor, table, said):
    with pytest.raises(ValueError, match=r"joint|gone|motor") as caught:
        project(tmp_path, motor, table)
    assert said in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


def test_a_curve_needs_speeds_of_a_shaft_and_the_sheet_of_python_is_checked_too(tmp_path):
    with pytest.raises(ValueError, match="speed is a forcing frequency; write 'shaft: motor'"):
        project(tmp_path, f"peak_torque: {PEAK}", shaft="forcing")
    low, high = ((0.0, 1.0), (2.0, 1.0)), ((0.0, 2.0), (2.0, 1.0))
    for limits, said in (
        (sw.MotorLimits(peak_torque=((1.0, 2.0), (2.0, 1.0))), "peak_torque begins at"),
        (sw.MotorLimits(peak_torque=low, continuous_torque=high), "above the peak torque of 1 N"),
        (sw.MotorLimits(brake=-1.0), "MotorLimits.brake is -1"),
    ):
        with pytest.raises(ValueError, match=said):
            limits.check()


def test_units_of_the_drive_are_read_in_si_and_written_back(tmp_path):
    found = project(tmp_path, "drive_units: {K_v: 0.1 1/s, K_p: 250 uN*m*s/rad, T_n: 0.01 ms}")
    assert [one.gain for one in found.drive_units] == ["K_v", "K_p", "T_n"]
    assert [one.size for one in found.drive_units] == pytest.approx([0.1, 2.5e-4, 1e-5])
    text = sw.project_text(replace(found, title="Changed"))
    (tmp_path / "again.yaml").write_text(text, encoding="utf-8")
    assert sw.read_project(tmp_path / "again.yaml").drive_units == found.drive_units
    with pytest.raises(ProjectError, match=r"motor\.drive_units\.K_v: '0.1 Hz' may be turns or radians a second"):
        project(tmp_path, "drive_units: {K_v: 0.1 Hz}")


def parts_of(value):
    """Every object in the fields of a project, at any depth."""
    yield value
    for part in value if isinstance(value, tuple) else ():
        yield from parts_of(part)


def test_every_object_that_a_file_gives_is_checked_where_it_is_read(tmp_path, monkeypatch):
    (tmp_path / "motor.csv").write_text(TABLE, encoding="utf-8")
    move = "move: {profile: [{type: trapezoid, angle: 90 deg, time: 1 s}], payload: {mass: 1 kg, radius: 1 m}}\n"
    sheet = PROJECT.format(motor=NUMBERS, shaft="motor") + "controller: {period: 1 ms}\n" + move
    texts = [*PROJECTS.values(), sheet]
    called = set()

    def noted(cls, check):
        return lambda self: (called.add(cls), check(self))[1]

    def read(text):
        (tmp_path / "one.yaml").write_text(text, encoding="utf-8")
        project = sw.read_project(tmp_path / "one.yaml")
        parts = [part for field in fields(project) for part in parts_of(getattr(project, field.name))]
        return {type(part) for part in parts if is_model(part) and hasattr(part, "check")}

    classes = set().union(*map(read, texts))
    assert {sw.MotorLimits, sw.Payload, sw.Harmonic} <= classes
    for cls in classes:
        monkeypatch.setattr(cls, "check", noted(cls, cls.check))
    for text in texts:
        read(text)
    assert classes - called == set()
