"""Starts of branches: solutions near the linear response, from strong damping, and from an integration."""

import numpy as np

from ...base.branch_labels import END
from ...base.protocols import Balance, omega_of
from ...base.results import Floats
from ...compile.tree import with_leaf
from ..integration.simulate import simulate
from .trace import solve, trace

GROWTH = 1e7  # an orbit this many times larger than at the start of its branch has no bound
SETTLING = 200  # periods integrated


def linear_start(problem: Balance, value: float) -> Floats | None:
    """Solution at a value of the parameter near the linear response."""
    return solve(problem, problem.linear_response(value))


def damped_start(problem: Balance, value: float) -> Floats | None:
    """Solution at a value of the parameter that a branch in the damping B connects with strong damping.

    With damping strong enough the orbit is near the linear response and alone; the branch comes down from there to the
    damping asked for, unless orbits grow beyond all bounds on the way.
    """
    damping = problem.damping_leaf()
    if damping is None or problem.leaf == damping:
        return None
    system = with_leaf(problem.system, problem.leaf, float(value))
    damped = problem._replace(system=system, leaf=damping)
    strong = max(system.B, system.J * abs(system.omega))
    for _ in range(20):
        start = solve(damped, damped.linear_response(strong))
        if start is not None:
            break
        strong *= 4.0
    else:
        return None
    branch = trace(damped, start, -1.0, system.B, strong, 0.2, growth=GROWTH)
    if branch.outcome != END or branch.points[-1, -1] != system.B:
        return None
    return solve(problem, np.append(branch.points[-1, :-1], value))


def settled_start(problem: Balance, value: float) -> Floats | None:
    """Solution at a value of the parameter near the motion to which an integration from rest has settled."""
    system = with_leaf(problem.system, problem.leaf, float(value))
    base = float(omega_of(system))
    turn = 2.0 * np.pi * problem.turns / base
    times = turn * SETTLING + problem.angles / base
    try:
        motion = simulate(system, np.zeros(problem.state_count()), np.concatenate([[0.0], times]))
    except ValueError:  # there is no motion from rest
        return None
    if not motion.status:
        return None
    return solve(problem, problem.sampled(motion.y[:, 1:], value))
