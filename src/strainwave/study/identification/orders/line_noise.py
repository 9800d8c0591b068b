"""Noise around the lines of a scan: periodogram of the residual, its local floor, and what noise alone can reach.

P(q) = |2/n sum r exp(-i q theta)|^2 is the squared amplitude of a line of order q in the residual r; for white noise of
variance s^2 its mean is 4 s^2/n, exponentially distributed.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....base.results import Floats

NEIGHBOURS = 64  # independent frequencies from which the noise at an order is estimated
FEWEST = 12
SCATTER = math.pi**2 / 6.0  # variance of the logarithm of an exponential value
CUT = 3.0  # a logarithm that stands so far above the median is a line
EVEN = 1e-6  # of a step: angles that deviate less are equidistant
BEND = 5.0  # spacings
CLOSE = 1.5  # frequencies nearer than so many spacings to a fitted line are no noise


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


def _sums(angle: Floats, residual: Floats, spacing: float, count: int) -> NDArray[np.complex128]:
    """Sums of residual exp(-i q (angle - first angle)) at q = spacing, 2 spacing, ...; by FFT where the grid allows."""
    n = len(angle)
    step = float(angle[-1] - angle[0]) / (n - 1)
    stride = spacing * step * n / (2.0 * math.pi)
    even = float(np.max(np.abs(angle - angle[0] - step * np.arange(n)))) < EVEN * step
    if even and abs(stride - round(stride)) < EVEN / count:
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
        self.enough = len(orders) >= FEWEST

    def estimates(self, sought: Any) -> tuple[Floats, Floats]:
        """Means (n,) of P at orders (n,) for a decision, and how many exponential values they are worth.

        The larger of two: of the straight lines over the order, and over the logarithm of the frequency, counted from
        `BEND` spacings on. Noise that falls within the lowest orders is far above the first, which would call it lines.
        """
        by_order, by_logarithm = self._means(sought, lambda x: x), self._means(sought, self._logarithm)
        larger = by_logarithm[0] > by_order[0]
        return np.where(larger, by_logarithm[0], by_order[0]), np.where(larger, by_logarithm[1], by_order[1])

    def variance(self, order: float) -> float:
        """Variance s^2 of the white noise that has the residual's mean P around an order."""
        return 0.25 * self.samples * float(self._means(order, lambda x: x)[0][0])

    def _logarithm(self, orders: Floats) -> Floats:
        return np.log(orders / self.spacing + BEND)

    def _means(self, sought: Any, place: Callable[[Floats], Floats]) -> tuple[Floats, Floats]:
        """`estimates` by straight lines through the logarithms of P at the neighbours, over a `place` of the order.

        Noise falls with the order more often than not, and low orders have neighbours on one side alone; lines that
        were not fitted are cut down first.
        """
        sought = np.atleast_1d(np.asarray(sought, float))
        count = min(NEIGHBOURS, len(self.orders))
        if not self.enough:
            mean = math.exp(float(np.mean(self.logarithms))) if count else math.inf
            return np.full(len(sought), mean), np.full(len(sought), count / SCATTER if count else 1.0)
        first = np.clip(np.searchsorted(self.orders, sought) - NEIGHBOURS // 2, 0, len(self.orders) - count)
        near = first[:, None] + np.arange(count)
        x, y = place(self.orders)[near] - place(sought)[:, None], self.logarithms[near]
        y = np.minimum(y, np.median(y, axis=1, keepdims=True) + CUT)
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
        free &= np.abs(orders - line) > min(CLOSE * spacing, 0.5) - 1e-6
    return Floor(orders[free], powers[free], spacing, highest, samples, 4.0 * least / samples)


def probability(ratio: float, freedom: float, trials: int) -> float:
    """Probability that noise exceeds `ratio` times its estimated mean at one of so many orders."""
    single = math.exp(-freedom * math.log1p(ratio / freedom))
    return -math.expm1(trials * math.log1p(-min(single, 1.0 - 1e-16)))
