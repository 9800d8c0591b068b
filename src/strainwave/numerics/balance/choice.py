"""Choice of the balance for a system, and the condensed balance of what its laws see."""

from typing import Any

import numpy as np

from ...base.protocols import Balance, Error, System, lacking, linear_part_of, orders_of
from ...base.results import Floats
from .condensed.problem import Condensed, assembled
from .first_order import first_order
from .harmonics import highest_order
from .linear_part import STRENGTH
from .rates import SAME, is_second_order
from .second_order import second_order


def balance_of(
    system: System, leaf: int, omega_leaf: int, harmonics: int, turns: int = 1, folded: bool = True
) -> Balance:  # fmt: skip
    """Balance problem of a system at its own parameters, in as few unknowns as it takes.

    That is the torsion alone where it is J x'' + B u' + T(u) = tau, what the laws see where all else is linear, and all
    states of any other. `folded`: its orbits may be taken to repeat as often in a turn as what drives them.

    Raises
    ------
    TypeError
        If the system has neither those fields nor a method rhs(phase, y).
    """
    if is_second_order(system):
        return second_order(system, leaf, omega_leaf, harmonics, turns)
    if lacking(system, "rhs"):
        raise TypeError(f"{type(system).__name__} has no rhs(phase, y), nor the fields {', '.join(SAME)}")
    problem = condensed(system, leaf, omega_leaf, harmonics, turns, folded)
    return first_order(system, leaf, omega_leaf, harmonics, turns) if problem is None else problem


LOOKED_AT, EQUAL = 64, 1e-9  # places of a turn, and the relative difference of torques that repeat there
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
        True if an orbit may be taken to repeat as often in a turn as what drives it.
    """
    top = highest_order(system)
    part = linear_part_of(system) if leaf in (omega_leaf, STRENGTH) else None
    lines = None if part is None else lines_of_error(part.error)
    if part is None or lines is None:
        return None
    every = repeats(part, top) if folded and turns == 1 else 1
    return assembled(system, part, lines, leaf, omega_leaf, max(1, harmonics // every), turns, every)


def repeats(part: Any, top: int) -> int:
    """Repeats in a turn, at most `top`, of everything that drives a system."""
    angles = 2.0 * np.pi * (np.arange(LOOKED_AT) + 0.3) / LOOKED_AT

    def driving(angles: Floats) -> Floats:
        return np.vstack([part.forces(angles), part.error.value(angles) + 0.0 * angles])

    drive = driving(angles)
    least = EQUAL * np.ptp(drive, axis=1, keepdims=True)
    if not np.any(least):
        return 1
    return max(g for g in range(1, top + 1) if np.all(np.abs(driving(angles + 2.0 * np.pi / g) - drive) <= least))


def lines_of_error(error: Error) -> Floats | None:
    """Rows (order, cosine, sine) of an error of any class, the mean first; None of one that has no end of lines."""
    top = max((1, *orders_of(error))) if orders_of(error) else 128
    samples = max(512, 4 * int(top) + 16)
    angles = 2.0 * np.pi * np.arange(samples) / samples
    waves = 2.0 / samples * np.fft.rfft(error.value(angles) + 0.0 * angles)
    size = np.abs(waves)
    orders = 1 + np.flatnonzero(size[1:-1] > ROUNDING * np.max(size))
    if len(orders) > MOST_LINES or np.any(orders > samples // 4):
        return None
    mean = [0.0, 0.5 * waves[0].real, 0.0]
    return np.array([mean, *([float(k), waves[k].real, -waves[k].imag] for k in orders)])
