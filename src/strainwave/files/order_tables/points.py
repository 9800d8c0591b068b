"""Equidistant points over whole turns, joined by straight lines: what most machines hold of an order table.

The angle is the encoder's, the shaft's less the zero mark. A line of order n between P points a turn is read up to
1 - cos(pi n/P), nearly (pi n/P)^2/2, of its amplitude too small halfway between two points.

Remarks at the head of a file: what the numbers below them mean, and what the file leaves of the table.
"""

import json
import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ...base.quantities import shown
from ...base.results import Floats
from ...base.units import NUMBER
from ...model.excitation import HIGHEST, Line
from ..yaml_text import Problem
from .content import CHOICES, OrderContent

PER_PERIOD = 32  # points a period of the highest order, unless the caller says otherwise: 0.5 % lost between them
FEWEST = 64
MOST_POINTS = 2 * HIGHEST  # two points a period of the highest order of a table
ROUNDING = 1e-13  # of the largest value: below it an amplitude is that of the computer's arithmetic

MARK = "strainwave order table"
KEYS = ("unit", "turn", "ratio", "zero", "sign", "direction", "delay", "speeds", "load", "source")
Side = tuple[float, tuple[Line, ...]]  # mean and lines of one direction of motion
LINE = re.compile(r"\s*(?:#|//|;|\(\*)\s*(\w+(?: \w+)?) = (.{0,30000})")


class Unfit(ValueError):
    """A file is no table of its format; the first argument is the `Problem`."""

    def __init__(self, line: int, field: str, sentence: str) -> None:
        super().__init__(Problem(line, 1, field, sentence))


def remarks(name: str, table: OrderContent, sentences: Iterable[str], options: dict[str, Any]) -> list[str]:
    """Head of a file as lines without the comment's mark, in plain ASCII."""
    fields = {key: getattr(table, key) for key in KEYS}
    rows = [f"{MARK}: {name}"]
    for key, value in fields.items():
        if value is not None and value != "":
            rows.append(f"{key} = {_written(value)}")
    rows += [f"option {key} = {_written(value)}" for key, value in options.items()]
    return [*rows, *sentences]


def _written(value: object) -> str:
    if isinstance(value, tuple):
        return " ".join(map(repr, value))
    if isinstance(value, str) and value not in [word for words in CHOICES.values() for word in words]:
        return json.dumps(value).replace("*", "\\u002a").replace("/", "\\u002f")
    return value if isinstance(value, str) else repr(value)


def said_by(text: str) -> tuple[dict[str, Any], dict[str, str]]:
    """Fields of the table and options of the format that the remarks of a file give.

    Raises
    ------
    Unfit
        If a remark has a value that is none.
    """
    fields: dict[str, Any] = {}
    options: dict[str, str] = {}
    for number, line in enumerate(text.splitlines(), start=1):
        match = LINE.match(line)
        if match is None:
            continue
        key, value = match.group(1), match.group(2).rstrip().removesuffix("*)").rstrip()
        if key.startswith("option "):
            options[key.removeprefix("option ")] = _text(number, key, value) if value.startswith('"') else value
        elif key in KEYS:
            fields[key] = _field(number, key, value)
    return fields, options


def _field(line: int, key: str, value: str) -> Any:
    if key in CHOICES:
        if value not in CHOICES[key]:
            raise Unfit(line, key, f"{shown(value)} is not known; write one of {', '.join(CHOICES[key])}")
        return value
    if key == "source":
        return _text(line, key, value)
    if key == "speeds":
        return tuple(float_in(line, key, part) for part in value.split())
    return float_in(line, key, value)


def _text(line: int, key: str, value: str) -> str:
    try:
        found = json.loads(value)
    except ValueError:
        found = None
    if not isinstance(found, str):
        raise Unfit(line, key, f"{shown(value)} is no text in double quotes; write it so")
    return found


def rows_of(text: str) -> Iterator[tuple[int, str]]:
    """Lines of a file with something on them that is no remark, each with its number."""
    for number, line in enumerate(text.splitlines(), start=1):
        if line.strip() and not line.lstrip().startswith("#"):
            yield number, line.strip()


def enter(found: dict[int, Any], line: int, name: str, place: int, value: object) -> None:
    """Enter what a file has at a place, or refuse the second one (Unfit)."""
    if place in found:
        raise Unfit(line, name, "is there twice; leave one out")
    found[place] = value


def float_in(line: int, field: str, text: str) -> float:
    """Finite number in a file (Unfit)."""
    plain = text.strip()
    value = float(plain) if len(plain) <= 60 and NUMBER.fullmatch(plain) else float("nan")
    if not abs(value) <= 1e60:
        raise Unfit(line, field, f"{shown(plain)} is no finite number; correct it")
    return value


