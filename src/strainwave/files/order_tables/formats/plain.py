"""JSON and CSV of lines, equal to the bit when read back, and CSV of points for anything that reads columns.

CSV over two turns, the motor's and the output's, is for a controller that looks a correction up by both angles.
"""

import json
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ....base.quantities import positive_count, shown
from ....base.results import Floats
from ....model.excitation import HIGHEST, Line
from ..content import CHOICES, OrderContent, merged
from ..format import Exact, Held, Motion, OfPoints, OrderFormat
from ..points import (
    MARK,
    MOST_POINTS,
    PER_PERIOD,
    ROUNDING,
    Points,
    Side,
    Unfit,
    acting,
    content_of,
    float_in,
    of_sides,
    rows_of,
    said_by,
    two_ways,
    ways,
    whole_in,
)

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
        for number, cells in _body(text, (LINES,))[1]:
            if len(cells) != len(LINES.split(",")) or cells[0] not in CHOICES["direction"]:
                raise Unfit(number, "file", f"{shown(','.join(cells)[:60])} is no row of {LINES}; correct it")
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
        head, rows = _body(text, POINTS)
        width, points = len(head.split(",")), list[list[float]]()
        for number, cells in rows:
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


def _body(text: str, heads: tuple[str, ...]) -> tuple[str, Iterator[tuple[int, list[str]]]]:
    """Head of a table, one of some, and the cells of its rows with their numbers."""
    rows = rows_of(text)
    number, head = next(rows, (1, heads[0]))
    if head not in heads:
        raise Unfit(number, "file", f"has the columns {shown(head[:60])}; they must be {heads[0]}")
    return head, ((number, line.split(",")) for number, line in rows)


HEADS = ("motor_rad,output_rad,value", "motor_rad,output_rad,forward,backward")
COARSE, MOST_ROWS = 8, 200_000  # points a turn at least, and of a file at most
TURN = 2.0 * math.pi


