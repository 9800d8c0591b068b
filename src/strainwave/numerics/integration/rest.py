"""What a long step may miss: how long a step may become where nothing happens, and a look inside such a step.

Where a motion comes to rest its error is zero and nothing limits the step, and whatever begins later would lie between
the stages of one step. No step of an explicit method is longer than its stability allows for long, so that limit costs
nothing elsewhere.
"""

import math
from typing import Any

from ...compile.jit import kernel, routine
from ...compile.tuples import alike, axpy, times
from .steps import dense_output, error_norm, rates_of

ROUNDS = 6  # of the power iteration, which needs an order of magnitude
NEAR = 1e-7  # size of the differences, next to states of size 1
IDLE = 25.0  # steps of a span in which nothing restores the system
APART = 0.125  # at most from a look or a stage to the next
STAGES = 0.25  # of a calm step: the stages alone of a step up to there are no farther apart
MISSED = 100.0  # by how many tolerances the system may differ there from the interpolant


@kernel
def largest(y: Any) -> float:
    """Largest absolute value of a tuple."""
    most = 0.0
    for i in range(len(y)):
        most = max(most, abs(y[i]))
    return most


@routine
def calm_step(stable: float, system: Any, omega: float, t: float, y: Any, k: Any, span: float) -> float:
    """Step [s] at which a method, by its interval of stability, becomes unstable at a state with the rates k.

    Where that is beyond the span [s], because nothing restores the system, it is a share of the span. From the largest
    eigenvalue of the Jacobian by power iteration, two rounds together because those of a vibration are a pair.
    """
    near = NEAR * (1.0 + largest(y))
    change, grown, before = alike(y, near), 0.0, 0.0
    for _ in range(ROUNDS):
        rates = axpy(rates_of(system, omega * t, axpy(y, 1.0, change)), -1.0, k)
        size = largest(rates)
        if not 0.0 < size < math.inf:
            return span / IDLE
        before, grown = grown, size / near
        change = times(near / size, rates)
    rate = math.sqrt(grown * before)
    return stable / rate if rate * span > stable else span / IDLE


@kernel
def dense_rate(s: float, h: float, y: Any, k: Any, y_end: Any, k_end: Any, dense: Any) -> Any:
    """Derivative by s of `dense_output`."""
    r = 1.0 - s
    difference = axpy(y_end, -1.0, y)
    slope = axpy(axpy(difference, -h, k), -2.0, axpy(difference, -h, k))  # h k - difference
    bend = axpy(axpy(difference, -h, k_end), -1.0, slope)
    out = axpy(difference, r - s, slope)
    out = axpy(out, s * (2.0 - 3.0 * s), bend)
    return axpy(out, 2.0 * s * r * (r - s), dense)


@routine
def undisturbed(
    scheme: Any, system: Any, omega: float, t: float, h: float, y: Any, k: Any, y1: Any, k1: Any, dense: Any,
    rtol: float, atol: float,
) -> bool:  # fmt: skip
    """Whether the system follows the interpolant of a step between its stages too."""
    for s in scheme.looks():
        rates = rates_of(system, omega * (t + s * h), dense_output(s, h, y, k, y1, k1, dense))
        missed = axpy(times(h, rates), -1.0, dense_rate(s, h, y, k, y1, k1, dense))
        if not error_norm(missed, y, y1, rtol, atol) <= MISSED:
            return False
    return True
