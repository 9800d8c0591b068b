"""Rests of a torsion law under a constant torque, and the direction of the remainder in between.

The rests of J x'' + B x' + T(x) = tau_0 are the zeros of T(x) - tau_0. Between two turning points of the law, and
beyond the last, there is one at most, or an interval; a law that does not say where its torque turns is sampled.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from ..base.law import breakpoints_of
from ..base.sentences import Angle, Sentence
from ..model.laws.springs import MERGE, turning_points_of
from ..numerics.roots import bracketed_root

SAMPLES = 4000  # intervals over the span of a law that is only sampled
ROUNDING = 1e-14  # torques below this fraction of the largest one met are zero to a law that is sampled
TOUCHING = 1e-10  # of the largest torque at a turning point: there two rests MERGE apart are one that it touches
CANCELLED = 1e-14  # of slope times torsion: less is rounding
DISTANCES = tuple(2.0**k for k in range(-40, 200))  # rad beyond the last turning point, where a sign is looked for


@dataclass(frozen=True)
class Landscape:
    """Rests in rising order, as intervals (low, high) [rad], and the sign of T - tau_0 between them.

    Attributes
    ----------
    rests : tuple of (float, float)
        Torsions with T = tau_0; a point has low = high, the play of a backlash is a whole interval.
    signs : tuple of float
        Sign of T - tau_0 left of the first rest, between the rests, and right of the last: one more than rests.
    low, high : float
        Ends of the examined torsions [rad]: infinite where the rests are known for all x.
    """

    rests: tuple[tuple[float, float], ...]
    signs: tuple[float, ...]
    low: float = -math.inf
    high: float = math.inf

    def wells(self) -> tuple[int, ...]:
        """Numbers of the rests that the torque pushes back to from both sides: the minima of the energy."""
        return tuple(i for i in range(len(self.rests)) if self.signs[i] < 0.0 < self.signs[i + 1])

    def borders(self, well: int) -> tuple[float, float]:
        """The next rests on both sides of a well [rad], or the ends of what is known."""
        left = self.rests[well - 1][1] if well > 0 else self.low
        right = self.rests[well + 1][0] if well + 1 < len(self.rests) else self.high
        return left, right


def landscape(law: Any, tau_0: float, span: float | None) -> Landscape:
    """Find the rests of a law under the constant torque `tau_0` [N*m].

    Parameters
    ----------
    law : NamedTuple
        Torsion law.
    tau_0 : float
        Constant torque [N*m].
    span : float, optional
        Largest torsion [rad] to be examined of a law that does not say where its torque turns.

    Raises
    ------
    ValueError
        If `span` is missing or not positive, or the torque is not finite, where the law is sampled.
    """

    def rest_torque(x: float) -> float:
        return float(law.torque(x)) - tau_0

    turns = turning_points_of(law)
    return _sampled(law, rest_torque, span) if turns is None else _turning(rest_torque, turns, abs(tau_0))


def reach(law: Any, tau_0: float, x: float) -> float:
    """Distance [rad] of a torsion in a well from the nearest saddle; infinite without one, and of an unknown law."""
    if turning_points_of(law) is None:
        return math.inf
    field = landscape(law, tau_0, None)
    wells = [field.borders(i) for i in field.wells() if field.rests[i][0] - MERGE <= x <= field.rests[i][1] + MERGE]
    return min((abs(border - x) for borders in wells for border in borders), default=math.inf)


def _signs(
    g: Callable[[float], float], rests: list[tuple[float, float]], low: float = -math.inf, high: float = math.inf
) -> tuple[float, ...]:
    """Sign of g between neighbouring rests; 0 where nothing lies beyond an infinite rest."""
    if not rests:
        return (float(np.sign(g(0.0))),)
    first, last = rests[0][0], rests[-1][1]
    left = 0.5 * (low + first) if math.isfinite(low) else first - max(1.0, abs(first))
    right = 0.5 * (high + last) if math.isfinite(high) else last + max(1.0, abs(last))
    places = [left, *(0.5 * (a[1] + b[0]) for a, b in pairwise(rests)), right]
    return tuple(float(np.sign(g(x))) if math.isfinite(x) else 0.0 for x in places)


def _turning(g: Callable[[float], float], turns: tuple[float, ...], size: float) -> Landscape:
    """Rests of a function that is monotone or constant between and beyond its turning points.

    `size` is the constant torque in it [N*m].
    """
    inner = turns or (0.0,)
    with np.errstate(all="ignore"):
        slope = max((abs(g(b) - g(a)) / (b - a) for a, b in pairwise(inner) if b > a), default=0.0)
        ends = _beyond(g, inner[0], -1.0, slope), _beyond(g, inner[-1], 1.0, slope)
    grid = [ends[0][0], *inner, ends[1][0]]
    values = [ends[0][1], *map(g, inner), ends[1][1]]
    touch = TOUCHING * max(size, *(abs(value) for value in values[1:-1])) if turns else 0.0
    for i, (before, value, after) in enumerate(zip(values, values[1:], values[2:], strict=False), 1):
        if abs(value) <= touch and before * after > 0.0:
            values[i] = 0.0
    intervals = _zeros(g, grid, values, 0.0, 0.0)
    if values[0] == values[1] == 0.0:
        intervals[0] = (-math.inf, intervals[0][1])
    if values[-1] == values[-2] == 0.0:
        intervals[-1] = (intervals[-1][0], math.inf)
    rests: list[tuple[float, float]] = []
    for low, high in intervals:
        if rests and low - rests[-1][1] <= MERGE * max(abs(low), abs(rests[-1][1])):
            first = rests.pop()
            point = 0.5 * (first[0] + high)
            rests.append((point, point) if first[0] == first[1] and low == high else (first[0], high))
        else:
            rests.append((low, high))
    return Landscape(tuple(rests), _signs(g, rests))


def _beyond(g: Callable[[float], float], end: float, outward: float, slope: float) -> tuple[float, float]:
    """First torsion outwards of the last turning point where the function has another sign, and its value there.

    Without one the value is that at the turning point. `slope` is the steepest met inside: a law that cancels large
    terms has rounding in proportion to it and to x.
    """
    start = g(end)
    for distance in DISTANCES:
        x = end + outward * distance
        try:
            value = g(x)
        except OverflowError:
            break
        if not math.isfinite(value):
            break
        slope = max(slope, abs(value - start) / distance)
        if np.sign(value) != np.sign(start) and abs(value) > CANCELLED * slope * abs(x):
            return x, value
    return end + outward, start


def _zeros(
    g: Callable[[float], float], grid: list[float], values: list[float], noise: float, xtol: float
) -> list[tuple[float, float]]:
    """Rests of a function, as intervals, that is monotone between the torsions of a grid, from its values there.

    Values up to `noise` are zero; where there is noise, an interval of zeros ends between two torsions.
    """
    rests: list[tuple[float, float]] = []
    i = 0
    while i < len(grid):
        if abs(values[i]) <= noise:
            j = i
            while j + 1 < len(grid) and abs(values[j + 1]) <= noise:
                j += 1
            wide = noise > 0.0 and i < j
            low = _edge(g, noise, grid[i], grid[i - 1]) if wide and i > 0 else grid[i]
            high = _edge(g, noise, grid[j], grid[j + 1]) if wide and j < len(grid) - 1 else grid[j]
            rests.append((low + 0.0, high + 0.0))  # no -0.0
            i = j
        elif i + 1 < len(grid) and abs(values[i + 1]) > noise and values[i] * values[i + 1] < 0.0:
            rests.append((bracketed_root(g, grid[i], grid[i + 1], xtol=xtol) + 0.0,) * 2)
        i += 1
    return rests


def _sampled(law: Any, g: Callable[[float], float], span: float | None) -> Landscape:
    """Rests of an unknown law on |x| <= span, from sign changes and zeros on samples."""
    name = type(law).__name__
    if span is None or not 0.0 < span < math.inf:
        raise ValueError(f"span is {span}, but {name} is only known by samples; give the largest torsion in rad")
    inner = [b for b in breakpoints_of(law) if abs(b) < span]
    grid = sorted({*np.linspace(-span, span, SAMPLES + 1).tolist(), *inner})
    values = [g(x) for x in grid]
    for x, value in zip(grid, values, strict=True):
        if not math.isfinite(value):
            raise ValueError(
                Sentence(
                    "the torque of {} at x = {} is {}; take a span smaller than {}", name, Angle(x), value, Angle(span)
                )
            )
    # In a gap the torque is zero but for rounding; a rest too wide makes the claim weaker, never wrong.
    noise = ROUNDING * max(abs(value) for value in values)
    rests = _zeros(g, grid, values, noise, 1e-15 * span)
    return Landscape(tuple(rests), _signs(g, rests, -span, span), -span, span)


def _edge(g: Callable[[float], float], noise: float, inside: float, outside: float) -> float:
    """End of an interval of zeros between a point inside it and one outside."""
    for _ in range(60):
        middle = 0.5 * (inside + outside)
        inside, outside = (middle, outside) if abs(g(middle)) <= noise else (inside, middle)
    return outside
