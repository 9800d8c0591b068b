"""Sentences on what a response curve should not be trusted in, with the frequency and the remedy."""

from typing import Any

import numpy as np

from ..results import Branch, Floats
from .balance import SecondOrder
from .description import Survey
from .fourier import analysis, synthesis
from .half_wave import all_orders

NEVER_STABLE = "no point of it is stable"
MATTERS = 1e-3  # share of the response in the harmonics left out
LOOKED_AT = 12  # points of a curve


def remarks(curves: list[Survey], branches: list[Branch]) -> list[list[str]]:
    """List what to know about each of several response curves with equal harmonics."""
    few = [_few(curve.points) for curve in curves]
    ends = np.cumsum([0, *(len(points) for points in few)]).tolist()
    system = stacked([c.problem.system for c in curves], [len(points) for points in few])
    shares, harmonics = left_out(curves[0].problem._replace(system=system), np.concatenate(few))
    found = []
    for i, (curve, branch, points) in enumerate(zip(curves, branches, few, strict=True)):
        said: list[str] = []
        found.append(said)
        if not len(branch):
            continue
        if not branch.stable.any():
            said.append(NEVER_STABLE)
        own = shares[ends[i] : ends[i + 1]]
        worst = int(np.argmax(own))
        if own[worst] > MATTERS:
            said.append(
                f"at omega = {points[worst, -1]:.6g} rad/s the harmonics left out hold about "
                f"{min(100.0, 100.0 * own[worst]):.2g} % of the response: take more than {harmonics} harmonics"
            )
        loose = floating(curve.problem, curve.points)
        if loose is not None:
            low, high = np.min(curve.points[loose, -1]), np.max(curve.points[loose, -1])
            said.append(
                f"at omega = {low:.6g} .. {high:.6g} rad/s the law gives no torque and any mean is in balance (the "
                "middle is shown): a mean torque would place it"
            )
    return found


def _few(points: Floats) -> Floats:
    """Some points of a curve, and the largest."""
    largest = np.argmax(np.abs(points[:, :-1]).max(axis=1, initial=0.0)) if len(points) else 0
    return np.concatenate([points[:: max(1, len(points) // LOOKED_AT)], points[largest : largest + 1]])


def stacked(things: list[Any], counts: list[int]) -> Any:
    """Model of the class of several, whose numbers that differ are columns: each thing's own, `counts` times."""
    first = things[0]
    if isinstance(first, tuple):
        items = [stacked(list(some), counts) for some in zip(*things, strict=True)]
        make: Any = type(first)
        return make(*items) if hasattr(first, "_fields") else tuple(items)
    if isinstance(first, float) and any(thing != first for thing in things):
        return np.repeat(things, counts)[:, None]
    return first


def left_out(problem: SecondOrder, points: Floats) -> tuple[Floats, int]:
    """Share of the response in the harmonics H+1 .. 3H+8 at every point, estimated from the torque; H."""
    series, omega = all_orders(problem, points[:, :-1]), points[:, -1:]
    h = series.shape[1] // 2
    most = 3 * h + 8
    samples = 3 * most
    system = problem.system
    u = series @ synthesis(h, samples)
    with np.errstate(all="ignore"):
        torque = (system.law.torque(u) + np.zeros_like(u)) @ analysis(most, samples)
        stiffness = np.mean(system.law.stiffness(u) + np.zeros_like(u), axis=1, keepdims=True)
        w = omega / problem.turns * np.arange(h + 1, most + 1)
        beyond = np.hypot(torque[:, h + 1 : most + 1], torque[:, most + h + 1 :])
        response = beyond / np.hypot(stiffness - system.J * w * w, system.B * w)
        share = np.linalg.norm(response, axis=1) / np.maximum(np.linalg.norm(series, axis=1), 1e-300)
    return np.where(np.isfinite(share), share, 0.0), h


def floating(problem: SecondOrder, points: Floats) -> Any:
    """Whether the law gives no torque anywhere on an orbit that moves, for every point; None if on no orbit."""
    law, n = problem.system.law, len(problem.error)
    if law.torque(0.0) != 0.0 or law.stiffness(0.0) != 0.0:
        return None
    u = points[:, :n] @ problem.synthesis
    idle = np.all(law.torque(u) + np.zeros_like(u) == 0.0, axis=1) & (np.ptp(u, axis=1) > 0.0)
    return idle if np.any(idle) else None
