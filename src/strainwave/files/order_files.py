"""Files of order tables: JSON of lines, CSV of points at equidistant angles of the encoder over a turn, and C headers.

A table is a mapping of the fields of an `OrderTable`. Comments at the head of CSV and C hold fields, as JSON values.
"""

import json
import math
import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..base.quantities import number, shown
from ..base.results import Floats
from ..base.units import NUMBER
from ..model.excitation import HIGHEST, Line
from .yaml_text import Problem

MARK, VERSION = "strainwave order table", 1
HEADS = ("angle_rad,value", "angle_rad,forward,backward")
OF_POINTS = ("lines", "backward", "mean", "mean_backward")  # what points hold
REMARK = re.compile(r"(?:#|//) *(\w+) = (.*)")
MOST_POINTS = 2 * HIGHEST
EVEN = 1e-6  # of a step: largest deviation of an angle
ROUNDING = 1e-13  # of the largest value: below it an amplitude is that of the computer's arithmetic
FUNCTIONS = """
/* Sum of a constant and lines amplitude cos(order angle + phase). */
static inline double NAME_sum(double mean, const double *order, const double *amplitude, const double *phase, int lines,
                              double angle)
{
    double total = mean;
    for (int i = 0; i < lines; i++)
        total += amplitude[i] * cos(order[i] * angle + phase[i]);
    return total;
}

/* Value at the angle of the shaft [rad] and its speed [rad/s], read ahead by the delay. */
static inline double NAME_value(double angle, double speed)
{
    const double led = angle + NAME_delay * speed;
    return speed < 0.0 ? @BACKWARD@ : @FORWARD@;
}

/* The same from the points, with straight lines between them. */
static inline double NAME_lookup(double angle, double speed)
{
    double place = (angle + NAME_delay * speed - NAME_zero) / 6.283185307179586;
    const double *points = speed < 0.0 ? NAME_points_backward : NAME_points_forward;
    int i;
    place = (place - floor(place)) * NAME_count;
    i = (int)place;
    if (i >= NAME_count)
        i = NAME_count - 1;
    return points[i] + (place - i) * (points[(i + 1) % NAME_count] - points[i]);
}
"""


class Unfit(ValueError):
    """A file is no order table; the first argument is the `Problem`."""

    def __init__(self, line: int, field: str, sentence: str) -> None:
        super().__init__(Problem(line, 1, field, sentence))


def to_json(table: Mapping[str, Any]) -> str:
    """Text of a table in JSON."""
    return json.dumps({"format": MARK, "version": VERSION} | _plain(table), indent=2, allow_nan=False) + "\n"


def to_csv(table: Mapping[str, Any], columns: Sequence[Sequence[float]]) -> str:
    """Text of a table in CSV, whose columns are values of all directions of motion, or forward and backward."""
    angles = (2.0 * math.pi * np.arange(len(columns[0])) / len(columns[0])).tolist()
    rows = [",".join(map(repr, row)) for row in zip(angles, *columns, strict=True)]
    remarks = _remarks("#", {name: value for name, value in table.items() if name not in OF_POINTS})
    return "\n".join([*remarks, HEADS[len(columns) - 1], *rows]) + "\n"


def to_c(table: Mapping[str, Any], sides: Mapping[str, Any], prefix: str) -> str:
    """Text of a table in C, with constant, lines and points by direction of motion."""
    if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]{0,60}", prefix):
        raise ValueError(f"prefix is {shown(prefix)}; give a name of C")
    guard, functions = f"{prefix.upper()}_H", FUNCTIONS.replace("NAME", prefix)
    rows = [*_remarks("//", table), f"#ifndef {guard}", f"#define {guard}", "#include <math.h>", ""]
    rows += [f"#define {prefix}_count {len(sides['forward'][2])}"]
    rows += [f"static const double {prefix}_{name} = {table[name]!r};" for name in ("delay", "zero")]
    for direction, (mean, lines, points) in sides.items():
        names = [f"{prefix}_{direction}_{kind}" for kind in Line._fields]
        rows += [_array(name, [line[i] for line in lines]) for i, name in enumerate(names)]
        rows += [_array(f"{prefix}_points_{direction}", points)]
        total = f"{prefix}_sum({mean!r}, {', '.join(names)}, {len(lines)}, led)"
        functions = functions.replace(f"@{direction.upper()}@", total)
    return "\n".join([*rows, functions.rstrip("\n"), "", f"#endif /* {guard} */"]) + "\n"


def from_text(text: str, names: Sequence[str]) -> dict[str, Any]:
    """Fields of a table, which has such of some names, from a file of any of the formats (Unfit, ValueError)."""
    if text.lstrip().startswith("{"):
        table = _from_json(text, names)
    else:
        table = {}
        for row in text.splitlines():
            if (match := REMARK.match(row)) is not None and match.group(1) in names:
                table[match.group(1)] = _value(match.group(2))
    for name in ("lines", "backward"):
        if isinstance(table.get(name), list):
            table[name] = tuple(_line(row) for row in table[name])
    return table if "lines" in table else table | _from_points(text, table)


