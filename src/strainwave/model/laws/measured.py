"""The torsion law of a measurement: a monotone cubic through points.

As in `laws`, it is a NamedTuple with branch-free `torque(x)`, `stiffness(x)` and `energy(x)`; it is C1 in the torque,
so it has no breakpoints. x is in rad on the output side, torque in N*m, energy in J.
"""

from collections.abc import Sequence
from itertools import pairwise
from math import isfinite
from typing import Any, NamedTuple

from ...base.quantities import LARGEST, Angle, Torque, TorsionalStiffness, checked, reals, shown
from ...compile.jit import kernel

FEWEST_POINTS, MOST_POINTS = 3, 64


class Knot(NamedTuple):
    """One point of a tabulated law: torsion x, torque T and stiffness K there."""

    x: Angle
    T: Torque
    K: TorsionalStiffness


@kernel
def outward(knots: Any, i: int) -> Any:
    """Interval i as cubic away from zero: first and last knot, direction, length, coefficients of s^2 and s^3."""
    a, b = knots[i], knots[i + 1]
    side = -1.0 if b.x <= 0.0 else 1.0
    begin, end = (b, a) if b.x <= 0.0 else (a, b)
    h = b.x - a.x
    secant = (b.T - a.T) / h
    return begin, end, side, h, (3.0 * secant - 2.0 * begin.K - end.K) / h, (a.K + b.K - 2.0 * secant) / (h * h)


@kernel
def anchor(knots: Any) -> Any:
    """Knot from which all intervals are added up: the last that is not above zero, so that T(0) of a knot is exact."""
    knot = knots[0]
    for i in range(1, len(knots)):
        knot = knots[i] if knots[i].x <= 0.0 else knot
    return knot


@kernel
def positive(s: Any) -> Any:
    """Return s where it is positive, else exactly 0."""
    return 0.5 * (s + abs(s))


@kernel
def shorter(s: Any, h: Any) -> Any:
    """Return the smaller of s and h; 0 exactly for s = 0 < h."""
    return 0.5 * (s + h - abs(s - h))


@kernel
def work(knots: Any, x: Any) -> Any:
    """Work [J] from the anchor to x."""
    first, last, start = knots[0], knots[len(knots) - 1], anchor(knots)
    below, above = positive(first.x - x), positive(x - last.x)
    total = start.T * (x - start.x) + 0.5 * (first.K * below * below + last.K * above * above)
    for i in range(len(knots) - 1):
        begin, end, side, h, second, third = outward(knots, i)
        s = shorter(positive(side * (x - begin.x)), h)
        rise = s * (begin.K + s * (second + s * third))
        total = (
            total + s * s * (begin.K / 2.0 + s * (second / 3.0 + s * third / 4.0)) + rise * positive(side * (x - end.x))
        )
    return total


class Tabulated(NamedTuple):
    """Monotone cubic through measured points, straight beyond the first and the last; C1. Build it with `tabulated`.

    Between two knots the torque is the cubic that has their torques and stiffnesses (Hermite). All arithmetic is a sum
    over the knots, so time grows with their number.
    """

    knots: tuple[Knot, ...]

    def torque(self, x: Any) -> Any:
        """Torque T(x) [N*m] at torsion x [rad]; exactly that of the knot at x = 0, if there is one."""
        knots = self.knots
        first, last = knots[0], knots[len(knots) - 1]
        total = anchor(knots).T + last.K * positive(x - last.x) - first.K * positive(first.x - x)
        for i in range(len(knots) - 1):
            begin, _, side, h, second, third = outward(knots, i)
            s = shorter(positive(side * (x - begin.x)), h)
            total = total + side * s * (begin.K + s * (second + s * third))
        return total

    def stiffness(self, x: Any) -> Any:
        """Stiffness dT/dx [N*m/rad] at torsion x [rad]; continuous."""
        total = anchor(self.knots).K + 0.0 * x
        for i in range(len(self.knots) - 1):
            begin, _, side, h, second, third = outward(self.knots, i)
            s = shorter(positive(side * (x - begin.x)), h)
            total = total + s * (2.0 * second + 3.0 * third * s)
        return total

    def energy(self, x: Any) -> Any:
        """Energy stored [J] at torsion x [rad]."""
        return work(self.knots, x) - work(self.knots, 0.0)

    def breakpoints(self) -> tuple[float, ...]:
        """No breakpoints: the slope is continuous."""
        return ()

    def turning_points(self) -> tuple[float, ...]:
        """Torsions [rad] of the knots: between two of them the torque rises or is constant."""
        return tuple(knot.x for knot in self.knots)

    def check(self) -> None:
        """Refuse too few knots, knots out of order, falling torques, and slopes that overshoot (ValueError)."""
        _check_points([(knot.x, knot.T) for knot in self.knots])
        for a, b in pairwise(self.knots):
            secant = (b.T - a.T) / (b.x - a.x)
            # Fritsch & Carlson 1980, sec. 3: sufficient for a monotone cubic
            if min(a.K, b.K) < 0.0 or max(a.K, b.K) > 3.0 * secant * (1.0 + 1e-12):
                raise ValueError(
                    f"Tabulated has the slopes {a.K:g} and {b.K:g} N*m/rad at {a.x:g} and {b.x:g} rad, whose points "
                    f"rise with {secant:g} N*m/rad; they must lie between 0 and three times that, tabulated(points) "
                    "finds some"
                )


