"""Loops by bandwidth and damping, and with the lag of a current loop."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.model.train.controls import HERTZ, Tuning, tuning_of

DRIVE = sw.Drive(4.5e-4, 1.3, 50.0, 20.0, sw.Linear(1e5))
INERTIA = DRIVE.J_m + DRIVE.J_l / DRIVE.N**2
LOOPS = [(30.0, 0.7, "position"), (30.0, 1.0, "speed"), (5.0, 0.5, "speed"), (12.0, 1.5, "position")]


@pytest.mark.parametrize(("hertz", "damping", "kind"), LOOPS)
def test_a_loop_on_a_rigid_gear_has_the_poles_of_its_bandwidth_and_damping(hertz, damping, kind):
    """With a gear 1e4 times stiffer the slow poles are those of s^2 + 2 zeta omega_n s + omega_n^2."""
    loop = sw.train.from_bandwidth(hertz * HERTZ, INERTIA, damping, kind=kind)
    rigid = DRIVE._replace(law=sw.Linear(1e9), B=2e3).train(control=loop)
    slow = sorted(sw.bode(rigid, [1.0]).poles, key=abs)[:2]
    omega_n = hertz * HERTZ / (1.0 if kind == "position" else 2.0 * damping)
    polynomial = np.poly(slow).real
    assert polynomial == pytest.approx([1.0, 2.0 * damping * omega_n, omega_n**2], rel=1e-3)


def test_a_speed_loop_of_damping_1_integrates_at_a_quarter_of_its_bandwidth():
    loop = sw.train.from_bandwidth(200.0, 1e-3, 1.0, kind="speed")
    assert loop == sw.train.SpeedLoop(0.2, pytest.approx(0.2 * 200.0 / 4.0, rel=1e-14))
    assert sw.train.from_bandwidth(200.0, 1e-3, 0.7) == sw.train.PositionLoop(40.0, pytest.approx(0.28, rel=1e-14))


@pytest.mark.parametrize("lag", [0.0, 1e-3])
@pytest.mark.parametrize(("hertz", "damping", "kind"), LOOPS)
def test_the_gains_tell_bandwidth_and_damping_again(hertz, damping, kind, lag):
    loop = sw.train.from_bandwidth(hertz * HERTZ, INERTIA, damping, kind=kind, lag=lag)
    found = tuning_of(loop, INERTIA)
    assert found._replace(bandwidth=1.0, damping=1.0) == Tuning(1.0, 1.0, kind, lag)
    assert found[:2] == pytest.approx((hertz * HERTZ, damping))


@pytest.mark.parametrize(
    "control", [sw.train.Free(), sw.train.Held(), sw.train.SpeedLoop(0.5), sw.train.PositionLoop(0.0, 0.1)]
)
def test_a_control_without_a_pair_of_poles_has_no_bandwidth(control):
    assert tuning_of(control, INERTIA) is None


LAG = 2e-3
LAGGED = [sw.train.SpeedLoop(0.3, 10.0, 2e-4), sw.train.PositionLoop(30.0, 0.3)]


@pytest.mark.parametrize("loop", LAGGED, ids=["speed", "position"])
def test_a_lagged_loop_moves_as_equations_written_by_hand(loop):
    """With T of the loop as a state of its own: lag T' + T = K_i x + K_p v + K_d v'."""
    train = DRIVE.train(control=sw.train.Lagged(loop, LAG), motor_torque=sw.Harmonic(0.5, 2), omega=40.0)
    run = sw.simulate(train, (1e-4, 0.0, 2e-3, 0.3, 0.0), (0.0, 0.2), method=sw.Dopri5(rtol=1e-11, atol=1e-14))
    K_i, K_p, K_d = (
        (loop.K_i, loop.K_p, loop.K_d) if isinstance(loop, sw.train.SpeedLoop) else (loop.K_p, loop.K_d, 0.0)
    )

    def rates(t, y):
        x, dx, angle, speed, T = y
        gear = DRIVE.B * dx + 1e5 * x
        fast = (0.5 * math.cos(2.0 * 40.0 * t) - T - gear / DRIVE.N) / DRIVE.J_m
        slow = gear / DRIVE.J_l
        return [dx, fast / DRIVE.N - slow, speed, fast, (K_i * angle + K_p * speed + K_d * fast - T) / LAG]

    # z = 0 at the start: T = K_d v/lag there
    start = [1e-4, 0.0, 2e-3, 0.3, K_d / LAG * 0.3]
    exact = solve_ivp(rates, (0.0, 0.2), start, method="DOP853", rtol=1e-11, atol=1e-14)
    assert run.y[:4, -1] == pytest.approx(exact.y[:4, -1], rel=1e-7)
    assert run.y[4, -1] + K_d / LAG * run.y[3, -1] == pytest.approx(exact.y[4, -1], rel=1e-7)


def test_the_periodic_motion_of_a_lagged_loop_is_that_of_equations_written_by_hand():
    """With a kinematic error that follows the motor's own angle, which gives way."""
    omega, e, N = 140.0, 1.1e-4, DRIVE.N
    loop = sw.train.from_bandwidth(30.0 * HERTZ, INERTIA, 0.7, lag=LAG)
    error = sw.KinematicError((sw.Line(2, e),))
    orbit = sw.find_orbit(DRIVE.train(control=loop, kinematic_error=error, omega=omega), harmonics=8)

    def rates(t, y):
        x, dx, angle, speed, T = y
        theta, turn = omega * t + angle, omega + speed
        slope = -2.0 * e * math.sin(2.0 * theta)
        gear = DRIVE.B * (dx - slope * turn) + 1e5 * (x - e * math.cos(2.0 * theta))
        fast = (-T - (1.0 / N - slope) * gear) / DRIVE.J_m
        loop_torque = loop.loop.K_p * angle + loop.loop.K_d * speed
        return [dx, fast / N - gear / DRIVE.J_l, speed, fast, (loop_torque - T) / LAG]

    period = 2.0 * math.pi / omega
    times = np.linspace(60.0 * period, 61.0 * period, 800)
    found = solve_ivp(rates, (0.0, times[-1]), [e, 0, 0, 0, 0], "DOP853", times, rtol=1e-10, atol=1e-14)
    assert orbit.stable
    assert orbit.peak == pytest.approx(np.max(np.abs(found.y[0])), rel=1e-4)  # of samples 1/800 of a turn apart


