"""Workspace of a march: rows of states that the kernels of integration share.

A state is in a row and its time derivatives in the next: at the begin of a step in `Y` and `K`, at its end in `Y1` and
`K1`. `DENSE` is the vector of the dense output.
"""

from typing import Any, NamedTuple

import numpy as np

from ...base.quantities import States
from ...base.results import Floats
from ...compile.calls import beyond, pointer
from ...compile.jit import kernel, kernel_as, routine
from .steps import dense_weights, weighted

Y, K, Y1, K1, ERROR, DENSE, INSIDE, RATE, BEFORE, _, SHIFTED, CHANGE = range(12)
ROWS = 12


def workspace(y: States) -> Floats:
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
def row(w: Floats, i: int) -> Any:
    """Row number i."""
    return w[i]


@kernel_as(lambda w: w.length, inline=True)
def length(w: Floats) -> int:
    """Length of the rows: of a workspace the number of states."""
    return int(w.shape[1])


@kernel_as(lambda w: Rows(w.first, w.length, w.turn ^ Y1), inline=True)
def turned(w: Floats) -> Any:
    """Workspace where the end of a step is the begin of the next; what the other rows hold is lost."""
    w[: K1 + 1] = w[[Y1, K1, Y, K]]
    return w


@kernel
def move(w: Floats, start: int, into: Floats, to: int) -> None:
    """Copy a state and its rates to rows of a workspace."""
    y, k, new, new_rate = row(w, start), row(w, start + 1), row(into, to), row(into, to + 1)
    for i in range(length(w)):
        new[i], new_rate[i] = y[i], k[i]


@routine
def shift(w: Floats, start: int, d: float) -> None:
    """Let `SHIFTED` be a state after a time d [s] with its rates."""
    y, k, out = row(w, start), row(w, start + 1), row(w, SHIFTED)
    for i in range(length(w)):
        out[i] = y[i] + d * k[i]


@routine
def interpolate(w: Floats, s: float, h: float) -> None:
    """Let `INSIDE` be the state at the fraction s of a step of h."""
    y, k, y1, k1, dense, out = row(w, Y), row(w, K), row(w, Y1), row(w, K1), row(w, DENSE), row(w, INSIDE)
    a = dense_weights(s, h)
    for i in range(length(w)):
        out[i] = weighted(a, y[i], k[i], y1[i], k1[i], dense[i])


@kernel
def store(table: Floats, column: int, t: float, w: Floats, start: int) -> None:
    """Write one sample (time, state, rate) to a column of the table."""
    n, y, k = length(w), row(w, start), row(w, start + 1)
    row(table, 0)[column] = t
    for i in range(n):
        row(table, 1 + i)[column], row(table, 1 + n + i)[column] = y[i], k[i]


class Recording(NamedTuple):
    """Arrays that a march records in.

    `samples` (1, n) are times [s] to record, (1, 0) for every step; `table` has a column for each, with time, states,
    rates and the largest values since the one before. `peaks` (1, m) are the largest values up to now, of the states
    and of what is watched, `watch` (4, watched) a workspace for the latter.
    """

    samples: Any
    peaks: Any
    watch: Any
    table: Any


@kernel
def recording_rows(record: Recording) -> Recording:
    """Rows of the arrays of a recording."""
    return Recording(rows(record.samples), rows(record.peaks), rows(record.watch), rows(record.table))
