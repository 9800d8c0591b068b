"""Beckhoff: start-up list of AX8000 and AMP8000, and the position compensation of TwinCAT 3."""

import math
import re
import struct
from dataclasses import dataclass
from math import pi
from types import MappingProxyType

import numpy as np

from ....base.quantities import shown
from ....model.excitation import Line
from ..content import OrderContent, positive, shifted
from ..format import Held, OfPoints, OrderFormat
from ..points import Points, Unfit, content_of, enter, float_in, rows_of, said_by, whole_in
from .code import refuse_name, st_real

HIGHEST_ORDER, COEFFICIENTS, FIRST = 200, 9, 7
INDEX = {"A": 0x32CB, "B": 0x36CB}
ROW = re.compile(r"0x(32CB|36CB):([0-9A-F]{2}) +(INT16|UINT32|REAL32) +(\S+) +([0-9A-F]+)", re.IGNORECASE)
LARGEST32 = float(np.finfo(np.float32).max)
PACKING = {"INT16": "<h", "UINT32": "<I", "REAL32": "<f"}
KINDS, WHAT = ("UINT32", "REAL32", "REAL32"), ("n", "phi, degrees", "r, N*m")  # of a coefficient


@dataclass(frozen=True)
class Beckhoff(
    OrderFormat, name="beckhoff", title="Beckhoff 0x32CB", unit="N*m", turn="motor",
    with_mean=False, most_lines=COEFFICIENTS, width=12, begin=r"\s*0x3[26]CB:",
):  # fmt: skip
    """Start-up list of object 0x32CB.

    Confirmed by the object pages of Beckhoff's Information System (infosys.beckhoff.com, ax8xxx_object,
    amp8000_object): 0x32CB (channel A) and 0x36CB (B); :01 control, INT16, 3 for the parameters of the start-up list;
    :02 gain, REAL32, 0 to 2; coefficient k: :(07+3k) n, UINT32, 0 to 200; :(08+3k) phi, REAL32, 0 to 360 degrees;
    :(09+3k) r, REAL32, from 0, in N*m. Some listings name k = 9 too. Not said in public: whether the torque is r cos or
    r sin(n angle + phi), from where and in which sense the angle counts, and the sign; 3241:0C shows the torque that
    the drive adds, compare it with the table at a slow turn. No public text format of a start-up list is known: the
    file is a table to be entered or scripted.

    Attributes
    ----------
    channel : str
        "A" or "B" of the drive.
    wave : str
        "cos" (default) or "sin": what the drive takes of n angle + phi.
    """

    channel: str = "A"
    wave: str = "cos"

    def __post_init__(self) -> None:
        if self.channel not in INDEX or self.wave not in ("cos", "sin"):
            raise ValueError(
                f"channel is {shown(self.channel)} and wave {shown(self.wave)}; take A or B, and cos or sin"
            )

    @property
    def _offset(self) -> float:
        """What the drive's phase has beyond that of a cosine [rad]."""
        return 0.5 * math.pi if self.wave == "sin" else 0.0

    def highest(self, table: OrderContent) -> int:
        """The largest n."""
        return HIGHEST_ORDER

    def why_highest(self, table: OrderContent) -> str:
        """What limits n."""
        return "n goes from 0 to 200"

    def store(self, table: OrderContent) -> Held:
        """Round phases [degrees] and amplitudes to 32 bits."""
        numbers = []
        for line in shifted(table.lines, table.zero):
            if line.amplitude > LARGEST32:
                raise ValueError(f"order {line.order} has {line.amplitude:g} N*m; REAL32 ends at {LARGEST32:.3g}")
            phi = np.float32(math.degrees(math.fmod(line.phase + self._offset, 2.0 * math.pi)) % 360.0)
            numbers.append((line.order, float(phi) % 360.0, float(np.float32(line.amplitude))))
        stored = OrderContent(_lines(numbers, self._offset, table.zero), unit="N*m")
        quantum = max((float(np.spacing(np.float32(line.amplitude))) for line in table.lines), default=0.0)
        return Held(stored.one_direction, table.one_direction, numbers, quantum)

    def text(self, table: OrderContent, held: Held, comments: list[str]) -> str:
        """Write index:subindex, type, value, the bytes in the order of the bus, and what it is."""
        numbers = held.numbers
        rows = [self._row(1, "INT16", 3, "control: use the start-up list"), self._row(2, "REAL32", 1.0, "gain")]
        for k, triple in enumerate([*numbers, *[(0, 0.0, 0.0)] * (COEFFICIENTS - len(numbers))]):
            for i, (kind, what, value) in enumerate(zip(KINDS, WHAT, triple, strict=True), FIRST + 3 * k):
                rows.append(self._row(i, kind, value, f"coefficient {k} {what}"))
        return "\n".join([*(f"# {line}" for line in comments), *rows]) + "\n"

    def _row(self, sub: int, kind: str, value: float, what: str) -> str:
        data = struct.pack(PACKING[kind], value).hex().upper()
        return f"0x{INDEX[self.channel]:04X}:{sub:02X} {kind:<6} {value!r:<24} {data:<8} # {what}"

    def parse(self, text: str) -> OrderContent:
        """Read the rows; a coefficient with r = 0 is none."""
        fields, _ = said_by(text)
        values: dict[int, float] = {}
        for number, line in rows_of(text):
            match = ROW.match(line)
            if match is None:
                raise Unfit(
                    number, "file", f"{shown(line[:60])} is no row of 0x32CB; write index:subindex type value data"
                )
            _, sub, kind, value, data = match.groups()
            at = int(sub, 16)
            enter(values, number, f"subindex {sub}", at, _checked(number, at, kind.upper(), value, data))
        gain = values.get(2, 1.0)
        numbers = []
        for k in range(COEFFICIENTS + 1):
            n, phi, r = [values.get(FIRST + 3 * k + i, math.nan) for i in range(3)]
            whole = not math.isnan(n + phi + r)
            if not whole and k < COEFFICIENTS:
                raise Unfit(1, f"coefficient {k}", "is not whole in the list; it may be cut off")
            if whole and r > 0.0:
                numbers.append((int(n), phi, gain * r))
        constant = sum(r * math.cos(math.radians(phi) - self._offset) for n, phi, r in numbers if n == 0)
        lines = _lines([triple for triple in numbers if triple[0] > 0], self._offset, fields.get("zero", 0.0))
        return OrderContent(**{"unit": "N*m"} | fields, lines=lines, mean=constant)