@dataclass(frozen=True)
class CsvGrid(
    OrderFormat, name="grid", title="CSV over two turns", turn="output", own_sign=True,
    both_ways=True, width=8, begin=rf"\s*({'|'.join(HEADS)})",
):  # fmt: skip
    """CSV of points over the encoder angles of motor and output, each over a turn; straight lines along both.

    A line that repeats j times in a turn of the motor and k times in one of the output takes as many points as j and k
    need, not as j N + k does.

    Attributes
    ----------
    motor_points, output_points : int, optional
        Points a turn. Default: 32 a period of the highest j and k, at least 8.
    capacity : int
        Points that the controller holds.
    """

    motor_points: int | None = None
    output_points: int | None = None
    capacity: int = MOST_ROWS

    def __post_init__(self) -> None:
        positive_count("capacity", self.capacity, MOST_ROWS)
        for name in ("motor_points", "output_points"):
            if getattr(self, name) is not None:
                positive_count(name, getattr(self, name), MOST_ROWS)

    def counts(self, table: OrderContent) -> tuple[int, int]:
        """Points of the motor's turn and of the output's for a table; too few or too many are refused (ValueError)."""
        if table.pairs is None:
            raise ValueError(f"{self.title} needs a whole ratio; give it to the table")
        counts = []
        for name, repeats in zip(("motor_points", "output_points"), np.abs(table.pairs).reshape(-1, 2).T, strict=True):
            highest = int(np.max(repeats, initial=0))
            counts.append(getattr(self, name) or max(COARSE, PER_PERIOD * highest))
            if counts[-1] <= 2 * highest:
                raise ValueError(f"{name} is {counts[-1]} and a line repeats {highest} times a turn; give more points")
        if math.prod(counts) * len(table.sides) > self.capacity:
            raise ValueError(
                f"a table of {counts[0]} by {counts[1]} points is more than the {self.capacity} that the controller "
                "holds; give motor_points and output_points, or take lines"
            )
        return counts[0], counts[1]

    def store(self, table: OrderContent) -> Held:
        """Sample the table, one grid or one for each direction of motion."""
        motor, output = [TURN * np.arange(count) / count for count in self.counts(table)]
        pairs = dict(zip(table.orders, table.pairs or (), strict=True))
        turns = {order: j * motor[:, None] + k * output + order * table.zero for order, (j, k) in pairs.items()}
        sets = {way: (mean, lines) for way, mean, lines in ways(table)}
        grids = []
        for act in acting(table)[: len(table.sides)]:
            mean, lines = (0.0, ()) if act is None else sets[act[0]]
            waves = (line.amplitude * np.cos(turns[line.order] + line.phase) for line in lines)
            grids.append(sum(waves, np.full((len(motor), len(output)), mean)))
        stored = _motion(grids, table.ratio or 1.0, table.zero)
        return Held(stored, stored, grids, points=grids[0].size)

    def text(self, table: OrderContent, held: Held, comments: list[str]) -> str:
        """Write a row a point, the output's angle first to change."""
        grids = held.numbers
        axes = np.meshgrid(*(TURN * np.arange(count) / count for count in grids[0].shape), indexing="ij")
        rows = np.column_stack([*(axis.ravel() for axis in axes), *(grid.ravel() for grid in grids)]).tolist()
        lines = [
            *(f"# {line}" for line in comments),
            HEADS[len(grids) - 1],
            *(",".join(map(repr, row)) for row in rows),
        ]
        return "\n".join(lines) + "\n"

    def parse(self, text: str) -> OrderContent:
        """Read the rows; points become lines by a Fourier series over both turns."""
        fields, _ = said_by(text)
        if not fields.get("ratio", 0.0) >= 1.0 or fields["ratio"] % 1:
            raise Unfit(1, "ratio", "is not in the remarks as a whole number; write '# ratio = 50.0'")
        head, body = _body(text, HEADS)
        rows: list[list[float]] = []
        for number, cells in body:
            if len(cells) != len(head.split(",")) or len(rows) >= MOST_ROWS:
                row = shown(",".join(cells)[:60])
                raise Unfit(number, "file", f"{row} is no row of {head}, or beyond {MOST_ROWS} of them; correct it")
            rows.append([float_in(number, "value", cell) for cell in cells])
        if len(rows) < 4 * 4:
            raise Unfit(1, "file", f"has {len(rows)} points; two turns need 16 at least, it may be cut off")
        table = np.array(rows)
        counts = [len(np.unique(column)) for column in table[:, :2].T]
        whole = len(table) == math.prod(counts) and min(counts) >= 4
        axes = np.indices(counts).reshape(2, -1) if whole else np.zeros((2, len(table)))
        steps = table[:, :2].T * np.array(counts)[:, None] / TURN - axes
        if not whole or np.max(np.abs(steps)) > EVEN:
            raise Unfit(1, "motor_rad", "and output_rad are not equidistant over a turn each; some rows may be missing")
        series = [_series(grid.reshape(counts), fields) for grid in table[:, 2:].T]
        return of_sides(series, {"turn": "output"} | fields)


def _motion(grids: list[Floats], ratio: float, zero: float) -> Motion:
    """Value by angle of the output [rad] and direction, with straight lines along both angles."""

    def value(angle: Floats, backward: bool) -> Floats:
        grid = grids[-1 if backward else 0]
        weights, corners = [], []
        for turn, count in zip((ratio, 1.0), grid.shape, strict=True):
            place = np.mod(turn * (angle - zero) / TURN, 1.0) * count
            low = np.floor(place)
            weights.append((1.0 - (place - low), place - low))
            corners.append([(low.astype(int) + i) % count for i in (0, 1)])
        terms = [weights[0][i] * weights[1][k] * grid[corners[0][i], corners[1][k]] for i in (0, 1) for k in (0, 1)]
        return np.asarray(np.sum(terms, axis=0))

    return value


def _series(grid: Floats, fields: dict[str, Any]) -> Side:
    """Mean and lines of a grid on the output's turn."""
    c = np.fft.fft2(grid) / grid.size
    least = ROUNDING * float(np.max(np.abs(grid), initial=0.0))
    lines, ratio = [], fields["ratio"]
    for j, k in np.argwhere(np.abs(c) > least).tolist():
        order = j * ratio + (k if 2 * k < grid.shape[1] else k - grid.shape[1])
        if 2 * j < grid.shape[0] and 2 * k != grid.shape[1] and order >= 1:
            phase = float(np.angle(c[j, k])) - order * fields.get("zero", 0.0)
            lines.append(Line(round(order), 2.0 * abs(c[j, k]), math.remainder(phase, TURN)))
    mean = float(c[0, 0].real)
    return mean if abs(mean) > least else 0.0, merged(lines)
