"""Largest values of a running integration, between its samples too: of the states, and of what a system has `watched`.

`watched(phase, y)` is a tuple of functions of the state, for instance the torque in a gear.
"""

import math
from typing import Any

import numpy as np

from ...base.protocols import System, omega_of
from ...base.results import Floats
from ...compile.elementwise import smaller
from ...compile.jit import kernel, routine
from ..addressed import watched
from .workspace import SHIFTED, Recording, length, row, shift

DIFFERENCE = 1e-5  # step of the differences that give the rates of what is watched, in units of 1 s and of 1/omega
TINY = 1e-200  # products of rates below it count as rest


@routine
def raise_peaks(
    system: System, omega: float, record: Recording, w: Floats, t: float, begin: int, t1: float, end: int
) -> None:
    """Raise the peaks of a record to the largest |value| from t to t1, whose states are in rows `begin` and `end`."""
    raise_to(record.peaks, 0, t1 - t, w, begin, end)
    if length(record.watch) > 0 and t1 > t:
        d = difference_step(omega, t1 - t)
        watch_with_rates(system, omega, t, w, begin, d, record.watch, 0)
        watch_with_rates(system, omega, t1, w, end, -d, record.watch, 2)
        raise_to(record.peaks, length(w), t1 - t, record.watch, 0, 2)


@kernel
def difference_step(omega: float, length: Any) -> Any:
    """Step of the differences at both ends of a stretch [s], which stay inside it."""
    return smaller(DIFFERENCE / (1.0 + abs(omega)), 0.5 * length)


@routine
def watch_with_rates(
    system: System, omega: float, t: float, w: Floats, state_row: int, d: float, watch: Floats, first: int
) -> None:
    """Write what is watched at a state to a row, and by a difference of d [s] its rates to the next."""
    x, v = row(watch, first), row(watch, first + 1)
    shift(w, state_row, d)
    watched(system, omega * t, row(w, state_row), x)
    watched(system, omega * (t + d), row(w, SHIFTED), v)
    for i in range(length(watch)):
        v[i] = (v[i] - x[i]) / d


def watched_ends(system: Any, run: Any, steps: Any) -> Any:
    """Value and rate at the begin, value and rate at the end of steps of a run, for each thing that is watched.

    `steps` are the numbers of the samples from which they lead.
    """
    ends, omega = steps + np.array([[0], [1]]), float(omega_of(system))
    t, y, k = run.t[ends], run.y[:, ends], run.rate[:, ends]
    d = difference_step(omega, t[1] - t[0]) * np.array([[1.0], [-1.0]])
    x, ahead = system.watched(omega * t, tuple(y)), system.watched(omega * (t + d), tuple(y + d * k))
    for now, after in zip(x, ahead, strict=True):
        at_ends, rates = np.broadcast_to(now, t.shape), np.broadcast_to((after - now) / d, t.shape)
        yield at_ends[0], rates[0], at_ends[1], rates[1]


@routine
def raise_to(largest: Floats, first: int, h: float, w: Floats, begin: int, end: int) -> None:
    """Raise `largest` to |x1| and, where a rate v changes sign, to the extreme of the cubic between.

    x and v are in one row and the next, x1 and v1 in another and the next; `largest` counts from `first` on.
    """
    x, v, x1, v1 = row(w, begin), row(w, begin + 1), row(w, end), row(w, end + 1)
    peaks = row(largest, 0)
    for i in range(length(w)):
        size = abs(x1[i])
        if v[i] * v1[i] < -TINY:
            c, d, rise = h * v[i], h * v1[i], x1[i] - x[i]
            a, b = c + d - 2.0 * rise, 3.0 * rise - 2.0 * c - d
            q = abs(b) + math.sqrt(b * b - 3.0 * a * c)
            # of both zeros of the slope 3 a s^2 + 2 b s + c the one between 0 and 1
            s = q / (3.0 * abs(a)) if b * c > 0.0 else abs(c) / q
            size = max(size, abs(x[i] + s * (c + s * (b + s * a))))
        peaks[first + i] = max(peaks[first + i], size)


@routine
def store_peaks(record: Recording, first: int, column: int) -> None:
    """Move the peaks of a record to a column of its table, from a row on, and begin again."""
    for i in range(length(record.peaks)):
        row(record.table, first + i)[column] = row(record.peaks, 0)[i]
        row(record.peaks, 0)[i] = 0.0
