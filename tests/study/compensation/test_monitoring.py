"""Records monitored: against least squares, through a resonance, and what is refused."""

import numpy as np
import pytest
from one_bench import PD, SAMPLING, loop

import strainwave as sw

T = 2.5e-4 * np.arange(12000)
SIGNAL = 0.3 + 2.0 * np.cos(2 * 60.0 * T + 0.5) + 0.8 * np.cos(4 * 60.0 * T)


def test_a_record_has_the_amplitudes_of_least_squares():
    rng = np.random.default_rng(2)
    y = SIGNAL + 0.2 * rng.standard_normal(len(T))
    found = sw.monitor(T, y, angle=60.0 * T, orders=(4, 2), bandwidth=4.0)
    basis = np.stack([np.ones_like(T), *(f(k * 60.0 * T) for k in (2, 4) for f in (np.cos, np.sin))], axis=1)
    fit = np.linalg.lstsq(basis, y, rcond=None)[0]
    expected = [np.hypot(*fit[1:3]), np.hypot(*fit[3:5])]
    assert found.orders.tolist() == [2.0, 4.0]
    assert np.max(np.abs(found.amplitude[:, -1] - expected)) < 5.0 * found.standard_error
    assert found.standard_error == pytest.approx(0.2 * np.sqrt(4.0 * 2.5e-4), rel=0.1)
    assert found.phase[0, -1] == pytest.approx(0.5, abs=5.0 * found.standard_error)
    assert found.frequency[100] == pytest.approx(120.0)
    assert found.settled_from == pytest.approx(np.log(100.0) / 4.0)


@pytest.mark.slow
def test_compiled_records_are_those_of_python(monkeypatch):
    y = SIGNAL.copy()
    y[500:520] = np.nan
    compiled = sw.monitor(T, y, angle=60.0 * T, orders=(2, 4))
    tracked = sw.monitor(T, y, frequencies=(80.0, 160.0))
    monkeypatch.setenv("STRAINWAVE_JIT", "0")
    plain, other = sw.monitor(T, y, angle=60.0 * T, orders=(2, 4)), sw.monitor(T, y, frequencies=(80.0, 160.0))
    np.testing.assert_allclose(compiled.amplitude, plain.amplitude, rtol=0, atol=1e-11)
    np.testing.assert_allclose(tracked.frequency, other.frequency, rtol=1e-9)
    assert compiled.lost == 20


def test_a_line_without_an_angle_is_tracked():
    found = sw.monitor(T, SIGNAL - 0.8 * np.cos(4 * 60.0 * T), frequencies=(80.0, 180.0), bandwidth=5.0)
    assert found.frequency[-1] == pytest.approx(120.0, rel=1e-4)
    assert found.amplitude[0, -1] == pytest.approx(2.0, rel=1e-3)


@pytest.mark.slow
def test_a_run_of_a_loop_is_monitored_in_one_line():
    run = sw.numerics.run_loop(loop(PD, 20.0, SAMPLING), 6.0)
    found = sw.monitor(run.time, run.error, angle=20.0 * run.time)
    steady = sw.numerics.loop_ensemble(
        loop(PD, 20.0, SAMPLING), {}, 3.0 + 10.0 * np.pi / 10.0, settle=3.0, orders=[2]
    )  # ten turns
    assert found.amplitude[0, -1] == pytest.approx(steady.amplitude[0, 0], rel=5e-3)
    assert found.phase[0, -1] == pytest.approx(steady.phase[0, 0], abs=5e-3)


def test_the_standard_error_of_a_tracked_line_is_that_of_many_records():
    rng, line = np.random.default_rng(6), 2.0 * np.cos(120.0 * T)
    ends = [
        sw.monitor(T, line + 0.5 * rng.standard_normal(len(T)), frequencies=(110.0, 130.0), bandwidth=2.0)
        for _ in range(12)
    ]
    sizes = np.concatenate([one.amplitude[0, 6000::400] for one in ends])
    assert ends[0].standard_error == pytest.approx(float(np.std(sizes)), rel=0.25)


def test_an_angle_may_be_given_within_one_turn():
    whole = sw.monitor(T, SIGNAL, angle=60.0 * T)
    wrapped = sw.monitor(T, SIGNAL, angle=np.mod(60.0 * T, 2.0 * np.pi))
    np.testing.assert_allclose(whole.amplitude, wrapped.amplitude, atol=1e-9)


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: sw.monitor(T, SIGNAL[1:], angle=T), "as many numbers of both"),
        (lambda: sw.monitor(T**2, SIGNAL, angle=T), "not even in time"),
        (lambda: sw.monitor(T, SIGNAL, angle=0.0 * T), "the angle is constant"),
        (lambda: sw.monitor(T, SIGNAL, angle=5000.0 * T, orders=(4,)), "too slow for order 4"),
        (lambda: sw.monitor(T, SIGNAL), "neither an angle nor a range"),
        (lambda: sw.monitor(T, SIGNAL, angle=T[1:]), "give a finite angle for each"),
        (lambda: sw.monitor(T, SIGNAL, angle=T, orders=(2, 2)), "give each order once"),
        (lambda: sw.monitor(T, SIGNAL, angle=T, orders=(0,)), "integers of at least 1"),
        (lambda: sw.monitor(T, SIGNAL * np.inf, angle=T), "infinite numbers"),
        (lambda: sw.monitor(T, SIGNAL * np.nan, angle=T), "signal contains only NaN"),
    ],
)
def test_what_cannot_be_monitored_gets_a_sentence(call, sentence):
    with pytest.raises(ValueError, match=sentence):
        call()
