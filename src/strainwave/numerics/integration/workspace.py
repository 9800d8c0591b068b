"""Workspace of a march: rows of states that its kernels share.

A state's rates are in the row after it. `Y` is the state at the begin of a step, `Y1` that at its end, `INSIDE` and
`BEFORE` are those at a sample and at the one before it; a scheme writes the rows from `Y1` to `DENSE`. `SHIFTED` is
next to one of them.
"""

from typing import Any, NamedTuple

import numpy as np

from ...compile.address import beyond, pointer
from ...compile.jit import kernel, kernel_as, routine
from ...results import Floats
from .steps import dense_weights, weighted

Y, K, Y1, K1, ERROR, DENSE, INSIDE, RATE, BEFORE, _, SHIFTED, CHANGE = range(12)
ROWS = 12


def workspace(y: Any) -> Floats:
    """Workspace of a march from the state y."""
    w = np.zeros((ROWS, len(y)))
    w[Y] = y
    return w


class Rows(NamedTuple):
    """An array with two axes as machine code hands it on: its first entry, the length of its rows, their order."""

    first: Any
    length: int
    turn: int


@kernel_as(lambda w: Rows(pointer(w), w.shape[1], 0), inline=True)
def rows(w: Floats) -> Any:
    """Rows of an array, which the functions below take."""
    return w


@kernel_as(lambda w, i: beyond(w.first, (i ^ w.turn) * w.length), inline=True)
def row(w: Any, i: int) -> Any:
    """Row number i."""
    return w[i]


@kernel_as(lambda w: w.length, inline=True)
def length(w: Any) -> int:
    """Length of the rows: of a workspace the number of states."""
    return int(w.shape[1])


@kernel_as(lambda w: Rows(w.first, w.length, w.turn ^ Y1), inline=True)
def turned(w: Floats) -> Any:
    """Workspace where the end of a step is the begin of the next; what the other rows hold is lost."""
    w[: K1 + 1] = w[[Y1, K1, Y, K]]
    return w


@kernel
def move(w: Any, start: int, into: Any, to: int) -> None:
    """Copy a state and its rates to rows of a workspace."""
    y, k, new, new_rate = row(w, start), row(w, start + 1), row(into, to), row(into, to + 1)
    for i in range(length(w)):
        new[i], new_rate[i] = y[i], k[i]


@routine
def shift(w: Any, start: int, d: float) -> None:
    """Let `SHIFTED` be a state after a time d [s] with its rates."""
    y, k, out = row(w, start), row(w, start + 1), row(w, SHIFTED)
    for i in range(length(w)):
        out[i] = y[i] + d * k[i]


@routine
def look(w: Any, s: float, h: float) -> None:
    """Let `INSIDE` be the state at the fraction s of a step of h."""
    y, k, y1, k1, dense, out = row(w, Y), row(w, K), row(w, Y1), row(w, K1), row(w, DENSE), row(w, INSIDE)
    a = dense_weights(s, h)
    for i in range(length(w)):
        out[i] = weighted(a, y[i], k[i], y1[i], k1[i], dense[i])
