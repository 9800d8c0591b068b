"""A move against equations written by hand, closed forms of slow and rigid moves, and what is refused."""

import dataclasses
import math
import re
import tracemalloc
from functools import partial

import numpy as np
import pytest
from canonical import Saturating
from loop_machines import SLOPES as SHG_25_100
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, root
from three_slopes import three_slopes

import strainwave as sw
from strainwave.base.law import torque_of
from strainwave.base.units import ARCSEC, RPM
from strainwave.study.move.servo import settled

pytestmark = pytest.mark.slow

GEAR = sw.catalogue.gear("SHG-25-100")
N, J_M, J_L, B, PULL = 100.0, GEAR.input_inertia + 2e-5, 0.5, 5.0, 60.0
LOOP = sw.train.from_bandwidth(60.0 * math.pi, J_M + J_L / N**2, 0.7)
ERROR = sw.KinematicError((sw.Line(2, 5e-5),))
TRAIN = sw.DriveTrain(
    sw.train.Motor(J_M, control=LOOP), N, B, GEAR.law, sw.train.Load(J_L, drag=sw.train.AngleTorque(PULL)), error=ERROR
)  # fmt: skip
QUARTER, TIME = 0.5 * math.pi, 0.6
LINEAR = TRAIN._replace(law=sw.Linear(31000.0), error=sw.NoError())
ROUGH = sw.Dopri5(rtol=1e-6, atol=1e-9)
torque = partial(three_slopes, slopes=SHG_25_100)


def commanded(t, k):
    """Angle and speed of the load in part k of the trapezoid: ramp, constant speed, ramp, rest."""
    ramp, top = TIME / 3.0, 1.5 * QUARTER / TIME
    if k == 0:
        return 0.5 * top / ramp * t * t, top / ramp * t
    if k == 1:
        return 0.5 * top * ramp + top * (t - ramp), top
    left = TIME - t if k == 2 else 0.0
    return QUARTER - 0.5 * top / ramp * left * left, top / ramp * left


def rates(t, y, k):
    """Angles and speeds of motor and load, by Newton's law."""
    motor, fast, load, slow = y.tolist()
    angle, speed = commanded(t, k)
    e, slope = 5e-5 * math.cos(2.0 * motor), -1e-4 * math.sin(2.0 * motor)
    passed = torque(motor / N - load - e) + B * (fast / N - slow - slope * fast)
    drive = -LOOP.K_p * (motor - N * angle) - LOOP.K_d * (fast - N * speed)
    return fast, (drive - (1.0 / N - slope) * passed) / J_M, slow, (passed - PULL * math.sin(load)) / J_L


@pytest.mark.slow
def test_a_quarter_turn_in_600_ms_is_that_of_dop853_on_equations_by_hand():
    move = sw.move(TRAIN, sw.Trapezoid(QUARTER, TIME), gear=GEAR)
    knots, y = (0.0, 0.2, 0.4, 0.6, float(move.time[-1])), (0.0, 0.0, -5e-5, 0.0)
    # at rest: torque = PULL sin(load) and 0 = K_p motor + torque/N; PULL sin(load) is far below the first bend
    load = brentq(lambda q: torque(-PULL * math.sin(q) / N / LOOP.K_p / N - q - 5e-5) - PULL * math.sin(q), -1e-3, 1e-3)
    motor = -PULL * math.sin(load) / N / LOOP.K_p
    load = brentq(
        lambda q: torque(motor / N - q - 5e-5 * math.cos(2 * motor)) - PULL * math.sin(q), -1e-3, 1e-3, xtol=1e-18
    )  # fmt: skip
    y, largest, parts = (motor, 0.0, load, 0.0), 0.0, []
    for k in range(4):
        span = (knots[k], knots[k + 1])
        parts.append(solve_ivp(rates, span, y, "DOP853", rtol=1e-12, atol=1e-15, args=(k,), dense_output=True))
        use = (move.time > span[0]) & (move.time <= span[1])
        angle = np.array([commanded(t, k)[0] for t in move.time[use]])
        theirs = angle - parts[-1].sol(move.time[use])[2]
        np.testing.assert_allclose(move.pointing_error[use], theirs, rtol=0.0, atol=1e-6 * move.peak_error)
        y, largest = parts[-1].y[:, -1], max(largest, float(np.max(np.abs(theirs))))
    assert move.peak_error == pytest.approx(largest, rel=1e-5)  # samples of the steps may miss the top
    # settled: the last time at which the error is the window away from that at rest, which the run's end has
    tail = parts[-1].sol
    rest = QUARTER - float(tail(knots[-1])[2])
    assert move.rest_error == pytest.approx(rest, rel=2e-3)
    off = lambda t: abs(QUARTER - tail(t)[2] - move.rest_error) - move.window  # noqa: E731
    times = np.linspace(TIME, knots[-1], 40001)
    last = np.flatnonzero([off(t) > 0.0 for t in times])[-1]
    settled = brentq(off, times[last], times[last + 1], xtol=1e-14) - TIME
    assert move.settling_time == pytest.approx(settled, rel=1e-6)
    assert move.window == pytest.approx(60.0 * ARCSEC)
    assert move.imbalance < 1e-8
    assert move.motor_work - move.dissipated == pytest.approx(move.stored, rel=1e-8)
    assert move.warnings == ()
    # rest by hand: torsion of 60 N m beyond both bends, and the droop of the loop
    twist = 14.0 / 31000.0 + 34.0 / 50000.0 + (PULL - 48.0) / 57000.0
    assert move.rest_error == pytest.approx(twist + PULL / N**2 / LOOP.K_p, abs=6e-5)  # and at most the kinematic error


