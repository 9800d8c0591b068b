"""Kinds of field in a file: a number with its unit, a word, a text, a list, or one of two kinds.

A kind reads the value of a field and writes it again, and gives its JSON Schema, unit and sign.
"""

import difflib
import json
import re
from collections.abc import Callable
from dataclasses import dataclass
from math import tau
from typing import Any, NamedTuple

from ...base.quantities import example, parse
from ...model.gears.gear import SPECIAL
from ..yaml_text import Keys, kind_of, shown

Schema = dict[str, Any]
MOST_TURNS = 1000  # of a phase
ANGLE = "(rad|deg|°|arc|rev|turn|[\"'′″])"
HINTS = {  # pattern in the text of a unit, of the JSON Schema
    "rad": ANGLE + "[^/]*$",
    "rad/s": f"({ANGLE}|rpm)",
    "N*m": "(N|lb|oz|gf)",
    "kg*m**2": "(g|lb|oz)",
    "s": "(s|min|h)",
    "1/s": "(/ *s|s *\\^ *-1|s⁻¹)",
    "Hz": "(Hz|rad)",
    "K": "K",
}
SIGNS = {"any": "[+\\-−]?", "positive": "\\+?(?=[^A-Za-z]*[1-9])", "not negative": "\\+?"}
LOW: dict[str, Schema] = {"any": {}, "positive": {"exclusiveMinimum": 0}, "not negative": {"minimum": 0}}
RANGES = {"any": "", "positive": "above 0", "not negative": "from 0"}


class Wrong(NamedTuple):
    """One fault below an entry: keys from the entry on, and a sentence, empty for a fault that is reported already."""

    keys: Keys
    sentence: str
    on_key: bool = False


class NotOfKind(ValueError):
    """A value of another kind than the argument names, such as "a list"; the complaint gives the example of the row."""


class Entry(NamedTuple):
    """Entry of a file while it is read.

    It has its keys, the list of all faults so far, an example of its value, and the fields at the top of the file.
    """

    keys: Keys
    faults: list[Wrong]
    example: str = ""
    top: tuple[str, ...] = ()

    def inside(self, key: str | int, example: str = "") -> "Entry":
        """Entry of a field or an item inside, with its example."""
        return self._replace(keys=(*self.keys, key), example=example)

    def wrong(self, sentence: str, *, on_key: bool = False) -> None:
        """Add a sentence about this entry, or about its key."""
        self.faults.append(Wrong(self.keys, sentence, on_key))

    def remedy(self, kind: "Kind") -> str:
        """Remedy for this entry: the example of the row, or else of the kind."""
        if not self.example:
            return f"write it, {kind.example()}"
        key = self.keys[-1] if self.keys else 0
        return f"write for example {self.example if isinstance(key, int) else repr(f'{key}: {self.example}')}"


class Kind:
    """Kind of what a field may hold, with the unit and the sign ("any", "positive", "not negative") of a number."""

    unit: str = ""
    sign: str = "any"

    def read(self, value: object, entry: Entry) -> Any:
        """The value in SI; a fault is raised (ValueError), or added to the entry."""
        raise NotImplementedError

    def schema(self) -> Schema:
        """JSON Schema of the field."""
        raise NotImplementedError

    def text(self, value: Any) -> str:
        """The value as a file has it."""
        return str(value)

    def example(self) -> str:
        """Example of a value, for a field whose row has none."""
        return example(self.unit)

    def part(self, value: object, key: str) -> "Row | None":
        """Row of a field inside a value of the file; None where it has none."""
        return None


class Row(NamedTuple):
    """A field: its kind, an example, a description, and its value where a file does not give it, or that as text."""

    kind: Kind
    example: str = ""
    description: str = ""
    default: Any = None
    needed: bool = False

    def without(self) -> Any:
        """Value of the field where the file does not give it."""
        return self.kind.read(self.default, Entry((), [])) if isinstance(self.default, str) else self.default

    def schema(self) -> Schema:
        """JSON Schema with the sentence, the unit and the range."""
        inside = self.kind.schema()
        unit, span = inside.get("x-unit", "1"), inside.get("x-range", "")
        text = (
            self.description.removesuffix(".") + (f" [{unit}]" if unit != "1" else "") + (f", {span}." if span else ".")
        )
        schema: Schema = {"description": text} | inside | {"description": text}
        if isinstance(self.default, int | float | str) and self.default != "":
            plain = isinstance(self.default, str) or unit == "1"
            schema["default"] = self.default if plain else f"{self.default:g} {unit}"
        return schema


