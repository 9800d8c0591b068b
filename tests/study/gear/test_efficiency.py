"""Load-proportional friction: equations by hand, energies, efficiencies against closed forms and a catalogue."""

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from three_slopes import three_slopes

import strainwave as sw

RPM = math.pi / 30.0
SLOPES = sw.PiecewiseLinear(1e5, 1.4e5, 1.8e5, 54.0, 196.0)
SIZES = (14, 17, 20, 25)


def sign(v, width):
    return v / math.sqrt(v * v + width * width)


@pytest.mark.slow
def test_a_train_with_friction_is_the_equation_written_by_hand():
    # J_m theta_m'' = -K_p d - K_d d' - (T + mu |T| sign(theta_m'))/N, J_l theta_l'' = T + T_l; the load's torque turns
    # round, so that |T| has its kink, and the motor starts from rest, so that the sign of its speed does too
    J_m, J_l, N, B, mu, width = 6e-4, 0.8, 50.0, 30.0, 0.2, 0.5
    K_p, K_d, mean, size = 40.0, 0.3, 10.0, 90.0
    profile = sw.train.SpeedProfile((0.0, 0.1, 0.4), (0.0, 60.0, -20.0))

    def reference(t):
        if t <= 0.1:
            return 300.0 * t * t, 600.0 * t
        s = t - 0.1
        return 3.0 + 60.0 * s - 0.5 * 80.0 / 0.3 * s * s, 60.0 - 80.0 / 0.3 * s

    def rhs(t, y):
        theta_m, v_m, theta_l, v_l = y.tolist()
        angle, speed = reference(t)
        T = three_slopes(theta_m / N - theta_l, SLOPES) + B * (v_m / N - v_l)
        control = -K_p * (theta_m - angle) - K_d * (v_m - speed)
        a_m = (control - (T + mu * abs(T) * sign(v_m, width)) / N) / J_m
        return [v_m, a_m, v_l, (T + mean + size * math.cos(90.0 * t)) / J_l]

    drive = sw.Drive(J_m, J_l, N, B, SLOPES)
    train = drive.train(
        control=sw.train.PositionLoop(K_p, K_d), load_torque=sw.Harmonic(size, 90, mean=mean), reference=profile,
        friction=sw.laws.LoadFriction(mu, width),
    )  # fmt: skip
    times = np.linspace(0.0, 0.4, 41)
    run = sw.drive_run(train, (0.0, 0.0, 0.0, 0.0), times, method=sw.Dopri5(rtol=1e-11, atol=1e-14))
    y, seen = np.zeros(4), [np.zeros(4)]
    for a, b in pairwise(times):
        y = solve_ivp(rhs, (a, b), y, method="DOP853", rtol=1e-12, atol=1e-14, max_step=1e-3).y[:, -1]
        seen.append(y)
    theta_m, _, theta_l, _ = np.transpose(seen)
    x = theta_m / N - theta_l
    assert np.max(np.abs(run.error - x)) < 1e-7 * np.max(np.abs(x))
    assert np.min(run.torque) < 0.0 < np.max(run.torque)
    assert np.min(run.motor_speed) < -15.0
    assert run.imbalance < 1e-8
    assert run.lost()["gear friction"] > 1.0


@pytest.mark.parametrize("way", ["driving", "back_driving"])
def test_the_energies_of_a_run_give_the_efficiency(way):
    gear = sw.catalogue.gear("RT1-H-CS-25-100")
    T, v = 60.0, 150.0
    load = T if way == "back_driving" else -T  # along the motion the load drives
    train = sw.Drive(1e-4, 0.5, 100.0, 20.0, sw.Linear(5e4)).train(
        control=sw.train.Held(),
        load_torque=sw.Harmonic(0.0, mean=load),
        motor_drag=gear.drag,
        friction=gear.friction,
        omega=v,
    )
    run = sw.drive_run(train, None, 0.2)
    at_load, at_motor = run.work["load torque"][-1], run.work["control"][-1]
    ratio = -at_load / at_motor if way == "driving" else -at_motor / at_load
    assert ratio == pytest.approx(getattr(sw.study.efficiency(train, T, v), way)[0, 0], rel=1e-9)
    assert run.imbalance < 1e-8


@pytest.mark.parametrize("size", SIZES)
def test_friction_from_a_catalogue_gives_its_efficiency_and_its_running_torque(size):
    # Schaeffler RT1-H-CS, ratio 100 (TPI 275): efficiency at rated torque and 2000 rpm, torques without load
    gear = sw.catalogue.gear(f"RT1-H-CS-{size}-100")
    train = sw.Drive(1e-4, 1.0, 100.0, 1.0, sw.Linear(1e4)).train(friction=gear.friction, motor_drag=gear.drag)
    found = sw.study.efficiency(train, gear.rated_torque, 2000.0 * RPM)
    assert found.driving[0, 0] == pytest.approx(gear.efficiency, abs=1e-4)
    assert float(gear.drag.torque(0.0, 2000.0 * RPM, ())) == pytest.approx(gear.running_torque, rel=1e-4)
    assert 0.05 < gear.friction.mu < 0.15


@pytest.mark.parametrize("size", SIZES)
def test_the_back_driving_torque_that_follows_is_near_the_catalogues(size):
    # nothing of it is in the fit: N T_start/(1 - mu) against the printed one; the efficiency is good to 3 points
    gear = sw.catalogue.gear(f"RT1-H-CS-{size}-100")
    follows = 100.0 * gear.starting_torque / (1.0 - gear.friction.mu)
    assert follows == pytest.approx(gear.back_driving_torque, rel=0.12)


def test_more_load_is_more_efficient_and_more_speed_less():
    gear = sw.catalogue.gear("RT1-H-CS-17-100")
    train = sw.Drive(1e-4, 1.0, 100.0, 1.0, sw.Linear(1e4)).train(friction=gear.friction, motor_drag=gear.drag)
    found = sw.study.efficiency(train, [5.0, 15.0, 31.0], [50.0, 200.0])
    assert found.driving.shape == (2, 3)
    assert np.all(np.diff(found.driving, axis=1) > 0.0)
    assert np.all(np.diff(found.driving, axis=0) < 0.0)
    assert np.all(found.driving < 1.0 / (1.0 + gear.friction.mu))
    light = sw.study.efficiency(train, 0.5 * found.back_driving_torque[0], 50.0)
    assert light.back_driving[0, 0] < 0.0


def test_bad_numbers_get_a_sentence():
    with pytest.raises(ValueError, match=r"from 0 up to 1"):
        sw.Drive(1e-4, 1.0, 100.0, 1.0, sw.Linear(1e4)).train(friction=sw.laws.LoadFriction(1.2))
    with pytest.raises(ValueError, match="running torque alone loses more"):
        sw.gears.load_friction(0.9, 10.0, 100.0, 0.05)
    with pytest.raises(ValueError, match=r"at most 1, 77 % is 0\.77"):
        sw.gears.load_friction(77.0, 10.0, 100.0)
    with pytest.raises(ValueError, match="no source gives the efficiency of CSG-25-100"):
        sw.catalogue.gear("CSG-25-100").friction  # noqa: B018
    with pytest.raises(ValueError, match="need at least as much at speed"):
        sw.gears.no_load_drag(0.02, 0.05)
    train = sw.Drive(1e-4, 1.0, 100.0, 1.0, sw.Linear(1e4)).train()
    with pytest.raises(ValueError, match=r"torque \[N\*m\]"):
        sw.study.efficiency(train, -1.0, 10.0)
