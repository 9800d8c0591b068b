"""Code: the table as a function of angle and speed, and as points for a controller without cosines.

C99, no allocation, no state, and structured text of IEC 61131-3. The sum runs in the order of `OrderTable.value`: both
agree to the rounding of cos.
"""

import re
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from ....base.quantities import shown
from ....model.excitation import HIGHEST, Line
from ..content import OrderContent
from ..format import Exact, Held, WithPoints, residual_of
from ..points import Points, Unfit, acting, float_in, motion, said_by, sampled, two_ways, ways, whole_in

C_ARRAY = re.compile(
    r"static const double (\w{1,80})_(forward|backward)_(order|amplitude|phase)\[\] = \{([0-9eE+\-., \n]*)\};"
)
C_MEAN = re.compile(r"static const double (\w{1,80})_(forward|backward)_mean = ([^;]{1,60});")
C_COUNT = re.compile(r"static const int (\w{1,80})_(forward|backward)_lines = ([0-9]{1,6});")
ST_ARRAY = re.compile(
    r"(order|amplitude|phase|mean)(Forward|Backward) : (?:LREAL|ARRAY\[1\.\.([0-9]{1,6})\] OF LREAL) := "
    r"([0-9eE+\-., \n\[\]]+);"
)

C_FUNCTIONS = """
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

ST_VALUE = """
VAR
    i : INT;
    led : LREAL;
    total : LREAL;
END_VAR

led := angle + delay * speed;
IF speed < 0.0 THEN
BACKWARD
ELSE
FORWARD
END_IF;
NAME := total;
END_FUNCTION
"""
ST_SUM = """    total := meanWAY;
    FOR i := 1 TO COUNT DO
        total := total + amplitudeWAY[i] * COS(orderWAY[i] * led + phaseWAY[i]);
    END_FOR;"""
ST_LOOKUP = """
VAR
    place : LREAL;
    turns : DINT;
    i : DINT;
    j : DINT;
END_VAR

place := (angle + delay * speed - zero) / 6.283185307179586;
turns := LREAL_TO_DINT(place);
IF DINT_TO_LREAL(turns) > place THEN
    turns := turns - 1;
END_IF;
place := (place - DINT_TO_LREAL(turns)) * COUNT.0;
i := LREAL_TO_DINT(place);
IF DINT_TO_LREAL(i) > place THEN
    i := i - 1;
END_IF;
IF i > LAST THEN
    i := LAST;
END_IF;
j := i + 1;
IF j > LAST THEN
    j := 0;
END_IF;
IF speed < 0.0 THEN
    NAMELookup := BACK[i] + (place - DINT_TO_LREAL(i)) * (BACK[j] - BACK[i]);
ELSE
    NAMELookup := pointsForward[i] + (place - DINT_TO_LREAL(i)) * (pointsForward[j] - pointsForward[i]);
