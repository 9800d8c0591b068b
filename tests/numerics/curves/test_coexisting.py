"""Ranges that begin or end inside a bistable band: the curve passes every motion at their ends, or tells of it."""

import numpy as np
import pytest

import strainwave as sw

HARDENING = sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, 0.1), sw.Harmonic(0.18), 1.0)  # NLvib example 01
SOFTENING = HARDENING._replace(law=sw.Cubic(1.0, -0.05), excitation=sw.Harmonic(0.1))
FOLDS = (1.115700, 1.269602)  # T1, to the digits printed there


def amplitudes_at(branch, omega):
    """Amplitudes of all orbits of a curve at one of its end frequencies."""
    return sorted(branch.amplitude(1)[branch.omega == omega])


def one_harmonic_amplitudes(system, omega):
    """The three of the cubic equation of harmonic balance with one harmonic (Nayfeh & Mook 1979, eq. 4.1.20)."""
    k, a3, F = system.law.K, 0.75 * system.law.K * system.law.alpha, system.excitation.amplitude
    detuning, loss = k - omega**2, system.B * omega
    squares = np.roots([a3**2, 2.0 * a3 * detuning, detuning**2 + loss**2, -(F**2)])
    return sorted(np.sqrt(r.real) for r in squares if abs(r.imag) < 1e-9 and r.real > 0.0)


@pytest.mark.parametrize("span", [(1.2, 2.0), (0.5, 1.2), (1.15, 1.25)])
@pytest.mark.parametrize("harmonics", [3, 4])
def test_a_range_that_begins_or_ends_in_the_band_shows_all_three_motions(span, harmonics):
    curve = sw.frequency_response(HARDENING, span, harmonics=harmonics, points=60)
    assert curve.message == "reached both ends"
    for end in span:
        expected = one_harmonic_amplitudes(HARDENING, end)
        assert len(expected) == (3 if FOLDS[0] < end < FOLDS[1] else 1)
        np.testing.assert_allclose(amplitudes_at(curve, end), expected, rtol=0.03)  # of the third harmonic
    assert sorted(f.omega for f in curve.folds) == pytest.approx(FOLDS, abs=0.01)


def test_a_softening_band_at_the_upper_end_is_shown_too():
    curve = sw.frequency_response(SOFTENING, (0.5, 0.92), harmonics=3, points=60)
    np.testing.assert_allclose(amplitudes_at(curve, 0.92), one_harmonic_amplitudes(SOFTENING, 0.92), rtol=0.03)


def test_the_run_up_from_inside_the_band_drops_at_its_fold():
    curve = sw.frequency_response(HARDENING, (1.2, 2.0), harmonics=7, points=60)
    told = sw.jumps(curve)
    assert told.jump_down == pytest.approx(FOLDS[1], abs=0.5e-6)
    assert "outside the range" in str(told)


def test_a_range_without_coexisting_motions_is_not_left():
    curve = sw.frequency_response(HARDENING, (0.8, 1.1), harmonics=3, points=60)
    assert curve.omega.min() == 0.8
    assert curve.omega.max() == 1.1
