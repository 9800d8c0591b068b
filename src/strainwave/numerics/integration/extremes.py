"""Largest values of a running integration, between its samples too: of the states, and of what a system has `watched`.

`watched(phase, y)` is a tuple of functions of the state, for instance the torque in a gear.
"""

import math
from typing import Any

import numpy as np

from ...base.choices import smaller
from ...base.protocols import omega_of
from ...compile.jit import kernel, routine
from ..addressed import watched
from .attempts import SHIFTED, length, row, shift

DIFFERENCE = 1e-5  # step of the differences that give the rates of what is watched, in units of 1 s and of 1/omega

TINY = 1e-200  # products of rates below it count as rest


@routine
def widen(
    system: Any, omega: float, most: Any, seen: Any, w: Any, t: float, place: int, t1: float, place1: int
) -> None:
    """Raise `most` to the largest |value| after t until t1, from the states in two rows.

    The rows of `seen` are for what is watched, with its rates, at both.
    """
    raise_to(most, 0, t1 - t, w, place, place1)
    if length(seen) > 0 and t1 > t:
        d = inside(omega, t1 - t)
        see(system, omega, t, w, place, d, seen, 0)
        see(system, omega, t1, w, place1, -d, seen, 2)
        raise_to(most, length(w), t1 - t, seen, 0, 2)


@kernel
def inside(omega: float, length: Any) -> Any:
    """Step of the differences at both ends of a stretch [s], which stay inside it."""
    return smaller(DIFFERENCE / (1.0 + abs(omega)), 0.5 * length)


@routine
def see(system: Any, omega: float, t: float, w: Any, place: int, d: float, seen: Any, to: int) -> None:
    """Write what is watched at a state to a row, and by a difference of d [s] its rates to the next."""
    x, v = row(seen, to), row(seen, to + 1)
    shift(w, place, d)
    watched(system, omega * t, row(w, place), x)
    watched(system, omega * (t + d), row(w, SHIFTED), v)
    for i in range(length(seen)):
        v[i] = (v[i] - x[i]) / d


def watched_ends(system: Any, run: Any, steps: Any) -> Any:
    """Value and rate at the begin, value and rate at the end of steps of a run, for each thing that is watched.

    `steps` are the numbers of the samples from which they lead.
    """
    ends, omega = steps + np.array([[0], [1]]), float(omega_of(system))
    t, y, k = run.t[ends], run.y[:, ends], run.rate[:, ends]
    d = inside(omega, t[1] - t[0]) * np.array([[1.0], [-1.0]])
    x, ahead = system.watched(omega * t, tuple(y)), system.watched(omega * (t + d), tuple(y + d * k))
    for value, after in zip(x, ahead, strict=True):
        at_ends, rates = np.broadcast_to(value, t.shape), np.broadcast_to((after - value) / d, t.shape)
        yield at_ends[0], rates[0], at_ends[1], rates[1]


@routine
def raise_to(largest: Any, first: int, h: float, w: Any, place: int, place1: int) -> None:
    """Raise `largest` to |x1| and, where a rate v changes sign, to the extreme of the cubic between.

    x and v are in one row and the next, x1 and v1 in another and the next; `largest` counts from `first` on.
    """
    x, v, x1, v1 = row(w, place), row(w, place + 1), row(w, place1), row(w, place1 + 1)
    most = row(largest, 0)
    for i in range(length(w)):
        size = abs(x1[i])
        if v[i] * v1[i] < -TINY:
            c, d, rise = h * v[i], h * v1[i], x1[i] - x[i]
            a, b = c + d - 2.0 * rise, 3.0 * rise - 2.0 * c - d
            q = abs(b) + math.sqrt(b * b - 3.0 * a * c)
            # of both zeros of the slope 3 a s^2 + 2 b s + c the one between 0 and 1
            s = q / (3.0 * abs(a)) if b * c > 0.0 else abs(c) / q
            size = max(size, abs(x[i] + s * (c + s * (b + s * a))))
        most[first + i] = max(most[first + i], size)


@routine
def put(most: Any, table: Any, first: int, place: int) -> None:
    """Move `most` to a column of the table from a row on, and begin again."""
    for i in range(length(most)):
        row(table, first + i)[place] = row(most, 0)[i]
        row(most, 0)[i] = 0.0
