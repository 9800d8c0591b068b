"""One periodic orbit of a general system, by harmonic balance in all its states."""

from typing import Any

import numpy as np

from ...quantities import parameters
from ...results import Floats, Orbit, Status
from ..balance.first_order import FirstOrder, first_order
from ..balance.fourier import from_blocks
from ..balance.harmonics import grown, starting_harmonics
from ..balance.truncation import tail_along
from ..continuation.passage import linear_start, settled_start
from ..continuation.trace import solve
from ..stability.first_order import floquet_of
from ..stability.second_order import displacement_peaks


def general_orbit(
    system: Any, harmonics: int | None, guess: Floats | None, period: int, tail_goal: float, most: int
) -> Orbit:
    """Orbit of a system with `rhs(phase, y)` at its own omega; `guess` lists coefficients (2H+1, states)."""
    names = [p.path for p in parameters(system) if isinstance(p.value, float)]
    leaf = names.index("omega") if "omega" in names else -1
    h = starting_harmonics(system, harmonics, period)

    def balanced(h: int, aim: float) -> tuple[tuple[FirstOrder, Any, Any], float]:
        nonlocal guess
        problem = first_order(system, leaf, leaf, h, period)
        found = _solution(problem, guess)
        if found is None:
            return (problem, None, None), 0.0
        guess, tail = from_blocks(problem.states(found).T), tail_along(problem, found[None, :], aim)
        return (problem, found, tail), tail.worst

    problem, found, tail = grown(balanced, h, most if harmonics is None else h, tail_goal)
    states = len(problem.sizes)
    if found is None:
        message = (
            f"no periodic orbit found at omega = {problem.omega:.6g} rad/s: Newton's method failed from the guess, the "
            "linear response and an integration; give a guess, or continue from a frequency with a small response"
        )
        nothing, unknown = np.zeros((3, states)), np.full(states, 0j)
        return Orbit(problem.omega, period, nothing, 0.0, unknown, False, 0.0, Status.NO_CONVERGENCE, message)
    floquet = floquet_of(problem, found[None, :])[0]
    series = problem.states(found)
    return Orbit(
        problem.omega, period, from_blocks(series.T), float(displacement_peaks(series[:1])[0]), floquet,
        bool(abs(floquet[0]) < 1.0), tail.share, *tail.verdict(Status.OK, "finished", "omega", problem.omega),
    )  # fmt: skip


def _solution(problem: FirstOrder, guess: Floats | None) -> Floats | None:
    if guess is None:
        found = linear_start(problem, problem.omega)
        return settled_start(problem, problem.omega) if found is None else found
    if guess.shape[1] != len(problem.sizes):
        states = len(problem.sizes)
        raise ValueError(f"guess has {guess.shape[1]} states; {type(problem.system).__name__} has {states}")
    return solve(problem, problem.point(guess, problem.omega))
