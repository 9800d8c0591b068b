"""Location of switches in a step: where the torsion crosses a breakpoint of the law, or a guard becomes negative."""

import math
from typing import Any

from ...base.protocols import System
from ...base.results import Floats
from ...compile.jit import kernel, routine
from ..addressed import guards, torsion
from .addressed_steps import torsion_inside, try_step
from .step_control import StepControl
from .workspace import INSIDE, SHIFTED, Y1, Y, interpolate, length, row, shift

SCAN_PLACES = 4  # places inside a step where the torsion is compared with the breakpoints, and the guards with 0


@routine
def set_sides(system: System, omega: float, t: float, w: Floats, kinks: Floats, kink: int) -> None:
    """Record on which side of each breakpoint the torsion is; on breakpoint `kink`, where the flow carries it."""
    u, breakpoints, sides = torsion(system, omega * t, row(w, Y)), row(kinks, 0), row(kinks, 1)
    for j in range(length(kinks)):
        away = u - breakpoints[j]
        if j == kink or away == 0.0:
            away = torsion_rate(system, omega, t, w, Y)
        sides[j] = 1.0 if away >= 0.0 else -1.0


@routine
def torsion_rate(system: System, omega: float, t: float, w: Floats, state_row: int) -> float:
    """Rate of the torsion along the flow, by a central difference (only its sign and about six digits matter)."""
    d = 1e-5 / (1.0 + abs(omega))
    shift(w, state_row, d)
    after = torsion(system, omega * (t + d), row(w, SHIFTED))
    shift(w, state_row, -d)
    return float((after - torsion(system, omega * (t - d), row(w, SHIFTED))) / (2.0 * d))


@routine
def first_switch(pair: Any, omega: float, t: float, h: float, w: Floats, kinks: Floats) -> Any:
    """First fraction of the step at which the torsion changes side of a breakpoint, and that breakpoint (-1: none)."""
    breakpoints, sides = row(kinks, 0), row(kinks, 1)
    low, lower, upper = 0.0, -math.inf, math.inf  # the torsion is between two breakpoints
    for j in range(length(kinks)):
        if sides[j] > 0.0:
            lower = max(lower, breakpoints[j])
        else:
            upper = min(upper, breakpoints[j])
    for i in range(1, SCAN_PLACES + 1):
        high, best, index = i / SCAN_PLACES, 2.0, -1
        u = torsion_inside(pair, omega * (t + high * h), high, h, w)
        if u < lower or u > upper:
            for j in range(length(kinks)):
                if (u - breakpoints[j]) * sides[j] < 0.0:
                    a, b = low, high
                    for _ in range(40):
                        s = 0.5 * (a + b)
                        inside = torsion_inside(pair, omega * (t + s * h), s, h, w)
                        if (inside - breakpoints[j]) * sides[j] < 0.0:
                            b = s
                        else:
                            a = s
                    if b < best:
                        best, index = b, j
            return best, index
        low = high
    return 2.0, -1


@routine
def step_onto(
    pair: Any, system: System, control: StepControl, omega: float, t: float, h: float, t_end: float, w: Floats,
    breakpoint: float,
) -> Any:  # fmt: skip
    """Take a step of about h that ends on the breakpoint: whether it does, h, and what `try_step` returns.

    By Newton's method on h. The whole step is repeated, instead of cutting its interpolant, so that its end has the
    order of the method too.
    """
    away = torsion(system, omega * t, row(w, Y)) - breakpoint
    gap = back = square = 0.0
    for _ in range(4):
        h = min(h - back, t_end - t)
        square = try_step(pair, omega * t, omega * h, h, control.rtol, control.atol, w)
        gap = torsion(system, omega * (t + h), row(w, Y1)) - breakpoint
        rate = torsion_rate(system, omega, t + h, w, Y1)
        back = gap / rate if abs(gap) < 0.1 * h * abs(rate) else 0.0
    return abs(gap) <= 1e-3 * abs(away), h, square


@routine
def is_guard_negative(system: Any, omega: float, t: float, s: float, h: float, w: Any, guard: Any) -> bool:
    """True if a guard is negative at the fraction s of a step of h from t."""
    interpolate(w, s, h)
    values = row(guard, 0)
    guards(system, omega * (t + s * h), row(w, INSIDE), values)
    least = values[0]
    for j in range(1, length(guard)):
        least = min(least, values[j])
    return bool(least < 0.0)


@routine
def first_stop(system: Any, omega: float, t: float, h: float, w: Any, guard: Any) -> float:
    """First fraction of the step at which a guard is negative; 2 where none is."""
    low = 0.0
    for i in range(1, SCAN_PLACES + 1):
        high = i / SCAN_PLACES
        if is_guard_negative(system, omega, t, high, h, w, guard):
            for _ in range(40):
                s = 0.5 * (low + high)
                if is_guard_negative(system, omega, t, s, h, w, guard):
                    high = s
                else:
                    low = s
            return high
        low = high
    return 2.0


@kernel
def step_to_event(
    pair: Any, system: Any, control: StepControl, omega: float, t: float, h: float, t_end: float, w: Any, kinks: Any,
    guard: Any,
) -> Any:  # fmt: skip
    """Try a step of h from t that ends where the torsion meets a breakpoint, or a guard becomes negative.

    Returns its length, what `try_step` returns, the breakpoint at its end (-1: none), whether it was cut, and whether a
    guard stops it.
    """
    square, kink, cut = try_step(pair, omega * t, omega * h, h, control.rtol, control.atol, w), -1, False
    if length(kinks) > 0 and square >= 0.0:
        s, crossed = first_switch(pair, omega, t, h, w, kinks)
        if crossed >= 0:
            breakpoint = row(kinks, 0)[crossed]
            met, h, square = step_onto(pair, system, control, omega, t, s * h, t_end, w, breakpoint)
            kink, cut = crossed if met else -1, True
    if length(guard) == 0 or square < 0.0:
        return h, square, kink, cut, False
    s = first_stop(system, omega, t, h, w, guard)
    if s < 1.0:
        h, kink, cut = s * h, -1, True
        square = try_step(pair, omega * t, omega * h, h, control.rtol, control.atol, w)
    return h, square, kink, cut, s <= 1.0
