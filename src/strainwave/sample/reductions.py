"""Which input makes an output scatter: regression coefficients and first-order indices from one random sample.

The first-order index of an input is Var(E(output | input)) / Var(output): the share of the variance that would go if
the input were known. Here the conditional mean is a regression on the input, its square and cosines of its rank. The
variance of the regression is that of its fit less what chance alone gives, told from each output and its distance from
the regression of all others: without bias where the noise of the outputs depends on the input, too.

Saltelli et al. 2008, Global Sensitivity Analysis: The Primer, secs. 1.2.5, 1.2.7; Kline, Saggio & Solvsten 2020,
Econometrica 88(5), 1859-1898 (leave-out estimation of variance components).
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import betaincinv

from ..base.results import Floats

CONFIDENCE = 0.95
RESAMPLED = 200
COSINES = 1.3  # times the cube root of the number of drives: functions of an input's rank in its regression
SINGLE = 0.99  # leverage from which a drive alone decides its own fit
DEPENDENT = 1e-8  # of the largest singular value: functions that others hold already
PIECES = 8  # sizes of the sample at which a running quantile is computed


@dataclass(frozen=True)
class Influence:
    """What one parameter contributes.

    Attributes
    ----------
    path : str
        The parameter.
    coefficient, coefficient_error : float
        Standardised regression coefficient and its standard error: by how many standard deviations the output changes
        with one of the parameter, as far as that is linear.
    index, index_error : float
        First-order index and its standard error. In samples of 32 to 2000, 1.96 of them on both sides hold the index
        of linear functions, products and Ishigami's in 90 to 99 % of samples; in more where it is near 0.
    """

    path: str
    coefficient: float
    coefficient_error: float
    index: float
    index_error: float

    @property
    def sentence(self) -> str:
        """Its index in words."""
        return f"{self.path}: first-order index {self.index:.2f} ± {self.index_error:.2f}"


@dataclass(frozen=True)
class Ranking:
    """Parameters by their first-order index, and the share of the variance that a linear model explains (R^2)."""

    rows: tuple[Influence, ...]
    linear_share: float


def ranking(inputs: dict[str, Floats], output: Floats, rng: np.random.Generator) -> Ranking:
    """Rank the inputs (n,) by what they contribute to the variance of the output (n,)."""
    table = np.array(list(inputs.values()))
    coefficients, linear = _regression(table, output)
    repeated = []
    for _ in range(RESAMPLED):
        some = rng.integers(len(output), size=len(output))
        repeated.append(_regression(table[:, some], output[some])[0])
    errors = np.std(np.array(repeated), axis=0, ddof=1)
    rows = [
        Influence(path, float(coefficients[i]), float(errors[i]), *_first_order(table[i], output))
        for i, path in enumerate(inputs)
    ]
    return Ranking(tuple(sorted(rows, key=lambda row: -row.index)), linear)


def _regression(table: Floats, output: Floats) -> tuple[Floats, float]:
    spread = float(np.std(output))
    widths = np.std(table, axis=1, keepdims=True)
    if not spread > 0.0:
        return np.zeros(len(table)), 0.0
    x = (table - np.mean(table, axis=1, keepdims=True)) / np.where(widths > 0.0, widths, 1.0)
    y = (output - np.mean(output)) / spread
    coefficients = np.linalg.lstsq(x.T, y, rcond=None)[0]
    left = y - coefficients @ x
    return coefficients, float(1.0 - np.mean(left * left))


def _first_order(values: Floats, output: Floats) -> tuple[float, float]:
    """First-order index of an input (n,) and its standard error."""
    n, y = len(output), output - np.mean(output)
    variance = float(y @ y) / (n - 1)
    if not variance > 0.0:
        return 0.0, 0.0
    basis = _basis(values)
    fit, leverage = basis @ (basis.T @ y), np.minimum(np.sum(basis * basis, axis=1), SINGLE)
    left = (y - fit) / (1.0 - leverage)  # from the regression on all others
    index = float(fit @ fit - (leverage - 1.0 / n) @ (y * left)) / (n - 1) / variance
    noise = left * left
    linear = y * y * (1.0 - index) - noise
    products = basis.T @ (basis * noise[:, None])
    pairs = float(np.sum(products * products) - np.sum((noise * leverage) ** 2))
    spread = float(np.var(linear)) / max(n - basis.shape[1], 1) + 2.0 * pairs / n**2
    return index, float(np.sqrt(spread)) / variance


def _basis(values: Floats) -> Floats:
    """Orthonormal functions (n, functions) of an input: a constant, itself, its square, cosines of its rank."""
    n = len(values)
    _, places, counts = np.unique(values, return_inverse=True, return_counts=True)
    rank = (np.cumsum(counts) - 0.5 * (counts + 1.0))[places]  # the mean of equal ones
    cosines = np.cos(np.pi * (rank[:, None] + 0.5) / n * np.arange(round(COSINES * n ** (1.0 / 3.0)) + 1))
    x = (values - np.mean(values)) / (np.std(values) or 1.0)
    directions, sizes, _ = np.linalg.svd(np.column_stack([cosines, x, x * x]), full_matrices=False)
    return np.asarray(directions[:, sizes > DEPENDENT * sizes[0]])


@dataclass(frozen=True, eq=False)
class RunningQuantile:
    """Quantiles of growing parts of a sample.

    Attributes
    ----------
    counts : (pieces,) int array
        Sizes of the parts, the last the whole.
    values, errors : (pieces, quantiles) arrays
        Quantiles and their bootstrap standard errors.
    """

    counts: Floats
    values: Floats
    errors: Floats


def running_quantile(sample: Floats, shares: Floats, rng: np.random.Generator) -> RunningQuantile:
    """Quantiles of the first n of a sample for n growing to the whole, with bootstrap standard errors."""
    counts = np.unique(np.geomspace(min(32, len(sample)), len(sample), PIECES).astype(int))
    values = np.array([np.quantile(sample[:n], shares) for n in counts])
    errors = np.array([quantile_errors(sample[:n], shares, rng) for n in counts])
    return RunningQuantile(counts, values, errors)


def quantile_errors(sample: Floats, shares: Floats, rng: np.random.Generator) -> Floats:
    """Bootstrap standard errors (quantiles,) of the quantiles of a sample."""
    n = len(sample)
    again = np.array([np.quantile(sample[rng.integers(n, size=n)], shares) for _ in range(RESAMPLED)])
    return np.asarray(np.std(again, axis=0, ddof=1))


def clopper_pearson(hits: int, count: int) -> tuple[float, float]:
    """Interval of 95 % of a probability of which `count` trials gave `hits`."""
    tail = 0.5 * (1.0 - CONFIDENCE)
    low = 0.0 if hits == 0 else float(betaincinv(hits, count - hits + 1, tail))
    high = 1.0 if hits == count else float(betaincinv(hits + 1, count - hits, 1.0 - tail))
    return low, high
