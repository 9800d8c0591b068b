"""Fields of a file, one row each: what reads it, an example, a sentence, and what holds without it.

Reader, complaints, JSON Schema, reference page, template, page form, names of a sweep and writer follow from the rows.
A group of fields is a class with rows (`Group`), or a class of the model, whose rows are its annotations.
"""

import difflib
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, ClassVar, Literal, get_args, get_origin, get_type_hints

from ...base.quantities import checked, is_model
from ...model.laws import friction, hysteresis, measured, rounded, springs
from ...model.train import motion
from ...model.train.filters import FILTERS
from ..yaml_text import Located, Problem, kind_of, name, shown
from . import kinds
from .kinds import Entry, Items, Kind, NotOfKind, Quantity, Row, Schema, Wrong, read

SPRINGS = (springs.__name__, rounded.__name__, measured.__name__)
SIGN_OF = {"N*m/rad": "positive", "N*m": "positive", "rad": "not negative"}  # of numbers of a spring, by their unit
TYPE = "Kind of the entry."
EXAMPLE_LAW = "{type: linear, K: 7160 N*m/rad}"
LINES = Path(__file__).with_name("descriptions.txt").read_text(encoding="utf-8").splitlines()
DESCRIPTIONS = dict(line.split(": ", 1) for line in LINES if line[:1] != "#")  # of fields of the model's classes


def field(kind: Any, example: str, description: str = "", default: Any = None) -> Any:
    """Row of a field that may be left out; a class stands for the group of its fields and says what its name says."""
    of = Fields(kind) if isinstance(kind, type) else kind
    return Row(of, example, description or line_of(kind), default)


def needed(kind: object, example: str, description: str = "") -> Any:
    """Row of a field that must be given."""
    return field(kind, example, description)._replace(needed=True)


class Group:
    """A group of fields of a file; `given` are the names of those that the file gives."""

    conditions: ClassVar[Schema] = {}  # between the fields, of the JSON Schema

    def __init__(self, **given: Any) -> None:
        self.given = {key for key, value in given.items() if value is not None}
        cls: Any = type(self)
        for key, row in rows_of(cls).items():
            attribute = key if hasattr(cls, key) else f"{key}_"
            setattr(self, attribute, given[key] if key in given else row.without())

    def check(self) -> Iterable[Wrong]:
        """Faults between the fields; a ValueError does as well."""
        return ()


@cache
def rows_of(cls: type[Any]) -> dict[str, Row]:
    """Rows of a class by the names that a file has: its own, or those of a model's annotations."""
    if not issubclass(cls, Group):
        return _rows_of_model(cls)
    attributes = {key: row for base in reversed(cls.__mro__) for key, row in vars(base).items()}
    return {key.rstrip("_"): row for key, row in attributes.items() if isinstance(row, Row)}


def _rows_of_model(cls: type[Any]) -> dict[str, Row]:
    """Rows of a class of the model; a table is given by its points."""
    table = cls is measured.Tabulated
    hints, defaults = {"points": None} if table else get_type_hints(cls, include_extras=True), cls._field_defaults
    return {
        key: Row(
            Points() if table else _kind_of(hint, cls, key),
            description=DESCRIPTIONS.get(f"{cls.__name__}.{key}") or DESCRIPTIONS.get(key, ""),
            default=defaults.get(key),
            needed=key not in defaults,
        )
        for key, hint in hints.items()
    }


def _kind_of(hint: object, cls: type, key: str) -> Kind:
    """Kind of a field of a model's class, by its annotation."""
    if hint is Any:
        return LAW
    if get_origin(hint) is tuple:
        item = get_args(hint)[0]
        return Coefficients() if item is float else Items(Fields(item))
    if get_origin(hint) is Literal:
        return kinds.Word(get_args(hint))
    if hint is str:
        return kinds.FILE_NAME
    if hint is int:
        return kinds.Whole(1 if key in ("n", "order") else None)
    unit = get_args(hint)[1]
    if unit == "rad/s" and cls in FILTERS:
        return kinds.BANDWIDTH
    if unit == "1/s":
        return Quantity(unit, "positive", check=no_frequency)
    if cls in FILTERS or key == "T_n":
        return Quantity(unit, "not negative" if key in ("depth", "zero_damping") else "positive")
    if key == "phase":
        return kinds.PHASE
    return Quantity(unit, SIGN_OF.get(unit, "any") if cls.__module__ in SPRINGS else "any")


