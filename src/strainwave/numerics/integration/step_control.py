"""Lengths of adaptive steps: the first one, the longest where nothing happens, and a look inside such a long step."""

import math
from typing import Any, NamedTuple

from ...base.protocols import System
from ...base.results import Floats
from ...compile.jit import kernel, routine
from ..addressed import rates
from .addressed_steps import BOUND
from .steps import LEAST_FACTOR, LOST_FACTOR, SAFETY, error_square, slope_weights, weighted
from .workspace import CHANGE, DENSE, INSIDE, K1, RATE, SHIFTED, Y1, K, Y, interpolate, length, row, shift

ROUNDS = 6  # of the power iteration, which needs an order of magnitude
DIFFERENCE_SIZE = 1e-7  # size of the differences, next to states of size 1
IDLE_STEPS = 25.0  # steps of a span in which nothing restores the system
LOOK_SPACING = 0.125  # at most from a look or a stage to the next
MISSED_TOLERANCES = 100.0  # by how many tolerances the system may differ there from the interpolant


class StepControl(NamedTuple):
    """Numbers that limit adaptive steps.

    Of the method: `order` is the power of h that the estimate of its error grows with, `stable` the length of its real
    interval of stability, and `looks` (1, n) are the fractions of a step at which the system is compared with the
    interpolant. Of a run: the `longest` step [s], the `span` [s] of the whole integration, and the tolerances.
    """

    order: int
    stable: float
    looks: Any
    longest: float
    span: float
    rtol: float
    atol: float


@routine
def largest(n: int, y: Floats) -> float:
    """Largest absolute value of n numbers."""
    size = 0.0
    for i in range(n):
        size = max(size, abs(y[i]))
    return size


@routine
def calm_step(stable: float, system: System, omega: float, t: float, w: Floats, state_row: int, span: float) -> float:
    """Step [s] at which a method, by its interval of stability, becomes unstable at a state.

    Where that is beyond the span [s], because nothing restores the system, it is a share of the span. From the largest
    eigenvalue of the Jacobian by power iteration, two rounds together because those of a vibration are a pair.
    """
    n, y, k, near_y, change = length(w), row(w, state_row), row(w, state_row + 1), row(w, SHIFTED), row(w, CHANGE)
    distance = DIFFERENCE_SIZE * (1.0 + largest(n, y))
    grown, before, size = 0.0, 0.0, 1.0
    for i in range(n):
        change[i] = 1.0
    for _ in range(min(ROUNDS, ROUNDS * n)):  # of a number that it knows the compiler would write out every round
        for i in range(n):
            near_y[i] = y[i] + distance / size * change[i]
        rates(system, omega * t, near_y, change)
        for i in range(n):
            change[i] -= k[i]
        size = largest(n, change)
        if not 0.0 < size < math.inf:
            return span / IDLE_STEPS
        before, grown = grown, size / distance
    rate = math.sqrt(grown * before)
    return stable / rate if rate * span > stable else span / IDLE_STEPS


@routine
def follows_interpolant(
    looks: Floats, system: Any, omega: float, t: float, h: float, w: Any, rtol: float, atol: float
) -> bool:  # fmt: skip
    """True if the system follows the interpolant of a step between its stages too: at the fractions `looks`."""
    n, dense, missed = length(w), row(w, DENSE), row(w, RATE)
    y, k, y1, k1 = row(w, Y), row(w, K), row(w, Y1), row(w, K1)
    for j in range(length(looks)):
        s = row(looks, 0)[j]
        interpolate(w, s, h)
        rates(system, omega * (t + s * h), row(w, INSIDE), missed)
        a = slope_weights(s, h)
        for i in range(n):
            missed[i] = h * missed[i] - weighted(a, y[i], k[i], y1[i], k1[i], dense[i])
        if not math.sqrt(error_square(n, missed, y, y1, rtol, atol)) <= MISSED_TOLERANCES:
            return False
    return True


@routine
def first_step(order: int, system: System, omega: float, t: float, w: Floats, rtol: float, atol: float) -> float:
    """Starting step size of a method with errors of this order (Hairer, Norsett & Wanner I, sec. II.4)."""
    n, y, k, change = length(w), row(w, Y), row(w, K), row(w, CHANGE)
    d0, d1 = math.sqrt(error_square(n, y, y, y, rtol, atol)), math.sqrt(error_square(n, k, y, y, rtol, atol))
    h0 = 1e-6 if d0 < 1e-5 or d1 < 1e-5 else 0.01 * d0 / d1
    shift(w, Y, h0)
    rates(system, omega * (t + h0), row(w, SHIFTED), change)
    for i in range(n):
        change[i] -= k[i]
    largest = max(d1, math.sqrt(error_square(n, change, y, y, rtol, atol)) / h0)
    h1 = max(1e-6, h0 * 1e-3) if largest <= 1e-15 else (0.01 / largest) ** (1.0 / order)
    return float(min(100.0 * h0, h1))


@kernel
def shorter_step(h: float, e: float, power: float) -> float:
    """Step to try after one of h whose error is e tolerances: at most 1 where the look inside has rejected it."""
    if e <= 1.0:
        return LOOK_SPACING * h
    return float(h * (max(LEAST_FACTOR, SAFETY * e**-power) if e < BOUND else LOST_FACTOR))
