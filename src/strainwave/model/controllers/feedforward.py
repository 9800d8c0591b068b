"""Known errors are taken away before they appear: at the angle, at the torque, or by the whole inverse.

A torque table over angle and speed cancels an error whose amplitude and phase change with the speed.
"""

from itertools import pairwise
from typing import Any, NamedTuple

from ...base.law import states_of, torque_of
from ...base.protocols import need
from ...base.quantities import AngularSpeed, Inertia, Ratio, Reals, States, Time, Torque
from ...compile.jit import kernel
from ...compile.maths import cos, sin
from ..train.motion import MOST_POINTS, polygon
from .loops import Measurement, moved

ROUNDS = 4  # of the fixed point theta_m = N (theta_l + u + e(theta_m)): it contracts by N e', below 1e-2


class AngleFeedforward(NamedTuple):
    """The motor is to follow N (theta_ref + e): the rigid gear then turns its output as it should.

    `error` is e [rad, output side] as a function of the motor's angle, here of its reference. With the inertia `J` of
    the motor, the torque that moves it along e is added, taken `lead` seconds ahead: with a loop that has no other
    error, this is the linear inverse of the drive. The load then feels no torque, whatever the gear's stiffness is.
    """

    loop: Any
    error: Any
    N: Ratio
    lead: Time = 0.0
    J: Inertia = 0.0

    def start(self) -> Any:
        """Memory before the first sample."""
        return self.loop.start()

    def update(self, state: States, m: Measurement) -> Any:
        """Memory after a sample, and the torque [N*m]."""
        now, ahead = m.reference, m.reference + self.lead * m.speed
        shift = self.N * self.error.value(now)
        rate = self.N * self.error.slope(now) * m.speed
        acceleration = self.N * (
            self.error.curvature(ahead) * m.speed * m.speed + self.error.slope(ahead) * m.acceleration
        )
        state, torque = self.loop.update(state, moved(m, shift, rate, 0.0))
        return state, torque + self.J * acceleration

    def check(self) -> None:
        """Refuse a loop or an error that is none (TypeError)."""
        need("AngleFeedforward.loop", self.loop, "start", "update(state, measurement)")
        need("AngleFeedforward.error", self.error, "value(angle)", "slope(angle)", "curvature(angle)")


class TorqueTable(NamedTuple):
    """A torque [N*m] over the motor's angle is added to that of `loop`: lines by order, at the reference's angle.

    `table` is a `Harmonic` or `Harmonics`; it is taken `lead` seconds ahead. One that was found by a plant's phase in
    forward motion is wrong backward, by twice that phase. Its orders count on the turn of a shaft that makes `turns` in
    one of the motor: 1/N is the output, on whose turn a line (j, k) of both turns has the order j N + k.
    """

    loop: Any
    table: Any
    lead: Time = 0.0
    turns: Ratio = 1.0

    def start(self) -> Any:
        """Memory before the first sample."""
        return self.loop.start()

    def update(self, state: States, m: Measurement) -> Any:
        """Memory after a sample, and the torque [N*m]."""
        state, torque = self.loop.update(state, m)
        return state, torque + self.table.torque(self.turns * (m.reference + self.lead * m.speed))

    def check(self) -> None:
        """Refuse a loop or a torque that is none (TypeError)."""
        need("TorqueTable.loop", self.loop, "start", "update(state, measurement)")
        need("TorqueTable.table", self.table, "torque(angle)")