def no_frequency(_: float, text: str) -> None:
    """Refuse a gain in Hz (ValueError)."""
    if "hz" in text.lower():
        raise ValueError(f"{text!r} may be turns or radians a second; write it in 1/s, for example 30 1/s")


def line_of(thing: object) -> str:
    """First line of the docstring."""
    return " ".join((thing.__doc__ or "").split("\n")[0].split())


@dataclass(frozen=True)
class Fields(Kind):
    """A group of the fields of a class; `ref` is the name of its JSON Schema where that stands apart."""

    cls: Any
    ref: str = ""

    def read(self, value: object, entry: Entry) -> Any:
        return read_group(value, self.cls, entry)

    def schema(self) -> Schema:
        return {"$ref": f"#/$defs/{self.ref}"} if self.ref else schema_of(self.cls)

    def text(self, value: object) -> str:
        return group_text(value)

    def part(self, value: object, key: str) -> Row | None:
        return rows_of(self.cls).get(key)


@cache
def name_of(cls: type) -> str:
    """Name of a class in a project file: "bouc_wen" for `BoucWen`, "lugre" for `LuGre`."""
    return re.sub(r"(?<=[a-z]{3})(?=[A-Z])", "_", cls.__name__).lower()


@cache
def law_types() -> dict[str, type]:
    """Laws by their name in a project file: springs, friction, memory, and what follows a shaft's own angle."""
    modules = springs, rounded, measured, friction, hysteresis, motion
    classes = (c for m in modules for c in vars(m).values() if getattr(c, "__module__", "") == m.__name__)
    return {name_of(c): c for c in classes if hasattr(c, "_fields") and hasattr(c, "stiffness")}


@dataclass(frozen=True)
class Typed(Kind):
    """A group with a `type`, the name of a class of the model whose fields are the others."""

    types: Callable[[], dict[str, type]] = law_types
    ref: str = "law"
    wrong: Callable[[Any], Iterable[Wrong]] | None = None  # with what was read

    def read(self, value: object, entry: Entry) -> Any:
        model = value if is_model(value) else self._typed(value, entry)  # a law of the user's own was read before
        if model is not None and self.wrong is not None:
            entry.faults.extend(wrong._replace(keys=(*entry.keys, *wrong.keys)) for wrong in self.wrong(model))
        return model

    def _typed(self, value: object, entry: Entry) -> Any:
        if not isinstance(value, dict):
            raise NotOfKind("a group of fields")
        types, type_entry = self.types(), entry.inside("type")
        if "type" not in value:
            return type_entry.wrong(f"is missing; write one of {', '.join(types)}")
        word = value["type"]
        cls = self.of(word)
        if cls is None:
            unknown = f"{shown(word)} is not known{kinds.suggestion(word, list(types))}"
            return type_entry.wrong("" if word is None else unknown)
        return read_group({key: item for key, item in value.items() if key != "type"}, cls, entry, ("type",))

    def of(self, word: object) -> type | None:
        """The class of a type, in any spelling of its name."""
        plain = re.sub("[-_]", "", word).lower() if isinstance(word, str) else ""
        return next((cls for key, cls in self.types().items() if key.replace("_", "") == plain), None)

    def schema(self) -> Schema:
        return {"$ref": f"#/$defs/{self.ref}"}

    def example(self) -> str:
        return f"for example {EXAMPLE_LAW}"

    def text(self, value: object) -> str:
        named = next((key for key, cls in self.types().items() if cls is type(value)), "")
        if not named:
            remedy = f"the laws of a project file ({', '.join(self.types())}); use it in Python"
            raise ValueError(f"{type(value).__name__} is not among {remedy}")
        if isinstance(value, measured.Tabulated):
            points = [(knot.x, knot.T) for knot in value.knots]
            if measured.tabulated(points) != value:
                raise ValueError("this table has slopes of its own and a project file holds points; use it in Python")
            return f"{{type: {named}, points: {Points().text(points)}}}"
        return group_text(value, named)

    def part(self, value: object, key: str) -> Row | None:
        cls = self.of(value.get("type")) if isinstance(value, dict) else None
        return rows_of(cls).get(key) if cls else None


