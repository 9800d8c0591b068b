"""Motions and torques that are prescribed in time, and the torque that depends on a shaft's own angle.

A reference motion has `value` (angle [rad]), `slope` and `curvature`, its derivatives by the base angle: with a base
speed omega the shaft turns at omega slope. The profiles are polygons through a few points, constant before the first
and after the last; they are meant for runs with omega = 1, where the base angle is the time in seconds.
"""

from itertools import pairwise
from typing import Any, NamedTuple

from ...base.quantities import Angle, AngularAcceleration, AngularJerk, AngularSpeed, Reals, States, Time, Torque
from ...compile.jit import kernel
from ...compile.maths import cos, sign, sin
from ..excitation import HIGHEST

MOST_POINTS = 16  # points of a profile: every one costs arithmetic in every step


@kernel
def clipped(s: Any, width: Any) -> Any:
    """Return s, but 0 below 0 and `width` above it; without branches."""
    return 0.5 * (abs(s) - abs(s - width) + width)


def _check_polygon(name: str, times: tuple[float, ...], values: tuple[float, ...]) -> None:
    if not 2 <= len(times) <= MOST_POINTS or len(times) != len(values):
        raise ValueError(
            f"{name} has {len(times)} times and {len(values)} values; it needs from 2 to {MOST_POINTS} of both, "
            "equally many"
        )
    if not all(a < b for a, b in pairwise(times)):
        raise ValueError(f"{name}.times are {', '.join(f'{t:g}' for t in times)} s; they must increase")


class Steady(NamedTuple):
    """The shaft turns with the base angle: at the constant speed omega."""

    def value(self, phase: Reals) -> Any:
        """Angle [rad] at the base angle [rad]."""
        return 1.0 * phase

    def slope(self, phase: Reals) -> Any:
        """Derivative of the angle by the base angle: 1."""
        return 1.0 + 0.0 * phase

    def curvature(self, phase: Reals) -> Any:
        """Second derivative: 0."""
        return 0.0 * phase


class AtRest(NamedTuple):
    """The shaft stands at angle 0: the reference of motors that start from rest under their torque."""

    def value(self, phase: Reals) -> Any:
        """Angle [rad]: 0."""
        return 0.0 * phase

    def slope(self, phase: Reals) -> Any:
        """Derivative of the angle by the base angle: 0."""
        return 0.0 * phase

    def curvature(self, phase: Reals) -> Any:
        """Second derivative: 0."""
        return 0.0 * phase


STEADY = Steady()


class SpeedProfile(NamedTuple):
    """A run-up, a stop or a cycle of both: speed [rad/s] through points in time, straight between them.

    The angle is 0 at time 0; before the first point the speed is the first, after the last the last. Angle C1,
    acceleration piecewise constant.
    """

    times: tuple[Time, ...]
    speeds: tuple[AngularSpeed, ...]

    def value(self, phase: Any) -> Any:
        """Angle [rad] at a time [s]."""
        angle = self.speeds[0] * phase
        for i in range(len(self.times) - 1):
            width = self.times[i + 1] - self.times[i]
            inside = clipped(phase - self.times[i], width)
            after = 0.5 * (phase - self.times[i + 1] + abs(phase - self.times[i + 1]))
            rate = (self.speeds[i + 1] - self.speeds[i]) / width
            angle = angle + rate * (0.5 * inside * inside + width * after)
        return angle

    def slope(self, phase: Reals) -> Any:
        """Speed [rad/s] at a time [s]."""
        return polygon(self.times, self.speeds, phase)

    def curvature(self, phase: Reals) -> Any:
        """Acceleration [rad/s^2] at a time [s]."""
        total = 0.0 * phase
        for i in range(len(self.times) - 1):
            rate = (self.speeds[i + 1] - self.speeds[i]) / (self.times[i + 1] - self.times[i])
            total = total + 0.5 * rate * (sign(phase - self.times[i]) - sign(phase - self.times[i + 1]))
        return total

    def corners(self) -> tuple[float, ...]:
        """Times [s] at which the acceleration jumps."""
        return self.times

    def check(self) -> None:
        """Refuse times that do not increase or do not fit the speeds (ValueError)."""
        _check_polygon("SpeedProfile", self.times, self.speeds)


class Segment(NamedTuple):
    """One segment of a motion with constant jerk: angle, speed and acceleration at its begin, and the jerk.

    It goes on before and after; a motion of many segments is integrated one after the other. Analytic.
    """

    begin: Time
    angle: Angle
    speed: AngularSpeed
    acceleration: AngularAcceleration
    jerk: AngularJerk

    def value(self, phase: Reals) -> Any:
        """Angle [rad] at a time [s]."""
        s = phase - self.begin
        return self.angle + s * (self.speed + s * (0.5 * self.acceleration + s * (self.jerk * (1.0 / 6.0))))

    def slope(self, phase: Reals) -> Any:
        """Speed [rad/s] at a time [s]."""
        s = phase - self.begin
        return self.speed + s * (self.acceleration + s * (0.5 * self.jerk))

    def curvature(self, phase: Reals) -> Any:
        """Acceleration [rad/s^2] at a time [s]."""
        return self.acceleration + (phase - self.begin) * self.jerk


@kernel
def polygon(times: States, values: States, t: Reals) -> Any:
    """Value at t of the polygon through points, constant before the first and after the last."""
    total = values[0] + 0.0 * t
    for i in range(len(times) - 1):
        width = times[i + 1] - times[i]
        total = total + (values[i + 1] - values[i]) / width * clipped(t - times[i], width)
    return total


class TorqueProfile(NamedTuple):
    """Torque [N*m] through points in time, straight between them: a start, a stop, a load that comes on. C0."""

    times: tuple[Time, ...]
    torques: tuple[Torque, ...]

    def torque(self, angle: Reals) -> Any:
        """Torque [N*m] at a time [s]."""
        return polygon(self.times, self.torques, angle)

    def corners(self) -> tuple[float, ...]:
        """Times [s] at which the slope of the torque jumps."""
        return self.times

    def check(self) -> None:
        """Refuse times that do not increase or do not fit the torques (ValueError)."""
        _check_polygon("TorqueProfile", self.times, self.torques)


class AngleTorque(NamedTuple):
    """Torque T = amplitude sin(order x + phase) that opposes a shaft at its own angle x.

    Gravity on an off-centre load or an imbalance on a horizontal axis: amplitude = m g r, order 1; cogging of a motor:
    order = number of detents a turn. It stores energy and loses none. Analytic; odd for phase 0.
    """

    amplitude: Torque
    order: int = 1
    phase: Angle = 0.0

    def torque(self, x: Reals) -> Any:
        """Torque [N*m] at the angle x [rad]."""
        return self.amplitude * sin(self.order * x + self.phase)

    def stiffness(self, x: Reals) -> Any:
        """Slope dT/dx [N*m/rad] at the angle x [rad]; negative where the torque pushes away."""
        return self.amplitude * self.order * cos(self.order * x + self.phase)

    def energy(self, x: Any) -> Any:
        """Energy stored [J] at the angle x [rad], 0 at x = 0."""
        return self.amplitude / self.order * (cos(self.phase) - cos(self.order * x + self.phase))

    def breakpoints(self) -> tuple[float, ...]:
        """No breakpoints: the law is smooth."""
        return ()

    def check(self) -> None:
        """Refuse an order below 1 or above 10000 (ValueError)."""
        if not 1 <= self.order <= HIGHEST:
            raise ValueError(f"AngleTorque.order is {self.order}; it must be from 1 to {HIGHEST}")