def _plain(table: Mapping[str, Any]) -> dict[str, Any]:
    rows = {name: table[name] and [line._asdict() for line in table[name]] for name in ("lines", "backward")}
    return {name: value for name, value in table.items() if name not in rows} | rows


def _remarks(mark: str, table: Mapping[str, Any]) -> list[str]:
    given = {name: value for name, value in table.items() if value is not None and value != ""}
    plain = _plain({"lines": None, "backward": None} | given)
    return [f"{mark} {MARK}", *(f"{mark} {name} = {json.dumps(plain[name])}" for name in given)]


def _array(name: str, values: Sequence[float]) -> str:
    rows = [", ".join(repr(float(v)) for v in values[i : i + 4]) for i in range(0, len(values), 4)]
    body = ",\n    ".join(rows or ["0.0"])
    return f"static const double {name}[] = {{\n    {body}\n}};"


def _from_json(text: str, names: Sequence[str]) -> dict[str, Any]:
    try:
        table: dict[str, Any] = json.loads(text)
    except (ValueError, RecursionError) as error:
        reason, line = " ".join(str(error).split())[:100], getattr(error, "lineno", 1)
        raise Unfit(line, "file", f"is not complete JSON ({reason}); save the table again") from None
    for name, expected in (("format", MARK), ("version", VERSION)):
        if (value := table.pop(name, None)) != expected:
            raise Unfit(1, name, f"is {shown(value)} and must be {expected!r}; save the table again")
    if strange := sorted(set(table) - set(names)):
        raise Unfit(1, strange[0][:40], f"is not a field of an order table; it has {', '.join(sorted(names))}")
    return {"lines": None} | table


def _value(text: str) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return text


def _line(row: Any) -> Any:
    return Line(**row) if isinstance(row, dict) and set(row) == set(Line._fields) else row


def _from_points(text: str, table: Mapping[str, Any]) -> dict[str, Any]:
    """Constant and lines of each direction of motion."""
    rows = [(i, row.strip()) for i, row in enumerate(text.splitlines(), 1) if row.strip() and row.lstrip()[0] != "#"]
    if not rows or rows[0][1] not in HEADS:
        sentence = f"is not an order table: neither JSON of lines, nor a C header, nor CSV with the columns {HEADS[0]}"
        raise Unfit(rows[0][0] if rows else 1, "file", sentence)
    width, body = rows[0][1].count(",") + 1, [(i, row.split(",")) for i, row in rows[1:]]
    for i, cells in body:
        if len(cells) != width:
            raise Unfit(i, "file", f"has {len(cells)} cells where the head names {width}; correct it")
        if bad := [cell for cell in cells if not _finite(cell.strip())]:
            raise Unfit(i, "value", f"{shown(bad[0])} is not a finite number; correct it")
    if not 4 <= len(body) <= MOST_POINTS:
        raise Unfit(1, "file", f"has {len(body)} points; a turn needs 4 to {MOST_POINTS}; the file may be incomplete")
    angles, *values = np.array([cells for _, cells in body], float).T
    step = 2.0 * math.pi / len(body)
    if np.max(np.abs(angles - step * np.arange(len(body)))) > EVEN * step:
        sentence = f"the {len(body)} angles are not equidistant from 0 over one turn; some may be missing"
        raise Unfit(1, "angle_rad", sentence)
    if table.get("direction", "both") != "both":
        values = values[-1:] if table["direction"] == "backward" else values[:1]
    zero = number("zero of an order table", table.get("zero", 0.0))
    sides = dict(zip((("mean", "lines"), ("mean_backward", "backward")), values, strict=False))
    return {key: value for names, row in sides.items() for key, value in zip(names, _series(row, zero), strict=True)}


def _finite(cell: str) -> bool:
    return len(cell) <= 60 and NUMBER.fullmatch(cell) is not None and abs(float(cell)) <= 1e60


def _series(values: Floats, zero: float) -> tuple[float, tuple[Line, ...]]:
    """Mean and lines of points over a turn of the encoder, whose index is at an angle of the shaft [rad]."""
    c = np.fft.rfft(values) / len(values)
    size = np.abs(c) * np.where(2 * np.arange(len(c)) == len(values), 1.0, 2.0)
    phase = np.angle(c) - np.arange(len(c)) * zero
    least = ROUNDING * float(np.max(np.abs(values)))
    strong = [int(k) for k in np.flatnonzero(size > least) if k > 0]
    lines = tuple(Line(k, float(size[k]), math.remainder(float(phase[k]), 2.0 * math.pi)) for k in strong)
    return float(c[0].real) if size[0] > least else 0.0, lines
