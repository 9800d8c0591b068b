"""The group `move` of a project file: what it reads as, that it is written back, and what is refused with its place."""

import math
from dataclasses import replace

import numpy as np
import pytest

import strainwave as sw

PROJECT = """\
title: Joint
gear: SHG-25-100
motor: {loop: {bandwidth: 30 Hz}, max_torque: 1.2 N*m, max_speed: 6000 rpm}
load: {inertia: 0.5 kg*m^2, drag: {type: angle_torque, amplitude: 60 N*m}}
damping: {B: 5 N*m*s/rad}
speed: {from: 100 rpm, to: 4000 rpm, shaft: motor}
excitation: {kinematic_error: [{order: 2, amplitude: 10 arcsec}]}
"""
MOVE = """\
move:
  start: -45 deg
  window: 30 arcsec
  payload: {mass: 2 kg, radius: 40 cm, phase: 90 deg}
  feedforward: {acceleration: 100 %, gravity: 0.9, at: motor}
  profile:
    - {type: trapezoid, angle: 90 deg, time: 0.6 s}
    - {type: dwell, time: 400 ms}
    - {type: s_curve, angle: -90 deg, speed: 180 deg/s, acceleration: 900 deg/s^2, jerk: 2e4 deg/s^3}
    - {type: angle_profile, file: back.csv}
"""
CSV = "time [s],angle [deg]\n0,0\n0.1,1\n0.2,2\n0.3,2.5\n"


def project(folder, text, table=CSV):
    (folder / "back.csv").write_text(table, encoding="utf-8")
    (folder / "joint.yaml").write_text(text, encoding="utf-8")
    return sw.read_project(folder / "joint.yaml")


def test_a_move_is_read_in_si(tmp_path):
    found = project(tmp_path, PROJECT + MOVE)
    task = found.move
    quarter = 0.5 * math.pi
    assert found.motor_limits == sw.MotorLimits(1.2, pytest.approx(200.0 * math.pi))
    assert task.start == pytest.approx(-0.5 * quarter)
    assert task.window == pytest.approx(math.radians(30.0 / 3600.0))
    assert task.payload == sw.Payload(2.0, pytest.approx(0.4), 0.0, pytest.approx(quarter))
    assert task.feedforward == sw.Feedforward(1.0, 0.9, 0.0, 1.0, "motor")
    assert task.profile[0] == sw.Trapezoid(pytest.approx(quarter), 0.6)
    assert task.profile[1] == sw.study.Dwell(pytest.approx(0.4))
    assert task.profile[2].jerk == pytest.approx(math.radians(2e4))
    assert isinstance(task.profile[3], sw.AngleProfile)
    np.testing.assert_allclose(task.profile[3].angles, np.radians([0.0, 1.0, 2.0, 2.5]))
    assert task.files == ("", "", "", "back.csv")


@pytest.mark.slow
def test_the_verb_takes_what_the_file_asks_and_arguments_go_first(tmp_path):
    found = project(tmp_path, PROJECT + MOVE)
    rough = {"method": sw.Dopri5(rtol=1e-4, atol=1e-7), "tail": 0.01}
    move = sw.move(found, **rough)
    assert move.reference[0] == pytest.approx(-0.25 * math.pi)
    assert move.window == found.move.window
    assert move.duration == pytest.approx(1.3 + 90.0 / 180.0 + 180.0 / 900.0 + 900.0 / 2e4)
    assert {finding.limit for finding in move.findings} >= {"max_rpm", "average_torque", "motor torque", "motor speed"}
    other = sw.move(found, sw.Trapezoid(0.1, 0.1), start=0.2, window=1e-4, **rough)
    assert (other.duration, other.window) == (pytest.approx(0.1), 1e-4)
    assert other.reference[0] == pytest.approx(0.2)
    bare = replace(found, move=None, limit=2e-4)
    assert sw.move(bare, sw.Trapezoid(0.1, 0.1), **rough).window == 2e-4
    with pytest.raises(ValueError, match="there is no profile"):
        sw.move(bare)


