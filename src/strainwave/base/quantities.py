"""Units of model fields, text with units, and parameters by path.

Inside the package every number is SI and radians (a kinematic error in rad, a speed in rad/s). The unit of a
field lives in its annotation, `Annotated[float, "N*m/rad"]`, where the command line, the project file and the
report read it. `parse` is the only way in for text with units; it refuses what stock unit libraries let pass
(Hz for rad/s, N*m for N*m/rad).
"""

from collections.abc import Callable, Mapping
from functools import cache
from math import inf, isfinite
from numbers import Integral, Real
from typing import Annotated, Any, NamedTuple, TypeVar, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from ..compile.bytecode import is_installed
from ..compile.identity import refuse_changed
from ..compile.jit import enabled
from ..compile.tree import is_model as is_model
from ..compile.tree import joined as joined
from ..compile.tree import leaf_of as leaf_of
from ..compile.tree import leaves, replaced
from ..compile.tree import mapped as mapped
from ..compile.tree import numbers as numbers_of
from ..compile.tree import shown as shown
from .units import convert as convert
from .units import example as example
from .units import parse as parse

T = TypeVar("T")
Angle = Annotated[float, "rad"]
TorsionalStiffness = Annotated[float, "N*m/rad"]
PerSquareRadian = Annotated[float, "1/rad**2"]
Torque = Annotated[float, "N*m"]
Inertia = Annotated[float, "kg*m**2"]
Damping = Annotated[float, "N*m*s/rad"]
AngularSpeed = Annotated[float, "rad/s"]
AngularAcceleration = Annotated[float, "rad/s**2"]
AngularJerk = Annotated[float, "rad/s**3"]
Ratio = Annotated[float, ""]
Time = Annotated[float, "s"]
Rate = Annotated[float, "1/s"]
Order = Annotated[Any, ""]  # an int, or a float that is not whole

Reals = NDArray[np.float64] | float
States = tuple[Reals, ...] | NDArray[np.float64]
"""Numbers or arrays of them, one for each state: a tuple, or an array with the states along its first axis."""

LARGEST, SMALLEST = 1e60, 1e-60  # of a parameter that is not 0: powers of these fit a float


MOST_THINGS = 10**9  # of anything that is counted

DEEPEST = 64  # models inside each other; the compiler writes code for every one


class Parameter(NamedTuple):
    """One number of a model: where it sits, what it is now, and its unit."""

    path: str
    value: float
    unit: str


@cache
def _hints(cls: type) -> dict[str, Any]:
    return get_type_hints(cls, include_extras=True)


def _is_float(hint: object) -> bool:
    return hint is float or (get_origin(hint) is Annotated and get_args(hint)[0] is float)


def _is_whole(value: object) -> bool:
    return isinstance(value, Integral) or (isinstance(value, Real) and bool(value % 1 == 0))


@cache
def _fields(cls: Any) -> list[tuple[str, Any, bool]]:
    """Name and annotation of every field, and whether it holds a float."""
    hints = ((name, _hints(cls).get(name, Any)) for name in cls._fields)
    return [(name, hint, _is_float(hint)) for name, hint in hints]


def _as_annotated(value: Any, hint: Any, field: str) -> Any:
    if hint is Any and is_model(value):
        return _floated(value)
    if get_origin(hint) is tuple:
        if is_model(value) or not isinstance(value, list | tuple):
            raise TypeError(f"{field} must be a tuple, not {shown(value)}; write a single item as (item,)")
        return _of_one_kind(tuple(_as_annotated(item, get_args(hint)[0], field) for item in value))
    if _is_float(hint) or hint == Order:
        if not isinstance(value, Real):
            raise TypeError(f"{field} must be a number, not {shown(value)}")
        number = _as_float(field, value)
        return int(number) if hint == Order and isfinite(number) and _is_whole(value) else number
    if hint is int:
        if not _is_whole(value):
            base = "; take a base angle on which it is, for a gear the output turn" if field.endswith(".order") else ""
            raise ValueError(f"{field} must be a whole number, not {shown(value)}{base}")
        return int(value)
    as_text = isinstance(value, str) and value[:1] in tuple("+-.0123456789")
    if hint is Any and (as_text or isinstance(value, list | dict | np.ndarray)):
        raise TypeError(f"{field} is {shown(value)}; a model holds numbers, other models and tuples of these")
    if hint is not Any and isinstance(hint, type) and not isinstance(value, hint):
        raise TypeError(f"{field} must be a {hint.__name__}, not {shown(value)}")
    return _floated(value) if is_model(value) else value.item() if isinstance(value, np.integer) else value


