"""A step of RODAS, an implicit method of order 4 with an estimate of order 3, whose length no fast decay bounds.

Hairer & Wanner, Solving Ordinary Differential Equations II, 2nd ed., sec. IV.7, and its program RODAS.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...base.law import torsion as torsion_of
from ...base.protocols import System
from ...base.quantities import Reals, States
from ...base.results import Floats
from ...compile.address import ByAddress
from ...compile.calls import POINTER, at
from ...compile.jit import entry, routine
from ..addressed import rates, rates_entry
from .addressed_steps import StepsAt, inside_entry, outcome

GAMMA = 0.25  # diagonal of the tableau
DIFFERENCE, SHARE = 1e-7, 1e-3  # of the differences: next to states of size 1, and of the step in time
PLACES = 0.0, 0.386, 0.21, 0.63, 1.0, 1.0  # of the stages, shares of a step
TURNS = 0.25, -0.1043, 0.1035, -0.0362, 0.0, 0.0  # weights of the derivative by time
A = (
    (),
    (1.544,),
    (0.9466785280815826, 0.2557011698983284),
    (3.314825187068521, 2.896124015972201, 0.9986419139977817),
    (1.221224509226641, 6.019134481288629, 12.53708332932087, -0.687886036105895),
    (1.221224509226641, 6.019134481288629, 12.53708332932087, -0.687886036105895, 1.0),
)
C = (
    (),
    (-5.6688,),
    (-2.430093356833875, -0.2063599157091915),
    (-0.1073529058151375, -9.594562251023355, -20.47028614809616),
    (7.496443313967647, -10.24680431464352, -33.99990352819905, 11.7089089320616),
    (8.083246795921522, -7.981132988064893, -31.52159432874371, 16.31930543123136, -6.058818238834054),
)
STATES, RATES = (tuple((*row, *(0.0,) * (6 - len(row))) for row in rows) for rows in (A, C))  # for compiled code


class Implicit(NamedTuple):
    """A system that `attempt` steps by RODAS."""

    system: Any

    def torsion(self, phase: Reals, y: States) -> Any:
        """Torsion [rad] of the gear."""
        return torsion_of(self.system, phase, y)

    def attempt(self, phase: float, turn: float, h: float, rtol: float, atol: float, w: Floats) -> float:
        """Try a step in a workspace: its first rows are the state and its rates, both at the end, the error."""
        return _step(self.system, w.shape[1], phase, turn, h, rtol, atol, *w[:6])


class ImplicitAt(NamedTuple):
    """A system by the addresses of its words and of its rates, with its number of states."""

    words: int
    rates_at: int
    states: int


def implicit_by_address(system: System, states: int, kinked: bool) -> ByAddress:
    """A system of so many states for kernels that `attempt` to step it by RODAS; where `kinked` they see switches."""

    def addressed(words: Callable[[Any], int]) -> StepsAt:
        stepped = ImplicitAt(words(system), rates_entry(system, states), states)
        step = entry(_attempt, stepped, *[float] * 5, *[POINTER] * 6)
        return StepsAt(words(stepped), step, stepped.words, inside_entry(system, states) if kinked else 0)

    return ByAddress(Implicit(system), addressed)


def _attempt(
    stepped: Any, phase: float, turn: float, h: float, rtol: float, atol: float, y: Any, rate: Any, y1: Any, k1: Any,
    error: Any, dense: Any,
) -> Any:  # fmt: skip
    system = at(stepped)
    return _step(system, system.states, phase, turn, h, rtol, atol, y, rate, y1, k1, error, dense)


@routine
def _step(
    system: Any, n: int, phase: float, turn: float, h: float, rtol: float, atol: float, y: Any, rate: Any, y1: Any,
    k1: Any, error: Any, dense: Any,
) -> float:  # fmt: skip
    m, u = np.zeros((n, 2 * n)), np.zeros((6, n))
    start, now, slope, by_time, later = np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    for i in range(n):
        start[i], now[i] = y[i], y[i]
    rates(system, phase + SHARE * turn, now, by_time)
    rates(system, phase + 2.0 * SHARE * turn, now, later)
    for j in range(n):
        d = DIFFERENCE * (1.0 + abs(start[j]))
        now[j] = start[j] + d
        rates(system, phase, now, slope)
        now[j] = start[j]
        for i in range(n):
            m[i, j] = (rate[i] - slope[i]) / d
        m[j, j] += 1.0 / (GAMMA * h)
        m[j, n + j] = 1.0
        by_time[j] = (4.0 * by_time[j] - later[j] - 3.0 * rate[j]) / (2.0 * SHARE)
    solve_in_place(m)
    for s in range(6):
        for i in range(n):
            now[i] = start[i]
            for q in range(s):
                now[i] += STATES[s][q] * u[q, i]
        rates(system, phase + PLACES[s] * turn, now, slope)
        for i in range(n):
            slope[i] += TURNS[s] * by_time[i]
            for q in range(s):
                slope[i] += RATES[s][q] / h * u[q, i]
        for i in range(n):
            for j in range(n):
                u[s, i] += m[i, n + j] * slope[j]
    for i in range(n):
        now[i] += u[5, i]
        y1[i], error[i], dense[i] = now[i], u[5, i], 0.0
    rates(system, phase + turn, now, k1)
    return outcome(start, now, u[5], rtol, atol)


@routine
def solve_in_place(m: Floats) -> None:
    """Solve in place: the left square of m, a system of equations, leaves in the columns behind it their solutions."""
    rows, columns = m.shape
    for k in range(rows):
        p = k
        for i in range(k + 1, rows):
            if abs(m[i, k]) > abs(m[p, k]):
                p = i
        if p != k:
            for j in range(k, columns):
                m[k, j], m[p, j] = m[p, j], m[k, j]
        inverse = 1.0 / m[k, k]
        for i in range(k + 1, rows):
            factor = m[i, k] * inverse
            if factor != 0.0:
                for j in range(k + 1, columns):
                    m[i, j] -= factor * m[k, j]
    for k in range(rows - 1, -1, -1):
        inverse = 1.0 / m[k, k]
        for j in range(rows, columns):
            m[k, j] *= inverse
        for i in range(k):
            factor = m[i, k]
            if factor != 0.0:
                for j in range(rows, columns):
                    m[i, j] -= factor * m[k, j]
