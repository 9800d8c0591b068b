"""Lines of any order beside a kinematic error, in the form that many variants run side by side."""

from typing import Any, NamedTuple

from ...maths import cos, sin
from ...quantities import Angle, Ratio


class OrderLine(NamedTuple):
    """A line of any order, cosine cos(order angle) + sine sin(order angle)."""

    order: Ratio
    cosine: Angle
    sine: Angle


class MoreLines(NamedTuple):
    """A kinematic error with lines of any order beside its own."""

    error: Any
    lines: tuple[OrderLine, ...]

    def value(self, angle: Any) -> Any:
        """Error [rad] at the base angle [rad]."""
        total = self.error.value(angle)
        for i in range(len(self.lines)):
            line = self.lines[i]
            total = total + line.cosine * cos(line.order * angle) + line.sine * sin(line.order * angle)
        return total

    def slope(self, angle: Any) -> Any:
        """Derivative de/dangle [rad/rad] at the base angle [rad]."""
        total = self.error.slope(angle)
        for i in range(len(self.lines)):
            line = self.lines[i]
            a = line.order * angle
            total = total + line.order * (line.sine * cos(a) - line.cosine * sin(a))
        return total

    def curvature(self, angle: Any) -> Any:
        """Second derivative of e [rad/rad^2] at the base angle [rad]."""
        total = self.error.curvature(angle)
        for i in range(len(self.lines)):
            line = self.lines[i]
            a = line.order * angle
            total = total - line.order * line.order * (line.cosine * cos(a) + line.sine * sin(a))
        return total