LAW = Typed()


@dataclass(frozen=True)
class Coefficients(Kind):
    """Coefficients of a polynomial, whose unit follows from their place."""

    def read(self, value: object, entry: Entry) -> Any:
        if not isinstance(value, list) or not 2 <= len(value) <= 16:
            what = f"has {len(value)} items" if isinstance(value, list) else f"is {kind_of(value)}"
            raise ValueError(f"{what}; write {self.example()}")
        return tuple(read(self._of(i), item, entry.inside(i)) for i, item in enumerate(value))

    def _of(self, power: int) -> Quantity:
        return Quantity(("N*m", "N*m/rad")[power] if power < 2 else f"N*m/rad**{power}")

    def schema(self) -> Schema:
        one = {"type": "string", "pattern": "^\\s*[+\\-−]?[0-9.].*[Nl]"}
        return {"type": "array", "items": one, "minItems": 2, "maxItems": 16}

    def text(self, value: Any) -> str:
        return f"[{', '.join(self._of(i).text(c) for i, c in enumerate(value))}]"

    def example(self) -> str:
        return "2 to 16 coefficients, for example [0 N*m, 7160 N*m/rad]"


@dataclass(frozen=True)
class Points(Kind):
    """Pairs of a torsion and a torque, or of others."""

    units: tuple[str, str] = ("rad", "N*m")
    pair: str = "a torsion and a torque; write [0.54 mrad, 54 N*m]"

    def read(self, value: object, entry: Entry) -> Any:
        if not isinstance(value, list):
            raise ValueError(f"is {kind_of(value)}; write {self.example()}")
        return tuple(self._pair(pair, entry.inside(i)) for i, pair in enumerate(value))

    def _pair(self, pair: object, entry: Entry) -> Any:
        if not isinstance(pair, list) or len(pair) != 2:
            return entry.wrong(f"is no pair of {self.pair}")
        return tuple(read(Quantity(unit), pair[j], entry.inside(j)) for j, unit in enumerate(self.units))

    def schema(self) -> Schema:
        pair = [Quantity(unit).schema() for unit in self.units]
        one = {"type": "array", "prefixItems": pair, "minItems": 2, "maxItems": 2}
        return {"type": "array", "items": one, "minItems": 2}

    def text(self, value: Any) -> str:
        first, second = self.units
        return f"[{', '.join(f'[{a!r} {first}, {b!r} {second}]' for a, b in value)}]"

    def example(self) -> str:
        return "points such as [[-1 mrad, -90 N*m], [0 mrad, 0 N*m], [1 mrad, 100 N*m]]"


def schema_of(cls: Any, named: str = "", also: Schema | None = None) -> Schema:
    """JSON Schema of the fields of a class, with its `type` where it has a name."""
    rows = rows_of(cls)
    kind: Schema = {"type": {"const": named, "description": TYPE}} if named else {}
    needs = ["type"] * bool(named) + [key for key, row in rows.items() if row.needed]
    properties = {**kind, **{key: row.schema() for key, row in rows.items()}, **(also or {})}
    schema: Schema = {"type": "object", "properties": properties, "additionalProperties": False}
    of_file = cls.conditions if issubclass(cls, Group) else {"description": line_of(cls)}
    return schema | ({"required": needs} if needs else {}) | of_file


def group_text(value: object, named: str = "") -> str:
    """A group as a file has it: the fields that are given, of a model those that differ from their defaults."""
    parts = [f"type: {named}"] if named else []
    return "{" + ", ".join(parts + [f"{key}: {text}" for key, text in texts_of(value).items()]) + "}"


def texts_of(value: object) -> dict[str, str]:
    """Texts of the fields of a group that are given, of a model of those that differ from their defaults, by name."""
    cls: Any = type(value)
    texts = {}
    for key, row in rows_of(cls).items():
        part = getattr(value, key if hasattr(value, key) else f"{key}_")
        if part is not None and (key in value.given if isinstance(value, Group) else row.needed or part != row.default):
            texts[key] = row.kind.text(part)
    return texts


