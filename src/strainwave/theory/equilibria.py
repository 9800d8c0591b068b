"""Where a torsion law balances a constant torque, and which way the remainder pushes in between.

The rests of J x'' + B x' + T(x) = tau_0 are the zeros of T(x) - tau_0. They are found exactly for piecewise-linear
laws, from the roots for polynomial ones, between the nodes of laws that never fall, and on samples for a law that is
not of this package.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from ..base.law import breakpoints_of
from ..base.sentences import Angle, Sentence
from ..model.laws import Backlash, Cubic, Linear, PiecewiseLinear, Play, Polynomial, RoundedPiecewiseLinear, Tabulated
from ..numerics.operating_point import bracketed_root

KNOWN = (Linear, Cubic, Polynomial, PiecewiseLinear, Backlash, RoundedPiecewiseLinear, Tabulated)
SAMPLES = 4000  # intervals over the span of a law that is only sampled
ROUNDING = 1e-14  # torques below this fraction of the largest one met are zero to an unknown law
MERGE = 1e-5  # roots closer than this fraction are one multiple root: np.roots spreads a triple root by eps^(1/3)


@dataclass(frozen=True)
class Landscape:
    """Rests in rising order, as intervals (low, high) [rad], and the sign of T - tau_0 between them.

    Attributes
    ----------
    rests : tuple of (float, float)
        Where T = tau_0; a point has low = high, the play of a backlash is a whole interval.
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


def is_known(law: Any) -> bool:
    """Whether the rests of a law are known for all torsions."""
    return type(law) in KNOWN or (type(law) is Play and is_known(law.law))


def landscape(law: Any, tau_0: float, span: float | None) -> Landscape:
    """Find the rests of a law under the constant torque `tau_0` [N*m].

    Parameters
    ----------
    law : NamedTuple
        Torsion law.
    tau_0 : float
        Constant torque [N*m].
    span : float, optional
        Largest torsion [rad] to be examined of a law that is not of this package; the package's laws do not need it.

    Raises
    ------
    ValueError
        If `span` is missing or not positive, or the torque is not finite, where the law is sampled.
    """

    def rest_torque(x: float) -> float:
        return float(law.torque(x)) - tau_0

    # Compared by class, not by isinstance: a user's subclass may change the torque.
    match law if is_known(law) else None:
        case Linear():
            return _piecewise(rest_torque, (0.0,), (law.K, law.K))
        case PiecewiseLinear(K3=K3):
            return _piecewise(rest_torque, law.breakpoints(), (K3, K3))
        case Backlash(K=K):
            return _piecewise(rest_torque, law.breakpoints(), (K, K))
        case RoundedPiecewiseLinear(K3=K3, width=width):
            corners = PiecewiseLinear(*law[:5]).breakpoints()
            nodes = [b + side for b in corners for side in (-0.5 * width, 0.5 * width)]
            return _piecewise(rest_torque, tuple(sorted(nodes)), (K3, K3), curved=True)
        case Tabulated(knots=knots):
            nodes = [knot.x for knot in knots]
            return _piecewise(rest_torque, tuple(nodes), (knots[0].K, knots[-1].K), curved=True)
        case Play(half_gap=half_gap, law=inner):
            return _behind_gap(landscape(inner, tau_0, span), half_gap)
        case Cubic(K=K, alpha=alpha):
            return _polynomial(rest_torque, (-tau_0, K, 0.0, K * alpha))
        case Polynomial(coefficients=c):
            return _polynomial(rest_torque, (c[0] - tau_0, *c[1:]))
        case _:
            return _sampled(law, rest_torque, span)


def reach(law: Any, tau_0: float, x: float) -> float:
    """Distance [rad] of a torsion in a well from the nearest saddle; infinite without one, and of an unknown law."""
    if not is_known(law):
        return math.inf
    found = landscape(law, tau_0, None)
    wells = [found.borders(i) for i in found.wells() if found.rests[i][0] - MERGE <= x <= found.rests[i][1] + MERGE]
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


def _behind_gap(inner: Landscape, half_gap: float) -> Landscape:
    """Rests of a law with play from those of the law: all move outwards, and a rest at zero becomes the gap."""

    def ends(low: float, high: float) -> tuple[float, float]:
        left = low - half_gap if low <= 0.0 else low + half_gap
        return left, high + half_gap if high >= 0.0 else high - half_gap

    return Landscape(tuple(ends(low, high) for low, high in inner.rests), inner.signs)