def _of_one_kind(items: tuple[Any, ...]) -> tuple[Any, ...]:
    """Models of one class with equal kinds of numbers, which compiled code loops over: floats where one has a float."""
    if not (items and is_model(items[0])):
        return items
    if len({type(item) for item in items}) > 1 or len({tuple(map(type, item)) for item in items if is_model(item)}) < 2:
        return items
    rows = zip(*items, strict=True)
    columns = [map(float, row) if {*map(type, row)} == {int, float} else row for row in rows]
    return tuple(type(items[0])(*row) for row in zip(*columns, strict=True))


def _refuse_deep(model: Any) -> None:
    level = [model]
    for _ in range(DEEPEST):
        level = [item for thing in level for item in thing if isinstance(item, tuple)]
        if not level:
            return
    raise ValueError(
        f"{type(model).__name__} holds models nested more than {DEEPEST} deep; put fewer laws side by side, laws of "
        "one kind often add up to one"
    )


def floated(model: T) -> T:
    """Return `model` with ints turned to floats in its float fields, at any depth.

    `Cubic(1, 0.1)` and `Cubic(1.0, 0.1)` are then one type to the compiler. Integer fields (orders) stay integers.

    Raises
    ------
    TypeError
        If `model` is no NamedTuple or a field holds something of another kind than its annotation says.
    ValueError
        If an integer field holds a number that is not whole, or models are nested more than 64 deep.
    """
    if not is_model(model):
        raise TypeError(f"a model object is a NamedTuple, such as Oscillator(...), not {shown(model)}")
    _refuse_deep(model)
    floats: T = _floated(model)
    return floats


def _floated(model: Any) -> Any:
    cls: Any = type(model)
    fields = zip(model, _fields(cls), strict=True)
    return cls(
        *[
            value if is_float and type(value) is float else _as_annotated(value, hint, f"{cls.__name__}.{name}")
            for value, (name, hint, is_float) in fields
        ]
    )


def checked(model: T) -> T:
    """Return `floated(model)` after checking it; every verb that takes a model calls this once.

    All numbers must be finite and 0 or of a size from 1e-60 to 1e60, whole ones up to 2^53, and no tuple empty; for the
    rest a model may have a method `check()` that raises a ValueError with one sentence.

    Raises
    ------
    TypeError, ValueError
        With one sentence on what is wrong with which field.
    """
    model = floated(model)
    _check(model)
    return model


def _largest(item: float) -> float:
    """Size up to which a number of a model is held: of a whole one that which floats tell apart from the next."""
    return 2**53 if isinstance(item, int) else LARGEST


def _check(model: Any) -> None:
    if not is_installed(type(model).__module__) and enabled():
        refuse_changed(type(model))
    small = ""
    for name, value in zip(model._fields, model, strict=True):
        items = value if isinstance(value, tuple) and not is_model(value) else (value,)
        if not items:
            raise ValueError(f"{type(model).__name__}.{name} is empty; it needs at least one item")
        for item in items:
            if is_model(item):
                _check(item)
            elif isinstance(item, float | int) and not abs(item) <= (largest := _largest(item)):
                limit = f"not exceed {largest:g} in SI units" if abs(item) < inf else "be finite"
                raise ValueError(f"{type(model).__name__}.{name} is {shown(value)}; it must {limit}")
            elif isinstance(item, float) and 0.0 < abs(item) < SMALLEST:
                bounds = f"it must be 0, or from {SMALLEST:g} in size, in SI units"
                small = f"{type(model).__name__}.{name} is {shown(value)}; {bounds}"
    if hasattr(model, "check"):
        model.check()
    if small:  # last: a field that has a reason of its own says it
        raise ValueError(small)


