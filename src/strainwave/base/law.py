"""Arguments that a law depends on, and the functions that do the same for every class of law or system.

x is the torsion [rad], v its rate [rad/s], z a tuple of internal states.

The arguments of its `torque` say it: `torque(x)` is a spring, `torque(x, v)` has friction, `torque(x, v, z)` memory,
with `z_rate(x, v, z)`, the tuple of the rates of its internal states z, and `states`, their number (a class constant or
a method without arguments; a law made of laws needs none: it has the states of its parts, in order). The choice is made
by class: in compiled code it costs nothing.
"""

from collections.abc import Iterator
from functools import cache
from itertools import pairwise
from math import isfinite, nan
from typing import Any

from ..compile.jit import chosen, kernel
from ..compile.tree import alike, axpy, shown
from .above import ROOT

KINDS = ("torque(x)", "torque(x, v)", "torque(x, v, z)")
TORSIONS = (1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0)  # times UNROUND, rad, to both sides: where a slope is compared
UNROUND = 1.2371  # no torsion that a user is likely to have a kink at
STEPS = (0.1, 1e-3, 1e-7)  # of the torsion: differences of which one gives the slope, whatever the law's scale
SLOPE_DIFFERENCE = 0.05  # of the larger one: two slopes that differ

COEFFICIENT = 1e-9  # of the terms of a polynomial: a torque that differs is another


def class_of(law: Any) -> Any:
    """Class of a model, or of the models that a type of the compiler stands for."""
    return getattr(law, "instance_class", type(law))


def has(thing: object, name: str) -> bool:
    """True if the class of a model, or of the models of a type of the compiler, has a method."""
    return hasattr(class_of(thing), name)


@cache
def _arguments(cls: type[Any]) -> int:
    code = getattr(getattr(cls, "torque", None), "__code__", None)
    return code.co_argcount - 1 - len(cls.torque.__defaults__ or ()) if code else 1


def depends(law: Any) -> int:
    """On how much a law's torque depends: 1 for torque(x), 2 for torque(x, v), 3 for torque(x, v, z)."""
    return _arguments(class_of(law))


def parts_of(law: Any) -> tuple[Any, ...]:
    """Laws that a law with memory is made of: its fields, where it does not say how many states are its own."""
    if not has(law, "z_rate") or has(law, "states"):
        return ()
    parts = law.types if hasattr(law, "instance_class") else law
    return tuple(part for part in parts if has(part, "torque"))


def states_of(law: Any) -> int:
    """Number of a law's internal states z."""
    cls = class_of(law)
    if not hasattr(cls, "z_rate"):
        return 0
    states = getattr(cls, "states", None)
    if states is None:
        return sum(states_of(part) for part in parts_of(law))
    return int(states(law) if callable(states) else states)


@chosen
def torsion(system: Any, phase: Any, y: Any) -> Any:
    """Return the system's torsion, or its first state where it defines none."""
    if has(system, "torsion"):
        return lambda system, phase, y: system.torsion(phase, y)
    return lambda system, phase, y: y[0]


@chosen
def torque_of(law: Any, x: Any, v: Any, z: Any) -> Any:
    """Torque [N*m] of any law at torsion x [rad], its rate v [rad/s] and the law's internal states z (a tuple)."""
    return (_of_spring, _of_friction, _of_memory)[depends(law) - 1]


@chosen
def z_rate_of(law: Any, x: Any, v: Any, z: Any) -> Any:
    """Rates of a law's internal states: a tuple, empty for a law without memory."""
    return (lambda law, x, v, z: law.z_rate(x, v, z)) if has(law, "z_rate") else (lambda law, x, v, z: ())


@chosen
def energy_of(law: Any, x: Any, z: Any) -> Any:
    """Energy stored [J] in any law; a law torque(x, v) stores none unless it has energy(x)."""
    if depends(law) == 3:
        return _energy_of_memory
    return _energy_of_spring if has(law, "energy") else _no_energy


@chosen
def losses_of(law: Any, x: Any, v: Any, z: Any) -> Any:
    """Powers [W] that a law turns into heat: a tuple, empty for a spring, T v for friction without memory."""
    return (_no_losses, _friction_losses, _own_losses)[depends(law) - 1]


@kernel
def heat_of(law: Any, x: Any, v: Any, z: Any) -> Any:
    """Power [W] that a law turns into heat: the sum of its `losses_of`."""
    powers = (0.0, *losses_of(law, x, v, z))
    total = powers[0]
    for i in range(1, len(powers)):
        total = total + powers[i]
    return total


