"""Branches of periodic orbits: solved at a point, traced, and described with stability, folds and period doublings."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...protocols import Balance
from ...results import Floats
from ..labels import CLOSED, FOLD, LOST, RUNNING, START, STEP, TOP, UNBOUNDED
from .arc_length import ROWS, SCALE, Z1, buffers_for, follow
from .missed_folds import with_missed_folds

MOST_PIECES = 40
LEAST_PIECE = 5  # points that a piece must have room for
PIECE = 512  # points per call of the kernel: between calls the user can interrupt
AIM = 1e-3


@dataclass(frozen=True)
class Trace:
    """Points of a branch (coefficients in blocks, parameter last), what each is, and how the branch ended.

    `message` is the sentence about the end, where the one that `describe` finds for the outcome does not tell enough;
    `elsewhere` holds values of the parameter and tables of orbits there through which the branch does not pass; `span`
    is the range that the branch was to be followed through, and may leave in between.
    """

    points: Floats
    labels: Any
    outcome: int
    message: str = ""
    elsewhere: tuple[tuple[float, Floats], ...] = ()
    span: tuple[float, float] | None = None


def state_from(guess: Floats, width: float) -> Floats:
    """State of a continuation that starts at a guess (coefficients, parameter), the latter in units of `width`."""
    state = np.zeros((ROWS, len(guess)))
    state[Z1] = guess
    state[SCALE] = 1.0 / max(float(np.linalg.norm(guess[:-1])), 1e-12)
    state[SCALE, -1] = 1.0 / width
    return state


def solve(problem: Balance, guess: Floats) -> Floats | None:
    """Solution at the parameter of a guess, or None."""
    points, labels = np.empty((5, len(guess))), np.empty(5, np.int64)
    at = float(guess[-1])
    state, buffers = state_from(guess, abs(at) + 1e-12), buffers_for(problem)
    count, _, _ = _run(problem, state, 1.0, START, at, at, 1.0, 1.0, AIM, buffers, points, labels)
    return points[0] if count else None


def _run(problem: Balance, *arguments: Any) -> Any:
    with np.errstate(all="ignore"):  # a step that fails is taken again, shorter
        return problem.run(follow, *arguments)


def trace(
    problem: Balance,
    guess: Floats,
    direction: float,
    lo: float,
    hi: float,
    step: float,
    width: float | None = None,
    growth: float = np.inf,
    most: int | None = None,
) -> Trace:
    """Follow one branch from a guess (coefficients, parameter) inside [lo, hi] until it leaves or closes.

    `step` is in units of the orbit's size and of `width` of the parameter (default: the range). The outcome is
    UNBOUNDED where the orbit is `growth` times larger than at the start. With `most` it is RUNNING after about so many
    points, which are given as they were taken, without a second look at folds.
    """
    state = state_from(guess, width or hi - lo)
    found: list[Floats] = []
    labels: list[Any] = []
    ds, outcome, mode = 0.1 * step, RUNNING, START
    buffers, left = buffers_for(problem), PIECE * MOST_PIECES if most is None else most
    while outcome == RUNNING and left >= LEAST_PIECE:
        piece = min(PIECE, left)
        points, kinds = np.empty((piece, len(guess))), np.empty(piece, np.int64)
        count, outcome, ds = _run(problem, state, direction, mode, lo, hi, ds, step, AIM, buffers, points, kinds)
        found.append(points[:count])
        labels.append(kinds[:count])
        mode = STEP
        left -= piece
        if growth < np.inf and outcome != LOST:
            squares = np.square(points[:count, :-1]).sum(axis=1)
            large = np.sqrt(squares) > growth * np.linalg.norm(found[0][0, :-1])
            if large.any():
                end = int(np.argmax(large)) + 1
                found[-1], labels[-1], outcome = points[:end], kinds[:end], UNBOUNDED
    points, kinds = np.concatenate(found), np.concatenate(labels)
    if most is None:
        points, kinds = with_missed_folds(problem, *in_order(points, kinds))
        if outcome == CLOSED:
            points[-1] = points[0]  # the last step went a little past the start
    return Trace(points, kinds, outcome)


def in_order(points: Floats, labels: Any) -> tuple[Floats, Any]:
    """Put folds and amplitude maxima in the order of the arc.

    They are listed before the end of the step in which they were found, the fold first, but may lie just outside it.
    """
    order = np.arange(len(labels))
    special = np.flatnonzero((labels == FOLD) | (labels == TOP))
    at = np.concatenate([special, special - 1])
    at = at[(at > 0) & (at < len(labels) - 2)]
    if not np.any(np.sum((points[at + 1] - points[at]) * (points[at + 2] - points[at - 1]), axis=1) < 0.0):
        return points, labels
    for i in special:
        for a in (i, i - 1):  # with its right neighbour, then with its left one
            if 0 < a < len(order) - 2:
                near, first, second, far = points[order[a - 1 : a + 3]]
                ahead = far - near
                if (second - first) @ ahead < 0.0 and np.linalg.norm(second - near) < np.linalg.norm(first - near):
                    order[a], order[a + 1] = order[a + 1], order[a]
    return points[order], labels[order]