def _lines(numbers: list[tuple[int, float, float]], offset: float, zero: float) -> tuple[Line, ...]:
    return shifted(positive([Line(n, r, math.radians(phi) - offset) for n, phi, r in numbers]), -zero)


def _checked(line: int, sub: int, kind: str, value: str, data: str) -> float:
    """Value of a row, which its bytes must repeat."""
    number = float(whole_in(line, "value", value, 0, 10**9)) if kind != "REAL32" else float_in(line, "value", value)
    place = (sub - FIRST) % 3 if sub >= FIRST else -1
    low, high = {0: (0.0, 200.0), 1: (0.0, 360.0), 2: (0.0, LARGEST32)}.get(place, (0.0, 4.0 if sub == 1 else 2.0))
    if not (low <= number <= high and 1 <= sub <= FIRST + 3 * (COEFFICIENTS + 1) - 1):
        raise Unfit(line, f"subindex {sub:02X}", f"is {number:g}; it must be from {low:g} to {high:g}")
    packed = struct.pack(PACKING[kind], int(number) if kind != "REAL32" else number).hex()
    if packed != data.lower():
        raise Unfit(line, f"subindex {sub:02X}", f"is {number:g} and its bytes are {data}; write both alike")
    return number


DEGREE = pi / 180.0
SIGNS = MappingProxyType({"command": 1.0, "actual": -1.0})
ELEMENT = re.compile(r"\( *Position *:= *([^,]{1,60}), *Compensation *:= *([^)]{1,60})\),?")
ARRAY = re.compile(r"(\w+) *: *ARRAY *\[0\.\.([0-9]{1,6})\] *OF *ST_PositionCompensationTableElement *:= *\[")


@dataclass(frozen=True)
class TwinCat(
    OfPoints, name="twincat", title="TwinCAT's position compensation", unit="rad", turn="output",
    both_ways=True, width=16, ends=1, more="; give more points",
    begin="(?s).{0,8000}ST_PositionCompensationTableElement",
):  # fmt: skip
    """Global variables for TwinCAT 3, positions and compensations in degrees of the output.

    Confirmed by Beckhoff's Information System (tcplclib_tc2_mc2): ST_PositionCompensationTableElement {Position:
    uncorrected position, for example the set position; Compensation: additive}, both LREAL; equidistant and increasing;
    ST_PositionCompensationTableParameter {MinPosition, MaxPosition, NoOfTableElements, Direction, Modulo};
    E_WorkDirection WorkDirectionBoth, WorkDirectionPositive, WorkDirectionNegative. Not said there: whether the last
    position of a modulo table repeats the first (here it does, 0 and 360), and what the block does between positions
    (here: straight lines). On what a position correction is added to, its pages differ: the target position (NC, Other
    Settings), or the actual position (MC_PositionCorrectionLimiter), where a positive value moves the axis in the
    negative direction.

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
        rows, values = [*(f"// {line}" for line in comments), "VAR_GLOBAL"], held.numbers.values
        for direction, side in zip(("Both",) if len(values) == 1 else ("Positive", "Negative"), values, strict=True):
            rows += self._array("" if direction == "Both" else direction, side, f"WorkDirection{direction}")
        return "\n".join([*rows, "END_VAR"]) + "\n"

    def _array(self, suffix: str, values: np.ndarray, direction: str) -> list[str]:
        count = len(values)
        type_name = "ST_PositionCompensationTable"
        pairs = [(st_real(360.0 * i / count), st_real(float(values[i % count]))) for i in range(count + 1)]
        return [
            f"    {self.variable}{suffix} : ARRAY[0..{count}] OF {type_name}Element := [",
            ",\n".join(f"        (Position := {at}, Compensation := {value})" for at, value in pairs), "    ];",
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
        return content_of(Points(np.array(sides)), {"unit": "rad", "turn": "output"} | fields)


def _check(name: str, elements: list[tuple[float, float]], wanted: int) -> None:
    if len(elements) != wanted or wanted < 3:
        raise Unfit(1, name, f"has {len(elements)} elements where it names {wanted}; it may be cut off")
    places = np.array([at for at, _ in elements])
    step = 360.0 / (wanted - 1)
    if np.max(np.abs(places - step * np.arange(wanted))) > 1e-6 * step:
        raise Unfit(1, name, "has positions that are not equidistant from 0 to 360; only such can be read as orders")
    if elements[0][1] != elements[-1][1]:
        raise Unfit(1, name, "ends with another compensation than it begins with, one turn apart; correct one")
