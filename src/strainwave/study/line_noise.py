"""Noise around the lines of a scan: periodogram of the residual, its local floor, and what noise alone can reach.

P(q) = |2/n sum r exp(-i q theta)|^2 is the squared amplitude of a line of order q in the residual r; for white noise of
variance s^2 its mean is 4 s^2/n, exponentially distributed.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..results import Floats

NEIGHBOURS = 64  # independent frequencies from which the noise at an order is estimated
FEWEST = 12
PASSES = 20
STRONG = 0.1  # lines of at least this share of the strongest one's power are taken in one pass
SCATTER = math.pi**2 / 6.0  # variance of the logarithm of an exponential value
CUT = 3.0  # a logarithm that stands so far above the median is a line
EVEN = 1e-6  # of a step: angles that deviate less are equidistant
ROUNDED = 1.5  # a residual of at most so many times the variance of rounding has no lines
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
    highest : int
        Highest order looked at.
    samples : int
        Samples behind the periodogram.
    least : float
        P of rounding errors, below which nothing is noise or line.
    """

    def __init__(self, orders: Floats, powers: Floats, highest: int, samples: int, least: float) -> None:
        self.orders, self.highest, self.samples = orders, highest, samples
        # The mean logarithm of an exponential value lies Euler's constant below that of its mean.
        self.logarithms = np.log(np.maximum(powers, max(least, 1e-300))) + np.euler_gamma
        self.enough = len(orders) >= FEWEST

    def estimate(self, order: float) -> tuple[float, float]:
        """Mean of P at an order, and how many exponential values it is worth.

        A straight line through the logarithms of its neighbours, because noise falls with the order more often than not
        and low orders have neighbours on one side alone; lines that were not fitted are cut down first.
        """
        first = int(np.searchsorted(self.orders, order)) - NEIGHBOURS // 2
        first = max(0, min(first, len(self.orders) - NEIGHBOURS))
        x = self.orders[first : first + NEIGHBOURS] - order
        y = self.logarithms[first : first + NEIGHBOURS]
        if len(x) < FEWEST:
            return (math.exp(float(np.mean(y))), float(len(x)) / SCATTER) if len(x) else (math.inf, 1.0)
        y = np.minimum(y, np.median(y) + CUT)
        middle = float(np.mean(x))
        spread = float(np.sum((x - middle) ** 2))
        slope = float(np.sum((x - middle) * y)) / spread
        lever = 1.0 / len(x) + middle * middle / spread
        return math.exp(float(np.mean(y)) - slope * middle), 1.0 / (SCATTER * lever)

    def variance(self, order: float) -> float:
        """Variance s^2 of the white noise that has the residual's mean P around an order."""
        return 0.25 * self.samples * self.estimate(order)[0]

    def false_alarm(self, order: int, squared: float, trials: int) -> float:
        """Probability that noise makes a line of this squared amplitude at one of so many orders."""
        mean, freedom = self.estimate(order)
        return probability(squared / mean, freedom, trials)

    def threshold(self, false_alarm: float, trials: int) -> float:
        """Amplitude that noise exceeds at one of so many orders with the given probability: its median."""
        single = -math.expm1(math.log1p(-false_alarm) / trials)
        looked_at = np.linspace(1, self.highest, min(50, self.highest))
        levels = [
            mean * freedom * (single ** (-1.0 / freedom) - 1.0) for mean, freedom in map(self.estimate, looked_at)
        ]
        return math.sqrt(float(np.median(levels)))


def noise_floor(runs: Sequence[Any], highest: int, lines: Sequence[int], least: float) -> Floor:
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
    return Floor(orders[free], powers[free], highest, samples, 4.0 * least / samples)


def probability(ratio: float, freedom: float, trials: int) -> float:
    """Probability that noise exceeds `ratio` times its estimated mean at one of so many orders."""
    single = math.exp(-freedom * math.log1p(ratio / freedom))
    return -math.expm1(trials * math.log1p(-min(single, 1.0 - 1e-16)))


def found_orders(
    residual: Callable[[Sequence[int]], list[Any]], highest: int, false_alarm: float, least: float
) -> list[int]:
    """Orders whose power noise alone would reach with a probability below `false_alarm`, over all orders.

    Parameters
    ----------
    residual : callable
        Gives the (angle, residual) of every direction after fitting the orders passed to it.
    highest : int
        Highest order looked at.
    least : float
        Variance of rounding.
    """
    chosen: list[int] = []
    for _ in range(PASSES):
        runs = residual(chosen)
        if sum(float(r @ r) for _, r in runs) <= ROUNDED * least * sum(len(r) for _, r in runs):
            break
        floor = noise_floor(runs, highest, chosen, least)
        P = power(runs, 1.0, highest)
        P[np.array(chosen, int) - 1] = 0.0
        hits = [
            k for k in range(1, highest + 1)
            if P[k - 1] > 0.0 and floor.false_alarm(k, float(P[k - 1]), highest) < false_alarm
        ]  # fmt: skip
        strongest = max((P[k - 1] for k in hits), default=0.0)
        hits = [k for k in hits if P[k - 1] >= STRONG * strongest]
        if not hits:
            break
        chosen = sorted([*chosen, *hits])
    return chosen
