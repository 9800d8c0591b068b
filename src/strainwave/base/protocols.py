"""Methods that objects of the package must have and may have, and what holds for an object without an optional one.

No class of a user needs to inherit from these: they are read by people and by type checkers. The functions below ask
an object for what several modules need of it, and `law` does so for laws; a module that alone needs a part asks by
`lacking` or takes a default.
"""

from collections.abc import Callable
from functools import lru_cache
from inspect import signature
from typing import Any, Protocol

from .law import is_spring
from .quantities import Reals, checked, shown
from .results import Floats


class Law(Protocol):
    """Torque [N*m] of a torsion x [rad]: or of x and its rate, `torque(x, v)`, or with internal states, see `law`.

    It may have `energy(x)`, `breakpoints()` (torsions where it is not smooth), `scaled(factor)` (a form for many
    steps), `spring_stiffness(x)` (without what friction or memory add at rest), `kinks(x, v, z)` (what vanishes where a
    law with memory is not smooth), `rounded()` (its form with rounded corners) and `check()`.
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
    `sizes()` of its states, `watched(phase, y)` (beside the states, for extremes), `prepared()`, its form for many
    steps, and `linear_part()`, a `LinearPart` (None where it has none): what is linear around its laws. Integration
    stops where one of its `guards(phase, y)` becomes negative, and goes on with the system and the state that
    `slipping(phase, y)` gives.
    """

    def rhs(self, phase: Any, y: Any) -> Any:
        """Time derivatives of the states, a tuple, at a base angle [rad]."""


class Control(Protocol):
    """Torque [N*m] of a motor's control against its deviation, `torque(x, v)` or, with states, `torque(x, v, z)`.

    It may have `inertia()` [kg*m^2], which counts against the acceleration of the deviation (0 otherwise).
    """

    def torque(self, x: Any, v: Any) -> Any:
        """Torque at a deviation [rad] from the reference and its rate [rad/s]."""


class LinearPart(Protocol):
    """Linear part of a system around its laws: M p'' + C p' + K p + torques of the laws = forces, in coordinates p.

    The first coordinates are the twists that the `laws` see: the first without the kinematic error, u = x - e. If the
    error follows a coordinate of the motion, that one comes next. All in SI units, angles in rad.

    Attributes
    ----------
    inertia, damping, stiffness : (n, n) arrays
        Matrices M, C and K.
    gear_damping : float
        Damping [N*m*s/rad] of the rate of u.
    laws : tuple
        Laws of the first coordinates.
    error : Any
        Kinematic error.
    follows : bool
        True if the error is a function of the base angle and of coordinate `len(laws)` together.
    per_speed : (n,) array
        Constant torques per speed of the base angle [N*m*s/rad]: drag at the mean speed.
    loose : int
        The coordinate whose mean torque is not asked: nothing holds it, or an integral. -1: none.
    zero_mean : (n,) array
        The sum of the coordinates whose mean is 0 instead.
    integral : (n,) array
        Means of the coordinates of a control that integrates, for each N*m of that torque; 0 of another.
    values, rates : (states, n) arrays
        The states that are no rates as sums of coordinates, and the others as sums of rates of coordinates.
    disturbed : Any
        The system whose variational equations tell the stability.
    """

    def forces(self, angles: Floats) -> Floats:
        """Torques (n, samples) at base angles [rad], without those of `per_speed`."""


class Scheme(Protocol):
    """Scheme of equal steps for an integration."""

    def step(self, system: Any, phase: Any, turn: Any, y: Any, h: Any) -> Any:
        """State, a tuple, after a step of h in time [s] and of `turn` in the base angle [rad]."""


class Measure(Protocol):
    """A number of each lane of an ensemble, accumulated while it runs.

    It may have `of_end(y)` in place of the two below, and `order()`, `unit()` and `check()`.
    """

    def start(self) -> Any:
        """Sums at the begin, a tuple."""

    def update(self, sums: Any, piece: Any) -> Any:
        """Sums after a piece of the trajectory."""

    def results(self, sums: Any, time: Any) -> Any:
        """Dictionary of name to value from the sums over a time [s]."""


