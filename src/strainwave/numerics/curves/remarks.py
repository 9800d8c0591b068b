"""Sentences on what a response curve should not be trusted in, with the frequency and the remedy."""

from typing import Any

import numpy as np

from ...results import Branch, Floats
from ...sentences import Sentence, Speed
from ..balance.second_order import SecondOrder
from ..continuation.describe import Survey

NEVER_STABLE = "no point of it is stable"


def remarks(curves: list[Survey], branches: list[Branch]) -> list[list[str]]:
    """List what to know about each of several response curves with equal harmonics."""
    found = []
    for curve, branch in zip(curves, branches, strict=True):
        said: list[str] = []
        found.append(said)
        if not len(branch):
            continue
        if not branch.stable.any():
            said.append(NEVER_STABLE)
        loose = floating(curve.problem, curve.points)
        if loose is not None:
            low, high = np.min(curve.points[loose, -1]), np.max(curve.points[loose, -1])
            said.append(
                Sentence(
                    "at omega = {} the law gives no torque and any mean is in balance (the middle is shown): a mean "
                    "torque would place it",
                    Speed(low, high, between=" .. "),
                )
            )
    return found


def floating(problem: SecondOrder, points: Floats) -> Any:
    """Whether the law gives no torque anywhere on an orbit that moves, for every point; None if on no orbit."""
    law, n = problem.system.law, len(problem.error)
    if law.torque(0.0) != 0.0 or law.stiffness(0.0) != 0.0:
        return None
    u = points[:, :n] @ problem.synthesis
    idle = np.all(law.torque(u) + np.zeros_like(u) == 0.0, axis=1) & (np.ptp(u, axis=1) > 0.0)
    return idle if np.any(idle) else None