END_IF;
END_FUNCTION
"""


class Code(WithPoints, Exact, own_sign=True, width=24):
    """Code with a table as a function of angle and speed, and as points for a controller without cosines.

    Attributes
    ----------
    end : str
        What a whole file ends with.
    """

    end: ClassVar[tuple[str, int, str]]

    def lookup(self, table: OrderContent) -> tuple[Points, str]:
        """Points of the lookup, and what straight lines between them leave of the table."""
        points = sampled(table, self.count(table))
        content = Held(motion(points, table.zero), table.one_direction, points, points=points.length)
        left = residual_of(table, table, content, (), True)
        return points, f"lookup: straight lines between {left.points} points leave {left.rms:.3g} {left.unit} rms"

    @abstractmethod
    def columns(self, text: str) -> dict[tuple[str, str], list[float]]:
        """Numbers of a file by direction and by what they are: mean, order, amplitude, phase."""

    def parse(self, text: str) -> OrderContent:
        """Read the arrays of the lines."""
        fields, _ = said_by(text)
        end, times, missing = self.end
        if text.count(end) < times:
            raise Unfit(text.count("\n") + 1, "file", f"{missing}; it may be cut off, write it again")
        found = self.columns(text)
        sets = {way: (found[way, kind][0], _lines(way, found)) for way, kind in found if kind == "mean"}
        if "forward" not in sets:
            raise Unfit(1, "file", "has no lines of an order table; write it again")
        return two_ways(fields, sets)


def columns_of(lines: tuple[Line, ...]) -> dict[str, list[float]]:
    """Numbers of lines by what they are."""
    return {kind: [float(getattr(line, kind)) for line in lines] for kind in Line._fields}


def _lines(way: str, found: Mapping[tuple[str, str], list[float]]) -> tuple[Line, ...]:
    columns = [found.get((way, kind), []) for kind in Line._fields]
    if len({len(column) for column in columns}) != 1:
        raise Unfit(1, way, "has not the lines that it names; it may be cut off, write it again")
    return tuple(
        Line(whole_in(1, "order", f"{order:.0f}", 1, HIGHEST), amplitude, phase)
        for order, amplitude, phase in zip(*columns, strict=True)
    )


@dataclass(frozen=True)
class CHeader(Code, name="c", title="a C header", end=("#endif", 1, "has no #endif")):
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

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.prefix, str) or not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]{0,60}", self.prefix):
            raise ValueError(f"prefix is {shown(self.prefix)}; give a name of C")

    def text(self, table: OrderContent, held: Held, comments: list[str]) -> str:
        """Write the numbers, the functions and the points."""
        name, (points, remark) = self.prefix, self.lookup(table)
        guard = f"{name.upper()}_H"
        rows = [*(f"// {line}" for line in (*comments, remark)), f"#ifndef {guard}", f"#define {guard}"]
        rows += ["#include <math.h>", "", f"#define {name}_count {points.length}", ""]
        rows += [f"static const double {name}_{key} = {getattr(table, key)!r};" for key in ("delay", "zero")]
        for side, mean, lines in ways(table):
            rows += [f"static const int {name}_{side}_lines = {len(lines)};"]
            rows += [f"static const double {name}_{side}_mean = {mean!r};"]
            rows += [_array(f"{name}_{side}_{kind}", values) for kind, values in columns_of(lines).items()]
        for side, values in (("forward", points.values[0]), ("backward", points.values[-1])):
            rows.append(_array(f"{name}_points_{side}", values.tolist()))
        forward, backward = ["0.0" if lines is None else self._sum(lines[0]) for lines in acting(table)]
        functions = C_FUNCTIONS.replace("NAME", name).replace("@BACKWARD@", backward).replace("@FORWARD@", forward)
        return "\n".join([*rows, functions.rstrip("\n"), "", f"#endif /* {guard} */"]) + "\n"

    def _sum(self, way: str) -> str:
        of = f"{self.prefix}_{way}"
        return f"{self.prefix}_sum({of}_mean, {of}_order, {of}_amplitude, {of}_phase, {of}_lines, led)"

    def columns(self, text: str) -> dict[tuple[str, str], list[float]]:
        """Numbers of the arrays; where there are no lines they hold one number."""
        arrays = {(side, kind): _numbers(kind, body) for _, side, kind, body in C_ARRAY.findall(text)}
        counts = {side: int(value) for _, side, value in C_COUNT.findall(text)}
        means = {(side, "mean"): [float_in(1, f"{side} mean", value)] for _, side, value in C_MEAN.findall(text)}
        for side, _ in means:
            for kind in Line._fields:
                values, count = arrays.get((side, kind), []), counts.get(side, -1)
                if count < 0 or len(values) != max(count, 1):
                    raise Unfit(1, side, "has not the lines that it names; it may be cut off, write it again")
                arrays[side, kind] = values[:count]
        return arrays | means


def _array(name: str, values: list[float]) -> str:
    rows = [", ".join(map(repr, values[i : i + 4])) for i in range(0, len(values), 4)] or ["0.0"]
    body = ",\n    ".join(rows)
    return f"static const double {name}[] = {{\n    {body}\n}};"


def _numbers(kind: str, body: str) -> list[float]:
    return [float_in(1, kind, cell) for cell in body.strip("[]").split(",") if cell.strip()]


@dataclass(frozen=True)
class StructuredText(
    Code, name="st", title="structured text", end=("END_FUNCTION", 2, "has not both functions")
):  # fmt: skip
    """Structured text with the functions `function`(angle, speed) and `function`Lookup(angle, speed).

    Attributes
    ----------
    function : str
        Name of the function.
    points : int, optional
        Points of the lookup a turn. Default: 32 a period of the highest order, from 64 to 20 000.
    """

    function: str = "F_OrderTable"
    points: int | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        refuse_name("function", self.function)

    def text(self, table: OrderContent, held: Held, comments: list[str]) -> str:
        """Write both functions."""
        points, remark = self.lookup(table)
        remarks = [f"(* {line} *)" for line in (*comments, remark)]
        return "\n".join([*remarks, self._value(table), self._lookup(table, points)])

    def _head(self, name: str, table: OrderContent) -> list[str]:
        return [
            f"FUNCTION {name} : LREAL", "VAR_INPUT", "    angle : LREAL; (* of the shaft, rad *)",
            "    speed : LREAL; (* of the shaft, rad/s *)", "END_VAR", "VAR CONSTANT",
            f"    delay : LREAL := {st_real(table.delay)};",
        ]  # fmt: skip

    def _value(self, table: OrderContent) -> str:
        rows = self._head(self.function, table)
        for name, mean, lines in ways(table):
            way = name.capitalize()
            rows.append(f"    mean{way} : LREAL := {st_real(mean)};")
            for kind, values in columns_of(lines).items() if lines else ():
                rows.append(f"    {kind}{way} : ARRAY[1..{len(lines)}] OF LREAL := [{_listed(values)}];")
        forward, backward = ["    total := 0.0;" if lines is None else _sum(*lines) for lines in acting(table)]
        body = ST_VALUE.replace("BACKWARD", backward).replace("FORWARD", forward).replace("NAME", self.function)
        return "\n".join([*rows, "END_VAR"]) + body

    def _lookup(self, table: OrderContent, points: Points) -> str:
        rows = [*self._head(f"{self.function}Lookup", table), f"    zero : LREAL := {st_real(table.zero)};"]
        last, names = points.length - 1, ("pointsForward", "pointsBackward")[: len(points.values)]
        for name, values in zip(names, points.values, strict=True):
            rows.append(f"    {name} : ARRAY[0..{last}] OF LREAL := [{_listed(values.tolist())}];")
        body = ST_LOOKUP.replace("COUNT", str(last + 1)).replace("LAST", str(last)).replace("BACK", names[-1])
        return "\n".join([*rows, "END_VAR"]) + body.replace("NAME", self.function)

    def columns(self, text: str) -> dict[tuple[str, str], list[float]]:
        """Numbers of the constants of the first function."""
        arrays: dict[tuple[str, str], list[float]] = {}
        for kind, way, count, body in ST_ARRAY.findall(text):
            arrays[way.lower(), kind] = values = _numbers(f"{kind}{way}", body)
            if count and int(count) != len(values):
                raise Unfit(1, f"{kind}{way}", f"has {len(values)} numbers where it names {count}; it may be cut off")
        return arrays


def _listed(values: list[float]) -> str:
    rows = [", ".join(map(st_real, values[i : i + 4])) for i in range(0, len(values), 4)]
    return ",\n        ".join(rows)


def _sum(way: str, lines: tuple[Line, ...]) -> str:
    if not lines:
        return f"    total := mean{way.capitalize()};"
    return ST_SUM.replace("WAY", way.capitalize()).replace("COUNT", str(len(lines)))


def st_real(value: float) -> str:
    """A number as a literal of IEC 61131-3, which has a point."""
    mantissa, mark, exponent = repr(value).partition("e")
    whole = mantissa if "." in mantissa else f"{mantissa}.0"
    return whole + (f"E{exponent}" if mark else "")


def refuse_name(option: str, text: str) -> None:
    """Refuse what is no name in IEC 61131-3 (ValueError)."""
    if not isinstance(text, str) or not re.fullmatch(r"[A-Za-z]\w{0,50}", text, re.ASCII):
        raise ValueError(f"{option} is {shown(text)}; give a name of letters and digits")
