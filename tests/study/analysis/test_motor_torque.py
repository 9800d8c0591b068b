"""The torque that a motor must give, against its two inertias integrated by SciPy from equations written here."""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from three_slopes import three_slopes

import strainwave as sw
from strainwave.base.units import ARCSEC, RPM
from strainwave.drive.demands.motor_limits import Need, sheet_findings
from strainwave.files.reading import from_text
from strainwave.study.analysis.verdict import Answer

N, J_M, J_L, PULL, T_C, WIDTH = 50.0, 6e-4, 1.3, 60.0, 0.15, 0.01
GEAR = (1e5, 1.4e5, 1.8e5, 28.0, 108.0)
LINES = ((1, 6.0), (2, 23.0))  # order, arcsec
DRIVE = """
gear:
  ratio: 50
  law: {{type: piecewise_linear, K1: 1e5 N*m/rad, K2: 1.4e5 N*m/rad, K3: 1.8e5 N*m/rad, T1: 28 N*m, T2: 108 N*m}}
motor:
  {{inertia: 6 kg*cm^2, loop: {{bandwidth: 30 Hz, damping: 0.7}},
   drag: {{type: coulomb, T_c: 0.15 N*m}}{motor}}}
load: {{inertia: 1.3 kg*m^2, drag: {{type: angle_torque, amplitude: 60 N*m}}}}
damping: {{B: 25 N*m*s/rad}}
speed: {{from: {low} rpm, to: {high} rpm, shaft: motor}}
excitation: {{kinematic_error: [{{order: 1, amplitude: 6 arcsec}}, {{order: 2, amplitude: 23 arcsec}}]}}
limit: {{oscillation: 200 arcsec}}
"""


def project(low=600, high=2000, motor=""):
    return from_text(DRIVE.format(low=low, high=high, motor=motor), Path("arm.yaml"))


def motor_torque(reference, load, end, samples, start=(0.0, 0.0, 0.0, 0.0)):
    """Times and torques [N*m] of the motor: d = theta_m - reference, q = theta_l - reference/N."""
    loop = 2.0 * math.pi * 30.0
    J = J_M + J_L / N**2
    K_p, K_d = J * loop**2, 1.4 * J * loop

    def rates(t, y):
        d, d_rate, q, q_rate = y.tolist()
        angle, speed, acceleration = reference(t)
        theta, omega = angle + d, speed + d_rate
        e = ARCSEC * sum(a * math.cos(k * theta) for k, a in LINES)
        slope = -ARCSEC * sum(k * a * math.sin(k * theta) for k, a in LINES)
        gear = three_slopes(d / N - q - e, GEAR) + 25.0 * (d_rate / N - q_rate - slope * omega)
        friction = T_C * omega / math.hypot(omega, WIDTH)
        motor = -K_p * d - K_d * d_rate - friction - (1.0 / N - slope) * gear
        output = (gear + load(angle / N + q)) / J_L
        return d_rate, motor / J_M - acceleration, q_rate, output - acceleration / N

    t = np.linspace(0.0, end, samples)
    y = solve_ivp(rates, (0.0, end), start, "DOP853", t, rtol=1e-8, atol=1e-11).y
    return t, -K_p * y[0] - K_d * y[1]


def at_speed(rpm, load, settle, turns, each=400):
    """Motor torque [N*m] at constant speed, in the last turns of the motor."""
    omega = rpm * RPM
    count = each * (settle + turns) + 1
    end = 2.0 * math.pi * (settle + turns) / omega
    _, torque = motor_torque(lambda t: (omega * t, omega, 0.0), load, end, count)
    return torque[each * settle :]


def test_the_motor_gives_what_a_constant_load_friction_and_the_vibration_take():
    found = project().under(-PULL).response(coexisting=False)
    motor = found.motor
    torque = at_speed(motor.at / RPM, lambda _: -PULL, 60, 4)
    assert motor.torque == pytest.approx(np.max(np.abs(torque)), rel=1e-3)
    i = int(np.argmin(np.abs(found.omega - motor.at)))
    assert found.motor_mean[i] == pytest.approx(np.mean(torque[:-1]), rel=1e-3)
    assert found.motor_mean[i] == pytest.approx(PULL / N + T_C, rel=0.02)  # the vibration's losses are beside it


