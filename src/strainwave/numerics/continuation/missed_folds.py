"""Folds that the steps of a continuation passed over, found where the parameter turns without a fold.

A step keeps the tangent of its prediction. Where the curve bends sharply (a motion reaches a breakpoint of its law),
that tangent may still point the old way a step or two after the fold, which is then looked for in the wrong step.
"""

from functools import partial
from typing import Any

import numpy as np

from ...protocols import Balance
from ...results import Floats
from ..balance.work import linearised
from ..labels import FOLD
from ..stability.special_points import root_on_chord

NEAR = 2  # points on either side among which the fold of a turn is


def with_missed_folds(problem: Balance, points: Floats, labels: Any) -> tuple[Floats, Any]:
    """Insert the folds at which the parameter (last of every point) turns and no fold is marked."""
    rise = np.diff(points[:, -1])
    for i in (np.flatnonzero(rise[1:] * rise[:-1] < 0.0) + 1)[::-1].tolist():
        if FOLD in labels[max(0, i - NEAR) : i + NEAR + 1]:
            continue
        for place in (i, i + 1):
            first, last = points[place - 1], points[place]
            slope = partial(_slope, problem, last - first)
            fold = root_on_chord(problem, first, last, slope)
            if fold is not None:
                points, labels = np.insert(points, place, fold, axis=0), np.insert(labels, place, FOLD)
                break
    return points, labels


def _slope(problem: Balance, chord: Floats, point: Floats) -> float:
    """Part along the parameter of the tangent that goes along the chord."""
    n = len(point) - 1
    _, matrix, column = linearised(problem, point)
    scale = np.full(n + 1, max(float(np.linalg.norm(point[:-1])), 1e-300))
    scale[-1] = max(abs(float(point[-1])), 1e-300)
    row = chord / scale
    bordered = np.block([[matrix, column[:, None]], [row[None, :] / scale]]) * scale
    tangent = np.linalg.solve(bordered, np.eye(n + 1)[n])
    return float(tangent[-1] / np.linalg.norm(tangent))