def tabulated(points: Sequence[Sequence[float]], *, odd: bool = False) -> Tabulated:
    """Build the monotone cubic law through measured points.

    Parameters
    ----------
    points : sequence of (float, float)
        Torsions [rad, output side], ascending, and torques [N*m], not descending; 3 to 64 pairs.
    odd : bool
        True to add the origin and the mirror image of points that all have positive torsions.

    Returns
    -------
    Tabulated
        A law: torque [N*m] at a torsion [rad]. The stiffness at an inner knot is the weighted harmonic mean of the
        two neighbouring secants (0 where one of them is 0), at an end the three-point formula, limited so that the
        cubic stays monotone.

    Raises
    ------
    ValueError
        If there are fewer than 3 or more than 64 points, or they are not numbers, unsorted, repeated or falling.

    References
    ----------
    Fritsch & Carlson 1980, SIAM J. Numer. Anal. 17(2), 238-246 (monotone cubics); Fritsch & Butland 1984, SIAM J. Sci.
    Stat. Comput. 5(2), 300-304, eq. (5) (the mean); Moler 2004, Numerical Computing with MATLAB, sec. 3.6 (the ends).
    """
    pairs = [_pair(point) for point in points]
    if odd:
        if pairs and not pairs[0][0] > 0.0:
            raise ValueError(
                f"an odd law is given by points with positive torsions and has one at {pairs[0][0]:g} rad; leave out "
                "the origin and the mirrored half, or write odd=False"
            )
        pairs = [*((-x, -T) for x, T in reversed(pairs)), (0.0, 0.0), *pairs]
    _check_points(pairs)
    steps = [b[0] - a[0] for a, b in pairwise(pairs)]
    secants = [(b[1] - a[1]) / h for (a, b), h in zip(pairwise(pairs), steps, strict=True)]
    inner = [_inner_slope(*steps[i - 1 : i + 1], *secants[i - 1 : i + 1]) for i in range(1, len(steps))]
    first, last = _end_slope(steps, secants), _end_slope(steps[::-1], secants[::-1])
    slopes = (first, *inner, last)
    law: Tabulated = checked(Tabulated(tuple(Knot(x, T, K) for (x, T), K in zip(pairs, slopes, strict=True))))
    return law


def _pair(point: Sequence[float]) -> tuple[float, float]:
    if reals(point).shape != (2,):
        raise ValueError(f"{shown(point)} is no point; write (torsion in rad, torque in N*m)")
    x, T = map(float, point)
    return x, T


def _check_points(pairs: Sequence[tuple[float, float]]) -> None:
    if not FEWEST_POINTS <= len(pairs) <= MOST_POINTS:
        many = "; average neighbouring points" if len(pairs) > MOST_POINTS else "; two make a straight line: use Linear"
        raise ValueError(f"a table of {len(pairs)} points is given; it needs {FEWEST_POINTS} to {MOST_POINTS}{many}")
    for x, T in pairs:
        if not (isfinite(x) and isfinite(T)):
            raise ValueError(f"the point ({x:g} rad, {T:g} N*m) is not finite; remove it")
    for (x0, T0), (x1, T1) in pairwise(pairs):
        if x1 == x0:
            raise ValueError(f"the torsion {x1:g} rad appears twice; average the two torques {T0:g} and {T1:g} N*m")
        if x1 < x0:
            raise ValueError(f"the torsion {x1:g} rad stands after {x0:g} rad; sort the points by torsion")
        if T1 < T0:
            raise ValueError(
                f"the torque falls from {T0:g} to {T1:g} N*m between {x0:g} and {x1:g} rad (negative stiffness); "
                "correct the points, or average the branches of a hysteresis loop first"
            )
        if not LARGEST * (x1 - x0) >= (T1 - T0):
            raise ValueError(
                f"the torque rises from {T0:g} to {T1:g} N*m between {x0:g} and {x1:g} rad, more than {LARGEST:g} "
                "N*m/rad; give the torsions in rad"
            )
    if pairs[0][1] == pairs[-1][1]:
        raise ValueError(f"the torque is {pairs[0][1]:g} N*m at every point; a law needs one that rises")


def _inner_slope(h0: float, h1: float, left: float, right: float) -> float:
    """Slope [N*m/rad] at a knot between steps h0 and h1 [rad] and their secants: the mean that keeps it monotone."""
    if left == 0.0 or right == 0.0:
        return 0.0
    w0, w1 = h0 + 2.0 * h1, 2.0 * h0 + h1
    return (w0 + w1) / (w0 / left + w1 / right)


def _end_slope(steps: Sequence[float], secants: Sequence[float]) -> float:
    """One-sided three-point slope at the first point, not negative (it is at most twice the first secant)."""
    (h0, h1), (first, second) = steps[:2], secants[:2]
    return max(((2.0 * h0 + h1) * first - h0 * second) / (h0 + h1), 0.0)
