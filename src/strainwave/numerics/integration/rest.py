"""What a long step may miss: how long a step may become where nothing happens, and a look inside such a step.

Where a motion comes to rest its error is zero and nothing limits the step, and whatever begins later would lie between
the stages of one step. No step of an explicit method is longer than its stability allows for long, so that limit costs
nothing elsewhere.
"""

import math
from typing import Any

from ...compile.jit import kernel, routine
from ..addressed import rates
from .steps import dense_slope, error_norm
from .workspace import CHANGE, DENSE, INSIDE, K1, RATE, SHIFTED, Y1, K, Y, look

ROUNDS = 6  # of the power iteration, which needs an order of magnitude
NEAR = 1e-7  # size of the differences, next to states of size 1
IDLE = 25.0  # steps of a span in which nothing restores the system
APART = 0.125  # at most from a look or a stage to the next
STAGES = 0.25  # of a calm step: the stages alone of a step up to there are no farther apart
MISSED = 100.0  # by how many tolerances the system may differ there from the interpolant


@kernel
def largest(y: Any) -> float:
    """Largest absolute value in an array."""
    most = 0.0
    for i in range(len(y)):
        most = max(most, abs(y[i]))
    return most


@routine
def calm_step(stable: float, system: Any, omega: float, t: float, w: Any, row: int, span: float) -> float:
    """Step [s] at which a method, by its interval of stability, becomes unstable at a state.

    Where that is beyond the span [s], because nothing restores the system, it is a share of the span. From the largest
    eigenvalue of the Jacobian by power iteration, two rounds together because those of a vibration are a pair.
    """
    change, n = w[CHANGE], w.shape[1]
    near = scale = NEAR * (1.0 + largest(w[row]))
    grown, before = 0.0, 0.0
    for i in range(n):
        change[i] = 1.0
    for _ in range(ROUNDS):
        for i in range(n):
            w[SHIFTED, i] = w[row, i] + scale * change[i]
        rates(system, omega * t, w[SHIFTED], change)
        for i in range(n):
            change[i] -= w[row + 1, i]
        size = largest(change)
        if not 0.0 < size < math.inf:
            return span / IDLE
        before, grown, scale = grown, size / near, near / size
    rate = math.sqrt(grown * before)
    return stable / rate if rate * span > stable else span / IDLE


@routine
def undisturbed(
    looks: Any, system: Any, omega: float, t: float, h: float, w: Any, rtol: float, atol: float
) -> bool:  # fmt: skip
    """Whether the system follows the interpolant of a step between its stages too: at the fractions `looks`."""
    for j in range(len(looks)):
        s = looks[j]
        look(w, s, h)
        rates(system, omega * (t + s * h), w[INSIDE], w[RATE])
        for i in range(w.shape[1]):
            slope = dense_slope(s, h, w[Y, i], w[K, i], w[Y1, i], w[K1, i], w[DENSE, i])
            w[RATE, i] = h * w[RATE, i] - slope
        if not error_norm(w[RATE], w[Y], w[Y1], rtol, atol) <= MISSED:
            return False
    return True
