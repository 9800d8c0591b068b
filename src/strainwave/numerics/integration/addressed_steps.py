"""Steps of an integration as marches call them: `try_step`, `take_step` and `torsion_inside` in a workspace.

Machine code knows the system and the step by addresses (`StepsAt`); run as Python, they are the objects themselves.

A step is compiled with a system of few states: it would take a quarter longer if it called it by an address of its
own, where nothing is shared by the stages. That of a train would compile for seconds, and there a call costs little.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from ...base.law import has
from ...base.law import torsion as torsion_of
from ...base.protocols import Scheme, System
from ...base.quantities import States
from ...base.results import Floats
from ...compile.address import ByAddress
from ...compile.calls import at, put_at, value
from ...compile.jit import entry, kernel, kernel_as
from ...compile.tree import axpy, times
from ..addressed import Tupled, rates_entry, torsion
from .steps import bounded, dense_weights, dopri5_step, error_square
from .workspace import DENSE, ERROR, INSIDE, K1, Y1, K, Y, interpolate, row

FEW_STATES = 3  # states of a system that is compiled into a step
BOUND = 1e30  # of every state: far beyond any physics, and its powers in a law still fit a float


class StepsAt(NamedTuple):
    """Stepper of a system by the addresses of its words and functions; 0 stands for what is not needed."""

    words: int
    step_at: int
    system: int
    inside_at: int


def attempts_by_address(system: System, states: int, kinked: bool) -> ByAddress:
    """A system of so many states for kernels that call `try_step` on it; where `kinked` they look for switches."""

    def addressed(words: Callable[[Any], int]) -> StepsAt:
        inside = inside_entry(system, states) if kinked else 0
        system_words = words(system)
        stepped = system if states <= FEW_STATES else Tupled(system_words, rates_entry(system, states))
        return StepsAt(words(stepped), entry(_attempt, stepped, *[float] * 5, *[states] * 6), system_words, inside)

    return ByAddress(system, addressed)


def inside_entry(system: Any, states: int) -> int:
    """Address of the torsion inside a step of a system of so many states."""
    return entry(_torsion_inside, system, *[float] * 3, *[states] * 5)


def steps_by_address(scheme: Scheme, system: System, states: int) -> ByAddress:
    """A scheme for kernels that call `take_step` on a system of so many states."""
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
    return outcome(begin, end, missed, rtol, atol)


def _step(pair: Any, phase: float, turn: float, h: float, y: Any, y1: Any, k1: Any) -> Any:
    scheme, system = at(pair)
    end = scheme.step(system, phase, turn, at(y), h)
    rate = system.rhs(phase + turn, end)
    put_at(y1, end)
    put_at(k1, rate)
    return _sound(end, rate)


@kernel
def outcome(y: Any, y1: Floats, error: Floats, rtol: float, atol: float) -> float:
    """Mean square of an error in units of the tolerance; less one and negative where a state passes `BOUND`."""
    square = error_square(len(y), error, y, y1, rtol, atol)
    return square if bounded(y1, BOUND) else -1.0 - square


@kernel
def _sound(y: States, rate: States) -> float:
    return 1.0 if bounded(y, BOUND) and bounded(rate, math.inf) else 0.0


def _attempt_loops(system: Any, phase: float, turn: float, h: float, rtol: float, atol: float, w: Floats) -> Any:
    ends = row(w, Y), row(w, K), row(w, Y1), row(w, K1)
    return value(system.step_at, system.words, (phase, turn, h, rtol, atol, *ends, row(w, ERROR), row(w, DENSE)))


@kernel_as(_attempt_loops, inline=True)
def try_step(system: Any, phase: float, turn: float, h: float, rtol: float, atol: float, w: Floats) -> float:
    """Try a step of h in time and `turn` in phase: its end, the error, and the vector of the dense output.

    Returns the mean square of the error in units of the tolerance; less one and negative where a state passes `BOUND`.
    """
    if has(system, "attempt"):
        return float(system.attempt(phase, turn, h, rtol, atol, w))
    y, rate = w[Y : K + 1].tolist()
    w[Y1 : DENSE + 1] = dopri5_step(system, phase, turn, tuple(y), h, tuple(rate))
    return outcome(y, w[Y1], w[ERROR], rtol, atol)


def _step_loops(pair: Any, phase: float, turn: float, h: float, w: Floats) -> Any:
    return value(pair.step_at, pair.words, (phase, turn, h, row(w, Y), row(w, Y1), row(w, K1)))


@kernel_as(_step_loops, inline=True)
def take_step(pair: Any, phase: float, turn: float, h: float, w: Floats) -> float:
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
    interpolate(w, s, h)
    return torsion(system, phase, w[INSIDE])
