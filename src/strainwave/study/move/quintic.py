"""Values between the samples of a motion, from its values, rates and second derivatives: quintic Hermite."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...results import Floats


class Quintic(NamedTuple):
    """Polynomials of degree 5 of a share s from 0 to 1, one for each step (m,), with the steps' begins and lengths."""

    begin: Floats
    length: Floats
    coefficients: Floats  # (6, m), the constant first

    @classmethod
    def through(cls, t: Floats, p: Floats, v: Floats, a: Floats, steps: NDArray[np.int64]) -> "Quintic":
        """Through samples (n,) of a value, its rate and its second derivative, over the steps that begin at `steps`."""
        i, j = steps, steps + 1
        h = t[j] - t[i]
        c0, c1, c2 = p[i], h * v[i], 0.5 * h * h * a[i]
        rise, slope, bend = p[j] - c0 - c1 - c2, h * v[j] - c1 - 2.0 * c2, h * h * a[j] - 2.0 * c2
        c3 = 10.0 * rise - 4.0 * slope + 0.5 * bend
        c4 = -15.0 * rise + 7.0 * slope - bend
        c5 = 6.0 * rise - 3.0 * slope + 0.5 * bend
        return cls(t[i], h, np.array([c0, c1, c2, c3, c4, c5]))

    def of_share(self, s: Floats, which: NDArray[np.int64]) -> Floats:
        """Values at shares of steps number `which`."""
        c = self.coefficients[:, which]
        value = c[5]
        for k in range(4, -1, -1):
            value = value * s + c[k]
        return np.asarray(value)

    def dense(self, each: int) -> Floats:
        """Times [s] with so many equal parts in each step, ascending."""
        return np.asarray((self.begin[:, None] + np.arange(each) / each * self.length[:, None]).ravel())

    def at(self, t: Floats) -> Floats:
        """Values at times (m,) [s] within the steps."""
        which = np.clip(np.searchsorted(self.begin, t, side="right") - 1, 0, len(self.begin) - 1)
        return self.of_share((t - self.begin[which]) / self.length[which], which)