LAGGING = sw.train.CascadeLoop(30.0, 0.12, 0.02)
FILTER = sw.train.LowPassFilter(2000.0, 0.6)
FILTERED_LAG = sw.train.Lagged(sw.train.Filtered(LAGGING, FILTER), 4e-4)
LOOPS = {
    "position": LOOP,
    "cascade": LAGGING,
    "PI cascade": sw.train.PositionIntegral(LAGGING, 0.2),
    "lag": sw.train.Lagged(LAGGING, 4e-4),
    "feedforward": LAGGING,
    "lag, feedforward": FILTERED_LAG,
    "lag, feedforward at the motor": FILTERED_LAG,
    "unlimited feedforward": sw.train.PositionIntegral(LAGGING, 0.2),
    "limited speed": sw.train.PositionIntegral(LAGGING, 0.2),
    "encoder of the load": sw.train.LoadEncoder(LAGGING._replace(K_v=9.0)),
    "unlimited, both encoders": sw.train.MixedEncoders(LAGGING, 50.0),
}
SHARES = sw.Feedforward(0.9, 0.8, 0.7, 0.98)


@pytest.mark.slow
def test_a_move_with_lines_of_both_turns_is_that_of_equations_by_hand():
    first, second, phase, order, stiff = 5e-5, 3e-5, 0.7, 2.0 - 2.0 / N, 31000.0
    error = sw.KinematicError((sw.Line(2, first), sw.Line(order, second, phase)))
    train = LINEAR._replace(error=error)
    move = sw.move(train, sw.Trapezoid(QUARTER, TIME))

    def written(t, y, k):
        motor, fast, load, slow = y.tolist()
        angle, speed = commanded(t, k)
        shaft = 2.0 * motor - 2.0 * motor / N + phase  # twice a motor turn against the output, which turns by 1/N
        e = first * math.cos(2.0 * motor) + second * math.cos(shaft)
        slope = -2.0 * first * math.sin(2.0 * motor) - (2.0 - 2.0 / N) * second * math.sin(shaft)
        passed = stiff * (motor / N - load - e) + B * (fast / N - slow - slope * fast)
        drive = -LOOP.K_p * (motor - N * angle) - LOOP.K_d * (fast - N * speed)
        return fast, (drive - (1.0 / N - slope) * passed) / J_M, slow, (passed - PULL * math.sin(load)) / J_L

    # at rest: stiff (motor/N - load - e) = PULL sin(load), and 0 = K_p motor + (1/N - e') PULL sin(load)
    rest = root(lambda y: written(0.0, np.array([y[0], 0.0, y[1], 0.0]), 0)[1::2], (0.0, -first), tol=1e-15).x
    y, knots = (rest[0], 0.0, rest[1], 0.0), (0.0, 0.2, 0.4, 0.6, float(move.time[-1]))
    for k in range(4):
        span = (knots[k], knots[k + 1])
        run = solve_ivp(written, span, y, "DOP853", rtol=1e-12, atol=1e-15, args=(k,), dense_output=True)
        use = (move.time > span[0]) & (move.time <= span[1])
        theirs = np.array([commanded(t, k)[0] for t in move.time[use]]) - run.sol(move.time[use])[2]
        np.testing.assert_allclose(move.pointing_error[use], theirs, rtol=0.0, atol=1e-6 * move.peak_error)
        y = tuple(run.y[:, -1])
    (said,) = (remark for remark in move.remarks if "beat" in remark)
    # 100/2 turns of the motor in a beat of the lines, 100 with gravity; a quarter of the output in 0.6 s is 25 turns
    beats = "The error beats every 100 turns of the motor (its kinematic error alone every 50), 2.4 s at the mean speed"
    assert said.startswith(f"{beats}; the motor turns 25 times in 0.6 s.")
    along = np.linspace(0.0, 0.5 * np.pi * N, 20_001)
    slow = np.max(np.abs(first * np.cos(2.0 * along) + second * np.cos(order * along + phase)))
    assert move.passes[0].quasi_steady == pytest.approx(slow, rel=1e-3)
    assert any(p.row(1)[0].value == "2 - 2/100" for p in move.passes)
    alone = train._replace(load=sw.train.Load(J_L))
    whole = sw.move(alone, sw.Trapezoid(math.pi, 2.0 * TIME), method=ROUGH)
    assert not any("beat" in remark for remark in whole.remarks)


