"""The torque that a motor must give, against its two inertias integrated by SciPy from equations written here."""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.base.units import ARCSEC, RPM
from strainwave.files.reading import from_text
from strainwave.study.analysis.verdict import Answer

N, J_M, J_L, PULL, T_C, WIDTH = 50.0, 6e-4, 1.3, 60.0, 0.15, 3.0
GEAR_K, GEAR_T = (1.0e5, 1.4e5, 1.8e5), (28.0, 108.0)
LINES = ((1, 6.0), (2, 23.0))  # order, arcsec
DRIVE = """
gear:
  ratio: 50
  law: {{type: piecewise_linear, K1: 1e5 N*m/rad, K2: 1.4e5 N*m/rad, K3: 1.8e5 N*m/rad, T1: 28 N*m, T2: 108 N*m}}
motor:
  {{inertia: 6 kg*cm^2, loop: {{bandwidth: 30 Hz, damping: 0.7}},
   drag: {{type: coulomb, T_c: 0.15 N*m, width: 3 rad/s}}{motor}}}
load: {{inertia: 1.3 kg*m^2, drag: {{type: angle_torque, amplitude: 60 N*m}}}}
damping: {{B: 25 N*m*s/rad}}
speed: {{from: {low} rpm, to: {high} rpm, shaft: motor}}
excitation: {{kinematic_error: [{{order: 1, amplitude: 6 arcsec}}, {{order: 2, amplitude: 23 arcsec}}]}}
limit: {{oscillation: 200 arcsec}}
"""


def project(low=600, high=2000, motor=""):
    return from_text(DRIVE.format(low=low, high=high, motor=motor), Path("arm.yaml"))


def spring(u):
    (K1, K2, K3), (T1, T2) = GEAR_K, GEAR_T
    u1 = T1 / K1
    u2, size = u1 + (T2 - T1) / K2, abs(u)
    torque = K1 * size if size < u1 else T1 + K2 * (size - u1) if size < u2 else T2 + K3 * (size - u2)
    return math.copysign(torque, u)


def motor_torque(reference, load, end, samples, start=(0.0, 0.0, 0.0, 0.0)):
    """Times and torques [N*m] of the motor: d = theta_m - reference, q = theta_l - reference/N."""
    loop = 2.0 * math.pi * 30.0
    J = J_M + J_L / N**2
    K_p, K_d = J * loop**2, 1.4 * J * loop

    def rates(t, y):
        d, d_rate, q, q_rate = y
        angle, speed, acceleration = reference(t)
        theta, omega = angle + d, speed + d_rate
        e = ARCSEC * sum(a * math.cos(k * theta) for k, a in LINES)
        slope = -ARCSEC * sum(k * a * math.sin(k * theta) for k, a in LINES)
        gear = spring(d / N - q - e) + 25.0 * (d_rate / N - q_rate - slope * omega)
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
    times, (low, _, high) = ramp.run.train.reference.times, ramp.run.train.reference.speeds
    rate = (high - low) / (times[2] - times[1])

    def reference(t):
        run = max(0.0, t - times[1])
        return low * t + 0.5 * rate * run * run, low + rate * run, rate if run else 0.0

    t, torque = motor_torque(reference, lambda angle: -PULL * math.sin(angle), times[2], 20_001)
    begun = torque[t >= times[1]]
    assert motor.run_up == ramp.motor().run_up == pytest.approx(np.max(np.abs(begun)), rel=1e-3)
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
    assert "above its limit of 0.3 N*m (loads and friction alone take 1.3" in torque.sentence
    assert speed.sentence.startswith("The speed of the motor reaches 2000 rpm, above its limit of 1500 rpm")


def test_one_curve_is_judged_by_the_motor_too():
    drive = project(motor=", max_torque: 0.3 N*m, max_speed: 1500 rpm").under(-PULL)
    judged = drive.judged(drive.response(coexisting=False))
    assert judged.passes is False
    assert [sentence.split(" of")[0] for sentence in judged.failures] == ["The torque", "The speed"]
    strong = dataclasses.replace(drive, motor_limits=sw.MotorLimits(5.0, 3000.0 * RPM))
    assert strong.judged(strong.response(coexisting=False)).passes is True
