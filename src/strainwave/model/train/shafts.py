"""Both ends of a drive train: the motor with its control, and the load, on its own or behind a coupling.

What opposes a shaft is a law of that shaft's angle and speed, of any kind: friction (`Coulomb`, `LuGre`, ...), gravity
(`AngleTorque`), both (`Parallel`). Angles in rad, torques in N*m, each of its own shaft.
"""

from typing import Any, NamedTuple

from ...law import check_law
from ...quantities import LARGEST, Damping, Inertia, TorsionalStiffness, shown
from ..excitation import Harmonic
from ..laws.springs import Linear

NO_TORQUE, NO_DRAG = Harmonic(0.0), Linear(0.0)


class Free(NamedTuple):
    """No control: the motor is driven by its torque alone."""


FREE = Free()


class Held(NamedTuple):
    """An ideal speed loop: the motor follows its reference motion whatever torque that takes."""


class PositionLoop(NamedTuple):
    """PD position loop on the motor: torque -K_p (theta_m - reference) - K_d (theta_m' - reference').

    It acts where it measures: with gains that are not negative it puts in no energy and cannot make the train unstable.
    """

    K_p: TorsionalStiffness
    K_d: Damping

    def check(self) -> None:
        """Refuse gains with which the loop drives away from its reference (ValueError)."""
        _gains_not_negative(self)


class SpeedLoop(NamedTuple):
    """PID speed loop on the motor, with the speed error w = theta_m' - reference': torque -K_p w - K_i int w - K_d w'.

    K_d [kg m^2] acts as inertia. With K_i the integral is the angle theta_m - reference of the state.
    """

    K_p: Damping
    K_i: TorsionalStiffness = 0.0
    K_d: Inertia = 0.0

    def check(self) -> None:
        """Refuse gains with which the loop drives away from its reference (ValueError)."""
        _gains_not_negative(self)


def _gains_not_negative(control: Any) -> None:
    name = type(control).__name__
    for gain, value in zip(control._fields, control, strict=True):
        if not value >= 0.0:
            raise ValueError(
                f"{name}.{gain} is {value:g}; with a negative gain the loop pushes the motor away from its reference: "
                "give its size, the loop has the minus sign"
            )


class Motor(NamedTuple):
    """Motor and wave generator: inertia J, torque `excitation`(base angle), `drag`(angle, speed), and `control`."""

    J: Inertia
    excitation: Any = NO_TORQUE
    drag: Any = NO_DRAG
    control: Any = FREE

    def check(self) -> None:
        """Refuse an inertia that is not positive (ValueError) and parts of another kind (TypeError)."""
        _check_shaft(self)
        if not isinstance(self.control, CONTROLS):
            raise TypeError(
                f"Motor.control is {shown(self.control)}; it must be Free(), Held(), a SpeedLoop or a PositionLoop"
            )


class Load(NamedTuple):
    """Load: inertia J, torque `excitation` (of the base angle) along the motion, `drag` (of angle and speed)."""

    J: Inertia
    excitation: Any = NO_TORQUE
    drag: Any = NO_DRAG

    def check(self) -> None:
        """Refuse an inertia that is not positive (ValueError) and parts of another kind (TypeError)."""
        _check_shaft(self)


class Elastic(NamedTuple):
    """Load behind a coupling or an elastic structure: on the gear sits the inertia J, then a law and a damping B.

    `load` is a `Load`, or again an `Elastic` for two couplings in series. The coupling's torque is a law of its own
    twist (angle before it - angle behind it), of any kind.
    """

    J: Inertia
    B: Damping
    law: Any
    load: Any

    def check(self) -> None:
        """Refuse an inertia that is not positive (ValueError) and parts of another kind (TypeError)."""
        _positive_inertia(self)
        refuse_driving(self)
        if not hasattr(self.law, "torque"):
            raise TypeError(f"Elastic.law is {shown(self.law)}; it must be an object with a method torque")
        check_law("Elastic.law", self.law)
        if not isinstance(self.load, Load | Elastic):
            raise TypeError(f"Elastic.load is {shown(self.load)}; it must be a Load or an Elastic")


CONTROLS = (Free, Held, PositionLoop, SpeedLoop)


def refuse_driving(part: Any) -> None:
    """Refuse a damping B that would put energy in (ValueError)."""
    if not part.B >= 0.0:
        raise ValueError(
            f"{type(part).__name__}.B is {part.B:g} N*m*s/rad; a damping must not be negative, it would drive the train"
        )


def _positive_inertia(shaft: Any) -> None:
    if not shaft.J >= 1.0 / LARGEST:
        name = type(shaft).__name__
        raise ValueError(f"{name}.J is {shaft.J:g} kg*m**2; an inertia must be positive, {1 / LARGEST:g} up")


def _check_shaft(shaft: Any) -> None:
    _positive_inertia(shaft)
    name = type(shaft).__name__
    for field in ("excitation", "drag"):
        if not hasattr(getattr(shaft, field), "torque"):
            raise TypeError(f"{name}.{field} is {shown(getattr(shaft, field))}; it must be an object with a torque")
    check_law(f"{name}.drag", shaft.drag)


def end_of(load: Any) -> Any:
    """The load itself, behind all couplings."""
    return end_of(load.load) if isinstance(load, Elastic) else load
