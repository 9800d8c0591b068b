"""Motions of a drive train: energies against closed forms, their balance, limits, and a run-up through resonance."""

from itertools import pairwise

import numpy as np
import pytest
from canonical import BALANCED, PLAIN_TRAIN, TRAINS
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import strainwave as sw

LINEAR = sw.Drive(J_m=5.26e-4, J_l=0.05, N=50.0, B=5.0, law=sw.Linear(7160.0))
GEAR = sw.catalogue.gear("CSG-40-50")
# cubic fit of that gear's stiffness, inertia of its wave generator, 3 % damping with the motor held, 23 arcsec
J_L, LAW = 1.3, sw.Cubic(1.089e5, 6.85e4)
DRIVE = sw.Drive(J_m=4.5e-4, J_l=J_L, N=50.0, B=2 * 0.03 * (LAW.K * J_L) ** 0.5, law=LAW)
ERROR = sw.KinematicError((sw.Line(2, 1.115e-4),))


def test_a_run_beyond_what_floats_resolve_is_refused_at_once():
    with pytest.raises(ValueError, match="where floats no longer resolve it; stay within"):
        sw.drive_run(PLAIN_TRAIN, t=1e300)


@pytest.mark.slow
@pytest.mark.parametrize("name", BALANCED)
def test_energy_balance_closes_to_1e_8(name):
    train = TRAINS[name]
    start = np.random.default_rng(1).uniform(-0.02, 0.02, len(train.state_names()))
    run = sw.drive_run(train, start, 0.3 if name == "held" else 1.5, method=sw.Dopri5(rtol=1e-10, atol=1e-13))
    assert run.trajectory.status is sw.Status.OK
    assert run.imbalance < 1e-8
    assert tuple(run.work) == train.power_names()
    assert all(np.min(np.diff(run.work[element])) > -1e-12 for element in run.lost())
    assert sum(run.lost().values()) > 0.0


def test_balance_sees_a_missing_element():
    run = sw.drive_run(PLAIN_TRAIN, (0.1, 0.0, 0.0, 0.0), 1.5)
    run.work["gear damping"][:] = 0.0
    assert run.imbalance > 1e-4


def test_efficiency_of_a_steady_motion_is_its_closed_form():
    # at constant speed T_m = b omega + T_l/N, so the efficiency is T_l/(N T_m)
    omega, b, load = 100.0, 2e-4, 3.0
    T_m = b * omega + load / 50.0
    train = LINEAR.train(
        motor_torque=sw.Harmonic(0.0, mean=T_m),
        load_torque=sw.Harmonic(0.0, mean=-load),
        motor_drag=sw.laws.Viscous(b),
        omega=omega,
    )
    run = sw.drive_run(train, (load / 7160.0, 0.0, 0.0, 0.0), 0.1)
    assert run.efficiency() == pytest.approx(load / (50.0 * T_m), rel=1e-9)
    assert run.lost()["motor drag"] == pytest.approx(b * omega**2 * 0.1, rel=1e-9)
    np.testing.assert_allclose(run.motor_speed, omega, rtol=1e-9)
    np.testing.assert_allclose(run.torque, load, rtol=1e-9)
    np.testing.assert_allclose(run.load_speed, omega / 50.0, rtol=1e-9)


def test_gear_damping_takes_pi_b_omega_a_squared_a_period():
    omega = 300.0
    equation = LINEAR.error_equation(motor_torque=sw.Harmonic(1.0), omega=omega)
    orbit = sw.find_orbit(equation)
    x, v = orbit.state(0.0)
    train = LINEAR.train(motor_torque=sw.Harmonic(1.0), omega=omega)
    run = sw.drive_run(train, (x, v, 0.0, 0.0), 2.0 * np.pi / omega)
    assert run.lost()["gear damping"] == pytest.approx(np.pi * 5.0 * omega * orbit.amplitude(1) ** 2, rel=1e-8)
    assert run.error[0] == x


def test_speed_and_torque_beyond_the_gears_limits_are_warnings():
    # 4000 rpm at the input and 523 N m repeated peak torque (catalogue); the load takes 600 N m at 450 rad/s = 4297 rpm
    train = DRIVE.train(control=sw.train.Held(), load_torque=sw.Harmonic(0.0, mean=-600.0), omega=450.0)
    run = sw.drive_run(train, (4e-3, 0.0), 0.05, gear=GEAR)
    assert run.trajectory.status is sw.Status.OK
    said = " ".join(run.warnings)
    assert "4297" in said
    assert len(run.warnings) >= 2
    assert sw.drive_run(train, (4e-3, 0.0), 0.05).warnings == ()


