"""Period doublings and branch points of a curve of periodic orbits, located between its points."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from ...base.branch_labels import BRANCH_POINT, DOUBLING, FOLD
from ...base.protocols import Balance
from ...base.results import Floats, Integers, SolveError
from ..balance.first_order import linearised, newton
from ..roots import bracketed_root
from .second_order import grid_of, hill, orbit_scales, steps_for

FINER, MOST_FINER = 4, 2048  # Numerov steps: four times those along a branch (256 times less error), or enough
NOISE = 1e-7  # of the products: below this a multiplier sits at 1 for good (as inside a gap)
ONE_PLACE = 1e-9  # relative distance of the parameter at a fold and at a branch point that are one


def products(traces: Floats, decay: Floats) -> tuple[Floats, Floats]:
    """(1 + m1)(1 + m2) and (1 - m1)(1 - m2) from Hill's traces and exp(-B period/(2J))."""
    total, determinant = traces * decay, decay * decay
    return 1.0 + total + determinant, 1.0 - total + determinant


def with_crossings(problem: Any, points: Floats, labels: Any, traces: Floats, decay: Floats) -> tuple[Floats, Any, int]:
    """Insert the period doublings and branch points between the points of a branch; returns how many there are."""
    doubling, crossing = products(traces, decay)
    crossings: list[tuple[int, int, Floats]] = []
    for i in changes(doubling, points):
        crossings += _located(problem, points, i, DOUBLING)
    for i in changes(crossing, points):
        if _passes_one(crossing, labels, i):
            turns = points[labels == FOLD, -1]  # a fold beside a point on it is no branch point
            crossed = _located(problem, points, i, BRANCH_POINT)
            crossings += [c for c in crossed if np.all(np.abs(turns - c[2][-1]) > ONE_PLACE * abs(c[2][-1]))]
    if not crossings:
        return points, labels, 0
    points, labels, _, _ = inserted(points, labels, crossings)
    return points, labels, len(crossings)


def changes(values: Floats, points: Floats) -> list[int]:
    """Places of points after which a value changes its sign, but for the seam of two arcs at one parameter."""
    sign = np.sign(values)
    places = np.flatnonzero(sign[1:] * sign[:-1] < 0.0).tolist()
    return [i for i in places if points[i, -1] != points[i + 1, -1]]


def inserted(
    points: Floats, labels: Integers, additions: list[tuple[int, int, Floats]]
) -> tuple[Floats, Any, list[int], Floats]:  # fmt: skip
    """Points and labels with new ones (number of the point before, label, point); their places, and they in order."""
    additions = sorted(additions, key=lambda item: (item[0], float(np.linalg.norm(item[2] - points[item[0]]))))
    places, new = [i + 1 for i, _, _ in additions], np.array([point for _, _, point in additions])
    labels = np.insert(labels, places, [label for _, label, _ in additions])
    return np.insert(points, places, new, axis=0), labels, places, new


def _passes_one(crossing: Floats, labels: Integers, i: int) -> bool:
    """True if the sign change between points i and i + 1 is no fold and no rounding."""
    if labels[i] == FOLD or labels[i + 1] == FOLD:
        return False
    for j, neighbour in ((i, i - 1), (i + 1, i + 2)):
        near_fold = 0 <= neighbour < len(labels) and labels[neighbour] == FOLD
        if near_fold and abs(crossing[j]) < 1e-5:
            return False
    return bool(max(abs(crossing[i]), abs(crossing[i + 1])) > NOISE)


def _located(problem: Balance, points: Floats, i: int, label: int) -> list[tuple[int, int, Floats]]:
    """Points between i and i + 1 of a branch at which the product of the label vanishes."""
    table = finer_table(problem, points[i : i + 2])
    point = root_on_chord(problem, points[i], points[i + 1], lambda z: _product(problem, z, table, label))
    return [] if point is None else [(i, label, point)]


def finer_table(problem: Any, points: Floats) -> Floats:
    """Synthesis table of the grid on which multipliers at special points are found."""
    steps = steps_for(problem, points)
    return grid_of(problem, max(steps, min(FINER * steps, MOST_FINER)))


def _product(problem: Any, point: Floats, table: Floats, label: int) -> float:
    traces = hill(problem, point[None, :], table)
    both = products(traces, orbit_scales(problem, point[-1:])[1])
    return float(both[0 if label == DOUBLING else 1][0])


def on_chord(
    problem: Balance, first: Floats, last: Floats, s: float, start: Floats | None = None
) -> Floats | None:  # fmt: skip
    """Solution in the plane across the chord from `first` to `last`, at the fraction s of it.

    Newton's method begins on the chord, or at a point `start` in that plane.
    """
    chord = last - first
    scale = np.full(len(first), 1.0 / max(float(np.linalg.norm(first[:-1])), 1e-300))
    scale[-1] = 1.0 / max(abs(float(first[-1])), abs(float(last[-1])), 1e-100)
    guess = first + s * chord
    point = corrected(problem, guess, chord * scale * scale, scale, start)
    if point is None or np.linalg.norm((point - guess) * scale) > np.linalg.norm(chord * scale):
        return None  # on another branch
    return point


def corrected(
    problem: Balance, guess: Floats, row: Floats, scale: Floats, start: Floats | None = None
) -> Floats | None:  # fmt: skip
    """Solution in the plane through a guess whose normal is `row`; None where Newton's method fails.

    It begins at the guess, or at another `start`.

    As Python, not compiled: a handful of solutions does not pay for another entry into compiled code. At a branch point
    the Jacobian is singular across the branch; there least squares leave that direction alone.
    """
    row = row / np.linalg.norm(row)

    def equations(z: Floats) -> tuple[Floats, Floats]:
        r, matrix, column = linearised(problem, z)
        return np.append(r, row @ z - row @ guess), np.vstack([np.column_stack([matrix, column]), row])

    point = newton(equations, guess if start is None else start, 1.0 / scale, 1e-12)
    if point is None:
        point = newton(equations, guess, 1.0 / scale, 1e-12, solve=lambda a, b: np.linalg.lstsq(a, b, rcond=1e-6)[0])
    return point


def root_on_chord(
    problem: Balance, first: Floats, last: Floats, function: Callable[[Floats], float]
) -> Floats | None:  # fmt: skip
    """Point of a curve between two of its points where a function of the point changes sign; None where it does not."""
    points = {0.0: first, 1.0: last}

    def point_at(s: float) -> Floats:
        if s not in points:
            point = on_chord(problem, first, last, s, _between(points, s))
            if point is None:
                raise SolveError("the chord of two points leaves their curve")
            points[s] = point
        return points[s]

    try:  # at a corner of the law the function may jump: there each bit is one solution more
        return point_at(bracketed_root(lambda s: function(point_at(s)), 0.0, 1.0, xtol=1e-9))
    except (SolveError, ValueError, np.linalg.LinAlgError):
        return None


def _between(points: dict[float, Floats], s: float) -> Floats:
    """Point at the fraction s of a chord on the polynomial through the points known nearest to it, at most four."""
    nearest = sorted(points, key=lambda share: abs(share - s))[:4]
    out = np.zeros_like(points[nearest[0]])
    for share in nearest:
        out += points[share] * math.prod((s - other) / (share - other) for other in nearest if other != share)
    return out
