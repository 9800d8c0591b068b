"""Bode plots against the transfer functions of two inertias, and at amplitude against the error equation."""

import math

import numpy as np
import pytest
from canonical import PLAIN_TRAIN

import strainwave as sw

DRIVE = sw.Drive(J_m=5.26e-4, J_l=0.05, N=50.0, B=0.5, law=sw.Cubic(7160.0, 1e4))
OMEGA = np.linspace(50.0, 900.0, 18)


def closed_form(drive, omega, torque, gain=0.0):
    """Speeds (theta_m', theta_l') of the linear drive for a torque (T_m, T_l), with a speed loop of this gain."""
    s = 1j * omega
    z = drive.B + drive.law.stiffness(0.0) / s  # gear torque per rate of twist
    matrix = [[drive.J_m * s + gain + z / drive.N**2, -z / drive.N], [-z / drive.N, drive.J_l * s + z]]
    return np.linalg.solve(matrix, torque)


@pytest.mark.parametrize(("source", "torque"), [("motor", (1.0, 0.0)), ("load", (0.0, 1.0))])
@pytest.mark.parametrize("gain", [0.0, 0.3])
def test_linear_response_is_its_transfer_function(source, torque, gain):
    train = DRIVE.train(control=sw.train.SpeedLoop(gain) if gain else sw.train.Free())
    found = sw.bode(train, OMEGA, source=source)
    exact = np.array([closed_form(DRIVE, w, torque, gain) for w in OMEGA]).T
    np.testing.assert_allclose(found.motor, exact[0], rtol=1e-9)
    np.testing.assert_allclose(found.load, exact[1], rtol=1e-9)
    np.testing.assert_allclose(found.decibels("load"), 20 * np.log10(abs(exact[1])), atol=1e-7)


def test_resonance_and_antiresonance_are_those_of_the_textbook():
    train = DRIVE._replace(B=0.0).train()
    resonance = np.sqrt(7160.0 * (2500 * DRIVE.J_m + DRIVE.J_l) / (2500 * DRIVE.J_m * DRIVE.J_l))
    antiresonance = np.sqrt(7160.0 / DRIVE.J_l)
    assert np.max(sw.bode(train, 1.0).poles.imag) == pytest.approx(resonance, rel=1e-10)
    assert resonance == pytest.approx(DRIVE.omega_0, rel=1e-14)
    at = sw.bode(train, antiresonance * np.array([0.9, 1.0, 1.1])).motor
    assert abs(at[1]) < 1e-9 * abs(at[0])
    # the phase of the motor's speed turns by half a turn there, and back at the resonance
    degrees = sw.bode(DRIVE._replace(B=0.01).train(), antiresonance * np.array([0.9, 1.0, 1.008])).degrees()
    assert degrees[0] < -80.0
    assert degrees[2] > 50.0


def test_held_motor_leaves_the_load_alone_on_its_spring():
    found = sw.bode(DRIVE.train(control=sw.train.Held()), OMEGA, source="load")
    s = 1j * OMEGA
    np.testing.assert_allclose(found.load, 1.0 / (DRIVE.J_l * s + DRIVE.B + 7160.0 / s), rtol=1e-9)
    assert np.all(found.motor == 0.0)


def test_mean_torque_stiffens_the_small_signal():
    x = 5e-3
    found = sw.bode(DRIVE._replace(B=0.0).train(), 1.0, at=(x, 0.0, 0.0, 0.0))
    assert np.max(found.poles.imag) == pytest.approx(np.sqrt(DRIVE.law.stiffness(x) / DRIVE.J), rel=1e-8)


