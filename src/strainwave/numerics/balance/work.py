"""Buffers of the solvers of balance problems, and such a problem linearised as Python."""

from typing import Any, NamedTuple

import numpy as np

from ...protocols import Balance
from ...results import Floats


class Work(NamedTuple):
    """Buffers of one solver, so that nothing is allocated in its loop."""

    u: Floats
    f: Floats
    tau: Floats
    error: Floats
    z: Floats
    r: Floats
    column: Floats
    spare: Floats


def work_for(problem: Balance) -> Any:
    """Buffers for a problem."""
    n, samples = problem.size(), len(problem.angles)
    return Work(
        np.empty(samples), np.empty(samples), np.empty(n), np.empty(n), np.empty(n + 1), np.empty(n), np.empty(n),
        np.empty(n),
    )  # fmt: skip


def linearised(problem: Balance, z: Floats) -> tuple[Floats, Floats, Floats]:
    """Residual of any balance problem at z, and its derivatives by the coefficients and by the parameter."""
    n, work = problem.size(), work_for(problem)
    matrix = np.empty((n, n))
    problem.residual(z, work, work.r)
    problem.linearise(z, work, matrix, work.column)
    return work.r, matrix, work.column
