"""Rankings against functions of known indices."""

import numpy as np
import pytest
from scipy import stats

from strainwave.files.variants.ranking import _first_order, ranking


def test_first_order_indices_of_the_ishigami_function():
    """Ishigami & Homma 1990: a = 7, b = 0.1 gives S1 = 0.3139, S2 = 0.4424, S3 = 0 (Saltelli et al. 2008)."""
    rng = np.random.default_rng(0)
    x = rng.uniform(-np.pi, np.pi, (3, 8000))
    y = ishigami(x)
    rows = {row.path: row for row in ranking(dict(zip("abc", x, strict=True)), y).rows}
    for path, wanted in (("a", 0.3139), ("b", 0.4424), ("c", 0.0)):
        assert abs(rows[path].index - wanted) < max(0.015, 3.0 * rows[path].index_error)
        assert rows[path].index_error < 0.02


def ishigami(x):
    return np.sin(x[0]) + 7.0 * np.sin(x[1]) ** 2 + 0.1 * x[2] ** 4 * np.sin(x[0])


def linear(x):
    return np.sqrt([0.75, 0.2, 0.05]) @ stats.norm.ppf(stats.uniform.cdf(x, -np.pi, 2.0 * np.pi))


@pytest.mark.parametrize(("count", "shift"), [(32, 0.04), (64, 0.02), (200, 0.01)])
@pytest.mark.parametrize(("function", "wanted"), [(ishigami, [0.3139, 0.4424, 0.0]), (linear, [0.75, 0.2, 0.05])])
def test_intervals_of_first_order_indices_cover(function, wanted, count, shift):
    """400 samples each: exact indices (Saltelli et al. 2008, and the shares of a sum) inside 1.96 standard errors."""
    errors, covered = [], []
    for seed in range(400):
        x = np.random.default_rng(seed).uniform(-np.pi, np.pi, (3, count))
        inputs = stats.norm.ppf(stats.uniform.cdf(x, -np.pi, 2.0 * np.pi)) if function is linear else x
        found = [_first_order(values, function(x)) for values in inputs]
        errors.append([index - exact for (index, _), exact in zip(found, wanted, strict=True)])
        covered.append([abs(index - w) < 1.96 * sigma for (index, sigma), w in zip(found, wanted, strict=True)])
    assert np.max(np.abs(np.mean(errors, axis=0))) < shift
    assert np.min(np.mean(covered, axis=0)) > 0.91
    assert 0.94 < np.mean(covered) < 0.99


def test_an_output_or_an_input_that_stays_has_no_index():
    x = np.random.default_rng(0).uniform(size=(2, 100))
    assert _first_order(x[0], np.ones(100)) == (0.0, 0.0)
    index, error = _first_order(np.ones(100), x[1])
    assert abs(index) < 2.0 * error
    index, error = _first_order(x[0], 3.0 * x[0] - 1.0)
    assert index == pytest.approx(1.0, abs=1e-9)
    assert error < 1e-9


def test_indices_of_a_sum_are_shares_of_its_variance():
    rng = np.random.default_rng(1)
    x = rng.normal(size=(2, 4000))
    found = ranking({"a": x[0], "b": x[1]}, 3.0 * x[0] - x[1])
    (first, second) = found.rows
    assert (first.path, second.path) == ("a", "b")
    assert abs(first.index - 0.9) < 4.0 * first.index_error + 0.01