def spring_stiffness(law: Any, x: Any) -> Any:
    """Stiffness [N*m/rad] of the spring in any law at torsion x [rad], without what friction or memory add at rest.

    Hysteresis and bristles are springs too until they yield or slip; a vibration of any size is not held by them.
    It is `law.spring_stiffness(x)`, and of laws without that method their `stiffness(x)`.
    """
    return law.spring_stiffness(x) if has(law, "spring_stiffness") else law.stiffness(x)


@chosen
def share(law: Any, z: Any) -> Any:
    """Internal states of a law itself: as many of the first of z as it has."""
    n = states_of(law)

    def first(law: Any, z: Any) -> Any:
        return z[:n]

    return first


@chosen
def tail(law: Any, z: Any) -> Any:
    """Tail of z: the internal states after the law's own."""
    n = states_of(law)

    def after(law: Any, z: Any) -> Any:
        return z[n:]

    return after


@chosen
def breakpoints_of(law: Any) -> Any:
    """Breakpoints of a law: a tuple of torsions, empty for one that does not say."""
    return (lambda law: law.breakpoints()) if has(law, "breakpoints") else (lambda law: ())


def stated(law: Any, name: str) -> Any:
    """Statement of a law on its torque as a whole, by a method without arguments; None from a law without it.

    A subclass that changes the torque states nothing by the method that it inherits.
    """
    classes = type(law).__mro__
    author = next((cls for cls in classes if name in vars(cls) or "torque" in vars(cls)), object)
    return getattr(law, name)() if name in vars(author) else None


def polynomial_of(law: Any) -> tuple[float, ...] | None:
    """Coefficients c_0, c_1, ... of a law whose torque is the sum of c_k x^k [N*m/rad^k]; None of another."""
    coefficients = stated(law, "polynomial")
    return None if coefficients is None else tuple(coefficients)


def is_linear(law: Any) -> bool:
    """True for a law that states a torque in a straight line over the torsion."""
    coefficients = polynomial_of(law)
    return coefficients is not None and not any(coefficients[2:])


@chosen
def kinks_of(law: Any, x: Any, v: Any, z: Any) -> Any:
    """Functions that vanish at the kinks of a law: its `kinks`, or distances [rad] of the torsion from breakpoints."""
    return _own_kinks if has(law, "kinks") else _past_breakpoints


def _own_kinks(law: Any, x: Any, v: Any, z: Any) -> Any:
    return law.kinks(x, v, z)


def _past_breakpoints(law: Any, x: Any, v: Any, z: Any) -> Any:
    breakpoints = breakpoints_of(law)
    return axpy(alike(breakpoints, x), -1.0, breakpoints)


def _of_spring(law: Any, x: Any, v: Any, z: Any) -> Any:
    return law.torque(x)


def _of_friction(law: Any, x: Any, v: Any, z: Any) -> Any:
    return law.torque(x, v)


def _of_memory(law: Any, x: Any, v: Any, z: Any) -> Any:
    return law.torque(x, v, z)


def _energy_of_spring(law: Any, x: Any, z: Any) -> Any:
    return law.energy(x)


def _energy_of_memory(law: Any, x: Any, z: Any) -> Any:
    return law.energy(x, z)


def _no_energy(law: Any, x: Any, z: Any) -> Any:
    return 0.0 * x


def _no_losses(law: Any, x: Any, v: Any, z: Any) -> Any:
    return ()


def _friction_losses(law: Any, x: Any, v: Any, z: Any) -> Any:
    return (law.torque(x, v) * v,)


def _own_losses(law: Any, x: Any, v: Any, z: Any) -> Any:
    return law.losses(x, v, z)


def check_law(field: str, law: Any) -> None:
    """Refuse a law whose methods do not fit together (TypeError, ValueError): `field` is its name."""
    if isinstance(law, type):
        name = law.__name__
        raise TypeError(f"{field} is the class {name}; give an object of it, with its numbers: {name}(...)")
    name = type(law).__name__
    if has(law, "rhs"):
        raise TypeError(f"{field} is a {name}, a system that moves by itself; give a law, such as Linear(K)")
    if depends(law) not in (1, 2, 3):
        raise TypeError(f"{name}.torque takes {depends(law)} arguments; a law has {', '.join(KINDS)}")
    if (depends(law) == 3) != has(law, "z_rate"):
        raise TypeError(f"{name} has {KINDS[depends(law) - 1]}; torque(x, v, z) and z_rate(x, v, z) need each other")
    if depends(law) == 3:
        n, z = states_of(law), (0.0,) * states_of(law)
        try:
            rates = len(law.z_rate(0.0, 0.0, z))
        except (IndexError, ValueError):
            rates = -1
        if rates != n:
            raise TypeError(
                f"{field}: {name} has {n} internal states but z_rate does not give as many rates; write `states = 2` "
                "in the class for two of them and return a tuple of two"
            )
    if depends(law) == 1 and has(law, "stiffness") and not of_the_package(law):
        _check_slope(law)
    if depends(law) == 1 and not of_the_package(law):
        _check_polynomial(law)


