"""Intervals of least squares: coverage with coloured residuals, and agreement with textbook formulas."""

import math

import numpy as np
import pytest
from scipy import stats
from scipy.signal import lfilter

from strainwave.study.identification.intervals import bootstrap, interval, sandwich, spread, whitener

SETS, ROWS = 400, 2000
LOW, HIGH = stats.binom.ppf([0.001, 0.999], SETS, 0.95) / SETS  # 91.5 .. 98 %
TRUE = np.array([0.3, 1.1, 0.7, -0.4])
AT = 2.0 * math.pi * 0.12  # rad a sample: the motion, and the resonance of the residual


def columns(rows=ROWS):
    """Offset, drift, and a motion with its cube."""
    k = np.arange(rows)
    motion = np.cos(AT * k + 3.0 * np.sin(2.0 * math.pi * k / rows))
    return np.column_stack([np.ones(rows), np.sin(8.0 * k / rows), motion, np.sin(AT * k)])


def coloured(rng, feedback, rows=ROWS):
    return lfilter([1.0], np.append(1.0, feedback), rng.standard_normal(rows + 1000))[1000:]


def resonant(radius):
    return [-2.0 * radius * math.cos(AT), radius * radius]


NOISE = {
    "white": lambda rng, _: rng.standard_normal(ROWS),
    "AR(1), 0.9": lambda rng, _: coloured(rng, [-0.9]),
    "AR(2), resonance": lambda rng, _: coloured(rng, resonant(0.98)),
    "quantised": lambda rng, clean: 0.5 * np.round((clean + 0.15 * rng.standard_normal(ROWS)) / 0.5) - clean,
    "grows with the motion": lambda rng, _: rng.standard_normal(ROWS) * (0.2 + columns()[:, 2] ** 2),
}


def covered(make, of):
    """Shares (p,) of the sets in which the intervals of `of(jacobian, residual)` cover the true parameters."""
    rng, table = np.random.default_rng(7), columns()
    inverse, hits = np.linalg.pinv(table), 0
    for _ in range(SETS):
        noise = make(rng, table @ TRUE)
        off = inverse @ noise
        deviation, freedom = of(table, noise - table @ off)
        hits = hits + np.array(
            [
                low <= 0.0 <= high
                for low, high in (interval(*three) for three in zip(off, deviation, freedom, strict=True))
            ]
        )
    return hits / SETS


def robust(table, residual):
    found = spread(table, residual)
    return np.sqrt(np.diag(found.covariance)), found.freedom


def ordinary(table, residual):
    freedom = len(residual) - table.shape[1]
    variance = np.diag(np.linalg.inv(table.T @ table)) * (residual @ residual) / freedom
    return np.sqrt(variance), np.full(table.shape[1], freedom)


@pytest.mark.slow
@pytest.mark.parametrize("name", NOISE)
def test_intervals_cover_with_every_kind_of_noise(name):
    shares = covered(NOISE[name], robust)
    assert np.all((shares >= LOW) & (shares <= HIGH)), shares


@pytest.mark.slow
@pytest.mark.parametrize(("name", "which"), [("AR(1), 0.9", 0), ("AR(2), resonance", 3)])
def test_ordinary_intervals_do_not_cover_where_the_residual_is_coloured_as_the_column(name, which):
    assert covered(NOISE[name], ordinary)[which] < 0.5


def test_the_whitener_is_the_filter_that_made_the_residual():
    residual = coloured(np.random.default_rng(1), resonant(0.95), 20000)
    assert whitener(residual, [slice(0, 20000)])[:2] == pytest.approx(-np.array(resonant(0.95)), abs=0.02)


def test_white_residuals_give_the_textbook_covariance():
    table, residual = columns(), np.random.default_rng(2).standard_normal(ROWS)
    deviation = np.sqrt(np.diag(sandwich(table, residual)))
    assert deviation == pytest.approx(ordinary(table, residual)[0], rel=0.06)


def test_variance_of_a_mean_is_the_spectrum_at_zero():
    rows, feedback = 20000, 0.9
    residual = coloured(np.random.default_rng(3), [-feedback], rows)
    variance = sandwich(np.ones((rows, 1)), residual - residual.mean())[0, 0]
    assert variance == pytest.approx(1.0 / (rows * (1.0 - feedback) ** 2), rel=0.15)


def test_records_are_not_correlated_with_each_other():
    rng, rows = np.random.default_rng(4), 1000
    table, residual = columns(rows), coloured(rng, [-0.9], rows)
    alone = sandwich(table, residual)
    twice = sandwich(np.vstack([table, table]), np.tile(residual, 2), [rows, rows])
    assert np.diag(twice) == pytest.approx(0.5 * np.diag(alone), rel=0.02)


def test_the_units_of_a_parameter_only_scale_its_deviation():
    table, residual = columns(), coloured(np.random.default_rng(5), [-0.5])
    scale = np.array([1e-9, 1.0, 1e7, 3.0])
    assert sandwich(table * scale, residual) == pytest.approx(
        sandwich(table, residual) / np.outer(scale, scale), rel=1e-6
    )


@pytest.mark.parametrize(("block", "records"), [(None, [100] * 80), (100, None)])
def test_bootstrap_agrees_with_the_sandwich(block, records):
    rng, rows = np.random.default_rng(6), 8000
    table = columns(rows)
    noise = coloured(rng, [-0.7], rows)
    residual = noise - table @ (np.linalg.pinv(table) @ noise)
    drawn = bootstrap(table, residual, records, block=block, draws=2000)
    assert np.std(drawn, axis=0)[[0, 2, 3]] == pytest.approx(
        np.sqrt(np.diag(sandwich(table, residual, records)))[[0, 2, 3]], rel=0.25
    )


def test_interval_is_students():
    low, high = interval(3.0, 0.5, 7.0)
    assert (high - 3.0, 3.0 - low) == pytest.approx([0.5 * stats.t.ppf(0.975, 7)] * 2)
    assert interval(3.0, 0.5, level=0.5).high == pytest.approx(3.0 + 0.5 * stats.norm.ppf(0.75))


def test_a_perfect_fit_has_no_scatter():
    assert np.all(sandwich(columns(), np.zeros(ROWS)) == 0.0)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: interval(1.0, 1.0, level=95), "level is 95; it is the probability of covering"),
        (lambda: spread(np.ones((3, 4)), np.ones(3)), "more rows n than parameters p"),
        (lambda: spread(np.ones((9, 2)), np.arange(9.0)), "depend on each other"),
        (lambda: spread(np.ones((9, 1)), np.full(9, np.nan)), "must be finite numbers"),
        (lambda: spread(np.ones((9, 1)), np.ones(9), [4, 4]), "share out all 9 rows"),
        (lambda: bootstrap(np.ones((9, 1)), np.ones(9)), "there is one record"),
    ],
)
def test_bad_input_is_one_sentence(call, said):
    with pytest.raises(ValueError, match=said) as caught:
        call()
    assert "\n" not in str(caught.value)
