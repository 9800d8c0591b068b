"""Samples: strata, bounds, and the same points whichever stretch is requested."""

import numpy as np
import pytest
from scipy.special import ndtr
from scipy.stats import kstest, qmc

import strainwave as sw
from strainwave.sample.sampling import points_of

LAWS = {"law.K": sw.Normal(100.0, 5.0), "J": sw.sample.LogUniform(0.1, 10.0), "B": sw.Uniform(-1.0, 3.0)}


def shares(values):
    """What share of each distribution lies below the values."""
    return np.array(
        [
            ndtr((values["law.K"] - 100.0) / 5.0),
            np.log10(values["J"] / 0.1) / 2.0,
            (values["B"] + 1.0) / 4.0,
        ]
    )


@pytest.mark.parametrize("count", [1, 2, 7, 64, 1000])
def test_each_stratum_of_a_latin_hypercube_has_one_point(count):
    values = points_of(sw.sample.LatinHypercube(count, LAWS, seed=3)).values(0, count)
    for share in shares(values):
        assert np.array_equal(np.sort(np.floor(share * count)), np.arange(count))


def test_the_parameters_of_a_latin_hypercube_are_independent():
    # of two shuffled orders of n the correlation has the standard deviation 1/sqrt(n - 1) = 0.016
    a, b, c = shares(points_of(sw.sample.LatinHypercube(4096, LAWS)).values(0, 4096))
    assert max(abs(np.corrcoef(pair)[0, 1]) for pair in ((a, b), (b, c), (a, c))) < 0.06
    order = np.arange(4096)
    assert max(abs(np.corrcoef(order, share)[0, 1]) for share in (a, b, c)) < 0.06


def test_points_of_a_latin_hypercube_lie_anywhere_in_their_strata():
    share = shares(points_of(sw.sample.LatinHypercube(2000, LAWS)).values(0, 2000))[2] * 2000.0
    assert kstest(share - np.floor(share), "uniform").pvalue > 0.001


def test_sobol_points_are_those_of_scipy():
    mine = shares(points_of(sw.sample.Sobol(256, LAWS, seed=5)).values(0, 256))
    scipys = qmc.Sobol(3, rng=np.random.default_rng(5)).random_base2(8).T
    assert mine == pytest.approx(scipys, abs=1e-8)


@pytest.mark.parametrize("kind", [sw.sample.LatinHypercube, sw.sample.Sobol])
def test_a_point_depends_on_its_number_alone(kind):
    whole = points_of(kind(128, LAWS)).values(0, 128)
    again = points_of(kind(128, LAWS))
    for first, count in ((100, 28), (0, 1), (0, 3), (40, 30)):
        part = again.values(first, count)
        assert all(np.array_equal(part[path], whole[path][first : first + count]) for path in LAWS)


@pytest.mark.parametrize("kind", [sw.sample.LatinHypercube, sw.sample.Sobol])
def test_another_seed_gives_another_sample(kind):
    a, b = (points_of(kind(16, LAWS, seed=seed)).values(0, 16) for seed in (0, 1))
    assert not np.any(a["B"] == b["B"])


def test_a_normal_distribution_is_cut_off_at_its_bounds():
    law = sw.Normal(1.0, 0.5, low=0.5)
    p = np.linspace(0.001, 0.999, 101)
    values = law.quantile(p)
    below = ndtr(-1.0)
    assert values.min() > 0.5
    assert (ndtr((values - 1.0) / 0.5) - below) / (1.0 - below) == pytest.approx(p, abs=1e-12)


@pytest.mark.parametrize(
    ("grid", "words"),
    [
        (sw.sample.Sobol(1000, LAWS), "512 or 1024"),
        (sw.sample.LatinHypercube(0, LAWS), "at least 1"),
        (sw.sample.LatinHypercube(8, {}), "distributions is empty"),
        (sw.sample.LatinHypercube(8, LAWS, seed=-1), "seed"),
        (sw.sample.LatinHypercube(8, {"J": sw.Uniform(2.0, 1.0)}), "low must be below high"),
        (sw.sample.LatinHypercube(8, {"J": sw.sample.LogUniform(-1.0, 1.0)}), "positive"),
        (sw.sample.LatinHypercube(8, {"J": sw.Normal(1.0, 0.0)}), "positive"),
        (sw.sample.LatinHypercube(8, {"J": sw.Normal(1.0, 0.1, low=9.0)}), "widen"),
        ({}, "dict of path to values"),
        ({"J": []}, "finite numbers"),
        ({"J": [1.0, np.nan]}, "finite numbers"),
    ],
)
def test_what_is_no_grid_is_refused_in_one_sentence(grid, words):
    with pytest.raises((TypeError, ValueError), match=words) as refusal:
        points_of(grid)
    assert "\n" not in str(refusal.value)