def parameters(model: Any) -> list[Parameter]:
    """List every number of a model with its path ("law.alpha", "error.lines.0.amplitude") and unit."""
    return [Parameter(path, value, _unit(type(owner), name)) for path, owner, name, value in numbers_of(model)]


def _unit(cls: type[Any], name: str) -> str:
    metadata = get_args(_hints(cls).get(name)) if issubclass(cls, tuple) and cls is not tuple else ()
    return metadata[1] if len(metadata) > 1 else ""


def replace(model: Any, changes: Mapping[str, Any]) -> Any:
    """Return `model` with the parameters at the given paths changed.

    Parameters
    ----------
    model : NamedTuple
        Any system, law or excitation.
    changes : dict
        Path to new value (SI units), for example ``{"law.alpha": 2.0, "error.lines.0.amplitude": 1e-4}``.

    Raises
    ------
    ValueError
        If a path does not exist; the sentence lists what does. If a number is NaN then.
    TypeError
        If `model` is no model.
    """
    if not is_model(model):
        raise TypeError(f"a model object is a NamedTuple, such as Oscillator(...), not {shown(model)}")
    for path, value in changes.items():
        model = replaced(model, path, value)
    if any(np.any(leaf != leaf) for leaf in leaves(model)):
        raise ValueError(f"{shown(model)} has NaN as a number; give finite ones")
    return model


def _as_float(name: str, value: Any) -> float:
    try:
        return float(value)
    except OverflowError:
        raise ValueError(f"{name} is {shown(value)}; it is too large for a floating-point number") from None


def number(name: str, value: object, *, positive: bool = False) -> float:
    """Return a number, 0 (not: positive) or from SMALLEST to LARGEST, or say that `name` is none."""
    good = isinstance(value, Real) and not isinstance(value, bool)
    result = _as_float(name, value) if good else 0.0
    if not (good and isfinite(result) and (result > 0.0 or not positive)):
        raise ValueError(f"{name} is {shown(value)}; it must be a {'positive ' if positive else ''}finite number")
    if result != 0.0 and not SMALLEST <= abs(result) <= LARGEST:
        bounds = f"{'' if positive else '0, or '}from {SMALLEST:g} to {LARGEST:g}"
        raise ValueError(f"{name} is {shown(value)}; it must be {bounds} in size, in SI units")
    return result


def number_of(function: Callable[[Any], Any], thing: Any, subject: str) -> float:
    """Value of a function of a thing, called `subject` in an error: one finite number (ValueError)."""
    value = float(function(thing))
    if not isfinite(value):
        raise ValueError(f"the function gives {value} for {subject}; give one that has a finite number there")
    return value


def reals(values: object) -> NDArray[np.float64]:
    """Real numbers as a new array (0 where below SMALLEST); none of texts, dates, masked ones."""
    try:
        array = np.array(values)
        if array.dtype.kind not in "biufO" or np.ma.is_masked(values):
            return np.empty(0)
        with np.errstate(all="ignore"):
            array = array.astype(float)
            return np.where(np.abs(array) < SMALLEST, 0.0, array)
    except (TypeError, ValueError, OverflowError):  # of rows of different lengths, and of others than numbers
        return np.empty(0)


def numbers(
    name: str, values: object, *, count: int | None = None, largest: float = LARGEST
) -> NDArray[np.float64]:  # fmt: skip
    """Return one or more finite numbers (exactly `count`) as a new array (n,), or say that `name` are none."""
    array = np.atleast_1d(reals(values))
    if array.ndim != 1 or array.size == 0 or count not in (None, array.size) or not np.all(np.isfinite(array)):
        raise ValueError(f"{name} is {shown(values)}; it must be {count or 'one or more'} finite numbers")
    if not np.all(np.abs(array) <= largest):
        raise ValueError(f"{name} is {shown(values)}; it must be numbers up to {largest:g} in size, in SI units")
    return array


def probabilities(name: str, values: object) -> NDArray[np.float64]:
    """Return numbers from 0 to 1 as a new array (n,), or say that `name` are none."""
    array = numbers(name, values)
    if not np.all((array >= 0.0) & (array <= 1.0)):
        raise ValueError(f"{name} is {shown(values)}; it must be from 0 to 1")
    return array