def test_bad_starts_and_times_are_told():
    with pytest.raises(ValueError, match="it must be 4 numbers: x, x', motor deviation, motor deviation'"):
        sw.drive_run(PLAIN_TRAIN, (0.0, 0.0))
    run = sw.drive_run(PLAIN_TRAIN, None, 0.1)
    with pytest.raises(ValueError, match=r"the run lasts from 0 to 0\.1 s; 2 s is outside"):
        run.efficiency(2.0)


def run_through(duration):
    """Largest |x| of the held drive on a run-up through its resonance."""
    profile = sw.train.SpeedProfile((0.0, duration), (100.0, 200.0))
    train = DRIVE.train(control=sw.train.Held(), kinematic_error=ERROR, reference=profile)
    run = sw.simulate(train, (0.0, 0.0), duration, method=sw.Dopri5(rtol=1e-7, atol=1e-12))
    assert run.status is sw.Status.OK
    return run.peak(after=0.1 * duration)


@pytest.mark.slow
def test_slow_run_up_reaches_the_peak_of_the_steady_response_and_a_fast_one_does_not():
    equation = DRIVE.error_equation(motor="held", kinematic_error=ERROR)
    steady = sw.frequency_response(equation, (100.0, 200.0))
    assert len(steady.folds) == 2  # the jump is there: the run-up follows the upper branch to its end
    largest = [run_through(duration) / steady.peak.max() for duration in (0.5, 2.0, 8.0)]
    assert largest[0] < largest[1] < largest[2] < 1.0
    assert largest[0] < 0.7
    assert largest[2] > 0.95


def test_a_start_that_is_no_state_is_refused():
    train = sw.DriveTrain(
        sw.train.Motor(1e-4), 50.0, 1.0, sw.Linear(1e4), sw.train.Load(1.0), reference=sw.train.AtRest()
    )
    with pytest.raises(ValueError, match=r"y0 is .*; it must be"):
        sw.drive_run(train, [0.0], 1e-3)


# A move of 200 ms after a rest of 500 ms: speeds of the motor through these points.
MOVE = sw.train.SpeedProfile((0.5, 0.55, 0.65, 0.7), (0.0, 60.0, 60.0, 0.0))
END = 0.75


def moved(y, gravity, t):
    """States (x, x') of DRIVE, held on MOVE under gravity sin(theta_l + 1), by DOP853 from corner to corner."""
    corners, speeds = (0.0, *MOVE.times, END), (0.0, *MOVE.speeds, 0.0)
    starts = (0.0, 0.0, 1.5, 7.5, 9.0, 9.0)
    found, largest = np.full((2, len(t)), np.nan), np.zeros(2)
    for i, (a, b) in enumerate(pairwise(corners)):
        rate = (speeds[i + 1] - speeds[i]) / (b - a)

        def rhs(time, y, a=a, i=i, rate=rate):
            angle = starts[i] + (speeds[i] + 0.5 * rate * (time - a)) * (time - a)
            torque = LAW.K * (y[0] + LAW.alpha * y[0] ** 3) + DRIVE.B * y[1]
            return y[1], rate / 50.0 - (torque - gravity * np.sin(angle / 50.0 - y[0] + 1.0)) / J_L

        part = solve_ivp(rhs, (a, b), y, method="DOP853", rtol=1e-11, atol=1e-15, dense_output=True)
        inside, y = (a <= t) & (t <= b), part.y[:, -1]
        if inside.any():
            found[:, inside] = part.sol(t[inside])
        x, v = part.sol(np.linspace(a, b, 4001))
        torque = LAW.K * (x + LAW.alpha * x**3) + DRIVE.B * v
        largest = np.maximum(largest, [np.max(np.abs(x)), np.max(np.abs(torque))])
    return found, largest


