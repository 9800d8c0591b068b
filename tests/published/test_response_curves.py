"""Response curves with published or independently computed numbers, to their printed digits.

T1: Krack & Gross 2019, example 01 of their program NLvib. T2: tutorial of HarmonicBalance.jl. T4: example of the
program OSCILATE. T17: AUTO-07p with NTST 20, DSMAX 0.05 (benchmarks/auto). The one-harmonic values are the closed-
form describing function; the gear of T19 and the backlash of T20 were computed by the exact flow of the linear
segments and by DOP853 with located switches, which agree to 2e-10 and 7e-10.
"""

import numpy as np
import pytest

import strainwave as sw


def duffing(B, alpha, A):
    return sw.Oscillator(1.0, B, sw.Cubic(1.0, alpha), sw.Harmonic(A), 1.0)


def top(branch, k=1):
    i = int(np.argmax(branch.amplitude(k)))
    return branch.amplitude(k)[i], branch.omega[i]


def folds(branch):
    return sorted(f.omega for f in branch.folds)


def test_one_harmonic_of_nlvib_example_01_is_the_closed_form():
    curve = sw.frequency_response(duffing(0.05, 0.1, 0.18), (0.5, 1.6), harmonics=1)
    assert top(curve) == pytest.approx((2.8416246, 1.2666342), abs=5e-8)


@pytest.mark.parametrize("harmonics", [7, None])
def test_nlvib_example_01_converged(harmonics):
    curve = sw.frequency_response(duffing(0.05, 0.1, 0.18), (0.5, 1.6), harmonics=harmonics)
    assert curve.status
    assert top(curve) == pytest.approx((2.830198, 1.268717), abs=6e-7)
    assert curve.peak.max() == pytest.approx(2.877112, abs=6e-7)
    assert folds(curve) == pytest.approx([1.115700, 1.269602], abs=6e-7)
    by_omega = {round(f.omega, 3): f.amplitude(1) for f in curve.folds}
    assert by_omega[1.27] == pytest.approx(2.82502, abs=6e-6)
    assert by_omega[1.116] == pytest.approx(1.08187, abs=6e-6)


def test_harmonicbalance_jl_tutorial():
    one = sw.frequency_response(duffing(0.01, 1.0, 0.01), (0.9, 1.3), harmonics=1)
    assert folds(one) == pytest.approx([1.038591, 1.224768], abs=6e-7)
    assert top(one) == pytest.approx((0.816502, 1.224727), abs=6e-7)
    seven = sw.frequency_response(duffing(0.01, 1.0, 0.01), (0.9, 1.3), harmonics=7)
    assert folds(seven) == pytest.approx([1.038604, 1.226449], abs=6e-7)
    # Three branches between the folds, two of them stable (the tutorial's figure).
    crossings = np.flatnonzero(np.diff(np.sign(seven.omega - 1.1)) != 0)
    assert [bool(seven.stable[i]) for i in crossings] == [True, False, True]


def test_a_range_that_ends_between_the_folds_still_shows_the_whole_curve():
    curve = sw.frequency_response(duffing(0.01, 1.0, 0.01), (0.9, 1.2), harmonics=7)
    assert (curve.omega[0], curve.omega[-1]) == (0.9, 1.2)
    assert folds(curve) == pytest.approx([1.038604, 1.226449], abs=6e-7)


def test_oscilate_duffing_direct():
    curve = sw.frequency_response(duffing(0.01, 0.2, 0.01), (0.9, 1.3))
    assert top(curve) == pytest.approx((0.939280, 1.064400), abs=6e-7)
    assert folds(curve) == pytest.approx([1.022189, 1.064511], abs=6e-7)


@pytest.mark.parametrize(("A", "error", "shift"), [(0.002, 0.30, 0.00), (0.005, 1.80, 0.08), (0.01, 6.46, 1.00)])
def test_error_of_first_order_multiple_scales_at_the_peak(A, error, shift):
    system = duffing(0.01, 0.2, A)
    true, at = top(sw.frequency_response(system, (0.8, 1.5)))
    first_order = A / 0.01  # peak f/(mu omega_0), at sigma = 3/8 alpha a^2
    assert 100.0 * (first_order / true - 1.0) == pytest.approx(error, abs=0.006)
    assert 100.0 * ((1.0 + 0.375 * 0.2 * first_order**2) / at - 1.0) == pytest.approx(shift, abs=0.006)