@pytest.mark.slow
@pytest.mark.parametrize("kind", LOOPS)
def test_a_move_with_limit_and_feedforward_is_that_of_equations_by_hand(kind):
    most, tail, weight = 0.3, 0.4, sw.Parallel(sw.train.AngleTorque(20.0), sw.laws.Viscous(1.0))
    fed, behind = SHARES if "feedforward" in kind else sw.Feedforward(), "at the motor" in kind
    fed = fed._replace(at="motor") if behind else fed
    PI = kind in ("PI cascade", "limited speed", "unlimited feedforward")
    if "unlimited" in kind:
        most = 1e9
    motor = sw.train.Motor(J_M, drag=sw.laws.Viscous(1e-4), control=LOOPS[kind])
    load = sw.train.Load(J_L, sw.Harmonic(0.0, mean=-5.0), weight)
    train = LINEAR._replace(motor=motor, load=load)
    curve = (0.0, 0.29), (150.0, 0.29), (400.0, 0.2)  # of the motor
    speed = {"limited speed": 320.0, "encoder of the load": 300.0}.get(kind, math.inf)
    sheet = sw.MotorLimits(most) if math.isinf(speed) else sw.MotorLimits(most, speed, curve)
    more = {} if most > 1e6 else {"limits": sheet, "limited": True}
    move = sw.move(train, sw.Trapezoid(QUARTER, TIME), feedforward=fed, tail=tail, **more)
    (K_v, K_p, T_n), of_load = LAGGING, "encoder" in kind
    K_v = 9.0 if "of the load" in kind else K_v

    def rates(t, y, k):
        motor, fast, load, slow, integral, place, lagged, mixed, low, low_rate = y.tolist()
        angle, speed = commanded(t, k)
        quick = (1.5 * QUARTER / TIME) / (TIME / 3.0) * (1, 0, -1, 0)[k]
        x, v = motor - N * angle, fast - fed.speed * N * speed
        x_l = N * (load - angle)
        seen = {"encoder of the load": x_l, "unlimited, both encoders": mixed}.get(kind, x)
        command = fed.speed * N * speed - K_v * (seen + (place / 0.2 if PI else 0.0))
        w = fast - min(max(command, -sheet.speed), sheet.speed)
        wanted = -K_p * (w + integral / T_n)
        forward = fed.acceleration * (J_M * N + J_L / N) * quick + fed.gravity * (20.0 * math.sin(angle) + 5.0) / N
        forward += fed.friction * (1e-4 * N + 1.0 / N) * speed
        wanted, forward = (wanted, forward) if behind else (wanted + forward, 0.0)
        asked = {"position": -LOOP.K_p * x - LOOP.K_d * v}.get(kind, lagged if "lag" in kind else wanted) + forward
        bend = 4e6 * (wanted - low) - 2400.0 * low_rate  # 2000 rad/s, damping 0.6
        largest = 0.29 - 0.09 * min(max(abs(fast) - 150.0, 0.0) / 250.0, 1.0) if sheet.peak_torque else most
        given = min(max(asked, -largest), largest)
        passed = 31000.0 * (motor / N - load) + B * (fast / N - slow)
        held = given != asked or abs(command) > sheet.speed
        pull = 20.0 * math.sin(load) + slow + 5.0
        return [
            fast, (given - passed / N - 1e-4 * fast) / J_M, slow, (passed - pull) / J_L, w - (given - asked) / K_p,
            0.0 if held else x, ((low if "forward" in kind else wanted) - lagged) / 4e-4, v + 50.0 * (x_l - mixed),
            low_rate, bend,
        ]  # fmt: skip

    # at rest: 20 sin(load) + 5 = -31000 load with the motor at 0, but for the position loop and encoders of the load
    knots, y = (0.0, 0.2, 0.4, 0.6, TIME + tail), np.zeros(10)
    y[2] = brentq(lambda q: 31000.0 * q + 20.0 * math.sin(q) + 5.0, -1e-3, 0.0, xtol=1e-18)
    held = 5.0 / N if of_load else -31000.0 * y[2] / N
    if of_load:
        y[0], y[2] = N * 5.0 / 31000.0, 0.0
    y[4], y[6] = -(held - fed.gravity * 5.0 / N) * T_n / K_p, held - behind * fed.gravity * 5.0 / N
    y[8] = y[6]
    if kind == "position":
        y[0] = -held / LOOP.K_p
        y[2] += y[0] / N * 31000.0 / (31000.0 + 20.0)
    for k in range(4):
        span = (knots[k], knots[k + 1])
        part = solve_ivp(rates, span, y, "DOP853", rtol=1e-10, atol=1e-13, max_step=1e-3, args=(k,), dense_output=True)
        use = (move.time > span[0]) & (move.time <= span[1])
        theirs = np.array([commanded(t, k)[0] for t in move.time[use]]) - part.sol(move.time[use])[2]
        np.testing.assert_allclose(
            move.pointing_error[use], theirs, rtol=0.0, atol=(1e-5 if more else 1e-6) * move.peak_error
        )
        y = part.y[:, -1]
    if more:
        assert move.peak_motor_torque == (0.29 if sheet.peak_torque else most)
        assert move.within_limits
        assert len(move.remarks) == (1 if math.isinf(speed) else 2)
        assert float(re.search("at its limit for (.*) s", move.remarks[-1])[1]) > 0.01