class Balance(Protocol):
    """Equations of a periodic orbit in its Fourier coefficients, which are what curves are followed through.

    A point z holds the `size()` coefficients (blocks: mean, cosines, sines; all states one after the other) and, last,
    the parameter that varies: leaf `leaf` of `system`, or a virtual one. A table has rows mean, cos 1, sin 1, ... and
    columns of states. An orbit takes `turns` turns of the base angle. There are three kinds, `SecondOrder` (of an
    oscillator, in its torsion u alone), `Condensed` (of a system that is linear around its laws, in what they see) and
    `FirstOrder` (of any system, in all states); what uses them asks for no class. All have all of this.
    """

    @property
    def system(self) -> Any:
        """The system, at its own parameters."""

    @property
    def leaf(self) -> int:
        """Place of the parameter among the numbers of the system; below -1 a virtual one."""

    @property
    def omega_leaf(self) -> int:
        """Place of the base frequency."""

    @property
    def turns(self) -> Any:
        """Turns of the base angle that an orbit takes."""

    @property
    def angles(self) -> Floats:
        """Base angles (samples,) [rad] of the samples of an orbit."""

    @property
    def synthesis(self) -> Floats:
        """Table (2H+1, samples): the coefficients of a state times it are the samples."""

    def _replace(self, *, system: Any = ..., leaf: int = ...) -> Any: ...

    def size(self) -> int:
        """Number of coefficients."""

    def harmonics(self) -> int:
        """Number of harmonics of a block."""

    def highest(self) -> int:
        """Highest harmonic of an orbit."""

    def state_count(self) -> int:
        """Number of states of the system."""

    def hill(self) -> bool:
        """True if disturbances obey Hill's equation, so that the trace of its period map tells all."""

    # What kernels call.

    def residual(self, z: Any, r: Any) -> None:
        """Write what the equations lack at z."""

    def linearise(self, z: Any, jacobian: Any, slope: Any) -> None:
        """Write its derivatives by the coefficients and by the parameter; follows `residual` at the same z."""

    def harmonic(self, z: Any, k: int) -> Any:
        """Cosine and sine coefficient of the first state's k-th harmonic."""

    def run(self, kernel: Any, *arguments: Any) -> Any:
        """Execute a kernel with the problem and arguments: as machine code, or as Python."""

    # From a point to an orbit and back.

    def series(self, points: Floats) -> Floats:
        """Coefficients (points, states, 2H+1), in blocks, of what the equations are in."""

    def displacements(self, points: Floats) -> Floats:
        """Coefficients (points, 2H+1), in blocks, of the first state."""

    def table(self, point: Floats) -> Floats:
        """Table of what the equations are in."""

    def state_table(self, table: Floats) -> Floats:
        """Table of the states that give all others, from a table of what the equations are in."""

    def motion(self, point: Floats, x: Floats) -> Floats:
        """Table of all states of a point, the first of which has the series x."""

    def point(self, table: Floats, value: float) -> Floats:
        """Point of a table of states, cut or filled up, at a value of the parameter."""

    def fitted(self, table: Floats, value: float) -> Floats | None:
        """Point of a table of what the equations are in; None where a symmetry forbids it."""

    def sampled(self, y: Floats, value: float) -> Floats:
        """Point of a motion with the states y (states, samples) at `angles`."""

    # What is known of its orbits.

    def linear_response(self, value: float) -> Floats:
        """Point near the response of the linearised system."""

    def left_out(self, points: Floats, index: int) -> tuple[Floats, Floats]:
        """Parameter at some points, one at `index`, and shares (values, states) of the harmonics left out there."""

    def damping_leaf(self) -> int | None:
        """Place of the damping that, strong enough, leaves the linear response alone; None where there is none."""

    def odd(self) -> Any:
        """Problem of the odd harmonics alone; None where orbits have others."""

    def biased(self) -> Any:
        """Problem with a little constant torque, of a system with half-wave symmetry; None for others."""

    def floating(self, points: Floats) -> Any:
        """True (points,) for an orbit that moves without any torque."""

    def several_at(self, points: Floats) -> Any:
        """True (points,) for an orbit beside which others may exist."""

    def to_search(self, value: float) -> Any:
        """The problem at a base frequency [rad/s], with as many harmonics as a search for other orbits takes."""

    def strongest(self) -> float:
        """Largest factor of all that alternates in the excitation in a search."""

    def ways(self) -> list[int]:
        """Leaves, virtual ones too, along which a search connects orbits."""

    def budget(self) -> tuple[int, float]:
        """Number of points of a search, and the length of its steps."""

    def patience(self) -> int | None:
        """Points of a curve beyond its range, at most; None: as many as it takes."""


