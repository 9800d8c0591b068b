"""What a long step may miss: how long a step may become where nothing happens, and a look inside such a step.

Where a motion comes to rest its error is zero and nothing limits the step, and whatever begins later would lie between
the stages of one step. No step of an explicit method is longer than its stability allows for long, so that limit costs
nothing elsewhere.
"""

import math
from typing import Any

from ...compile.jit import routine
from ..addressed import rates
from .steps import error_square, slope_weights, weighted
from .workspace import CHANGE, DENSE, INSIDE, K1, RATE, SHIFTED, Y1, K, Y, length, look, row

ROUNDS = 6  # of the power iteration, which needs an order of magnitude
NEAR = 1e-7  # size of the differences, next to states of size 1
IDLE = 25.0  # steps of a span in which nothing restores the system
APART = 0.125  # at most from a look or a stage to the next
STAGES = 0.25  # of a calm step: the stages alone of a step up to there are no farther apart
MISSED = 100.0  # by how many tolerances the system may differ there from the interpolant


@routine
def largest(n: int, y: Any) -> float:
    """Largest absolute value of n numbers."""
    most = 0.0
    for i in range(n):
        most = max(most, abs(y[i]))
    return most


@routine
def calm_step(stable: float, system: Any, omega: float, t: float, w: Any, place: int, span: float) -> float:
    """Step [s] at which a method, by its interval of stability, becomes unstable at a state.

    Where that is beyond the span [s], because nothing restores the system, it is a share of the span. From the largest
    eigenvalue of the Jacobian by power iteration, two rounds together because those of a vibration are a pair.
    """
    n, y, k, near_y, change = length(w), row(w, place), row(w, place + 1), row(w, SHIFTED), row(w, CHANGE)
    near = NEAR * (1.0 + largest(n, y))
    grown, before, size = 0.0, 0.0, 1.0
    for i in range(n):
        change[i] = 1.0
    for _ in range(min(ROUNDS, ROUNDS * n)):  # of a number that it knows the compiler would write out every round
        for i in range(n):
            near_y[i] = y[i] + near / size * change[i]
        rates(system, omega * t, near_y, change)
        for i in range(n):
            change[i] -= k[i]
        size = largest(n, change)
        if not 0.0 < size < math.inf:
            return span / IDLE
        before, grown = grown, size / near
    rate = math.sqrt(grown * before)
    return stable / rate if rate * span > stable else span / IDLE


@routine
def undisturbed(
    looks: Any, system: Any, omega: float, t: float, h: float, w: Any, rtol: float, atol: float
) -> bool:  # fmt: skip
    """Whether the system follows the interpolant of a step between its stages too: at the fractions `looks`."""
    n, y, k, y1, k1, dense, missed = (
        length(w),
        row(w, Y),
        row(w, K),
        row(w, Y1),
        row(w, K1),
        row(w, DENSE),
        row(w, RATE),
    )
    for j in range(length(looks)):
        s = row(looks, 0)[j]
        look(w, s, h)
        rates(system, omega * (t + s * h), row(w, INSIDE), missed)
        a = slope_weights(s, h)
        for i in range(n):
            missed[i] = h * missed[i] - weighted(a, y[i], k[i], y1[i], k1[i], dense[i])
        if not math.sqrt(error_square(n, missed, y, y1, rtol, atol)) <= MISSED:
            return False
    return True
