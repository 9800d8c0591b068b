"""Period doublings and branch points of a curve of periodic orbits, located between its points.

With the multipliers m1, m2 of a second-order system the products (1 + m1)(1 + m2) and (1 - m1)(1 - m2) are polynomials
in the trace of the period map: the first changes sign where a multiplier passes -1 (period doubling), the second where
one passes +1, at folds and at branch points (a symmetric orbit loses its symmetry). Each sign change is narrowed on
the curve itself, corrected along the chord between the two points, with multipliers from a finer grid.

Seydel 2010, Practical Bifurcation and Stability Analysis, secs. 5.3-5.5 and 7.4.
"""

from typing import Any

import numpy as np

from ...protocols import Balance
from ...results import Floats
from ..balance.work import linearised
from ..labels import BRANCH_POINT, DOUBLING, FOLD
from .second_order import grid_of, hill, orbit_scales, steps_for

FINER, ENOUGH = 4, 2048  # Numerov steps: four times those along a branch (256 times less error), or enough
NOISE = 1e-7  # of the products: below this a multiplier sits at 1 for good (as inside a gap)


def products(traces: Floats, decay: Floats) -> tuple[Floats, Floats]:
    """(1 + m1)(1 + m2) and (1 - m1)(1 - m2) from Hill's traces and exp(-B period/(2J))."""
    total, determinant = traces * decay, decay * decay
    return 1.0 + total + determinant, 1.0 - total + determinant


def with_crossings(problem: Any, points: Floats, labels: Any, traces: Floats, decay: Floats) -> tuple[Floats, Any, int]:
    """Insert the period doublings and branch points between the points of a branch; returns how many there are."""
    doubling, crossing = products(traces, decay)
    found: list[tuple[int, int, Floats]] = []
    for i in np.flatnonzero(doubling[1:] * doubling[:-1] < 0.0).tolist():
        found += _located(problem, points, i, DOUBLING)
    for i in np.flatnonzero(crossing[1:] * crossing[:-1] < 0.0).tolist():
        if _passes_one(crossing, labels, i):
            found += _located(problem, points, i, BRANCH_POINT)
    if not found:
        return points, labels, 0
    found.sort(key=lambda item: (item[0], float(np.linalg.norm(item[2] - points[item[0]]))))
    places = [i + 1 for i, _, _ in found]
    points = np.insert(points, places, [p for _, _, p in found], axis=0)
    return points, np.insert(labels, places, [label for _, label, _ in found]), len(found)


def _passes_one(crossing: Floats, labels: Any, i: int) -> bool:
    """Whether the sign change between points i and i + 1 is no fold and no rounding."""
    if labels[i] == FOLD or labels[i + 1] == FOLD:
        return False
    for j, neighbour in ((i, i - 1), (i + 1, i + 2)):
        near_fold = 0 <= neighbour < len(labels) and labels[neighbour] == FOLD
        if near_fold and abs(crossing[j]) < 1e-5:
            return False
    return bool(max(abs(crossing[i]), abs(crossing[i + 1])) > NOISE)


def _located(problem: Any, points: Floats, i: int, label: int) -> list[tuple[int, int, Floats]]:
    point = crossing_between(problem, points[i], points[i + 1], label)
    return [] if point is None else [(i, label, point)]


def crossing_between(problem: Any, first: Floats, last: Floats, label: int) -> Floats | None:
    """Point between two points of a branch where the product of the label vanishes; None if it does not change sign."""
    table = finer_table(problem, np.stack([first, last]))
    place = [0.0, 1.0]
    ends = [_product(problem, first, table, label), _product(problem, last, table, label)]
    if not ends[0] * ends[1] < 0.0:
        return None
    small = 1e-12 * max(abs(ends[0]), abs(ends[1]))
    side, best = 0, first
    for _ in range(60):
        s = (place[0] * ends[1] - place[1] * ends[0]) / (ends[1] - ends[0])
        point = on_chord(problem, first, last, s)
        if point is None:
            return None
        moved, best = float(np.linalg.norm(point - best)), point
        here = _product(problem, point, table, label)
        end = 0 if here * ends[0] > 0.0 else 1
        place[end], ends[end] = s, here
        if side == end:  # Illinois
            ends[1 - end] *= 0.5
        side = end
        if abs(here) < small or place[1] - place[0] < 1e-12 or moved < 1e-12 * float(np.linalg.norm(point)):
            break
    return best


def finer_table(problem: Any, points: Floats) -> Floats:
    """Synthesis table of the grid on which multipliers at special points are found."""
    steps = steps_for(problem, points)
    return grid_of(problem, max(steps, min(FINER * steps, ENOUGH)))


def _product(problem: Any, point: Floats, table: Floats, label: int) -> float:
    traces, _ = hill(problem, point[None, :], table)
    both = products(traces, orbit_scales(problem, point[-1:])[1])
    return float(both[0 if label == DOUBLING else 1][0])


def on_chord(problem: Balance, first: Floats, last: Floats, s: float) -> Floats | None:
    """Solution in the plane across the chord from `first` to `last`, at the fraction s of it."""
    chord = last - first
    scale = np.full(len(first), 1.0 / max(float(np.linalg.norm(first[:-1])), 1e-300))
    scale[-1] = 1.0 / max(abs(float(first[-1])), abs(float(last[-1])), 1e-100)
    guess = first + s * chord
    point = corrected(problem, guess, chord * scale * scale, scale)
    if point is None or np.linalg.norm((point - guess) * scale) > np.linalg.norm(chord * scale):
        return None  # on another branch
    return point


def corrected(problem: Balance, guess: Floats, row: Floats, scale: Floats) -> Floats | None:
    """Solution in the plane through a guess whose normal is `row`; None where Newton's method fails.

    As Python, not compiled: a handful of solutions does not pay for another entry into compiled code. At a branch point
    the Jacobian is singular across the branch; there least squares leave that direction alone.
    """
    for singular in (False, True):
        point = _newton(problem, guess.copy(), row / np.linalg.norm(row), scale, singular)
        if point is not None:
            return point
    return None


def _newton(problem: Balance, z: Floats, row: Floats, scale: Floats, singular: bool) -> Floats | None:
    target, last = float(row @ z), np.inf
    for _ in range(20):
        r, matrix, column = linearised(problem, z)
        bordered = np.block([[matrix, column[:, None]], [row[None, :]]]) / scale
        short = np.append(r, row @ z - target)
        try:
            step = np.linalg.lstsq(bordered, short, rcond=1e-6)[0] if singular else np.linalg.solve(bordered, short)
        except np.linalg.LinAlgError:
            return None
        z = z - step / scale
        size = float(np.linalg.norm(step))
        if not size < 1e3:
            return None
        if size < 1e-12 or (size < 1e-9 and size > 0.3 * last):
            return z
        last = size
    return None
