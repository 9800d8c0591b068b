"""Schemes: one step of an integration method, as a model with methods, so that kernels run anyone's.

A scheme of fixed steps has

- `step(system, phase, turn, y, h)`: the state after a step of h in time and `turn` in phase,
- `order()`: the order of the method; 4 stands for all higher ones.

A scheme of adaptive steps has

- `attempt(system, phase, turn, y, h, rate)`: from y and its rate the new state, its rate, the estimate of the error,
  and a vector d: inside the step the solution is the cubic through both ends plus s^2 (1 - s)^2 d at the fraction s,
- `error_order()`: the power of h that the estimate grows with,
- `stable()`: the length of its real interval of stability,
- `looks()`: fractions between which and its stages there is at most an eighth of a step.

`runge_kutta` makes the scheme of a Butcher tableau, which has all of these.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...base.arguments import typed
from ...base.protocols import System
from ...base.quantities import Reals, States, shown
from ...base.results import Floats
from ...compile.jit import chosen
from ...compile.tree import alike, times
from .steps import combined, dop8_step, dopri5_step, rk4_step

HEAVIEST = 1e6  # weight of a stage: products of fifty still fit a float
EIGHTHS = (0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875)


class Classical(NamedTuple):
    """The classical Runge-Kutta step of fourth order."""

    def order(self) -> int:
        """Order of the method."""
        return 4

    def step(self, system: System, phase: Reals, turn: Reals, y: States, h: Reals) -> Any:
        """State after a step."""
        return rk4_step(system, phase, turn, y, h)


class EighthOrder(NamedTuple):
    """The step of DOP853."""

    def order(self) -> int:
        """4: the order of what the measures see between steps."""
        return 4

    def step(self, system: System, phase: Reals, turn: Reals, y: States, h: Reals) -> Any:
        """State after a step."""
        return dop8_step(system, phase, turn, y, h)


class DormandPrince(NamedTuple):
    """The step of Dormand & Prince 5(4)."""

    def attempt(self, system: Any, phase: Reals, turn: Reals, y: Any, h: Reals, rate: Any) -> Any:
        """State after a step, its rate, the error, and the vector of the dense output."""
        return dopri5_step(system, phase, turn, y, h, rate)

    def error_order(self) -> int:
        """Power of h that the estimate of the error grows with."""
        return 5

    def stable(self) -> float:
        """Length of the real interval of stability (Hairer & Wanner II, sec. IV.2)."""
        return 3.3

    def looks(self) -> Any:
        """Fractions of a step where its stages are more than 1/8 of it apart."""
        return 0.1, 0.425, 0.55, 0.675


class Tableau(NamedTuple):
    """Scheme of a Butcher tableau; `runge_kutta` makes it.

    `c`, `a`, `b` are the tableau; `error` and `dense` the weights of the estimate of the error and of the dense output,
    the last one that of the rate at the end; `orders` those of the method and of the estimate.
    """

    c: Any
    a: Any
    b: Any
    error: Any
    dense: Any
    orders: tuple[int, int]
    interval: float

    def order(self) -> int:
        """Order of the method."""
        return self.orders[0]

    def step(self, system: System, phase: Reals, turn: Reals, y: States, h: Reals) -> Any:
        """State after a step."""
        first = times(h, system.rhs(phase, y))
        return combined(y, self.b, stages(self.a[1:], self.c[1:], system, phase, turn, y, h, (first,)))

    def attempt(self, system: Any, phase: Reals, turn: Reals, y: Any, h: Reals, rate: Any) -> Any:
        """State after a step, its rate, the error, and the vector of the dense output."""
        k = stages(self.a[1:], self.c[1:], system, phase, turn, y, h, (times(h, rate),))
        y1 = combined(y, self.b, k)
        new_rate = system.rhs(phase + turn, y1)
        nothing, k = alike(y, 0.0), (*k, times(h, new_rate))
        return y1, new_rate, combined(nothing, self.error, k), combined(nothing, self.dense, k)

    def error_order(self) -> int:
        """Power of h that the estimate of the error grows with."""
        return self.orders[1]

    def stable(self) -> float:
        """Length of the real interval of stability."""
        return self.interval

    def looks(self) -> Any:
        """Fractions between which there is an eighth of a step."""
        return EIGHTHS


@chosen
def stages(a: Any, c: Any, system: Any, phase: Reals, turn: Reals, y: Any, h: Reals, k: Any) -> Any:
    """Tuple of the rates of all stages, times h, from those of the first ones."""
    return _more_stages if len(a) else _no_more_stages


def _more_stages(a: Any, c: Any, system: Any, phase: Any, turn: Any, y: Any, h: Any, k: Any) -> Any:
    new = times(h, system.rhs(phase + turn * c[0], combined(y, a[0], k)))
    return stages(a[1:], c[1:], system, phase, turn, y, h, (*k, new))


def _no_more_stages(a: Any, c: Any, system: System, phase: Reals, turn: Reals, y: States, h: Reals, k: Any) -> Any:
    return k


@typed
def runge_kutta(
    a: Sequence[Sequence[float]],
    b: Sequence[float],
    *,
    embedded: Sequence[float] | None = None,
    dense: Sequence[float] | None = None,
) -> Tableau:
    """Scheme of an explicit Runge-Kutta method, for `FixedStep` and, with `embedded`, for `AdaptiveStep`.

    Parameters
    ----------
    a : sequence of (i,) sequences
        Row i holds the weights of the i stages before; the first row is empty.
    b : (stages,) sequence
        Weights of the stages in the step.
    embedded : (stages,) or (stages + 1,) sequence, optional
        Weights of the second solution, whose difference estimates the error; the last one that of the rate at the end.
    dense : (stages,) or (stages + 1,) sequence, optional
        Weights of the vector d: inside the step the solution is the cubic through both ends and their rates plus
        s^2 (1 - s)^2 d. Left out, the cubic alone: for estimates of an order up to the third.

    Returns
    -------
    Tableau
        A scheme whose numbers have no unit, for `FixedStep` or `AdaptiveStep`.

    Raises
    ------
    ValueError
        If a row has another length, weights do not add up to 1, or an estimate of fourth order comes without `dense`.

    References
    ----------
    Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I, 2nd ed., secs. II.1 (the conditions of order)
    and II.6.
    """
    n = len(b)
    rows = tuple(_weights(f"row {i} of a", row, (i,)) for i, row in enumerate(a))
    if len(rows) != n:
        raise ValueError(f"a has {len(rows)} rows and b {n} weights; give each stage a row and a weight")
    matrix = np.array([[*row, *[0.0] * (n + 1 - len(row))] for row in (*rows, _weights("b", b, (n,)))])
    weights, orders, error = matrix[-1], [_order(matrix, matrix[-1])], np.zeros(n + 1)
    if embedded is not None:
        second = np.resize([*_weights("embedded", embedded, (n, n + 1)), 0.0], n + 1)
        orders.append(_order(matrix, second))
        error = weights - second
    if not all(orders):
        raise ValueError("the weights b, and those embedded, must add up to 1")
    if len(orders) == 2 and orders[1] == orders[0] == 4 and dense is None:
        raise ValueError(
            "between the ends of its steps a method with an estimate of fourth order needs `dense` as well: give the "
            "weights of its dense output, or use it with FixedStep"
        )
    between = () if dense is None else _weights("dense", dense, (n, n + 1))
    c = tuple(matrix[:-1].sum(axis=1).tolist())
    known = tuple(error.tolist()) if embedded is not None else ()
    return Tableau(c, rows, tuple(weights[:n].tolist()), known, between, (orders[0], 1 + min(orders)), _stable(matrix))


def _weights(name: str, row: Any, lengths: tuple[int, ...]) -> tuple[float, ...]:
    try:
        found = tuple(float(weight) for weight in row)
    except (TypeError, ValueError, OverflowError):
        found = (np.nan,)
    if len(found) not in lengths or not np.all(np.abs(found) <= HEAVIEST):
        raise ValueError(
            f"{name} is {shown(row)}; it must be {lengths[0]} finite weights up to {HEAVIEST:g}, of the stages before"
        )
    return found


def _order(matrix: Floats, weights: Floats) -> int:
    """Order of a method with these weights, up to 4; 0 where it has none."""
    c = matrix.sum(axis=1)
    trees = [
        [(np.ones_like(c), 1.0)],
        [(c, 1 / 2)],
        [(c * c, 1 / 3), (matrix @ c, 1 / 6)],
        [(c**3, 1 / 4), (c * (matrix @ c), 1 / 8), (matrix @ c**2, 1 / 12), (matrix @ matrix @ c, 1 / 24)],
    ]
    met = [all(abs(weights @ tree - value) < 1e-9 for tree, value in level) for level in trees]
    return [*met, False].index(False)


def _stable(matrix: Floats) -> float:
    """Length of the real interval of stability of the method in the last row of a matrix."""
    inside, ones = matrix[:-1, :-1], np.ones(len(matrix) - 1)
    z = np.linspace(0.0, 2.0 * len(ones) ** 2, 2000)[1:]  # no polynomial with so many stages is stable beyond
    growth = [1.0 - s * matrix[-1, :-1] @ np.linalg.solve(np.eye(len(ones)) + s * inside, ones) for s in z]
    return float(z[max(int(np.argmax(np.abs(growth) > 1.0 + 1e-9)), 1) - 1])
