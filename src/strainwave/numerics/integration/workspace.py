"""Workspace of a march: rows of states that its kernels share, and the steps of a scheme there.

A state's rates are in the row after it. `Y` is the state at the begin of a step, `Y1` that at its end, `INSIDE` and
`BEFORE` are those at a sample and at the one before it; a scheme writes the rows from `Y1` to `DENSE`. `SHIFTED` is
next to one of them.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...compile.address import ByAddress, at, call, pointer, put_at
from ...compile.jit import entry, kernel, kernel_as
from ...results import Floats
from ..addressed import Tupled, system_by_address
from .steps import dense_output

Y, K, Y1, K1, ERROR, DENSE, INSIDE, RATE, BEFORE, _, SHIFTED, CHANGE = range(12)
ROWS = 12
SMALL = 2  # states up to which a step is compiled with the system: calls of it would cost more than what it computes


class SchemeAt(NamedTuple):
    """A scheme for one system by the addresses of their words and of the function that takes a step."""

    words: int
    step_at: int


def scheme_by_address(scheme: Any, system: Any, states: int, adaptive: bool) -> ByAddress:
    """A scheme for kernels, to step a system of so many states."""
    row = states
    kinds = (float, float, row, float, *[row] * (5 if adaptive else 1))

    def addressed(words: Callable[[Any], int]) -> SchemeAt:
        part = system
        if states > SMALL:
            known = system_by_address(system, states).addressed(words)
            part = Tupled(known.words, known.rates_at)
        return SchemeAt(words((scheme, part)), entry(_attempt if adaptive else _step, (scheme, part), *kinds))

    return ByAddress((scheme, system), addressed)


def _attempt(
    pair: Any, phase: Any, turn: Any, y: Any, h: Any, rate: Any, y1: Any, k1: Any, error: Any, dense: Any
) -> None:
    scheme, system = at(pair)
    end, end_rate, missed, between = scheme.attempt(system, phase, turn, at(y), h, at(rate))
    put_at(y1, end)
    put_at(k1, end_rate)
    put_at(error, missed)
    put_at(dense, between)


def _step(pair: Any, phase: Any, turn: Any, y: Any, h: Any, y1: Any) -> None:
    scheme, system = at(pair)
    put_at(y1, scheme.step(system, phase, turn, at(y), h))


def _attempt_loops(pair: Any, phase: Any, turn: Any, h: Any, w: Any) -> None:
    given, made = (pointer(w[Y]), h, pointer(w[K])), (pointer(w[Y1]), pointer(w[K1]), pointer(w[ERROR]))
    call(pair.step_at, pair.words, (phase, turn, *given, *made, pointer(w[DENSE])))


@kernel_as(_attempt_loops, inline=True)
def attempt(pair: Any, phase: float, turn: float, h: float, w: Floats) -> None:
    """Try a step of h in time and `turn` in phase: its end, the error, and the vector of the dense output."""
    (scheme, system), (y, rate) = pair, w[Y : K + 1].tolist()
    w[Y1 : DENSE + 1] = scheme.attempt(system, phase, turn, tuple(y), h, tuple(rate))


def _step_loops(pair: Any, phase: Any, turn: Any, h: Any, w: Any) -> None:
    call(pair.step_at, pair.words, (phase, turn, pointer(w[Y]), h, pointer(w[Y1])))


@kernel_as(_step_loops, inline=True)
def step(pair: Any, phase: float, turn: float, h: float, w: Floats) -> None:
    """Take a step of h in time and `turn` in phase: the state at its end, without its rates."""
    scheme, system = pair
    w[Y1] = scheme.step(system, phase, turn, tuple(w[Y].tolist()), h)


def workspace(y: Any) -> Floats:
    """Workspace of a march from the state y."""
    w = np.zeros((ROWS, len(y)))
    w[Y] = y
    return w


@kernel
def move(w: Any, row: int, to: int) -> None:
    """Copy a state and its rates to other rows."""
    for i in range(w.shape[1]):
        w[to, i], w[to + 1, i] = w[row, i], w[row + 1, i]


@kernel
def shift(w: Any, row: int, d: float) -> None:
    """Let `SHIFTED` be a state after a time d [s] with its rates."""
    for i in range(w.shape[1]):
        w[SHIFTED, i] = w[row, i] + d * w[row + 1, i]


@kernel
def look(w: Any, s: float, h: float) -> None:
    """Let `INSIDE` be the state at the fraction s of a step of h."""
    for i in range(w.shape[1]):
        w[INSIDE, i] = dense_output(s, h, w[Y, i], w[K, i], w[Y1, i], w[K1, i], w[DENSE, i])
