"""Crests of a curve of orbits: where |x|, or |x - mean|, is largest among its neighbours.

The steps of a continuation pass a crest at some distance. A crest is looked for on the polynomial through five points,
over the arc between them, and solved for there; with that point more it is looked for again where it may be higher.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from ...protocols import Balance
from ...results import Floats
from ...series import largest_size, oscillation
from ..balance.fourier import from_blocks
from ..labels import TOP
from ..stability.special_points import inserted
from .trace import solve

LEAST = 0.01  # of the largest value on the curve: lower crests stay as they are
REACH, LOOKED = 2, 17  # points to both sides of a crest, and places looked at between the next ones
ROUNDS, SETTLED = 6, 1e-12  # solutions of a crest, and the relative rise above one that is none
SAME = 1e-6  # of the arc of these: what is nearer is one point
ONE = 1e-6  # relative distance below which two points are one
MEAN = 1e-6  # of the largest |x|: with a smaller mean both crests are one

Measure = Callable[[Floats], Floats]


def with_crests(problem: Balance, points: Floats, labels: Any) -> tuple[Floats, Any]:
    """Points and labels of a curve with the crests of |x| and of |x - mean| among them, labelled TOP."""
    if len(points) < 3:
        return points, labels
    series = _series(problem, points)
    peaks = largest_size(series)
    sizes: list[tuple[Measure, Floats]] = [(largest_size, peaks)]
    if np.any(np.abs(series[:, 0]) > MEAN * peaks):
        sizes.append((oscillation, oscillation(series)))
    found: list[tuple[int, int, Floats]] = []
    for measure, values in sizes:
        for i in crests_of(values):
            crest = _crest(problem, points, i, values, measure)
            if crest is None:
                continue
            place = i if crest[0] > 0.0 else i - 1
            known = [points[place], points[place + 1], *(point for at, _, point in found if at == place)]
            if all(_apart(crest[1], point) > ONE for point in known):  # often the two crests are one
                found.append((place, TOP, crest[1]))
    if not found:
        return points, labels
    points, labels, _, _ = inserted(points, labels, found)
    return points, labels


def crests_of(values: Floats) -> list[int]:
    """Places of the values that are above both neighbours, and no less than a hundredth of the largest."""
    inner = values[1:-1]
    above = (inner >= values[:-2]) & (inner > values[2:]) & (inner > LEAST * np.max(values))
    return [int(i) + 1 for i in np.flatnonzero(above)]


def _crest(problem: Balance, points: Floats, i: int, sizes: Floats, measure: Measure) -> tuple[float, Floats] | None:
    """Crest next to a point, after which it lies where the first number is positive; None where the point is it.

    It is the highest place of the polynomial through five points, solved for at the parameter there.
    """
    scale = np.full(points.shape[1], 1.0 / max(float(np.linalg.norm(points[i, :-1])), 1e-300))
    scale[-1] = 1.0 / max(abs(float(points[i, -1])), 1e-300)
    some = points[max(i - REACH, 0) : i + REACH + 1] * scale
    at = min(i, REACH)
    arc = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(some, axis=0), axis=1)))
    apart = np.diff(arc) > SAME * arc[-1]
    first, last, here = arc[at - 1], arc[at + 1], arc[at]
    if not (apart[at - 1] and apart[at]):
        return None
    known = np.append(True, apart)
    some, arc, size, crest, near = some[known], arc[known], float(sizes[i]), None, 0.1 * min(here - first, last - here)
    for _ in range(ROUNDS):
        s, top = _highest(problem, arc, some, scale, first, last, measure)
        if top - size <= SETTLED * top or not first < s < last or np.any(s == arc):
            break
        guess = _between(arc, some, np.array([s]))[0] / scale
        found = solve(problem, guess)
        if found is None or float(np.linalg.norm((found - guess) * scale)) > near:
            break
        value = float(measure(_series(problem, found[None]))[0])
        if value >= size:
            size, crest = value, (s - here, found)
        place = int(np.searchsorted(arc, s))
        arc, some = np.insert(arc, place, s), np.insert(some, place, found * scale, axis=0)
    return crest


def _highest(
    problem: Balance, arc: Floats, points: Floats, scale: Floats, low: float, high: float, measure: Measure
) -> tuple[float, float]:  # fmt: skip
    """Place between two others where the polynomial through points is highest, and the value there."""
    for _ in range(2):
        places = np.linspace(low, high, LOOKED)
        values = measure(_series(problem, _between(arc, points, places) / scale))
        best = min(max(int(np.argmax(values)), 1), LOOKED - 2)
        low, high = places[best - 1], places[best + 1]
    left, top, right = values[best - 1 : best + 2].tolist()
    bend, rise = left - 2.0 * top + right, left - right
    if not bend < 0.0:
        return float(places[best]), top
    return float(places[best] + 0.25 * rise * (high - low) / bend), top - rise * rise / (8.0 * bend)


def _between(arc: Floats, points: Floats, places: Floats) -> Floats:
    """Points at places of the arc on the polynomial through points there (Lagrange)."""
    ratios = (places[:, None, None] - arc) / (arc[:, None] - arc + np.eye(len(arc)))
    ratios[:, np.arange(len(arc)), np.arange(len(arc))] = 1.0
    return np.asarray(np.prod(ratios, axis=2) @ points)


def _apart(a: Floats, b: Floats) -> float:
    """Distance of two points, of the motion and of the speed, relative to their sizes."""
    motion = float(np.linalg.norm(a[:-1] - b[:-1])) / max(float(np.linalg.norm(b[:-1])), 1e-300)
    return motion + abs(float(a[-1] / b[-1]) - 1.0)


def _series(problem: Balance, points: Floats) -> Floats:
    """Coefficients (points, 2H+1) of x: mean, cos 1, sin 1, ..."""
    return np.asarray(from_blocks(problem.displacements(points).T).T)