def number(value: object, unit: str, sign: str = "any") -> float:
    """Read a number with its unit ("any", "positive" or "not negative"), or say what is wrong (ValueError)."""
    if not isinstance(value, str):
        raise ValueError(f"is {kind_of(value)}, not a number with its unit; write {example(unit)}")
    result = parse(value, unit)
    if sign == "positive" and result <= 0.0:
        raise ValueError(f"{value!r} is not positive; write a value above zero")
    if sign == "not negative" and result < 0.0:
        raise ValueError(f"{value!r} is negative; write zero or more")
    largest = 1e30 if "rad**" in unit else 1e15  # of a polynomial's coefficients, and of everything else
    if result and not 1.0 / largest <= abs(result) <= largest:
        raise ValueError(f"{value!r} is outside any realistic range; check the number and its unit")
    return result


def suggestion(value: object, words: list[str]) -> str:
    """End of a sentence about an unknown word: the closest of the known words, or else all of them."""
    matches = difflib.get_close_matches(str(value).lower().replace("-", "_").replace(" ", "_"), words, n=1)
    return f"; did you mean {matches[0]!r}?" if matches else f"; write one of {', '.join(words)}"


@dataclass(frozen=True)
class Quantity(Kind):
    """A number with its unit, or a word in its place."""

    unit: str = ""
    sign: str = "any"
    word: str = ""
    check: Callable[[float, str], Any] | None = None  # of the number and its text (ValueError)
    ends: tuple[tuple[str, float], ...] = ()  # of the JSON Schema

    def read(self, value: Any, entry: Entry) -> Any:
        if self.word and value == self.word:
            return value
        result = number(value, self.unit, self.sign)
        if self.check is not None:
            self.check(result, value)
        return result

    def schema(self) -> Schema:
        start, ends = f"^\\s*{SIGNS[self.sign]}[0-9.]", dict(self.ends)
        span = f"from {ends['minimum']}" if "minimum" in ends else RANGES[self.sign]
        about = {"x-unit": self.unit.replace("**", "^") or "1", "x-range": span}
        if "maximum" in ends:
            about["x-range"] += f" to {ends['maximum']}"
        if self.unit:
            typical = example(self.unit).removeprefix("for example ").split(" or ")[0]
            pattern = f"{start}.*{HINTS.get(self.unit, '[A-Za-z°/]')}"
            schema: Schema = {"type": "string", "pattern": pattern, "examples": [typical], **about}
        else:
            text = {"type": "string", "pattern": start + "[^A-Za-z]*([eE]|%|percent)?[^A-Za-z]*$"}
            schema = {"anyOf": [{"type": "number", **LOW[self.sign], **ends}, text], **about}
        return {"anyOf": [{"const": self.word}, schema], **about} if self.word else schema

    def text(self, value: Any) -> str:
        return str(value) if isinstance(value, str) else f"{value!r} {self.unit}".rstrip().replace("**", "^")


@dataclass(frozen=True)
class Accuracy(Quantity):
    """An accuracy class, or the word for one of the gear's record."""

    def read(self, value: Any, entry: Entry) -> Any:
        return value if value == SPECIAL else super().read(value, entry)

    def schema(self) -> Schema:
        quantity = super().schema()
        return quantity | {"anyOf": [{"const": SPECIAL}, *quantity["anyOf"]]}


@dataclass(frozen=True)
class Bandwidth(Quantity):
    """A bandwidth in rad/s: of a loop, unlike a shaft, it may be in Hz."""

    def read(self, value: object, entry: Entry) -> float:
        if isinstance(value, str) and "rad" in value:
            return number(value, "rad/s", "positive")
        if isinstance(value, str) and re.search("rpm|rev|turn|deg", value):
            raise ValueError(f"{shown(value)} is a speed of a shaft, not a bandwidth; write 30 Hz or 188 rad/s")
        return tau * number(value, "Hz", "positive")

    def text(self, value: Any) -> str:
        return f"{value!r} rad/s"


@dataclass(frozen=True)
class Whole(Kind):
    """A whole number between two ends, with a remedy, and a text about one beyond the ends."""

    low: int | None = None
    high: int | None = None
    remedy: str = "write for example 2"
    beyond: str = ""

    def read(self, value: object, entry: Entry) -> int:
        if not isinstance(value, str) or not re.fullmatch(r"[+-]?[0-9]{1,9}", value.strip()):
            raise ValueError(f"{shown(value)} is not a whole number; {self.remedy}")
        low, high = [int(value) if end is None else end for end in (self.low, self.high)]
        if self.beyond and not low <= int(value) <= high:
            raise ValueError(f"{value!r} {self.beyond}")
        return int(value)

    def schema(self) -> Schema:
        ends = {"minimum": self.low, "maximum": self.high}
        low = "" if self.low is None else f"from {self.low}"
        span = low if self.high is None else f"{low} to {self.high}"
        return {"type": "integer", **_given(ends), "x-unit": "1", "x-range": span}

    def example(self) -> str:
        return "for example 2"


