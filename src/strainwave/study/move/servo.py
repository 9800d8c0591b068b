"""The motor of a move as its drive has it: its torque limited, with anti-windup, and feedforward."""

from typing import Annotated, Any, NamedTuple

import numpy as np

from ...base.choices import larger, select, smaller
from ...base.law import class_of, share, states_of, torque_of, z_rate_of
from ...base.protocols import lacking
from ...base.quantities import Inertia, Ratio, Torque
from ...compile.jit import chosen
from ...drive.asked import Feedforward
from ...model.laws.friction import LuGre, Stribeck, Viscous
from ...model.laws.hysteresis import Parallel
from ...model.train.controls import CascadeLoop, Lagged, core_of, inertia_of, states_inside
from ...model.train.drive_train import DriveTrain
from ...model.train.filters import Filtered, PositionIntegral

SLOW = 1e-3  # times the speed at which surfaces part: dry friction has its sign from there on


class Servo(NamedTuple):
    """A loop whose motor gives a torque of at most `most`, and that is given a share `speed` of its reference's speed.

    The integral of a cascade gives back what the limit took, with its own time constant T_n (back-calculation; Astrom &
    Hagglund, PID Controllers, 2nd ed. 1995, sec. 3.5); that of its position loop waits. `back` is 1/K_p, 0 of another
    loop. The torque beside the loop's counts in the limit.
    """

    loop: Any
    most: Torque
    back: Annotated[float, "rad/(N*m*s)"]
    speed: Ratio = 1.0

    def states(self) -> int:
        """Number of internal states."""
        return states_inside(self)

    def torque(self, x: Any, v: Any, z: Any) -> Any:
        """Torque [N*m] against the deviation that the loop asks for."""
        return torque_of(self.loop, x, v, z)

    def z_rate(self, x: Any, v: Any, z: Any) -> Any:
        """Rates of the internal states without the limit."""
        return z_rate_of(self.loop, x, v, z)

    def driven(self, J: Any, torque: Any, excitation: Any, reference: Any, deviation: Any, z: Any) -> Any:
        """What `controlled` returns."""
        x, v = deviation[0], deviation[1] + (1.0 - self.speed) * reference[0]
        states, heavy = share(self.loop, z), inertia_of(self.loop)
        asked = excitation - torque_of(self.loop, x, v, states)
        asked = asked - heavy * ((torque + asked + heavy * reference[1]) / (J + heavy) - reference[1])
        applied = larger(smaller(asked, self.most), -self.most)
        acceleration = (torque + applied) / J
        rates = unwound(self.loop, z_rate_of(self.loop, x, v, states), (applied - asked) * self.back)
        return acceleration, applied - excitation, (deviation[1], acceleration - reference[1], *rates)


@chosen
def unwound(loop: Any, rates: Any, cut: Any) -> Any:
    """Rates of the states of a loop, from those without a limit and what it took [rad/s]."""
    classes = _classes(loop)
    if CascadeLoop not in classes:
        return _plain
    return _both if PositionIntegral in classes else _speed


def _classes(loop: Any) -> tuple[Any, ...]:
    """Classes of a loop and of the loops inside it, or of what stands for them in the compiler."""
    if class_of(loop) not in (Lagged, Filtered, PositionIntegral):
        return (class_of(loop),)
    return (class_of(loop), *_classes((loop.types if hasattr(loop, "instance_class") else loop)[0]))


def _plain(loop: Any, rates: Any, cut: Any) -> Any:
    return rates


def _speed(loop: Any, rates: Any, cut: Any) -> Any:
    return (*rates[:-1], rates[-1] - cut)


def _both(loop: Any, rates: Any, cut: Any) -> Any:
    return (*rates[:-2], select(cut == 0.0, rates[-2], 0.0), rates[-1] - cut)