def test_a_slow_move_has_the_torques_and_means_of_a_rigid_drive():
    # 1 rad in 5 s on a level axis: the inertias take less than 0.2 N m
    train = LINEAR._replace(load=sw.train.Load(J_L, sw.Harmonic(0.0, mean=-30.0)))
    move = sw.move(train, sw.SCurve(1.0, 5.0), gear=GEAR, tail=0.1, method=ROUGH)
    assert move.rms_gear_torque == pytest.approx(30.0, rel=1e-3)
    assert move.average_gear_torque == pytest.approx(30.0, rel=1e-3)
    assert move.rms_motor_torque == pytest.approx(0.3, rel=1e-3)
    assert move.average_speed == pytest.approx(N / 5.0, rel=1e-12)
    assert move.peak_speed == pytest.approx(1.5 * N / 5.0, rel=2e-3)
    # L10 = 10 000 h (rated/average)^3 (2000 rpm/mean speed), SHG-25-100: 87 N m
    assert move.life == pytest.approx(1e4 * (87.0 / 30.0) ** 3 * 2000.0 * RPM / (N / 5.0), rel=4e-3)
    assert move.rest_error == pytest.approx(30.0 / 31000.0 + 0.3 / LOOP.K_p / N, rel=1e-9)
    assert move.rms_error == pytest.approx(move.rest_error, rel=1e-3)
    assert move.settling_time == 0.0
    assert move.work["load torque"] == pytest.approx(-30.0, rel=1e-4)
    assert move.motor_work == pytest.approx(30.0, rel=1e-3)


def test_friction_of_the_meshing_costs_its_share_of_a_slow_lift():
    train = LINEAR._replace(load=sw.train.Load(J_L, sw.Harmonic(0.0, mean=-30.0)), friction=sw.laws.LoadFriction(0.1))
    slow = sw.SCurve(1.0, 3.0)
    move = sw.move(train, slow, tail=0.1, method=sw.Dopri5(rtol=1e-4, atol=1e-7))
    moving = (move.time > 1.3) & (move.time < 1.7)
    np.testing.assert_allclose(move.motor_torque[moving], 1.1 * 30.0 / N, rtol=1e-3)
    assert move.dissipated == pytest.approx(0.1 * 30.0 * 1.0, rel=3e-3)  # of 30 J over 1 rad
    (said,) = sw.move(train, slow, limits=sw.MotorLimits(torque=0.32), tail=0.1, method=ROUGH).failures
    assert "loads and friction alone require 0.33 N*m" in said
    assert "the torque is too large even without acceleration" in said


