"""Sampled loops against SciPy on equations written by hand, and against exact discretisation."""

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pytest
from one_bench import DRIVE, ERROR, GEAR, J_L, J_M, LOOP, PD, PERIOD, SAMPLING, B, N, loop
from scipy import signal
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq

import strainwave as sw
from strainwave.base.units import ARCSEC
from strainwave.maths import sqrt
from strainwave.numerics.ensemble.loops import fastest
from strainwave.study.compensation.bench import bench_of

SMOOTH = sw.Cubic(1e5, 5e3)
IDEAL = sw.controllers.Sampling(PERIOD, PERIOD)


class Broken(NamedTuple):
    """A controller whose torque is NaN."""

    size: float

    def start(self):
        return (0.0,)

    def update(self, state, m):
        return state, sqrt(-self.size + 0.0 * m.motor)


def by_hand(law, speed, sampling, samples, limit=1e9):
    """Motor, gear and load as two absolute angles, a PD loop at the samples, its torque held and late: DOP853.

    It shares nothing with the library but the numbers: angles are absolute, the delay is a list of torques in time.
    """
    torque = {"Cubic": lambda u: 1e5 * (u + 5e3 * u**3), "Linear": lambda u: 1e5 * u}[law]
    amplitude, order = ERROR.lines[0].amplitude, ERROR.lines[0].order

    def rates(_, y, given):
        motor, fast, load, slow = y
        u = motor / N - load - amplitude * math.cos(order * motor)
        slope = -amplitude * order * math.sin(order * motor)
        T = torque(u) + B * (fast / N - slow - slope * fast)
        return fast, (given - (1.0 / N - slope) * T) / J_M, slow, T / J_L

    y, last, given, found = np.array([0.0, speed, 0.0, speed / N]), None, [(-1.0, 0.0)], []
    for k in range(samples):
        t = k * sampling.period
        found.append(speed * t / N - y[2])
        deviation = y[0] - speed * t
        if sampling.motor_quantum:
            deviation = round(y[0] / sampling.motor_quantum) * sampling.motor_quantum - speed * t
        rate = 0.0 if last is None else (deviation - last) / sampling.period
        last = deviation
        asked = -LOOP.K_p * deviation - LOOP.K_d * rate
        given.append((t + sampling.delay, max(-limit, min(limit, asked))))
        ends = sorted({t, t + sampling.period, *(at for at, _ in given if t < at < t + sampling.period)})
        for low, high in pairwise(ends):
            now = [value for at, value in given if at <= low + 1e-12][-1]
            y = solve_ivp(rates, (low, high), y, "DOP853", rtol=1e-11, atol=1e-14, args=(now,)).y[:, -1]
    return np.array(found)


@pytest.mark.parametrize("delay", [0.0, PERIOD, 0.4 * PERIOD, 2.3 * PERIOD])
def test_a_loop_is_that_of_scipy_by_hand(delay):
    """From the motor on its reference and the load at its speed: the first 40 ms."""
    sampling = sw.controllers.Sampling(PERIOD, delay)
    own = loop(speed=50.0, sampling=sampling, law=SMOOTH)
    found = sw.numerics.run_loop(own, 0.04, steps=4)
    expected = by_hand("Cubic", 50.0, sampling, 160)
    assert np.max(np.abs(expected)) > 5.0 * ARCSEC
    np.testing.assert_allclose(found.error, expected, atol=1e-8 * np.max(np.abs(expected)))


def test_encoder_and_limit_are_those_by_hand():
    sampling = sw.controllers.Sampling(PERIOD, PERIOD, 0.3, 2.0 * math.pi / 2**14)
    own = loop(speed=50.0, sampling=sampling, law=SMOOTH)
    found = sw.numerics.run_loop(own, 0.04, steps=4)
    assert np.max(np.abs(found.torque)) == 0.3
    expected = by_hand("Cubic", 50.0, sampling, 160, limit=0.3)
    np.testing.assert_allclose(found.error, expected, atol=1e-8 * np.max(np.abs(expected)))


CASCADE = sw.train.CascadeLoop(40.0, 0.5, 0.02)
LOW_PASS, NOTCH = sw.train.LowPassFilter(3000.0), sw.train.NotchFilter(900.0, 300.0)
FILTERED = sw.train.Filtered(sw.train.Filtered(CASCADE, LOW_PASS), NOTCH)


