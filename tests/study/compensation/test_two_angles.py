"""A table on the angles of motor and output against lines that beat, in a closed loop written out here with SciPy.

Gear 16:1 with lines (2, 0) and (2, -2), a sampled PD loop with a period of delay. The table is that of the library;
what reads it here knows the angles of both shafts within a turn each, and the pairs.
"""

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.app.commands.compensation.order_tables import written_tables
from strainwave.files.reading import from_text
from strainwave.study.compensation.bench import steady_bench_of
from strainwave.study.compensation.gains import times_of, turns_of

ARCSEC, TURN = math.pi / 648_000.0, 2.0 * math.pi
N, J_M, J_L, B, K, SPEED = 16.0, 1e-3, 0.3, 25.0, 9e3, 80.0
K_P, K_D, FILTER, PERIOD = 8.0, 0.12, 6e-4, 1.5e-3
ERROR = sw.KinematicError((sw.Line(2, 20.0 * ARCSEC, 0.3), sw.Line(2 - 2 / N, 17.0 * ARCSEC, -1.0)))
TRAIN = sw.Drive(J_m=J_M, J_l=J_L, N=N, B=B, law=sw.Linear(K)).train(
    kinematic_error=ERROR, control=sw.train.from_bandwidth(90.0, J_M, 0.7), omega=SPEED
)
SAMPLING = sw.controllers.Sampling(PERIOD, PERIOD)
LOOP = sw.controllers.SampledPD(K_P, K_D, PERIOD, FILTER)
TABLE = sw.OrderTable.of(ERROR, ratio=N)
ON_MOTOR = sw.KinematicError(ERROR.lines[:1])


def rates(_, y, torque):
    """Motors and loads of three loops, by their torques."""
    angle, speed, load, load_speed = y.reshape(4, 3)
    slope = sum(-A * k * np.sin(k * angle + phase) for k, A, phase in ERROR.lines)
    error = sum(A * np.cos(k * angle + phase) for k, A, phase in ERROR.lines)
    transmitted = K * (angle / N - load - error) + B * (speed / N - load_speed - slope * speed)
    motor = (torque - (1.0 / N - slope) * transmitted) / J_M
    return np.concatenate([speed, motor, load_speed, transmitted / J_L])


def corrections(time):
    """Angle of the motor and torque that are added at a time: none, by both angles, by the motor's angle alone."""
    lines = [(j, k, line) for (j, k), line in zip(TABLE.pairs, TABLE.lines, strict=True)]
    told = []
    for chosen in ((), lines, [one for one in lines if one[1] == 0]):
        angle = torque = 0.0
        for j, k, line in chosen:
            rate = (j + k / N) * SPEED
            for later, size in ((0.0, 1.0), (1.5 * PERIOD, -J_M * rate**2)):
                motor, output = math.fmod(SPEED * (time + later), TURN), math.fmod(SPEED * (time + later) / N, TURN)
                value = size * N * line.amplitude * math.cos(j * motor + k * output + line.phase)
                angle, torque = (angle + value, torque) if not later else (angle, torque + value)
        told.append((angle, torque))
    return np.array(told).T


def pointing_errors(settle, end):
    """Pointing error (3, n) of the three loops at the samples from a time on."""
    y = np.concatenate([np.zeros(3), np.full(3, SPEED), np.zeros(3), np.full(3, SPEED / N)])
    rate, last, acting, found = np.zeros(3), None, np.zeros(3), []
    for i in range(round(end / PERIOD)):
        t = i * PERIOD
        if t >= settle:
            found.append(SPEED * t / N - y[6:9])
        aim, ahead = corrections(t)
        deviation = y[:3] - SPEED * t - aim
        if last is not None:
            rate += ((deviation - last) / PERIOD - rate) * PERIOD / (PERIOD + FILTER)
        last = deviation
        y = solve_ivp(rates, (0.0, PERIOD), y, "DOP853", args=(acting,), rtol=1e-7, atol=1e-11).y[:, -1]
        acting = ahead - K_P * deviation - K_D * rate
    return np.array(found).T


