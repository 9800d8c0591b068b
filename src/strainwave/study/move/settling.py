"""When the load has settled: from when on its pointing error stays within a window of that at rest."""

import numpy as np

from .quintic import Quintic

WITHIN = 8  # places in a step at which the error is looked at
HALVINGS = 60


def settling(error: Quintic, rest: float, window: float, begin: float, end: float) -> float | None:
    """Time [s] after `begin` from which on |error - rest| stays within the window until `end`; None if it does not.

    Parameters
    ----------
    error : Quintic
        Pointing error [rad] over the time [s].
    rest : float
        Where it comes to rest [rad].
    window : float
        Largest distance from there [rad].
    begin, end : float
        End of the motion, and begin of the next or end of what is known [s].
    """
    first = int(np.searchsorted(error.begin, begin, side="right")) - 1
    last = int(np.searchsorted(error.begin, end, side="left"))
    steps = np.arange(max(first, 0), last)
    shares = np.linspace(0.0, 1.0, WITHIN + 2)
    which, s = np.repeat(steps, len(shares)), np.tile(shares, len(steps))
    t = error.begin[which] + s * error.length[which]
    off = np.abs(error.of_share(s, which) - rest) - window
    outside = np.flatnonzero((off > 0.0) & (t >= begin) & (t <= end))
    if not len(outside):
        return 0.0
    at = int(outside[-1])
    if at + 1 == len(t) or t[at + 1] > end:
        return None
    return _crossing(error, rest, window, float(t[at]), float(t[at + 1])) - begin


def _crossing(error: Quintic, rest: float, window: float, low: float, high: float) -> float:
    """Time [s] between two at which the error enters the window, by bisection."""
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if abs(float(error.at(np.array([middle]))[0]) - rest) > window:
            low = middle
        else:
            high = middle
    return high