@pytest.mark.parametrize("control", [LOOP, CASCADE, sw.train.PositionIntegral(CASCADE, 0.2), FILTERED])
def test_a_loaded_drive_begins_in_the_balance_of_its_torques(control):
    load = sw.train.Load(J_L, sw.Harmonic(0.0, mean=-60.0))
    bench = bench_of(DRIVE._replace(motor=sw.train.Motor(J_M, control=control), load=load), IDEAL)
    closed = bench.closed(bench.loop, 50.0)
    closed = closed._replace(train=closed.train._replace(error=sw.NoError()))
    found = sw.numerics.run_loop(closed, 0.2, y0=bench.start(50.0))
    np.testing.assert_allclose(found.torque, 60.0 / N, rtol=1e-9)
    sag = 60.0 / N**2 / control.K_p if control is LOOP else 0.0
    np.testing.assert_allclose(found.error, brentq(lambda u: GEAR.law.torque(u) - 60.0, 0.0, 0.01) + sag, rtol=1e-6)
    many = sw.numerics.loop_ensemble(closed, {}, 0.2, settle=0.0, y0=bench.start(50.0))
    assert many.torque_peak == pytest.approx(60.0 / N, rel=1e-9)


def test_filters_of_a_loop_are_those_of_scipy_on_its_torque():
    motor = sw.train.Motor(J_M, control=FILTERED)
    filtered = bench_of(DRIVE._replace(motor=motor), IDEAL).loop
    plain = filtered.loop.loop
    states, given, found = [plain.start(), filtered.start()], [], []
    for k in range(400):
        m = sw.controllers.Measurement(0.0, 0.0, 0.0, 1e-3 * math.cos(0.3 * k) + 1e-6 * k * k, 0.0, 0.0, 0.0)
        states[0], torque = plain.update(states[0], m)
        states[1], behind = filtered.update(states[1], m)
        given.append(torque)
        found.append(behind)
    wanted = np.array(given)
    for w, above, below in (
        (3000.0, [3000.0**2], [1.0, 1.4 * 3000.0, 3000.0**2]),
        (900.0, [1.0, 30.0, 900.0**2], [1.0, 300.0, 900.0**2]),
    ):
        b, a = signal.bilinear(above, below, 0.5 * w / math.tan(0.5 * w * PERIOD))
        wanted = signal.lfilter(b, a, wanted, zi=signal.lfilter_zi(b, a) * wanted[0])[0]
    np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-9 * np.max(np.abs(wanted)))


@pytest.mark.slow
def test_lost_angles_are_bridged_and_counted():
    clean = sw.numerics.run_loop(loop(sampling=SAMPLING), 1.0)
    lossy = sw.numerics.run_loop(loop(sampling=SAMPLING._replace(loss=0.05)), 1.0)
    assert np.all(np.isfinite(lossy.error))
    assert lossy.memory.lost / 4000 == pytest.approx(0.05, abs=0.01)
    assert lossy.rms(0.5) == pytest.approx(clean.rms(0.5), rel=0.05)


def test_a_controller_that_gives_nan_gets_no_torque():
    run = sw.numerics.run_loop(loop(Broken(1.0)), 0.01)
    assert np.all(run.torque == 0.0)
    assert np.all(np.isfinite(run.error))


def exact_response(frequency):
    """Load's error of a torque added to a sampled PD loop with one period of delay: matrix exponentials, no steps."""
    K, period = 1e5, PERIOD
    A = np.zeros((4, 4))  # motor, fast, load, slow
    A[0, 1] = A[2, 3] = 1.0
    A[1] = np.array([-K / N**2, -B / N**2, K / N, B / N]) / J_M
    A[3] = np.array([K / N, B / N, -K, -B]) / J_L
    whole = np.zeros((5, 5))
    whole[:4, :4], whole[1, 4] = A, 1.0 / J_M
    step = expm(whole * period)
    Phi, gamma = step[:4, :4], step[:4, 4]
    # State: y, last deviation, torque of the last sample, which acts now
    M = np.zeros((6, 6))
    M[:4, :4], M[:4, 5] = Phi, gamma
    M[4, 0] = 1.0
    M[5, 0], M[5, 4] = -LOOP.K_p - LOOP.K_d / period, LOOP.K_d / period
    inputs = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
    z = np.exp(1j * frequency * period)
    return -np.linalg.solve(z * np.eye(6) - M, inputs)[2], np.linalg.eigvals(M)


def test_the_map_from_sample_to_sample_is_that_of_matrix_exponentials():
    own = loop(speed=50.0, sampling=IDEAL, law=sw.Linear(1e5))
    found = sw.numerics.loop_response(own, [20.0, 100.0, 190.0, 400.0])
    expected = [exact_response(frequency)[0] for frequency in found.omega]
    np.testing.assert_allclose(found.error_of_torque, expected, rtol=1e-5)
    poles = exact_response(1.0)[1]
    biggest = np.sort(np.abs(poles))[-3:]
    np.testing.assert_allclose(np.sort(np.abs(found.poles))[-3:], biggest, rtol=1e-6)
    assert found.stable
    assert found.slowest == pytest.approx(-PERIOD / math.log(biggest[-1]), rel=1e-4)


