"""Sentences on what a response curve should not be trusted in, with the frequency and the remedy."""

from typing import Any

import numpy as np

from ..results import Branch, Floats
from .balance import SecondOrder
from .fourier import analysis, synthesis

MATTERS = 1e-3  # share of the response in the harmonics left out


def remarks(problem: Any, branch: Branch, points: Floats) -> list[str]:
    """List what to know about a response curve: points are (coefficients in blocks, omega last)."""
    found: list[str] = []
    if not len(branch):
        return found
    if not np.any(branch.stable):
        found.append("no point of it is stable")
    if isinstance(problem, SecondOrder):
        share, at = left_out(problem, points)
        if share > MATTERS:
            found.append(
                f"at omega = {at:.6g} rad/s the harmonics left out hold about {min(100.0, 100.0 * share):.2g} % of the "
                f"response: take more than {len(problem.error) // 2} harmonics"
            )
        loose = floating(problem, points)
        if np.any(loose):
            low, high = np.min(points[loose, -1]), np.max(points[loose, -1])
            found.append(
                f"at omega = {low:.6g} .. {high:.6g} rad/s the law gives no torque and any mean is in balance (the "
                "middle is shown): a mean torque would place it"
            )
    return found


def left_out(problem: SecondOrder, points: Floats) -> tuple[float, float]:
    """Largest share of the response in the harmonics H+1 .. 3H+8, estimated from the torque, and its omega [rad/s]."""
    h = len(problem.error) // 2
    most = 3 * h + 8
    samples = 4 * most
    system, n = problem.system, len(problem.error)
    u = points[:, :n] @ synthesis(h, samples)
    with np.errstate(all="ignore"):
        torque = (system.law.torque(u) + np.zeros_like(u)) @ analysis(most, samples)
        stiffness = np.mean(system.law.stiffness(u) + np.zeros_like(u), axis=1, keepdims=True)
        k = np.arange(h + 1, most + 1)
        w = points[:, -1:] / problem.turns * k
        response = np.hypot(torque[:, k], torque[:, most + k]) / np.hypot(stiffness - system.J * w * w, system.B * w)
        share = np.linalg.norm(response, axis=1) / np.maximum(np.linalg.norm(points[:, :n], axis=1), 1e-300)
    worst = int(np.argmax(np.where(np.isfinite(share), share, 0.0)))
    return float(share[worst]), float(points[worst, -1])


def floating(problem: SecondOrder, points: Floats) -> Any:
    """Whether the law gives no torque anywhere on an orbit that moves, for every point."""
    n = len(problem.error)
    u = points[:, :n] @ synthesis(n // 2, 4 * n)
    idle = np.all(problem.system.law.torque(u) + np.zeros_like(u) == 0.0, axis=1)
    return idle & (np.ptp(u, axis=1) > 0.0)