def test_coupling_adds_a_resonance():
    chain = sw.DriveTrain(
        sw.train.Motor(DRIVE.J_m),
        50.0,
        0.0,
        sw.Linear(7160.0),
        sw.train.Elastic(0.02, 0.0, sw.Linear(3e4), sw.train.Load(0.03)),
    )
    stiffness = np.array([[7160 / 2500, -7160 / 50, 0], [-7160 / 50, 7160 + 3e4, -3e4], [0, -3e4, 3e4]])
    squares = np.linalg.eigvals(np.diag([1 / DRIVE.J_m, 1 / 0.02, 1 / 0.03]) @ stiffness)
    exact = np.sqrt(np.sort(abs(squares))[1:])
    poles = np.sort(sw.bode(chain, 1.0).poles.imag)[-2:]
    np.testing.assert_allclose(poles, exact, rtol=1e-8)
    # at low frequency the whole train turns as one inertia
    slow = sw.bode(chain, 1e-2).load[0]
    assert abs(slow) == pytest.approx(1.0 / (50.0 * 1e-2 * (DRIVE.J_m + 0.05 / 2500)), rel=1e-6)


@pytest.mark.parametrize("control", [sw.train.Free(), sw.train.PositionLoop(0.05, 0.02)], ids=["free", "loop"])
def test_small_amplitude_gives_the_linear_response(control):
    train, omega = DRIVE.train(control=control), np.array([150.0, 420.0])
    small, linear = sw.bode(train, omega, amplitude=1e-7), sw.bode(train, omega)
    np.testing.assert_allclose(small.motor, linear.motor, rtol=1e-5)
    np.testing.assert_allclose(small.load, linear.load, rtol=1e-5)
    assert small.messages == ()


def test_large_amplitude_has_the_torsion_of_the_error_equation():
    damped = DRIVE._replace(B=5.0)
    found = sw.bode(damped.train(), [380.0], amplitude=1.0)
    twist = (found.motor[0] / 50.0 - found.load[0]) / 380.0
    # amplitude(1) of x, by Taylor integration of the four states and by harmonic balance of the reduced equation
    assert abs(twist) == pytest.approx(9.55480228e-4, rel=1e-6)
    assert abs(sw.bode(damped.train(), [380.0]).load[0] / found.load[0] - 1.0) > 1e-3


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: sw.bode(PLAIN_TRAIN, [1e-300]), "omega has 0 rad/s; a frequency must be positive, 1e-60 up"),
        (lambda: sw.bode(PLAIN_TRAIN, [0.0]), "omega has 0 rad/s; a frequency must be positive"),
        (lambda: sw.bode(PLAIN_TRAIN, [1.0], source="gear"), "source is 'gear'; it must be 'motor' or 'load'"),
        (lambda: sw.bode(PLAIN_TRAIN, [1.0], amplitude=-1.0), "amplitude is -1.0; it must be a positive"),
        (lambda: sw.bode(PLAIN_TRAIN, [1.0], at=(0.0, 0.0)), "at is .*; it must be 4 finite numbers"),
        (lambda: sw.bode(PLAIN_TRAIN, [1.0]).decibels("x"), "shaft is 'x'; it must be 'motor' or 'load'"),
        (
            lambda: sw.bode(DRIVE.train(control=sw.train.Held()), [1.0]),
            "a held motor does not respond to torque; use source='load'",
        ),
    ],
)
def test_bad_input_is_told_in_one_sentence(call, sentence):
    with pytest.raises(ValueError, match=sentence):
        call()


def test_a_bode_plot_prints_as_a_summary_not_as_its_numbers():
    plot = sw.bode(sw.HDC_40_050.train(), np.geomspace(1.0, 1000.0, 240))
    assert len(str(plot).splitlines()) <= 5
    assert repr([plot]) == f"[{plot}]"
    # free-free: sqrt(K/J) with J = N^2 J_m J_l/(N^2 J_m + J_l), and damping B/(2 sqrt(K J))
    drive = sw.HDC_40_050
    both = drive.N**2 * drive.J_m
    J = both * drive.J_l / (both + drive.J_l)
    K = float(drive.law.stiffness(0.0))
    assert f"{math.sqrt(K / J):.6g} rad/s (damping ratio {drive.B / (2.0 * math.sqrt(K * J)):.3g})" in str(plot)
