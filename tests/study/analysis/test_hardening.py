"""The trade of the cubic coefficient: closed forms at first order, harmonic balance and integration beyond it."""

import numpy as np
import pytest

import strainwave as sw

ZETA, F = 0.01, 0.01
DUFFING = sw.Oscillator(1.0, 2.0 * ZETA, sw.Cubic(1.0, 0.0), sw.Harmonic(F), 1.0)


def test_without_hardening_it_is_the_linear_resonance():
    found = sw.study.hardening(DUFFING, [0.0], (0.2, 1.5))
    top = np.sqrt(1.0 - 2.0 * ZETA**2)
    assert found.peak[0] == pytest.approx(F / (2.0 * ZETA * np.sqrt(1.0 - ZETA**2)), rel=1e-6)
    assert found.peak_speed[0] == pytest.approx(top, rel=1e-4)
    assert found.jump_width[0] == 0.0
    assert found.superharmonic[0] < 1e-12
    assert found.inside.all()


def test_a_law_that_says_the_polynomial_of_a_cubic_is_one():
    own = DUFFING._replace(law=sw.Polynomial((0.0, 1.0, 0.0, 0.5)))
    found = sw.study.hardening(own, [0.0, 0.01], (0.2, 1.5))
    assert found.peak == pytest.approx(sw.study.hardening(DUFFING, [0.0, 0.01], (0.2, 1.5)).peak, rel=1e-12)
    with pytest.raises(ValueError, match="requires a Cubic law, not Polynomial"):
        sw.study.hardening(DUFFING._replace(law=sw.Polynomial((0.0, 1.0, 0.1, 0.5))), [0.0], (0.2, 1.5))


def test_first_order_says_what_changes_and_what_does_not():
    # Nayfeh & Mook 1979, 4.1: peak f/(mu omega_0), shift 3/8 alpha a^2, superharmonic alpha C^3/(4 mu), C = F/(1 - 1/9)
    alpha = np.array([-0.02, 0.01, 0.02, 0.04])
    weak = DUFFING._replace(excitation=sw.Harmonic(2.0 * ZETA * 0.3))  # peak 0.3
    found = sw.study.hardening(weak, alpha, (0.2, 1.3))
    shift = 0.375 * alpha * found.peak**2
    np.testing.assert_allclose(found.peak, 0.3, rtol=2e-3)
    np.testing.assert_allclose(found.peak_speed - np.sqrt(1.0 - 2.0 * ZETA**2), shift, rtol=0.02, atol=2e-6)
    C = 2.0 * ZETA * 0.3 / (1.0 - 1.0 / 9.0)
    np.testing.assert_allclose(found.superharmonic, np.abs(alpha) * C**3 / (8.0 * ZETA), rtol=0.02)
    np.testing.assert_allclose(3.0 * found.superharmonic_speed, 1.0, atol=2e-3)


def test_strong_hardening_lowers_the_peak_as_its_speed_rises():
    # beyond first order the peak is A/(mu omega_peak): 3.13 against 5 at first order
    strong = DUFFING._replace(B=0.01, excitation=sw.Harmonic(0.05))
    found = sw.study.hardening(strong, [0.0, 0.1, 0.4], (0.15, 4.0))
    np.testing.assert_allclose(found.peak[1:] * found.peak_speed[1:], 5.0, rtol=0.03)
    assert np.all(np.diff(found.peak) < 0.0)
    assert np.all(np.diff(found.jump_width) > 0.0)


@pytest.mark.slow
def test_the_error_at_the_speeds_of_duty_is_the_largest_that_integration_settles_on():
    speeds, alpha = [0.5, 1.05, 1.2, 1.35], [0.05, 0.3]
    system = DUFFING._replace(excitation=sw.Harmonic(0.06))
    found = sw.study.hardening(system, alpha, (0.2, 2.0), speeds=speeds)
    a = np.linspace(-3.0, 3.0, 13)
    x, v, w, k = (part.ravel() for part in np.meshgrid(a, a, speeds, alpha, indexing="ij"))
    settled = sw.ensemble(
        system,
        {"omega": w, "law.alpha": k},
        np.stack([x, v]),
        periods=20,
        settle=400,
        measures=(sw.numerics.Extremes(),),
    )
    half = np.maximum(-settled.lowest.values, settled.highest.values)  # an odd law: no mean
    for i, one in enumerate(alpha):
        for j, speed in enumerate(speeds):
            seen = np.max(half[(w == speed) & (k == one)])
            assert found.at_speeds[i, j] == pytest.approx(seen, rel=2e-3)
    assert found.best() in alpha
    assert found.best([1.0, 0.0, 0.0, 0.0]) == alpha[int(np.argmin(found.at_speeds[:, 0]))]


def test_what_it_cannot_answer_gets_a_sentence():
    with pytest.raises(ValueError, match="requires a Cubic law"):
        sw.study.hardening(DUFFING._replace(law=sw.PiecewiseLinear(1.0, 2.0, 3.0, 1.0, 2.0)), [0.1], (0.2, 2.0))
    with pytest.raises(ValueError, match="must hold both resonances"):
        sw.study.hardening(DUFFING, [0.1], (0.5, 2.0))
    two = sw.Harmonics((sw.Harmonic(0.1), sw.Harmonic(0.1, 2)))
    with pytest.raises(ValueError, match="one order of excitation"):
        sw.study.hardening(DUFFING._replace(excitation=two), [0.1], (0.2, 2.0))
    with pytest.raises(ValueError, match="inside the range"):
        sw.study.hardening(DUFFING, [0.1], (0.2, 2.0), speeds=[3.0])
    with pytest.raises(ValueError, match="alpha"):
        sw.study.hardening(DUFFING, [np.nan], (0.2, 2.0))
    found = sw.study.hardening(DUFFING, [0.1], (0.2, 2.0))
    with pytest.raises(ValueError, match="speeds of the duty"):
        found.best()


def test_a_range_that_ends_in_a_bistable_band_has_its_largest_motion_at_its_end():
    # the upper motions go on to 1.26; averaging puts them at a speed by their size (Nayfeh & Mook 1979, 4.1)
    found = sw.study.hardening(DUFFING._replace(B=0.02, excitation=sw.Harmonic(0.05)), [0.2], (0.24, 1.2))
    whole = sw.study.hardening(DUFFING._replace(B=0.02, excitation=sw.Harmonic(0.05)), [0.2], (0.24, 1.8))
    assert found.peak_speed[0] == 1.2
    assert found.peak[0] < 0.9 * whole.peak[0]
    a = found.peak[0]
    assert np.sqrt(1.0 + 0.75 * 0.2 * a**2 - 0.05 / a) == pytest.approx(found.peak_speed[0], rel=5e-3)
    assert not found.inside[0]
    assert whole.inside[0]
