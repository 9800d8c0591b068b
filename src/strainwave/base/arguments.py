"""Arguments of public functions, compared with the annotations of their signatures where they enter.

An annotation that says no more than `Any`, or what NumPy can make an array of, lets all pass: the function itself looks
at such a value.
"""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import fields
from fractions import Fraction
from functools import cache, wraps
from inspect import signature
from math import isfinite, nan
from numbers import Integral, Real
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, ParamSpec, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import ArrayLike

from ..compile.tree import is_model, shown
from .quantities import SMALLEST

P = ParamSpec("P")
R = TypeVar("R")
PLAIN: dict[Any, tuple[tuple[type, ...], str]] = {
    bool: ((bool, np.bool_), "True or False"),
    int: ((Integral,), "a whole number"),
    float: ((Real,), "a finite number"),
    str: ((str,), "a text"),
    NoneType: ((NoneType,), "None"),
}
ARRAYS = {each for each in get_args(ArrayLike) if each not in (bool, int, float, complex, str, bytes)}  # its marks
GIVEN = {
    "Project": "what read_project returns",
    "Branch": "what frequency_response returns",
    "Orbit": "what find_orbit returns",
    "DriveResponse": "what Project.response returns",
}


def silent(*_: Any) -> None:
    """Progress of which nobody is told: the default of an argument `progress`."""


def typed(function: Callable[P, R]) -> Callable[P, R]:
    """Let a function refuse arguments of other kinds than its signature says, each in a sentence (TypeError)."""
    places = signature(function)

    @cache
    def kinds() -> dict[str, Any]:
        return get_type_hints(function, include_extras=True)

    @wraps(function)
    def verb(*arguments: P.args, **named: P.kwargs) -> R:
        try:
            bound = places.bind(*arguments, **named)
        except TypeError as error:
            raise TypeError(f"{function.__name__}: {error}; its arguments are {', '.join(places.parameters)}") from None
        given = bound.arguments
        for name, value in given.items():
            refuse(name, value, kind := kinds().get(name, Any))
            given[name] = plain(value, kind)
        return function(*bound.args, **bound.kwargs)

    return verb


def plain(value: Any, kind: Any) -> Any:
    """A number of NumPy or a fraction as one of Python (0 where tiny), an array for a list as a tuple; all else."""
    if isinstance(value, np.ndarray) and value.ndim and any(_is_of(each, Sequence) for each in _asked(kind)):
        return tuple(value.tolist())
    if isinstance(value, np.bool_ | np.integer | np.floating):
        value = value.item() if isinstance(value.item(), bool | int | float) else float(value)
    if isinstance(value, Fraction) and _is_float(value):
        value = float(value)
    return 0.0 if isinstance(value, float) and abs(value) < SMALLEST else value


def refuse(name: str, value: object, kind: object) -> None:
    """Refuse a value of another kind: ValueError where a number or a choice is asked for, else TypeError."""
    if fits(value, kind):
        return
    asked = _asked(kind)
    plain = [each for each in asked if each in (bool, int, float, NoneType) or _is_list(each)]
    if get_origin(kind) is Literal or len(plain) == len(asked):
        raise ValueError(f"{name} is {shown(value)}; it must be {in_words(kind)}")
    raise TypeError(f"{name} is {shown(value)}; give {in_words(kind)}")


def _asked(kind: object) -> tuple[Any, ...]:
    return get_args(kind) if get_origin(kind) in (Union, UnionType) else (kind,)


def _is_of(kind: object, cls: type) -> bool:
    """Whether an annotation with brackets is of a class."""
    form = get_origin(kind)
    return isinstance(form, type) and issubclass(form, cls)


def _is_list(kind: object) -> bool:
    """Whether an annotation asks for numbers or texts in a list, or for a number with a unit."""
    return not _is_of(kind, Mapping) and get_args(kind)[:1] in ((int,), (float,), (str,))


def refuse_fields(thing: Any, *names: str) -> None:
    """Refuse a dataclass with fields (all of them, or these) of other kinds than their annotations say (TypeError).

    Numbers of NumPy, fractions and arrays become what `plain` makes of them.
    """
    kinds = _fields(thing.__class__)
    for name in names or kinds:
        refuse(name, value := getattr(thing, name), kinds[name])
        object.__setattr__(thing, name, plain(value, kinds[name]))


@cache
def _fields(cls: Any) -> dict[str, Any]:
    hints = get_type_hints(cls, include_extras=True)
    return {field.name: hints[field.name] for field in fields(cls)}


