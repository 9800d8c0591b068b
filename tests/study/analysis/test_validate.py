"""Multiple scales against integration on the article's drive and on a small oscillator."""

from fractions import Fraction

import numpy as np
import pytest
from article_cases import OMEGA_0, derived

import strainwave as sw


@pytest.mark.slow
@pytest.mark.parametrize(
    ("omega", "resonance", "claimed", "limit"),
    [
        pytest.param(10.47, sw.NONRESONANT, 0.021, 0.0005, id="non-resonant"),
        pytest.param(OMEGA_0, sw.PRIMARY, 0.048, 0.02, id="primary"),
        pytest.param(OMEGA_0 / 3.0, sw.SUPERHARMONIC, 0.035, 0.001, id="superharmonic"),
        pytest.param(3.0 * OMEGA_0, sw.SUBHARMONIC, 0.042, 0.001, id="subharmonic"),
    ],
)
def test_rms_difference_is_below_what_the_article_claims(omega, resonance, claimed, limit):
    """Table 4 of the article, from rest, 0 to 5/mu: difference over solution."""
    compared = sw.study.compare_with_integration(derived(omega), resonance)
    assert compared.rms_difference <= limit < claimed
    assert compared.peak_theory == pytest.approx(compared.peak_integrated, rel=2e-3)


@pytest.mark.slow
def test_harmonics_at_the_end_are_those_of_the_settled_motion():
    """Errata table, superharmonic case of the derived set, about 30/mu: 2.8777e-3 at omega, 6.51e-7 at 3 omega."""
    compared = sw.study.compare_with_integration(
        derived(OMEGA_0 / 3.0), sw.SUPERHARMONIC, t_end=30.0 / sw.HDC_40_050.mu
    )
    for found in compared.harmonics[Fraction(1)]:
        assert found == pytest.approx(2.8777e-3, abs=5e-8)
    for found in compared.harmonics[Fraction(3)]:
        assert found == pytest.approx(6.51e-7, abs=5e-10)


SMALL = sw.Oscillator(1.0, 0.1, sw.Cubic(1.0, 0.1), sw.Harmonic(0.05), 1.0)


def test_comparison_reports_both_sides_over_one_window():
    compared = sw.study.compare_with_integration(SMALL, sw.PRIMARY, (0.2, 0.0), t_end=20.0)
    assert compared.window == (0.0, 20.0)
    assert np.array_equal(compared.theory.t, compared.integrated.t)
    direct = np.sqrt(
        np.mean((compared.theory.x - compared.integrated.y[0]) ** 2) / np.mean(compared.integrated.y[0] ** 2)
    )
    assert compared.rms_difference == pytest.approx(direct, rel=1e-12)
    assert 0.0 < compared.rms_difference < 0.1
    assert compared.peak_integrated >= np.max(np.abs(compared.integrated.y[0]))
    assert compared.harmonics == {}  # fewer than 12 periods in the last fifth


def test_window_needs_damping_or_an_end():
    with pytest.raises(ValueError, match="t_end"):
        sw.study.compare_with_integration(SMALL._replace(B=0.0), sw.PRIMARY)
    with pytest.raises(ValueError, match="positive"):
        sw.study.compare_with_integration(SMALL, sw.PRIMARY, t_end=-1.0)


def test_diverging_integration_is_an_error_with_its_reason():
    escaping = sw.Oscillator(1.0, 0.01, sw.Cubic(1.0, -0.1), sw.Harmonic(0.01), 0.9)
    with pytest.raises(sw.SolveError, match="left every bound"):
        sw.study.compare_with_integration(escaping, sw.PRIMARY, (10.0, 5.0), t_end=20.0)
