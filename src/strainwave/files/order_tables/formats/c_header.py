"""C header: the table as a function of angle and speed, and as points for a controller without cosines.

C99, no allocation, no state; the sum runs in the order of `OrderTable.value`, so both agree to the rounding of cos.
"""

import re
from dataclasses import dataclass
from typing import ClassVar

from ....base.quantities import positive_count, shown
from ....model.excitation import HIGHEST, Line
from ..content import OrderContent
from ..format import Exact, Held, WithPoints, lookup_remark, marked
from ..points import MOST_POINTS, Unfit, float_in, said_by, sampled, whole_in

NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,60}")
ARRAY = re.compile(
    r"static const double (\w{1,80})_(forward|backward)_(order|amplitude|phase)\[\] = \{([0-9eE+\-., \n]*)\};"
)
SCALAR = re.compile(r"static const double (\w{1,80})_(forward|backward)_mean = ([^;]{1,60});")
COUNT = re.compile(r"static const int (\w{1,80})_(forward|backward)_lines = ([0-9]{1,6});")

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
    if (speed < 0.0)
        return @BACKWARD@;
    return @FORWARD@;
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


@dataclass(frozen=True)
class CHeader(WithPoints, Exact):
    """C header with functions `prefix`_value(angle, speed) and `prefix`_lookup(angle, speed).

    Attributes
    ----------
    prefix : str
        Begin of all names.
    points : int, optional
        Points of the lookup a turn. Default: 32 a period of the highest order, at least 64.
    """

    prefix: str = "order_table"
    points: int | None = None
    name: ClassVar[str] = "c"
    title: ClassVar[str] = "a C header"
    own_sign: ClassVar[bool] = True
    both_ways: ClassVar[bool] = True
    with_delay: ClassVar[bool] = True

    def __post_init__(self) -> None:
        if not isinstance(self.prefix, str) or not NAME.fullmatch(self.prefix):
            raise ValueError(f"prefix is {shown(self.prefix)}; give a name of C")
        if self.points is not None:
            positive_count("points", self.points, MOST_POINTS)

    def text(self, table: OrderContent, held: Held, said: list[str]) -> str:
        """Write the numbers, the functions and the points."""
        name = self.prefix
        guard = f"{name.upper()}_H"
        points = sampled(table, self.count(table))
        back = points.forward if points.backward is None else points.backward
        said = [*said, lookup_remark(table, points)]
        rows = [*(f"// {line}" for line in said), f"#ifndef {guard}", f"#define {guard}", "#include <math.h>", ""]
        rows += [f"#define {name}_count {len(points.forward)}", ""]
        rows += [f"static const double {name}_{key} = {getattr(table, key)!r};" for key in ("delay", "zero")]
        rows += self._set("forward", table.mean, table.lines)
        if table.backward is not None:
            rows += self._set("backward", table.mean_backward, table.backward)
        rows += [_array(f"{name}_points_{way}", values) for way, values in
                 (("forward", points.forward.tolist()), ("backward", back.tolist()))]  # fmt: skip
        other = "forward" if table.backward is None else "backward"
        forward = "0.0" if table.direction == "backward" else self._sum("forward")
        backward = "0.0" if table.direction == "forward" else self._sum(other)
        functions = FUNCTIONS.replace("NAME", name).replace("@BACKWARD@", backward).replace("@FORWARD@", forward)
        return "\n".join([*rows, functions.rstrip("\n"), "", f"#endif /* {guard} */"]) + "\n"

    def _set(self, way: str, mean: float, lines: tuple[Line, ...]) -> list[str]:
        name = f"{self.prefix}_{way}"
        return [
            f"static const int {name}_lines = {len(lines)};",
            f"static const double {name}_mean = {mean!r};",
            _array(f"{name}_order", [float(line.order) for line in lines]),
            _array(f"{name}_amplitude", [line.amplitude for line in lines]),
            _array(f"{name}_phase", [line.phase for line in lines]),
        ]

    def _sum(self, way: str) -> str:
        of = f"{self.prefix}_{way}"
        return f"{self.prefix}_sum({of}_mean, {of}_order, {of}_amplitude, {of}_phase, {of}_lines, led)"

    def parse(self, text: str) -> OrderContent:
        """Read the arrays of the lines."""
        fields, _ = said_by(text)
        if "#endif" not in text:
            raise Unfit(text.count("\n") + 1, "file", "has no #endif; it may be cut off, write it again")
        arrays = {(way, kind): _numbers(kind, body) for _, way, kind, body in ARRAY.findall(text)}
        means = {way: float_in(1, f"{way} mean", value) for _, way, value in SCALAR.findall(text)}
        counts = {way: int(value) for _, way, value in COUNT.findall(text)}
        sets = {way: _lines(way, arrays, counts.get(way)) for way in means}
        if "forward" not in sets:
            raise Unfit(1, "file", "has no lines of an order table; write it again")
        return OrderContent(
            **fields, lines=sets["forward"], mean=means["forward"], backward=sets.get("backward"),
            mean_backward=means.get("backward", 0.0),
        )  # fmt: skip

    @classmethod
    def recognises(cls, text: str) -> bool:
        """Whether it says so."""
        return marked(text, cls.name)


def _array(name: str, values: list[float]) -> str:
    rows = [", ".join(map(repr, values[i : i + 4])) for i in range(0, len(values), 4)] or ["0.0"]
    body = ",\n    ".join(rows)
    return f"static const double {name}[] = {{\n    {body}\n}};"


def _numbers(kind: str, body: str) -> list[float]:
    return [float_in(1, kind, cell) for cell in body.split(",") if cell.strip()]


def _lines(way: str, arrays: dict[tuple[str, str], list[float]], count: int | None) -> tuple[Line, ...]:
    columns = [arrays.get((way, kind)) for kind in ("order", "amplitude", "phase")]
    found = [column for column in columns if column is not None]
    if count is None or len(found) < 3 or {len(column) for column in found} != {max(count, 1)}:
        raise Unfit(1, way, "has not the lines that it names; it may be cut off, write it again")
    rows = list(zip(*found, strict=True))[:count]
    return tuple(
        Line(whole_in(1, "order", f"{order:.0f}", 1, HIGHEST), amplitude, phase) for order, amplitude, phase in rows
    )