def fits(value: Any, kind: Any) -> bool:
    """Whether a value is of the kind of an annotation, as far as it says."""
    form, inner = get_origin(kind), get_args(kind)
    if getattr(value, "ndim", None) == 0 and hasattr(value, "item"):
        value = value.item()  # a number in an array without axes
    if form in (Union, UnionType):
        return bool(ARRAYS & set(inner)) or any(fits(value, each) for each in inner)
    if form is Literal:
        return isinstance(value, str) and value in inner
    if form is Annotated:
        return fits(value, inner[0])
    if kind in PLAIN:
        right = isinstance(value, PLAIN[kind][0]) and (kind is bool or not isinstance(value, bool))
        return right and (kind is not float or _is_float(value))
    if form is not None:
        return _fits_generic(value, form, inner)
    whole = isinstance(kind, type) and kind not in (object, Any) and not getattr(kind, "_is_protocol", False)
    return isinstance(value, kind) if whole else True


def _is_float(value: Any) -> bool:
    """Whether a floating-point number holds a number; none holds one of 400 digits."""
    try:
        float(value)
    except OverflowError:
        return False
    return True


def _fits_generic(value: Any, form: Any, inner: tuple[Any, ...]) -> bool:
    """Whether a value is a mapping, a function or a sequence as an annotation says."""
    if form is np.ndarray or not isinstance(form, type):
        return True
    if form is Callable:
        fixed = bool(inner) and inner[0] is not ...
        return callable(value) and not isinstance(value, type) and (not fixed or takes(value, len(inner[0])))
    if issubclass(form, Mapping):
        return isinstance(value, Mapping) and all(fits(k, inner[0]) and fits(v, inner[1]) for k, v in value.items())
    if not issubclass(form, Iterable):
        return isinstance(value, form)
    if inner and ARRAYS & set(get_args(inner[0])):
        return True  # arrays of arrays are looked at by the function itself
    if isinstance(value, str) and inner[:1] == (str,):
        return True  # what takes names says how a single one is written
    if isinstance(value, str | bytes | Mapping | type) or is_model(value) or not np.iterable(value):
        return False
    if isinstance(value, range) or (isinstance(value, np.ndarray) and not value.dtype.hasobject):
        value = value[:1]  # the others are of the same kind
    item_kind = float if inner[0] is int else inner[0]
    return not (isinstance(value, Collection) and any(not fits(item, item_kind) for item in value))


def takes(function: Any, count: int) -> bool:
    """Whether a function or a method can be called with so many arguments, as far as it says."""
    try:
        signature(function).bind(*range(count))
    except ValueError:  # of a function written in C
        return True
    except TypeError:
        return False
    return True


def number_of(function: Callable[[Any], Any], thing: Any, place: str) -> float:
    """What a function says of something, `place` in words: one finite number (ValueError)."""
    answer = function(thing)
    try:
        value = float(answer)
    except (TypeError, ValueError, OverflowError):
        value = nan
    if not isfinite(value):
        raise ValueError(
            f"the function gives {shown(answer)[:60]} for {place}; give one that has a finite number there"
        )
    return value


def in_words(kind: object) -> str:
    """What an annotation asks for, in words."""
    form, inner = get_origin(kind), get_args(kind)
    if form in (Union, UnionType) and ARRAYS & set(inner):
        return "an array of numbers"
    if form in (Union, UnionType):  # None is what an argument is that is left out
        return " or ".join(dict.fromkeys(in_words(each) for each in inner if each is not NoneType))
    if form is Literal:
        *first, last = map(repr, inner)
        return f"{', '.join(first)} or {last}" if first else last
    if form is Annotated:
        return in_words(inner[0])
    if kind in PLAIN:
        return PLAIN[kind][1]
    if form is Callable:
        fixed = bool(inner) and inner[0] is not ...
        return f"a function of {len(inner[0])} argument{'' if len(inner[0]) == 1 else 's'}" if fixed else "a function"
    if _is_of(kind, Mapping):
        return f"a dictionary: of each name ({in_words(inner[0])}) {in_words(inner[1])}"
    if form is not None:
        plain = not inner or inner[0] in (Any, object)
        return "a list or tuple" if plain else f"a list or tuple, each item {in_words(inner[0])}"
    name = getattr(kind, "__name__", str(kind))
    return GIVEN.get(name, f"{'an' if name[0] in 'AEIO' else 'a'} {name}")
