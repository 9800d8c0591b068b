"""The largest value of a series between its samples, against closed forms and a dense grid."""

import numpy as np
import pytest

from strainwave.base.series import (
    MOST_BYTES,
    highest_between,
    largest_of_samples,
    largest_size,
    oscillation,
    remembered,
    sizes_of_samples,
    weights_at,
)


def test_one_wave_has_its_amplitude_and_its_mean():
    found = largest_size(np.array([[0.3, 0.6, -0.8], [-0.3, 0.6, -0.8], [0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]))
    np.testing.assert_allclose(found, [1.3, 1.3, 0.0, 2.0], rtol=1e-15)


def test_oscillation_is_counted_from_the_mean_to_the_farther_side():
    # -cos a + cos 2a / 2 lies between -3/4 (cos a = 1/2) and 3/2 (cos a = -1)
    coefficients = np.array([[100.0, -1.0, 0.0, 0.5, 0.0]])
    assert oscillation(coefficients) == pytest.approx(1.5, rel=1e-15)
    assert oscillation(-coefficients) == pytest.approx(1.5, rel=1e-15)
    assert coefficients[0, 0] == 100.0


def test_largest_size_of_random_series_is_that_of_a_grid_of_a_million_points():
    rng, h = np.random.default_rng(5), 9
    coefficients = rng.normal(size=(6, 2 * h + 1))
    found, k = largest_size(coefficients), np.arange(1, h + 1)[:, None]
    angle = np.linspace(0.0, 2.0 * np.pi, 1_000_001)
    for row, value in zip(coefficients, found, strict=True):
        dense = np.max(np.abs(row[0] + row[1::2] @ np.cos(k * angle) + row[2::2] @ np.sin(k * angle)))
        # a grid misses at most h^2 step^2/8 of the sum of the amplitudes: 6e-10 here
        assert 0.0 <= value - dense + 1e-12 <= 1e-8


def test_a_mean_alone_and_no_series_are_taken():
    np.testing.assert_array_equal(largest_size(np.array([[-2.0], [1.0]])), [2.0, 1.0])
    assert largest_size(np.empty((0, 5))).shape == (0,)


def test_the_highest_place_between_two_is_that_of_a_dense_look():
    arc = np.array([0.0, 0.8, 2.0, 2.9, 4.1])
    rows = np.stack([np.full(5, 0.2), np.cos(0.5 * (arc - 1.7)), 0.3 * np.sin(arc)], axis=1)
    for from_mean in (False, True):
        place, top = highest_between(arc, rows, 0.8, 2.9, from_mean)
        places = np.linspace(0.8, 2.9, 40001)
        dense = np.stack([np.polyval(np.polyfit(arc, column, 4), places) for column in rows.T], axis=1)
        sizes = np.hypot(dense[:, 1], dense[:, 2]) + (0.0 if from_mean else np.abs(dense[:, 0]))
        assert place == pytest.approx(places[np.argmax(sizes)], abs=1e-3)
        assert top == pytest.approx(np.max(sizes), rel=1e-8)
        assert weights_at(arc, place).sum() == pytest.approx(1.0, abs=1e-14)


def test_the_largest_of_sampled_rows_is_that_of_each_wherever_it_stands():
    angles = 2.0 * np.pi * np.arange(96) / 96
    shifts = np.concatenate([angles[:4], angles[-4:] + 0.02, np.random.default_rng(3).uniform(0.0, 6.0, 20)])
    waves = np.cos(angles + shifts[:, None]) + 0.2 * np.cos(3.0 * (angles + shifts[:, None]))
    waves[5, 40] = 3.0  # a jump, which no parabola goes through
    sizes = largest_of_samples(-waves)
    assert sizes[5] == 3.0
    # a parabola through samples of step h misses the top by at most 3 h^4/128 of the fourth derivative, 17.2 there
    np.testing.assert_allclose(np.delete(sizes, 5), 1.2, atol=17.2 * angles[1] ** 4 * 3 / 128)
    assert largest_of_samples(np.empty((0, 5))).shape == (0,)


def test_the_sizes_of_samples_are_those_beside_them_but_at_crests():
    angles = 2.0 * np.pi * (np.arange(96) + 0.4) / 48
    waves = -np.cos(angles)
    sizes, crests = sizes_of_samples(waves), [24, 48, 72]  # those at the ends have too few beside them
    np.testing.assert_array_equal(np.delete(sizes, crests), np.delete(np.abs(waves), crests))
    np.testing.assert_allclose(sizes[crests], 1.0, atol=3 * angles[1] ** 4 / 128)
    waves[24] = 3.0  # a jump, which no parabola goes through
    assert np.max(sizes_of_samples(waves)) == 3.0


def test_tables_are_remembered_up_to_a_size_and_those_used_last_stay():
    made = []

    @remembered
    def table(bytes_of_it):
        made.append(bytes_of_it)
        return np.zeros(bytes_of_it, np.uint8), np.zeros(0)

    first, large = table(3), MOST_BYTES - 4
    table(4)
    assert table(3) is first
    table(large)  # with 3 it fits, with 4 it does not
    assert table(3) is first
    table(4)
    assert made == [3, 4, large, 4]
    table(2 * MOST_BYTES)
    table(3)
    assert made[4:] == [2 * MOST_BYTES, 3]
