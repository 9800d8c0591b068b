"""Objects of the model as groups of a project file, read and written: {type: linear, K: 7160 N*m/rad}.

`type` is the name of a class of the model; the other fields are the class's own, in the units of their annotations, and
those with a default may be left out. A new law is known here without a line of code. What is wrong with an entry is
collected with its place, all of it.
"""

import difflib
import re
from collections.abc import Collection
from functools import cache
from math import tau
from typing import Any, NamedTuple, get_args, get_origin, get_type_hints

from pydantic_core import PydanticCustomError

from ..base.quantities import checked, example, parse
from ..compile.tree import is_model
from ..model.laws import friction, hysteresis, measured
from ..model.laws import springs as laws
from ..model.train import motion
from ..model.train.controls import PositionLoop, SpeedLoop
from ..model.varying import Ripple, Variation
from .yaml_text import Keys, kind_of, read, shown

SPRINGS = (laws.__name__, measured.__name__)
POSITIVE, NOT_NEGATIVE = ("N*m/rad", "N*m"), ("rad",)  # numbers of a spring, by their unit
EXAMPLE_POINTS = "points such as [[-1 mrad, -90 N*m], [0 mrad, 0 N*m], [1 mrad, 100 N*m]]"
MOST_TURNS = 1000  # of a phase
MOST_SCATTER = 0.3  # beyond it a normal distribution has values near zero
MOST_OF_PHASE = 1.0  # rad
EXAMPLE_LAW = "{type: linear, K: 7160 N*m/rad}"


class Wrong(NamedTuple):
    """One thing that is wrong below an entry: keys from the entry on, a sentence; empty where it was told before."""

    keys: Keys
    sentence: str
    on_key: bool = False


def refusal(*problems: Wrong) -> PydanticCustomError:
    """Error about fields below the one that is being validated."""
    return PydanticCustomError("at", "{problems}", {"problems": problems})


def number(value: Any, unit: str, sign: str = "any") -> float:
    """Read a number with its unit ("any", "positive" or "not negative"), or say what is wrong (ValueError)."""
    if not isinstance(value, str):
        raise ValueError(f"is {kind_of(value)}, not a number with its unit; write {example(unit)}")
    result = parse(value, unit)
    if sign == "positive" and result <= 0.0:
        raise ValueError(f"{value!r} is not positive; write a value above zero")
    if sign == "not negative" and result < 0.0:
        raise ValueError(f"{value!r} is negative; write zero or more")
    most = 1e30 if "rad**" in unit else 1e15  # of a polynomial's coefficients, and of everything else
    if result and not 1.0 / most <= abs(result) <= most:
        raise ValueError(f"{value!r} is beyond any drive; check the number and its unit")
    return result


def phase(value: Any) -> float:
    """Read a phase [rad]: an angle that is told from one more turn (ValueError)."""
    result = number(value, "rad")
    if abs(result) > MOST_TURNS * tau:
        raise ValueError(
            f"{value!r} is more than {MOST_TURNS} turns; write a phase within one turn, for example 90 deg"
        )
    return result


class Radians(float):
    """Standard deviation of a phase [rad], which has no size of its own; those of other numbers are relative."""


def deviation(value: Any) -> float:
    """Read a standard deviation: relative to the number itself, or the angle of a phase (ValueError)."""
    try:
        share = number(value, "", "positive")
    except ValueError:
        if not (isinstance(value, str) and re.search(r"[A-Za-z°]\s*$", value)):
            raise
        angle = number(value, "rad", "positive")
        if angle > MOST_OF_PHASE:
            raise ValueError(f"{value!r} is more than {MOST_OF_PHASE:g} rad; write one standard deviation") from None
        return Radians(angle)
    if share > MOST_SCATTER:
        raise ValueError(f"{value!r} is more than {100 * MOST_SCATTER:g} %; write one standard deviation, as 5 %")
    return share


def deviation_text(size: float) -> str:
    """Text of a standard deviation in a file."""
    return f"{float(size)!r} rad" if isinstance(size, Radians) else repr(size)


def whole(value: Any, what: str = "write for example 2") -> int:
    """Read a whole number, or say that it is none (ValueError)."""
    if not isinstance(value, str) or not re.fullmatch(r"[+-]?[0-9]{1,9}", value.strip()):
        raise ValueError(f"{shown(value)} is not a whole number; {what}")
    return int(value)


def near(value: Any, known: list[str]) -> str:
    """End of a sentence about a word that is not known: the nearest, or else all that are."""
    found = difflib.get_close_matches(str(value).lower().replace("-", "_").replace(" ", "_"), known, n=1)
    return f"; did you mean {found[0]!r}?" if found else f"; write one of {', '.join(known)}"


@cache
def name_of(cls: type) -> str:
    """Name of a class in a project file: "bouc_wen" for `BoucWen`, "lugre" for `LuGre`."""
    return re.sub(r"(?<=[a-z]{3})(?=[A-Z])", "_", cls.__name__).lower()


