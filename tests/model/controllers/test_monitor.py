"""Monitors on signals whose amplitude, phase and frequency are known."""

import math

import numpy as np
import pytest

import strainwave as sw
from strainwave.base.quantities import checked

PERIOD, RATE = 2.5e-4, 3.0
CHAIN = sw.controllers.Demodulator(
    sw.controllers.Demodulator(sw.controllers.Average(RATE, PERIOD), RATE, PERIOD, order=4), RATE, PERIOD, order=2
)


def followed(chain, angle, signal):
    """Cosine and sine amplitudes (2, n) of the outermost order."""
    state, found = chain.start(), []
    for a, y in zip(angle.tolist(), signal.tolist(), strict=True):
        state = chain.update(state, a, y)
        found.append(state[1:])
    return np.array(found).T


def test_orders_and_mean_are_found_without_leakage():
    t = PERIOD * np.arange(16000)
    angle = 60.0 * t
    signal = 0.7 + 2.0 * np.cos(2 * angle + 0.5) + 0.8 * np.cos(4 * angle - 1.0)
    found = followed(CHAIN, angle, signal)
    assert found[:, -1] == pytest.approx([2.0 * math.cos(0.5), -2.0 * math.sin(0.5)], rel=1e-4)


def test_an_estimate_settles_with_its_rate():
    t = PERIOD * np.arange(4000)
    found = followed(
        sw.controllers.Demodulator(sw.controllers.Average(1e-9, PERIOD), RATE, PERIOD), 200.0 * t, np.cos(400.0 * t)
    )
    off = 1.0 - found[0]
    assert np.log(off[1000] / off[3000]) / 0.5 == pytest.approx(RATE, rel=0.02)
    assert CHAIN.settling(0.01) == pytest.approx(math.log(100.0) / RATE)


def test_noise_comes_through_with_its_gain():
    rng, t = np.random.default_rng(3), PERIOD * np.arange(200000)
    single = sw.controllers.Demodulator(sw.controllers.Average(RATE, PERIOD), RATE, PERIOD)
    found = followed(single, 60.0 * t, 0.5 * rng.standard_normal(len(t)))
    assert np.var(found[:, 20000:]) == pytest.approx(single.noise_gain() * 0.25, rel=0.15)


def test_an_amplitude_that_grows_lags_by_its_rate_over_the_bandwidth():
    t = PERIOD * np.arange(20000)
    angle = 60.0 * t + 4.0 * t * t  # a run-up
    found = followed(
        sw.controllers.Demodulator(sw.controllers.Average(RATE, PERIOD), RATE, PERIOD),
        angle,
        0.4 * t * np.cos(2 * angle),
    )
    assert 0.4 * t[-1] - found[0, -1] == pytest.approx(0.4 / RATE, rel=0.03)


def test_lost_samples_leave_the_estimate_as_it_is():
    t = PERIOD * np.arange(8000)
    signal = np.cos(120.0 * t)
    signal[4000:4400] = np.nan
    found = followed(CHAIN, 60.0 * t, signal)
    assert np.all(found[:, 4000:4400] == found[:, 3999:4000])
    assert np.all(np.isfinite(found))


@pytest.mark.parametrize("omega", [70.0, 100.0, 140.0])
def test_the_tracker_finds_frequency_amplitude_and_phase(omega):
    tracker = sw.controllers.Tracker(50.0, 160.0, 5.0, PERIOD)
    state = tracker.start()
    for k in range(16000):
        state = tracker.update(state, 0.7 + 2.0 * math.cos(omega * k * PERIOD + 0.3))
    assert state[3] == pytest.approx(omega, rel=1e-4)
    assert tracker.amplitude(state) == pytest.approx(2.0, rel=1e-3)
    off = math.atan2(state[1], state[0]) - (omega * 15999 * PERIOD + 0.3)
    assert math.remainder(off, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-3)
    assert state[2] == pytest.approx(0.7, rel=1e-3)


def test_the_tracker_follows_a_frequency_with_its_rate():
    """After a small step of the frequency its distance decays as the slower root of s^2 + (g w/2) (s + r)."""
    tracker, phase, off = sw.controllers.Tracker(50.0, 160.0, 0.8, PERIOD), 0.0, []
    state = tracker.start()
    for k in range(22000):
        omega = 105.0 if k < 16000 else 107.0
        phase += omega * PERIOD
        state = tracker.update(state, math.cos(phase))
        off.append(107.0 - state[3])
    half = 0.3 * 106.0 / 4.0
    expected = half - math.sqrt(half * half - 2.0 * half * 0.8)
    assert math.log(off[17600] / off[20600]) / (3000 * PERIOD) == pytest.approx(expected, rel=0.05)