def test_gravity_itself_asks_over_a_turn_of_the_output_what_its_largest_torque_does():
    found = project(1700, 2000).under(-PULL).response(coexisting=False)
    torque = at_speed(2000.0, lambda angle: -PULL * math.cos(angle), 50, 50)
    top = int(np.argmax(found.omega))
    assert found.motor_torque[top] == pytest.approx(np.max(np.abs(torque)), rel=1e-3)


@pytest.mark.slow
def test_a_motor_that_gravity_alone_overloads_fails_the_analysis_which_names_both_torques():
    found = project(motor=", max_torque: 0.3 N*m, max_speed: 1500 rpm").analyze()
    ramp, motor = found.train.ramp, found.motor
    times, speeds = np.array(ramp.run.train.reference)
    rates = np.diff(speeds) / np.diff(times)
    angles = np.append(0.0, np.cumsum(0.5 * (speeds[1:] + speeds[:-1]) * np.diff(times)))

    def reference(t):
        k = min(int(np.searchsorted(times, t, side="right")), len(rates)) - 1
        s = t - times[k]
        return angles[k] + (speeds[k] + 0.5 * rates[k] * s) * s, speeds[k] + rates[k] * s, rates[k]

    t, torque = motor_torque(reference, lambda angle: -PULL * math.sin(angle), times[-1], 20_001)
    begun = torque[t >= times[1]]
    assert motor.run_up == ramp.motor().run_up == pytest.approx(np.max(np.abs(begun)), rel=1e-3)
    rate = np.array([reference(at)[2] for at in t[t >= times[1]]])
    accelerating = (J_M + J_L / N**2) * rate  # the run-up's own choice: not asked of the motor
    assert ramp.motor().torque == pytest.approx(np.max(np.abs(begun - accelerating)), rel=1e-3)
    assert motor.torque == max(case.drive.motor.torque for case in found.load_cases)
    assert motor.load == -PULL
    assert motor.torque == pytest.approx(np.max(np.abs(at_speed(motor.at / RPM, lambda _: -PULL, 60, 4))), rel=1e-3)
    assert motor.holding == pytest.approx(PULL / N + T_C, rel=0.02)
    verdict = found.verdict
    assert verdict.answer is Answer.NOT
    assert verdict.allowed == ()
    torque, speed = verdict.exceeded
    assert "above its limit of 0.3 N*m (loads and friction alone require 1.3" in torque.sentence
    assert speed.sentence.startswith("The speed of the motor reaches 2000 rpm, above its limit of 1500 rpm")


def test_one_curve_is_judged_by_the_motor_too():
    drive = project(motor=", max_torque: 0.3 N*m, max_speed: 1500 rpm").under(-PULL)
    judged = drive.judged(drive.response(coexisting=False))
    assert judged.passes is False
    assert [sentence.split(" of")[0] for sentence in judged.failures] == ["The torque", "The speed"]
    strong = dataclasses.replace(drive, motor_limits=sw.MotorLimits(5.0, 3000.0 * RPM))
    assert strong.judged(strong.response(coexisting=False)).passes is True


SHEET = (
    ", peak_torque: [[0 rpm, 1.5 N*m], [1900 rpm, 1.5 N*m], [2000 rpm, 1.3 N*m]]"
    ", continuous_torque: [[0 rpm, 1.36 N*m], [2000 rpm, 1.29 N*m]], rated_speed: 1500 rpm, brake: 1.1 N*m"
)


def test_peak_and_rms_torque_are_judged_at_every_speed_against_the_curves_of_the_motor():
    loaded = project(1700, 2000, SHEET).under(-PULL)
    found = loaded.response(coexisting=False)
    torque = at_speed(2000.0, lambda _: -PULL, 60, 4)[:-1]
    peak, rms = np.max(np.abs(torque)), math.sqrt(np.mean(torque**2))
    top = int(np.argmax(found.omega))
    assert found.motor_rms[top] == pytest.approx(rms, rel=1e-3)
    judged = loaded.judged(found)
    passed = {finding.limit: finding for finding in judged.findings if finding.exceeded}
    assert set(passed) == {"motor torque", "motor rms torque", "motor rated speed", "motor brake torque"}
    assert passed["motor torque"].value == pytest.approx(peak, rel=1e-3)
    assert passed["motor torque"].bound == pytest.approx(1.3)
    assert f"at 2000 rpm, its available peak torque 1.3 N*m: {peak - 1.3:.2g}" in passed["motor torque"].sentence
    assert passed["motor brake torque"].value == pytest.approx(PULL / N)
    assert not passed["motor rated speed"].fails
    sheet, speeds = loaded.motor_limits, np.linspace(1700.0, 2000.0, 61) * RPM
    sizes = {"motor torque": found.motor_torque, "motor rms torque": found.motor_rms}
    asked = {name: np.interp(speeds, found.omega, size) for name, size in sizes.items()}
    for i, omega in enumerate(speeds):
        fails = any(size[i] > sheet.at(name, omega) for name, size in asked.items())
        near = any(abs(size[i] / sheet.at(name, omega) - 1.0) < 1e-3 for name, size in asked.items())
        assert near or fails == any(low <= omega <= high for low, high in judged.verdict.speeds)