@cache
def law_types() -> dict[str, type]:
    """Laws by their name in a project file: springs, friction, memory, and what follows a shaft's own angle."""
    found = (c for m in (laws, measured, friction, hysteresis, motion) for c in vars(m).values())
    return {name_of(c): c for c in found if isinstance(c, type) and hasattr(c, "stiffness")}


def loop_types() -> dict[str, type]:
    """Control loops of the motor by their name in a project file."""
    return {name_of(c): c for c in (SpeedLoop, PositionLoop)}


@cache
def fields_of(cls: type) -> dict[str, Any]:
    """Fields of a class in a project file with their annotations; a table is given by its points."""
    return {"points": "points"} if cls is measured.Tabulated else dict(get_type_hints(cls, include_extras=True))


def read_entry(value: Any, known: dict[str, type], for_example: str = EXAMPLE_LAW) -> Any:
    """Read a group of a project file with a `type` as the model object that it describes.

    Raises
    ------
    PydanticCustomError
        With everything that is wrong.
    """
    found: list[Wrong] = []
    model = _typed(value, known, (), found, for_example)
    if found:
        raise refusal(*found)
    return model


def read_ripples(value: Any) -> Variation:
    """Read a list of ripples as the variation of a stiffness or a damping; errors as `read_entry`, and ValueError."""
    found: list[Wrong] = []
    ripples = _items(value, tuple[Ripple, ...], (), found)
    if found:
        raise refusal(*found)
    variation: Variation = checked(Variation(ripples))
    return variation


def _typed(value: Any, known: dict[str, type], keys: Keys, found: list[Wrong], for_example: str = EXAMPLE_LAW) -> Any:
    if is_model(value):  # a law of the user's own, which was read before
        return value
    if not isinstance(value, dict):
        said = f"{shown(value)} is not a group of fields; write for example {for_example}"
        return found.append(Wrong(keys, "" if value is None else said))
    field = (*keys, "type")
    if "type" not in value:
        return found.append(Wrong(field, f"is missing; write one of {', '.join(known)}"))
    word = value["type"]
    plain = word.replace("_", "").lower() if isinstance(word, str) else ""
    cls = next((c for c in known.values() if c.__name__.lower() == plain), None)
    if cls is None:
        said = "" if word is None else f"{shown(word)} is not known{near(word, list(known))}"
        return found.append(Wrong(field, said))
    return of_class({key: item for key, item in value.items() if key != "type"}, cls, keys, found, ("type",))


def of_class(value: Any, cls: Any, keys: Keys, found: list[Wrong], more: tuple[str, ...] = ()) -> Any:
    """Read the fields of a class by its annotations; None with what is wrong, from the entry on, in `found`."""
    if not isinstance(value, dict):
        said = f"{shown(value)} is not a group of fields; write {{{', '.join(fields_of(cls))}}}"
        return found.append(Wrong(keys, "" if value is None else said))
    before, fields = len(found), fields_of(cls)
    for key in value:
        if key not in fields:
            found.append(Wrong((*keys, key), _unknown(key, [*more, *fields]), True))
    given: dict[str, Any] = {}
    for field, hint in fields.items():
        if field in value:
            given[field] = _value(value[field], hint, cls, (*keys, field), found)
        elif field not in cls._field_defaults:
            found.append(Wrong((*keys, field), f"is missing; write it, {_example_of(hint)}"))
    if len(found) > before:
        return None
    try:
        return checked(measured.tabulated(given["points"]) if cls is measured.Tabulated else cls(**given))
    except (TypeError, ValueError) as error:
        below = about(error, cls, given)
        return found.append(below._replace(keys=keys + below.keys))


def about(error: Exception, cls: type, given: Collection[str]) -> Wrong:
    """What is wrong with an object of the model, at its field where the sentence begins with one that was given."""
    text = str(error)
    fields = (field for field in given if text.startswith(f"{cls.__name__}.{field} is "))
    return next((Wrong((f,), text.removeprefix(f"{cls.__name__}.{f} ")) for f in fields), Wrong((), text))


def _unknown(key: str, here: list[str]) -> str:
    spelt = {field.lower(): field for field in here}
    close = difflib.get_close_matches(key.lower(), list(spelt), n=1)
    return f"unknown field; did you mean {spelt[close[0]]!r}?" if close else f"unknown field; known: {', '.join(here)}"


