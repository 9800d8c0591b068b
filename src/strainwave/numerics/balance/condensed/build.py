"""How a condensed problem is made from a system's linear part."""

from typing import Any

import numpy as np

from ....base.protocols import Error, System, linear_part_of, orders_of
from ....base.results import Floats
from ..harmonics import highest_order
from ..linear_part import STRENGTH
from .problem import Condensed, assembled

LOOKED_AT, SAME = 64, 1e-9  # places of a turn, and the relative difference of torques that repeat there
MOST_LINES, ROUNDING = 64, 1e-14  # of an error, and share of the largest line that is none


def condensed(
    system: System, leaf: int, omega_leaf: int, harmonics: int, turns: int = 1, folded: bool = True
) -> Condensed | None:
    """Build the condensed problem of a system; None where it has no linear part.

    Parameters
    ----------
    system : NamedTuple
        The system, with a method `linear_part()`.
    leaf, omega_leaf : int
        Places of the parameter that varies and of the base frequency; only the frequency and the strength may vary.
    harmonics : int
        Highest harmonic of omega/turns.
    turns : int
        Turns of the base angle that an orbit takes.
    folded : bool
        Whether an orbit may be taken to repeat as often in a turn as what drives it.
    """
    top = highest_order(system)
    part = linear_part_of(system) if leaf in (omega_leaf, STRENGTH) else None
    lines = None if part is None else lines_of_error(part.error)
    if part is None or lines is None:
        return None
    every = repeats(part, top) if folded and turns == 1 else 1
    return assembled(system, part, lines, leaf, omega_leaf, max(1, harmonics // every), turns, every)


def repeats(part: Any, top: int) -> int:
    """How often in a turn, at most `top` times, everything that drives a system repeats."""
    angles = 2.0 * np.pi * (np.arange(LOOKED_AT) + 0.3) / LOOKED_AT

    def driving(angles: Floats) -> Floats:
        return np.vstack([part.forces(angles), part.error.value(angles) + 0.0 * angles])

    here = driving(angles)
    least = SAME * np.ptp(here, axis=1, keepdims=True)
    if not np.any(least):
        return 1
    return max(g for g in range(1, top + 1) if np.all(np.abs(driving(angles + 2.0 * np.pi / g) - here) <= least))


def lines_of_error(error: Error) -> Floats | None:
    """Rows (order, cosine, sine) of an error of any class, the mean first; None of one that has no end of lines."""
    top = max((1, *orders_of(error))) if orders_of(error) else 128
    samples = max(512, 4 * int(top) + 16)
    angles = 2.0 * np.pi * np.arange(samples) / samples
    waves = 2.0 / samples * np.fft.rfft(error.value(angles) + 0.0 * angles)
    size = np.abs(waves)
    found = 1 + np.flatnonzero(size[1:-1] > ROUNDING * np.max(size))
    if len(found) > MOST_LINES or np.any(found > samples // 4):
        return None
    mean = [0.0, 0.5 * waves[0].real, 0.0]
    return np.array([mean, *([float(k), waves[k].real, -waves[k].imag] for k in found)])