def test_an_error_at_rest_is_that_of_gravity_and_the_window_is_about_it():
    move = sw.move(LINEAR, sw.Trapezoid(QUARTER, TIME), method=ROUGH)
    assert move.rest_error == pytest.approx(PULL / 31000.0 + PULL / N**2 / LOOP.K_p, rel=1e-5)
    wide = sw.move(LINEAR, sw.Trapezoid(QUARTER, TIME), window=1e-2, method=ROUGH)
    narrow = sw.move(LINEAR, sw.Trapezoid(QUARTER, TIME), window=1e-9, method=ROUGH)
    assert wide.settling_time == 0.0
    assert narrow.settling_time is None
    assert move.gear_torque[-1] == pytest.approx(PULL, rel=1e-2)
    assert move.motor_torque[-1] == pytest.approx(PULL / N, rel=1e-2)


def test_every_motion_of_a_duty_cycle_settles_and_a_cycle_gains_no_energy():
    there, back = sw.SCurve(0.5, 0.3), sw.Trapezoid(-0.5, 0.3)
    move = sw.move(LINEAR, [there, sw.study.Dwell(0.4), back, sw.study.Dwell(0.4)], window=1e-5, method=ROUGH)
    alone = sw.move(LINEAR, there, window=1e-5, tail=0.4, method=ROUGH)
    assert move.duration == pytest.approx(1.4)
    assert len(move.settling_times) == 2
    assert move.settling_times[0] == pytest.approx(alone.settling_time, rel=1e-5)
    assert move.settling_time == move.settling_times[1]
    assert move.reference[-1] == pytest.approx(0.0, abs=1e-15)
    assert abs(move.stored) < 1e-6 * move.peak_gear_torque
    assert np.all(np.diff(move.time) > 0.0)


def test_a_payload_adds_its_inertia_and_its_weight():
    load = sw.Payload(mass=4.0, radius=0.5, inertia=0.1, phase=0.3)
    weight = 4.0 * 9.80665 * 0.5
    bare = LINEAR._replace(load=sw.train.Load(J_L))
    heavy = LINEAR._replace(load=sw.train.Load(J_L + 1.1, drag=sw.train.AngleTorque(weight, 1, 0.3)))
    part = sw.Trapezoid(0.5, 0.4)
    options = {"tail": 0.1, "method": ROUGH, "start": 0.2}
    carried, same = sw.move(bare, part, payload=load, **options), sw.move(heavy, part, **options)
    np.testing.assert_array_equal(carried.pointing_error, same.pointing_error)
    assert carried.gear_torque[0] == pytest.approx(weight * math.sin(0.5), rel=1e-3)  # start 0.2 and phase 0.3


def test_a_held_motor_follows_exactly_and_its_torque_is_what_that_takes():
    train = LINEAR._replace(motor=sw.train.Motor(J_M, control=sw.train.Held()), load=sw.train.Load(J_L))
    move = sw.move(train, sw.Trapezoid(1.0, 0.4), tail=0.2, method=ROUGH)
    np.testing.assert_allclose(move.motor_speed, move.reference_speed, atol=1e-9)
    # J_m N theta'' + T/N, the gear's torque that of the load
    later = (move.time > 0.01) & (move.time < 0.12)
    acceleration = 4.5 / 0.16
    np.testing.assert_allclose(
        move.motor_torque[later], J_M * N * acceleration + move.gear_torque[later] / N, rtol=1e-9
    )  # fmt: skip


@pytest.mark.slow
def test_a_resonance_is_passed_where_order_times_speed_is_its_frequency_and_costs_less_when_faster():
    held = LINEAR._replace(
        motor=sw.train.Motor(J_M, control=sw.train.Held()), load=sw.train.Load(J_L), error=ERROR, B=2.0
    )
    natural = math.sqrt(31000.0 / J_L)
    found = []
    for time in (0.5, 1.4):
        move = sw.move(held, sw.Trapezoid(2.0, time), tail=0.1, bands=[(100.0, 140.0)], method=ROUGH)
        assert [crossing.order for crossing in move.passes] == [2, 2]
        assert move.passes[0].speed == pytest.approx(0.5 * natural, rel=1e-6)
        top = 3.0 * N / time  # of the trapezoid, reached in a third of the time
        assert move.passes[0].time == pytest.approx(0.5 * natural / top * time / 3.0, rel=1e-6)
        assert move.passes[0].quasi_steady == pytest.approx(5e-5, rel=1e-5)
        assert move.time_in_bands == (pytest.approx(2.0 * 40.0 / top * time / 3.0, rel=1e-9),)
        found.append(move.passes[0].amplification)
    steady = 31000.0 / (2.0 * natural)  # 1/(2 zeta)
    assert 1.0 < found[0] < found[1] < 1.1 * steady


