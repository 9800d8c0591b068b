"""Both ends of a drive train: the motor with its control, and the load, on its own or behind a coupling.

The torque against a shaft is a law of that shaft's angle and speed, of any kind: friction (`Coulomb`, `LuGre`, ...),
gravity (`AngleTorque`), both (`Parallel`). Angles in rad, torques in N*m, each of its own shaft.

The methods of a load are given its states, for every coupling from the gear on (twist, its rate, z of its law) and then
z of the load's drag, and the `motion` (angle, speed) of the gear's output.
"""

from typing import Any, NamedTuple

from ...base.law import check_law, energy_of, heat_of, kinks_of, share, states_of, tail, torque_of, z_rate_of
from ...base.protocols import lacking, need
from ...base.quantities import SMALLEST, Damping, Inertia, Reals, States, shown
from ..excitation import Harmonic
from ..laws.dry import moved, refuse_dry
from ..laws.springs import Linear
from .controls import FREE, Free, Held

NO_TORQUE, NO_DRAG = Harmonic(0.0), Linear(0.0)


class Motor(NamedTuple):
    """Motor and wave generator: inertia J, torque `excitation`(base angle), `drag`(angle, speed), and `control`."""

    J: Inertia
    excitation: Any = NO_TORQUE
    drag: Any = NO_DRAG
    control: Any = FREE

    @property
    def held(self) -> bool:
        """True for a motor that follows its reference ideally."""
        return isinstance(self.control, Held)

    @property
    def free(self) -> bool:
        """True for a motor that nothing keeps on its reference."""
        return isinstance(self.control, Free)

    def check(self) -> None:
        """Refuse an inertia that is not positive (ValueError) and parts of another kind (TypeError)."""
        _check_shaft(self)
        if self.held:
            return
        if lacking(self.control, "torque"):
            raise TypeError(
                f"Motor.control is {shown(self.control)}; it must be Free(), Held(), a SpeedLoop, a PositionLoop or "
                "another object with a torque(x, v) against the deviation from the reference"
            )
        check_law("Motor.control", self.control)


