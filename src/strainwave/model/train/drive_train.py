"""The drive train: motor, gear and load, of which both error equations are reductions.

J_m theta_m'' = T_m + control - drag - (1/N - e'(theta_m)) T - T_f/N and J_l theta_l'' = T_l - drag + T, with the
gear's torque T = B u' + T(u), u = x - e(theta_m), x = theta_m/N - theta_l: Lagrange's equations of `theory.derivation`,
nothing dropped. T_f is the friction of the meshing, a share of |T|. The state holds x instead of theta_l, and the
motor's deviation from its reference instead of theta_m, so that no small twist is the difference of large angles.
"""

from typing import Any, NamedTuple

from ...base import law as laws
from ...base.above import above
from ...base.law import breakpoints_of, energy_of, has, heat_of, kinks_of, share, states_of, tail, torque_of, z_rate_of
from ...base.protocols import Control, joint_orders, need
from ...base.quantities import SMALLEST, AngularSpeed, Damping, Ratio, Reals, States
from ...compile.jit import chosen, kernel
from ..excitation import NoError
from ..laws.dry import Dry, comes_to_rest, dry, guards_of, moved, refuse_dry, sign_at, stuck
from ..laws.friction import NO_FRICTION
from .controls import controlled, motor_states, off_reference
from .linear_part import linear_part
from .motion import Steady
from .shafts import Motor, check_load, refuse_driving


@kernel
def motor_motion(train: Any, phase: Reals, y: States) -> Any:
    """Angle [rad] and speed [rad/s] of the motor."""
    angle, speed = motor_states(train.motor.control, y)[0]
    return train.reference.value(phase) + angle, train.omega * train.reference.slope(phase) + speed


@kernel
def gear_motion(train: Any, y: States, motor: States) -> Any:
    """Torsion [rad] of the gear, its rate [rad/s], and 1/N - e'(theta_m), how much output a motor's angle gives."""
    slope = train.error.slope(motor[0])
    return y[0] - train.error.value(motor[0]), y[1] - slope * motor[1], 1.0 / train.N - slope


@kernel
def gear_torque(train: Any, gear: States, states: States) -> Any:
    """Torque [N*m, output side] that the gear transmits, with its damping."""
    return torque_of(train.law, gear[0], gear[1], share(train.law, states)) + train.B * gear[1]


@kernel
def inner_states(train: Any, y: States) -> Any:
    """States of the train after those of the motor and of its control: of gear, motor's drag and load."""
    return tail(train.motor.control, motor_states(train.motor.control, y)[1])


@kernel
def motor_acceleration(train: Any, phase: Reals, y: States, motor: States, reaction: Reals, states: States) -> Any:
    """Acceleration [rad/s^2] of the motor, the torque [N*m] of its control, and the rates of the states of both."""
    control, drag = train.motor.control, train.motor.drag
    against = torque_of(drag, motor[0], motor[1], share(drag, states))
    excitation, torque = train.motor.excitation.torque(phase), -against - reaction
    omega, motion = train.omega, train.reference
    reference = omega * motion.slope(phase), omega * omega * motion.curvature(phase), motion.value(phase)
    z = motor_states(control, y)[1]
    seen, J = seen_deviation(control, train, y), moved(drag, train.motor.J)
    return controlled(control, J, torque, excitation, reference, seen, z)


@chosen
def seen_deviation(control: Control, train: Any, y: States) -> Any:
    """Deviation (angle [rad], speed [rad/s]) from the reference that a control of the motor sees by its encoders."""
    return _of_load if has(control, "at_load") else _of_motor


def _of_motor(control: Control, train: Any, y: States) -> Any:
    return motor_states(control, y)[0]


def _of_load(control: Control, train: Any, y: States) -> Any:
    angle, speed = motor_states(control, y)[0]
    return angle - train.N * (y[0] + coupling_twist(train, y)[0]), speed


