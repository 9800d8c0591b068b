"""Torsion laws: the torque of a gear's spring as a function of its torsion u.

A law is a NamedTuple with `torque(x)`, `stiffness(x)` = dT/dx, `energy(x)` (zero at x = 0) and, where it is not smooth,
`breakpoints()`, the torsions where its slope changes. All arithmetic is branch-free, so that one definition serves
numbers, arrays, compiled kernels and, where the law is smooth, symbols. x is in rad on the output side, torque in N*m,
energy in J.

What a law says of its torque as a whole, theory asks for: `polynomial()`, its coefficients c_0, c_1 and so on, where it
is one; else `turning_points()`, the torsions between which, and beyond which, the torque only rises, only falls or is
constant. A law that says neither is sampled.

`scaled(factor)` is the same law with its torque times a factor, in the form that runs many steps: of the same class, or
of one with nothing left to compute again in every step, which stands under its law. Numbers may then be arrays.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...base.law import KINDS, breakpoints_of, depends, has, polynomial_of, stated
from ...base.protocols import need
from ...base.quantities import Angle, PerSquareRadian, Reals, States, Torque, TorsionalStiffness
from ...compile.jit import kernel
from ...compile.maths import sign
from ...compile.tree import with_leaf
from .rounded import ROUNDED, RoundedPiecewiseLinear, check_slopes, corners, widest

MERGE = 1e-5  # roots closer than this fraction are one multiple root: `roots` spreads a triple root by eps^(1/3)


class Linear(NamedTuple):
    """Ideal spring T = K x. Analytic, odd."""

    K: TorsionalStiffness

    def torque(self, x: Reals) -> Any:
        """Torque T(x) [N*m] at torsion x [rad]."""
        return self.K * x

    def stiffness(self, x: Reals) -> Any:
        """Stiffness dT/dx [N*m/rad] at torsion x [rad]."""
        return self.K + 0.0 * x

    def energy(self, x: Reals) -> Any:
        """Energy stored [J] at torsion x [rad]."""
        return 0.5 * self.K * x * x

    def breakpoints(self) -> tuple[float, ...]:
        """No breakpoints: the law is smooth."""
        return ()

    def scaled(self, factor: Any) -> "Linear":
        """The same law times a factor."""
        return Linear(self.K * factor)

    def polynomial(self) -> tuple[float, ...]:
        """Coefficients of the torque."""
        return (0.0, self.K)


class Cubic(NamedTuple):
    """Hardening (alpha > 0) or softening (alpha < 0) spring T = K (x + alpha x^3). Analytic, odd."""

    K: TorsionalStiffness
    alpha: PerSquareRadian

    def torque(self, x: Reals) -> Any:
        """Torque T(x) [N*m] at torsion x [rad]."""
        return self.K * (x + self.alpha * x * x * x)

    def stiffness(self, x: Reals) -> Any:
        """Stiffness dT/dx [N*m/rad] at torsion x [rad]."""
        return self.K * (1.0 + 3.0 * self.alpha * x * x)

    def energy(self, x: Reals) -> Any:
        """Energy stored [J] at torsion x [rad]."""
        xx = x * x
        return self.K * xx * (0.5 + 0.25 * self.alpha * xx)

    def breakpoints(self) -> tuple[float, ...]:
        """No breakpoints: the law is smooth."""
        return ()

    def scaled(self, factor: Reals) -> "LinearAndCubic":
        """The same law times a factor, its coefficients multiplied out."""
        return LinearAndCubic(self.K * factor, self.K * self.alpha * factor)

    def polynomial(self) -> tuple[float, ...]:
        """Coefficients of the torque."""
        return (0.0, self.K, 0.0, self.K * self.alpha)


class LinearAndCubic(NamedTuple):
    """Odd law linear x + cubic x^3: `Cubic` with its coefficients multiplied out."""

    linear: Any
    cubic: Any

    def torque(self, x: Reals) -> Any:
        """Torque T(x) [N*m] at torsion x [rad]."""
        return x * (self.linear + self.cubic * (x * x))


class Polynomial(NamedTuple):
    """Power series: T is the sum of c_k x^k, k = 0, 1, 2 and so on, c_k in N*m/rad^k. Analytic; odd without even k."""

    coefficients: tuple[float, ...]

    def torque(self, x: Reals) -> Any:
        """Torque T(x) [N*m] at torsion x [rad]; T(0) = c0."""
        c = self.coefficients
        total = 0.0 * x
        for i in range(len(c)):
            total = total * x + c[len(c) - 1 - i]
        return total

    def stiffness(self, x: Reals) -> Any:
        """Stiffness dT/dx [N*m/rad] at torsion x [rad]."""
        c = self.coefficients
        total = 0.0 * x
        for i in range(len(c) - 1):
            k = len(c) - 1 - i
            total = total * x + k * c[k]
        return total

    def energy(self, x: Any) -> Any:
        """Energy stored [J] at torsion x [rad]."""
        c = self.coefficients
        total = 0.0 * x
        for i in range(len(c)):
            k = len(c) - 1 - i
            total = (total + c[k] / (k + 1)) * x
        return total

    def breakpoints(self) -> tuple[float, ...]:
        """No breakpoints: the law is smooth."""
        return ()

    def scaled(self, factor: Any) -> "Polynomial":
        """The same law times a factor."""
        return Polynomial(tuple(c * factor for c in self.coefficients))

    def polynomial(self) -> tuple[float, ...]:
        """Coefficients of the torque."""
        return self.coefficients


class PiecewiseLinear(NamedTuple):
    """The vendors' stiffness: slope K1 up to torque T1, K2 up to T2, K3 beyond; odd, C0.

    Torsion at T1 is x1 = T1/K1, at T2 it is x2 = x1 + (T2 - T1)/K2 (Harmonic Drive LLC, CSF/CSG catalogue, p. 50).
    Requires 0 < T1 < T2 and positive slopes.
    """

    K1: TorsionalStiffness
    K2: TorsionalStiffness
    K3: TorsionalStiffness
    T1: Torque
    T2: Torque

    def torque(self, x: Any) -> Any:
        """Torque T(x) [N*m] at torsion x [rad]."""
        x1, x2 = corners(self)
        inner = 0.5 * (self.K1 - self.K2) * (abs(x + x1) - abs(x - x1))
        outer = 0.5 * (self.K2 - self.K3) * (abs(x + x2) - abs(x - x2))
        return self.K3 * x + inner + outer

    def stiffness(self, x: Reals) -> Any:
        """Stiffness dT/dx [N*m/rad] at torsion x [rad]; at a breakpoint the mean of both sides."""
        x1, x2 = corners(self)
        inner = 0.5 * (self.K1 - self.K2) * (sign(x + x1) - sign(x - x1))
        outer = 0.5 * (self.K2 - self.K3) * (sign(x + x2) - sign(x - x2))
        return self.K3 + inner + outer

    def energy(self, x: Any) -> Any:
        """Energy stored [J] at torsion x [rad]."""
        x1, x2 = corners(self)
        # c is the part of abs(x) inside the breakpoint: the integral of clip(x, -b, b) is c abs(x) - c^2/2
        c1 = 0.5 * abs(abs(x + x1) - abs(x - x1))
        c2 = 0.5 * abs(abs(x + x2) - abs(x - x2))
        inner = (self.K1 - self.K2) * (c1 * abs(x) - 0.5 * c1 * c1)
        outer = (self.K2 - self.K3) * (c2 * abs(x) - 0.5 * c2 * c2)
        return 0.5 * self.K3 * x * x + inner + outer

    def breakpoints(self) -> tuple[float, ...]:
        """Torsions [rad] where the slope changes: -x2, -x1, x1, x2."""
        x1, x2 = corners(self)
        return (-x2, -x1, x1, x2)

    def scaled(self, factor: Reals) -> "Slopes":
        """The same law times a factor, without divisions."""
        x1, x2 = corners(self)
        half = 0.5 * factor
        return Slopes(self.K3 * factor, half * (self.K1 - self.K2), half * (self.K2 - self.K3), x1, x2)

    def turning_points(self) -> tuple[float, ...]:
        """None: the torque rises."""
        return ()

    def rounded(self) -> RoundedPiecewiseLinear:
        """The same law with its corners rounded."""
        return RoundedPiecewiseLinear(*self, ROUNDED * widest(self))

    def check(self) -> None:
        """Refuse slopes that are not positive, and torques out of order (ValueError)."""
        check_slopes(self)


class Slopes(NamedTuple):
    """Odd law of three slopes with breakpoints x1 < x2: `PiecewiseLinear` without its divisions."""

    K3: Any
    inner: Any
    outer: Any
    x1: Any
    x2: Any

    def torque(self, x: Reals) -> Any:
        """Torque T(x) [N*m] at torsion x [rad]."""
        inner = self.inner * (abs(x + self.x1) - abs(x - self.x1))
        return self.K3 * x + inner + self.outer * (abs(x + self.x2) - abs(x - self.x2))


@kernel
def outside(x: Any, gap: Any) -> Any:
    """Torsion [rad] beyond a gap of a half width: exactly 0 inside it."""
    above, below = x - gap, x + gap
    return 0.5 * ((above + abs(above)) + (below - abs(below)))


class Backlash(NamedTuple):
    """Play: T = 0 for |x| <= half_gap, K (x - half_gap sign x) outside; odd, C0."""

    K: TorsionalStiffness
    half_gap: Angle

    def torque(self, x: Any) -> Any:
        """Torque T(x) [N*m] at torsion x [rad]."""
        return self.K * outside(x, self.half_gap)

    def stiffness(self, x: Reals) -> Any:
        """Stiffness dT/dx [N*m/rad] at torsion x [rad]; at the edge of the gap the mean of both sides."""
        b = self.half_gap
        return self.K * (1.0 - 0.5 * (sign(x + b) - sign(x - b)))

    def energy(self, x: Any) -> Any:
        """Energy stored [J] at torsion x [rad]."""
        beyond = outside(x, self.half_gap)
        return 0.5 * self.K * beyond * beyond

    def breakpoints(self) -> tuple[float, ...]:
        """Torsions [rad] at the edges of the gap."""
        return (-self.half_gap, self.half_gap)

    def scaled(self, factor: Any) -> "Backlash":
        """The same law times a factor."""
        return Backlash(self.K * factor, self.half_gap)

    def turning_points(self) -> tuple[float, ...]:
        """Torsions [rad] at the edges of the gap."""
        return self.breakpoints()

    def check(self) -> None:
        """Refuse a negative gap (ValueError)."""
        if self.half_gap < 0.0:
            raise ValueError(f"Backlash.half_gap is {self.half_gap:g} rad; it must not be negative")


@kernel
def spread(places: States, gap: Any) -> Any:
    """Breakpoints of a law behind a gap, sorted: the edges of the gap, and the law's own moved outwards by it."""
    edges = (-gap, gap) + places  # noqa: RUF005  (Numba takes no starred tuple for a variable that loops change)
    for i in range(2, len(edges)):
        edges = with_leaf(edges, i, edges[i] + gap * sign(edges[i]))
        for j in range(i, 0, -1):
            low, high = min(edges[j - 1], edges[j]), max(edges[j - 1], edges[j])
            edges = with_leaf(with_leaf(edges, j - 1, low), j, high)
    return edges