def array_of(name: str, values: object, *shape: int | None) -> NDArray[np.float64]:
    """Return finite numbers as a new array of a shape (None: any length; no shape: any), or say that they are none."""
    array = reals(values)
    right = not shape or (
        array.ndim == len(shape) and all(m in (None, n) for n, m in zip(array.shape, shape, strict=True))
    )
    if array.size == 0 or not right or not np.all(np.abs(array) <= LARGEST):
        form = f" of the shape ({', '.join('n' if n is None else str(n) for n in shape)})" if shape else ""
        raise ValueError(f"{name} is {shown(values)}; it must be finite numbers{form}")
    return array


def samples_of(name: str, values: object) -> NDArray[np.float64]:
    """Return numbers of any shape, NaN and none at all too, as a new array, or say that `name` are no numbers."""
    array = reals(values)
    if np.any(np.abs(array) > LARGEST):
        raise ValueError(f"{name} is {shown(values)}; its numbers must be of a size up to {LARGEST:g} in SI units")
    if array.size == 0 and np.size(values):  # type: ignore[arg-type]
        raise ValueError(f"{name} is {shown(values)}; it must be an array of numbers")
    return array


def complex_number(name: str, value: complex) -> complex:
    """Return a finite complex number of a size up to `LARGEST`, or say that `name` is none."""
    if not abs(value) <= LARGEST:
        raise ValueError(f"{name} is {shown(value)}; it must be one finite number, real or complex")
    return complex(value)


def complex_numbers(name: str, values: object) -> NDArray[np.complex128]:
    """Return finite complex numbers of a size up to `LARGEST` as a new array of any shape, or say what `name` is."""
    array = np.array(values, complex)
    if array.size == 0 or not np.all(np.abs(array) <= LARGEST):
        raise ValueError(f"{name} is {shown(values)}; it must be finite numbers, real or complex")
    return np.asarray(array)


def positive_count(name: str, value: Any, largest: int = MOST_THINGS) -> int:
    """Return a whole number from 1 to `largest`, or say in one sentence that `name` is none."""
    if whole(name, value, 1) > largest:
        raise ValueError(f"{name} is {shown(value)}; it must be at most {largest}")
    return int(value)


def whole(name: str, value: object, least: int = 0) -> int:
    """Return a whole number from `least` on, such as a seed, or say in one sentence that `name` is none."""
    if not isinstance(value, Integral) or isinstance(value, bool) or int(value) < least:
        raise ValueError(f"{name} is {shown(value)}; it must be a whole number of at least {least}")
    return int(value)


def choice(name: str, value: object, *choices: str) -> None:
    """Refuse what is none of the choices (ValueError)."""
    if value not in choices:
        *first, last = map(repr, choices)
        raise ValueError(f"{name} is {shown(value)}; it must be {', '.join(first)} or {last}")


def index(name: str, value: object, count: int, things: str) -> int:
    """Return a whole number that counts things from either end, or say that `name` is none."""
    if not isinstance(value, Integral) or isinstance(value, bool) or int(value) not in range(-count, count):
        raise ValueError(f"{name} is {shown(value)}; it must be from {-count} to {count - 1}, of {count} {things}")
    return int(value)


def interval(name: str, span: Any, *, positive: bool = False) -> tuple[float, float]:
    """Return two finite numbers in rising order (both positive), or say that `name` is no such interval."""
    lo, hi = map(float, span) if np.shape(span) == (2,) else (0.0, 0.0)
    if not (isfinite(lo) and isfinite(hi) and lo < hi):
        raise ValueError(f"{name} is {shown(span)}; it must be two finite numbers (low, high) with low < high")
    if positive and not lo > 0.0:
        raise ValueError(f"{name} is {lo:g} .. {hi:g}; it must be 0 < low < high")
    if not all(v == 0.0 or SMALLEST <= abs(v) <= LARGEST for v in (lo, hi)):
        raise ValueError(f"{name} is {lo:g} .. {hi:g}; its ends must be from {SMALLEST:g} to {LARGEST:g} in size, or 0")
    if hi - lo < 1e-9 * max(abs(lo), abs(hi)):
        raise ValueError(f"{name} is {lo!r} .. {hi!r}; its ends must be at least 1e-9 of them apart, or take one value")
    return lo, hi
