"""The move that a project file asks for, in the analysis: torques of a rigid drive in closed form."""

from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from strainwave.app.commands.cli import cli
from strainwave.app.report.report import write
from strainwave.app.web import views
from strainwave.base.units import RPM
from strainwave.files.reading import from_text
from strainwave.study.analysis.verdict import Answer

N, J_M, J_L, SPEED, ACCELERATION = 50.0, 6e-4, 1.3, 1.0, 2.0
TEXT = """
title: Table
gear: {ratio: 50, law: {type: linear, K: 1e6 N*m/rad}}
motor: {inertia: 6 kg*cm^2, MODE, max_torque: 0.3 N*m}
load: {inertia: 1.3 kg*m^2}
damping: {ratio: 5 %}
speed: {from: 600 rpm, to: 900 rpm, shaft: motor}
excitation: {kinematic_error: [{order: 2, amplitude: 0.01 arcsec}]}
limit: {oscillation: 100 arcsec}
move: {profile: [{type: s_curve, angle: 60 deg, speed: 1 rad/s, acceleration: 2 rad/s^2, jerk: 5 rad/s^3}]}
"""
LOOP = "loop: {type: cascade, bandwidth: 60 Hz, damping: 0.7}"


def project(mode=LOOP, torque="0.3"):
    text = TEXT.replace("MODE", mode).replace("max_torque: 0.3", f"max_torque: {torque}")
    return from_text(text, Path("table.yaml"))


@pytest.mark.slow
def test_an_analysis_has_the_largest_torques_of_the_move_of_the_file():
    report = write(project())
    moved, motor = report.view.analysis.moved, report.results["required_motor"]["torque_Nm"]
    assert moved.peak_gear_torque == pytest.approx(J_L * ACCELERATION, rel=0.03)  # and its vibration
    assert moved.peak_motor_torque == pytest.approx((J_M + J_L / N**2) * N * ACCELERATION, rel=0.03)
    assert moved.peak_speed == pytest.approx(N * SPEED, rel=0.03)
    assert moved.peak_motor_torque > 2.0 * motor  # steady motions ask for less
    assert report.results["move"]["motor"]["peak_speed_rpm"] == pytest.approx(moved.peak_speed / RPM)
    assert f"move of the file: Motor torque up to {moved.peak_motor_torque:.4g} N·m" in report.summary


@pytest.mark.slow
def test_a_limit_that_the_move_of_the_file_passes_is_in_the_verdict():
    weak, strong = write(project(torque="0.1")), write(project(torque="0.2"))
    assert strong.view.analysis.verdict.answer is Answer.ALL_RIGHT
    assert weak.view.analysis.verdict.answer is Answer.NOT
    assert not weak.view.analysis.verdict.exceeded  # steady motions keep it
    headline = weak.results["verdict"]["headline"]
    assert headline.startswith("Fail; in the move of the project file, ")
    assert headline.endswith(" N·m exceeds the motor's largest torque of 0.1 N·m")
    assert "Motor limit exceeded" in weak.results["verdict"]["what_to_do"]
    assert "above its limit of 0.1 N·m" in weak.results["verdict"]["answers"]["move of the file"]


@pytest.mark.slow
def test_an_analysis_says_why_the_move_of_the_file_is_missing():
    analysis = project(mode="mode: free").analyze(advice=False)
    assert analysis.moved is None
    assert [said for said in analysis.remarks if said.startswith("The move of the project file is not computed: ")]


def test_an_answer_about_steady_motions_says_that_the_move_of_the_file_is_judged_elsewhere(tmp_path):
    path = tmp_path / "table.yaml"
    path.write_text(project().text, encoding="utf-8")
    said = "These results are for steady motions; `analyze` and `move` check the move of the project file."
    assert said in CliRunner().invoke(cli, ["response", str(path)]).output
    assert said in views.response(project())["remarks"]
    assert said not in views.response(replace(project(), move=None))["remarks"]
