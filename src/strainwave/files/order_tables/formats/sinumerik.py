"""SINUMERIK: part program that fills the encoder error compensation $AA_ENC_COMP of a rotary axis.

Confirmed by Siemens' Function Manuals (Extended Functions, K3: Compensations, 03/2013, 6FC5397-1BP40-3BA1; SINUMERIK
808D, 01/2017): $AA_ENC_COMP[e,N,AXi] value of point N, 8 bytes; _STEP, _MIN and _MAX in the unit of the axis; with
_IS_MODULO 1 the table repeats, 0 to 360 degrees with both ends given; straight lines between the points; the value is
added to the actual position, a positive one moves the axis in the negative direction, so it is the negative of our
correction, and the axis jumps by the value at its reference point when the table begins to act. The 808D holds 200
points, others MD38000 $MA_MM_ENC_COMP_MAX_POINTS. Values are written while MD32700 $MA_ENC_COMP_ENABLE is 0, and act
with 1 on a referenced axis, alike in both directions.
"""

import re
from dataclasses import dataclass
from math import pi
from typing import ClassVar

import numpy as np

from ....base.quantities import positive_count, shown
from ..content import OrderContent
from ..format import Held, OfPoints
from ..points import MOST_POINTS, Points, Unfit, content_of, enter, float_in, rows_of, said_by, whole_in

DIGITS, DEGREE = 9, pi / 180.0
AXIS = re.compile(r"[A-Z][A-Z0-9_]{0,31}")
ASSIGNED = re.compile(
    r"\$AA_ENC_COMP(_STEP|_MIN|_MAX|_IS_MODULO)?\[([01]),(?:([0-9]{1,6}),)?([A-Z][A-Z0-9_]*)\] *= *(\S+)"
)
MOST = MOST_POINTS + 1


@dataclass(frozen=True)
class Sinumerik(OfPoints):
    """Part program for $AA_ENC_COMP.

    Attributes
    ----------
    axis : str
        Name of the machine axis.
    capacity : int
        Points that the control holds, both ends included: 200, or MD38000.
    points : int, optional
        Points of the file, both ends included. Default: 32 a period of the highest order, as far as they go.
    """

    axis: str = "AX1"
    capacity: int = 200
    points: int | None = None
    name: ClassVar[str] = "sinumerik"
    title: ClassVar[str] = "SINUMERIK's $AA_ENC_COMP"
    unit: ClassVar[str | None] = "rad"
    turn: ClassVar[str | None] = "output"
    ends: ClassVar[int] = 1
    decimals: ClassVar[int | None] = DIGITS
    more: ClassVar[str] = "; set MD38000 $MA_MM_ENC_COMP_MAX_POINTS and give it as capacity"
    begin: ClassVar[str] = r"(?s).{0,8000}\$AA_ENC_COMP\["

    def __post_init__(self) -> None:
        if not isinstance(self.axis, str) or not AXIS.fullmatch(self.axis):
            raise ValueError(f"axis is {shown(self.axis)}; give the name of a machine axis, for example 'AX1'")
        capacity = positive_count("capacity", self.capacity, MOST)
        if capacity < 3:
            raise ValueError(f"capacity is {capacity}; a table needs 3 points at least")
        if self.points is not None and not 3 <= positive_count("points", self.points) <= capacity:
            raise ValueError(f"points is {self.points}; the control holds 3 to {capacity}: {self.more[2:]}")

    def most(self) -> int:
        """How many points the control holds."""
        return self.capacity

    def size(self) -> float:
        """A degree, to be taken off."""
        return -DEGREE

    def text(self, table: OrderContent, held: Held, comments: list[str]) -> str:
        """Write the program, both ends of the turn included."""
        points = held.numbers
        count = len(points.forward)
        rows = ["%_N_" + self.axis + "_EEC_INI", *(f"; {line}" for line in comments), "CHANDATA(1)"]
        for i in range(count + 1):
            rows.append(f"$AA_ENC_COMP[0,{i},{self.axis}]={float(points.forward[i % count]) + 0.0:.{DIGITS}f}")
        rows += [
            f"$AA_ENC_COMP_STEP[0,{self.axis}]={360.0 / count!r}",
            f"$AA_ENC_COMP_MIN[0,{self.axis}]=0.0",
            f"$AA_ENC_COMP_MAX[0,{self.axis}]=360.0",
            f"$AA_ENC_COMP_IS_MODULO[0,{self.axis}]=1",
            "M17",
        ]
        return "\n".join(rows) + "\n"

    def parse(self, text: str) -> OrderContent:
        """Read the assignments; other blocks of the program are not looked at."""
        fields, _ = said_by(text)
        values: dict[int, float] = {}
        settings: dict[str, float] = {}
        for number, line in rows_of(text):
            if not line.upper().startswith("$AA_ENC_COMP"):
                continue
            match = ASSIGNED.match(line)
            if match is None or (match.group(1) is None) is (match.group(3) is None):
                raise Unfit(number, "file", f"{shown(line[:60])} is no assignment of $AA_ENC_COMP; correct it")
            kind, _, place, _, value = match.groups()
            if place is None:
                settings[kind] = float_in(number, f"$AA_ENC_COMP{kind}", value)
            else:
                at = whole_in(number, "point", place, 0, MOST - 1)
                enter(values, number, f"point {at}", at, float_in(number, f"point {at}", value))
        if set(settings) != {"_STEP", "_MIN", "_MAX", "_IS_MODULO"}:
            raise Unfit(1, "file", "has not all of _STEP, _MIN, _MAX and _IS_MODULO; it may be cut off")
        if (settings["_MIN"], settings["_MAX"], settings["_IS_MODULO"]) != (0.0, 360.0, 1.0):
            raise Unfit(
                1, "file", "is no table over 0 .. 360 degrees with modulo; only such a one can be read as orders"
            )
        count = len(values) - 1
        if count < 2 or set(values) != set(range(count + 1)) or abs(settings["_STEP"] * count - 360.0) > 1e-6:
            raise Unfit(1, "file", f"has {len(values)} points, which do not fill 360 degrees; it may be cut off")
        if values[0] != values[count]:
            raise Unfit(1, f"point {count}", "differs from point 0, which it repeats; correct one")
        return content_of(
            Points(-DEGREE * np.array([values[i] for i in range(count)])), {"unit": "rad", "turn": "output"} | fields
        )