def test_torques_of_an_angle_have_their_means_and_torques_of_the_time_act_in_time():
    part, options = sw.SCurve(0.1, 0.1), {"tail": 0.1, "method": ROUGH}
    with_lines = LINEAR._replace(load=sw.train.Load(J_L, sw.Harmonic(5.0, order=2, mean=-20.0)))
    constant = LINEAR._replace(load=sw.train.Load(J_L, sw.Harmonic(0.0, mean=-20.0)))
    lines, mean = sw.move(with_lines, part, **options), sw.move(constant, part, **options)
    assert "torque lines, defined for constant speed, are omitted" in lines.remarks[0]
    np.testing.assert_array_equal(lines.pointing_error, mean.pointing_error)
    assert mean.remarks == ()
    comes = LINEAR._replace(load=sw.train.Load(J_L, sw.train.TorqueProfile((0.02, 0.05), (0.0, -20.0))))
    timed = sw.move(comes, part, **options)
    assert timed.gear_torque[0] == pytest.approx(0.0, abs=1e-9)
    assert timed.rest_error == pytest.approx(mean.rest_error, rel=1e-9)
    t = np.linspace(0.0, 0.1, 2001)  # of a rigid drive; by integration of the torque over the commanded angle
    rigid = np.trapezoid(np.interp(t, (0.02, 0.05), (0.0, -20.0)), np.interp(t, timed.time, timed.reference))
    assert timed.work["load torque"] == pytest.approx(rigid, rel=0.02)


def test_gravity_beside_friction_of_the_load_holds_it_at_the_equilibrium_however_short_the_run():
    # two torques side by side were taken for a law with memory: the last error of the run was said
    train = LINEAR._replace(load=sw.train.Load(J_L, drag=sw.Parallel(sw.train.AngleTorque(PULL), sw.laws.Viscous(0.1))))
    move = sw.move(train, sw.SCurve(0.3, 0.15), tail=0.03, method=ROUGH)
    lag = 1.0 / 31000.0 + 1.0 / N**2 / LOOP.K_p
    rest = brentq(lambda error: error - lag * PULL * math.sin(0.3 - error), 0.0, 0.1)
    assert move.rest_error == pytest.approx(rest, rel=1e-9)
    assert abs(move.pointing_error[-1] - rest) > 0.01 * rest


def test_a_law_with_memory_rests_where_a_longer_wait_brings_it():
    # the error at the end of the run, which still vibrated, was said
    train = LINEAR._replace(law=sw.Parallel(sw.Linear(31000.0), sw.BoucWen(6e4, 0.0, 8e-5)))
    move = sw.move(train, sw.Trapezoid(QUARTER, TIME), tail=0.03, method=ROUGH)

    def by_hand(t, y, k):
        motor, fast, load, slow, z = y.tolist()
        angle, speed = commanded(t, k)
        strain, share = fast / N - slow, abs(z) / 8e-5
        passed = 31000.0 * (motor / N - load) + 6e4 * z + B * strain
        drive = -LOOP.K_p * (motor - N * angle) - LOOP.K_d * (fast - N * speed)
        slip = strain - share * (0.5 * abs(strain) * math.copysign(1.0, z) + 0.5 * strain)
        return fast, (drive - passed / N) / J_M, slow, (passed - PULL * math.sin(load)) / J_L, slip

    y, knots = np.zeros(5), (0.0, TIME / 3.0, 2.0 * TIME / 3.0, TIME, 2.0 * TIME)
    for k in range(4):
        y = solve_ivp(by_hand, knots[k : k + 2], y, "DOP853", args=(k,), rtol=1e-8, atol=1e-12).y[:, -1]
    assert move.rest_error == pytest.approx(QUARTER - y[2], rel=1e-3)
    assert abs(move.pointing_error[-1] - move.rest_error) > 0.01 * move.rest_error


