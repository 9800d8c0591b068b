"""Amplitudes of orders in runs at several speeds, each run alone and all with one delay, and the noise around them.

A line is A cos(k theta(t - delay) + phase), the real part of c exp(i k theta(t - delay)), c = A exp(i phase). In a run
at the speed w a delay that is d longer turns c by exp(-i k w d).

Noise is told from the periodogram of the residual, P(q) = |2/n sum r exp(-i q theta)|^2: the squared amplitude of a
line of order q in the residual r; for white noise of variance s^2 its mean is 4 s^2/n, exponentially distributed.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ....base.results import Complexes, Floats
from ..run import Run

NEIGHBOURS = 64  # independent frequencies from which the noise at an order is estimated
FEWEST_NEIGHBOURS = 12
SCATTER = math.pi**2 / 6.0  # variance of the logarithm of an exponential value
LINE_HEIGHT = 3.0  # a logarithm that stands so far above the median is a line
EVEN_SHARE = 1e-6  # of a step: angles that deviate less are equidistant
BEND = 5.0  # spacings
LINE_WIDTH = 1.5  # frequencies nearer than so many spacings to a fitted line are no noise


def correlation(residual: Floats) -> float:
    """Correlation of neighbouring values."""
    power = float(residual @ residual)
    return float(residual[1:] @ residual[:-1]) / power if power > 0.0 else 0.0


def power(runs: Sequence[Any], spacing: float, count: int) -> Floats:
    """P (count,) at the orders spacing, 2 spacing, ...; several directions of rotation add up before squaring.

    Parameters
    ----------
    runs : sequence of (angle, residual)
        Arrays [rad].
    """
    total = np.zeros(count, complex)
    for angle, residual in runs:
        total += _sums(angle, residual, spacing, count) * np.exp(-1j * spacing * np.arange(1, count + 1) * angle[0])
    return np.asarray(np.abs(2.0 / sum(len(angle) for angle, _ in runs) * total) ** 2)


def _sums(angle: Floats, residual: Floats, spacing: float, count: int) -> Complexes:
    """Sums of residual exp(-i q (angle - first angle)) at q = spacing, 2 spacing, ...; by FFT where the grid allows."""
    n = len(angle)
    step = float(angle[-1] - angle[0]) / (n - 1)
    stride = spacing * step * n / (2.0 * math.pi)
    even = float(np.max(np.abs(angle - angle[0] - step * np.arange(n)))) < EVEN_SHARE * step
    if even and abs(stride - round(stride)) < EVEN_SHARE / count:
        return np.asarray(np.fft.fft(residual)[round(stride) * np.arange(1, count + 1) % n])
    turn = np.exp(-1j * spacing * (angle - angle[0]))
    turned = residual.astype(complex)
    sums = np.empty(count, complex)
    for j in range(count):
        turned *= turn
        sums[j] = turned.sum()
    return sums


class Floor:
    """Noise power over the orders.

    Parameters
    ----------
    orders, powers : (n,) arrays
        Independent frequencies without lines, ascending, and P there.
    spacing : float
        Distance of independent frequencies.
    highest : int
        Highest order looked at.
    samples : int
        Samples behind the periodogram.
    least : float
        P of rounding errors, below which nothing is noise or line.
    """

    def __init__(
        self, orders: Floats, powers: Floats, spacing: float, highest: int, samples: int, least: float
    ) -> None:
        self.orders, self.spacing, self.highest, self.samples = orders, spacing, highest, samples
        # The mean logarithm of an exponential value lies Euler's constant below that of its mean.
        self.logarithms = np.log(np.maximum(powers, max(least, 1e-300))) + np.euler_gamma
        self.enough = len(orders) >= FEWEST_NEIGHBOURS

    def estimates(self, sought: Any) -> tuple[Floats, Floats]:
        """Means (n,) of P at orders (n,) for a decision, and how many exponential values they are worth.

        The larger of two: of the straight lines over the order, and over the logarithm of the frequency, counted from
        `BEND` spacings on. Noise that falls within the lowest orders is far above the first, which would call it lines.
        """
        by_order = self._means(sought, lambda x: x)
        by_logarithm = self._means(sought, lambda x: np.log(x / self.spacing + BEND))
        larger = by_logarithm[0] > by_order[0]
        return np.where(larger, by_logarithm[0], by_order[0]), np.where(larger, by_logarithm[1], by_order[1])

    def variance(self, order: float) -> float:
        """Variance s^2 of the white noise that has the residual's mean P around an order."""
        return 0.25 * self.samples * float(self._means(order, lambda x: x)[0][0])

    def _means(self, sought: Any, axis: Callable[[Floats], Floats]) -> tuple[Floats, Floats]:
        """Mean of P at each sought order, and the number of exponential values that it is worth.

        A straight line through log P of the nearest orders, over `axis(order)`: noise falls with the order more often
        than not, and low orders have neighbours on one side alone. Log P is cut off above its median, as lines that
        were not fitted stand out of it. With too few neighbours there is one mean for all.
        """
        sought = np.atleast_1d(np.asarray(sought, float))
        count = min(NEIGHBOURS, len(self.orders))
        if not self.enough:
            mean = math.exp(float(np.mean(self.logarithms))) if count else math.inf
            return np.full(len(sought), mean), np.full(len(sought), count / SCATTER if count else 1.0)
        first = np.clip(np.searchsorted(self.orders, sought) - NEIGHBOURS // 2, 0, len(self.orders) - count)
        neighbours = first[:, None] + np.arange(count)
        x, y = axis(self.orders)[neighbours] - axis(sought)[:, None], self.logarithms[neighbours]
        y = np.minimum(y, np.median(y, axis=1, keepdims=True) + LINE_HEIGHT)
        middle = np.mean(x, axis=1)
        off = x - middle[:, None]
        spread = np.sum(off * off, axis=1)
        slope = np.sum(off * y, axis=1) / spread
        lever = 1.0 / count + middle * middle / spread
        return np.exp(np.mean(y, axis=1) - slope * middle), 1.0 / (SCATTER * lever)

    def threshold(self, false_alarm: float, trials: int) -> float:
        """Amplitude that noise exceeds at one of so many orders with the given probability: its median."""
        single = -math.expm1(math.log1p(-false_alarm) / trials)
        mean, freedom = self.estimates(np.linspace(1, self.highest, min(50, self.highest)))
        return math.sqrt(float(np.median(mean * freedom * (single ** (-1.0 / freedom) - 1.0))))


def noise_floor(runs: Sequence[Any], highest: int, lines: Sequence[float], least: float) -> Floor:
    """Estimate the noise around the orders 1 to `highest` from residuals in which `lines` were fitted.

    `least` is the variance of rounding, below which nothing is noise or line.
    """
    samples = sum(len(angle) for angle, _ in runs)
    n = min(len(angle) for angle, _ in runs)
    reach = min(float(angle[-1] - angle[0]) * len(angle) / (len(angle) - 1) for angle, _ in runs)
    spacing = 2.0 * math.pi / reach
    count = max(1, min(int(highest / spacing) + NEIGHBOURS, (n - 1) // 2))
    orders: Floats = spacing * np.arange(1, count + 1, dtype=float)
    powers = power(runs, spacing, count)
    free = np.ones(count, bool)
    for line in lines:
        free &= np.abs(orders - line) > min(LINE_WIDTH * spacing, 0.5) - 1e-6
    return Floor(orders[free], powers[free], spacing, highest, samples, 4.0 * least / samples)


DELAY_S = 0.02  # s: the largest delay that is looked for
STEP_RAD = 0.3  # rad: of the fastest change of phase between two delays that are tried
ROUNDS = 4
SAME_SPEED = 0.02  # relative difference of two speeds that counts as none
WORST_CONDITION = 1e3  # condition of the columns of a run
ROUNDING = 1e-13  # of the largest value: that of the computer, which is no white noise but repeats with the lines


@dataclass(frozen=True)
class RunFit:
    """Lines of one run.

    Attributes
    ----------
    values : (lines,) complex array
        c of each line.
    spreads : (lines, 2, 2) array
        Covariance of its real and imaginary parts.
    residual : (n,) array
        What is left.
    without_orders : (n,) array
        The value less the lines of the orders alone.
    floor : Floor
        Noise around the orders.
    slow : (m,) array
        Shares of the columns beside the lines.
    inverse : (m + 2 lines, m + 2 lines) array
        (X'X)^-1 of all columns.
    least : float
        Variance of rounding.
    """

    values: Floats
    spreads: Floats
    residual: Floats
    without_orders: Floats
    floor: Floor
    slow: Floats
    inverse: Floats
    least: float

    def block(self, i: int) -> Floats:
        """The part (2, 2) of line i in (X'X)^-1."""
        columns = slice(len(self.slow) + 2 * i, len(self.slow) + 2 * i + 2)
        return self.inverse[columns, columns]

    def amplitude(self, i: int) -> tuple[float, float]:
        """Amplitude of line i, and its standard deviation."""
        return abs(self.values[i]), math.sqrt(0.5 * float(np.trace(self.spreads[i])))


def fit_run(
    run: Run, orders: Sequence[float], delay: float, highest: float, frequencies: Sequence[float] = (),
    loose: Sequence[int] = (),
) -> RunFit:  # fmt: skip
    """Lines of these orders in one run beside lines of these frequencies [Hz], and the noise around them.

    The `loose` ones have places from the run: their spreads hold what these may be off by.
    """
    theta = run.angle_before(delay)
    slow = run.slow_columns(min(orders, default=highest))
    elapsed = run.time - run.time[0]  # a frequency that the slow columns hold is no column of its own
    turns = [2.0 * np.pi * f * elapsed for f in frequencies if 2.0 * f * elapsed[-1] > slow.shape[1]]
    nuisances = np.column_stack([slow, *(wave(x) for x in turns for wave in (np.cos, np.sin))])
    columns = np.column_stack([nuisances, *waves_of(theta, orders)])
    shares, back = solved(run, columns, orders)
    residual = run.value - columns @ shares
    ascending = np.sign(run.travel) * run.angle
    standing = [2.0 * np.pi * f / abs(run.speed) for f in frequencies]
    taken = _taken(run, [*orders, *standing], slow.shape[1], highest)
    inverse, least, first = back @ back.T, rounding(run.value), nuisances.shape[1]
    floor = noise_floor([(ascending, residual)], int(np.ceil(highest)), taken, 0.0)
    if loose:
        inverse = _with_places(columns, shares, theta, [first + 2 * i for i in loose])
    values, spreads = [], []
    for i, k in enumerate(orders):
        pair = slice(first + 2 * i, first + 2 * i + 2)
        values.append(complex(*shares[pair]))
        spreads.append(max(floor.variance(k), least) * inverse[pair, pair])
    remainder = run.value - columns[:, first:] @ shares[first:]
    spread = np.array(spreads).reshape(len(values), 2, 2)
    return RunFit(np.array(values), spread, residual, remainder, floor, shares[:first], inverse, least)


def waves_of(angle: Floats, orders: Sequence[float]) -> list[Floats]:
    """Two columns (n,) of each order, whose shares are the real and the imaginary part of c."""
    return [part for k in orders for part in (np.cos(k * angle), -np.sin(k * angle))]


def solved(run: Run, columns: Floats, orders: Sequence[float]) -> tuple[Floats, Floats]:
    """Shares of the columns in the value of a run by least squares, and R with (X'X)^-1 = R R'."""
    if len(columns) <= columns.shape[1]:
        raise ValueError(
            f"{len(columns)} samples are given for {columns.shape[1]} unknowns (slow parts and two a line); measure "
            "more samples"
        )
    sizes = np.linalg.norm(columns, axis=0)
    u, s, vt = np.linalg.svd(columns / np.where(sizes > 0.0, sizes, 1.0), full_matrices=False)
    if s[0] > WORST_CONDITION * s[-1]:
        raise ValueError(
            f"samples over {run.turns:.3g} turns cannot separate the orders {', '.join(f'{k:g}' for k in orders)}; "
            "take longer runs without gaps in the angle, or fewer orders"
        )
    back = (vt.T / s) / sizes[:, None]
    return back @ (u.T @ run.value), back


def _with_places(columns: Floats, shares: Floats, theta: Floats, begin: Sequence[int]) -> Floats:
    """Inverse normal matrix of the columns beside the derivatives by the orders of lines that begin at some."""
    moved = [theta * (shares[i] * columns[:, i + 1] - shares[i + 1] * columns[:, i]) for i in begin]
    every = np.column_stack([columns, *moved])
    sizes, many = np.linalg.norm(every, axis=0), columns.shape[1]
    inverse = np.linalg.pinv((every / sizes).T @ (every / sizes)) / np.outer(sizes, sizes)
    return np.asarray(inverse[:many, :many])


def _taken(run: Run, orders: Sequence[float], slow: int, highest: float) -> list[float]:
    """Independent orders near which fitted lines, or so many slow columns, leave less than the noise."""
    spacing = (1.0 - 1.0 / len(run.time)) / run.turns
    grid = spacing * np.arange(1, int(1.5 * highest / spacing) + int(0.5 * slow + LINE_WIDTH) + 2)
    beside = np.min([np.abs(grid - k) for k in (*orders, np.inf)], axis=0) <= LINE_WIDTH * spacing
    return [*orders, *grid[beside | (grid <= (0.5 * slow + LINE_WIDTH) * spacing)]]


def rounding(values: Floats) -> float:
    """Variance of rounding to steps, the smallest difference of two values being one, or of the computer's."""
    steps = np.diff(np.unique(values))
    return max(float(np.min(steps)) if len(steps) else 0.0, ROUNDING * float(np.max(np.abs(values)))) ** 2 / 12.0


@dataclass(frozen=True)
class Joint:
    """Lines of all runs with one delay.

    Attributes
    ----------
    values : (lines,) complex array
        c of each line.
    covariance : (2 lines + 1, 2 lines + 1) array
        Of real and imaginary parts, line by line, and last the delay [s].
    delay : float
        [s].
    misfit : float
        Sum of the squares of what single runs differ by, in deviations.
    freedom : int
        How many numbers are behind it.
    """

    values: Floats
    covariance: Floats
    delay: float
    misfit: float
    freedom: int


def fit_together(orders: Floats, speeds: Floats, fits: Sequence[RunFit], delay: float, *, delayed: bool) -> Joint:
    """Lines and the delay behind the lines of several runs, which were fitted with a first delay [s].

    Parameters
    ----------
    orders : (lines,) array
        Orders.
    speeds : (runs,) array
        Mean speeds [rad/s].
    fits : sequence of RunFit
        Of the runs.
    delay : float
        With which they were fitted.
    delayed : bool
        Whether more or less delay is looked for.
    """
    values = np.array([fit.values for fit in fits])  # (runs, lines)
    # (runs, lines, 2, 2): matrices that turn a deviation with this covariance into one of unit size
    roots = np.linalg.inv(np.linalg.cholesky(np.array([fit.spreads for fit in fits])))
    d = _delay(orders, speeds, values, roots) if delayed else 0.0
    for _ in range(20):
        jacobian, residual, means = _linear(orders, speeds, values, roots, d, delayed)
        change = np.linalg.lstsq(jacobian, residual, rcond=None)[0]
        if delayed:
            d += float(change[-1])
        if not delayed or abs(change[-1]) < 1e-12 + 1e-6 * abs(d):
            break
    jacobian, residual, means = _linear(orders, speeds, values, roots, d, delayed)
    lines = 2 * len(orders)
    covariance = np.full((lines + 1, lines + 1), np.inf)
    covariance[: jacobian.shape[1], : jacobian.shape[1]] = np.linalg.pinv(jacobian.T @ jacobian)
    return Joint(means, covariance, delay + d, float(residual @ residual), len(residual) - jacobian.shape[1])


def _weighted(roots: Floats, c: Any) -> Floats:
    """Real and imaginary parts (runs, lines, 2) of numbers (runs, lines), in deviations."""
    return np.asarray(np.einsum("rijk,rik->rij", roots, np.stack([c.real, c.imag], axis=-1)))


def _linear(
    orders: Floats, speeds: Floats, values: Floats, roots: Floats, d: float, delayed: bool
) -> tuple[Floats, Floats, Floats]:  # fmt: skip
    """Derivatives by (lines, delay) and differences, in deviations, at the nearest lines of a delay."""
    (runs, lines), turn = values.shape, np.exp(-1j * orders * speeds[:, None] * d)
    bases = np.stack([_weighted(roots, turn), _weighted(roots, 1j * turn)], axis=-1)
    wanted, jacobian = _weighted(roots, values), np.zeros((runs, lines, 2, 2 * lines + delayed))
    means = np.empty(lines, complex)
    for i in range(lines):
        jacobian[:, i, :, 2 * i : 2 * i + 2] = bases[:, i]
        means[i] = complex(*np.linalg.lstsq(bases[:, i].reshape(-1, 2), wanted[:, i].ravel(), rcond=None)[0])
    if delayed:
        jacobian[..., -1] = _weighted(roots, -1j * orders * speeds[:, None] * turn * means)
    return jacobian.reshape(2 * runs * lines, -1), _weighted(roots, values - means * turn).ravel(), means


def _delay(orders: Floats, speeds: Floats, values: Floats, roots: Floats) -> float:
    """Delay [s], among even ones up to `DELAY_S`, that makes lines (runs, lines) of all runs most alike.

    Each line is turned back by the delay; the power of its weighted mean over the runs, summed over lines, is largest.
    """
    weights = np.linalg.norm(roots, axis=(2, 3)) ** 2 / 2.0
    fastest = float(np.max(np.abs(np.subtract.outer(speeds, speeds)))) * float(np.max(orders))
    tried = np.linspace(-DELAY_S, DELAY_S, 2 * int(min(DELAY_S * fastest / STEP_RAD, 5000)) + 3)
    turned = values[None] * np.exp(1j * tried[:, None, None] * orders[None, None] * speeds[None, :, None])
    total = np.sum(np.abs(np.sum(weights * turned, axis=1)) ** 2 / np.sum(weights, axis=0), axis=1)
    return float(tried[np.argmax(total)])