def test_scipy_finds_what_tables_on_one_and_two_angles_leave():
    plain = sw.controllers.AngleFeedforward(LOOP, ON_MOTOR, N, SAMPLING.lead, J_M)
    both, single = [
        sw.compensate(TRAIN, one, speed=SPEED, sampling=SAMPLING, loop=LOOP, robust=False) for one in ("inverse", plain)
    ]
    bench = steady_bench_of(TRAIN, SAMPLING, LOOP)
    settle, end = times_of(bench, SPEED)
    errors = pointing_errors(settle, settle + 0.5 * (end - settle))  # a beat is half of what is measured
    angle = SPEED * PERIOD * np.arange(round(settle / PERIOD), round(settle / PERIOD) + errors.shape[1])
    columns = [np.ones_like(angle), *(f(order * angle) for order in bench.orders for f in (np.cos, np.sin))]
    fitted = np.linalg.lstsq(np.array(columns).T, errors.T, rcond=None)[0]
    amplitude = np.hypot(fitted[1::2], fitted[2::2])  # orders down; plain loop, both angles, motor's angle
    assert both.orders.tolist() == pytest.approx([2 - 2 / N, 2.0], abs=1e-12)
    assert amplitude[:, 0] == pytest.approx(both.amplitude_before, rel=2e-3)
    assert np.all(amplitude[:, 1] < 0.05 * amplitude[:, 0])
    assert np.all(both.amplitude_after < 0.05 * both.amplitude_before)
    assert amplitude[:, 2] == pytest.approx(single.amplitude_after, rel=0.02, abs=0.002 * amplitude[0, 0])
    removed = 1.0 - np.std(errors, axis=1) / np.std(errors[0])
    assert removed[1] > 0.95
    assert removed[2] < 0.6
    for found, share in ((both, removed[1]), (single, removed[2])):
        assert 1.0 - found.after.rms / found.before.rms == pytest.approx(share, rel=0.02)
        assert found.stable
    assert single.amplitude_after[0] == pytest.approx(single.amplitude_before[0], rel=0.02)  # the other clock's, whole


def test_a_run_is_measured_over_whole_beats():
    bench = steady_bench_of(TRAIN, SAMPLING, LOOP)
    assert bench.repeat == N / 2
    assert turns_of(bench) % N == 0
    slow = steady_bench_of(TRAIN._replace(error=sw.KinematicError((sw.Line(1 / N, 1e-4),))), SAMPLING, LOOP)
    assert slow.repeat == N
    assert turns_of(slow) == 4 * N


@pytest.mark.parametrize(("pull", "alone"), [(0.0, ""), (1.0, " (its kinematic error alone every 8)")])
def test_a_bench_tells_the_beat_of_all_that_drives_and_of_its_lines(pull, alone):
    drag = sw.train.AngleTorque(pull, 1)
    bench = steady_bench_of(TRAIN._replace(load=TRAIN.load._replace(drag=drag)), SAMPLING, LOOP)
    assert f"The error beats every {16 if pull else 8} turns of the motor{alone}." in bench.remarks


@pytest.mark.slow
def test_tables_of_controllers_count_on_the_output_and_leave_what_the_controllers_do():
    bench = steady_bench_of(TRAIN, SAMPLING, LOOP)
    for name, turns in (("inverse", ["angle"]), ("predicted-table", ["torque"]), ("adaptive", ["torque"])):
        found = sw.compensate(TRAIN, name, speed=SPEED, sampling=SAMPLING, loop=LOOP, robust=False)
        assert found.stable
        assert found.after.rms < 0.05 * found.before.rms
        tables = dict(written_tables(bench, found))
        assert list(tables) == turns
        for table, rms in tables.values():
            assert (table.turn, table.pairs) == ("output", ((2, -2), (2, 0)))
            if name != "inverse":  # whose torque of the inertia is no table
                assert rms == pytest.approx(found.after.rms, abs=0.01 * found.before.rms)


@pytest.mark.parametrize(
    ("ratio", "order", "said"),
    [
        (
            51 / 50,
            2 - 2 * 50 / 51,
            "depends on both turns; this needs a whole ratio of at least 2",
        ),
        (16.5, 2 - 2 / 16.5, "of at least 2, not 16.5; remove the order"),
        (
            16.0,
            2.01,
            "the order 2.01 is no whole number of repeats per turn of the wave generator and up to 8 of the output",
        ),
    ],
)
def test_clocks_that_no_turn_of_the_output_brings_together_are_refused(ratio, order, said):
    train = TRAIN._replace(N=ratio, error=sw.KinematicError((sw.Line(2, 1e-4), sw.Line(order, 1e-4))))
    with pytest.raises(ValueError, match=said):
        sw.compensate(train, "inverse", speed=SPEED, sampling=SAMPLING, loop=LOOP, robust=False)


def test_what_knows_the_turn_of_the_motor_alone_says_so():
    with pytest.raises(ValueError, match=r"order 2 - 2/16 belongs to the output's turn; use 'adaptive'"):
        sw.compensate(TRAIN, "repetitive", speed=SPEED, sampling=SAMPLING, loop=LOOP, robust=False)
    axis = """
gear: {ratio: 50, law: {type: cubic, K: 1e5 N*m/rad, alpha: 2e4 1/rad^2}}
motor: {inertia: 14.5 kg*cm^2}
load: {inertia: 10 kg*m^2}
damping: {ratio: 2 %}
speed: {from: 382 rpm, to: 573 rpm, shaft: motor}
excitation: {kinematic_error: [{order: {wave_generator: 2, output: -2}, amplitude: 23 arcsec}]}
"""
    with pytest.raises(
        ValueError, match=r"order 2 - 2/50 is a line of the output's turn, and a prediction over the speed"
    ):
        sw.prediction_table(from_text(axis, Path("axis.yaml")))
