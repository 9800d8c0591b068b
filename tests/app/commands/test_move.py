"""`strainwave move`: what it prints and writes, with the numbers of the library, and its complaints."""

import csv
import json
import re
from itertools import takewhile
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner
from small_drive import LINEAR, at_the_load

import strainwave as sw
from strainwave.app.commands import cli as command
from strainwave.app.commands import move as move_command
from strainwave.drive.demands.motor_limits import MotorLimits
from strainwave.plot.moves import move_panels
from strainwave.plot.svg import stacked

PROJECT = at_the_load(LINEAR, 24, 38).replace("mode: held", "loop: {bandwidth: 20 Hz}, max_torque: 60 N*m")
PROJECT += "move: {profile: [{type: s_curve, angle: 20 deg, time: 0.1 s}]}\n"
PART = "trapezoid, angle: 10 deg, time: 0.05 s"


def invoke(*given):
    return CliRunner().invoke(command.cli, ["move", *map(str, given)])


@pytest.mark.slow
def test_the_command_writes_and_prints_the_numbers_of_the_library(drive, tmp_path):
    (tmp_path / "back.csv").write_text("time [s],angle [deg]\n0,0\n0.02,-4\n0.04,-8\n0.06,-10\n")
    out, profile = tmp_path / "out", [PART, "dwell, time: 10 ms", tmp_path / "back.csv"]
    run = invoke(drive, *profile, "-o", out, "--band", "1000 rpm", "1300 rpm", "--window", "20 arcsec", "--json")
    assert run.exit_code == 0, run.output
    data = json.loads(run.stdout)
    parts = [sw.Trapezoid(np.radians(10.0), 0.05), sw.study.Dwell(0.01), sw.read_profile(tmp_path / "back.csv")]
    bands, window = [(1000.0 * np.pi / 30.0, 1300.0 * np.pi / 30.0)], np.radians(20.0 / 3600.0)
    move = sw.move(sw.read_project(drive), parts, bands=bands, window=window)
    assert data["pointing_error_rad"]["peak"] == pytest.approx(move.peak_error, rel=1e-9)
    assert data["settling_time_s"] == pytest.approx(move.settling_time, rel=1e-6)
    assert data["speeds_to_avoid"][0]["time_s"] == pytest.approx(move.time_in_bands[0], rel=1e-9)
    assert [p["amplification"] for p in data["resonances_passed"]] == pytest.approx(
        [p.amplification for p in move.passes], rel=1e-6
    )  # fmt: skip
    assert json.loads((out / "move.json").read_text()) == data
    assert sorted(file.name for file in out.iterdir()) == ["move.csv", "move.json", "move.svg"]
    rows = list(csv.DictReader((out / "move.csv").read_text().splitlines()))
    assert float(rows[-1]["time_s"]) == pytest.approx(move.time[-1], rel=1e-6)
    largest = max(abs(float(row["pointing_error_rad"])) for row in rows)
    assert largest == pytest.approx(np.max(np.abs(move.pointing_error)), rel=1e-6)
    text = invoke(drive, *profile, "-o", out, "--band", "1000 rpm", "1300 rpm").stdout
    assert re.search(r"speeds to avoid: from \[rpm\] .*\n +1000 +1300 ", text)
    assert "unexplained" not in text  # the balance is closed
    assert "settling time after each of 2 motions: " in text
    lines = text.splitlines()
    head = next(i for i, line in enumerate(lines) if "resonance [Hz]" in line)
    told = [line.split() for line in takewhile(lambda line: line.split()[0] == "2", lines[head + 1 :])]
    assert len(told) == len({p.speed for p in move.passes})
    worst = max((p for p in move.passes if p.speed == move.passes[0].speed), key=lambda p: p.largest)
    times = sum(p.speed == worst.speed for p in move.passes)
    assert any(row[3] == str(times) and float(row[4]) == pytest.approx(worst.time, rel=1e-3) for row in told)


def test_the_figure_has_every_peak_and_the_limits_that_are_near(drive):
    project = sw.read_project(drive)
    rough = sw.Dopri5(rtol=1e-5, atol=1e-8)
    move = sw.move(project, payload=sw.Payload(1.0, 0.1), bands=[(20.0, 30.0)], tail=0.2, method=rough)
    gear = sw.catalogue.gear("CSG-40-50")
    shown = move_panels(move, gear, MotorLimits(1.5 * move.peak_motor_torque))
    for panel, values in zip(
        shown[1:], (move.pointing_error, move.motor_torque, move.gear_torque), strict=True
    ):  # fmt: skip
        reach = [np.ptp(c.y) for c in panel.curves if np.all(np.isfinite(c.y)) and c.upper is None and not c.marker]
        assert max(reach) == pytest.approx(np.ptp(values), rel=1e-9)
        assert panel.xlim == shown[0].xlim
    assert 'viewBox="0 0 430 ' in stacked(move.panels(), 215.0, "")  # narrow, for telephones
    labels = {curve.label for panel in shown for curve in panel.curves}
    assert {"speeds to avoid", "largest torque of the motor", "end of the move"} <= labels
    assert "momentary torque of the gear" not in labels  # far above


