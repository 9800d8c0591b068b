"""The operating point under a mean torque: figures of a size-40 gear, the terms, and the backbone by quadrature."""

import math

import numpy as np
import pytest

import strainwave as sw

# Cubic fit of the three slopes of a CSF-40-50 (1, 1.4, 1.8)e5 N*m/rad, 54 and 196 N*m: CSF/CSG catalogue, p. 50.
SIZE_40 = sw.Cubic(1.089e5, 6.85e4)
SLOPES = sw.PiecewiseLinear(1e5, 1.4e5, 1.8e5, 54.0, 196.0)


def test_rated_torque_raises_the_frequency_of_a_size_40_gear_by_a_fifth():
    at = sw.small_signal(SIZE_40, 178.0)  # rated torque of the CSG-40-50
    assert at.x == pytest.approx(1.43e-3, abs=0.005e-3)
    assert 3.0 * SIZE_40.alpha * at.x**2 == pytest.approx(0.42, abs=0.005)
    assert at.frequency_ratio == pytest.approx(1.19, abs=0.005)
    assert SIZE_40.torque(at.x) == pytest.approx(178.0, rel=1e-12)
    assert at.quadratic == pytest.approx(3.0 * SIZE_40.K * SIZE_40.alpha * at.x, rel=1e-14)
    assert at.cubic == pytest.approx(SIZE_40.K * SIZE_40.alpha, rel=1e-14)


def test_taylor_terms_of_a_polynomial_are_its_shifted_coefficients():
    law = sw.Polynomial((0.1, 1.0, -0.2, 0.5, 0.3))
    at = sw.small_signal(law, 0.7)
    u = np.linspace(-1e-2, 1e-2, 9)
    cubic = 0.7 + at.stiffness * u + at.quadratic * u**2 + at.cubic * u**3
    np.testing.assert_allclose(law.torque(at.x + u), cubic, rtol=0, atol=0.31e-8)  # the fourth-order term, 0.3 u^4


def test_terms_for_an_amplitude_become_taylors_as_it_shrinks():
    law = sw.Cubic(1.0, 0.3)
    fitted, taylor = sw.small_signal(law, 0.8, amplitude=0.4), sw.small_signal(law, 0.8)
    assert (fitted.quadratic, fitted.cubic) == pytest.approx((taylor.quadratic, taylor.cubic), rel=1e-10)
    law = sw.tabulated([(0.01 * i, math.tan(0.01 * i)) for i in range(-60, 61, 2)])
    smaller = sw.small_signal(law, math.tan(0.3), amplitude=0.05)
    t = math.tan(0.3)
    assert smaller.quadratic == pytest.approx(t * (1.0 + t * t), rel=0.02)  # second Taylor coefficient of tan


def test_straight_lines_have_terms_only_for_an_amplitude():
    small, large = sw.small_signal(SLOPES, 178.0), sw.small_signal(SLOPES, 178.0, amplitude=1e-3)
    assert (small.stiffness, small.quadratic, small.cubic, small.backbone) == (1.4e5, None, None, None)
    assert large.x == small.x == pytest.approx(SLOPES.breakpoints()[2] + (178.0 - 54.0) / 1.4e5, rel=1e-12)
    assert large.quadratic > 0.0  # softer below, stiffer above


def test_without_mean_torque_an_odd_law_has_no_even_term():
    at = sw.small_signal(SIZE_40, 0.0)
    assert (at.x, at.quadratic, at.frequency_ratio) == (0.0, 0.0, 1.0)
    assert at.backbone == pytest.approx(3.0 / 8.0 * SIZE_40.alpha, rel=1e-14)


@pytest.mark.parametrize("mean", [0.0, 0.2, 0.6])
def test_free_vibration_about_the_operating_point_follows_the_backbone(mean):
    # Independent: the period of an undamped motion from its energy integral (quadrature between the turning points).
    law = sw.Cubic(1.0, 0.1)
    at = sw.small_signal(law, mean)
    top = 0.02

    def potential(x):
        return law.energy(x) - mean * x

    low, high = at.x - 2.0 * top, at.x - 0.5 * top
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if potential(middle) > potential(at.x + top) else (low, middle)
    bottom = 0.5 * (low + high)
    centre, amplitude = 0.5 * (at.x + top + bottom), 0.5 * (at.x + top - bottom)
    angle = (np.arange(400) + 0.5) * math.pi / 400  # x = centre + amplitude cos(angle) removes the end singularities
    x = centre + amplitude * np.cos(angle)
    speed = np.sqrt(2.0 * (potential(at.x + top) - potential(x)))
    period = 2.0 * np.mean(amplitude * np.sin(angle) / speed) * math.pi
    shift = 2.0 * math.pi / period / math.sqrt(at.stiffness) - 1.0
    assert shift == pytest.approx(at.backbone * amplitude**2, rel=2e-3)


def test_play_has_no_stiffness_at_rest_but_some_under_torque():
    at = sw.small_signal(sw.Play(1e-4, sw.Linear(1e5)), 20.0)
    assert (at.x, at.stiffness, at.frequency_ratio) == (pytest.approx(3e-4, rel=1e-12), 1e5, math.inf)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"mean_torque": math.nan}, r"mean_torque \[N\*m\] is nan"),
        ({"mean_torque": 1.0, "amplitude": 0.0}, r"amplitude \[rad\] is 0\.0"),
        ({"mean_torque": 1.0, "amplitude": math.inf}, r"amplitude \[rad\] is inf"),
    ],
)
def test_impossible_operating_points_are_refused(arguments, sentence):
    with pytest.raises(ValueError, match=sentence):
        sw.small_signal(SIZE_40, **arguments)


def test_a_torque_that_a_softening_law_cannot_carry_is_refused():
    with pytest.raises(
        ValueError, match=r"Cubic carries at most 1\.2171\d N\*m, at 1\.83 rad, and the mean torque is 5 N"
    ):
        sw.small_signal(sw.Cubic(1.0, -0.1), 5.0).x  # noqa: B018
