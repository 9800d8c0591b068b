"""Size along a curve of motions or a run: bands of speed in which it is above a level, and its peaks."""

from math import sqrt
from typing import NamedTuple

import numpy as np

from ...base.results import Booleans, Floats
from .intervals import Span

HALF_POWER = sqrt(0.5)  # of a peak: the ends of its half-power band


class SizeCurve(NamedTuple):
    """Sizes of motions in the order of a curve or a sweep.

    Attributes
    ----------
    omega : (n,) array
        Speeds of the base angle [rad/s].
    sizes : (n,) array
        Oscillation [rad], or another quantity with a level.
    joined : (n,) or (n - 1,) bool array
        True where a motion is joined to the next one: the size between them is linear.
    """

    omega: Floats
    sizes: Floats
    joined: Booleans

    def run(self, i: int, level: float) -> tuple[int, int]:
        """First and last number of the motions around number i that are above a level."""
        low = np.flatnonzero(self.sizes[:i] <= level)
        high = np.flatnonzero(self.sizes[i:] <= level)
        return int(low[-1]) + 1 if len(low) else 0, i + int(high[0]) - 1 if len(high) else len(self.sizes) - 1

    def band(self, first: int, last: int, level: float) -> Span:
        """Speeds between which the motions from `first` to `last` are above a level, by linear interpolation."""
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
        """Numbers of the motions above `least` that are the largest in their half-power band."""
        padded = np.concatenate([[-np.inf], self.sizes, [-np.inf]])
        high = (self.sizes > least) & (self.sizes >= padded[:-2]) & (self.sizes > padded[2:])
        return [int(i) for i in np.flatnonzero(high) if self.sizes[i] == self._highest(int(i))]

    def _highest(self, i: int) -> float:
        first, last = self.run(i, HALF_POWER * self.sizes[i])
        return float(np.max(self.sizes[first : last + 1]))
