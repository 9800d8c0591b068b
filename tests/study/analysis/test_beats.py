"""An analysis of motions that beat: its numbers against an integration of the joint's equations, and its words."""

from math import cos, sin
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from turns import sizes_of_turns

import strainwave as sw
from strainwave.app.report.report import write_view
from strainwave.app.view import View
from strainwave.drive.steady import is_beating
from strainwave.drive.two_turns import two_turn_motion
from strainwave.files.reading import from_text
from strainwave.model.gears import catalogue
from strainwave.study.analysis.design_variables import Subject
from strainwave.study.analysis.remedies import with_gear

pytestmark = pytest.mark.slow

N, K, ALPHA, J, B, MEAN, PULL = 50.0, 2e4, 4e5, 1.0, 30.0, 4.0, 6.0
ARCSEC = np.pi / 648000.0
FIRST, SECOND, PHASE = 20.0 * ARCSEC, 6.0 * ARCSEC, np.radians(40.0)
PLACES, SETTLING = 512, 1  # samples of a turn of the motor, and output turns before those that count
LOOP = 2.0 * np.pi * 30.0, 0.7
J_M = 1e-4

TEXT = """\
title: joint
gear: {ratio: 50, law: {type: cubic, K: 2e4 N*m/rad, alpha: 4e5 1/rad^2}}
motor: {inertia: 1 kg*cm^2, MOTOR}
load: {inertia: 1 kg*m^2, drag: {type: angle_torque, amplitude: PULL N*m, order: 1}}
damping: {B: 30 N*m*s/rad}
speed: {from: 300 rpm, to: 1200 rpm, shaft: motor}
excitation:
  kinematic_error:
    - {order: 2, amplitude: 20 arcsec}
    - {order: {wave_generator: 2, output: 2}, amplitude: 6 arcsec, phase: 40 deg}
  load_torque: {mean: -4 N*m}
limit: {oscillation: 60 arcsec}
"""
MOTORS = {"held": "mode: held", "loop": "loop: {bandwidth: 30 Hz, damping: 0.7}"}


def joint(path, motor="held", pull=PULL):
    return from_text(TEXT.replace("MOTOR", MOTORS[motor]).replace("PULL", f"{pull}"), path / "joint.yaml")


@pytest.fixture(scope="module", params=MOTORS)
def analysed(request, tmp_path_factory):
    project = joint(tmp_path_factory.mktemp("joint"), request.param)
    return SimpleNamespace(motor=request.param, project=project, analysis=project.analyze())


def largest_and_smallest(motor, omega):
    """Largest and smallest |pointing error - mean| over turns that begin in each turn of the motor."""
    sizes = sizes_of_turns(integrated(motor, omega, turns=N + 1), PLACES)[:-1].reshape(int(N), PLACES)
    return sizes.max(axis=1), sizes.min()


def integrated(motor, omega, gravity=PULL, second=SECOND, turns=N):
    """Pointing error over some turns of the motor, after an output turn, its equations written out."""
    order = 2.0 + 2.0 / N
    inertia = J_M + J / N**2
    stiff, damped = inertia * LOOP[0] ** 2, 2.0 * LOOP[1] * LOOP[0] * inertia

    def rates(t, y):
        x, v, d, w = y.tolist()  # between motor and load, and the motor's deviation
        a, b = 2.0 * (omega * t + d), order * (omega * t + d) + PHASE
        e = FIRST * cos(a) + second * cos(b)
        slope = -2.0 * FIRST * sin(a) - order * second * sin(b)
        torque = K * (x - e) * (1.0 + ALPHA * (x - e) ** 2) + B * (v - slope * (omega + w))
        back = -(1.0 / N - slope) * torque
        fast = (back - stiff * d - damped * w) / J_M if motor == "loop" else 0.0
        against = MEAN + gravity * sin((omega * t + d) / N - x)
        return [v, fast / N - (torque - against) / J, w, fast]

    turn = 2.0 * np.pi / omega
    t = turn * (N * SETTLING + np.arange(int(turns) * PLACES + 1) / PLACES)
    y = solve_ivp(rates, (0.0, t[-1]), np.zeros(4), "DOP853", t_eval=t, rtol=1e-8, atol=1e-12).y
    return y[0] - y[2] / N


def test_the_largest_motion_is_that_of_an_integration_in_every_turn(analysed):
    largest, beat = analysed.analysis.largest_oscillation(), analysed.analysis.beat
    sizes, smallest = largest_and_smallest(analysed.motor, largest.omega)
    np.testing.assert_allclose(beat.balanced, sizes, rtol=2e-3)  # of the samples' crests, and of the waves left out
    np.testing.assert_allclose(beat.integrated, sizes, rtol=2e-3)
    assert largest.peak == pytest.approx(np.max(sizes), rel=2e-3)
    assert largest.smallest == pytest.approx(smallest, rel=1e-2)  # by samples: a crest leaves a turn steeply
    assert largest.beat == beat.period == pytest.approx(2.0 * np.pi * N / largest.omega, rel=1e-12)
    assert 0.0 < beat.difference < 2e-3


