"""JSON and CSV of lines, equal to the bit when read back, and CSV of points for anything that reads columns."""

import json
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ....base.quantities import shown
from ....model.excitation import HIGHEST, Line
from ..content import OrderContent
from ..format import Exact, Held, OfPoints
from ..points import MARK, MOST_POINTS, Points, Unfit, content_of, float_in, rows_of, said_by, two_ways, ways, whole_in

VERSION = 1
PLAIN = ("unit", "turn", "ratio", "zero", "sign", "direction", "mean", "mean_backward", "delay", "load", "source")


@dataclass(frozen=True)
class JsonFile(Exact, name="json", title="JSON", own_sign=True, begin=r"\s*\{"):
    """JSON with every field of the table; amplitudes 0-to-peak, phases in rad."""

    def text(self, table: OrderContent, held: Held, comments: list[str]) -> str:
        """Write the fields, lines last."""
        data: dict[str, Any] = {"format": MARK, "version": VERSION}
        data |= {name: getattr(table, name) for name in PLAIN}
        data["speeds"] = None if table.speeds is None else list(table.speeds)
        for name, lines in (("lines", table.lines), ("backward", table.backward)):
            data[name] = None if lines is None else [line._asdict() for line in lines]
        return json.dumps(data, indent=2, allow_nan=False) + "\n"

    def parse(self, text: str) -> OrderContent:
        """Read the fields."""
        try:
            data = json.loads(text, parse_constant=_refused)
        except json.JSONDecodeError as error:
            raise Unfit(error.lineno, "file", f"is no whole JSON ({error.msg}); save the table again") from None
        except (ValueError, RecursionError) as error:
            raise Unfit(1, "file", f"is no order table ({' '.join(str(error).split())[:100]}); save it again") from None
        if not isinstance(data, dict) or data.get("format") != MARK:
            raise Unfit(1, "format", f"is not {MARK!r}; save an order table with write(path, format='json')")
        if data.get("version") != VERSION:
            raise Unfit(1, "version", f"is {shown(data.get('version'))}; this version of strainwave reads {VERSION}")
        known = {"format", "version", "speeds", "lines", "backward", *PLAIN}
        if strange := sorted(set(data) - known):
            raise Unfit(1, strange[0][:40], f"is not a field of an order table; it has {', '.join(sorted(known))}")
        fields = {name: data[name] for name in PLAIN if name in data}
        speeds = data.get("speeds")
        return OrderContent(
            lines=_lines(data.get("lines"), "lines"),
            backward=None if data.get("backward") is None else _lines(data["backward"], "backward"),
            speeds=tuple(speeds) if isinstance(speeds, list) else speeds,
            **fields,
        )


def _refused(constant: str) -> None:
    raise ValueError(f"{constant} is no finite number")


def _lines(data: object, name: str) -> tuple[Line, ...]:
    if not isinstance(data, list):
        raise Unfit(1, name, f"are {shown(data)}; write a list of {{'order', 'amplitude', 'phase'}}")
    for line in data:
        if not isinstance(line, dict) or set(line) != {"order", "amplitude", "phase"}:
            raise Unfit(1, name, f"hold {shown(line)}; write order, amplitude and phase of every line")
    return tuple(Line(**line) for line in data)


LINES, POINTS = "direction,order,amplitude,phase", ("angle_rad,value", "angle_rad,forward,backward")
END = "# end"
EVEN = 1e-6  # of a step: how far an angle may be from its place


