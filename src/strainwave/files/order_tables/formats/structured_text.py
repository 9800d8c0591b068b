"""IEC 61131-3 structured text: the table as a function of angle and speed, and as a function that reads points."""

import re
from dataclasses import dataclass
from typing import ClassVar

from ....base.quantities import positive_count, shown
from ....model.excitation import HIGHEST, Line
from ..content import OrderContent
from ..format import Exact, Held, WithPoints, lookup_remark, marked
from ..points import MOST_POINTS, Points, Unfit, float_in, said_by, sampled, whole_in
from .twincat import st_real

ARRAY = re.compile(
    r"(order|amplitude|phase|mean)(Forward|Backward) : (?:LREAL|ARRAY\[1\.\.([0-9]{1,6})\] OF LREAL) := "
    r"([0-9eE+\-., \n\[\]]+);"
)

VALUE = """
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
SUM = """    total := meanWAY;
    FOR i := 1 TO COUNT DO
        total := total + amplitudeWAY[i] * COS(orderWAY[i] * led + phaseWAY[i]);
    END_FOR;"""
LOOKUP = """
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


@dataclass(frozen=True)
class StructuredText(WithPoints, Exact):
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
    name: ClassVar[str] = "st"
    title: ClassVar[str] = "structured text"
    own_sign: ClassVar[bool] = True
    both_ways: ClassVar[bool] = True
    with_delay: ClassVar[bool] = True

    def __post_init__(self) -> None:
        if not isinstance(self.function, str) or not re.fullmatch(r"[A-Za-z]\w{0,50}", self.function, re.ASCII):
            raise ValueError(f"function is {shown(self.function)}; give a name of letters and digits")
        if self.points is not None:
            positive_count("points", self.points, MOST_POINTS)

    def text(self, table: OrderContent, held: Held, said: list[str]) -> str:
        """Write both functions."""
        points = sampled(table, self.count(table))
        said = [*said, lookup_remark(table, points)]
        return "\n".join([*(f"(* {line} *)" for line in said), self._value(table), self._lookup(table, points)])

    def _head(self, name: str, table: OrderContent) -> list[str]:
        return [
            f"FUNCTION {name} : LREAL", "VAR_INPUT", "    angle : LREAL; (* of the shaft, rad *)",
            "    speed : LREAL; (* of the shaft, rad/s *)", "END_VAR", "VAR CONSTANT",
            f"    delay : LREAL := {st_real(table.delay)};",
        ]  # fmt: skip

    def _value(self, table: OrderContent) -> str:
        rows = self._head(self.function, table)
        rows += _set("Forward", table.mean, table.lines)
        if table.backward is not None:
            rows += _set("Backward", table.mean_backward, table.backward)
        nothing = "    total := 0.0;"
        forward = nothing if table.direction == "backward" else _sum("Forward", table.lines)
        way, lines = ("Forward", table.lines) if table.backward is None else ("Backward", table.backward)
        backward = nothing if table.direction == "forward" else _sum(way, lines)
        body = VALUE.replace("BACKWARD", backward).replace("FORWARD", forward).replace("NAME", self.function)
        return "\n".join([*rows, "END_VAR"]) + body

    def _lookup(self, table: OrderContent, points: Points) -> str:
        rows = [*self._head(f"{self.function}Lookup", table), f"    zero : LREAL := {st_real(table.zero)};"]
        last = len(points.forward) - 1
        for way, values in (("Forward", points.forward), ("Backward", points.backward)):
            if values is not None:
                rows.append(f"    points{way} : ARRAY[0..{last}] OF LREAL := [{_listed(values.tolist())}];")
        back = "pointsForward" if points.backward is None else "pointsBackward"
        body = LOOKUP.replace("COUNT", str(last + 1)).replace("LAST", str(last)).replace("BACK", back)
        return "\n".join([*rows, "END_VAR"]) + body.replace("NAME", self.function)

    def parse(self, text: str) -> OrderContent:
        """Read the constants of the first function."""
        fields, _ = said_by(text)
        if text.count("END_FUNCTION") < 2:
            raise Unfit(text.count("\n") + 1, "file", "has not both functions; it may be cut off, write it again")
        found: dict[tuple[str, str], list[float]] = {}
        for kind, way, count, body in ARRAY.findall(text):
            values = [float_in(1, f"{kind}{way}", cell) for cell in body.strip("[]").split(",")]
            if count and int(count) != len(values):
                raise Unfit(1, f"{kind}{way}", f"has {len(values)} numbers where it names {count}; it may be cut off")
            found[kind, way] = values
        sets = {way: _lines(way, found) for kind, way in found if kind == "mean"}
        if "Forward" not in sets:
            raise Unfit(1, "file", "has no lines of an order table; write it again")
        return OrderContent(
            **fields, lines=sets["Forward"], mean=found["mean", "Forward"][0], backward=sets.get("Backward"),
            mean_backward=found.get(("mean", "Backward"), [0.0])[0],
        )  # fmt: skip

    @classmethod
    def recognises(cls, text: str) -> bool:
        """Whether it says so."""
        return marked(text, f"{cls.name} *)")


def _listed(values: list[float]) -> str:
    rows = [", ".join(map(st_real, values[i : i + 4])) for i in range(0, len(values), 4)]
    return ",\n        ".join(rows)


def _set(way: str, mean: float, lines: tuple[Line, ...]) -> list[str]:
    rows = [f"    mean{way} : LREAL := {st_real(mean)};"]
    columns = {
        "order": [float(line.order) for line in lines],
        "amplitude": [line.amplitude for line in lines],
        "phase": [line.phase for line in lines],
    }
    if lines:
        rows += [
            f"    {kind}{way} : ARRAY[1..{len(lines)}] OF LREAL := [{_listed(values)}];"
            for kind, values in columns.items()
        ]
    return rows


def _sum(way: str, lines: tuple[Line, ...]) -> str:
    if not lines:
        return f"    total := mean{way};"
    return SUM.replace("WAY", way).replace("COUNT", str(len(lines)))


def _lines(way: str, found: dict[tuple[str, str], list[float]]) -> tuple[Line, ...]:
    columns = [found.get((kind, way), []) for kind in ("order", "amplitude", "phase")]
    if len({len(column) for column in columns}) != 1:
        raise Unfit(1, way, "has not the lines that it names; it may be cut off, write it again")
    rows = zip(*columns, strict=True)
    return tuple(
        Line(whole_in(1, "order", f"{order:.0f}", 1, HIGHEST), amplitude, phase) for order, amplitude, phase in rows
    )
