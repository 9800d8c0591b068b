"""Other forms of a drive train: at constant mean speed, with its energies as states, in coordinates of the load."""

from dataclasses import replace
from typing import Any, NamedTuple

from ...base.protocols import joint_orders
from ...base.quantities import AngularSpeed, Ratio, Reals, States
from ...compile.jit import kernel
from ...compile.tree import axpy
from ..excitation import NoError
from .controls import off_reference
from .drive_train import DriveTrain, coupling_twist, motor_motion
from .linear_part import linear_part
from .motion import AtRest, Steady


class SteadyTrain(NamedTuple):
    """A free drive train at constant mean speed, in coordinates that do not drift, so that its motions are periodic.

    The state is (x [rad], x' [rad/s], w [rad/s], p [N*m]), then the internal states as in the train: w is the motor's
    speed less that of the train's reference (omega for `Steady`, 0 for `AtRest`), and p the mean motor torque that
    keeps the mean speed, found with the orbit: p' = -(bandwidth^2/8) J_m omega^2 w, with the torque -bandwidth J_m
    omega w beside it. On the ripple of order k the two act as a speed loop far below it, of relative size bandwidth/k:
    the motor is free but for that.

    With `by_angle` 1 the base angle is the motor's own angle: the excitation follows the motor through its ripple, as
    kinematic error, cogging and commutation do, and the mean over time is exactly omega. With 0 the base angle is
    omega t, for torques given in time; the train may then have no kinematic error. The two largest multipliers of an
    orbit belong to the mean speed, just below 1.
    """

    train: DriveTrain
    omega: AngularSpeed
    by_angle: int = 1
    bandwidth: Ratio = 1e-6

    def rhs(self, phase: Reals, y: States) -> Any:
        """Rates of the state, per 1/omega of the base angle: time derivatives where that is omega t."""
        w = y[2]
        speed = w + (self.omega - self.train.omega) * self.train.reference.slope(phase)
        rates = self.train.rhs(phase, (y[0], y[1], 0.0 * w, speed, *y[4:]))
        inertia = self.train.motor.J
        kept = y[3] / inertia - self.bandwidth * self.omega * w
        trim = -0.125 * self.bandwidth * self.bandwidth * inertia * self.omega * self.omega * w
        corrected = (rates[0], rates[1] + kept / self.train.N, rates[3] + kept, trim, *rates[4:])
        return axpy(corrected, self.by_angle * (self.omega / (self.omega + w) - 1.0), corrected)

    def sizes(self) -> tuple[float, ...]:
        """Least sizes of the states for finite differences: 1e-3 J_m omega^2 for p, of which all rates are linear."""
        least = 1e-3 * self.train.motor.J * self.omega * self.omega
        return tuple(least if name == "p" else 0.0 for name in self.state_names())

    def torsion(self, phase: Reals, y: States) -> Any:
        """Torsion u = x - e(theta_m) of the gear [rad]."""
        return y[0] - self.train.error.value(phase)

    def torque(self, phase: Reals, y: States) -> Any:
        """Torque that the gear transmits [N*m, output side], with its damping."""
        return self.train.torque(phase, self._train_state(phase, y))

    def _train_state(self, phase: Reals, y: States) -> Any:
        """State of the train itself."""
        speed = y[2] + (self.omega - self.train.omega) * self.train.reference.slope(phase)
        return (y[0], y[1], 0.0 * speed, speed, *y[4:])

    def breakpoints(self) -> tuple[float, ...]:
        """Torsions [rad] where the gear's law is not smooth."""
        return self.train.breakpoints()

    def kinks(self, phase: Reals, y: States) -> Any:
        """Functions that vanish where the laws are not smooth, as of the train itself."""
        return self.train.kinks(phase, self._train_state(phase, y))

    def state_names(self) -> tuple[str, ...]:
        """Names of the states, in order."""
        return ("x", "x'", "w", "p", *self.train.state_names()[4:])

    def orders(self) -> tuple[float, ...]:
        """Orders of the motor's torque and of the kinematic error."""
        return self.train.orders()

    def check(self) -> None:
        """Refuse a train that is not free, or whose motions have no constant mean speed (ValueError)."""
        train = self.train
        if not train.motor.free:
            raise ValueError(
                f"SteadyTrain takes a free motor, not {train.motor.control}; a motor with a loop keeps its mean speed, "
                "so find_orbit takes its DriveTrain as it is"
            )
        if self.by_angle not in (0, 1):
            raise ValueError(f"SteadyTrain.by_angle is {self.by_angle}; it must be 1 (motor's angle) or 0 (omega t)")
        if not isinstance(train.reference, Steady if self.by_angle else Steady | AtRest):
            raise ValueError(
                "SteadyTrain needs the reference Steady(), or AtRest() with by_angle=0; other motions are not periodic"
            )
        if not self.by_angle and not isinstance(train.error, NoError):
            raise ValueError("a kinematic error follows the motor's angle; take by_angle=1, torques then follow it too")
        if not self.omega > 0.0 or not self.bandwidth > 0.0:
            raise ValueError(
                f"SteadyTrain has omega {self.omega:g} rad/s and bandwidth {self.bandwidth:g}; both must be positive"
            )


