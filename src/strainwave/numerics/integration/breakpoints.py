"""Location of switches: where the torsion of a running integration crosses a breakpoint of the law.

Of `kinks` row 0 are the breakpoints, row 1 says on which side of each (-1.0 or 1.0) the torsion is. A step that ends on
the other side is repeated so that it ends on the breakpoint; each step then sees one smooth piece of the law.
"""

import math
from typing import Any

from ...compile.jit import routine
from ..addressed import torsion
from .attempts import attempt, torsion_inside
from .workspace import SHIFTED, Y1, Y, length, row, shift

SCAN = 4  # places inside a step where the torsion is compared with the breakpoints


@routine
def set_sides(system: Any, omega: float, t: float, w: Any, kinks: Any, at: int) -> None:
    """Record on which side of each breakpoint the torsion is; on breakpoint number `at`, where the flow carries it."""
    u, breakpoints, sides = torsion(system, omega * t, row(w, Y)), row(kinks, 0), row(kinks, 1)
    for j in range(length(kinks)):
        away = u - breakpoints[j]
        if j == at or away == 0.0:
            away = torsion_rate(system, omega, t, w, Y)
        sides[j] = 1.0 if away >= 0.0 else -1.0


@routine
def torsion_rate(system: Any, omega: float, t: float, w: Any, place: int) -> float:
    """Rate of the torsion along the flow, by a central difference (only its sign and about six digits matter)."""
    d = 1e-5 / (1.0 + abs(omega))
    shift(w, place, d)
    after = torsion(system, omega * (t + d), row(w, SHIFTED))
    shift(w, place, -d)
    return float((after - torsion(system, omega * (t - d), row(w, SHIFTED))) / (2.0 * d))


@routine
def first_switch(pair: Any, omega: float, t: float, h: float, w: Any, kinks: Any) -> Any:
    """First fraction of the step at which the torsion changes side of a breakpoint, and that breakpoint (-1: none)."""
    breakpoints, sides = row(kinks, 0), row(kinks, 1)
    low, below, above = 0.0, -math.inf, math.inf  # the torsion is between two breakpoints
    for j in range(length(kinks)):
        if sides[j] > 0.0:
            below = max(below, breakpoints[j])
        else:
            above = min(above, breakpoints[j])
    for i in range(1, SCAN + 1):
        high, best, at = i / SCAN, 2.0, -1
        u = torsion_inside(pair, omega * (t + high * h), high, h, w)
        if u < below or u > above:
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
                        best, at = b, j
            return best, at
        low = high
    return 2.0, -1


@routine
def step_onto(
    pair: Any, system: Any, omega: float, t: float, h: float, rtol: float, atol: float, w: Any, breakpoint: float,
    t_end: float,
) -> Any:  # fmt: skip
    """Take a step of about h that ends on the breakpoint (Newton on h): whether it does, h, and what `attempt` returns.

    The whole step is repeated, instead of cutting its interpolant, so that its end has the order of the method too.
    """
    away = torsion(system, omega * t, row(w, Y)) - breakpoint
    gap = back = square = 0.0
    for _ in range(4):
        h = min(h - back, t_end - t)
        square = attempt(pair, omega * t, omega * h, h, rtol, atol, w)
        gap = torsion(system, omega * (t + h), row(w, Y1)) - breakpoint
        rate = torsion_rate(system, omega, t + h, w, Y1)
        back = gap / rate if abs(gap) < 0.1 * h * abs(rate) else 0.0
    return abs(gap) <= 1e-3 * abs(away), h, square