@dataclass(frozen=True)
class CsvLines(
    Exact, name="csv", title="CSV of lines", own_sign=True, begin=rf"(?s)(.{{0,4000}}\n)?{LINES}\n"
):  # fmt: skip
    """CSV of lines, one row an order and order 0 for the constant, with the other fields in remarks."""

    def text(self, table: OrderContent, held: Held, comments: list[str]) -> str:
        """Write a row an order; amplitude in the unit of the table, phase in rad."""
        rows = [*(f"# {line}" for line in comments), LINES]
        for way, mean, lines in ways(table):
            name = way if table.backward is not None else table.direction
            rows.append(f"{name},0,{mean!r},0.0")
            rows += [f"{name},{line.order},{line.amplitude!r},{line.phase!r}" for line in lines]
        return "\n".join([*rows, END]) + "\n"

    def parse(self, text: str) -> OrderContent:
        """Read the rows."""
        fields, _ = said_by(text)
        sets: dict[str, list[Line]] = {}
        means: dict[str, float] = {}
        width, rows = _body(text, (LINES,))
        for number, line in rows:
            cells = line.split(",")
            if len(cells) != width or cells[0] not in ("both", "forward", "backward"):
                raise Unfit(number, "file", f"{shown(line[:60])} is no row of {LINES}; correct it")
            order = whole_in(number, "order", cells[1], 0, HIGHEST)
            size, phase = float_in(number, "amplitude", cells[2]), float_in(number, "phase", cells[3])
            lines = sets.setdefault(cells[0], [])
            if order == 0:
                means[cells[0]] = size
            else:
                lines.append(Line(order, size, phase))
        if f"{MARK}: {self.name}\n" in text and not text.rstrip().endswith(END):
            raise Unfit(text.count("\n") + 1, "file", f"does not end with {END!r}; it is cut off, save the table again")
        if not sets:
            raise Unfit(1, "file", "has no rows; it may be cut off, save the table again")
        return _content(fields, {way: (means.get(way, 0.0), tuple(lines)) for way, lines in sets.items()})


def _content(fields: dict[str, Any], sets: dict[str, tuple[float, tuple[Line, ...]]]) -> OrderContent:
    """Table of rows by direction: "both", one direction alone, or forward and backward."""
    if set(sets) == {"forward", "backward"}:
        return two_ways(fields | {"direction": "both"}, sets)
    if len(sets) > 1:
        raise Unfit(1, "direction", f"has rows of {' and '.join(sets)}; write both, or forward and backward")
    (direction,) = sets
    if fields.get("direction", direction) != direction:
        raise Unfit(1, "direction", f"is {fields['direction']} in the remarks and {direction} in the rows; correct it")
    return two_ways(fields | {"direction": direction}, {"forward": sets[direction]})


@dataclass(frozen=True)
class CsvPoints(
    OfPoints, name="points", title="CSV of points", own_sign=True, both_ways=True,
    begin=rf"\s*({'|'.join(POINTS)})",
):  # fmt: skip
    """CSV of points at equidistant angles of the encoder over one turn: angle, value, and that in backward motion.

    Attributes
    ----------
    points : int, optional
        Points a turn. Default: 32 a period of the highest order, at least 64.
    """

    points: int | None = None

    def text(self, table: OrderContent, held: Held, comments: list[str]) -> str:
        """Write a row a point."""
        points = held.numbers
        rows = [",".join(map(repr, row)) for row in np.vstack([points.angles(), points.values]).T.tolist()]
        return "\n".join([*(f"# {line}" for line in comments), POINTS[len(points.values) - 1], *rows]) + "\n"

    def parse(self, text: str) -> OrderContent:
        """Read the rows."""
        fields, _ = said_by(text)
        width, rows = _body(text, POINTS)
        points: list[list[float]] = []
        for number, line in rows:
            cells = line.split(",")
            if len(cells) != width:
                raise Unfit(number, "file", f"has {len(cells)} cells where the head names {width}; correct it")
            points.append([float_in(number, "value", cell) for cell in cells])
            if len(points) > MOST_POINTS:
                raise Unfit(number, "file", f"has more than {MOST_POINTS} points; take fewer")
        if len(points) < 4:
            raise Unfit(1, "file", f"has {len(points)} points; a turn needs 4 at least, it may be cut off")
        table = np.array(points)
        step = 2.0 * math.pi / len(table)
        if np.max(np.abs(table[:, 0] - step * np.arange(len(table)))) > EVEN * step:
            raise Unfit(
                1, "angle_rad", f"the {len(table)} angles are not equidistant from 0 over one turn; some may be missing"
            )
        return content_of(Points(table[:, 1:].T), fields)


def _body(text: str, heads: tuple[str, ...]) -> tuple[int, Iterator[tuple[int, str]]]:
    """Columns of a table below one of some heads, and its rows with their numbers."""
    rows = rows_of(text)
    number, head = next(rows, (1, heads[0]))
    if head not in heads:
        raise Unfit(number, "file", f"has the columns {shown(head[:60])}; they must be {heads[0]}")
    return head.count(",") + 1, rows
