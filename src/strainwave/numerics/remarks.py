"""Sentences on what a response curve should not be trusted in, with the frequency and the remedy."""

from typing import Any

import numpy as np

from ..results import Branch, Floats
from .balance import SecondOrder
from .fourier import analysis, synthesis
from .half_wave import all_orders

MATTERS = 1e-3  # share of the response in the harmonics left out
LOOKED_AT = 12  # points of a curve


def remarks(problem: Any, branch: Branch, points: Floats) -> list[str]:
    """List what to know about a response curve: points are (coefficients in blocks, omega last)."""
    found: list[str] = []
    if not len(branch):
        return found
    if not np.any(branch.stable):
        found.append("no point of it is stable")
    if isinstance(problem, SecondOrder):
        few = points[:: max(1, len(points) // LOOKED_AT)]
        largest = points[np.argmax(np.abs(points[:, :-1]).max(axis=1))]
        share, at, harmonics = left_out(problem, np.vstack([few, largest]))
        if share > MATTERS:
            found.append(
                f"at omega = {at:.6g} rad/s the harmonics left out hold about {min(100.0, 100.0 * share):.2g} % of the "
                f"response: take more than {harmonics} harmonics"
            )
        loose = floating(problem, points)
        if np.any(loose):
            low, high = np.min(points[loose, -1]), np.max(points[loose, -1])
            found.append(
                f"at omega = {low:.6g} .. {high:.6g} rad/s the law gives no torque and any mean is in balance (the "
                "middle is shown): a mean torque would place it"
            )
    return found


def left_out(problem: SecondOrder, points: Floats) -> tuple[float, float, int]:
    """Largest share of the response in the harmonics H+1 .. 3H+8, estimated from the torque; its omega [rad/s]; H."""
    series, omega = all_orders(problem, points[:, :-1]), points[:, -1:]
    h = series.shape[1] // 2
    most = 3 * h + 8
    samples = 4 * most
    system = problem.system
    u = series @ synthesis(h, samples)
    with np.errstate(all="ignore"):
        torque = (system.law.torque(u) + np.zeros_like(u)) @ analysis(most, samples)
        stiffness = np.mean(system.law.stiffness(u) + np.zeros_like(u), axis=1, keepdims=True)
        k = np.arange(h + 1, most + 1)
        w = omega / problem.turns * k
        response = np.hypot(torque[:, k], torque[:, most + k]) / np.hypot(stiffness - system.J * w * w, system.B * w)
        share = np.linalg.norm(response, axis=1) / np.maximum(np.linalg.norm(series, axis=1), 1e-300)
    worst = int(np.argmax(np.where(np.isfinite(share), share, 0.0)))
    return float(share[worst]), float(omega[worst, 0]), h


def floating(problem: SecondOrder, points: Floats) -> Any:
    """Whether the law gives no torque anywhere on an orbit that moves, for every point."""
    law, n = problem.system.law, len(problem.error)
    if law.torque(0.0) != 0.0 or law.stiffness(0.0) != 0.0:
        return np.zeros(len(points), bool)
    u = points[:, :n] @ problem.synthesis
    idle = np.all(law.torque(u) + np.zeros_like(u) == 0.0, axis=1)
    return idle & (np.ptp(u, axis=1) > 0.0)
