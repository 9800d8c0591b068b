"""Which orbits are one motion: on a branch already, shifted by whole forcing periods, or mirrored."""

from typing import Any

import numpy as np

from ...numerics.balance.fourier import stretched
from ...numerics.continuation.trace import solve
from ...results import Branch, Floats


def takes(point: Floats, period: int) -> bool:
    """Whether an orbit takes `period` turns and no fewer: more than rounding beside the harmonics of fewer."""
    h, size = len(point) // 2 - 1, float(np.linalg.norm(point[:-1]))
    shorter = [n for n in range(1, period) if period % n == 0]
    for n in shorter:
        rest = np.array([k for k in range(1, h + 1) if k % (period // n)])
        if not np.linalg.norm(point[np.concatenate([rest, h + rest])]) > 1e-6 * size:
            return False
    return True


def lies_on(problem: Any, point: Floats, branch: Branch) -> bool:
    """Whether an orbit, or a copy of it, is on a branch: the same motion at its frequency."""
    omega = float(point[-1])
    side, stretch = branch.omega - omega, problem.turns // branch.period
    for i in np.flatnonzero(side[1:] * side[:-1] <= 0.0):
        width = side[i] - side[i + 1]
        share = float(side[i] / width) if width != 0.0 else 0.0
        series = (1.0 - share) * branch.coefficients[i] + share * branch.coefficients[i + 1]
        there = solve(problem, problem.point(stretched(series[:, None], stretch), omega))
        if there is not None and are_copies(point[:-1] + problem.error, there[:-1] + problem.error, problem.turns):
            return True
    return False


def are_copies(x: Floats, y: Floats, period: int) -> bool:
    """Whether two series (blocks) are one motion but for whole forcing periods, or half turns and a mirror."""
    h = len(x) // 2
    k = np.arange(h + 1)
    a, b = (np.append(z[0], z[1 : h + 1] - 1j * z[h + 1 :]) for z in (x, y))
    halves = np.arange(2 * period)[:, None]
    shifted = b * np.exp(1j * np.pi * k * halves / period) * (-1.0) ** halves
    return bool(np.min(np.linalg.norm(shifted - a, axis=1)) < 1e-5 * np.linalg.norm(a))