def test_a_project_that_names_no_loop_gets_one_and_says_so(tmp_path):
    text = PROJECT.replace("motor: {loop: {bandwidth: 30 Hz}, max_torque: 1.2 N*m, max_speed: 6000 rpm}\n", "")
    text = text.replace("{kinematic_error:", "{load_torque: {mean: {from: -9 N*m, to: 3 N*m}}, kinematic_error:")
    move = sw.move(
        project(tmp_path, text), sw.Trapezoid(0.1, 0.1), tail=0.01, method=sw.Dopri5(rtol=1e-4, atol=1e-7)
    )  # fmt: skip
    assert "has no loop of the motor; a position loop of 30 Hz" in move.remarks[0]
    assert "a range, -9 to 3 N*m" in move.remarks[1]


def test_a_changed_project_with_a_move_is_written_and_reads_back_equal(tmp_path):
    found = project(tmp_path, PROJECT + MOVE)
    changed = replace(found, title="Changed")
    (tmp_path / "again.yaml").write_text(sw.project_text(changed), encoding="utf-8")
    again = sw.read_project(tmp_path / "again.yaml")
    assert again.move == found.move
    assert again.motor_limits == found.motor_limits
    python = replace(found, title="Changed", move=found.move._replace(files=("",) * 4))
    with pytest.raises(ValueError, match="AngleProfile as a CSV file"):
        sw.project_text(python)


WRONG = [
    ("profile: []", "joint.yaml:8:", "move.profile"),
    ("profile: [{type: ramp, angle: 1 rad}]", "move.profile[0].type: 'ramp' is not known"),
    ("profile: [{type: dwell, time: -1 s}]", "move.profile[0].time: is -1 s; it must be positive"),
    ("profile: [{type: trapezoid, angle: 1 rad}]", "neither a time nor limits"),
    (
        "profile: [{type: angle_profile, file: ../back.csv}]",
        "'../back.csv' is no plain file name; put the file",
    ),
    ("profile: [{type: angle_profile, file: back.csv, time: 1 s}]", "move.profile[0].time: unknown field"),
    ("profile: [{type: angle_profile, file: gone.csv}]", "gone.csv:1:1: file: does not exist"),
    ("profile: [{type: dwell, time: 1 s}], feedforward: {gravity: -1}", "move.feedforward.gravity: is -1"),
    ("profile: [{type: dwell, time: 1 s}], feedforward: {at: load}", "write one of reference, motor"),
    ("profile: [{type: dwell, time: 1 s}], payload: {mass: 1 kg}", "move.payload.radius: is missing"),
    ("profile: [{type: dwell, time: 1 s}], window: 0 deg", "move.window: '0 deg' is not positive"),
    ("start: 1 rad", "move.profile: is missing"),
]


@pytest.mark.parametrize(("fields", "said"), [(fields, said[-1]) for fields, *said in WRONG])
def test_what_is_wrong_with_a_move_is_said_with_its_place(tmp_path, fields, said):
    with pytest.raises(ValueError, match=r"joint|gone") as caught:
        project(tmp_path, PROJECT + f"move: {{{fields}}}\n")
    assert said in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


TABLES = [
    (
        "time [s],angle [deg]\n0,0\n0.2,1\n0.1,2\n",
        ":4:1: time: 0.1 stands after 0.2 of line 3; a profile goes forward in time",
    ),
    ("time,angle [deg]\n0,0\n0.2,1\n", ":1:1: time: column 'time' has no unit"),
    ("time [s],angle [deg]\n0,0\n", ":1:1: file: has fewer than two points"),
    ("", ":1:1: file: is empty; give a profile"),
]


@pytest.mark.parametrize(("text", "said"), TABLES)
def test_a_wrong_table_is_refused_with_its_line(tmp_path, text, said):
    path = tmp_path / "profile.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match="profile") as caught:
        sw.read_profile(path)
    assert said in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


def test_a_table_of_another_country_is_read(tmp_path):
    path = tmp_path / "profile.csv"
    path.write_text("# log\nZeit;x\ntime (ms);angle (rad);load\n0;0,0;1\n\n500;0,5;2\n", encoding="utf-8")
    found = sw.read_profile(path, delimiter=";", decimal=",")
    assert found == sw.AngleProfile((0.0, 0.5), (0.0, 0.5)) == sw.read_profile(path)
    with pytest.raises(ValueError, match="the delimiter"):
        sw.read_profile(path, delimiter=",", decimal=",")
