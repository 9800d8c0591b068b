"""A balance problem linearised, and Newton's method."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ...compile.jit import kernel
from ...protocols import Balance
from ...results import Floats


def linearised(problem: Balance, z: Floats) -> tuple[Floats, Floats, Floats]:
    """Residual of any balance problem at z, and its derivatives by the coefficients and by the parameter."""
    n = problem.size()
    r, matrix, column = np.empty(n), np.empty((n, n)), np.empty(n)
    problem.run(_linearise, z, r, matrix, column)
    return r, matrix, column


@kernel
def _linearise(problem: Any, z: Any, r: Any, matrix: Any, column: Any) -> None:
    problem.residual(z, r)
    problem.linearise(z, matrix, column)


def least_step(matrix: Floats, residual: Floats) -> Floats | None:
    """Newton's step, the shortest where the matrix is singular; None where it is not finite."""
    if not (np.all(np.isfinite(matrix)) and np.all(np.isfinite(residual))):  # LAPACK would print and give up
        return None
    step = np.linalg.lstsq(matrix, residual, rcond=None)[0]
    return np.asarray(step) if np.all(np.isfinite(step)) else None


def newton(
    equations: Callable[[Floats], tuple[Floats, Floats]], x: Floats, scale: Floats, tiny: float,
    *, most: int = 20, far: float = 1e3, solve: Callable[..., Any] = np.linalg.solve,
) -> Floats | None:  # fmt: skip
    """Root of equations, which give values and derivatives at x, or None; steps count in units `scale` of the unknowns.

    It ends at a step below `tiny`, at one after which the next would be far below it, or at one below a thousand times
    that where rounding keeps them from shrinking.
    """
    last = np.inf
    for _ in range(most):
        values, derivatives = equations(x)
        try:
            step = solve(derivatives * scale, values)
        except np.linalg.LinAlgError:
            return None
        x = x - step * scale
        size = float(np.linalg.norm(step))
        if not size < far:
            return None
        following = size * (size / last) ** 2 if last < np.inf else np.inf  # where the steps shrink quadratically
        if size < tiny or (size < 1e3 * tiny and size > 0.3 * last) or following < 0.01 * tiny:
            return x
        last = size
    return None