@kernel
def forces(train: Any, phase: Reals, y: States) -> Any:
    """Motions of motor, gear and output, internal states of gear and drag, torque, and `motor_acceleration`."""
    motor = motor_motion(train, phase, y)
    gear, z = gear_motion(train, y, motor), inner_states(train, y)
    torque, of_motor = gear_torque(train, gear, z), tail(train.law, z)
    against = gear[2] * torque + train.friction.torque(torque, motor[1]) / train.N
    driven = motor_acceleration(train, phase, y, motor, against, of_motor)
    output = motor[0] / train.N - y[0], motor[1] / train.N - y[1]
    return motor, gear, output, z, of_motor, torque, driven


@kernel
def coupling_twist(train: Any, y: States) -> Any:
    """Twist [rad] of all couplings together and its rate, from the state; from the rates of the state, their rates."""
    return train.load.twist(tail(train.motor.drag, tail(train.law, inner_states(train, y))))


class DriveTrain(NamedTuple):
    """Motor, strain wave gear (ratio N, damping B across it, torsion law, kinematic error, friction) and load.

    The state is (x, x'), x = theta_m/N - theta_l [rad, output side] the dynamic error; the motor's deviation from its
    `reference` motion, (theta_m - reference [rad], its rate [rad/s]), unless it is held; the internal states of the
    control, of the law and of the motor's drag; for every coupling (twist [rad], its rate) and the internal states of
    its law; and the internal states of the load's drag. Behind couplings theta_l is the angle of what sits on the gear.
    The kinematic error follows the motor's own angle. `friction` is that of the meshing, `LoadFriction` or none.

    `excitation`s are functions of the base angle, phase = omega t; a run-up has omega = 1, so that the base angle is
    the time. With the `Steady` reference deviations are those from constant speed, and motions are periodic.
    """

    motor: Motor
    N: Ratio
    B: Damping
    law: Any
    load: Any
    omega: AngularSpeed = 1.0
    error: Any = NoError()
    reference: Any = Steady()
    friction: Any = NO_FRICTION

    def rhs(self, phase: Reals, y: States) -> Any:
        """Time derivatives of the state at the base angle [rad]."""
        motor, gear, output, z, of_motor, torque, (fast, _, of_control) = forces(self, phase, y)
        slow, of_load = self.load.rates(phase, output, tail(self.motor.drag, of_motor), torque)
        law = z_rate_of(self.law, gear[0], gear[1], share(self.law, z))
        drag = z_rate_of(self.motor.drag, motor[0], motor[1], share(self.motor.drag, of_motor))
        return (y[1], fast / self.N - slow, *of_control, *law, *drag, *of_load)

    def pulls(self, phase: Reals, y: States) -> Any:
        """Speed [rad/s] of motor and of load, each with the torque [N*m] on it if it sticks."""
        motor, _, output, _, of_motor, torque, (fast, _, _) = forces(self, phase, y)
        load = self.load.pull(phase, output, tail(self.motor.drag, of_motor), torque)
        return (motor[1], moved(self.motor.drag, self.motor.J) * fast), load

    def guards(self, phase: Reals, y: States) -> Any:
        """Functions that stay positive while each dry shaft slides as it does, or sticks: see `slipping`."""
        motor, load = self.pulls(phase, y)
        return guards_of(self.motor.drag, *motor) + guards_of(self.load.end().drag, *load)

    def slipping(self, phase: float, y: States) -> tuple["DriveTrain", States]:
        """The train as its shafts slide or stick from a state on, and that state, those at rest exactly so."""
        motor = self.motor.drag if self.motor.held else dry(self.motor.drag)
        load = dry(self.load.end().drag)
        if not (isinstance(motor, Dry) or isinstance(load, Dry)):
            return self, y
        of_motor, of_load = self.with_motor(drag=stuck(motor)).with_load(drag=stuck(load)).pulls(phase, y)
        state, turning = list(y), self.omega * self.reference.slope(phase)
        if isinstance(motor, Dry):
            rests, (v, pull) = comes_to_rest(self.motor.drag, of_motor[0], turning), of_motor
            motor = Dry(motor.drag, sign_at(motor, v, pull, rests))
            if rests:
                state[3], state[1] = state[3] - v, state[1] - v / self.N
        if isinstance(load, Dry):
            rests, (v, pull) = comes_to_rest(self.load.end().drag, of_load[0], turning), of_load
            load = Dry(load.drag, sign_at(load, v, pull, rests))
            if rests:
                state[(0, *self.twists())[-1] + 1] += v
        return self.with_motor(drag=motor).with_load(drag=load), tuple(state)

    def with_motor(self, **changes: Any) -> "DriveTrain":
        """The same with other fields of its motor."""
        return self._replace(motor=self.motor._replace(**changes))

    def with_load(self, **changes: Any) -> "DriveTrain":
        """The same with other fields of its load, behind all couplings."""
        return self._replace(load=self.load.with_end(self.load.end()._replace(**changes)))

    def torsion(self, phase: Reals, y: States) -> Any:
        """Torsion u = x - e(theta_m) of the gear [rad]."""
        return y[0] - self.error.value(motor_motion(self, phase, y)[0])

    def torque(self, phase: Reals, y: States) -> Any:
        """Torque that the gear transmits [N*m, output side], with its damping."""
        motor = motor_motion(self, phase, y)
        return gear_torque(self, gear_motion(self, y, motor), inner_states(self, y))

    def motor_torque(self, phase: Reals, y: States) -> Any:
        """Torque of the motor [N*m], that of its control included."""
        return self.motor.excitation.torque(phase) + forces(self, phase, y)[6][1]

    def energy(self, phase: Reals, y: States) -> Any:
        """Energy [J] of the whole train: kinetic, and stored in the laws."""
        motor = motor_motion(self, phase, y)
        gear, z = gear_motion(self, y, motor), inner_states(self, y)
        of_motor = tail(self.law, z)
        output = motor[0] / self.N - y[0], motor[1] / self.N - y[1]
        stored = energy_of(self.law, gear[0], share(self.law, z)) + energy_of(
            self.motor.drag, motor[0], share(self.motor.drag, of_motor)
        )
        kinetic = 0.5 * self.motor.J * motor[1] * motor[1]
        return kinetic + stored + self.load.energy(output, tail(self.motor.drag, of_motor))

    def losses(self, phase: Reals, y: States) -> Any:
        """Powers [W] as `power_names` lists them: put in by motor torque, control and load torque; then lost."""
        motor, gear, output, z, of_motor, torque, (_, control, _) = forces(self, phase, y)
        given = self.motor.excitation.torque(phase) * motor[1]
        law = heat_of(self.law, gear[0], gear[1], share(self.law, z))
        drag = heat_of(self.motor.drag, motor[0], motor[1], share(self.motor.drag, of_motor))
        mesh = self.friction.torque(torque, motor[1]) * motor[1] / self.N
        of_load = self.load.powers(phase, output, tail(self.motor.drag, of_motor))
        return (given, control * motor[1], of_load[0], self.B * gear[1] * gear[1], law, mesh, drag, *of_load[1:])

    def motor_speed(self, phase: Reals, y: States) -> Any:
        """Speed theta_m' of the motor [rad/s]."""
        return motor_motion(self, phase, y)[1]

    def load_speed(self, phase: Reals, y: States) -> Any:
        """Speed [rad/s] of the load, behind all couplings."""
        return motor_motion(self, phase, y)[1] / self.N - y[1] - coupling_twist(self, y)[1]

    def load_error(self, y: States) -> Any:
        """Error between motor and load [rad]: x and the twists of all couplings, theta_m/N - theta of the load.

        The motor's own deviation from its reference is not in it.
        """
        return y[0] + coupling_twist(self, y)[0]

    def pointing_error(self, y: States) -> Any:
        """Pointing error [rad] of the load: its reference angle, that of the motor over N, minus its angle.

        It is `load_error` less the motor's deviation over N; of a free motor, which has no reference, `load_error`.
        """
        return self.load_error(y) - off_reference(self.motor.control, y)[0] / self.N

    def twists(self) -> tuple[int, ...]:
        """Places of the couplings' twists in the state."""
        count = len(self.load.couplings())
        names = self.state_names() if count else ()  # asked for at every motion of a balance
        return tuple(names.index(f"coupling {i + 1}") for i in range(count))

    def breakpoints(self) -> tuple[float, ...]:
        """Torsions [rad] where the gear's law is not smooth."""
        return tuple(breakpoints_of(self.law))

    def kinks(self, phase: Reals, y: States) -> tuple[Any, ...]:
        """Functions that vanish where the laws of the gear and of the couplings are not smooth."""
        gear = gear_motion(self, y, motor_motion(self, phase, y))
        z = inner_states(self, y)
        corners = kinks_of(self.law, gear[0], gear[1], share(self.law, z))
        return (*corners, *self.load.kinks(tail(self.motor.drag, tail(self.law, z))))

    @property
    def load_inertia(self) -> Any:
        """Inertia [kg*m^2] of all that is behind the gear, rigid."""
        return self.load.end().J + sum(J for J, _, _ in self.load.chain())

    @property
    def loop_inertia(self) -> Any:
        """Inertia [kg*m^2, motor side] that a loop of the motor turns: the motor, and the rigid load over N^2."""
        return self.motor.J + self.load_inertia / (self.N * self.N)

    def state_names(self) -> tuple[str, ...]:
        """Names of the states, in order; a prime is a rate."""
        motor = () if self.motor.held else ("motor deviation", "motor deviation'")
        control = (f"control z{i + 1}" for i in range(states_of(self.motor.control)))
        law = (f"gear z{i + 1}" for i in range(states_of(self.law)))
        drag = (f"motor z{i + 1}" for i in range(states_of(self.motor.drag)))
        return ("x", "x'", *motor, *control, *law, *drag, *self.load.state_names())

    def power_names(self) -> tuple[str, ...]:
        """Names of the powers of `losses`, in order; the first three put energy in, the others take it out."""
        behind = (f"coupling {i}" for i in range(len(self.load.couplings()), 0, -1))
        return (
            "motor torque",
            "control",
            "load torque",
            "gear damping",
            "gear law",
            "gear friction",
            "motor drag",
            "load drag",
            *behind,
        )

    def orders(self) -> tuple[float, ...]:
        """Orders of the motor's torque and, with the motor at the base angle, of the kinematic error."""
        error = self.error if isinstance(self.reference, Steady) else NoError()
        return joint_orders(self.motor.excitation, error)

    def linear_part(self) -> Any:
        """Linear part around its laws, at constant mean speed; None where laws have memory or drags friction."""
        return linear_part(self)

    def to_control(self, **options: Any) -> Any:
        """Linear train as a `control.StateSpace` of python-control; see `drive.state_space`."""
        return above("to_control")(self, **options)

    def check(self) -> None:
        """Refuse no ratio, damping that drives (ValueError) and parts without the methods needed (TypeError)."""
        if not self.N >= SMALLEST:
            raise ValueError(f"DriveTrain.N is {self.N:g}; a ratio must be positive")
        refuse_driving(self)
        check_load("DriveTrain.load", self.load)
        for name, method in (
            ("law", "torque"),
            ("error", "value(angle)"),
            ("error", "slope(angle)"),
            ("reference", "curvature(angle)"),
            ("friction", "torque(torque, speed)"),
        ):
            need(f"DriveTrain.{name}", getattr(self, name), method)
        laws.check_law("DriveTrain.law", self.law)
        refuse_dry("DriveTrain.law", self.law)
