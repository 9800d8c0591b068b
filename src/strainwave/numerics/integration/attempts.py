"""Steps of a method in a workspace, where kernels know its system by an address.

A step is compiled with a system of few states: it would take a quarter longer if it called it by an address of its
own, where nothing is shared by the stages. That of a train would compile for seconds, and there a call costs little.

Workspace of a march: rows of states that its kernels share.

Largest values of a running integration, between its samples too: of the states, and of what a system has `watched`.

`watched(phase, y)` is a tuple of functions of the state, for instance the torque in a gear.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...base.law import torsion as torsion_of
from ...base.protocols import Scheme, System, omega_of
from ...base.quantities import States
from ...base.results import Floats
from ...compile.address import ByAddress, at, beyond, pointer, put_at, value
from ...compile.elementwise import smaller
from ...compile.jit import entry, kernel, kernel_as, routine
from ...compile.tree import axpy, times
from ..addressed import Tupled, rates_entry, torsion, watched
from .steps import bounded, dense_weights, dopri5_step, error_square, weighted

FEW_STATES = 3  # states of a system that is compiled into a step
BOUND = 1e30  # of every state: far beyond any physics, and its powers in a law still fit a float

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
def look(w: Floats, s: float, h: float) -> None:
    """Let `INSIDE` be the state at the fraction s of a step of h."""
    y, k, y1, k1, dense, out = row(w, Y), row(w, K), row(w, Y1), row(w, K1), row(w, DENSE), row(w, INSIDE)
    a = dense_weights(s, h)
    for i in range(length(w)):
        out[i] = weighted(a, y[i], k[i], y1[i], k1[i], dense[i])


class StepsAt(NamedTuple):
    """Stepper of a system by the addresses of its words and functions; 0 stands for what is not needed."""

    words: int
    step_at: int
    system: int
    inside_at: int


def attempts_by_address(system: System, states: int, kinked: bool) -> ByAddress:
    """A system of so many states for kernels that `attempt` to step it; where `kinked` they look for switches."""

    def addressed(words: Callable[[Any], int]) -> StepsAt:
        inside = entry(_torsion_inside, system, *[float] * 3, *[states] * 5) if kinked else 0
        system_words = words(system)
        stepped = system if states <= FEW_STATES else Tupled(system_words, rates_entry(system, states))
        return StepsAt(words(stepped), entry(_attempt, stepped, *[float] * 5, *[states] * 6), system_words, inside)

    return ByAddress(system, addressed)


def steps_by_address(scheme: Scheme, system: System, states: int) -> ByAddress:
    """A scheme for kernels that `step` a system of so many states."""
    pair = scheme, system
    return ByAddress(pair, lambda words: StepsAt(words(pair), entry(_step, pair, *[float] * 3, *[states] * 3), 0, 0))


def _attempt(
    system: Any, phase: float, turn: float, h: float, rtol: float, atol: float, y: Any, rate: States, y1: Any, k1: Any,
    error: Floats, dense: Any,
) -> Any:  # fmt: skip
    begin = at(y)
    end, end_rate, missed, between = dopri5_step(at(system), phase, turn, begin, h, at(rate))
    put_at(y1, end)
    put_at(k1, end_rate)
    put_at(error, missed)
    put_at(dense, between)
    return _outcome(begin, end, missed, rtol, atol)


def _step(pair: Any, phase: float, turn: float, h: float, y: Any, y1: Any, k1: Any) -> Any:
    scheme, system = at(pair)
    end = scheme.step(system, phase, turn, at(y), h)
    rate = system.rhs(phase + turn, end)
    put_at(y1, end)
    put_at(k1, rate)
    return _sound(end, rate)


@kernel
def _outcome(y: Any, y1: Floats, error: Floats, rtol: float, atol: float) -> float:
    square = error_square(len(y), error, y, y1, rtol, atol)
    return square if bounded(y1, BOUND) else -1.0 - square


@kernel
def _sound(y: States, rate: States) -> float:
    return 1.0 if bounded(y, BOUND) and bounded(rate, math.inf) else 0.0


def _attempt_loops(system: Any, phase: float, turn: float, h: float, rtol: float, atol: float, w: Floats) -> Any:
    ends = row(w, Y), row(w, K), row(w, Y1), row(w, K1)
    return value(system.step_at, system.words, (phase, turn, h, rtol, atol, *ends, row(w, ERROR), row(w, DENSE)))


@kernel_as(_attempt_loops, inline=True)
def attempt(system: Any, phase: float, turn: float, h: float, rtol: float, atol: float, w: Floats) -> float:
    """Try a step of h in time and `turn` in phase: its end, the error, and the vector of the dense output.

    Returns the mean square of the error in units of the tolerance; less one and negative where a state passes `BOUND`.
    """
    y, rate = w[Y : K + 1].tolist()
    w[Y1 : DENSE + 1] = dopri5_step(system, phase, turn, tuple(y), h, tuple(rate))
    return _outcome(y, w[Y1], w[ERROR], rtol, atol)


def _step_loops(pair: Any, phase: float, turn: float, h: float, w: Floats) -> Any:
    return value(pair.step_at, pair.words, (phase, turn, h, row(w, Y), row(w, Y1), row(w, K1)))


@kernel_as(_step_loops, inline=True)
def step(pair: Any, phase: float, turn: float, h: float, w: Floats) -> float:
    """Take a step of h in time and `turn` in phase: its end, and 0 where a state there passes `BOUND`, else 1."""
    scheme, system = pair
    w[Y1] = y = scheme.step(system, phase, turn, tuple(w[Y].tolist()), h)
    w[K1] = rate = system.rhs(phase + turn, y)
    return _sound(y, rate)


def _torsion_inside(system: Any, phase: float, s: float, h: float, y: Any, k: Any, y1: Any, k1: Any, dense: Any) -> Any:
    a, system = dense_weights(s, h), at(system)
    begin, end = axpy(times(a[0], at(y)), a[1], at(k)), axpy(times(a[2], at(y1)), a[3], at(k1))
    return 1.0 * torsion_of(system, phase, axpy(axpy(begin, 1.0, end), a[4], at(dense)))


def _inside_loops(system: Any, phase: float, s: float, h: float, w: Floats) -> Any:
    ends = row(w, Y), row(w, K), row(w, Y1), row(w, K1)
    return value(system.inside_at, system.system, (phase, s, h, *ends, row(w, DENSE)))


@kernel_as(_inside_loops)
def torsion_inside(system: Any, phase: float, s: float, h: float, w: Floats) -> float:
    """Torsion [rad] at the fraction s of a step of h."""
    look(w, s, h)
    return torsion(system, phase, w[INSIDE])


@kernel
def store(table: Floats, column: int, t: float, w: Floats, start: int) -> None:
    """Write one sample (time, state, rate) to a column of the table."""
    n, y, k = length(w), row(w, start), row(w, start + 1)
    row(table, 0)[column] = t
    for i in range(n):
        row(table, 1 + i)[column], row(table, 1 + n + i)[column] = y[i], k[i]


DIFFERENCE = 1e-5  # step of the differences that give the rates of what is watched, in units of 1 s and of 1/omega

TINY = 1e-200  # products of rates below it count as rest


@routine
def widen(
    system: System, omega: float, peaks: Floats, watch: Floats, w: Floats, t: float, begin: int, t1: float, end: int
) -> None:
    """Raise `peaks` to the largest |value| after t until t1, from the states in the rows `begin` and `end`.

    The rows of `watch` are for what is watched, with its rates, at both.
    """
    raise_to(peaks, 0, t1 - t, w, begin, end)
    if length(watch) > 0 and t1 > t:
        d = inside(omega, t1 - t)
        see(system, omega, t, w, begin, d, watch, 0)
        see(system, omega, t1, w, end, -d, watch, 2)
        raise_to(peaks, length(w), t1 - t, watch, 0, 2)


@kernel
def inside(omega: float, length: Any) -> Any:
    """Step of the differences at both ends of a stretch [s], which stay inside it."""
    return smaller(DIFFERENCE / (1.0 + abs(omega)), 0.5 * length)


@routine
def see(system: System, omega: float, t: float, w: Floats, state_row: int, d: float, watch: Floats, first: int) -> None:
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
    d = inside(omega, t[1] - t[0]) * np.array([[1.0], [-1.0]])
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
def put(peaks: Floats, table: Floats, first: int, column: int) -> None:
    """Move `peaks` to a column of the table from a row on, and begin again."""
    for i in range(length(peaks)):
        row(table, first + i)[column] = row(peaks, 0)[i]
        row(peaks, 0)[i] = 0.0