class InverseDynamics(NamedTuple):
    """The nonlinear inverse of a drive train: the motion and the torque of the motor with which the load is on course.

    On course the load needs the torque T = J_l theta'' + drag - T_l, which twists the gear by u(T), and the motor
    stands at theta_m = N (theta_ref + u + e(theta_m)). Its torque is J_m theta_m'' + drag + (1/N - e') T less T_m, its
    own beside the controller's. The twist is taken to change slowly. `train` is the model of the drive, its load
    without couplings and its laws without memory.
    """

    loop: Any
    train: Any
    lead: Time = 0.0

    def start(self) -> Any:
        """Memory before the first sample."""
        return self.loop.start()

    def update(self, state: States, m: Measurement) -> Any:
        """Memory after a sample, and the torque [N*m]."""
        now = inverse(self.train, m.reference, m.speed, m.acceleration)
        ahead = inverse(
            self.train, m.reference + self.lead * m.speed, m.speed + self.lead * m.acceleration, m.acceleration
        )
        state, torque = self.loop.update(state, moved(m, now[0] - m.reference, now[1] - m.speed, 0.0))
        return state, torque + ahead[2]

    def check(self) -> None:
        """Refuse a loop that is none (TypeError), and a train that it cannot invert (ValueError)."""
        need("InverseDynamics.loop", self.loop, "start", "update(state, measurement)")
        need("InverseDynamics.train", self.train, "pointing_error")
        end = self.train.load.end()
        if end is not self.train.load or any(states_of(law) for law in (self.train.law, end.drag)):
            raise ValueError(
                "the train has couplings or laws with memory, which have no inverse in closed form; use a train "
                "without them; the loop corrects the difference"
            )
        if not (k := float(self.train.law.stiffness(0.0))) > 0.0:
            raise ValueError(f"the train has the stiffness {k:g} N*m/rad at rest, and no inverse; give a positive one")


@kernel
def inverse(train: Any, angle: Reals, speed: Reals, acceleration: Reals) -> Any:
    """Angle [rad], speed [rad/s] and torque [N*m] of the motor with which the load is at (angle, ...)/N."""
    load, N = train.load, train.N
    torque = load.J * acceleration / N - load.excitation.torque(angle)
    torque = torque + drag_of(load.drag, angle / N, speed / N)
    twist = torque / train.law.stiffness(0.0 * torque)
    for _ in range(ROUNDS):
        twist = twist - (train.law.torque(twist) - torque) / train.law.stiffness(twist)
    motor = angle + N * twist
    for _ in range(ROUNDS):
        motor = angle + N * (twist + train.error.value(motor))
    slope = train.error.slope(motor)
    fast = speed / (1.0 - N * slope)
    quick = (acceleration + N * train.error.curvature(motor) * fast * fast) / (1.0 - N * slope)
    drag = drag_of(train.motor.drag, motor, fast)
    ripple = train.motor.excitation.torque(angle)
    return motor, fast, train.motor.J * quick + drag + (1.0 / N - slope) * torque - ripple


@kernel
def drag_of(drag: Any, angle: Reals, speed: Reals) -> Any:
    """Torque [N*m] of a drag without memory."""
    return torque_of(drag, angle, speed, ())


class SpeedTable(NamedTuple):
    """The torque a(w) cos(k theta) + b(w) sin(k theta) is added to that of `loop`, w the speed of the reference.

    a and b are straight between up to 16 speeds, and constant outside. Several orders are tables around each other.
    """

    loop: Any
    speeds: tuple[AngularSpeed, ...]
    cosines: tuple[Torque, ...]
    sines: tuple[Torque, ...]
    order: int = 2
    lead: Time = 0.0

    def start(self) -> Any:
        """Memory before the first sample."""
        return self.loop.start()

    def update(self, state: States, m: Measurement) -> Any:
        """Memory after a sample, and the torque [N*m]."""
        state, torque = self.loop.update(state, m)
        turn = self.order * (m.reference + self.lead * m.speed)
        a, b = polygon(self.speeds, self.cosines, m.speed), polygon(self.speeds, self.sines, m.speed)
        return state, torque + a * cos(turn) + b * sin(turn)

    def check(self) -> None:
        """Refuse a loop that is none (TypeError), and speeds that do not increase or fit the torques (ValueError)."""
        need("SpeedTable.loop", self.loop, "start", "update(state, measurement)")
        n = len(self.speeds)
        if not 2 <= n <= MOST_POINTS or not n == len(self.cosines) == len(self.sines):
            raise ValueError(
                f"SpeedTable has {n} speeds, {len(self.cosines)} cosines and {len(self.sines)} sines; it needs from 2 "
                f"to {MOST_POINTS} of each, equally many"
            )
        if not all(a < b for a, b in pairwise(self.speeds)):
            raise ValueError("SpeedTable.speeds must increase; sort them")