@pytest.mark.parametrize(
    ("gravity", "times"), [(0.0, END), (0.0, [0.0, 0.2, END]), (60.0, np.linspace(0.0, END, 8))], ids=["0", "3", "8"]
)
def test_move_after_a_rest_under_gravity(gravity, times):
    train = DRIVE.train(control=sw.train.Held(), reference=MOVE, load_drag=sw.train.AngleTorque(gravity, 1, 1.0))
    run = sw.drive_run(train, None, times, method=sw.Dopri5(rtol=1e-7, atol=1e-12))
    # the twist under which the gear holds the load at rest: theta_l = -x
    rest = brentq(lambda x: LAW.torque(x) - gravity * np.sin(1.0 - x), -1e-2, 1.1e-2, xtol=1e-18)
    assert run.error[0] == pytest.approx(rest, rel=1e-9, abs=1e-15)
    exact, (error, torque) = moved((rest, 0.0), gravity, run.trajectory.t)
    np.testing.assert_allclose(run.error, exact[0], rtol=0, atol=3e-6 * error)
    assert run.peak_error == pytest.approx(error, rel=1e-5)
    assert run.largest()[0] == run.peak_error
    assert run.peak_torque == pytest.approx(torque, rel=1e-4)
    assert run.peak_speed == pytest.approx(60.0, rel=1e-12)


@pytest.mark.parametrize(
    "control", [sw.train.Held(), sw.train.PositionLoop(20.0, 0.5), sw.train.SpeedLoop(0.5, 20.0)], ids=str
)
def test_nothing_moves_before_a_move_begins(control):
    # with a kinematic error too: the load waits at theta_m/N - e - u
    train = DRIVE.train(
        control=control, reference=MOVE, load_drag=sw.train.AngleTorque(60.0, 1, 1.0),
        kinematic_error=sw.KinematicError((sw.Line(2, 1e-4, 0.3),)),
        load_torque=sw.train.TorqueProfile((1.0, 2.0), (-30.0, 0.0)),
    )  # fmt: skip
    run = sw.drive_run(train, None, 0.1, method=sw.Dopri5(rtol=1e-7, atol=1e-13))
    assert np.ptp(run.error) < 1e-8 * abs(run.error[0])
    assert np.ptp(run.torque) < 1e-6 * abs(run.torque[0])


def test_torque_that_nothing_holds_is_told():
    slack = sw.Drive(4.5e-4, 1.3, 50.0, 20.0, sw.Linear(0.0))
    train = slack.train(control=sw.train.Held(), load_torque=sw.Harmonic(0.0, mean=-3.0), reference=sw.train.AtRest())
    with pytest.raises(sw.SolveError, match="give the initial state, y0"):
        sw.drive_run(train, None, 0.1)


@pytest.mark.slow
def test_a_lagged_speed_loop_without_integral_part_begins_on_its_reference_and_gives_way():
    # against a constant torque its speed falls by T/(N K_p); at first there is no deviation, so no torque of the loop
    K_p, load = 0.1, 20.0
    control = sw.train.Lagged(sw.train.SpeedLoop(K_p=K_p, K_i=0.0), 1e-3)
    train = LINEAR.train(load_torque=sw.Harmonic(0.0, mean=-load), omega=100.0, control=control)
    run = sw.drive_run(train, None, 0.3)
    np.testing.assert_allclose(run.trajectory.y[:, 0], (load / 7160.0, 0.0, 0.0, 0.0, 0.0), rtol=1e-9, atol=1e-12)
    assert run.trajectory.y[3, -1] == pytest.approx(-load / (50.0 * K_p), rel=1e-3)


def test_torque_between_samples_counts_for_the_limits():
    # 600 N*m for 20 ms, more than the gear may carry, between two samples
    knock = sw.train.TorqueProfile((0.1, 0.11, 0.13, 0.14), (0.0, -600.0, -600.0, 0.0))
    train = DRIVE.train(control=sw.train.Held(), reference=sw.train.AtRest(), load_torque=knock)
    run = sw.drive_run(train, None, [0.0, 0.05, 0.5], gear=GEAR, method=sw.Dopri5())
    assert np.max(np.abs(run.torque)) < 100.0
    assert run.peak_torque > 600.0
    assert run.warnings
    loose = train._replace(load=sw.train.Elastic(0.5, 10.0, sw.Linear(4e5), train.load))
    every, seldom = (sw.drive_run(loose, None, t, method=sw.Dopri5()) for t in (0.13, [0.0, 0.05, 0.13]))
    assert seldom.peak_error == pytest.approx(np.max(np.abs(every.error)), rel=2e-3)
    assert seldom.peak_error == pytest.approx(every.peak_error, rel=1e-5)
    assert seldom.peak_torque == pytest.approx(every.peak_torque, rel=1e-5)
