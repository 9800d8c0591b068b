"""Pieces of trajectories: the rough functions that choose steps and places of extremes, and the extremes themselves."""

import math

import numpy as np
import pytest

from strainwave.numerics.ensemble import pieces

pytestmark = pytest.mark.slow

NUMBERS = np.concatenate([10.0 ** np.linspace(-20.0, 20.0, 4001), 1.0 + np.linspace(0.0, 1.0, 501)]).tolist()


def test_rough_reciprocal_is_right_to_two_percent():
    assert max(abs(x * pieces._one_over_by_bits(x) - 1.0) for x in NUMBERS) < 0.02


def test_rough_logarithm_is_right_to_nine_hundredths_and_exact_at_powers_of_two():
    assert max(abs(pieces._log2_by_bits(x) - math.log2(x)) for x in NUMBERS) < 0.09
    assert [pieces._log2_by_bits(2.0**n) for n in (-66, -1, 0, 1, 7)] == [-66.0, -1.0, 0.0, 1.0, 7.0]


def test_rough_power_of_two_is_right_to_a_thousandth():
    assert max(abs(pieces._two_to_by_bits(x) / 2.0**x - 1.0) for x in np.linspace(-30.0, 30.0, 4001).tolist()) < 0.001


@pytest.mark.parametrize("x", [math.inf, math.nan, 0.0])
def test_a_scale_that_is_no_number_never_makes_an_error_small(x):
    assert not abs(1e-3 * pieces._one_over_by_bits(x)) <= 1.0


def test_extremes_between_two_points_are_those_of_a_sine():
    for start in np.linspace(0.0, 2.0 * math.pi, 97).tolist():
        for h, vertex_error, smooth_error in ((0.1, 1e-6, 1e-9), (0.2, 1e-5, 1e-7)):
            (x0, v0, a0), (x1, v1, a1) = [(math.sin(t), math.cos(t), -math.sin(t)) for t in (start, start + h)]
            found = pieces.vertex(x0, v0, x1, v1, h), pieces.smooth_vertex(x0, v0, a0, x1, v1, a1, h)
            if v0 * v1 < 0.0:
                assert found[0] == pytest.approx(math.copysign(1.0, x0), abs=vertex_error)
                assert found[1] == pytest.approx(math.copysign(1.0, x0), abs=smooth_error)
            else:
                low, high = sorted((x0, x1))
                assert all(low - 1e-15 <= value <= high + 1e-15 for value in found)


def test_extreme_of_a_state_at_rest_is_the_state():
    assert pieces.vertex(0.3, 0.0, 0.3, 0.0, 0.1) == 0.3
    assert abs(0.0) * pieces._one_over_by_bits(1e-290) == 0.0