def test_speeds_to_avoid_end_where_the_largest_turn_is_at_the_limit(analysed):
    ((low, high),) = analysed.analysis.avoid.bands
    mapped = sw.speed_map(analysed.project, search=False)
    np.testing.assert_allclose(mapped.forbidden[0], [[low, high]], rtol=1e-8)
    for omega in (low, high):
        assert np.max(largest_and_smallest(analysed.motor, omega)[0]) == pytest.approx(analysed.project.limit, rel=2e-4)
    assert analysed.analysis.verdict.answer == "pass except at some speeds"


def test_remedies_are_those_of_the_changed_drive(analysed):
    project, analysis = analysed.project, analysed.analysis
    found = {(remedy.what, remedy.share): remedy for remedy in analysis.remedies}
    cancelled = found["kinematic error of order 2", -1.0]
    second = project.kinematic_error._replace(lines=project.kinematic_error.lines[1:])
    _, size = largest_of(project.whole._replace(error=second), project.speeds.limits)
    assert cancelled.ratio == pytest.approx(size / analysis.largest_oscillation().peak, rel=1e-3)


def test_remedies_name_the_line_that_moves_a_turn_of_the_motor(tmp_path):
    slow = "    - {order: {output: 1}, amplitude: 60 arcsec}\n  load_torque"
    text = TEXT.replace("MOTOR", MOTORS["held"]).replace("PULL", f"{PULL}").replace("  load_torque", slow)
    project = from_text(text.replace("amplitude: 6 ", "amplitude: 25 "), tmp_path / "joint.yaml")
    names = {remedy.what for remedy in project.analyze().remedies}
    assert {name for name in names if "kinematic" in name} == {"kinematic error of order 2 + 2/50"}


def largest_of(train, speeds):
    """Speed and size of the largest turn among motions at speeds that lie ever closer."""
    low, high = speeds
    while high / low > 1.002:
        omega = np.linspace(low, high, 9)
        sizes = [two_turn_motion(train, w).largest[0] for w in omega.tolist()]
        top = int(np.argmax(sizes))
        low, high = omega[max(0, top - 1)], omega[min(8, top + 1)]
    return omega[top], sizes[top]


def test_a_report_has_the_beat_wherever_it_has_the_largest_oscillation(analysed, tmp_path):
    largest = analysed.analysis.largest_oscillation()
    report = write_view(View.of(analysed.project, analysed.analysis), tmp_path)
    found, beat = report.results, report.results["beat"]
    assert found["largest_oscillation"]["smallest_rad"] == largest.smallest
    assert found["largest_oscillation"]["beat_s"] == beat["period_s"] == largest.beat
    assert beat["turns"] == 50.0
    assert len(beat["oscillation_of_each_turn_rad"]) == 50
    words = f"in the smallest turn, with a period of {largest.beat:.3g} s)"
    assert words in found["verdict"]["sentence"]
    assert words in found["verdict"]["answers"]["largest oscillation"]
    assert words in report.summary
    assert found["resonance_remark"].startswith("multiple scales requires motions that repeat with every turn, but")
    assert "Small oscillations: order 2 at" in found["resonance_remark"]
    assert "and order 2.04 at" in found["resonance_remark"]
    rows = found["exact_response"]["harmonics"]
    pairs = [(row["wave_generator"], row["output"]) for row in rows]
    assert {(2, 0), (2, 2)} < set(pairs)
    waves = analysed.analysis.exact.curve.waves
    size = waves.amplitudes[analysed.analysis.exact.top, waves.pairs.tolist().index([2, 2])]
    row = rows[pairs.index((2, 2))]
    assert (row["amplitude_rad"], row["phase_rad"]) == (abs(size), np.angle(size))
    page = (tmp_path / "report.html").read_text("utf-8")
    assert "Time integration agrees within" in page
    assert "smallest turn of the beat" in page
    appendix = (tmp_path / "appendix.html").read_text("utf-8")
    assert "Beating motions do not repeat with every turn" in appendix


def test_waves_of_a_curve_are_those_of_the_motion_at_a_speed(tmp_path):
    project = joint(tmp_path)
    found = project.response()
    at = found.top
    alone = two_turn_motion(project.whole, float(found.omega[at]))
    for order, pair in ((2, (2, 0)), (2.04, (2, 2)), (0.02, (0, 1))):
        assert found.curve.waves.amplitude(order)[at] == pytest.approx(alone.amplitude(*pair)[0], rel=1e-3)
    assert not np.any(found.curve.waves.amplitude(1.234))


def test_a_motion_in_time_that_beats_repeats_with_no_turn(tmp_path):
    project = joint(tmp_path, pull=0.0)
    motion, beat = sw.drive_motion(project, 70.0), two_turn_motion(project.whole, 70.0)
    assert "the motion does not repeat with every turn" in motion.remark
    assert beat.smallest[0] < motion.oscillation < 1.001 * beat.largest[0]


