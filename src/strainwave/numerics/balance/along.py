"""Rates of a system and their derivatives at many samples of a motion, as one loop of machine code.

With a `strength` s what varies with the base angle at a fixed state is multiplied: f = m + s (f - m), with the mean m
over the angles `turn`. Without such angles nothing is.
"""

from typing import Any

import numpy as np

from ...compile.jit import axpy, chosen, kernel, kernel_as, routine
from ...results import Floats
from ...tree import with_leaf
from ..integration.steps import rates_of, times
from .rates import jacobians_at, rates_at

NO_TURN = np.empty(0)


@chosen
def column(zero: Any, y: Any, i: Any) -> Any:
    """Column i of an array as a tuple that is as long as `zero`."""
    return _items if len(zero) else _nothing


def _items(zero: Any, y: Any, i: Any) -> Any:
    return (y[y.shape[0] - len(zero), i], *column(zero[1:], y, i))


def _nothing(zero: Any, y: Any, i: Any) -> Any:
    return ()


@kernel
def put_column(values: Any, out: Any, i: Any) -> None:
    """Write a tuple to column i of an array."""
    for j in range(len(values)):
        out[j, i] = values[j]


@routine
def strengthened(system: Any, angle: float, y: Any, turn: Any, strength: float) -> Any:
    """Rates of a system of a strength at an angle [rad] and a state (a tuple)."""
    here = rates_of(system, angle, y)
    if len(turn) == 0:
        return here
    mean = times(0.0, here)
    for i in range(len(turn)):
        mean = axpy(mean, 1.0 / len(turn), rates_of(system, turn[i], y))
    return axpy(mean, strength, axpy(here, -1.0, mean))


def _rates_loops(system: Any, zero: Any, angles: Any, y: Any, turn: Any, strength: float, out: Any) -> None:
    for i in range(angles.shape[0]):
        put_column(strengthened(system, angles[i], column(zero, y, i), turn, strength), out, i)


@kernel_as(_rates_loops)
def rates_along(
    system: Any, zero: Any, angles: Floats, y: Floats, turn: Floats, strength: float, out: Floats
) -> None:  # fmt: skip
    """Write the rates (states, n) at base angles (n,) [rad] and states (states, n); `zero` is a tuple of zeros."""
    out[:] = _of_strength(rates_at, system, angles, y, turn, strength)


def _slopes_loops(
    system: Any, zero: Any, angles: Any, y: Any, turn: Any, strength: float, steps: Any, out: Any
) -> None:  # fmt: skip
    for i in range(angles.shape[0]):
        here = column(zero, y, i)
        for j in range(len(zero)):
            d = steps[j]
            after = strengthened(system, angles[i], with_leaf(here, j, here[j] + d), turn, strength)
            before = strengthened(system, angles[i], with_leaf(here, j, here[j] - d), turn, strength)
            for k in range(len(zero)):
                out[k, j, i] = (after[k] - before[k]) / (2.0 * d)


@kernel_as(_slopes_loops)
def slopes_along(
    system: Any, zero: Any, angles: Floats, y: Floats, turn: Floats, strength: float, steps: Floats, out: Floats
) -> None:  # fmt: skip
    """Write the derivatives (states, states, n) of the rates by the states: central differences of half length `steps`.

    In NumPy from the system's own `jacobian`, where it has one.
    """

    def slopes(system: Any, angles: Floats, y: Floats) -> Floats:
        return jacobians_at(system, angles, y, steps, 1.0)

    out[:] = _of_strength(slopes, system, angles, y, turn, strength)


def _of_strength(of: Any, system: Any, angles: Floats, y: Floats, turn: Floats, strength: float) -> Floats:
    here = of(system, angles, y)
    if not len(turn):
        return np.asarray(here)
    mean = of(system, turn, np.broadcast_to(y[..., None], (*y.shape, len(turn)))).mean(axis=-1)
    return np.asarray(mean + strength * (here - mean))