@dataclass(frozen=True)
class Word(Kind):
    """One of some words."""

    words: tuple[str, ...]

    def read(self, value: object, entry: Entry) -> Any:
        if value not in self.words:
            raise ValueError(f"{shown(value)} is not known{suggestion(value, list(self.words))}")
        return value

    def schema(self) -> Schema:
        return {"enum": list(self.words)}


@dataclass(frozen=True)
class Text(Kind):
    """A text: a function returns its value or refuses it, another one gives more of its JSON Schema."""

    convert: Callable[[str], Any] = str
    more_schema: Callable[[], Schema] = dict
    name: str = "a text"
    sample: str = "a text"

    def read(self, value: object, entry: Entry) -> Any:
        if not isinstance(value, str):
            raise NotOfKind(self.name)
        return self.convert(value)

    def schema(self) -> Schema:
        return {"type": "string", **self.more_schema()}

    def example(self) -> str:
        return self.sample

    def text(self, value: str) -> str:
        return json.dumps(value, ensure_ascii=False)


@dataclass(frozen=True)
class Items(Kind):
    """A list of items of one kind, with its least and largest length."""

    item: Kind
    low: int | None = None
    high: int | None = None

    def read(self, value: object, entry: Entry) -> Any:
        if not isinstance(value, list):
            raise NotOfKind("a list")
        for limit, outside, which in ((self.low, -1, "least"), (self.high, 1, "most")):
            if limit is not None and outside * (len(value) - limit) > 0:
                raise ValueError(f"has {len(value)} items; write at {which} {limit}")
        return tuple(read(self.item, item, entry.inside(i, entry.example[1:-1])) for i, item in enumerate(value))

    def schema(self) -> Schema:
        return {"type": "array", "items": self.item.schema(), **_given({"minItems": self.low, "maxItems": self.high})}

    def text(self, value: Any) -> str:
        return f"[{', '.join(map(self.item.text, value))}]"

    def part(self, value: object, key: str) -> Row:
        return Row(self.item)


@dataclass(frozen=True)
class Either(Kind):
    """A group of fields, or a value of a plain kind, or a word in their place."""

    plain: Kind
    group: Kind
    word: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "unit", self.plain.unit)
        object.__setattr__(self, "sign", self.plain.sign)

    def read(self, value: object, entry: Entry) -> Any:
        if self.word and value == self.word:
            return value
        return (self.group if isinstance(value, dict) else self.plain).read(value, entry)

    def schema(self) -> Schema:
        plain, group = self.plain.schema(), self.group.schema()
        kept: Schema = {key: plain[key] for key in ("x-unit", "x-range") if key in plain}
        words = [{"const": self.word}] * bool(self.word)
        return {"anyOf": [plain, group, *words], **kept}

    def text(self, value: Any) -> str:
        if isinstance(value, str):
            return value
        return (self.plain if isinstance(value, int | float) else self.group).text(value)

    def part(self, value: object, key: str) -> Row | None:
        return self.group.part(value, key)


def read(kind: Kind, value: object, entry: Entry) -> Any:
    """Read the value of an entry; None for a wrong one, whose fault the entry then has, or that is reported already."""
    before = len(entry.faults)
    try:
        result = entry.wrong("") if value is None else kind.read(value, entry)
        return result if len(entry.faults) == before else None
    except NotOfKind as error:
        entry.wrong(f"{shown(value)} is not {error}; {entry.remedy(kind)}")
    except ValueError as error:
        entry.wrong(str(error))
    return None


def _turns(angle: float, text: str) -> None:
    if abs(angle) > MOST_TURNS * tau:
        raise ValueError(f"{text!r} is more than {MOST_TURNS} turns; write a phase within one turn, for example 90 deg")


def plain_file(text: str) -> str:
    """Pass the name of a file in the folder of the project file (ValueError)."""
    if re.search(r"[/\\:]|^\.", text):
        raise ValueError(f"{shown(text)} is no plain file name; put the file beside the project file")
    return text


def _given(ends: Schema) -> Schema:
    return {key: end for key, end in ends.items() if end is not None}


PHASE = Quantity("rad", check=_turns)
BANDWIDTH = Bandwidth("Hz", "positive")
FILE_NAME = Text(
    plain_file, lambda: {"pattern": "^[^/\\\\:.][^/\\\\:]*$"}, sample="the name of a file beside the project file"
)
