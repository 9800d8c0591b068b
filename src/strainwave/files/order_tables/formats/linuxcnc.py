"""LinuxCNC: the compensation file of a joint, and a component for HAL for what that file cannot hold."""

import math
import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from ....base.quantities import interval, positive_count, shown
from ....base.results import Floats
from ....model.excitation import HIGHEST, Line
from ..content import OrderContent
from ..format import Exact, Held, OfPoints
from ..points import Points, Side, Unfit, acting, content_of, float_in, said_by, two_ways, ways, whole_in

POINTS, DIGITS = 256, 9
DEGREE = math.pi / 180.0
QUANTUM = 10.0**-DIGITS * DEGREE  # rad


@dataclass(frozen=True)
class LinuxCnc(
    OfPoints, name="linuxcnc", title="LinuxCNC's COMP_FILE", unit="rad", both_ways=True, width=24,
    ends=1, decimals=DIGITS, more="; take a shorter span, or write the format hal",
):  # fmt: skip
    """Compensation file of a rotary joint in degrees.

    Confirmed by LinuxCNC's sources (emc/motion: usrmotintf.cc, command.c, control.c, motion.h): at most 256 points,
    nominal positions strictly increasing; nominal - forward is added to the command of the motor while the joint moves
    up, nominal - reverse while it moves down, the last one at rest, and followed within the joint's velocity and
    acceleration; straight lines between the points, constant beyond the ends; corrections are kept in 32 bits; a
    compensation file replaces BACKLASH. Reading stops at the first line that is not three numbers, so the remarks stand
    at the end. The file covers the travel of the joint, not a turn that repeats.

    Attributes
    ----------
    span : (float, float)
        First and last position of the joint [degrees], whole turns of the table's shaft apart.
    points : int, optional
        Lines of the file, at most 256. Default: 32 a period of the highest order, as far as 256 go.
    """

    span: tuple[float, float] = (0.0, 360.0)
    points: int | None = None

    def __post_init__(self) -> None:
        interval("span", self.span)
        if self.points is not None:
            count = positive_count("points", self.points)
            if not 3 <= count <= POINTS:
                raise ValueError(
                    f"points is {count}; LinuxCNC's COMP_FILE holds 3 to {POINTS}, beyond that write the format hal"
                )

    def most(self) -> int:
        """How many points the control holds."""
        return POINTS

    def entries(self, table: OrderContent, held: Held) -> int:
        """Points, each of both directions of motion."""
        return held.points or 0

    def size(self) -> float:
        """A degree."""
        return DEGREE

    def start(self, table: OrderContent) -> float:
        """Angle of the table's shaft [rad] at the begin of the span."""
        return self.span[0] * DEGREE * _ratio(table)

    def kept(self, values: Floats) -> Floats:
        """Corrections in 32 bits."""
        return values.astype(np.float32).astype(float)

    def turns(self, table: OrderContent) -> int:
        """Whole turns of the table's shaft over the span."""
        turns = (self.span[1] - self.span[0]) / 360.0 * _ratio(table)
        if abs(turns - round(turns)) > 1e-6 or round(turns) < 1:
            raise ValueError(
                f"the span of {self.span[0]:g} .. {self.span[1]:g} degrees is {turns:.6g} turns of the {table.turn}; "
                f"take whole ones, {360.0 / _ratio(table):.6g} degrees each"
            )
        return round(turns)

    def text(self, table: OrderContent, held: Held, comments: list[str]) -> str:
        """Write nominal, forward and reverse, and the remarks below them."""
        points = held.numbers
        low, high = self.span
        rows = []
        for i in range(points.length + 1):
            nominal = round(low + (high - low) * i / points.length, DIGITS)
            ends = nominal - points.values[[0, -1], i % points.length]
            rows.append(" ".join(f"{value:.{DIGITS}f}" for value in (nominal, *ends)))
        return "\n".join([*rows, "", *(f"# {line}" for line in comments)]) + "\n"

    def parse(self, text: str) -> OrderContent:
        """Read the lines up to the first that is not three numbers."""
        fields, _ = said_by(text)
        rows: list[list[float]] = []
        for number, line in enumerate(text.splitlines(), start=1):
            cells = line.split()
            if len(cells) != 3 or cells[0].startswith("#"):
                break
            rows.append([float_in(number, "position", cell) for cell in cells])
            if len(rows) > POINTS:
                raise Unfit(number, "file", f"has more than {POINTS} points; LinuxCNC takes no more, leave some out")
            if len(rows) > 1 and rows[-1][0] <= rows[-2][0]:
                raise Unfit(number, "nominal", f"{shown(cells[0])} does not increase; LinuxCNC refuses it")
        if len(rows) < 3:
            raise Unfit(1, "file", f"begins with {len(rows)} lines of three numbers; it may be cut off")
        table = np.array(rows)
        return content_of(_points(table, fields), {"unit": "rad", "turn": "output"} | fields)


def _ratio(table: OrderContent) -> float:
    """Turns of the table's shaft per turn of the joint."""
    if table.turn == "output":
        return 1.0
    if table.ratio is None:
        raise ValueError("the orders count on the motor turn and the joint is the output; give the table its ratio")
    return table.ratio