def test_speeds_to_avoid_of_the_analysis_are_added_to_those_given(drive, tmp_path, monkeypatch):
    found = SimpleNamespace(avoid=SimpleNamespace(bands=((100.0, 120.0),)))
    monkeypatch.setattr(sw.Project, "analyze", lambda *_: found)
    rough = {"tail": 0.02, "method": sw.Dopri5(rtol=1e-4, atol=1e-7)}
    monkeypatch.setattr(move_command, "moved", lambda *given, **options: sw.move(*given, **options, **rough))
    run = invoke(drive, PART, "-o", tmp_path / "out", "--avoid", "--band", "10 rad/s", "20 rad/s", "--json")
    assert run.exit_code == 0, run.output
    bands = json.loads(run.stdout)["speeds_to_avoid"]
    # the trapezoid has 50 3/2 10 deg/0.05 s = 261.8 rad/s at the motor, reached in a sixtieth of a second
    rate = 50.0 * np.radians(15.0) / 0.05 * 60.0
    assert [band["time_s"] for band in bands] == pytest.approx([20.0 / rate, 40.0 / rate], rel=1e-9)
    assert [band["from_rpm"] for band in bands] == pytest.approx([10.0 * 30.0 / np.pi, 100.0 * 30.0 / np.pi])
    assert (tmp_path / "out" / "move.svg").read_text().startswith("<svg")


WRONG = [
    ((PART, "--start", "3"), 2, "--start: '3' has no unit"),
    (("ramp, angle: 1 rad",), 2, "the profile 'ramp, angle: 1 rad' is wrong: type: 'ramp' is not known"),
    (("trapezoid, angle: 1 rad",), 2, "is wrong: Trapezoid has neither a time nor limits"),
    ((PART, "--payload", "mass: 2 kg"), 2, "radius: is missing"),
    ((PART, "--band", "1300 rpm", "1000 rpm"), 2, "--band: '1300 rpm' to '1000 rpm' is not a range"),
    (("dwell, time: 1 s",), 1, "only waits for 1 s; give an angle"),
]


@pytest.mark.parametrize(
    ("left_out", "given", "said"),
    [
        (
            PROJECT.splitlines()[-1],
            (),
            "no profile; write 'trapezoid, angle: 90 deg, time: 0.6 s' after the",
        ),
        (
            ", max_torque: 60 N*m",
            (PART, "--limited"),
            "motor torque; write 'max_torque: 3 N*m' into",
        ),
        ("", (PART, "dwell, time: 1e9 s", PART), "of 1e+09 s; give a shorter profile\n"),
    ],
)
def test_remedies_name_what_the_command_and_the_file_take(drive, tmp_path, left_out, given, said):
    drive.write_text(PROJECT.replace(left_out, ""), encoding="utf-8")
    run = invoke(drive, *given, "-o", tmp_path / "out")
    assert run.exit_code == 1
    assert said in run.stderr


@pytest.mark.parametrize(("given", "code", "said"), WRONG)
def test_a_wrong_command_ends_with_one_sentence_and_writes_nothing(drive, tmp_path, given, code, said):
    run = invoke(drive, *given, "-o", tmp_path / "out")
    assert run.exit_code == code
    assert said in run.stderr
    assert "Traceback" not in run.output
    assert len([line for line in run.stderr.splitlines() if not re.match("A small drive: |Usage: |Try |$", line)]) == 1
    assert not (tmp_path / "out").exists()


def test_a_move_beyond_the_motor_is_a_fail_in_the_first_line_and_in_json(drive, tmp_path):
    given = (drive, "trapezoid, angle: 90 deg, time: 5 ms", "-o", tmp_path / "out")
    text, data = invoke(*given), json.loads(invoke(*given, "--json").stdout)
    assert text.exit_code == 0, text.output
    first = text.stdout.splitlines()[0]
    assert first.startswith("FAIL: The torque")
    assert any("above its limit of 60 N*m; the move is computed with unlimited" in said for said in data["failures"])
    assert data["passes"] is False
    (motor,) = [one for one in data["limits"] if one["limit"] == "motor torque"]
    assert motor["fails"]
    assert motor["value"] > motor["bound"] == 60.0