def test_an_unstable_loop_has_a_pole_outside():
    fast = loop(sw.controllers.SampledPD(60.0 * LOOP.K_p, 60.0 * LOOP.K_d, PERIOD), sampling=IDEAL)
    assert not sw.numerics.loop_response(fast, [10.0]).stable
    slow = loop(sampling=IDEAL)
    assert sw.numerics.loop_response(slow, [10.0]).stable


@pytest.mark.slow
def test_an_ensemble_has_what_single_loops_have():
    stiffness = np.array([0.9e5, 1e5, 1.2e5])
    own = loop(sampling=SAMPLING, law=sw.Cubic(1e5, 5e3))
    found = sw.numerics.loop_ensemble(own, {"train.law.K": stiffness}, 1.5, settle=0.5, orders=[2, 4])
    for lane, K in enumerate(stiffness.tolist()):
        one = sw.numerics.run_loop(loop(sampling=SAMPLING, law=sw.Cubic(K, 5e3)), 1.5, unit=lane)
        late = one.error[2000:]
        trend = np.polyval(np.polyfit(one.time[2000:] - 1.0, late, 1), one.time[2000:] - 1.0)
        assert found.rms[lane] == pytest.approx(np.std(late - trend), rel=1e-7)
        assert found.peak[lane] == pytest.approx(np.max(np.abs(late)), rel=1e-12)
        assert found.torque_peak[lane] == pytest.approx(np.max(np.abs(one.torque[2000:])), rel=1e-12)
        turns = 50.0 * one.time[2000:]
        amplitude = 2.0 * np.mean(late * np.exp(-2j * turns))
        assert found.amplitude[0, lane] == pytest.approx(abs(amplitude), rel=1e-9)
        assert found.phase[0, lane] == pytest.approx(np.angle(amplitude), abs=1e-9)
    assert found.stable.all()


@pytest.mark.slow
def test_an_ensemble_is_the_same_in_any_place_and_thread():
    own, values = loop(sampling=SAMPLING._replace(motor_noise=1e-4)), np.linspace(20.0, 70.0, 70)
    one = sw.numerics.loop_ensemble(own, {"train.omega": values}, 0.2, settle=0.1, threads=1)
    two = sw.numerics.loop_ensemble(own, {"train.omega": values}, 0.2, settle=0.1, threads=3)
    np.testing.assert_array_equal(one.rms, two.rms)
    assert np.std(one.rms) > 0.0


@pytest.mark.slow
def test_a_loop_that_grows_is_called_unstable():
    fast = sw.controllers.SampledPD(60.0 * LOOP.K_p, 60.0 * LOOP.K_d, PERIOD)
    found = sw.numerics.loop_ensemble(loop(fast, sampling=IDEAL), {}, 0.5, settle=0.1)
    assert not found.stable[0]


def test_steps_between_samples_follow_the_fastest_motion():
    own = loop(sampling=IDEAL)
    rate = math.sqrt(GEAR.K1 * (1.0 / J_L + 1.0 / (N * N * J_M)))
    assert fastest(own.train, np.zeros(5)) == pytest.approx(rate, rel=0.02)  # its damping changes it by 1 %
    slow = sw.controllers.ClosedLoop(own.train, PD._replace(period=1e-2), sw.controllers.Sampling(1e-2, 1e-2))
    assert sw.numerics.run_loop(slow, 0.1).steps == math.ceil(rate * 1e-2 / 0.15)


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: sw.numerics.run_loop(loop(), -1.0), r"duration \[s\] is -1"),
        (
            lambda: sw.numerics.run_loop(loop(), 1.0, y0=[0.0]),
            r"y0 has 1 numbers; the plant has 5 states: x, x', motor",
        ),
        (lambda: sw.numerics.run_loop(loop(), 1.0, every=0), r"every"),
        (
            lambda: sw.numerics.run_loop(
                loop(PD._replace(period=10.0), sampling=sw.controllers.Sampling(10.0, 0.0)), 20.0
            ),
            r"too slow for the plant",
        ),
        (lambda: sw.numerics.loop_ensemble(loop(), {}, 1.0, settle=1.0), r"settle is 1 s; it must be from 0 to below"),
        (lambda: sw.numerics.loop_ensemble(loop(), {"train.J": [1.0]}, 1.0, settle=0.5), r"train.J"),
        (
            lambda: sw.numerics.loop_ensemble(loop(), {"train.omega": [1.0], "train.B": [1.0, 2.0]}, 1.0, settle=0.5),
            r"1 \(train.omega\), 2 \(train.B\) numbers",
        ),
        (lambda: sw.numerics.loop_response(loop(), [2e4]), r"carry none above"),
        (
            lambda: sw.numerics.run_loop(sw.controllers.ClosedLoop(sw.HDC_40_050.train(), PD, SAMPLING), 1.0),
            r"motor without commanded torque",
        ),
    ],
)
def test_what_cannot_be_run_gets_a_sentence(call, sentence):
    with pytest.raises(ValueError, match=sentence):
        call()
