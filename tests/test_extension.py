"""What a user adds to the package, each as one class outside it, used everywhere it should work."""

from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.compile.jit import as_python
from strainwave.maths import tanh
from strainwave.model.train.train_forms import AtLoad


class LevellingLoop(NamedTuple):
    """A control: a position loop whose torque levels off at a limit."""

    K_p: float
    K_d: float
    limit: float

    def torque(self, x, v):
        return self.limit * tanh((self.K_p * x + self.K_d * v) / self.limit)


class LaggingLoop(NamedTuple):
    """A control with a state of its own: a position loop whose torque follows at a rate."""

    K_p: float
    K_d: float
    rate: float

    states = 1

    def torque(self, x, v, z):
        return z[0]

    def z_rate(self, x, v, z):
        return (self.rate * (self.K_p * x + self.K_d * v - z[0]),)


ERROR = sw.KinematicError((sw.Line(2, 1.1e-4, 0.3),))
DRIVE = sw.Drive(5.26e-4, 5e-2, 50.0, 5.0, sw.Cubic(7160.0, 1e4))
LOOP = sw.PositionLoop(2.0, 0.05)
CONTROLS = {"levelling": LevellingLoop(2.0, 0.05, 0.1), "lagging": LaggingLoop(2.0, 0.05, 900.0)}
each_control = pytest.mark.parametrize("control", CONTROLS.values(), ids=CONTROLS.keys())
TIGHT = sw.Dopri5(rtol=1e-11, atol=1e-14)


def with_control(control, omega=190.0):
    return DRIVE.train(control=control, kinematic_error=ERROR, load_torque=sw.Harmonic(3.0), omega=omega)


def in_absolute_angles(t, y):
    theta_m, theta_l, speed_m, speed_l, *z = y
    x, v = theta_m - 190.0 * t, speed_m - 190.0
    wanted = 2.0 * x + 0.05 * v
    against = z[0] if z else 0.1 * np.tanh(wanted / 0.1)
    u = theta_m / 50 - theta_l - ERROR.value(theta_m)
    du = speed_m / 50 - speed_l - ERROR.slope(theta_m) * speed_m
    torque = DRIVE.law.torque(u) + 5.0 * du
    motor = -against - (1 / 50 - ERROR.slope(theta_m)) * torque
    load = 3.0 * np.cos(190.0 * t) + torque
    return [speed_m, speed_l, motor / DRIVE.J_m, load / DRIVE.J_l, *([900.0 * (wanted - z[0])] if z else [])]


@each_control
def test_simulation_with_a_users_control_agrees_with_scipy_in_absolute_angles(control):
    train = with_control(control)
    states = len(train.state_names())
    with as_python(10**9):
        run = sw.simulate(train, np.zeros(states), 0.05, method=TIGHT)
    start = [0.0, 0.0, 190.0, 190.0 / 50, *([0.0] * (states - 4))]
    other = solve_ivp(in_absolute_angles, (0, 0.05), start, "DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
    x, v, angle, speed = run.y[:4, -1]
    theta_m = 190.0 * 0.05 + angle
    found = [theta_m, theta_m / 50 - x, 190.0 + speed, (190.0 + speed) / 50 - v, *run.y[4:, -1]]
    np.testing.assert_allclose(found, other, rtol=1e-8, atol=1e-10)


@pytest.mark.slow
@each_control
def test_orbit_and_response_curve_with_a_users_control_are_where_it_settles(control):
    train = with_control(control)
    system = AtLoad(train, train.omega)
    with as_python(10**9):
        orbit = sw.find_orbit(system, harmonics=15)
        y = orbit.state(np.zeros(1))[:, 0]
        end = sw.simulate(system, y, 2.0 * np.pi / train.omega, method=TIGHT).y[:, -1]
        curve = sw.frequency_response(system, (189.0, 190.0), harmonics=15)
    assert orbit.stable
    np.testing.assert_allclose(end, y, rtol=0, atol=1e-6 * np.max(np.abs(y)))
    assert curve.omega[-1] == pytest.approx(190.0)
    assert curve.peak[-1] == pytest.approx(orbit.peak, rel=1e-6)


def test_bode_of_a_users_control_is_that_of_its_linear_loop_and_of_the_textbook():
    omega = np.array([30.0, 150.0, 420.0])
    expected = sw.bode(DRIVE.train(control=LOOP), omega)
    found = sw.bode(DRIVE.train(control=CONTROLS["levelling"]), omega)
    np.testing.assert_allclose(found.motor, expected.motor, rtol=1e-3)  # differences over 1 mrad of a tanh
    s = 1j * omega
    gear, loop = DRIVE.law.K + DRIVE.B * s, (2.0 + 0.05 * s) * 900.0 / (900.0 + s)
    passed = gear * DRIVE.J_l * s**2 / (gear + DRIVE.J_l * s**2)  # stiffness of the gear with the load behind it
    textbook = s / (DRIVE.J_m * s**2 + loop + passed / DRIVE.N**2)
    np.testing.assert_allclose(sw.bode(DRIVE.train(control=CONTROLS["lagging"]), omega).motor, textbook, rtol=1e-6)


def test_powers_of_a_train_with_a_users_control_add_up():
    train = with_control(CONTROLS["lagging"])
    assert train.state_names()[2:5] == ("motor deviation", "motor deviation'", "control z1")
    with as_python(10**9):
        run = sw.drive_run(train, np.zeros(5), 0.05, method=TIGHT)
    assert run.imbalance < 1e-8


@pytest.mark.compiled
@pytest.mark.slow
@each_control
def test_compiled_code_runs_a_users_control(control):
    train = with_control(control)
    y0 = np.full(len(train.state_names()), 1e-4)
    system = AtLoad(train, train.omega)
    method = sw.Rk4(steps_per_period=400)
    compiled = sw.simulate(train, y0, 0.02, method=method).y[:, -1], sw.find_orbit(system, harmonics=6).peak
    with as_python(10**9):
        python = sw.simulate(train, y0, 0.02, method=method).y[:, -1], sw.find_orbit(system, harmonics=6).peak
    np.testing.assert_allclose(compiled[0], python[0], rtol=0, atol=1e-12)
    assert compiled[1] == pytest.approx(python[1], rel=1e-10)


@pytest.mark.parametrize("control", ["PD", LevellingLoop], ids=["text", "class"])
def test_what_is_no_control_is_refused(control):
    with pytest.raises(TypeError, match=r"^Motor\.control is "):
        with_control(control)