def read_group(value: object, cls: type[Any], entry: Entry, former: tuple[str, ...] = ()) -> Any:
    """Read the fields of a class; None where something is wrong. Fields of `former` were read before."""
    before = len(entry.faults)
    values = _given(value, cls, entry, former)
    if len(entry.faults) > before:
        return None
    try:
        if issubclass(cls, Group):
            group = cls(**values)
            entry.faults.extend(wrong._replace(keys=(*entry.keys, *wrong.keys)) for wrong in group.check())
            return group
        return checked(measured.tabulated(**values) if cls is measured.Tabulated else cls(**values))
    except (TypeError, ValueError) as error:
        text = str(error)
        match = re.match(r"\w+\.(\w+) (?=is )", text)
        if match and match[1] in values:
            return entry.inside(match[1]).wrong(text[match.end() :])
        return entry.wrong(text)


def _given(value: object, cls: Any, entry: Entry, former: tuple[str, ...] = ()) -> dict[str, Any]:
    """Values of the fields that a file gives, None for a wrong one."""
    if not isinstance(value, dict):
        raise NotOfKind("a group of fields")
    rows = rows_of(cls)
    for key in value:
        if key not in rows:
            entry.inside(key).wrong(_unknown(key, [*former, *rows], rows, entry), on_key=True)
    values = {}
    for key, row in rows.items():
        field_entry = entry.inside(key, row.example)
        if key in value:
            values[key] = read(row.kind, value[key], field_entry)
        elif row.needed:
            field_entry.wrong(f"is missing; {field_entry.remedy(row.kind)}")
    return values


def _unknown(key: str, fields: list[str], rows: dict[str, Row], entry: Entry) -> str:
    """Sentence for a field that nobody knows: the nearest field, else that whose description has the word, else all."""
    spelt = {field.lower(): field for field in (*entry.top, *fields)}
    close = difflib.get_close_matches(key.lower(), list(spelt), n=1)
    if close and spelt[close[0]] in fields:
        return f"unknown field; did you mean {spelt[close[0]]!r}?"
    if close:
        return f"unknown field; did you mean {close[0]!r}? It belongs to the top level, not to {name(entry.keys)!r}"
    for field, row in rows.items():
        if len(key) > 3 and row.example and re.search(rf"\b{re.escape(key)}\b", row.description, re.IGNORECASE):
            return f"unknown field; see {field!r} ({row.description.removesuffix('.')}), as {field}: {row.example}"
    return f"unknown field; known here: {', '.join(fields)}"


def problems_of(faults: Iterable[Wrong], located: Located) -> Iterator[Problem]:
    """Problems of faults, with their positions in a file."""
    for keys, sentence, on_key in faults:
        if sentence:
            yield Problem(*(located.keys[keys] if on_key else located.position(keys)), name(keys), sentence)


def read_file(content: Any, cls: Any, located: Located) -> tuple[Any, list[Problem]]:
    """Read the content of a file; fields that are wrong are None, and what holds no fields at all gives none."""
    rows, faults, problems = rows_of(cls), list[Wrong](), list(located.problems)
    if content is None and problems:
        return None, problems
    try:
        values = _given(content, cls, Entry((), faults, "", tuple(rows)))
    except NotOfKind:
        first = next(key for key, row in rows.items() if row.needed)
        fact = "is empty" if content is None else f"holds {shown(content)}, not fields"
        sentence = f"{fact}; begin with a line such as '{first}: {rows[first].example}'"
        return None, [*problems, Problem(*located.position(()), "file", sentence)]
    defaults = {key: None for key, row in rows.items() if row.needed}
    return cls(**defaults | values), [*problems, *problems_of(faults, located)]


def row_at(cls: type[Any], content: object, keys: Iterable[str]) -> Row | None:
    """The row of a field by its path in the content of a file; None where the path leads to no field."""
    row: Row | None = Row(Fields(cls))
    for key in keys:
        row = row and row.kind.part(content, key)
        content = inside(content, key)
    return row


def inside(content: object, key: str) -> Any:
    """Value of a key of a group or a list; None where there is none."""
    if isinstance(content, list):
        return content[int(key)] if key.isdecimal() and int(key) < len(content) else None
    return content.get(key) if isinstance(content, dict) else None
