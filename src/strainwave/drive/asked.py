"""What is asked of a drive beside its speeds: the limits of its motor, a move, what the load carries."""

import math
from numbers import Real
from typing import Annotated, Any, NamedTuple

from ..base.quantities import Angle, AngularSpeed, Inertia, Ratio, Torque, checked, number
from ..base.units import RPM
from ..model.gears.limits import Finding
from ..model.laws.hysteresis import Parallel
from ..model.train.drive_train import DriveTrain
from ..model.train.motion import AngleTorque
from ..model.train.shafts import NO_DRAG

Mass = Annotated[float, "kg"]
Length = Annotated[float, "m"]

Acceleration = Annotated[float, "m/s**2"]


WEIGHT = 9.80665  # m/s^2, standard gravity


STRONGER, SLOWER = "take a stronger motor, another ratio or less load", "drive slower, or take a smaller ratio"


class MotorLimits(NamedTuple):
    """Largest torque [N*m] and speed [rad/s] of a motor; infinite where nothing is known."""

    torque: Torque = math.inf
    speed: AngularSpeed = math.inf

    def check(self) -> None:
        """Refuse limits that are not positive (ValueError)."""
        for name in self._fields:
            if not (isinstance(getattr(self, name), Real) and getattr(self, name) == math.inf):
                number(f"MotorLimits.{name}", getattr(self, name), positive=True)


def motor_findings(
    limits: MotorLimits, torque: float | None, speed: float | None, holding: float = 0.0,
    remedies: tuple[str, str] = (STRONGER, SLOWER),
) -> tuple[Finding, ...]:  # fmt: skip
    """Compare a motor's largest torque [N*m] and speed [rad/s] with its limits, where both are known.

    `holding` is the part of the torque that loads and friction take at steady speed, `remedies` what helps beyond.
    """
    findings = []
    rpm = None if speed is None else speed / RPM
    parts = (("torque", torque, limits.torque, "N*m"), ("speed", rpm, limits.speed / RPM, "rpm"))
    for (name, value, bound, unit), remedy in zip(parts, remedies, strict=True):
        if value is None or not math.isfinite(bound):
            continue
        beyond = Finding(f"motor {name}", value, bound, unit, "").exceeded
        end = f"within its limit of {bound:.4g} {unit}"
        if beyond:
            steady = name == "torque" and holding > bound
            alone = f" (loads and friction alone take {holding:.4g} N*m)" if steady else ""
            end = f"above its limit of {bound:.4g} {unit}{alone}; {remedy}"
        sentence = f"The {name} of the motor reaches {value:.4g} {unit}, {end}."
        findings.append(Finding(f"motor {name}", value, bound, unit, sentence))
    return tuple(findings)


class Payload(NamedTuple):
    """A mass at a radius from the axis of the load, with an inertia about its own centre.

    It adds mass radius^2 + inertia to the load's inertia and the torque mass gravity radius sin(angle + phase) against
    its motion, with the angle of the load: phase 0 is a mass that hangs down where this angle is 0, 90 degrees one that
    is level there. A vertical axis has gravity 0, an inclined one its part across the axis.
    """

    mass: Mass
    radius: Length
    inertia: Inertia = 0.0
    phase: Angle = 0.0
    gravity: Acceleration = WEIGHT

    def on(self, train: DriveTrain) -> DriveTrain:
        """The train with this payload on its load."""
        checked(self)
        end = train.load.end()
        pull = self.mass * self.gravity * self.radius
        drag = end.drag
        if pull:
            law = AngleTorque(pull, 1, self.phase)
            drag = law if drag == NO_DRAG and type(drag) is type(NO_DRAG) else Parallel(law, drag)
        end = end._replace(J=end.J + self.mass * self.radius * self.radius + self.inertia, drag=drag)
        loaded: DriveTrain = checked(train._replace(load=train.load.with_end(end)))
        return loaded

    def check(self) -> None:
        """Refuse a negative mass, radius, inertia or gravity (ValueError)."""
        for name in ("mass", "radius", "inertia", "gravity"):
            if not getattr(self, name) >= 0.0:
                raise ValueError(f"Payload.{name} is {getattr(self, name):g}; it must be zero or more")


class Feedforward(NamedTuple):
    """What the motor of a move is given before a deviation asks for it, as shares of what its model needs: 1 is exact.

    `acceleration` is the torque of all inertias, rigid; `gravity` that which a constant torque and the angles of the
    shafts take at rest; `friction` what their drags add at the speed of the reference, of a law with memory the part
    that depends on the speed alone; `speed` is the share of the reference's speed in that which the speed loop follows.
    """

    acceleration: Ratio = 0.0
    gravity: Ratio = 0.0
    friction: Ratio = 0.0
    speed: Ratio = 1.0

    def check(self) -> None:
        """Refuse negative shares (ValueError)."""
        for name, value in zip(self._fields, self, strict=True):
            if not value >= 0.0:
                raise ValueError(f"Feedforward.{name} is {value:g}; it must be zero or more, 1 is exact")


class Task(NamedTuple):
    """What a project file asks of a move: parts of the profile, angle at the begin [rad], payload, window [rad].

    `files` has for every part the name of its file, empty where it is in the project file itself; `feedforward` is what
    the motor is given beside its loop.
    """

    profile: tuple[Any, ...] = ()
    start: float | None = None
    payload: Payload | None = None
    window: float | None = None
    files: tuple[str, ...] = ()
    feedforward: Feedforward | None = None
