"""Largest values of a running integration, between its samples too: of the states, and of what a system has `watched`.

`watched(phase, y)` is a tuple of functions of the state, for instance the torque in a gear.
"""

import math
from typing import Any

from ...choices import smaller
from ...compile.jit import chosen, kernel, routine
from ...compile.tuples import axpy, times
from ...law import has
from ...protocols import omega_of
from ...results import Trajectory

DIFFERENCE = 1e-5  # step of the differences that give the rates of what is watched, in units of 1 s and of 1/omega

TINY = 1e-200  # products of rates below it count as rest


@chosen
def widen(system: Any, omega: float, most: Any, t: float, y: Any, k: Any, t1: float, y1: Any, k1: Any) -> Any:
    """Raise `most` (an array) to the largest |value| after t until t1, from the states and their rates at both."""
    return _widen_both if has(system, "watched") else _widen_states


def _widen_states(system: Any, omega: float, most: Any, t: float, y: Any, k: Any, t1: float, y1: Any, k1: Any) -> None:
    raise_to(most, 0, t1 - t, y, k, y1, k1)


def _widen_both(system: Any, omega: float, most: Any, t: float, y: Any, k: Any, t1: float, y1: Any, k1: Any) -> None:
    raise_to(most, 0, t1 - t, y, k, y1, k1)
    if t1 > t:
        raise_to(most, len(y), t1 - t, *ends_of(system, omega, t, y, k, t1, y1, k1))


@routine
def watched(system: Any, phase: Any, y: Any) -> Any:
    """What the system has watched at a base angle and a state."""
    return system.watched(phase, y)


@kernel
def ends_of(system: Any, omega: float, t: Any, y: Any, k: Any, t1: Any, y1: Any, k1: Any) -> Any:
    """What is watched at both ends of a stretch, with its rates there: by differences that stay inside the stretch."""
    d = smaller(DIFFERENCE / (1.0 + abs(omega)), 0.5 * (t1 - t))
    x, ahead = watched(system, omega * t, y), watched(system, omega * (t + d), axpy(y, d, k))
    x1, back = watched(system, omega * t1, y1), watched(system, omega * (t1 - d), axpy(y1, -d, k1))
    return x, times(1.0 / d, axpy(ahead, -1.0, x)), x1, times(1.0 / d, axpy(x1, -1.0, back))


def watched_ends(system: Any, run: Trajectory) -> Any:
    """Value and rate at the begin, value and rate at the end of all steps of a run, for each thing that is watched."""
    omega, early, late = float(omega_of(system)), slice(None, -1), slice(1, None)
    ends = ((run.t[side], tuple(run.y[:, side]), tuple(run.rate[:, side])) for side in (early, late))
    first, last = ends
    return zip(*ends_of(system, omega, *first, *last), strict=True)


@kernel
def raise_to(most: Any, place: int, h: float, x: Any, v: Any, x1: Any, v1: Any) -> None:
    """Raise `most` from a place on to |x1| and, where a rate v changes sign, to the extreme of the cubic between."""
    for i in range(len(x)):
        size = abs(x1[i])
        if v[i] * v1[i] < -TINY:
            c, d, rise = h * v[i], h * v1[i], x1[i] - x[i]
            a, b = c + d - 2.0 * rise, 3.0 * rise - 2.0 * c - d
            q = abs(b) + math.sqrt(b * b - 3.0 * a * c)
            # of both zeros of the slope 3 a s^2 + 2 b s + c the one between 0 and 1
            s = q / (3.0 * abs(a)) if b * c > 0.0 else abs(c) / q
            size = max(size, abs(x[i] + s * (c + s * (b + s * a))))
        most[place + i] = max(most[place + i], size)


@kernel
def put(most: Any, out: Any, place: int) -> None:
    """Move `most` to a column of `out`, and begin again."""
    for i in range(len(most)):
        out[i, place] = most[i]
        most[i] = 0.0
