"""A branch followed both ways, up to where it is born from a motion at rest or one that repeats after fewer turns."""

from typing import Any

import numpy as np

from ...base.branch_labels import CLOSED, END, FOLD, LOST, STEP
from ...base.protocols import Balance
from ...base.results import Floats
from ..continuation.trace import Trace, solve, trace

UPRIGHT = 0.05  # of the largest departure from another branch: below this a turn is that of the crossing
SUBHARMONIC = 1e-6  # of a motion: below this it repeats after fewer turns


def both_ways(
    problem: Balance,
    guess: Floats,
    lo: float,
    hi: float,
    step: float,
    width: float | None = None,
    growth: float = np.inf,
    apart: Any = None,
) -> Trace:
    """Follow the branch through a guess (coefficients, parameter) until it closes or leaves [lo, hi] at both ends.

    Where the coefficients `apart` (mask or numbers) vanish it ends: it is born there from a motion without them.
    """
    if solve(problem, guess) is None:
        return Trace(np.empty((0, len(guess))), np.empty(0, int), LOST)
    up = _to_birth(trace(problem, guess, 1.0, lo, hi, step, width, growth), apart)
    if up.outcome in (CLOSED, LOST) or float(guess[-1]) <= lo:
        return up
    down = _to_birth(trace(problem, up.points[0], -1.0, lo, hi, step, width, growth), apart)
    if down.outcome == CLOSED:
        return down
    points = np.concatenate([down.points[:0:-1], up.points])
    labels = np.concatenate([down.labels[:0:-1], up.labels])
    if up.outcome == END and down.outcome != END:  # the end that needs explaining comes last
        return Trace(points[::-1], labels[::-1], down.outcome)
    return Trace(points, labels, up.outcome)


def _to_birth(curve: Trace, apart: Any) -> Trace:
    part, returned = (curve, False) if apart is None or curve.outcome == LOST else until_return(curve, apart)
    return part if returned else curve


def apart_from_shorter(problem: Any, guess: Floats) -> Any:
    """Coefficients that the motion from which a branch may be born lacks; None where it cannot be.

    Of several turns those are of the harmonics between those of one; of one turn all, where nothing excites.
    """
    h, turns = problem.harmonics(), int(problem.turns)
    if turns == 1:
        rests = not np.any(problem.linear_response(float(guess[-1]))[:-1])
        return np.arange(len(guess) - 1) if rests else None
    numbers = np.concatenate([subharmonic_places(h, turns) + block for block in range(0, len(guess) - 1, 2 * h + 1)])
    return numbers if np.linalg.norm(guess[numbers]) > SUBHARMONIC * np.linalg.norm(guess[:-1]) else None


def subharmonic_places(h: int, turns: int) -> Any:
    """Places, in a block of coefficients of h harmonics over several turns, of those that a motion of one has not."""
    k = np.flatnonzero(np.arange(h + 1) % turns)
    return np.concatenate([k, h + k])


def until_return(curve: Trace, apart: Any) -> tuple[Trace, bool]:
    """A branch up to where it meets another: there its coefficients `apart`, which the other lacks, change sign.

    Next to the meeting point the branch stands upright, a fold of the crossing itself: no fold is marked there.
    """
    part = curve.points[:, apart]
    flips = np.flatnonzero(np.sum(part[1:] * part[:-1], axis=1) < 0.0)
    size = np.linalg.norm(part, axis=1)
    last = int(flips[0]) if len(flips) else len(part) - 1
    while len(flips) and last > 0 and size[last] < 1e-4 * np.max(size):
        last -= 1
    arc = slice(0, last + 1)
    upright = (curve.labels[arc] == FOLD) & (size[arc] < UPRIGHT * np.max(size[arc]))
    labels = np.where(upright, STEP, curve.labels[arc])
    return Trace(curve.points[arc], labels, END if len(flips) else curve.outcome), len(flips) > 0