LEVEL = TRAIN._replace(load=sw.train.Load(J_L))
SAGGING = TRAIN._replace(motor=sw.train.Motor(J_M, control=sw.train.SpeedLoop(0.05)))
FREE = TRAIN._replace(motor=sw.train.Motor(J_M))
REFUSED = [
    ((TRAIN, sw.Trapezoid(QUARTER, TIME)), {"limits": sw.MotorLimits(torque=-1.0)},
     r"MotorLimits.torque is -1.0; it must be a positive finite number"),
    ((TRAIN, sw.Trapezoid(QUARTER, TIME)), {"payload": sw.Payload(-1.0, 0.5)}, "Payload.mass is -1"),
    ((TRAIN, sw.Trapezoid(QUARTER, TIME)), {"window": 0.0}, "window"),
    ((TRAIN, sw.Trapezoid(QUARTER, TIME)), {"tail": math.nan}, "tail"),
    ((TRAIN, sw.Trapezoid(QUARTER, TIME)), {"bands": [(2.0, 1.0)]}, "bands"),
    ((FREE, sw.Trapezoid(QUARTER, TIME)), {}, "the motor of this drive is free and cannot follow a profile"),
    ((SAGGING, sw.Trapezoid(QUARTER, TIME)), {}, "does not correct the motor's angle"),
    ((TRAIN,), {}, "there is no profile"),
    ((TRAIN, sw.Trapezoid(QUARTER, TIME)), {"limited": True}, "a limited move needs the largest motor torque"),
    (
        (TRAIN, sw.Trapezoid(QUARTER, TIME)),
        {"limited": True, "limits": sw.MotorLimits(0.5)},
        r"at rest the load requires 0.6 N\*m from the motor, whose limit is 0.5 N\*m: the motor cannot hold",
    ),
    ((TRAIN, []), {}, "the profile is empty"),
]  # fmt: skip


@pytest.mark.parametrize(("given", "options", "said"), REFUSED)
def test_what_cannot_be_moved_is_refused_in_one_sentence(given, options, said):
    with pytest.raises(ValueError, match=said) as caught:
        sw.move(*given, **options)
    assert "\n" not in str(caught.value)


# what a move asks beyond its limits, and what is said of it
BEYOND = [
    (TRAIN, {"limits": sw.MotorLimits(speed=3000.0 * RPM)},
     r"3\d\d\d rpm, above its limit of 3000 rpm; .*lengthen the move from 0.6 s to at least 0.75 s \(rigid drive"),
    # gravity alone takes 60/100 N m
    (TRAIN, {"limits": sw.MotorLimits(torque=0.3)},
      r"above its limit of 0.3 N\*m \(loads and friction alone require 0.6 N\*m\); .*large even without acceleration"),
    # (J_m N + J_l/N) 4.5 QUARTER/TIME^2 = 0.3475 N m, and TIME sqrt(0.3475/0.3) = 0.6458 s
    (LEVEL, {"limits": sw.MotorLimits(torque=0.3)},
     r"limit of 0.3 N\*m; the move is computed with unlimited .*; lengthen the move from 0.6 s to at least 0.6458 s"),
    # the vibration alone is beyond
    (LEVEL, {"limits": sw.MotorLimits(torque=0.35)},
     r"above its limit of 0.35 N\*m; .* torque; use a longer time, a smoother profile or a stronger motor"),
    (TRAIN, {"payload": sw.Payload(100.0, 0.5), "gear": GEAR}, r"above the momentary torque of SHG-25-100, 369 N\*m"),
]  # fmt: skip


@pytest.mark.parametrize(("train", "options", "said"), BEYOND)
def test_a_move_beyond_its_limits_is_computed_and_fails_first_of_all(train, options, said):
    part = sw.Trapezoid(QUARTER, TIME)
    move = sw.move(train, part, tail=0.1, method=ROUGH, **options)
    free = sw.move(train, part, tail=0.1, method=ROUGH, payload=options.get("payload"))
    assert move.within_limits is False
    assert any(re.search(said, sentence) for sentence in move.failures)
    assert str(move).startswith("FAIL: The ")
    assert move.peak_motor_torque == free.peak_motor_torque
    assert free.within_limits is None
    assert free.failures == ()


def test_a_mean_speed_above_that_of_a_duty_cycle_is_no_failure():
    gear = dataclasses.replace(GEAR, average_rpm=100.0)
    move = sw.move(LEVEL, sw.Trapezoid(QUARTER, TIME), gear=gear, tail=0.1, method=ROUGH)
    assert any("largest average input speed" in warning for warning in move.warnings)
    assert move.failures == ()
    assert move.within_limits is True


