"""Bands of speed: where sizes along a curve or a run are above a level."""

from math import ceil, inf, sqrt
from typing import Any, NamedTuple

import numpy as np

from ...base.law import depends
from ...base.protocols import orders_of
from ...base.results import Floats
from ...base.series import largest_of_samples
from .intervals import Span
from .resonances import OperatingPoint

HALF_POWER = sqrt(0.5)
PER_ORDER, BEAT_TURNS, BEAT_STARTS = 64, 500, 192  # places in a cycle of an order; turns in one of which lines meet
AMPLIFIED = 2.0  # times the error of quasi-static rotation, from which on a peak is one


class Motions(NamedTuple):
    """Motions in the order of a curve or a sweep: speeds, oscillations, and whether each is joined to the next."""

    omega: Floats
    sizes: Floats
    joined: Any

    def run(self, i: int, level: float) -> tuple[int, int]:
        """First and last of the motions around number i that are above a level."""
        low = np.flatnonzero(self.sizes[:i] <= level)
        high = np.flatnonzero(self.sizes[i:] <= level)
        return int(low[-1]) + 1 if len(low) else 0, i + int(high[0]) - 1 if len(high) else len(self.sizes) - 1

    def band(self, first: int, last: int, level: float) -> Span:
        """Span between which such a run lies, its ends by linear interpolation."""
        ends = [*self.omega[first : last + 1]]
        for inside, outside in ((first, first - 1), (last, last + 1)):
            if 0 <= outside < len(self.omega) and self.joined[min(inside, outside)]:
                share = (self.sizes[inside] - level) / (self.sizes[inside] - self.sizes[outside])
                ends.append(self.omega[inside] + share * (self.omega[outside] - self.omega[inside]))
        return float(min(ends)), float(max(ends))

    def above(self, level: float) -> list[Span]:
        """Bands of all motions above a level."""
        bands, i = [], 0
        while i < len(self.omega):
            if self.sizes[i] > level:
                first, i = self.run(i, level)
                bands.append(self.band(first, i, level))
            i += 1
        return bands

    def peaks(self, least: float) -> list[int]:
        """Numbers of those above `least` that are the largest in their half-power band."""
        padded = np.concatenate([[-np.inf], self.sizes, [-np.inf]])
        high = (self.sizes > least) & (self.sizes >= padded[:-2]) & (self.sizes > padded[2:])
        return [int(i) for i in np.flatnonzero(high) if self.sizes[i] == self._highest(int(i))]

    def _highest(self, i: int) -> float:
        first, last = self.run(i, HALF_POWER * self.sizes[i])
        return float(np.max(self.sizes[first : last + 1]))


def quasi_static(system: Any, point: OperatingPoint) -> float:
    """Oscillation [rad] of a drive that follows its excitation without inertia; of a beat in its largest turn."""
    orders = tuple(orders_of(system))
    count, beats = PER_ORDER * ceil(max((1, *orders))), any(order % 1 for order in orders)
    angles = 2.0 * np.pi * np.arange(BEAT_TURNS * count if beats else count) / count
    twist = (system.excitation.torque(angles) - point.mean_torque) / (point.stiffness if point.stiffness > 0.0 else inf)
    error = system.error.value(angles) + twist + 0.0 * angles
    if not beats:
        return float(largest_of_samples((error - np.mean(error))[None])[0])
    sums, step = np.append(0.0, np.cumsum(error)), max(1, count // BEAT_STARTS)
    means = (sums[count:-1] - sums[: -count - 1] + 0.5 * (error[count:] - error[:-count])) / count
    turns, mean = np.lib.stride_tricks.sliding_window_view(error, count + 1), means[::step]
    worst = step * int(np.argmax(np.maximum(turns[::step].max(axis=1) - mean, mean - turns[::step].min(axis=1))))
    return float(largest_of_samples((turns[worst] - means[worst])[None])[0])


def searched(law: Any) -> bool:
    """True if motions apart from a torque's curve are looked for: with memory or a gap that takes most of the time."""
    return depends(law) == 1 and bool(law.stiffness(0.0) > 0.0)