class Play(NamedTuple):
    """A gap in series with any spring law: T = 0 for |x| <= half_gap, law(x - half_gap sign x) outside.

    The free play of an Oldham coupling at the wave generator, seen at the output. The law must be zero at zero;
    `Play(b, Linear(K))` is `Backlash(K, b)`. Odd if the law is; C0.
    """

    half_gap: Angle
    law: Any

    def torque(self, x: Any) -> Any:
        """Torque T(x) [N*m] at torsion x [rad]."""
        return self.law.torque(outside(x, self.half_gap))

    def stiffness(self, x: Any) -> Any:
        """Stiffness dT/dx [N*m/rad] at torsion x [rad]; at the edge of the gap the mean of both sides."""
        touching = 1.0 - 0.5 * (sign(x + self.half_gap) - sign(x - self.half_gap))
        return touching * self.law.stiffness(outside(x, self.half_gap))

    def energy(self, x: Any) -> Any:
        """Energy stored [J] at torsion x [rad]."""
        return self.law.energy(outside(x, self.half_gap))

    def breakpoints(self) -> tuple[float, ...]:
        """Torsions [rad] at the edges of the gap, and the law's breakpoints moved outwards by it."""
        places: tuple[float, ...] = spread(breakpoints_of(self.law), self.half_gap)
        return places

    def turning_points(self) -> tuple[float, ...] | None:
        """Torsions [rad] at the edges of the gap, and the law's turning points moved outwards by it."""
        inner = turning_points_of(self.law)
        return None if inner is None else spread(inner, self.half_gap)

    def check(self) -> None:
        """Refuse a negative gap, a law that pulls, pushes or has a corner at zero (ValueError), and no spring."""
        if self.half_gap < 0.0:
            raise ValueError(f"Play.half_gap is {self.half_gap:g} rad; it must not be negative")
        need("Play.law", self.law, "torque")
        name = type(self.law).__name__
        if depends(self.law) != 1:
            raise TypeError(f"Play.law is a {name} with {KINDS[depends(self.law) - 1]}; it takes a spring, torque(x)")
        need("Play.law", self.law, "stiffness")
        pull = float(self.law.torque(0.0))
        if pull != 0.0:
            raise ValueError(
                f"Play.law is a {name} with the torque {pull:g} N*m at zero torsion; inside the gap nothing can carry "
                "it, use a law with T(0) = 0 and give the mean torque to the excitation"
            )
        stiffness = float(self.law.stiffness(0.0))
        if stiffness < 0.0:
            raise ValueError(
                f"Play.law is a {name} with the stiffness {stiffness:g} N*m/rad at zero torsion; behind a gap it would "
                "push the sides apart, give one that is not negative"
            )
        if 0.0 in breakpoints_of(self.law):
            raise ValueError(f"Play.law is a {name} with a corner at zero torsion; the gap has its own, move it away")


