"""Motor of a move with its limits: torque and speed command limited with anti-windup, and feedforward."""

from typing import Annotated, Any, NamedTuple

import numpy as np

from ...base.law import class_of, share, states_of, torque_of, z_rate_of
from ...base.protocols import Law, lacking
from ...base.quantities import LARGEST, AngularSpeed, Inertia, Rate, Ratio, Torque
from ...base.results import Floats
from ...compile.elementwise import larger, select, smaller
from ...compile.jit import chosen
from ...drive.demands.motor_limits import PEAK, MotorLimits
from ...drive.demands.move_task import Feedforward
from ...model.laws.dry import settled
from ...model.train.controls import FREE, CascadeLoop, Lagged, core_of, inertia_of, motor_states, states_inside
from ...model.train.drive_train import DriveTrain, seen_deviation
from ...model.train.filters import Filtered, MixedEncoders, PositionIntegral, apart
from ...model.train.motion import polygon


class Servo(NamedTuple):
    """A loop whose motor gives a torque of at most `most`, and that is given a share `speed` of its reference's speed.

    The limit goes with the motor's speed, of either sign, by the polygon through `torques` at `speeds`. The integral of
    a cascade gives back what the limit took, with its own time constant T_n (back-calculation; Astrom & Hagglund,
    PID Controllers, 2nd ed. 1995, sec. 3.5); that of its position loop waits. `back` is 1/K_p, 0 of another loop. The
    torque beside the loop's counts in the limit.

    The speed that a cascade's speed loop is to keep, share `speed` of the reference's less K_v (x + int x/T_p), stays
    within `fastest`; the integral of its position loop waits then, too. `of_integral` is 1/T_p.

    What is `fed` forward joins the torque that the loop asks for before its filters and lag, a share `behind` of it
    after them.
    """

    loop: Any
    limit: Torque
    back: Annotated[float, "rad/(N*m*s)"]
    speed: Ratio = 1.0
    speeds: tuple[AngularSpeed, ...] = (0.0, 1.0)
    torques: tuple[Torque, ...] = (LARGEST, LARGEST)
    fastest: AngularSpeed = LARGEST
    K_v: Rate = 0.0
    of_integral: Rate = 0.0
    fed: Any = FREE
    behind: Ratio = 0.0

    def states(self) -> int:
        """Number of internal states."""
        return states_inside(self)

    def torque(self, x: Any, v: Any, z: Any) -> Any:
        """Torque [N*m] against the deviation that the loop asks for."""
        return torque_of(self.loop, x, v, (*z, 0.0))

    def z_rate(self, x: Any, v: Any, z: Any) -> Any:
        """Rates of the internal states without the limit."""
        return z_rate_of(self.loop, x, v, (*z, 0.0))

    def command(self, x: Any, z: Any, speed: Any) -> Any:
        """Speed [rad/s] that the position loop asks of the motor, without its limit, at the speed of the reference."""
        return self.speed * speed - self.K_v * with_position_integral(self.loop, x, z, self.of_integral)

    def respond(self, J: Any, torque: Any, excitation: Any, reference: Any, deviation: Any, z: Any) -> Any:
        """Acceleration [rad/s^2], torque [N*m] and rates of the states, as `controlled` returns them.

        `reference` is the speed, the acceleration and the angle of the motor's reference. A loop with an inertia H asks
        for a torque that falls with the acceleration a of the deviation, which follows from the torque itself:
        T = T_0 - H a with J (a + a_ref) = T_others + T. Solved for it, a = (T_others + T_0 + H a_ref)/(J + H) - a_ref.
        """
        speed, reference_acceleration, angle = reference
        x, v = deviation[0], deviation[1] + (1.0 - self.speed) * speed
        states, H = share(self.loop, z), inertia_of(self.loop)
        command = self.command(x, states, speed)
        excess = command - larger(smaller(command, self.fastest), -self.fastest)
        v = v + excess
        fed = self.fed.torque(angle, reference)
        given = (*states, (1.0 - self.behind) * fed)
        asked = excitation + self.behind * fed - torque_of(self.loop, x, v, given)
        asked = asked - H * ((torque + asked + H * reference_acceleration) / (J + H) - reference_acceleration)
        bound = smaller(self.limit, polygon(self.speeds, self.torques, abs(deviation[1] + speed)))
        applied = larger(smaller(asked, bound), -bound)
        acceleration = (torque + applied) / J
        rates = with_limits(self.loop, z_rate_of(self.loop, x, v, given), (applied - asked) * self.back, excess)
        return acceleration, applied - excitation, (deviation[1], acceleration - reference_acceleration, *rates)


