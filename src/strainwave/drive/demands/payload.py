"""Payload of a load: a mass at a radius, with its inertia and its weight."""

from typing import Annotated, NamedTuple

from ...base.quantities import Angle, Inertia, checked
from ...model.laws.hysteresis import Parallel
from ...model.train.drive_train import DriveTrain
from ...model.train.motion import AngleTorque
from ...model.train.shafts import NO_DRAG

Mass = Annotated[float, "kg"]
Length = Annotated[float, "m"]
Acceleration = Annotated[float, "m/s**2"]
WEIGHT = 9.80665  # m/s^2, standard gravity


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
        mass, radius, inertia, phase, gravity = checked(self)
        end = train.load.end()
        pull, J, drag = mass * gravity * radius, end.J + mass * radius * radius + inertia, end.drag
        if pull:
            law = AngleTorque(pull, 1, phase)
            drag = law if drag == NO_DRAG and type(drag) is type(NO_DRAG) else Parallel(law, drag)
        loaded: DriveTrain = checked(train.with_load(J=J, drag=drag))
        return loaded

    def check(self) -> None:
        """Refuse a negative mass, radius, inertia or gravity (ValueError)."""
        for name in ("mass", "radius", "inertia", "gravity"):
            if not getattr(self, name) >= 0.0:
                raise ValueError(f"Payload.{name} is {getattr(self, name):g}; it must be zero or more")
