"""Number of harmonics of a periodic orbit: as many as requested, or enough for every line of the excitation.

A line beyond the last harmonic would be sampled too coarsely and appear at another order, so it is refused.

Half-wave symmetry: a smooth odd law under odd orders lets the second half of a turn be minus the first. The orbits then
have odd harmonics alone, and a curve of them is followed with half the unknowns and samples.
"""

import math
from collections.abc import Callable
from typing import TypeVar

import numpy as np

from ...base.law import is_spring
from ...base.protocols import Balance, Law, System, orders_of
from ...base.quantities import positive_count
from ...base.results import Floats
from ...compile.tree import with_leaf

FEWEST_PER_TURN = 7  # per turn of the base angle
MOST_HARMONICS = 127  # reached automatically
MOST_WITH_CORNERS = 31  # the same for friction and memory: general form, and a series that decays as a power of k
SEARCH_PER_TURN = 15  # of a search for other orbits, per turn
TWISTS = np.geomspace(1e-9, 1e6, 46)  # [rad]
LARGEST_HARMONICS = 1000  # the matrix of the balance has (2 H + 1)^2 entries


Result = TypeVar("Result")


def grown(solve: Callable[[int, float], tuple[Result, float]], h: int, largest: int, aim: float) -> Result:
    """Result with as many harmonics as it takes, from h to at most `largest`.

    Parameters
    ----------
    solve : callable
        `solve(h, aim)`: the result with h harmonics, and its tail (see `truncation`), which nobody compares where the
        aim is infinite; a tail of 0 ends the growth.
    h, largest : int
        Harmonics to begin with, and to end with whatever the tail is: h itself where the caller has chosen them.
    aim : float
        Largest tail of what is negligible.
    """
    while True:
        last = h >= largest
        result, tail = solve(h, math.inf if last else aim)
        if last or tail <= aim:
            return result
        h = min(2 * h + 1, largest)


def most_harmonics(system: System) -> int:
    """Largest number of harmonics that is taken without a request."""
    return MOST_HARMONICS if is_spring(system) else MOST_WITH_CORNERS


def highest_order(system: System) -> int:
    """Highest order of the excitation and the kinematic error on the base angle; 1 where the system does not say."""
    return max((1, *whole_orders(system)))


def whole_orders(system: System) -> tuple[int, ...]:
    """Orders of a system; refuse those that do not repeat with the base angle, as of lines of the output's turn."""
    orders = orders_of(system)
    for order in orders:
        if order != int(order):
            raise ValueError(
                f"the order {order:.6g} is not an integer, so the motion does not repeat with the base angle; take "
                "one on which all orders are whole (for a gear the turn of its output), or integrate with simulate"
            )
    return tuple(map(int, orders))


def starting_harmonics(system: System, harmonics: int | None, period: int, points: int = 1) -> int:
    """Return the number H of harmonics of omega/period to begin with.

    Parameters
    ----------
    system : NamedTuple
        The system, whose highest order H must reach.
    harmonics : int or None
        Number that the caller asks for; None for the automatic choice: 7 per turn, or two more than the highest order.
    period : int
        Turns of the base angle per orbit.
    points : int
        Points of a curve, checked here with the others.

    Raises
    ------
    ValueError
        If one of them or an order is not an integer of at least 1, or H is too small for the highest order or above
        1000.
    """
    period = positive_count("period", period, LARGEST_HARMONICS)
    positive_count("points", points)
    highest = highest_order(system)
    if harmonics is None:
        count = period * max(FEWEST_PER_TURN, highest + 2 if highest > 1 else 1)
        if count > LARGEST_HARMONICS:
            raise ValueError(
                f"a line of order {highest} over {period} turns takes {count} harmonics; at most {LARGEST_HARMONICS} "
                "are possible: leave the line out, or integrate"
            )
        return count
    if positive_count("harmonics", harmonics, LARGEST_HARMONICS) < highest * period:
        raise ValueError(
            f"harmonics is {harmonics}, but a line of order {highest} is harmonic {highest * period} of the orbit; "
            f"take at least {highest * period}, or leave the choice open"
        )
    return int(harmonics)


def seems_odd(law: Law, *series: Floats) -> bool:
    """True for a law that is odd at torsions of all sizes, with series (in blocks) of odd harmonics alone.

    `is_odd_on` checks the law on the orbits found.
    """
    with np.errstate(all="ignore"):
        odd = _odd(law.torque(TWISTS), law.torque(-TWISTS))
    return odd and all(map(_is_odd_series, series))


def mirrored(point: Floats) -> Floats:
    """The motion -u(phase - pi) of a point (all coefficients in blocks, parameter last): its even harmonics turn."""
    h = len(point) // 2 - 1
    sign = np.where(np.arange(h + 1) % 2 == 1, 1.0, -1.0)
    return np.asarray(point * np.concatenate([sign, sign[1:], [1.0]]))


def is_odd_on(problem: Balance, points: Floats) -> bool:
    """True for a law that is odd at the torsions of the orbits found (coefficients in blocks, parameter last)."""
    some = points[::3]  # neighbours have next to the same torsions
    u = some[:, :-1] @ problem.synthesis
    law = with_leaf(problem.system, problem.leaf, some[:, -1:]).law
    return _odd(law.torque(u), law.torque(-u))


def _is_odd_series(series: Floats) -> bool:
    """True if the mean and the even harmonics are rounding."""
    h, sizes = len(series) // 2, [abs(value) for value in series.tolist()]
    return bool(max(sizes[:1] + sizes[2 : h + 1 : 2] + sizes[h + 2 :: 2]) <= 1e-14 * max(sizes))


def _odd(forth: Floats, back: Floats) -> bool:
    return not np.any(np.abs(forth + back) > 1e-12 * np.abs(forth))