@chosen
def with_position_integral(loop: Any, x: Any, z: Any, share: Any) -> Any:
    """Deviation x [rad] plus a share [1/s] of its integral, the last but one of the states z of a loop that has it."""
    return _with_integral if PositionIntegral in _classes(loop) else _without_integral


def _with_integral(loop: Any, x: Any, z: Any, share: Any) -> Any:
    return x + share * z[-2]


def _without_integral(loop: Any, x: Any, z: Any, share: Any) -> Any:
    return x


@chosen
def with_limits(loop: Any, rates: Any, cut: Any, excess: Any) -> Any:
    """Rates of the states of a loop behind its limits, from those without them.

    `cut` and `excess` [rad/s] are what the limit of the torque, over K_p, and that of the speed command took.
    """
    classes = _classes(loop)
    if CascadeLoop not in classes:
        return _as_without_limits
    return _with_both_integrals if PositionIntegral in classes else _with_speed_integral


def _classes(loop: Any) -> tuple[Any, ...]:
    """Classes of a loop and of the loops inside it, or of what stands for them in the compiler."""
    if class_of(loop) not in (Lagged, Filtered, FedLoop, PositionIntegral):
        return (class_of(loop),)
    return (class_of(loop), *_classes((loop.types if hasattr(loop, "instance_class") else loop)[0]))


def _as_without_limits(loop: Any, rates: Any, cut: Any, excess: Any) -> Any:
    return rates


def _with_speed_integral(loop: Any, rates: Any, cut: Any, excess: Any) -> Any:
    return (*rates[:-1], rates[-1] - cut)


def _with_both_integrals(loop: Any, rates: Any, cut: Any, excess: Any) -> Any:
    return (*rates[:-2], select(abs(cut) + abs(excess) == 0.0, rates[-2], 0.0), rates[-1] - cut)


class FedLoop(NamedTuple):
    """A loop with a torque [N*m] fed forward beside its own: the last of the states that it is given, and none of its.

    Filters and lags around it hand their states on, so that the torque goes through them.
    """

    loop: Any

    def states(self) -> int:
        """Number of internal states."""
        return states_inside(self)

    def torque(self, x: Any, v: Any, z: Any) -> Any:
        """Torque [N*m] against the deviation."""
        return torque_of(self.loop, x, v, z[:-1]) - z[-1]

    def z_rate(self, x: Any, v: Any, z: Any) -> Any:
        """Rates of the internal states."""
        return z_rate_of(self.loop, x, v, z[:-1])

    def inertia(self) -> Any:
        """Torque [kg*m^2] against the acceleration of the deviation."""
        return inertia_of(self.loop)


def with_fed_torque(loop: Any) -> Any:
    """A loop that takes a torque fed forward inside its lag and filters."""
    return loop._replace(loop=with_fed_torque(loop.loop)) if isinstance(loop, Lagged | Filtered) else FedLoop(loop)


