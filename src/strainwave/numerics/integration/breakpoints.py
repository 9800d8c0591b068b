"""Location of switches: where the torsion of a running integration crosses a breakpoint of the law.

`sides` holds, for each breakpoint, on which side of it (-1.0 or 1.0) the torsion is. A step that ends on the other
side is repeated so that it ends on the breakpoint; each step then sees one smooth piece of the law.
"""

from typing import Any

from ...compile.jit import kernel
from ...compile.tuples import axpy
from ...law import torsion
from .steps import dense_output

SCAN = 4  # places inside a step where the torsion is compared with the breakpoints


@kernel
def set_sides(system: Any, omega: float, t: float, y: Any, k: Any, breakpoints: Any, sides: Any, at: int) -> None:
    """Record on which side of each breakpoint the torsion is; on breakpoint number `at`, where the flow carries it."""
    u = torsion(system, omega * t, y)
    ahead = torsion_rate(system, omega, t, y, k)
    for j in range(len(breakpoints)):
        away = u - breakpoints[j]
        if j == at or away == 0.0:
            away = ahead
        sides[j] = 1.0 if away >= 0.0 else -1.0


@kernel
def torsion_rate(system: Any, omega: float, t: float, y: Any, k: Any) -> float:
    """Rate of the torsion along the flow, by a central difference (only its sign and about six digits matter)."""
    d = 1e-5 / (1.0 + abs(omega))
    after = torsion(system, omega * (t + d), axpy(y, d, k))
    before = torsion(system, omega * (t - d), axpy(y, -d, k))
    return float((after - before) / (2.0 * d))


@kernel
def first_switch(
    system: Any, omega: float, t: float, h: float, y: Any, k: Any, y1: Any, k1: Any, dense: Any,
    breakpoints: Any, sides: Any,
) -> Any:  # fmt: skip
    """First fraction of the step at which the torsion changes side of a breakpoint, and that breakpoint (-1: none)."""
    low = 0.0
    for i in range(1, SCAN + 1):
        high = i / SCAN
        u = torsion(system, omega * (t + high * h), dense_output(high, h, y, k, y1, k1, dense))
        best, at = 2.0, -1
        for j in range(len(breakpoints)):
            if (u - breakpoints[j]) * sides[j] < 0.0:
                a, b = low, high
                for _ in range(40):
                    s = 0.5 * (a + b)
                    inside = torsion(system, omega * (t + s * h), dense_output(s, h, y, k, y1, k1, dense))
                    if (inside - breakpoints[j]) * sides[j] < 0.0:
                        b = s
                    else:
                        a = s
                if b < best:
                    best, at = b, j
        if at >= 0:
            return best, at
        low = high
    return 2.0, -1


@kernel
def step_onto(
    scheme: Any, system: Any, omega: float, t: float, h: float, y: Any, k: Any, breakpoint: float, t_end: float
) -> Any:
    """Step of about h that ends on the breakpoint (Newton on h): whether it does, h, and the step.

    The whole step is repeated, instead of cutting its interpolant, so that its end has the order of the method too.
    """
    away = torsion(system, omega * t, y) - breakpoint
    shift = 0.0
    for _ in range(4):
        h = min(h - shift, t_end - t)
        y1, k1, error, dense = scheme.attempt(system, omega * t, omega * h, y, h, k)
        gap = torsion(system, omega * (t + h), y1) - breakpoint
        rate = torsion_rate(system, omega, t + h, y1, k1)
        shift = gap / rate if abs(gap) < 0.1 * h * abs(rate) else 0.0
    return abs(gap) <= 1e-3 * abs(away), h, y1, k1, error, dense
