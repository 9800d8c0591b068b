"""What the objects must have that the package works with, what they may have, and the defaults otherwise.

No class of a user needs to inherit from these: they are read by people and by type checkers. The functions below are
the only place that asks an object for what it may have; `law` does the same for laws.
"""

from collections.abc import Callable
from typing import Any, Protocol

from .law import is_spring
from .quantities import checked, shown


class Law(Protocol):
    """Torque [N*m] of a torsion x [rad]: or of x and its rate, `torque(x, v)`, or with internal states, see `law`.

    It may have `energy(x)`, `breakpoints()` (torsions where it is not smooth), `scaled(factor)` (a form for many
    steps), `spring_stiffness(x)` (without what friction or memory add at rest) and `check()`.
    """

    def torque(self, x: Any) -> Any:
        """Torque [N*m]."""

    def stiffness(self, x: Any) -> Any:
        """Its derivative [N*m/rad]."""


class Excitation(Protocol):
    """A torque of the base angle. It may have `orders()`, integers on the base angle, and `corners()` of a profile."""

    def torque(self, angle: Any) -> Any:
        """Torque [N*m] at a base angle [rad]."""


class Error(Protocol):
    """A kinematic error of the base angle. It may have `orders()` and `lines`."""

    def value(self, angle: Any) -> Any:
        """Error [rad, output side]."""

    def slope(self, angle: Any) -> Any:
        """Derivative by the base angle."""

    def curvature(self, angle: Any) -> Any:
        """Second derivative."""


class System(Protocol):
    """Anything that moves. It may have `omega` [rad/s] (1: the base angle is the time in seconds).

    It may also have `state_names()` (two states otherwise), `orders()` (of the base angle: none known otherwise),
    `jacobian(phase, y)`, `torsion(phase, y)` (the first state otherwise) and `breakpoints()` of it, `kinks(phase, y)`,
    `sizes()` of its states, `watched(phase, y)` (beside the states, for extremes), and `prepared()`, its form for many
    steps.
    """

    def rhs(self, phase: Any, y: Any) -> Any:
        """Time derivatives of the states, a tuple, at a base angle [rad]."""


class Control(Protocol):
    """Torque [N*m] of a motor's control against its deviation, `torque(x, v)` or, with states, `torque(x, v, z)`.

    It may have `inertia()` [kg*m^2], which counts against the acceleration of the deviation (0 otherwise).
    """

    def torque(self, x: Any, v: Any) -> Any:
        """Torque at a deviation [rad] from the reference and its rate [rad/s]."""


class Scheme(Protocol):
    """What takes a step of an integration; `FixedStep` and `AdaptiveStep` make a method of it.

    For adaptive steps it has, in place of these, `attempt(system, phase, turn, y, h, rate)`, `error_order()`,
    `stable()` and `looks()`, see `numerics.integration.schemes`.
    """

    def order(self) -> int:
        """Its order: the error of a step is of one power of h more."""

    def step(self, system: Any, phase: Any, turn: Any, y: Any, h: Any) -> Any:
        """State, a tuple, after a step of h in time [s] and of `turn` in the base angle [rad]."""


class Measure(Protocol):
    """A number of each lane of an ensemble, accumulated while it runs.

    It may have `of_end(y)` and `of_turns(y)` in place of the two below, and `order()`, `unit()` and `check()`.
    """

    def start(self) -> Any:
        """Sums at the begin, a tuple."""

    def update(self, sums: Any, piece: Any) -> Any:
        """Sums after a piece of the trajectory."""

    def results(self, sums: Any, time: Any) -> Any:
        """Dictionary of name to value from the sums over a time [s]."""


class Load(Protocol):
    """What hangs on the gear's output: a `Load`, or an `Elastic` coupling with a load behind it.

    See `model.train.shafts`: its other methods say what moves behind the gear, and take the torque of the gear on.
    """

    def with_end(self, load: Any) -> Any:
        """The same couplings with another load behind them."""


def lacking(thing: Any, *methods: str) -> tuple[str, ...]:
    """Those of the methods or fields that an object lacks: all of them if it is a class."""
    return methods if isinstance(thing, type) else tuple(name for name in methods if not hasattr(thing, name))


def need(where: str, thing: Any, *methods: str, remedy: str = "") -> None:
    """Refuse what lacks one of the methods (TypeError): `where` names its field."""
    if missing := lacking(thing, *methods):
        raise TypeError(f"{where} is {shown(thing)}; it must be an object with a method {missing[0]}{remedy}")


def with_parts(verb: str, system: Any, *parts: str) -> Any:
    """Return `checked(system)`, or say in one sentence which field or method it lacks for `verb` (TypeError)."""
    system = checked(system)
    if missing := lacking(system, *parts):
        name = type(system).__name__
        remedy = "; drive.error_equation() gives one" if name == "Drive" else ""
        if not lacking(system, "rhs"):
            remedy = "; simulate, find_orbit, shoot, frequency_response and parameter_response take any system"
        raise TypeError(f"{verb} takes a system such as an Oscillator; {name} has no {missing[0]}{remedy}")
    return system


def prepared(thing: Any) -> Any:
    """Form of a system for many steps: itself, unless it has one."""
    return thing if lacking(thing, "prepared") else thing.prepared()


def scaled(thing: Any, factor: Any, otherwise: Callable[[Any, Any], Any]) -> Any:
    """A law, torque or error times a factor in its form for many steps: `otherwise` makes one where it has none."""
    return otherwise(thing, factor) if lacking(thing, "scaled") else thing.scaled(factor)


def omega_of(system: Any) -> Any:
    """Speed of the base angle [rad/s]: 1 where a system has none."""
    return getattr(system, "omega", 1.0)


def names_of(system: Any) -> tuple[str, ...]:
    """Names of a system's states: none where it does not say."""
    return () if lacking(system, "state_names") else tuple(system.state_names())


def state_count(system: Any) -> int:
    """How many states a system has: two unless it names them."""
    return len(names_of(system)) or 2


def orders_of(thing: Any) -> tuple[int, ...]:
    """Orders of a system, an excitation or an error on the base angle: none where they are not known."""
    return () if lacking(thing, "orders") else tuple(thing.orders())


def joint_orders(*parts: Any) -> tuple[int, ...]:
    """Orders of several parts, rising, each once."""
    return tuple(sorted({order for part in parts for order in orders_of(part)}))


def terms_of(torque: Any) -> tuple[Any, ...]:
    """Harmonics of a torque: its terms, or itself."""
    return tuple(getattr(torque, "terms", (torque,)))


def lines_of(error: Any) -> tuple[Any, ...]:
    """Lines of a kinematic error: none where it does not list them."""
    return tuple(getattr(error, "lines", ()))


def has_jacobian(system: Any) -> bool:
    """Whether a system has a `jacobian` that holds: of a law with friction or memory it does not."""
    return not lacking(system, "jacobian") and is_spring(system)


def order_of(measure: Any) -> int:
    """Highest order that a measure asks the steps to resolve; 0 where it does not ask."""
    return 0 if lacking(measure, "order") else int(measure.order())