def whole_in(line: int, field: str, text: str, low: int, high: int) -> int:
    """Whole number between two bounds in a file (Unfit)."""
    plain = text.strip()
    value = int(plain) if re.fullmatch(r"[+-]?[0-9]{1,9}", plain) else None
    if value is None or not low <= value <= high:
        raise Unfit(line, field, f"{shown(plain)} is no whole number from {low} to {high}; correct it")
    return value


class Points(NamedTuple):
    """Values (1 or 2, P) at angles start + 2 pi turns i/P of the encoder, i = 0 .. P - 1, which repeat after `turns`.

    A second row is that of backward motion, where it is another one.
    """

    values: Floats
    turns: int = 1
    start: float = 0.0

    @property
    def length(self) -> int:
        """Points P."""
        return int(self.values.shape[1])

    def angles(self) -> Floats:
        """Angles of the encoder [rad], (P,)."""
        return self.start + 2.0 * math.pi * self.turns * np.arange(self.length) / self.length

    def value(self, angle: Floats, backward: bool) -> Floats:
        """Value between the points at angles of the encoder [rad]."""
        values = self.values[-1 if backward else 0]
        place = np.mod((angle - self.start) / (2.0 * math.pi * self.turns), 1.0) * self.length
        return np.asarray(np.interp(place, np.arange(self.length + 1), np.append(values, values[0])))

    def sides(self, zero: float) -> list[Side]:
        """Mean and lines of each row: a discrete Fourier series, of which whole orders of one turn are kept.

        `zero` is the shaft's angle at the encoder's index.
        """
        return [self._of(values, zero) for values in self.values]

    def _of(self, values: Floats, zero: float) -> Side:
        c = np.fft.rfft(values) / self.length
        least = ROUNDING * float(np.max(np.abs(values), initial=0.0))
        lines = []
        for bin_ in range(self.turns, self.length // 2 + 1, self.turns):
            size = (1.0 if 2 * bin_ == self.length else 2.0) * abs(c[bin_])
            if size > least:
                order = bin_ // self.turns
                phase = float(np.angle(c[bin_])) - order * (self.start + zero)
                lines.append(Line(order, float(size), math.remainder(phase, 2.0 * math.pi)))
        mean = float(c[0].real)
        return mean if abs(mean) > least else 0.0, tuple(lines)


def sampled(table: OrderContent, count: int, *, turns: int = 1, start: float = 0.0) -> Points:
    """The table at `count` angles of the encoder over so many turns, backward apart where it differs."""
    angle = table.zero + start + 2.0 * math.pi * turns * np.arange(count) / count
    return Points(np.array([table.one_direction(angle, backward) for backward in table.sides]), turns, start)


def points_for(table: OrderContent, capacity: int, turns: int = 1) -> int:
    """How many points over so many turns the highest order needs, at most `capacity`."""
    highest = max(table.orders, default=1)
    return min(capacity, max(FEWEST, PER_PERIOD * highest * turns))


def motion(points: Points, zero: float) -> Callable[[Floats, bool], Floats]:
    """Value of points by angle of the shaft [rad] and direction."""
    return lambda angle, backward: points.value(angle - zero, backward)


def highest_order(points: int, turns: int = 1) -> int:
    """Highest order that so many points over so many turns can hold: two points a period."""
    return points // (2 * turns)


def content_of(points: Points, fields: dict[str, Any]) -> OrderContent:
    """Order table of points that were read, with the other fields as far as they are known."""
    return of_sides(points.sides(fields.get("zero", 0.0)), fields)


def of_sides(sides: Sequence[Side], fields: dict[str, Any]) -> OrderContent:
    """Order table of one set of lines or of two, of which that of the table's direction counts, if it has one."""
    if fields.get("direction", "both") != "both":
        sides = [sides[-1 if fields["direction"] == "backward" else 0]]
    return two_ways(fields, dict(zip(("forward", "backward"), sides, strict=False)))


def ways(table: OrderContent) -> list[tuple[str, float, tuple[Line, ...]]]:
    """Constant and lines of forward motion, and of backward motion where they are other ones."""
    back = [] if table.backward is None else [("backward", table.mean_backward, table.backward)]
    return [("forward", table.mean, table.lines), *back]


def acting(table: OrderContent) -> list[tuple[str, tuple[Line, ...]] | None]:
    """Which of `ways` acts in forward motion, and which in backward motion; None where nothing does."""
    names = [(way, lines) for way, _, lines in ways(table)]
    return [None if table.direction == "backward" else names[0], None if table.direction == "forward" else names[-1]]


def two_ways(fields: Mapping[str, Any], sets: Mapping[str, Side]) -> OrderContent:
    """Table of constant and lines by direction of motion: forward, and backward where there are such."""
    mean_backward, backward = sets.get("backward", (0.0, None))
    mean, lines = sets["forward"]
    return OrderContent(**fields, lines=lines, mean=mean, backward=backward, mean_backward=mean_backward)