def test_auto_07p_folds():
    curve = sw.frequency_response(duffing(0.1, 0.05, 1.0), (0.25, 3.0), harmonics=15)
    found = folds(curve)
    assert found[-1] == pytest.approx(1.5863944025, abs=2e-9)
    assert min(found, key=lambda w: abs(w - 1.27)) == pytest.approx(1.2704388305, abs=2e-9)


GEAR = sw.Oscillator(
    0.6030927835, 9.82317898446, sw.PiecewiseLinear(1e5, 1.4e5, 1.8e5, 54.0, 196.0), sw.Harmonic(0.0), 235.0,
    sw.KinematicError((sw.Line(2, 1.1e-4),)),
)  # fmt: skip


def torsion_peak(orbit):
    phase = np.linspace(0.0, 2.0 * np.pi, 2001)
    for _ in range(2):  # the second time between the neighbours of the largest sample
        size = np.abs(orbit.state(phase)[0] - GEAR.error.value(phase))
        at = phase[np.argmax(size)]
        phase = np.linspace(at - np.pi / 1000.0, at + np.pi / 1000.0, 2001)
    return np.max(np.abs(orbit.state(phase)[0] - GEAR.error.value(phase)))


@pytest.mark.slow
def test_gear_with_three_slopes():
    curve = sw.frequency_response(GEAR, (150.0, 300.0), harmonics=63)
    assert folds(curve) == pytest.approx([226.448419, 249.057291], abs=6e-7)
    at_235 = np.flatnonzero(np.diff(np.sign(curve.omega - 235.0)) != 0)
    peaks = []
    for i in at_235:
        series = np.column_stack([curve.coefficients[i], np.zeros(curve.coefficients.shape[1])])
        orbit = sw.find_orbit(GEAR, guess=series)
        peaks.append((torsion_peak(orbit), orbit.stable))
    values, stable = zip(*peaks, strict=True)
    assert values == pytest.approx([0.00236525454, 0.00174831231, 0.00043689558], abs=6e-12)
    assert stable == (True, False, True)


@pytest.mark.slow
def test_backlash_by_balance_and_shooting():
    system = sw.Oscillator(1.0, 0.1, sw.Backlash(1.0, 0.5), sw.Harmonic(0.6), 0.8)
    orbit = sw.find_orbit(system)
    assert orbit.peak == pytest.approx(3.297722874, abs=6e-10)
    assert orbit.amplitude(1) == pytest.approx(3.260846925, abs=6e-10)
    assert orbit.amplitude(3) == pytest.approx(0.042768294, abs=6e-10)
    assert orbit.multipliers[0] == pytest.approx(0.317168 + 0.596106j, abs=6e-7)
    assert abs(orbit.multipliers[0]) == pytest.approx(0.675231907, abs=6e-10)


@pytest.mark.parametrize(("harmonics", "bar"), [(5, 1e-4), (15, 1e-6), (63, 1e-8)])
def test_harmonics_that_a_backlash_needs(harmonics, bar):
    system = sw.Oscillator(1.0, 0.1, sw.Backlash(1.0, 0.5), sw.Harmonic(0.6), 0.8)
    orbit = sw.find_orbit(system, harmonics=harmonics, guess=np.array([0.0, -3.2, 0.5]))
    assert abs(orbit.amplitude(1) / 3.260846925 - 1.0) < bar


@pytest.mark.slow
def test_backlash_curve():
    system = sw.Oscillator(1.0, 0.1, sw.Backlash(1.0, 0.5), sw.Harmonic(0.6), 0.8)
    curve = sw.frequency_response(system, (0.3, 1.0), harmonics=63)
    assert curve.folds == []
    assert top(curve) == pytest.approx((6.333361852, 0.9458299), rel=1e-7)