def test_gravity_stays_in_a_beat_under_other_loads(tmp_path):
    text = (
        TEXT.replace("MOTOR", MOTORS["held"])
        .replace("PULL", f"{PULL}")
        .replace("mean: -4 N*m", "mean: {from: -8 N*m, to: 0 N*m}")
        .replace("from: 300 rpm, to: 1200 rpm", "from: 640 rpm, to: 700 rpm")
    )
    project = from_text(text, tmp_path / "joint.yaml")
    analysis = project.analyze(advice=False)
    assert [analysis.load_cases[i].torque for i in (0, -1)] == [-8.0, 0.0]
    case = analysis.load_cases[0]
    top = case.drive.top
    train = project.whole
    end = train.load.end()._replace(excitation=sw.Harmonic(0.0, mean=-8.0))
    alone = two_turn_motion(train._replace(load=train.load.with_end(end)), float(case.drive.omega[top]))
    assert alone.amplitude(0, 1)[0] > 0.0
    np.testing.assert_allclose(case.drive.curve.envelope[top], [alone.largest[0], alone.smallest[0]], rtol=1e-3)


def test_lines_of_the_output_keep_their_repeats_with_another_ratio(tmp_path):
    text = TEXT.replace("{ratio: 50, law: {type: cubic, K: 2e4 N*m/rad, alpha: 4e5 1/rad^2}}", "CSG-40-50")
    text = text.replace("MOTOR", MOTORS["held"]).replace("PULL", f"{PULL}").replace("1 kg*cm^2", "5 kg*cm^2")
    project = from_text(text, tmp_path / "joint.yaml")
    subject = Subject(project.system(reduced=True), project.whole, project.speeds.limits, project)
    changed = with_gear(subject, project, catalogue.gear("CSG-40-80"))
    assert changed.train.N == 80.0
    assert [line.order for line in changed.train.error.lines] == [2, 2.0 + 2.0 / 80.0]


def test_gravity_alone_is_exact_too_and_its_difference_is_said(tmp_path):
    text = TEXT.replace("MOTOR", MOTORS["loop"]).replace("PULL", "30")
    lines = [line for line in text.splitlines() if "wave_generator" not in line]
    project = from_text("\n".join(lines) + "\n", tmp_path / "joint.yaml")
    assert not is_beating(project.subject.error)
    analysis = project.analyze()
    omega, size = analysis.train.gravity
    error = integrated("loop", omega, 30.0, 0.0, N + 1.0)
    total = np.concatenate([[0.0], np.cumsum(0.5 * (error[1:] + error[:-1]))])
    slow = (total[PLACES:] - total[:-PLACES]) / PLACES  # mean of the turn around each place
    fast = error[PLACES // 2 : len(error) - PLACES // 2] - slow
    assert size == pytest.approx(np.max(np.abs(fast)), rel=2e-3)
    quasi = max(float(case.drive.oscillation[case.drive.top]) for case in analysis.load_cases)
    change = 100.0 * abs(size / quasi - 1.0)
    said = analysis.train.remarks[-1]
    assert f"{change:.2g} % {'more' if size > quasi else 'less'} than with constant torques" in said


def test_a_free_motor_is_analysed_by_its_train_beside_its_error_equation(tmp_path):
    text = TEXT.replace("MOTOR", "mode: free").replace(
        ", drag: {type: angle_torque, amplitude: PULL N*m, order: 1}", ""
    )
    project = from_text(text.replace("from: 300", "from: 1000").replace("60 arcsec", "40 arcsec"), tmp_path / "j.yaml")
    analysis = project.analyze()
    largest = analysis.largest_oscillation()
    alone = two_turn_motion(project.whole, largest.omega)
    assert largest.peak == pytest.approx(alone.largest[0], rel=1e-3)
    # a linear answer of both waves: the error equation leaves out terms of order N e', here 2 %
    free = project.drive.J
    sizes = []
    for size, order in ((FIRST, 2.0), (SECOND, 2.0 + 2.0 / N)):
        w = order * largest.omega
        gear = K + 1j * w * B
        sizes.append(size * abs(gear / (gear - free * w * w)))
    assert largest.peak == pytest.approx(sum(sizes), rel=0.02)
    assert largest.smallest == pytest.approx(sizes[0] - sizes[1], rel=0.04)
    assert analysis.exact.oscillation.max() == pytest.approx(sum(sizes), rel=0.01)
    assert {"damping of the gear", "kinematic error of order 2"} <= {remedy.what for remedy in analysis.remedies}


def test_a_comparison_has_the_period_of_the_beat(tmp_path):
    project = joint(tmp_path, pull=0.0)
    alone = "\n".join(line for line in TEXT.splitlines() if "wave_generator" not in line)
    alone = alone.replace("MOTOR", MOTORS["held"]).replace("PULL", "0").replace("title: joint", "title: plain")
    found = sw.compare([project, from_text(f"{alone}\n", tmp_path / "plain.yaml")])
    rpm = found.speed[0] * 30.0 / np.pi
    assert found.beat(0) == pytest.approx(25.0 * 60.0 / rpm, rel=1e-12)  # two beats in the 50 turns of an output turn
    assert found.beat(1) is None
    said = " ".join(str(found).split())
    assert f"{rpm:.4g}" in said
    assert "of the base angle" not in said