class FedTorque(NamedTuple):
    """Torque [N*m] of a motor over the time with what is fed forward of its load, as shares of `Feedforward`.

    `reference` is the motion of the motor, `inertia` that of all shafts on its side, `constant` the torque on the load.
    """

    torques: Any
    reference: Any
    N: Ratio
    inertia: Inertia
    constant: Torque
    motor: Any
    load: Any
    shares: Feedforward

    def torque(self, phase: Any) -> Any:
        """Torque [N*m] at a time [s]."""
        angle, speed = self.reference.value(phase), self.reference.slope(phase)
        still = steady_drag(self.motor, angle, 0.0 * speed), steady_drag(self.load, angle / self.N, 0.0 * speed)
        drags = steady_drag(self.motor, angle, speed), steady_drag(self.load, angle / self.N, speed / self.N)
        gravity = still[0] + (still[1] - self.constant) / self.N
        friction = drags[0] - still[0] + (drags[1] - still[1]) / self.N
        fed = self.shares.gravity * gravity + self.shares.friction * friction
        moved = self.shares.acceleration * self.inertia * self.reference.curvature(phase)
        return self.torques.torque(phase) + moved + fed


@chosen
def steady_drag(law: Any, angle: Any, speed: Any) -> Any:
    """Torque [N*m] of a drag whose internal states are 0."""
    zeros = (0.0,) * states_of(law)

    def without(law: Any, angle: Any, speed: Any) -> Any:
        return torque_of(law, angle, speed, zeros)

    return without


def settled(law: Any) -> Any:
    """A drag as it is at steady speeds: bristles that slip (LuGre) are dry friction beside a viscous one."""
    if isinstance(law, Parallel):
        return Parallel(settled(law.first), settled(law.second))
    if isinstance(law, LuGre):
        return Parallel(Stribeck(law.T_c, law.T_s, law.v_s, SLOW * law.v_s), Viscous(law.sigma_2))
    return law


def servo_train(train: DriveTrain, most: float, holding: float, shares: Feedforward) -> DriveTrain:
    """The train with feedforward and a limit of its motor's torque [N*m], above what holds its load (ValueError)."""
    motor, end = train.motor, train.load.end()
    if motor.held:
        raise ValueError(
            "an ideally held motor takes any torque and needs no feedforward; give the motor a loop, or leave limited "
            "and feedforward out"
        )
    if holding >= most:
        raise ValueError(
            f"at rest the load takes {holding:.4g} N*m of the motor, whose limit is {most:.4g} N*m: it does not "
            "hold its load; take a stronger motor, a larger ratio or less load"
        )
    core, torques = core_of(motor.control), motor.excitation
    encoder = motor.control if hasattr(motor.control, "at_load") else None
    loop = encoder.loop if encoder else motor.control
    control: Any = Servo(loop, most, 1.0 / core.K_p if isinstance(core, CascadeLoop) else 0.0, shares.speed)
    control = encoder._replace(loop=control) if encoder else control
    if any(shares[:3]):
        constant = 0.0 if lacking(end.excitation, "mean") else end.excitation.mean
        torques = FedTorque(
            torques, train.reference, train.N, train.loop_inertia, constant,
            settled(motor.drag), settled(end.drag), shares,
        )  # fmt: skip
    return train._replace(motor=motor._replace(control=control, excitation=torques))


def on_segment(train: DriveTrain, segment: Any) -> DriveTrain:
    """The train with a motion of its reference, and with what is fed forward of it."""
    torques = train.motor.excitation
    if isinstance(torques, FedTorque):
        train = train._replace(motor=train.motor._replace(excitation=torques._replace(reference=segment)))
    return train._replace(reference=segment)


def limited_time(torque: Any, t: Any, most: float) -> float:
    """Time [s] of samples (n,) of the motor's torque [N*m] at the limit."""
    at_limit = np.abs(torque) >= most * (1.0 - 1e-9)
    return float(np.sum(np.diff(t)[at_limit[1:] & at_limit[:-1]]))
