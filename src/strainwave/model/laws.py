"""Torsion laws: the torque of a gear's spring as a function of its torsion u.

A law is a NamedTuple with `torque(x)`, `stiffness(x)` = dT/dx, `energy(x)` (zero at x = 0) and, where it is not smooth,
`breakpoints()`, the torsions where its slope changes. All arithmetic is branch-free, so that one definition serves
numbers, arrays, compiled kernels and, where the law is smooth, symbols. x is in rad on the output side, torque in N*m,
energy in J.
"""

from typing import Any, NamedTuple

from ..maths import sign
from ..quantities import Angle, PerSquareRadian, Torque, TorsionalStiffness


class Linear(NamedTuple):
    """Ideal spring T = K x. Analytic, odd."""

    K: TorsionalStiffness

    def torque(self, x: Any) -> Any:
        """Torque T(x) [N*m] at torsion x [rad]."""
        return self.K * x

    def stiffness(self, x: Any) -> Any:
        """Stiffness dT/dx [N*m/rad] at torsion x [rad]."""
        return self.K + 0.0 * x

    def energy(self, x: Any) -> Any:
        """Energy stored [J] at torsion x [rad]."""
        return 0.5 * self.K * x * x

    def breakpoints(self) -> tuple[float, ...]:
        """No breakpoints: the law is smooth."""
        return ()


class Cubic(NamedTuple):
    """Hardening (alpha > 0) or softening (alpha < 0) spring T = K (x + alpha x^3). Analytic, odd."""

    K: TorsionalStiffness
    alpha: PerSquareRadian

    def torque(self, x: Any) -> Any:
        """Torque T(x) [N*m] at torsion x [rad]."""
        return self.K * (x + self.alpha * x * x * x)

    def stiffness(self, x: Any) -> Any:
        """Stiffness dT/dx [N*m/rad] at torsion x [rad]."""
        return self.K * (1.0 + 3.0 * self.alpha * x * x)

    def energy(self, x: Any) -> Any:
        """Energy stored [J] at torsion x [rad]."""
        xx = x * x
        return self.K * xx * (0.5 + 0.25 * self.alpha * xx)

    def breakpoints(self) -> tuple[float, ...]:
        """No breakpoints: the law is smooth."""
        return ()


class Polynomial(NamedTuple):
    """T = c0 + c1 x + c2 x^2 + ... with a tuple of coefficients c_k [N*m/rad^k]. Analytic; odd if c0 = c2 = ... = 0."""

    coefficients: tuple[float, ...]

    def torque(self, x: Any) -> Any:
        """Torque T(x) [N*m] at torsion x [rad]; T(0) = c0."""
        c = self.coefficients
        total = 0.0 * x
        for i in range(len(c)):
            total = total * x + c[len(c) - 1 - i]
        return total

    def stiffness(self, x: Any) -> Any:
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
        x1 = self.T1 / self.K1
        x2 = x1 + (self.T2 - self.T1) / self.K2
        inner = 0.5 * (self.K1 - self.K2) * (abs(x + x1) - abs(x - x1))
        outer = 0.5 * (self.K2 - self.K3) * (abs(x + x2) - abs(x - x2))
        return self.K3 * x + inner + outer

    def stiffness(self, x: Any) -> Any:
        """Stiffness dT/dx [N*m/rad] at torsion x [rad]; at a breakpoint the mean of both sides."""
        x1 = self.T1 / self.K1
        x2 = x1 + (self.T2 - self.T1) / self.K2
        inner = 0.5 * (self.K1 - self.K2) * (sign(x + x1) - sign(x - x1))
        outer = 0.5 * (self.K2 - self.K3) * (sign(x + x2) - sign(x - x2))
        return self.K3 + inner + outer

    def energy(self, x: Any) -> Any:
        """Energy stored [J] at torsion x [rad]."""
        x1 = self.T1 / self.K1
        x2 = x1 + (self.T2 - self.T1) / self.K2
        # c is the part of abs(x) inside the breakpoint: the integral of clip(x, -b, b) is c abs(x) - c^2/2
        c1 = 0.5 * abs(abs(x + x1) - abs(x - x1))
        c2 = 0.5 * abs(abs(x + x2) - abs(x - x2))
        inner = (self.K1 - self.K2) * (c1 * abs(x) - 0.5 * c1 * c1)
        outer = (self.K2 - self.K3) * (c2 * abs(x) - 0.5 * c2 * c2)
        return 0.5 * self.K3 * x * x + inner + outer

    def breakpoints(self) -> tuple[float, ...]:
        """Torsions [rad] where the slope changes: -x2, -x1, x1, x2."""
        x1 = self.T1 / self.K1
        x2 = x1 + (self.T2 - self.T1) / self.K2
        return (-x2, -x1, x1, x2)

    def check(self) -> None:
        """Refuse slopes that are not positive, and torques out of order (ValueError)."""
        if min(self.K1, self.K2, self.K3) <= 0.0:
            slopes = f"{self.K1:g}, {self.K2:g}, {self.K3:g} N*m/rad"
            raise ValueError(f"PiecewiseLinear has the slopes {slopes}; all must be positive")
        if not 0.0 < self.T1 < self.T2:
            raise ValueError(f"PiecewiseLinear has T1 = {self.T1:g} and T2 = {self.T2:g} N*m; it needs 0 < T1 < T2")


class Backlash(NamedTuple):
    """Play: T = 0 for |x| <= half_gap, K (x - half_gap sign x) outside; odd, C0."""

    K: TorsionalStiffness
    half_gap: Angle

    def torque(self, x: Any) -> Any:
        """Torque T(x) [N*m] at torsion x [rad]."""
        above, below = x - self.half_gap, x + self.half_gap
        return 0.5 * self.K * ((above + abs(above)) + (below - abs(below)))  # exactly 0 inside the gap

    def stiffness(self, x: Any) -> Any:
        """Stiffness dT/dx [N*m/rad] at torsion x [rad]; at the edge of the gap the mean of both sides."""
        b = self.half_gap
        return self.K * (1.0 - 0.5 * (sign(x + b) - sign(x - b)))

    def energy(self, x: Any) -> Any:
        """Energy stored [J] at torsion x [rad]."""
        above, below = x - self.half_gap, x + self.half_gap
        outside = 0.5 * ((above + abs(above)) + (below - abs(below)))
        return 0.5 * self.K * outside * outside

    def breakpoints(self) -> tuple[float, ...]:
        """Torsions [rad] at the edges of the gap."""
        return (-self.half_gap, self.half_gap)

    def check(self) -> None:
        """Refuse a negative gap (ValueError)."""
        if self.half_gap < 0.0:
            raise ValueError(f"Backlash.half_gap is {self.half_gap:g} rad; it must not be negative")
