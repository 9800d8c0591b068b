"""Crests of a curve of orbits: where |x|, or |x - mean|, is largest among its neighbours.

The steps of a continuation pass a crest at some distance. A crest is looked for at the vertex of the parabola through
three points, over the arc between them, and solved for at the parameter there. That point takes the place of one of the
three, until the next vertex is no higher.
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
SETTLED, VERTICES = 1e-12, 6  # relative rise of a parabola above its points that is none; parabolas of a crest
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
            crest = _crest(problem, points[i - 1 : i + 2], values[i - 1 : i + 2], measure)
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


def _crest(problem: Balance, points: Floats, sizes: Floats, measure: Measure) -> tuple[float, Floats] | None:
    """Crest next to the middle one of three points, after which it lies where the first number is positive.

    None where that point is it, or where no solution is found beside it.
    """
    scale = np.full(points.shape[1], 1.0 / max(float(np.linalg.norm(points[1, :-1])), 1e-300))
    scale[-1] = 1.0 / max(abs(float(points[1, -1])), 1e-300)
    first, ahead, best = points[1], (points[2] - points[0]) * scale, None
    (before, here, after), (low, top, high) = points, sizes
    for _ in range(VERTICES):
        a, b = (float(np.linalg.norm(way * scale)) for way in (here - before, after - here))
        if a == 0.0 or b == 0.0:
            break
        left, right = (top - low) / a, (high - top) / b
        bend = (right - left) / (a + b)
        slope = left + bend * a
        if not bend < 0.0 or slope * slope < -4.0 * bend * SETTLED * top:
            break
        s = -0.5 * slope / bend
        step, turn = (here - before) / a, ((after - here) / b - (here - before) / a) / (a + b)
        guess = here + s * (step + turn * (s + a))
        found = solve(problem, guess)
        if found is None or float(np.linalg.norm((found - guess) * scale)) > 0.1 * min(a, b):
            break
        size = float(measure(_series(problem, found[None]))[0])
        if size >= top and s > 0.0:
            before, low, here, top = here, top, found, size
        elif size >= top:
            after, high, here, top = here, top, found, size
        elif s > 0.0:
            after, high = found, size
        else:
            before, low = found, size
        best = here
    if best is None or best is first:
        return None
    return float((best - first) * scale @ ahead), best


def _apart(a: Floats, b: Floats) -> float:
    """Distance of two points, of the motion and of the speed, relative to their sizes."""
    motion = float(np.linalg.norm(a[:-1] - b[:-1])) / max(float(np.linalg.norm(b[:-1])), 1e-300)
    return motion + abs(float(a[-1] / b[-1]) - 1.0)


def _series(problem: Balance, points: Floats) -> Floats:
    """Coefficients (points, 2H+1) of x: mean, cos 1, sin 1, ..."""
    return np.asarray(from_blocks(problem.displacements(points).T).T)
