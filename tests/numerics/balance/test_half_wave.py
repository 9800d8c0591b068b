"""Odd systems have the same orbits by odd harmonics alone; systems that are not odd keep all harmonics."""

import numpy as np
import pytest

import strainwave as sw
from strainwave.base.series import largest_size
from strainwave.compile.tree import leaf_of
from strainwave.numerics.balance.first_order import linearised
from strainwave.numerics.balance.fourier import all_orders
from strainwave.numerics.balance.harmonics import is_odd_on
from strainwave.numerics.balance.second_order import second_order
from strainwave.numerics.continuation.trace import series_of, solve
from strainwave.numerics.stability.second_order import grid_of, hill

pytestmark = pytest.mark.slow

DUFFING = sw.Oscillator(1.0, 0.1, sw.Cubic(1.0, 0.05), sw.Harmonic(1.0), 0.8)
LINES = sw.KinematicError((sw.Line(1, 0.02, 0.3), sw.Line(3, 0.01, 1.0)))


def full(system, harmonics=9):
    leaf = leaf_of(system, "omega")
    return second_order(system, leaf, leaf, harmonics)


@pytest.mark.parametrize("system", [DUFFING, DUFFING._replace(error=LINES)])
def test_odd_orbits_their_multipliers_and_peaks_are_those_of_the_full_balance(system):
    whole = full(system)
    odd = whole.odd()
    point, few = (solve(problem, problem.linear_response(0.8)) for problem in (whole, odd))
    np.testing.assert_allclose(all_orders(few[None, :-1], 2)[0], point[:-1], rtol=1e-9, atol=1e-12)
    traces, odd_traces = hill(whole, point[None], grid_of(whole, 1024)), hill(odd, few[None], grid_of(odd, 1024))
    np.testing.assert_allclose(odd_traces, traces, rtol=1e-9)
    peaks, odd_peaks = largest_size(series_of(whole, point[None])), largest_size(series_of(odd, few[None]))
    np.testing.assert_allclose(odd_peaks, peaks, rtol=1e-9)


def test_peaks_are_the_larger_of_two_extremes_that_are_nearly_equal():
    small = sw.KinematicError((sw.Line(2, 1e-4, 0.3),))
    curve = sw.frequency_response(DUFFING._replace(error=small), (0.5, 1.4))
    turns = np.arange(1, curve.coefficients.shape[1] // 2 + 1)[:, None] * np.linspace(0.0, 2.0 * np.pi, 20_001)
    waves = np.stack([np.cos(turns), np.sin(turns)], axis=1).reshape(2 * len(turns), -1)
    samples = curve.coefficients[:, :1] + curve.coefficients[:, 1:] @ waves
    np.testing.assert_allclose(curve.peak, np.max(np.abs(samples), axis=1), rtol=1e-7)


def test_the_odd_jacobian_is_the_derivative_of_the_odd_residual():
    odd = full(DUFFING).odd()
    n = len(odd.tau)
    z = np.append(np.random.default_rng(2).normal(size=n), 1.1)
    z[0] = 0.0
    _, jacobian, column = linearised(odd, z)
    for j in range(1, n + 1):
        sides = []
        for step in (-1e-6, 1e-6):
            moved = z.copy()
            moved[j] += step
            sides.append(linearised(odd, moved)[0])
        slope = (sides[1] - sides[0]) / 2e-6
        np.testing.assert_allclose(column if j == n else jacobian[:, j], slope, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize(
    "system",
    [
        DUFFING._replace(excitation=sw.Harmonic(1.0, mean=0.2)),
        DUFFING._replace(excitation=sw.Harmonic(1.0, order=2)),
        DUFFING._replace(error=sw.KinematicError((sw.Line(2, 0.01),))),
        DUFFING._replace(law=sw.Polynomial((0.0, 1.0, 1e-6, 0.05))),
        DUFFING._replace(law=sw.Backlash(1.0, 0.1)),
    ],
)
def test_systems_that_are_not_odd_or_not_smooth_keep_all_harmonics(system):
    assert full(system).odd() is None


def test_a_law_that_is_odd_only_where_the_orbits_are_not_is_found_out():
    odd = full(DUFFING).odd()
    point = solve(odd, odd.linear_response(0.8))[None]
    assert is_odd_on(odd, point)
    lopsided = odd._replace(system=DUFFING._replace(law=sw.Polynomial((0.0, 1.0, 1e-6, 0.05))))
    assert not is_odd_on(lopsided, point)


def test_a_symmetric_curve_tells_where_its_symmetry_breaks():
    """Ueda's oscillator x'' + 0.05 x' + x^3 = A cos t has symmetry-breaking branch points on its symmetric curve."""
    ueda = sw.Oscillator(1.0, 0.05, sw.Polynomial((0.0, 0.0, 0.0, 1.0)), sw.Harmonic(0.5), 1.0)
    curve = sw.frequency_response(ueda, (0.5, 1.5), harmonics=15)
    assert curve.status
    assert curve.branch_points
    whole = full(ueda, 15)
    for point in curve.branch_points:
        traces = hill(whole, np.append(_blocks(point.coefficients[:, 0]), point.omega)[None])
        decay = np.exp(-np.pi * 0.05 / point.omega)
        assert 1.0 - traces[0] * decay + decay**2 == pytest.approx(0.0, abs=1e-5)


def _blocks(series):
    return np.concatenate([series[:1], series[1::2], series[2::2]])