class FedTorque(NamedTuple):
    """Torque [N*m] that is fed forward of a motor's load along its reference, as shares of `Feedforward`.

    `inertia` is that of all shafts on the side of the motor, `constant` the torque on the load.
    """

    N: Ratio
    inertia: Inertia
    constant: Torque
    motor: Any
    load: Any
    acceleration: Ratio
    gravity: Ratio
    friction: Ratio

    def torque(self, angle: Any, motion: Any) -> Any:
        """Torque [N*m] at an angle [rad] of the motor's reference, its speed [rad/s] and acceleration [rad/s^2]."""
        speed, curvature = motion[0], motion[1]
        still = steady_drag(self.motor, angle, 0.0 * speed), steady_drag(self.load, angle / self.N, 0.0 * speed)
        drags = steady_drag(self.motor, angle, speed), steady_drag(self.load, angle / self.N, speed / self.N)
        gravity = still[0] + (still[1] - self.constant) / self.N
        friction = drags[0] - still[0] + (drags[1] - still[1]) / self.N
        moved = self.acceleration * self.inertia * curvature
        return moved + self.gravity * gravity + self.friction * friction


@chosen
def steady_drag(law: Law, angle: Any, speed: Any) -> Any:
    """Torque [N*m] of a drag whose internal states are 0."""
    zeros = (0.0,) * states_of(law)

    def without(law: Law, angle: Any, speed: Any) -> Any:
        return torque_of(law, angle, speed, zeros)

    return without


def servo_train(train: DriveTrain, limits: MotorLimits, holding: float, shares: Feedforward) -> DriveTrain:
    """The train with feedforward and limits of its motor, whose torque is above what holds its load (ValueError)."""
    motor, end = train.motor, train.load.end()
    if motor.held:
        raise ValueError(
            "an ideally held motor has no torque limit and needs no feedforward; add a motor loop, or remove limited "
            "and feedforward"
        )
    limit = float(limits.at(PEAK, 0.0))
    if holding >= limit:
        raise ValueError(
            f"at rest the load requires {holding:.4g} N*m from the motor, whose limit is {limit:.4g} N*m: the motor "
            "cannot hold the load; use a stronger motor, a larger ratio or less load"
        )
    core = core_of(motor.control)
    encoder = motor.control if hasattr(motor.control, "at_load") else None
    loop = encoder.loop if encoder else motor.control
    control: Any = Servo(with_fed_torque(loop), min(limits.torque, LARGEST), 0.0, shares.speed)
    if limits.peak_torque:
        speeds, curve = zip(*limits.peak_torque, strict=True)
        control = control._replace(speeds=speeds, torques=curve)
    if isinstance(core, CascadeLoop):
        of_integral = 1.0 / apart(loop)[1].get("T_p", np.inf)
        fastest = min(limits.fastest, LARGEST)
        control = control._replace(back=1.0 / core.K_p, fastest=fastest, K_v=core.K_v, of_integral=of_integral)
    if any(shares[:3]):
        constant = 0.0 if lacking(end.excitation, "mean") else end.excitation.mean
        drags = settled(motor.drag), settled(end.drag)
        fed = FedTorque(train.N, train.loop_inertia, constant, *drags, *shares[:3])
        control = control._replace(fed=fed, behind=float(shares.at == "motor"))
    return train.with_motor(control=encoder._replace(loop=control) if encoder else control)


def commanded_speed(train: DriveTrain, t: Floats, y: Any) -> Floats:
    """Speed [rad/s] (n,) that the position loop of a limited cascade asks for, before its limit; 0 of another loop.

    It is that at times t (n,) [s], in states y (states, n) of the train.
    """
    control = train.motor.control
    servo = control.loop if hasattr(control, "at_load") else control
    if not servo.K_v:
        return np.zeros(len(t))
    deviation, states = seen_deviation(control, train, y)[0], share(control, motor_states(control, y)[1])
    if isinstance(control, MixedEncoders):
        deviation, states = states[0], states[1:]
    return np.asarray(servo.command(deviation, states, train.omega * train.reference.slope(t)))


def limited_time(values: Floats, t: Floats, most: Any) -> float:
    """Time [s] for which a torque or a speed (n,), at times t (n,) [s], is at its largest value."""
    at_limit = np.abs(values) >= most * (1.0 - 1e-9)
    return float(np.sum(np.diff(t)[at_limit[1:] & at_limit[:-1]]))