def test_a_curve_that_dips_between_two_motions_is_met_at_its_own_points():
    need = Need(np.array([100.0, 200.0]), np.array([1.0, 1.2]), np.array([0.5, 0.5]), np.array([True]))
    dip = sw.MotorLimits(peak_torque=((0.0, 2.0), (140.0, 2.0), (150.0, 0.9), (160.0, 2.0), (200.0, 2.0)))
    speeds, torque, _, joined = need.against(dip, "motor torque")
    assert (speeds.tolist(), joined.tolist()) == ([100.0, 140.0, 150.0, 160.0, 200.0], [True] * 4)
    assert torque.tolist() == pytest.approx([1.0, 1.08, 1.1, 1.12, 1.2])
    (found,) = sheet_findings(dip, [need])
    assert (found.value, found.bound, found.omega) == (pytest.approx(1.1), 0.9, 150.0)
    apart = need._replace(joined=np.array([False]))
    assert apart.against(dip, "motor torque")[0].tolist() == [100.0, 200.0]


@pytest.mark.slow
def test_a_duty_cycle_is_judged_by_its_rms_torque_at_its_speeds_and_the_rest_that_is_named_makes_it_pass():
    limits = sw.MotorLimits(continuous_torque=((0.0, 1.4), (1000.0 * RPM, 1.0), (3000.0 * RPM, 0.4)), K_t=0.5)
    angle, time = math.radians(60.0), 0.5
    move = sw.move(project(), sw.Trapezoid(angle, time, ramp=0.5), limits=limits)
    rate = 4.0 * angle / time**2 * N
    half = 0.5 * time

    def reference(t):
        if t < half:
            return 0.5 * rate * t * t, rate * t, rate
        left = max(0.0, time - t)
        return N * angle - 0.5 * rate * left * left, rate * left, -rate if left else 0.0

    start = (0.0, 0.0, -ARCSEC * sum(size for _, size in LINES), 0.0)
    t, torque = motor_torque(reference, lambda q: -PULL * math.sin(q), time, 40_001, start)
    rms = math.sqrt(np.trapezoid(torque**2, t) / time)
    assert move.rms_motor_torque == pytest.approx(rms, rel=1e-4)
    assert move.peak_motor_torque == pytest.approx(np.max(np.abs(torque)), rel=1e-3)
    assert {fact.key: fact.value for fact in move.facts()}["motor.rms_current_A"] == pytest.approx(2.0 * rms, rel=1e-4)
    speed = np.array([reference(moment)[1] for moment in t])  # the deviation of the loop is below 1 % of it
    allowed = np.interp(speed, [0.0, 1000.0 * RPM, 3000.0 * RPM], [1.4, 1.0, 0.4])
    share = np.trapezoid((torque / allowed) ** 2, t)
    (finding,) = [one for one in move.findings if one.limit == "motor rms torque"]
    assert finding.bound == pytest.approx(math.sqrt(np.trapezoid(torque**2, t) / share), rel=5e-3)
    assert finding.fails == (share > time)
    rest = float(finding.sentence.split("add a rest of ")[1].split(" s")[0])
    held = PULL * math.sin(angle) / N / 1.4
    assert rest == pytest.approx((share - time) / (1.0 - held**2), rel=0.02)
    for duration, fails in ((0.5 * rest, True), (1.1 * rest, False)):  # friction holds a part of the load at rest
        cycle = sw.move(project(), [sw.Trapezoid(angle, time, ramp=0.5), sw.study.Dwell(duration)], limits=limits)
        assert [one.fails for one in cycle.findings if one.limit == "motor rms torque"] == [fails]