def test_a_lagged_loop_stands_where_the_loop_itself_does():
    torque = sw.Harmonic(0.0, mean=-50.0)
    states = [
        sw.study.operating_state(DRIVE.train(control=control, load_torque=torque), 100.0)
        for control in (sw.train.PositionLoop(30.0, 0.3), sw.train.Lagged(sw.train.PositionLoop(30.0, 0.3), LAG))
    ]
    assert states[1][:4] == pytest.approx(states[0][:4], rel=1e-9, abs=1e-12)
    assert states[1][4] == pytest.approx(30.0 * states[0][2], rel=1e-9)


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"bandwidth": -1.0}, r"bandwidth \[rad/s\] is -1.0; it must be a positive finite number"),
        ({"inertia": 0.0}, r"inertia \[kg\*m\^2\] is 0.0; it must be a positive"),
        ({"damping": 0.0}, "damping is 0.0; it must be a positive"),
        ({"kind": "torque"}, "kind is 'torque'; it must be 'position', 'speed' or 'cascade'"),
        ({"lag": -1.0}, r"lag \[s\] is -1; it must be zero or more"),
        ({"lag": 5e-3}, "a bandwidth of 31.83 Hz is above half the inverse lag, 15.92 Hz for 5 ms; lower the"),
    ],
)
def test_what_gives_no_loop_is_said(asked, said):
    with pytest.raises(ValueError, match=said):
        sw.train.from_bandwidth(**({"bandwidth": 200.0, "inertia": 1e-3} | asked))


@pytest.mark.parametrize(
    ("control", "said"),
    [
        (sw.train.Lagged(sw.train.SpeedLoop(0.1), 0.0), "Lagged.lag is 0 s; it must be positive"),
        (sw.train.Lagged(sw.train.SpeedLoop(-0.1), 1e-3), "SpeedLoop.K_p is -0.1; with a negative gain"),
    ],
)
def test_what_is_no_lagged_loop_is_said(control, said):
    with pytest.raises(ValueError, match=said):
        DRIVE.train(control=control)
