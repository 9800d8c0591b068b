"""TwinCAT 3: global variables with the table of MC_TableBasedPositionCompensation (library Tc2_MC2).

Confirmed by Beckhoff's Information System (tcplclib_tc2_mc2): ST_PositionCompensationTableElement {Position:
uncorrected position, for example the set position; Compensation: additive}, both LREAL; equidistant and increasing;
ST_PositionCompensationTableParameter {MinPosition, MaxPosition, NoOfTableElements, Direction, Modulo};
E_WorkDirection WorkDirectionBoth, WorkDirectionPositive, WorkDirectionNegative. Not said there: whether the last
position of a modulo table repeats the first (here it does, 0 and 360), and what the block does between positions
(here: straight lines). On what a position correction is added to, its pages differ: the target position (NC, Other
Settings), or the actual position (MC_PositionCorrectionLimiter), where a positive value moves the axis in the
negative direction.
"""

import re
from dataclasses import dataclass
from math import pi
from types import MappingProxyType
from typing import ClassVar

import numpy as np

from ....base.quantities import shown
from ..content import OrderContent
from ..format import Held, OfPoints
from ..points import Points, Unfit, content_of, float_in, rows_of, said_by
from .code import refuse_name, st_real

DEGREE = pi / 180.0
SIGNS = MappingProxyType({"command": 1.0, "actual": -1.0})
ELEMENT = re.compile(r"\( *Position *:= *([^,]{1,60}), *Compensation *:= *([^)]{1,60})\),?")
ARRAY = re.compile(r"(\w+) *: *ARRAY *\[0\.\.([0-9]{1,6})\] *OF *ST_PositionCompensationTableElement *:= *\[")


@dataclass(frozen=True)
class TwinCat(OfPoints):
    """Global variables for TwinCAT 3, positions and compensations in degrees of the output.

    Attributes
    ----------
    points : int, optional
        Elements of the array, both ends included. Default: 32 a period of the highest order, at least 65.
    variable : str
        Name of the array; its parameters are called the same with `Parameter`.
    added_to : str
        What the axis adds a compensation to: "command" (default), or "actual", for which the values change their sign.
    """

    points: int | None = None
    variable: str = "OrderTable"
    added_to: str = "command"
    name: ClassVar[str] = "twincat"
    title: ClassVar[str] = "TwinCAT's position compensation"
    unit: ClassVar[str | None] = "rad"
    turn: ClassVar[str | None] = "output"
    both_ways: ClassVar[bool] = True
    ends: ClassVar[int] = 1
    more: ClassVar[str] = "; give more points"
    begin: ClassVar[str] = "(?s).{0,8000}ST_PositionCompensationTableElement"

    def __post_init__(self) -> None:
        super().__post_init__()
        refuse_name("variable", self.variable)
        if self.added_to not in SIGNS:
            raise ValueError(f"added_to is {shown(self.added_to)}; it must be 'command' or 'actual'")
        if self.points is not None and self.points < 3:
            raise ValueError(f"points is {self.points}; a table needs 3 at least")

    def size(self) -> float:
        """A degree, to be added or taken off."""
        return SIGNS[self.added_to] * DEGREE

    def text(self, table: OrderContent, held: Held, comments: list[str]) -> str:
        """Write one array, or one for each direction of motion."""
        points = held.numbers
        rows = [*(f"// {line}" for line in comments), "VAR_GLOBAL"]
        if points.backward is None:
            rows += self._array("", points.forward, "WorkDirectionBoth")
        else:
            rows += self._array("Positive", points.forward, "WorkDirectionPositive")
            rows += self._array("Negative", points.backward, "WorkDirectionNegative")
        return "\n".join([*rows, "END_VAR"]) + "\n"

    def _array(self, suffix: str, values: np.ndarray, direction: str) -> list[str]:
        count = len(values)
        type_name = "ST_PositionCompensationTable"
        rows = [f"    {self.variable}{suffix} : ARRAY[0..{count}] OF {type_name}Element := ["]
        for i in range(count + 1):
            end = "" if i == count else ","
            position, value = st_real(360.0 * i / count), st_real(float(values[i % count]))
            rows.append(f"        (Position := {position}, Compensation := {value}){end}")
        return [
            *rows, "    ];",
            f"    {self.variable}{suffix}Parameter : {type_name}Parameter := (MinPosition := 0.0, "
            f"MaxPosition := 360.0, NoOfTableElements := {count + 1}, Direction := {direction}, Modulo := TRUE);",
        ]  # fmt: skip

    def parse(self, text: str) -> OrderContent:
        """Read one array or two."""
        fields, _ = said_by(text)
        arrays: dict[str, list[tuple[float, float]]] = {}
        counts: dict[str, int] = {}
        name = ""
        for number, plain in rows_of(text):
            if (match := ARRAY.match(plain)) is not None:
                name = match.group(1)
                if name in arrays:
                    raise Unfit(number, name[:40], "is there twice; leave one out")
                arrays[name], counts[name] = [], int(match.group(2)) + 1
            elif (match := ELEMENT.fullmatch(plain)) is not None and name:
                position, value = [float_in(number, name[:40], part) for part in match.groups()]
                arrays[name].append((position, value))
            elif plain.startswith("("):
                raise Unfit(number, name[:40] or "file", f"{shown(plain[:60])} is no element of a table; correct it")
        for name, elements in arrays.items():
            _check(name[:40], elements, counts[name])
        sides = [self.size() * np.array([value for _, value in elements[:-1]]) for elements in arrays.values()]
        if len(sides) not in (1, 2) or (len(sides) == 2 and len(sides[0]) != len(sides[1])):
            raise Unfit(1, "file", f"has {len(sides)} tables; one, or two of one size, can be read")
        if len(sides) == 2 and not next(iter(arrays)).endswith("Positive"):
            sides = sides[::-1]
        points = Points(sides[0], sides[1] if len(sides) == 2 else None)
        return content_of(points, {"unit": "rad", "turn": "output"} | fields)


def _check(name: str, elements: list[tuple[float, float]], wanted: int) -> None:
    if len(elements) != wanted or wanted < 3:
        raise Unfit(1, name, f"has {len(elements)} elements where it names {wanted}; it may be cut off")
    places = np.array([at for at, _ in elements])
    step = 360.0 / (wanted - 1)
    if np.max(np.abs(places - step * np.arange(wanted))) > 1e-6 * step:
        raise Unfit(1, name, "has positions that are not equidistant from 0 to 360; only such can be read as orders")
    if elements[0][1] != elements[-1][1]:
        raise Unfit(1, name, "ends with another compensation than it begins with, one turn apart; correct one")
