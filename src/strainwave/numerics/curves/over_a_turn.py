"""The curve of motions that repeat with the base angle: over as small a part of a turn as everything repeats with."""

from dataclasses import replace as with_changes
from typing import Any

import numpy as np

from ...base.law import breakpoints_of
from ...base.protocols import Balance
from ...compile.tree import leaf_of
from ..balance.choice import balance_of
from ..balance.condensed.problem import Condensed
from ..balance.first_order import FirstOrder, first_order
from ..balance.fourier import distances, stretched
from ..balance.harmonics import highest_order
from ..balance.rates import rates_at
from ..balance.truncation import MATTERS, Tail
from ..continuation.trace import Trace
from .response import traced

PER_ORDER, WITH_KINKS = 4, 8  # harmonics to begin with per order of the excitation; and at least, with breakpoints
SPRING, SPRING_WITH_KINKS = 7, 15  # the same of an oscillator; all in all, with breakpoints
MOST_HARMONICS, MOST_OF_SPRING = 64, 63  # at most, or two beyond the highest order
LOOKED_AT, SAME = 12, 1e-9  # places of a turn, and the relative difference of rates that act alike there


def traced_turn(
    system: Any, speeds: tuple[float, float], points: int, fixed: int | None = None, coexisting: bool = True,
    truncation: bool = True,
) -> tuple[Any, Trace, Tail | None, str]:  # fmt: skip
    """Balance problem and points of a curve, with the harmonics that its first state takes, or those given.

    Where motions may be `coexisting` at its ends it passes them, or lists those that it does not.

    What repeats g times in a turn is followed over a g-th of a turn, with a g-th of the unknowns. Of fixed harmonics
    the tail is None without `truncation`: what is left out is not looked at.
    """
    leaf, top = leaf_of(system, "omega"), highest_order(system)
    middle = system._replace(omega=(speeds[0] * speeds[1]) ** 0.5)
    small: Any = balance_of(middle, leaf, leaf, top)
    general = isinstance(small, FirstOrder)
    g = repeats(small, top) if general else top // max(1, small.harmonics())

    def problem_with(h: int) -> Balance:
        if general:
            return first_order(middle, leaf, leaf, max(1, h // g), 1.0 / g)
        if isinstance(small, Condensed):
            return small.with_harmonics(max(1, h // small.every))
        return balance_of(middle, leaf, leaf, h)

    if small.hill():
        harmonics = of_spring(top, bool(breakpoints_of(system)))
    else:
        kinked = len(distances(system, np.zeros(1), np.zeros((small.state_count(), 1)))) > 0
        harmonics = of_drive(top, g, kinked)
    harmonics = harmonics if fixed is None else (fixed, fixed)
    left = (lambda t: t.share if general or small.hill() else t.worst) if truncation else None
    problem, curve, tail, origin = traced(
        problem_with, *speeds, harmonics, MATTERS, points, coexisting, left
    )  # fmt: skip
    if g == 1 or not general:
        return problem, curve, tail, origin
    return *_unfolded(problem, curve, g), tail and tail._replace(harmonics=tail.harmonics * g), origin


def of_spring(top: int, kinked: bool) -> tuple[int, int]:
    """Harmonics that the curve of one equation begins with, and at most, for the highest order of what drives it."""
    begin, largest = (max(top, SPRING_WITH_KINKS) if kinked else SPRING * top), max(MOST_OF_SPRING, top + 2)
    return min(begin, largest), largest


def of_drive(top: int, g: int, kinked: bool) -> tuple[int, int]:
    """The same of a drive that repeats g times in a turn."""
    begin, largest = max(PER_ORDER * top, (WITH_KINKS if kinked else 1) * g), max(MOST_HARMONICS, top + 2 * g)
    return min(begin, largest), largest


def repeats(problem: FirstOrder, top: int) -> int:
    """Repeats in a turn, at most `top`, of everything that acts on a system."""
    angles = 2.0 * np.pi * np.arange(LOOKED_AT) / LOOKED_AT
    moving = problem.sizes[:, None] * np.cos(1.0 + np.arange(len(problem.sizes))[:, None] + angles)
    alike = set(range(2, top + 1))
    for y in (0.0 * moving, moving):
        rates = rates_at(problem.system, angles, y)
        least = SAME * np.max(np.abs(rates), axis=1, keepdims=True)
        for g in sorted(alike):
            if np.any(np.abs(rates_at(problem.system, angles + 2.0 * np.pi / g, y) - rates) > least):
                alike.remove(g)
    return max(alike, default=1)


def _unfolded(problem: FirstOrder, curve: Trace, g: int) -> tuple[FirstOrder, Trace]:
    """The same curve over a whole turn, of which it was followed over a g-th."""
    h = g * problem.harmonics()
    full = first_order(problem.system, problem.leaf, problem.omega_leaf, h, sizes=problem.sizes)
    points = [full.point(stretched(problem.table(z), g), float(z[-1])) for z in curve.points]
    elsewhere = tuple((value, stretched(table, g)) for value, table in curve.elsewhere)
    return full, with_changes(curve, points=np.array(points).reshape(-1, full.size() + 1), elsewhere=elsewhere)