def _points(table: Any, fields: dict[str, Any]) -> Points:
    """Points in rad of lines that are equidistant over whole turns."""
    nominal = table[:, 0]
    steps = np.diff(nominal)
    step = (nominal[-1] - nominal[0]) / len(steps)
    if np.max(np.abs(steps - step)) > 1e-6 * step + 2.0 * 10.0**-DIGITS:
        raise Unfit(1, "nominal", "is not equidistant; strainwave reads equidistant tables")
    ratio = fields.get("ratio", 1.0) if fields.get("turn", "output") == "motor" else 1.0
    turns = (nominal[-1] - nominal[0]) / 360.0 * ratio
    if abs(turns - round(turns)) > 1e-6 * max(1.0, turns) or round(turns) < 1:
        raise Unfit(len(nominal), "nominal", f"ends after {turns:.6g} turns; only whole turns can be read as orders")
    trims = (nominal[:, None] - table[:, 1:]) * DEGREE
    if np.max(np.abs(trims[0] - trims[-1])) > 3.0 * QUANTUM:
        raise Unfit(len(nominal), "file", "ends with another correction than it begins with, whole turns apart")
    sides = 1 if np.array_equal(trims[:-1, 0], trims[:-1, 1]) else 2
    return Points(trims[:-1, :sides].T, round(turns), float(nominal[0]) * DEGREE * ratio)


LINE = re.compile(r"\{([0-9.]{1,12}), ([^,{}]{1,60}), ([^,{}]{1,60})\},?")
SET = re.compile(r"static const double (forward|backward)\[([0-9]{1,6})\]\[3\] = \{([^;]*)\};")
MEAN = re.compile(r"static const double mean_(forward|backward) = ([^;]{1,60});")

BODY = """
double angle = position * 0.017453292519943295 * per_turn + zero + delay * velocity * 0.017453292519943295 * per_turn;
double total = 0.0;
int i;
if (velocity < 0.0) {
BACK} else {
AHEAD}
correction = total * 57.29577951308232;
"""
SUM = """    total = mean_WAY;
    for (i = 0; i < COUNT; i++)
        total += WAY[i][1] * cos(WAY[i][0] * angle + WAY[i][2]);
"""


@dataclass(frozen=True)
class HalComponent(Exact, name="hal", title="a HAL component", unit="rad"):
    """Source of a component for LinuxCNC's HAL.

    Confirmed by LinuxCNC's documentation of halcompile: `component NAME`, `pin in float`, `pin out float`, `function
    _`, `license`, `;;`, C below; the name of the file is that of the component. The component reads position [degrees]
    and velocity [degrees/s] of the joint and gives the correction [degrees], which a sum2 of HAL adds to the motor's
    command; that connection is the integrator's, and joint.N.motor-pos-fb must lose it again.

    Attributes
    ----------
    component : str
        Name of the component, and of the file before `.comp`.
    """

    component: str = "order_table"

    def __post_init__(self) -> None:
        if not isinstance(self.component, str) or not re.fullmatch(r"[a-z][a-z0-9_]{0,40}", self.component):
            raise ValueError(f"component is {shown(self.component)}; give a name of small letters and digits")

    def store(self, table: OrderContent) -> Held:
        """Keep everything as it is; the ratio of the gear must be known where orders count on the motor."""
        if table.turn == "motor" and table.ratio is None:
            raise ValueError("the orders count on the motor turn and the joint is the output; give the table its ratio")
        return super().store(table)

    def text(self, table: OrderContent, held: Held, comments: list[str]) -> str:
        """Write the declarations and the code."""
        per_turn = table.ratio if table.turn == "motor" else 1.0
        rows = [
            *(f"// {line}" for line in comments),
            f'component {self.component} "Correction of a joint by orders of its drive, from strainwave";',
            'pin in float position "position of the joint, degrees";',
            'pin in float velocity "velocity of the joint, degrees/s";',
            'pin out float correction "to be added to the command, degrees";',
            "option period no;", "function _;", 'license "GPL";', "include <rtapi_math.h>;", ";;",
            f"static const double per_turn = {per_turn!r};  // turns of the table's shaft per turn of the joint",
            f"static const double zero = {table.zero!r};", f"static const double delay = {table.delay!r};",
            *(row for one in ways(table) for row in _set(*one)), "FUNCTION(_) {",
        ]  # fmt: skip
        ahead, back = ["" if lines is None else _sum(*lines) for lines in acting(table)]
        return "\n".join(rows) + BODY.replace("BACK", back).replace("AHEAD", ahead) + "}\n"

    def parse(self, text: str) -> OrderContent:
        """Read the lines of the component."""
        fields, _ = said_by(text)
        means = {side: float_in(1, f"mean_{side}", value) for side, value in MEAN.findall(text)}
        content: dict[str, Side] = {}
        for side, count, body in SET.findall(text):
            rows = [[float_in(1, side, cell) for cell in row] for row in LINE.findall(body)]
            if len(rows) != int(count) or side not in means:
                raise Unfit(1, side, f"has {len(rows)} lines where it names {count}; it may be cut off")
            lines = (Line(whole_in(1, "order", f"{n:.0f}", 0, HIGHEST), size, phase) for n, size, phase in rows)
            content[side] = means[side], tuple(line for line in lines if line.order > 0)
        if "forward" not in content or "\ncorrection = " not in text:
            raise Unfit(1, "file", "is no whole component; it may be cut off, write it again")
        return two_ways({"unit": "rad"} | fields, content)


def _sum(way: str, lines: tuple[Line, ...]) -> str:
    return SUM.replace("WAY", way).replace("COUNT", str(len(lines)))


def _set(way: str, mean: float, lines: tuple[Line, ...]) -> list[str]:
    shown_lines = lines or (Line(0, 0.0, 0.0),)  # C has no empty arrays
    rows = [f"    {{{float(line.order)!r}, {line.amplitude!r}, {line.phase!r}}}," for line in shown_lines]
    return [
        f"static const double mean_{way} = {mean!r};", f"static const double {way}[{len(shown_lines)}][3] = {{", *rows,
        "};",
    ]  # fmt: skip
