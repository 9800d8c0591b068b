"""What `variability` returns, and which input makes its output scatter: first-order indices from one random sample.

The first-order index of an input is Var(E(output | input)) / Var(output): the share of the variance that would go if
the input were known. Here the conditional mean is a regression on the input, its square and cosines of its share. The
variance of the regression is that of its fit less what chance alone gives, told from each output and its distance from
the regression of all others: without bias where the noise of the outputs depends on the input, too.

Saltelli et al. 2008, Global Sensitivity Analysis: The Primer, secs. 1.2.5, 1.2.7; Kline, Saggio & Solvsten 2020,
Econometrica 88(5), 1859-1898 (leave-out estimation of variance components).
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.special import betaincinv, ndtr

from ..base.results import Floats
from ..base.sentences import on_screen

CONFIDENCE = 0.95
RESAMPLED = 200
COSINES = 1.3  # times the cube root of the number of drives: functions of an input's share in its regression
SINGLE = 0.99  # leverage from which a drive alone decides its own fit
LIKELY = 1.36  # over sqrt(n): distance from the ranks that a known distribution exceeds in 5 % of samples
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
    again = (rng.integers(len(output), size=len(output)) for _ in range(RESAMPLED))
    errors = np.std([_regression(table[:, some], output[some])[0] for some in again], axis=0, ddof=1)
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
    """Orthonormal functions (n, functions) of an input: a constant, itself, its square, cosines of its share."""
    n, x = len(values), (values - np.mean(values)) / (np.std(values) or 1.0)
    _, places, counts = np.unique(values, return_inverse=True, return_counts=True)
    share = (np.cumsum(counts) - 0.5 * counts)[places] / n  # by rank: the mean of equal ones
    even = 0.5 / n + (1.0 - 1.0 / n) * (values - np.min(values)) / (np.ptp(values) or 1.0)
    smooth = min(even, ndtr(x), key=lambda one: float(np.max(np.abs(one - share))))
    likely = np.max(np.abs(smooth - share)) < LIKELY / np.sqrt(n)
    share = smooth if likely else share  # ranks scatter, which blurs the higher cosines
    cosines = np.cos(np.pi * share[:, None] * np.arange(round(COSINES * n ** (1.0 / 3.0)) + 1))
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
    return low, (1.0 if hits == count else float(betaincinv(hits + 1, count - hits, 1.0 - tail)))


@dataclass(frozen=True, eq=False)
class SpeedSpread:
    """Peak errors at one speed.

    Attributes
    ----------
    omega : float
        Base speed [rad/s] (of the nominal drive, where omega itself varies).
    shares : (quantiles,) array
        Shares of the drives.
    peak : (drives,) array
        Peak error [rad] of every drive; nan where its motion left every bound.
    running : RunningQuantile
        Quantiles of the peak error [rad] of growing parts of the sample: what more drives would still change.
    ranking : Ranking
        The parameters by what they contribute to the variance of the peak error.
    diverged, unsettled : int
        Drives that left every bound, and bounded drives whose motion did not settle (their peak is that of the last 8
        turns).
    """

    omega: float
    shares: Floats
    peak: Floats
    running: RunningQuantile
    ranking: Ranking
    diverged: int
    unsettled: int

    @property
    def quantiles(self) -> Floats:
        """Quantiles of the peak error [rad] among the drives that stay bounded."""
        return np.asarray(self.running.values[-1])

    @property
    def errors(self) -> Floats:
        """Their standard errors [rad] (bootstrap)."""
        return np.asarray(self.running.errors[-1])

    def __str__(self) -> str:
        return "\n".join(line[2:] for line in _speed_lines(self))

    __repr__ = __str__


@dataclass(frozen=True, eq=False)
class JumpSpread:
    """Jump speeds [rad/s] of the drives whose response was followed; nan where there is no jump.

    Attributes
    ----------
    span : (float, float)
        Range of omega [rad/s].
    shares : (quantiles,) array
        Shares of the drives that jump.
    up, down : (followed,) arrays
        Where the peak jumps up and where it drops; of several hysteresis bands in that with the largest jump.
    failed : int
        Drives whose curve could not be followed or has no stable orbit.
    """

    span: tuple[float, float]
    shares: Floats
    up: Floats
    down: Floats
    failed: int

    def __str__(self) -> str:
        return "\n".join(line[2:] for line in _jump_lines(self))

    __repr__ = __str__

    def quantiles(self) -> tuple[Floats, Floats]:
        """Quantiles of the speeds of the jumps up and down; nan where no drive jumps."""
        return self._of_both(1, np.quantile)

    def errors(self) -> tuple[Floats, Floats]:
        """Their standard errors (bootstrap); nan where fewer than two drives jump."""
        return self._of_both(2, partial(quantile_errors, rng=np.random.default_rng(0)))

    def _of_both(self, least: int, number_of: Callable[[Floats, Floats], Any]) -> tuple[Floats, Floats]:
        """What a function says of the speeds of either jump and the shares; nan where too few drives jump."""
        none = np.full(len(self.shares), np.nan)
        up, down = self.up[np.isfinite(self.up)], self.down[np.isfinite(self.down)]
        of_up = np.asarray(number_of(up, self.shares)) if len(up) >= least else none
        return of_up, np.asarray(number_of(down, self.shares)) if len(down) >= least else none


@dataclass(frozen=True, eq=False)
class Band:
    """Resonances in a range of speed.

    Attributes
    ----------
    low, high : float
        Range of omega [rad/s].
    amplitude : float
        Amplitude [rad] at which the natural frequency is taken; 0: small vibrations.
    natural : (drives,) array
        Natural frequencies [rad/s]; nan where nothing restores, or where the law does not carry the mean torque.
    inside : dict of int to (drives,) bool array
        Order of the excitation to whether its line meets the natural frequency in the range.
    """

    low: float
    high: float
    amplitude: float
    natural: Floats
    inside: dict[int, NDArray[np.bool_]]

    @property
    def without(self) -> int:
        """How many drives have no natural frequency; the probabilities count them as drives without a resonance."""
        return int(np.count_nonzero(np.isnan(self.natural)))

    def __str__(self) -> str:
        p, error = self.probability()
        each = ", ".join(f"order {k}: {self.probability(k)[0]:.4f}" for k in self.inside)
        return f"resonance at {self.low:g} .. {self.high:g} rad/s: probability {p:.4f} +- {error:.4f} ({each})"

    __repr__ = __str__

    def probability(self, order: int | None = None) -> tuple[float, float]:
        """Probability of a resonance in the range with one order, or with any, and its standard error."""
        if order is None:
            hit = np.any([np.zeros(len(self.natural), bool), *self.inside.values()], axis=0)
        else:
            hit = self.inside[order]
        p = float(np.mean(hit))
        return p, float(np.sqrt(p * (1.0 - p) / len(hit)))


@dataclass(frozen=True, eq=False)
class Variability:
    """How a drive's behaviour scatters with its parameters.

    Attributes
    ----------
    drives : dict of str to (drives,) array
        Path of every varied parameter to its values; of parameters that vary together, their paths with " & " between
        them to the factor.
    speeds : tuple of SpeedSpread
        One for every speed.
    jumps : JumpSpread or None
        Jump speeds, if requested.
    band : Band or None
        Resonances in the range of speed, if requested.
    seed : int
        With which the drives were drawn.
    """

    drives: dict[str, Floats]
    speeds: tuple[SpeedSpread, ...]
    jumps: JumpSpread | None
    band: Band | None
    seed: int

    def dataset(self) -> xr.Dataset:
        """Parameters and peaks over (speed, drive), quantiles over (speed, quantile), ranking over (speed, path)."""
        data = xr.Dataset(
            coords={
                "speed": ("speed", [s.omega for s in self.speeds], {"units": "rad/s"}),
                "quantile": self.speeds[0].shares,
                "path": list(self.drives),
            },
            attrs={"seed": self.seed},
        )
        for path, values in self.drives.items():
            data[path] = ("drive", values)
        data["peak"] = (("speed", "drive"), np.array([s.peak for s in self.speeds]), {"units": "rad"})
        data["peak_quantile"] = (("speed", "quantile"), np.array([s.quantiles for s in self.speeds]), {"units": "rad"})
        data["peak_quantile_error"] = (("speed", "quantile"), np.array([s.errors for s in self.speeds]))
        for name in ("coefficient", "coefficient_error", "index", "index_error"):
            rows = [{row.path: getattr(row, name) for row in s.ranking.rows} for s in self.speeds]
            data[name] = (("speed", "path"), np.array([[row[path] for path in self.drives] for row in rows]))
        data["diverged"] = ("speed", [s.diverged for s in self.speeds])
        data["unsettled"] = ("speed", [s.unsettled for s in self.speeds])
        if self.jumps is not None:
            data["jump_up"] = ("followed", self.jumps.up, {"units": "rad/s"})
            data["jump_down"] = ("followed", self.jumps.down, {"units": "rad/s"})
        if self.band is not None:
            data["natural_frequency"] = ("drive", self.band.natural, {"units": "rad/s"})
        return data

    def __str__(self) -> str:
        count = len(next(iter(self.drives.values())))
        lines = [f"Variability: {count} drives, {len(self.drives)} parameters vary, seed {self.seed}"]
        for spread in self.speeds:
            lines += _speed_lines(spread)
        if self.jumps is not None:
            lines += _jump_lines(self.jumps)
        if self.band is not None:
            lines.append(f"  {self.band}")
            if self.band.without:
                lines.append(
                    f"    {self.band.without} drives have no natural frequency and count as without resonance: their "
                    "law does not carry the mean torque, or has no stiffness there"
                )
        return on_screen("\n".join(lines))

    __repr__ = __str__


def _speed_lines(spread: SpeedSpread) -> Iterator[str]:
    values = ", ".join(
        f"{q:.0%}: {v:.5g} +- {e:.1g}" for q, v, e in zip(spread.shares, spread.quantiles, spread.errors, strict=True)
    )
    yield f"  at {spread.omega:g} rad/s, peak |x| [rad] {values}"
    if spread.diverged or spread.unsettled:
        yield f"    {spread.diverged} drives left every bound, {spread.unsettled} did not settle"
    for row in spread.ranking.rows:
        yield (
            f"    {row.path}: {row.index:.3f} +- {row.index_error:.3f} of the variance, regression "
            f"{row.coefficient:+.3f} +- {row.coefficient_error:.3f}"
        )
    yield f"    a linear model explains {spread.ranking.linear_share:.3f} of the variance"


def _jump_lines(spread: JumpSpread) -> Iterator[str]:
    n = len(spread.up)
    ways = zip(("up", "down"), (spread.up, spread.down), spread.quantiles(), spread.errors(), strict=True)
    for name, values, quantiles, errors in ways:
        jumping = int(np.count_nonzero(np.isfinite(values)))
        text = ", ".join(
            f"{q:.0%}: {v:.6g}" + (f" +- {e:.1g}" if np.isfinite(e) else "")
            for q, v, e in zip(spread.shares, quantiles, errors, strict=True)
        )
        yield f"  jump {name}: {jumping} of {n} drives{', at [rad/s] ' + text if jumping else ''}"
    if spread.failed:
        yield f"  {spread.failed} of {n} response curves could not be used"