class Metered(NamedTuple):
    """A drive train whose state goes on with the energies [J] of `train.power_names()`: the integrals of its powers.

    They have the accuracy of the integration, so that the energy balance closes to its tolerance.
    """

    train: DriveTrain

    @property
    def omega(self) -> float:
        """Base speed [rad/s] of the train."""
        return self.train.omega

    def rhs(self, phase: Reals, y: States) -> Any:
        """Time derivatives of the state and the powers [W]; the train looks at its own states alone."""
        return self.train.rhs(phase, y) + self.train.losses(phase, y)

    def torsion(self, phase: Reals, y: States) -> Any:
        """Torsion u = x - e(theta_m) of the gear [rad]."""
        return self.train.torsion(phase, y)

    def watched(self, phase: Reals, y: States) -> Any:
        """Pointing error and x at the load [rad], torque in the gear [N*m, output side], speed of the motor [rad/s]."""
        train = self.train
        return train.pointing_error(y), train.load_error(y), train.torque(phase, y), motor_motion(train, phase, y)[1]

    def breakpoints(self) -> tuple[float, ...]:
        """Torsions [rad] where the gear's law is not smooth."""
        return self.train.breakpoints()

    def guards(self, phase: Reals, y: States) -> Any:
        """Functions that stay positive while the shafts of the train slide as they do, or stick."""
        return self.train.guards(phase, y)

    def slipping(self, phase: float, y: States) -> Any:
        """The same as its shafts slide or stick from a state on, and that state."""
        train, state = self.train.slipping(phase, y)
        return self._replace(train=train), state

    def state_names(self) -> tuple[str, ...]:
        """Names of the train's states, then of the powers that are integrated."""
        return self.train.state_names() + self.train.power_names()


@kernel
def turning(system: Any) -> Any:
    """The train of an `AtLoad` at its speed omega."""
    train = system.train
    return DriveTrain(
        train.motor, train.N, train.B, train.law, train.load, system.omega, train.error, train.reference, train.friction
    )


@kernel
def own_state(system: Any, y: States) -> Any:
    """State of the train itself from that of an `AtLoad`."""
    twist, rate = behind_gear(system.train, y)
    return (y[0] - twist, y[1] - rate, *y[2:])


@kernel
def behind_gear(train: DriveTrain, y: States) -> Any:
    """Pointing error [rad] beside x of the gear, and its rate; from the rates of the state, their rates.

    The twists of all couplings, less the motor's deviation over the ratio.
    """
    (twist, rate), (angle, speed) = coupling_twist(train, y), off_reference(train.motor.control, y)
    return twist - angle / train.N, rate - speed / train.N


class AtLoad(NamedTuple):
    """A train in whose state (x, x') is the pointing error and its rate: reference/N - theta of the load.

    The pointing error is x of the gear, with the twists of couplings and without the motor's own deviation from its
    reference. A free motor has no reference: there it is x. Its omega is that of the train.
    """

    train: DriveTrain
    omega: AngularSpeed

    @property
    def law(self) -> Any:
        """Law of the gear."""
        return self.train.law

    def rhs(self, phase: Reals, y: States) -> Any:
        """Time derivatives of the state at the base angle [rad]."""
        rates = turning(self).rhs(phase, own_state(self, y))
        speed, acceleration = behind_gear(self.train, rates)
        return (rates[0] + speed, rates[1] + acceleration, *rates[2:])

    def torsion(self, phase: Reals, y: States) -> Any:
        """Torsion u = x - e(theta_m) of the gear [rad], x that across the gear."""
        return turning(self).torsion(phase, own_state(self, y))

    def breakpoints(self) -> tuple[float, ...]:
        """Torsions [rad] where the gear's law is not smooth."""
        return self.train.breakpoints()

    def kinks(self, phase: Reals, y: States) -> Any:
        """Functions that vanish where its laws are not smooth, as of the train itself."""
        return turning(self).kinks(phase, own_state(self, y))

    def guards(self, phase: Reals, y: States) -> Any:
        """Functions that stay positive while the shafts of the train slide as they do, or stick."""
        return turning(self).guards(phase, own_state(self, y))

    def slipping(self, phase: float, y: States) -> Any:
        """The same as its shafts slide or stick from a state on, and that state."""
        train, state = turning(self).slipping(phase, own_state(self, y))
        twist, rate = behind_gear(train, state)
        return self._replace(train=train), (state[0] + twist, state[1] + rate, *state[2:])

    def orders(self) -> tuple[float, ...]:
        """Orders of the torques and of the kinematic error."""
        return joint_orders(self.train, self.train.load.end().excitation)

    def linear_part(self) -> Any:
        """Linear part around its laws; its mean torque keeps the speed of a motor that nothing holds."""
        part = linear_part(turning(self), at_load=True)
        return None if part is None else replace(part, disturbed=AtLoad(part.disturbed, self.omega))