def turning_points_of(law: Any) -> tuple[float, ...] | None:
    """Turning points [rad] of a law in rising order, its own or its polynomial's; None where it says neither."""
    coefficients = polynomial_of(law)
    if coefficients is None:
        points = stated(law, "turning_points")
        return None if points is None else tuple(sorted(map(float, points)))
    roots = np.polynomial.Polynomial(np.trim_zeros(coefficients, "b") or [0.0]).deriv().roots()
    return tuple(np.sort(roots.real[np.abs(roots.imag) <= MERGE * np.abs(roots)]).tolist())


def energy_in(law: Any) -> Callable[[Any], Any] | None:
    """Stored energy [J] as a function of the torsion [rad]: a spring's own, or its polynomial's; None without both."""
    coefficients = polynomial_of(law)
    if has(law, "energy") or coefficients is None:
        return getattr(law, "energy", None)
    return np.polynomial.Polynomial(coefficients).integ()


def taylor(law: Any, x: float) -> tuple[float | None, float | None]:
    """Second and third Taylor coefficient of a polynomial law at x; None for other laws."""
    coefficients = polynomial_of(law)
    if coefficients is None:
        return None, None
    series = np.polynomial.Polynomial(coefficients)
    return float(series.deriv(2)(x)) / 2.0, float(series.deriv(3)(x)) / 6.0
