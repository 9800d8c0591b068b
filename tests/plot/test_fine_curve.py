"""Curves drawn between their points: closer to the truth than straight lines, and exact where they were computed."""

from dataclasses import replace

import numpy as np
import pytest

from strainwave.base.results import Branch, Status
from strainwave.drive.drive_response import DriveResponse
from strainwave.plot.smooth_curve import PARTS, fine

ZETA = 0.05


def response(omega):
    """Linear oscillator (omega_0 = 1) under cos(phase): its harmonic is 1/(1 - omega^2 + 2 i zeta omega)."""
    motion = 1.0 / (1.0 - omega**2 + 2j * ZETA * omega)
    table = np.column_stack([0.0 * omega, motion.real, -motion.imag, 0.0 * omega, 0.0 * omega])
    stable, multipliers = omega < 1.0, np.zeros((len(omega), 2), complex)
    curve = Branch(
        "omega", omega, omega, table, np.abs(motion), multipliers, stable, [], [], 1, False, 0.0, "", Status.OK, ""
    )
    return DriveResponse(curve, None)


def test_a_drawn_curve_is_ten_times_nearer_to_the_truth_than_straight_lines():
    coarse = response(0.5 + np.cumsum(np.tile([0.018, 0.022], 25)))
    drawn = fine(coarse).curve
    truth = response(drawn.omega).curve.peak
    straight = np.interp(drawn.omega, coarse.curve.omega, coarse.curve.peak)
    assert np.max(np.abs(drawn.peak - truth)) < 0.1 * np.max(np.abs(straight - truth))


def test_computed_points_stay_and_a_step_is_as_stable_as_its_first_point():
    coarse = response(np.linspace(0.5, 1.5, 41))
    drawn = fine(coarse).curve
    for name in ("omega", "coefficients", "peak", "stable"):
        assert np.array_equal(getattr(drawn, name)[::PARTS], getattr(coarse.curve, name)), name
    assert np.array_equal(drawn.stable[:-1], np.repeat(coarse.curve.stable[:-1], PARTS))


def test_a_curve_that_beats_is_drawn_by_the_sizes_of_its_turns():
    def beating(omega):
        found = response(omega)
        size = found.curve.peak
        return replace(found, curve=replace(found.curve, envelope=np.column_stack([1.5 * size, 0.5 * size])))

    coarse = beating(0.5 + np.cumsum(np.tile([0.018, 0.022], 25)))
    drawn = fine(coarse).curve
    assert np.array_equal(drawn.envelope[::PARTS], coarse.curve.envelope)
    assert np.array_equal(drawn.peak[::PARTS], coarse.curve.peak)
    assert len(drawn.oscillation) == len(drawn.omega)
    np.testing.assert_allclose(drawn.envelope, np.outer(drawn.peak, [1.5, 0.5]), rtol=1e-12)
    truth = response(drawn.omega).curve.peak
    straight = np.interp(drawn.omega, coarse.curve.omega, coarse.curve.peak)
    assert np.max(np.abs(drawn.peak - truth)) < 0.1 * np.max(np.abs(straight - truth))


@pytest.mark.parametrize("count", [1, 2])
def test_a_curve_of_few_points_is_drawn_as_it_is(count):
    few = response(np.linspace(0.5, 0.6, count))
    assert fine(few) is few