def _value(value: Any, hint: Any, cls: type, keys: Keys, found: list[Wrong]) -> Any:
    """Read one field by its annotation; None with what is wrong in `found`."""
    if value is None:
        return found.append(Wrong(keys, ""))
    if hint is Any:
        return _typed(value, law_types(), keys, found)
    if hint == "points" or get_origin(hint) is tuple:
        return _items(value, hint, keys, found)
    try:
        if hint is int:
            return whole(value)
        if keys[-1] == "phase":
            return phase(value)
        unit, spring = get_args(hint)[1], cls.__module__ in SPRINGS
        sign = "positive" if unit in POSITIVE else "not negative" if unit in NOT_NEGATIVE else "any"
        return number(value, unit, sign if spring else "any")
    except ValueError as error:
        return found.append(Wrong(keys, str(error)))


def _items(value: Any, hint: Any, keys: Keys, found: list[Wrong]) -> Any:
    """Read a list: of points, of coefficients whose unit follows from their place, or of groups."""
    if not isinstance(value, list):
        return found.append(Wrong(keys, f"is {kind_of(value)}; write {_example_of(hint)}"))
    if hint == "points":
        return tuple(_pair(pair, (*keys, i), found) for i, pair in enumerate(value))
    item = get_args(hint)[0]
    if item is not float:
        return tuple(of_class(group, item, (*keys, i), found) for i, group in enumerate(value))
    if not 2 <= len(value) <= 16:
        return found.append(Wrong(keys, f"has {len(value)} items; write {_example_of(hint)}"))
    return tuple(_number(text, _coefficient(i), (*keys, i), found) for i, text in enumerate(value))


def _coefficient(power: int) -> str:
    return ("N*m", "N*m/rad")[power] if power < 2 else f"N*m/rad**{power}"


def _pair(pair: Any, keys: Keys, found: list[Wrong]) -> Any:
    if not isinstance(pair, list) or len(pair) != 2:
        return found.append(Wrong(keys, "is no pair of a torsion and a torque; write [0.54 mrad, 54 N*m]"))
    return tuple(_number(pair[j], unit, (*keys, j), found) for j, unit in enumerate(("rad", "N*m")))


def _number(value: Any, unit: str, keys: Keys, found: list[Wrong]) -> Any:
    try:
        return number(value, unit)
    except ValueError as error:
        return found.append(Wrong(keys, str(error)))


def _example_of(hint: Any) -> str:
    if hint == "points":
        return EXAMPLE_POINTS
    if hint is Any:
        return f"for example {EXAMPLE_LAW}"
    if hint is int:
        return "for example 2"
    if get_origin(hint) is tuple:
        plain = get_args(hint)[0] is float
        return "2 to 16 coefficients, for example [0 N*m, 7160 N*m/rad]" if plain else "for example " + RIPPLES
    return example(get_args(hint)[1])


RIPPLES = "[{order: 2, depth: 5 %}]"


def project_entry(model: Any) -> str:
    """Write a law as the entry of a project file that reads back as the same law.

    Parameters
    ----------
    model : NamedTuple
        A law of this package, of any kind, for `gear: {ratio: 50, law: ...}`; laws inside it too. Fields that have
        their default are left out.

    Returns
    -------
    str
        One line of YAML, for example "{type: cubic, K: 7160.0 N*m/rad, alpha: 0.1 1/rad^2}".

    Raises
    ------
    ValueError
        If it is no such law, a table whose slopes are not those that `tabulated` finds, or one with numbers that a
        project file refuses.
    TypeError
        If it is not a model object.
    """
    text = _entry(checked(model))
    found: list[Wrong] = []
    _typed(read(f"law: {text}").content["law"], law_types() | loop_types(), (), found)
    if found:
        place = " ".join([type(model).__name__, *map(str, found[0].keys)])
        raise ValueError(f"a project file does not take this law: {place} {found[0].sentence}")
    return text


def _entry(model: Any) -> str:
    cls: Any = type(model)
    if cls not in (law_types() | loop_types()).values():
        raise ValueError(
            f"{cls.__name__} is not among the laws of a project file ({', '.join(law_types())}); use it in Python"
        )
    if cls is measured.Tabulated:
        points = [(knot.x, knot.T) for knot in model.knots]
        if measured.tabulated(points) != model:
            raise ValueError("this table has slopes of its own and a project file holds points; use it in Python")
        pairs = ", ".join(f"[{x!r} rad, {T!r} N*m]" for x, T in points)
        return f"{{type: {name_of(cls)}, points: [{pairs}]}}"
    fields = [f"type: {name_of(cls)}"]
    for field, hint in fields_of(cls).items():
        value = getattr(model, field)
        if field not in cls._field_defaults or value != cls._field_defaults[field]:
            fields.append(f"{field}: {_written(value, hint)}")
    return "{" + ", ".join(fields) + "}"


def _written(value: Any, hint: Any) -> str:
    if is_model(value):
        return _entry(value)
    if isinstance(value, tuple):
        return "[" + ", ".join(f"{c!r} {_coefficient(i)}".replace("**", "^") for i, c in enumerate(value)) + "]"
    unit = get_args(hint)[1] if hint is not int else ""
    return f"{value!r} {unit}".rstrip().replace("**", "^")