def of_the_package(law: Any) -> bool:
    """True for a law of a class of this package, so that its methods fit together."""
    return type(law).__module__.startswith(f"{ROOT}.")


def _check_slope(law: Any) -> None:
    """Refuse a user's spring whose stiffness is not the slope of its torque (ValueError).

    Errors of a law, and values that are no numbers, are reported by what uses it.
    """
    try:
        samples = [
            (x, float(law.stiffness(x)), [_slope(law, x, share * room) for share in STEPS]) for x, room in _places(law)
        ]
    except Exception:
        return
    for x, given, slopes in samples:
        if not abs(given) + sum(abs(slope) for slope, _ in slopes) < float("inf"):
            continue
        if all(abs(slope - given) > SLOPE_DIFFERENCE * max(abs(slope), abs(given)) + noise for slope, noise in slopes):
            raise ValueError(
                f"{type(law).__name__}.stiffness at {x:.4g} rad gives {given:.4g} N*m/rad and its torque rises by "
                f"{slopes[1][0]:.4g} N*m/rad there; stiffness(x) must be the derivative of torque(x)"
            )


def _check_polynomial(law: Any) -> None:
    """Refuse a user's spring whose coefficients do not give its torque (ValueError)."""
    coefficients = polynomial_of(law) or ()
    for x, _ in _places(law) if coefficients else ():
        terms = [c * x**k for k, c in enumerate(coefficients)]
        torque = float(law.torque(x))
        if abs(torque - sum(terms)) > COEFFICIENT * sum(map(abs, terms)):
            raise ValueError(
                f"{type(law).__name__}.polynomial gives {sum(terms):.6g} N*m at {x:.4g} rad and its torque is "
                f"{torque:.6g} N*m there; polynomial() must give the coefficients of 1, x, x^2 and so on"
            )


def _places(law: Any) -> Iterator[tuple[float, float]]:
    """Torsions of a law away from its breakpoints, with what is free of them to either side."""
    knots = sorted(map(float, breakpoints_of(law)))
    between = [0.5 * (a + b) for a, b in pairwise(knots) if b > a]
    for x in (*(side * UNROUND * size for size in TORSIONS for side in (1.0, -1.0)), *between):
        room = min([abs(x - knot) for knot in knots] + ([abs(x)] if x != 0.0 else []))
        if room > 0.0:
            yield x, room


def _slope(law: Any, x: float, step: float) -> tuple[float, float]:
    """Central difference of a spring's torque, and what rounding may add to it [N*m/rad]."""
    above, below = float(law.torque(x + step)), float(law.torque(x - step))
    return (above - below) / (2.0 * step), 1e-15 * (abs(above) + abs(below)) / step


def corners_of(model: Any) -> tuple[float, ...]:
    """Corners of a model and of the models in its fields; a model that lists its own speaks for its fields too.

    Corners are base angles [rad; s where omega is 1] at which a function of the base angle jumps or changes its slope.
    A part of a system that does not repeat, a profile of torque or of speed, lists them: `corners()`, a tuple.
    """
    if not isinstance(model, type) and hasattr(model, "corners"):
        return _listed_corners(model)
    return tuple(corner for item in model if isinstance(item, tuple) for corner in corners_of(item))


def _listed_corners(model: Any) -> tuple[float, ...]:
    corners = model.corners()
    try:
        listed = tuple(float(corner) for corner in corners)
    except (TypeError, ValueError):
        listed = (nan,)
    if not all(map(isfinite, listed)):
        name = type(model).__name__
        raise ValueError(f"{name}.corners() gives {shown(corners)}; it must give a tuple of finite base angles")
    return listed


def repeating(verb: str, system: Any) -> Any:
    """Return the system, or refuse one that does not repeat with every turn of the base angle (ValueError)."""
    if corners := corners_of(system):
        raise ValueError(
            f"{type(system).__name__} has a profile with corners at {shown(corners)} s and does not repeat; {verb} "
            "takes what repeats with every turn of the base angle: use simulate or drive_run"
        )
    return system


def is_spring(system: Any) -> bool:
    """True if a system's law depends on the torsion alone, so that its `jacobian` and a balance in x alone hold."""
    return not hasattr(system, "law") or depends(system.law) == 1


def springs_only(verb: str, system: Any) -> None:
    """Refuse a law with friction or memory in a verb whose theory knows springs alone (TypeError)."""
    if not is_spring(system):
        raise TypeError(
            f"{verb} takes a law torque(x) and {type(system.law).__name__} has {KINDS[depends(system.law) - 1]}; use "
            "find_orbit, frequency_response, parameter_response or simulate, which take every law"
        )