def lacking(thing: object, *methods: str) -> tuple[str, ...]:
    """Those of the methods or fields that an object lacks: all of them if it is a class."""
    return methods if isinstance(thing, type) else tuple(name for name in methods if not hasattr(thing, name))


def takes(function: Any, count: int) -> bool:
    """True for a function or a method that, by its signature, can be called with so many arguments."""
    plain = getattr(function, "__func__", function)  # of a method, which has its object before its arguments
    return _takes(plain, count + (plain is not function))


@lru_cache(1024)
def _takes(function: Any, count: int) -> bool:
    try:
        signature(function).bind(*range(count))
    except ValueError:  # of a function written in C
        return True
    except TypeError:
        return False
    return True


def need(field: str, thing: object, *methods: str, remedy: str = "") -> None:
    """Refuse what lacks one of the methods, and a class in place of an object (TypeError): `field` is its name.

    A method may be written with its arguments, "value(angle, v)": one that takes fewer or more is refused too.
    """
    if isinstance(thing, type):
        name = thing.__name__
        raise TypeError(f"{field} is the class {name}; give an object of it, with its numbers: {name}(...){remedy}")
    for method in methods:
        name, _, arguments = method.partition("(")
        part = lacking(thing, "rhs") and takes(getattr(thing, name, None), arguments.count(",") + 1)  # no whole system
        if lacking(thing, name) or (arguments and not part):
            raise TypeError(f"{field} is {shown(thing)}; it must be an object with a method {method}{remedy}")


def with_parts(verb: str, system: System, *parts: str) -> Any:
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


def linear_part_of(system: Any) -> Any:
    """The `LinearPart` of a system; None where it has none or does not say."""
    return None if lacking(system, "linear_part") else system.linear_part()


def scaled(thing: Any, factor: Reals, otherwise: Callable[[Any, Any], Any]) -> Any:
    """A law, torque or error times a factor in its form for many steps: `otherwise` makes one where it has none."""
    return otherwise(thing, factor) if lacking(thing, "scaled") else thing.scaled(factor)


def omega_of(system: System) -> Any:
    """Speed of the base angle [rad/s]: 1 where a system has none."""
    return getattr(system, "omega", 1.0)


def names_of(system: Any) -> tuple[str, ...]:
    """Names of a system's states: none where it does not say."""
    return () if lacking(system, "state_names") else tuple(system.state_names())


def state_count(system: System) -> int:
    """Number of states of a system: two unless it names them."""
    return len(names_of(system)) or 2


def orders_of(thing: Any) -> tuple[float, ...]:
    """Orders of a system, an excitation or an error on the base angle: none where they are not known."""
    return () if lacking(thing, "orders") else tuple(thing.orders())


def joint_orders(*parts: Any) -> tuple[float, ...]:
    """Orders of several parts, rising, each once."""
    return tuple(sorted({order for part in parts for order in orders_of(part)}))


def terms_of(torque: object) -> tuple[Any, ...]:
    """Harmonics of a torque: its terms, or itself."""
    return tuple(getattr(torque, "terms", (torque,)))


def lines_of(error: object) -> tuple[Any, ...]:
    """Lines of a kinematic error: none where it does not list them."""
    return tuple(getattr(error, "lines", ()))


def has_jacobian(system: System) -> bool:
    """True for a system with a `jacobian` that holds: with friction or memory in the law it does not."""
    return not lacking(system, "jacobian") and is_spring(system)


def order_of(measure: Any) -> int:
    """Highest order that a measure asks the steps to resolve; 0 where it does not ask."""
    return 0 if lacking(measure, "order") else int(measure.order())
