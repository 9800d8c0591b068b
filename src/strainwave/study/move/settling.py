"""Settling of the load: the time from which on its pointing error stays within a window of that at rest.

Values between the samples of a motion come from its values, rates and second derivatives (quintic Hermite).
"""

from typing import NamedTuple

import numpy as np
from numpy.polynomial.polynomial import polyval

from ...base.results import Floats, Integers
from ...numerics.roots import bracketed_root

STEP_TIMES = 8  # times in a step at which the error is computed


class Quintic(NamedTuple):
    """Polynomials of degree 5 of a share s from 0 to 1, one for each step (m,), with the steps' begins and lengths."""

    begin: Floats
    length: Floats
    coefficients: Floats  # (6, m), the constant first

    @classmethod
    def through(cls, t: Floats, p: Floats, v: Floats, a: Floats, steps: Integers) -> "Quintic":
        """Through samples (n,) of a value, its rate and its second derivative, over the steps that begin at `steps`."""
        i, j = steps, steps + 1
        h = t[j] - t[i]
        c0, c1, c2 = p[i], h * v[i], 0.5 * h * h * a[i]
        rise, slope, bend = p[j] - c0 - c1 - c2, h * v[j] - c1 - 2.0 * c2, h * h * a[j] - 2.0 * c2
        c3 = 10.0 * rise - 4.0 * slope + 0.5 * bend
        c4 = -15.0 * rise + 7.0 * slope - bend
        return cls(t[i], h, np.array([c0, c1, c2, c3, c4, 6.0 * rise - 3.0 * slope + 0.5 * bend]))

    def of_share(self, s: Floats, which: Integers) -> Floats:
        """Values at shares of steps number `which`."""
        return np.asarray(polyval(s, self.coefficients[:, which], tensor=False))

    def dense(self, each: int) -> Floats:
        """Times [s] with so many equal parts in each step, ascending."""
        return np.asarray((self.begin[:, None] + np.arange(each) / each * self.length[:, None]).ravel())

    def values(self, t: Floats) -> Floats:
        """Values at times (m,) [s] within the steps."""
        which = np.clip(np.searchsorted(self.begin, t, side="right") - 1, 0, len(self.begin) - 1)
        return self.of_share((t - self.begin[which]) / self.length[which], which)


def settling(error: Quintic, final: float, window: float, begin: float, end: float) -> float | None:
    """Time [s] after `begin` from which on |error - rest| stays within the window until `end`; None if it does not.

    Parameters
    ----------
    error : Quintic
        Pointing error [rad] over the time [s].
    final : float
        Error at rest [rad].
    window : float
        Largest distance from it [rad].
    begin, end : float
        End of the motion, and begin of the next or end of what is known [s].
    """
    first = int(np.searchsorted(error.begin, begin, side="right")) - 1
    steps = np.arange(max(first, 0), int(np.searchsorted(error.begin, end, side="left")))
    shares = np.linspace(0.0, 1.0, STEP_TIMES + 2)
    k, s = np.repeat(steps, len(shares)), np.tile(shares, len(steps))
    t = error.begin[k] + s * error.length[k]
    off = np.abs(error.of_share(s, k) - final) - window
    outside = np.flatnonzero((off > 0.0) & (t >= begin) & (t <= end))
    if not len(outside):
        return 0.0
    i = int(outside[-1])
    if i + 1 == len(t) or t[i + 1] > end:
        return None

    def beyond(time: float) -> float:
        return abs(float(error.values(np.array([time]))[0]) - final) - window

    last, inside = float(t[i]), float(t[i + 1])
    if not beyond(last) > 0.0 >= beyond(inside):  # both at the bound of a step, where they differ by rounding
        return inside - begin
    return bracketed_root(beyond, last, inside, xtol=0.0) - begin
