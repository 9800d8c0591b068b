"""Spectra from accuracy classes, and their true peak-to-peak."""

import math

import numpy as np
import pytest

import strainwave as sw
from strainwave.model.error_spectrum import MEASURED_ERRORS, accuracy_spectrum, extremes, peak_to_peak

ARCSEC = math.pi / 648_000.0


def error_of(*lines):
    return sw.KinematicError(tuple(sw.Line(*line) for line in lines))


def extremes_by_roots(orders, a, b):
    """Extremes of a trigonometric polynomial from all roots of its derivative in z = exp(i t)."""
    n = max(orders)
    slope = np.zeros(2 * n + 1, complex)
    for k, c, s in zip(orders, a, b, strict=True):
        half = 0.5 * (c - 1j * s)  # of z^k
        slope[n + k] += 1j * k * half
        slope[n - k] -= 1j * k * np.conj(half)
    t = np.angle(np.roots(slope[::-1]))
    values = sum(c * np.cos(k * t) + s * np.sin(k * t) for k, c, s in zip(orders, a, b, strict=True))
    return float(np.min(values)), float(np.max(values))


@pytest.mark.parametrize("seed", range(6))
def test_extremes_are_those_at_the_roots_of_the_derivative(seed):
    rng = np.random.default_rng(seed)
    orders = rng.choice(np.arange(1, 13), size=4, replace=False)
    a, b = rng.normal(size=(2, 4))
    # every root is near the unit circle or a value inside the range, so the extremes are the true ones
    assert extremes(orders, a, b) == pytest.approx(extremes_by_roots(orders, a, b), rel=1e-9)


def test_peak_to_peak_of_one_and_two_lines_has_its_closed_form():
    assert peak_to_peak(error_of((2, 3e-5, 0.7))) == pytest.approx(6e-5, rel=1e-14)
    assert peak_to_peak(error_of((2, 3e-5, 0.0), (2, 4e-5, 0.5 * math.pi))) == pytest.approx(1e-4, rel=1e-12)
    # cos t + r cos 2t: largest 1 + r at 0, smallest -r - 1/(8 r) where cos t = -1/(4 r), for r > 1/4
    for r in (0.3, 1.0, 4.0):
        assert peak_to_peak(error_of((1, 1.0), (2, r))) == pytest.approx(1.0 + 2.0 * r + 1.0 / (8.0 * r), rel=1e-12)


def test_peak_to_peak_does_not_depend_on_the_base_turn_or_a_shift():
    one = error_of((1, 1e-5, 0.2), (2, 3e-5, 1.0), (4, 1e-5, -2.0))
    shifted = error_of(*((k, a, p + 0.37 * k) for k, a, p in one.lines))
    assert peak_to_peak(shifted) == pytest.approx(peak_to_peak(one), rel=1e-12)
    assert peak_to_peak(sw.gears.on_output_turn(one, 160)) == pytest.approx(peak_to_peak(one), rel=1e-12)


def test_lines_of_both_turns_have_their_peak_to_peak_on_the_output_turn():
    oval = error_of((2, 1e-4), (2 - 2 / 50, 1e-4, 0.3), (7 / 50, 2e-5))
    theta = np.linspace(0.0, 50 * 2.0 * math.pi, 1_000_001)  # a turn of the output, by the motor's
    moved = sw.gears.on_output_turn(oval, 50)
    assert moved.orders() == (100, 98, 7)
    assert peak_to_peak(moved) == pytest.approx(np.ptp(oval.value(theta)), rel=1e-6)


@pytest.mark.parametrize("shares", [{2: 1.0}, {1: 0.25, 2: 1.0, 4: 0.25}, {1: 3.0, 2: 2.0, 4: 1.0, 6: 0.5}])
def test_spectrum_of_a_class_has_its_peak_to_peak_and_its_shares(shares):
    error = accuracy_spectrum(2.9e-4, shares, phases={2: 0.4})
    theta = np.linspace(0.0, 2.0 * math.pi, 100_001)
    assert np.ptp(error.value(theta)) == pytest.approx(2.9e-4, rel=1e-6)
    amplitudes = {line.order: line.amplitude for line in error.lines}
    for order, share in shares.items():
        assert amplitudes[order] / amplitudes[2] == pytest.approx(share / shares[2], rel=1e-12)


def test_default_shares_give_less_than_the_sum_of_amplitudes():
    error = accuracy_spectrum(1.0)
    assert [line.order for line in error.lines] == [1, 2, 4]
    assert 2.0 * sum(line.amplitude for line in error.lines) > 1.2
    assert accuracy_spectrum(np.float32(1.0)) == error


def test_every_catalogue_gear_with_a_class_gets_a_spectrum():
    classes = {gear.accuracy for gear in sw.catalogue.select() if gear.accuracy is not None}
    assert len(classes) >= 3
    for accuracy in classes:
        assert peak_to_peak(accuracy_spectrum(accuracy)) == pytest.approx(accuracy, rel=1e-12)


def test_measured_errors_are_below_the_vendors_limit_where_both_are_known():
    found = MEASURED_ERRORS[0]
    assert peak_to_peak(found.error()) == pytest.approx(46.0 * ARCSEC, rel=1e-12)
    assert found.peak_to_peak < sw.catalogue.gear("CSF-17-100").accuracy  # CSF/CSG catalogue p. 49: 4.4e-4 rad
    assert all(error.source and error.error(2).lines[0].order == 2 for error in MEASURED_ERRORS)


@pytest.mark.parametrize("accuracy", [0.0, -1e-4, 1e-300, 1e300, math.nan, math.inf, None])
def test_an_accuracy_that_is_no_angle_is_refused(accuracy):
    with pytest.raises(ValueError, match="it must be a positive angle in rad"):
        accuracy_spectrum(accuracy)


@pytest.mark.parametrize(
    ("shares", "phases", "words"),
    [
        ({}, None, "no order has a share"),
        ({2: 0.0}, None, "no order has a share"),
        ({2: -1.0}, None, "share of order 2 is -1.0"),
        ({2: math.nan}, None, "share of order 2 is nan"),
        ({0: 1.0}, None, "order is 0"),
        ({2.5: 1.0}, None, "whole number"),
        ({2: 1e300}, None, "share of order 2 is 1e.300"),
        ({2: 1.0}, {4: 0.1}, "order 4 has a phase and no share"),
        ({2: 1.0}, {2: math.inf}, "it must be finite"),
    ],
)
def test_wrong_shares_and_phases_are_refused(shares, phases, words):
    with pytest.raises(ValueError, match=words):
        accuracy_spectrum(1e-4, shares, phases)