def _piecewise(
    g: Callable[[float], float], nodes: tuple[float, ...], slopes: tuple[float, float], curved: bool = False
) -> Landscape:
    """Rests of a continuous function, straight between nodes (or curved but never falling) and beyond them.

    `slopes` are those before the first node and after the last.
    """
    values = [g(x) for x in nodes]
    intervals = [(x, x) for x, value in zip(nodes, values, strict=True) if value == 0.0]
    for (a, ga), (b, gb) in pairwise(zip(nodes, values, strict=True)):
        if ga == 0.0 == gb:
            intervals.append((a, b))
        elif ga * gb < 0.0:
            x = bracketed_root(g, a, b, xtol=1e-300) if curved else a - ga * (b - a) / (gb - ga)
            intervals.append((x, x))
    for node, value, slope, outward in (
        (nodes[0], values[0], slopes[0], -1.0),
        (nodes[-1], values[-1], slopes[1], 1.0),
    ):
        if value == 0.0 == slope:
            intervals.append((node, math.inf) if outward > 0.0 else (-math.inf, node))
        elif value * slope * outward < 0.0:
            intervals.append((node - value / slope,) * 2)
    rests: list[tuple[float, float]] = []
    for low, high in sorted((low + 0.0, high + 0.0) for low, high in intervals):  # no -0.0
        if rests and low <= rests[-1][1]:
            rests[-1] = (rests[-1][0], max(high, rests[-1][1]))
        else:
            rests.append((low, high))
    return Landscape(tuple(rests), _signs(g, rests))


def _polynomial(g: Callable[[float], float], coefficients: tuple[float, ...]) -> Landscape:
    """Rests of a polynomial, c0 + c1 x + ...: its real roots, where roots that nearly coincide count as one."""
    if not any(coefficients):
        return Landscape(((-math.inf, math.inf),), (0.0, 0.0))
    roots = np.roots(coefficients[::-1])
    # A pair this near to the real axis counts as a double root: a rest too many makes the claim smaller, never wrong.
    near = np.sort(np.real(roots[np.abs(roots.imag) <= MERGE * np.abs(roots)]))
    groups: list[list[float]] = []
    for root in near.tolist():
        if groups and root - groups[-1][-1] <= MERGE * max(abs(root), abs(groups[-1][-1])):
            groups[-1].append(root)
        else:
            groups.append([root])
    slope = np.polynomial.Polynomial(coefficients).deriv()
    points = [_polished(g, slope, group) for group in groups]
    rests = [(x, x) for x in points]
    return Landscape(tuple(rests), _signs(g, rests))


def _polished(g: Callable[[float], float], slope: Callable[[float], float], group: list[float]) -> float:
    """Mean of a group of roots; a single one after Newton steps: `np.roots` errs by a fraction of the largest root."""
    x = sum(group) / len(group)
    for _ in range(3 if len(group) == 1 else 0):
        rate = float(slope(x))
        better = x - g(x) / rate if rate != 0.0 else x
        if not abs(g(better)) < abs(g(x)):
            break
        x = better
    return x


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
    rests: list[tuple[float, float]] = []
    i = 0
    while i < len(grid):
        if abs(values[i]) <= noise:
            j = i
            while j + 1 < len(grid) and abs(values[j + 1]) <= noise:
                j += 1
            low = _edge(g, noise, grid[i], grid[i - 1]) if 0 < i < j else grid[i]
            high = _edge(g, noise, grid[j], grid[j + 1]) if i < j < len(grid) - 1 else grid[j]
            rests.append((low, high))
            i = j
        elif i + 1 < len(grid) and abs(values[i + 1]) > noise and values[i] * values[i + 1] < 0.0:
            rests.append((bracketed_root(g, grid[i], grid[i + 1], xtol=1e-15 * span),) * 2)
        i += 1
    return Landscape(tuple(rests), _signs(g, rests, -span, span), -span, span)


def _edge(g: Callable[[float], float], noise: float, inside: float, outside: float) -> float:
    """End of an interval of zeros between a point inside it and one outside."""
    for _ in range(60):
        middle = 0.5 * (inside + outside)
        inside, outside = (middle, outside) if abs(g(middle)) <= noise else (inside, middle)
    return outside
