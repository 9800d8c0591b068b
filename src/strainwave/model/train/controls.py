"""What keeps the motor on its reference motion: a law of the motor's deviation from there, which it opposes.

A control has the methods of a law, `torque(x, v)` or, with states of its own, `torque(x, v, z)` with `z_rate(x, v, z)`
and `states`: x [rad] and v [rad/s] are the deviations of the motor's angle and speed from its reference, the torque
[N*m] counts against them. It may have `inertia()` [kg*m^2], which counts against the deviation of the acceleration.
`Held` alone has none of these: it prescribes the motion.
"""

from typing import Any, NamedTuple

from ...compile.jit import chosen
from ...law import class_of, depends, has, share, torque_of, z_rate_of
from ...protocols import lacking
from ...quantities import Damping, Inertia, Time, TorsionalStiffness, shown


class Free(NamedTuple):
    """No control: the motor is driven by its torque alone."""

    def torque(self, x: Any, v: Any) -> Any:
        """Torque [N*m]: 0."""
        return 0.0


FREE = Free()


class Held(NamedTuple):
    """An ideal speed loop: the motor follows its reference motion whatever torque that takes."""


class Commanded(NamedTuple):
    """A torque from outside: it is the internal state z [N*m] itself, which a sampled controller overwrites.

    Between two samples it stays as it is.
    """

    def states(self) -> int:
        """Number of internal states."""
        return 1

    def torque(self, x: Any, v: Any, z: Any) -> Any:
        """Torque [N*m] against the deviation: the commanded torque pushes along the motion."""
        return -z[0]

    def z_rate(self, x: Any, v: Any, z: Any) -> Any:
        """Rate of the held torque: 0."""
        return (0.0 * z[0],)


COMMANDED = Commanded()


class PositionLoop(NamedTuple):
    """PD position loop on the motor: torque -K_p (theta_m - reference) - K_d (theta_m' - reference').

    It acts where it measures: with gains that are not negative it puts in no energy and cannot make the train unstable.
    """

    K_p: TorsionalStiffness
    K_d: Damping

    def torque(self, x: Any, v: Any) -> Any:
        """Torque [N*m] against the deviation x [rad] and its rate v [rad/s]."""
        return self.K_p * x + self.K_d * v

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

    def torque(self, x: Any, v: Any) -> Any:
        """Torque [N*m] against the deviation x [rad] and its rate v [rad/s]."""
        return self.K_i * x + self.K_p * v

    def inertia(self) -> Any:
        """Torque against the acceleration of the deviation [kg*m^2]."""
        return self.K_d

    def check(self) -> None:
        """Refuse gains with which the loop drives away from its reference (ValueError)."""
        _gains_not_negative(self)


class Lagged(NamedTuple):
    """A loop whose torque follows with the first-order lag of its current loop: lag T' + T = torque of the loop.

    `loop` is a `PositionLoop` or a `SpeedLoop`. The one state z [N*m] is T less the part K_d v/lag that answers an
    acceleration at once, so that none is differentiated: T = z + K_d v/lag, z' = (K_i x + K_p v - T)/lag. Unlike
    its `loop` alone it can make a train unstable.
    """

    loop: Any
    lag: Time

    def states(self) -> int:
        """Number of internal states."""
        return 1

    def torque(self, x: Any, v: Any, z: Any) -> Any:
        """Torque [N*m] against the deviation, of its rate v [rad/s] and z = (z,) [N*m]."""
        return z[0] + inertia_of(self.loop) / self.lag * v

    def z_rate(self, x: Any, v: Any, z: Any) -> Any:
        """Rate (z',) [N*m/s] of the internal state."""
        return ((self.loop.torque(x, v) - self.torque(x, v, z)) / self.lag,)

    def check(self) -> None:
        """Refuse a lag that is not positive (ValueError) and a loop of another kind (TypeError)."""
        if not self.lag > 0.0:
            raise ValueError(f"Lagged.lag is {self.lag:g} s; it must be positive, without a lag give the loop itself")
        if lacking(self.loop, "torque") or depends(self.loop) != 2:
            raise TypeError(f"Lagged.loop is {shown(self.loop)}; it must be a PositionLoop or a SpeedLoop")


class Nudged(NamedTuple):
    """A free motor with a loop far too weak to matter, by which the stability of its mean speed is judged."""

    K_p: Damping
    K_i: TorsionalStiffness

    def torque(self, x: Any, v: Any) -> Any:
        """Torque [N*m] against the deviation x [rad] and its rate v [rad/s]."""
        return self.K_i * x + self.K_p * v


def _gains_not_negative(control: Any) -> None:
    name = type(control).__name__
    for gain, value in zip(control._fields, control, strict=True):
        if not value >= 0.0:
            raise ValueError(
                f"{name}.{gain} is {value:g}; with a negative gain the loop pushes the motor away from its reference: "
                "give its size, the loop has the minus sign"
            )


@chosen
def motor_states(control: Any, y: Any) -> Any:
    """Deviation (angle [rad], speed [rad/s]) of the motor from its reference, and the states of the train after it."""
    return _without_motor if class_of(control) is Held else _with_motor


def _without_motor(control: Any, y: Any) -> Any:
    return (0.0 * y[0], 0.0 * y[0]), y[2:]


def _with_motor(control: Any, y: Any) -> Any:
    return (y[2], y[3]), y[4:]


@chosen
def off_reference(control: Any, y: Any) -> Any:
    """Deviation (angle [rad], speed [rad/s]) of the motor as the load points wrong by it: none without a reference."""
    return _with_none if class_of(control) in (Held, Free, Nudged) else _with_all


def _with_none(control: Any, y: Any) -> Any:
    return 0.0 * y[0], 0.0 * y[1]


def _with_all(control: Any, y: Any) -> Any:
    return motor_states(control, y)[0]


@chosen
def controlled(control: Any, J: Any, torque: Any, reference: Any, deviation: Any, z: Any) -> Any:
    """Acceleration [rad/s^2] of a motor under its control and another torque, torque [N*m] of the control, own rates.

    `reference` is the acceleration of its reference; z begins with the states of the control.
    """
    return _prescribed if class_of(control) is Held else _driven


def _prescribed(control: Any, J: Any, torque: Any, reference: Any, deviation: Any, z: Any) -> Any:
    return reference, J * reference - torque, ()


def _driven(control: Any, J: Any, torque: Any, reference: Any, deviation: Any, z: Any) -> Any:
    x, v = deviation
    own, heavy = share(control, z), inertia_of(control)
    against = torque_of(control, x, v, own)
    acceleration = (torque - against + heavy * reference) / (J + heavy)
    relative = acceleration - reference
    return acceleration, -against - heavy * relative, (v, relative, *z_rate_of(control, x, v, own))


@chosen
def inertia_of(control: Any) -> Any:
    """Torque [kg*m^2] of a control against the acceleration of the deviation; 0 of one that does not say."""
    return _own_inertia if has(control, "inertia") else _no_inertia


def _own_inertia(control: Any) -> Any:
    return control.inertia()


def _no_inertia(control: Any) -> Any:
    return 0.0