def tracked(tracker, signal):
    """Numbers (4, n) of a tracker over a signal."""
    state, found = tracker.start(), []
    for y in signal.tolist():
        state = tracker.update(state, y)
        found.append(state)
    return np.array(found).T


@pytest.mark.parametrize("rate", [0.8, 2.0, 20.0])
def test_a_tracker_has_settled_when_it_says_so(rate):
    """After a small step of the frequency: nothing above 1 % is left, and at half of that time more than that is."""
    tracker = sw.controllers.Tracker(60.0, 160.0, rate, PERIOD)
    begin, time = 24000, tracker.settling(0.01, 106.0)
    after = int(time / PERIOD)
    phase = PERIOD * np.cumsum(np.where(np.arange(begin + 2 * after) < begin, 105.0, 107.0))
    off = np.abs(107.0 - tracked(tracker, np.cos(phase))[3])
    assert np.max(off[begin + int(1.2 * after) :]) < 0.01 * 2.0
    assert np.max(off[begin + after // 2 :]) > 0.01 * 2.0
    assert tracker.settling(0.01) >= time
    assert tracker.settling(0.01) == max(tracker.settling(0.01, w) for w in np.linspace(60.0, 160.0, 9).tolist())


@pytest.mark.parametrize(("acceleration", "rate"), [(4.0, 2.0), (10.0, 4.0), (-6.0, 3.0)])
def test_in_a_run_up_a_tracker_lags_as_its_formula_says(acceleration, rate):
    """The frequency by a/r, the phase by 2 a/(r g w)."""
    tracker, gain = sw.controllers.Tracker(40.0, 200.0, rate, PERIOD), 0.3
    t = PERIOD * np.arange(24000)
    begin = 120.0 - 0.5 * acceleration * t[-1]
    omega, phase = begin + acceleration * t, (begin + 0.5 * acceleration * t) * t
    v, q, _, w = tracked(tracker, 1.5 * np.cos(phase))[:, -4000:]
    omega, phase = omega[-4000:], phase[-4000:]
    late = np.remainder(phase - np.arctan2(q, v) + math.pi, 2.0 * math.pi) - math.pi
    assert np.mean(omega - w) == pytest.approx(acceleration / rate, rel=0.02)
    assert np.mean(late * omega) == pytest.approx(2.0 * acceleration / (rate * gain), rel=0.03)


@pytest.mark.slow
def test_noise_comes_through_a_tracker_with_its_gain():
    rng, t, omega, rate = np.random.default_rng(5), PERIOD * np.arange(240000), 120.0, 2.0
    tracker = sw.controllers.Tracker(60.0, 160.0, rate, PERIOD)
    v, q, _, w = tracked(tracker, 2.0 * np.cos(omega * t) + 0.5 * rng.standard_normal(len(t)))[:, 20000:]
    assert np.var(np.hypot(v, q)) == pytest.approx(0.25 * tracker.noise_gain(omega), rel=0.15)
    assert np.var(w) == pytest.approx((rate * 0.5 / 2.0) ** 2 * tracker.noise_gain(omega), rel=0.15)


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: CHAIN._replace(bandwidth=2000.0), "together below the rate of samples, 4000 1/s"),
        (lambda: CHAIN._replace(bandwidth=0.0), "Demodulator.bandwidth is 0 1/s"),
        (lambda: CHAIN._replace(order=0), "Demodulator.order is 0"),
        (lambda: sw.controllers.Tracker(50.0, 40.0, 5.0, PERIOD), "0 < low < high is required"),
        (lambda: sw.controllers.Tracker(50.0, 5000.0, 5.0, PERIOD), "follow up to 4000 rad/s"),
        (
            lambda: sw.controllers.SpeedTable(sw.controllers.SampledPD(1.0, 0.1, PERIOD), (1.0,), (1.0,), (1.0,)),
            "SpeedTable has 1 speeds",
        ),
        (
            lambda: sw.controllers.SpeedTable(
                sw.controllers.SampledPD(1.0, 0.1, PERIOD), (2.0, 1.0), (1.0, 0.0), (0.0, 1.0)
            ),
            "must increase",
        ),
    ],
)
def test_numbers_out_of_range_get_a_sentence(make, sentence):
    with pytest.raises(ValueError, match=sentence):
        checked(make())
