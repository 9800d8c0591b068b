"""A closed loop written out here, plant and controller, and integrated by SciPy: the rms error at the load is the same.

Gear 100:1 with a hardening spring and Bouc-Wen hysteresis, gravity at 60 degrees, friction on the motor, an encoder of
14 bits on it, samples every 400 us and a delay of 220 us.
"""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.study.compensation.bench import steady_bench_of
from strainwave.study.compensation.gains import times_of

ARCSEC, TURN = math.pi / 648_000.0, 2.0 * math.pi
N, J_M, J_L, B, SPEED = 100.0, 6e-5, 0.5, 12.0, 80.0
K, ALPHA, K_Z, YIELD = 1.4e4, 4e4, 2e3, 1.2e-4
K_P, K_D, FILTER, PERIOD, DELAY, LIMIT, QUANTUM = 2.5, 0.03, 3e-4, 4e-4, 2.2e-4, 1.2, TURN / 2**14
GRAVITY, ANGLE = 9.0, math.radians(60.0)
LINES = ((2, 18.0 * ARCSEC, 0.3), (4, 5.0 * ARCSEC, -1.0))
TRAIN = sw.Drive(
    J_m=J_M, J_l=J_L, N=N, B=B, law=sw.Parallel(sw.Cubic(K, ALPHA), sw.BoucWen(K_Z, 0.0, YIELD, n=2))
).train(
    kinematic_error=sw.KinematicError(tuple(sw.Line(*line) for line in LINES)),
    control=sw.train.from_bandwidth(100.0, 1e-4, 0.7),
    load_drag=sw.train.AngleTorque(GRAVITY),
    motor_drag=sw.laws.Coulomb(0.02),
    omega=SPEED,
)  # fmt: skip
SAMPLING = sw.controllers.Sampling(PERIOD, DELAY, LIMIT, motor_quantum=QUANTUM)
LOOP = sw.controllers.SampledPD(K_P, K_D, PERIOD, FILTER)


def error(a, derivative):
    """Kinematic error over the motor's angle, or its first or second derivative."""
    return sum(A * k**derivative * math.cos(k * a + phase + 0.5 * math.pi * derivative) for k, A, phase in LINES)


def rates(_, y, torque):
    """Motor, load and hysteresis under a torque of the motor."""
    angle, speed, load, load_speed, z = y
    slope = error(angle, 1)
    u, du = angle / N - load - error(angle, 0), speed / N - load_speed - slope * speed
    transmitted = K * (u + ALPHA * u**3) + K_Z * z + B * du
    friction = math.copysign(0.02, speed)
    dz = du - (z / YIELD) ** 2 * 0.5 * (abs(du) * np.sign(z) + du)
    motor = (torque - friction - (1.0 / N - slope) * transmitted) / J_M
    return [speed, motor, load_speed, (transmitted - GRAVITY * math.sin(ANGLE)) / J_L, dz]


def pointing_errors(state, torque, settle, end, inverse):
    """Pointing error at the samples after a time; `inverse` is what follows N (reference + e) with its torque.

    `torque` is in force before the first sample's."""
    y, found = state, []
    last = rate = begun = 0.0
    for k in range(round(end / PERIOD)):
        t = k * PERIOD
        reference = SPEED * t
        if t >= settle:
            found.append(reference / N - y[2])
        aim, ahead = reference, 0.0
        if inverse:
            aim += N * error(reference, 0)
            ahead = J_M * N * error(reference + SPEED * (DELAY + 0.5 * PERIOD), 2) * SPEED**2
        deviation = QUANTUM * round(y[0] / QUANTUM) - aim
        rate += (begun * (deviation - last) / PERIOD - rate) * PERIOD / (PERIOD + FILTER)
        last, begun = deviation, 1.0
        new = min(max(ahead - K_P * deviation - K_D * rate, -LIMIT), LIMIT)
        for span, acting in ((DELAY, torque), (PERIOD - DELAY, new)):
            y = solve_ivp(rates, (0.0, span), y, "DOP853", args=(acting,), rtol=1e-9, atol=1e-13).y[:, -1]
        torque = new
    return np.array(found)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["loop", "inverse"])
def test_scipy_finds_the_same_rms_at_the_load(name):
    found = sw.compensate(
        TRAIN, name, speed=SPEED, sampling=SAMPLING, loop=LOOP, robust=False, load_angles=(ANGLE,)
    )  # fmt: skip
    bench = steady_bench_of(TRAIN, SAMPLING, LOOP, None, ANGLE)
    x, rate, motor, motor_rate, torque, z = bench.start(SPEED)
    state = [motor, SPEED + motor_rate, motor / N - x, (SPEED + motor_rate) / N - rate, z]
    errors = pointing_errors(state, torque, *times_of(bench, SPEED), name == "inverse")
    sample = np.arange(len(errors))
    trend = np.polyval(np.polyfit(sample, errors, 1), sample)
    assert found.after.rms == pytest.approx(np.std(errors - trend), rel=5e-4)
    assert found.after.mean == pytest.approx(np.mean(errors), rel=5e-4)
    assert found.after.peak == pytest.approx(np.max(np.abs(errors)), rel=2e-3)  # between samples it may be larger