class Load(NamedTuple):
    """Load: inertia J, torque `excitation` (of the base angle) along the motion, `drag` (of angle and speed)."""

    J: Inertia
    excitation: Any = NO_TORQUE
    drag: Any = NO_DRAG

    def rates(self, phase: Any, motion: Any, states: Any, torque: Any) -> Any:
        """Acceleration [rad/s^2] of what sits on the gear under its `torque` [N*m], and the rates of the states."""
        angle, speed = motion
        z = share(self.drag, states)
        drag = torque_of(self.drag, angle, speed, z)
        pull = torque + self.excitation.torque(phase) - drag
        return pull / moved(self.drag, self.J), z_rate_of(self.drag, angle, speed, z)

    def pull(self, phase: Any, motion: Any, states: Any, torque: Any) -> Any:
        """Speed [rad/s] of the load, and the torque [N*m] on it."""
        drag = torque_of(self.drag, motion[0], motion[1], share(self.drag, states))
        return motion[1], torque + self.excitation.torque(phase) - drag

    def twist(self, states: States) -> Any:
        """Twist [rad] of all couplings together and its rate; from the rates of the states, their rates."""
        return 0.0, 0.0

    def energy(self, motion: States, states: States) -> Any:
        """Energy [J]: kinetic, and stored in the laws."""
        return 0.5 * self.J * motion[1] * motion[1] + energy_of(self.drag, motion[0], share(self.drag, states))

    def powers(self, phase: Reals, motion: States, states: States) -> Any:
        """Powers [W]: what the load torque puts in, then what the drag and each coupling lose."""
        lost = heat_of(self.drag, motion[0], motion[1], share(self.drag, states))
        return self.excitation.torque(phase) * motion[1], lost

    def kinks(self, states: States) -> Any:
        """Functions that vanish where the laws of the couplings are not smooth: none."""
        return ()

    def state_names(self, number: int = 1) -> tuple[str, ...]:
        """Names of the states; couplings are counted from `number` on."""
        return tuple(f"load z{i + 1}" for i in range(states_of(self.drag)))

    def couplings(self) -> tuple[Any, ...]:
        """Laws of the couplings between the gear and the load: none."""
        return ()

    def chain(self) -> tuple[tuple[Any, Any, Any], ...]:
        """Inertia before each coupling, its damping and its law, from the gear on: none."""
        return ()

    def end(self) -> Any:
        """The load itself, behind all couplings."""
        return self

    def with_end(self, load: Any) -> Any:
        """The same couplings with another load behind them."""
        return load

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

    def rates(self, phase: Any, motion: Any, states: Any, torque: Any) -> Any:
        """Acceleration [rad/s^2] of what sits on the gear under its `torque` [N*m], and the rates of the states."""
        twist, speed, z = states[0], states[1], states[2:]
        behind, states_of_law = (motion[0] - twist, motion[1] - speed), share(self.law, z)
        passed = torque_of(self.law, twist, speed, states_of_law) + self.B * speed
        gear_side = (torque - passed) / self.J
        load_side, rates = self.load.rates(phase, behind, tail(self.law, z), passed)
        return gear_side, (speed, gear_side - load_side, *z_rate_of(self.law, twist, speed, states_of_law), *rates)

    def pull(self, phase: Any, motion: Any, states: Any, torque: Any) -> Any:
        """Speed [rad/s] of the load, and the torque [N*m] on it."""
        twist, speed, z = states[0], states[1], states[2:]
        passed = torque_of(self.law, twist, speed, share(self.law, z)) + self.B * speed
        return self.load.pull(phase, (motion[0] - twist, motion[1] - speed), tail(self.law, z), passed)

    def twist(self, states: States) -> Any:
        """Twist [rad] of all couplings together and its rate; from the rates of the states, their rates."""
        twist, rate = self.load.twist(tail(self.law, states[2:]))
        return states[0] + twist, states[1] + rate

    def energy(self, motion: States, states: States) -> Any:
        """Energy [J]: kinetic, and stored in the laws."""
        twist, speed, z = states[0], states[1], states[2:]
        behind = motion[0] - twist, motion[1] - speed
        of_coupling = 0.5 * self.J * motion[1] * motion[1] + energy_of(self.law, twist, share(self.law, z))
        return of_coupling + self.load.energy(behind, tail(self.law, z))

    def powers(self, phase: Reals, motion: States, states: States) -> Any:
        """Powers [W]: what the load torque puts in, then what the drag and each coupling lose, the nearest last."""
        twist, speed, z = states[0], states[1], states[2:]
        behind = motion[0] - twist, motion[1] - speed
        lost = self.B * speed * speed + heat_of(self.law, twist, speed, share(self.law, z))
        return (*self.load.powers(phase, behind, tail(self.law, z)), lost)

    def kinks(self, states: States) -> Any:
        """Functions that vanish where the laws of the couplings are not smooth."""
        z = states[2:]
        corners = kinks_of(self.law, states[0], states[1], share(self.law, z))
        return (*corners, *self.load.kinks(tail(self.law, z)))

    def state_names(self, number: int = 1) -> tuple[str, ...]:
        """Names of the states; couplings are counted from `number` on."""
        name = f"coupling {number}"
        inner = tuple(f"{name} z{i + 1}" for i in range(states_of(self.law)))
        return (name, f"{name}'", *inner, *self.load.state_names(number + 1))

    def couplings(self) -> tuple[Any, ...]:
        """Laws of the couplings between the gear and the load, from the gear on."""
        return (self.law, *self.load.couplings())

    def chain(self) -> tuple[tuple[Any, Any, Any], ...]:
        """Inertia before each coupling, its damping and its law, from the gear on."""
        return ((self.J, self.B, self.law), *self.load.chain())

    def end(self) -> Any:
        """The load itself, behind all couplings."""
        return self.load.end()

    def with_end(self, load: Any) -> Any:
        """The same couplings with another load behind them."""
        return self._replace(load=self.load.with_end(load))

    def check(self) -> None:
        """Refuse an inertia that is not positive (ValueError) and parts of another kind (TypeError)."""
        _positive_inertia(self)
        refuse_driving(self)
        need("Elastic.law", self.law, "torque")
        check_law("Elastic.law", self.law)
        refuse_dry("Elastic.law", self.law)
        check_load("Elastic.load", self.load)


def check_load(name: str, load: object) -> None:
    """Refuse what has not the methods of a load (TypeError): `name` is that of its field."""
    if lacking(load, "with_end"):
        raise TypeError(f"{name} is {shown(load)}; it must be a Load or an Elastic")


def refuse_driving(part: Any) -> None:
    """Refuse a damping B that would put energy in (ValueError)."""
    if not part.B >= 0.0:
        raise ValueError(
            f"{type(part).__name__}.B is {part.B:g} N*m*s/rad; a damping must not be negative, it would drive the train"
        )


def _positive_inertia(shaft: Any) -> None:
    if not shaft.J >= SMALLEST:
        name = type(shaft).__name__
        raise ValueError(f"{name}.J is {shaft.J:g} kg*m**2; an inertia must be positive, {SMALLEST:g} up")


def _check_shaft(shaft: Any) -> None:
    _positive_inertia(shaft)
    name = type(shaft).__name__
    need(f"{name}.excitation", shaft.excitation, "torque(angle)")
    need(f"{name}.drag", shaft.drag, "torque")
    check_law(f"{name}.drag", shaft.drag)
