"""The vendors' law of three slopes with its corners rounded: C1, so that it has no breakpoints."""

from typing import Any, NamedTuple

from ...base.quantities import Angle, Reals, Torque, TorsionalStiffness
from ...compile.jit import kernel

ROUNDED = 0.25  # of the widest corners that do not meet: sizes within 0.5 % of an integration with true corners


@kernel
def corners(law: Any) -> Any:
    """Torsions x1 and x2 [rad] at which the slope of a law of three slopes changes."""
    x1 = law.T1 / law.K1
    return x1, x1 + (law.T2 - law.T1) / law.K2


def widest(law: Any) -> float:
    """Largest width [rad] over which the corners of a law of three slopes are rounded and do not meet."""
    return float(min(2.0 * law.T1 / law.K1, (law.T2 - law.T1) / law.K2))


def check_slopes(law: Any) -> None:
    """Refuse slopes that are not positive, and torques out of order (ValueError)."""
    if min(law.K1, law.K2, law.K3) <= 0.0:
        slopes = f"{law.K1:g}, {law.K2:g}, {law.K3:g} N*m/rad"
        raise ValueError(f"PiecewiseLinear has the slopes {slopes}; all must be positive")
    if not 0.0 < law.T1 < law.T2:
        raise ValueError(f"PiecewiseLinear has T1 = {law.T1:g} and T2 = {law.T2:g} N*m; it needs 0 < T1 < T2")


@kernel
def clipped(s: Any, w: Any) -> Any:
    """Clip s to -w .. w."""
    return 0.5 * (abs(s + w) - abs(s - w))


@kernel
def rounded(s: Reals, w: Reals) -> Any:
    """Return abs(s) outside -w .. w, and inside it the parabola w/2 + s^2/(2 w) that joins it smoothly."""
    c = clipped(s, w)
    return abs(s - c) + 0.5 * (w + c * c / w)


@kernel
def area(s: Any, w: Reals) -> Any:
    """Integral of `rounded` from 0 to s, odd in s."""
    c = clipped(s, w)
    return 0.5 * ((s - c) * (abs(s) + w) + c * (w + c * c / (3.0 * w)))


class RoundedPiecewiseLinear(NamedTuple):
    """`PiecewiseLinear` with its corners rounded over a `width` [rad] of torsion: odd, C1.

    Within width/2 of a corner the torque is a parabola and the stiffness runs linearly from one slope to the next;
    outside it is the vendors' straight line itself. Requires, besides what `PiecewiseLinear` requires, that the rounded
    corners neither meet each other nor reach zero: width <= 2 x1 and width <= x2 - x1.
    """

    K1: TorsionalStiffness
    K2: TorsionalStiffness
    K3: TorsionalStiffness
    T1: Torque
    T2: Torque
    width: Angle

    def torque(self, x: Reals) -> Any:
        """Torque T(x) [N*m] at torsion x [rad]."""
        w, (x1, x2) = 0.5 * self.width, corners(self)
        inner = 0.5 * (self.K1 - self.K2) * (rounded(x + x1, w) - rounded(x - x1, w))
        outer = 0.5 * (self.K2 - self.K3) * (rounded(x + x2, w) - rounded(x - x2, w))
        return self.K3 * x + inner + outer

    def stiffness(self, x: Reals) -> Any:
        """Stiffness dT/dx [N*m/rad] at torsion x [rad]; continuous."""
        w, (x1, x2) = 0.5 * self.width, corners(self)
        inner = 0.5 * (self.K1 - self.K2) * (clipped(x + x1, w) - clipped(x - x1, w)) / w
        outer = 0.5 * (self.K2 - self.K3) * (clipped(x + x2, w) - clipped(x - x2, w)) / w
        return self.K3 + inner + outer

    def energy(self, x: Any) -> Any:
        """Energy stored [J] at torsion x [rad]."""
        w, (x1, x2) = 0.5 * self.width, corners(self)
        inner = 0.5 * (self.K1 - self.K2) * (area(x + x1, w) - area(x - x1, w) - 2.0 * area(x1, w))
        outer = 0.5 * (self.K2 - self.K3) * (area(x + x2, w) - area(x - x2, w) - 2.0 * area(x2, w))
        return 0.5 * self.K3 * x * x + inner + outer

    def breakpoints(self) -> tuple[float, ...]:
        """No breakpoints: the slope is continuous."""
        return ()

    def turning_points(self) -> tuple[float, ...]:
        """None: the torque rises."""
        return ()

    def rounded(self) -> "RoundedPiecewiseLinear":
        """The law itself: its corners are rounded."""
        return self

    def check(self) -> None:
        """Refuse what `PiecewiseLinear` refuses, and transitions that meet (ValueError)."""
        check_slopes(self)
        if not 0.0 < self.width <= widest(self) * (1.0 + 1e-12):
            raise ValueError(
                f"RoundedPiecewiseLinear.width is {self.width:g} rad; it must be positive and at most "
                f"{widest(self):.6g} rad, where the rounded corners meet"
            )