def test_a_move_of_too_many_steps_takes_less_than_a_gigabyte():
    tracemalloc.start()
    try:
        with pytest.raises(sw.SolveError, match=r"takes more than [\d,]+ steps and reached .* of 1e\+09 s"):
            sw.move(LINEAR, sw.Trapezoid(QUARTER, TIME), tail=1e9)
        assert tracemalloc.get_traced_memory()[1] < 1e9
    finally:
        tracemalloc.stop()


def test_a_law_that_cannot_carry_the_load_is_told():
    soft = LINEAR._replace(law=Saturating(2000.0, 0.01))  # carries 20 N m
    with pytest.raises(ValueError, match=r"the load torque is 60 N\*m at 90 deg, too large for the gear"):
        sw.move(soft, sw.Trapezoid(QUARTER, TIME), start=QUARTER, method=ROUGH)


@pytest.mark.slow
def test_ten_thousand_points_are_followed_as_the_function_they_are_from():
    t = np.linspace(0.0, 2.0, 10_001)
    angle = 0.2 * (1.0 - np.cos(np.pi * t))
    move = sw.move(TRAIN, sw.AngleProfile(tuple(t), tuple(angle)), tail=0.1)

    def by_hand(time, y):
        motor, fast, load, slow = y.tolist()
        e, slope = 5e-5 * math.cos(2.0 * motor), -1e-4 * math.sin(2.0 * motor)
        passed = torque(motor / N - load - e) + B * (fast / N - slow - slope * fast)
        off = motor - N * 0.2 * (1.0 - math.cos(math.pi * time))
        drive = -LOOP.K_p * off - LOOP.K_d * (fast - N * 0.2 * math.pi * math.sin(math.pi * time))
        return fast, (drive - (1.0 / N - slope) * passed) / J_M, slow, (passed - PULL * math.sin(load)) / J_L

    load = -float(move.pointing_error[0])
    motor = -PULL * math.sin(load) / N / LOOP.K_p
    times = move.time[move.time <= 2.0][::50]
    found = solve_ivp(by_hand, (0.0, 2.0), (motor, 0.0, load, 0.0), "DOP853", times, rtol=1e-10, atol=1e-14)
    theirs = 0.2 * (1.0 - np.cos(np.pi * times)) - found.y[2]
    mine = move.pointing_error[move.time <= 2.0][::50]
    np.testing.assert_allclose(mine, theirs, rtol=0.0, atol=1e-6 * move.peak_error)


def test_in_a_gap_the_load_rests_where_it_came_to_stand():
    # every place in the gap is a rest: the error at rest was said to be 0 and the load to settle never or too late
    train = TRAIN._replace(law=sw.Play(60 * ARCSEC, GEAR.law), load=sw.train.Load(J_L), error=sw.NoError())
    found = sw.move(train, sw.Trapezoid(0.5, 0.4), window=20 * ARCSEC, tail=2.0, method=ROUGH)
    end = found.pointing_error[-1]
    assert np.ptp(found.pointing_error[found.time > found.time[-1] - 0.05]) < 1e-5 * ARCSEC
    assert found.rest_error == pytest.approx(end, abs=1e-5 * ARCSEC)
    assert abs(end) > 5.0 * ARCSEC
    after = found.pointing_error[found.time > 0.4 + found.settling_time]
    assert np.max(np.abs(after - end)) <= 20.0 * ARCSEC * (1.0 + 1e-6)


def test_a_load_that_pulls_through_the_gap_rests_at_the_equilibrium():
    train = TRAIN._replace(law=sw.Play(60 * ARCSEC, GEAR.law), load=sw.train.Load(J_L, sw.Harmonic(0.0, mean=-20.0)))
    found = sw.move(train, sw.Trapezoid(0.5, 0.4), window=20 * ARCSEC, tail=0.5, method=ROUGH)
    assert found.rest_error == pytest.approx(found.pointing_error[-1], rel=1e-4)


@pytest.mark.parametrize("speed", [-3.0, 0.02, 0.7])
def test_the_drag_that_is_fed_forward_of_bristles_is_that_at_a_steady_speed(speed):
    law = sw.laws.LuGre(sigma_0=50.0, sigma_1=10.0, sigma_2=1.0, T_c=0.3, T_s=0.5, v_s=0.05)
    bent = brentq(lambda z: law.z_rate(0.0, speed, (z,))[0], -1.0, 1.0, xtol=1e-15)
    assert torque_of(settled(law), 0.0, speed, ()) == pytest.approx(law.torque(0.0, speed, (bent,)), rel=1e-5)
