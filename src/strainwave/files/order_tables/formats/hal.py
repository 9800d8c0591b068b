"""LinuxCNC: a component for HAL (source for halcompile), for tables that the compensation file cannot hold.

Confirmed by LinuxCNC's documentation of halcompile: `component NAME`, `pin in float`, `pin out float`, `function _`,
`license`, `;;`, C below; the name of the file is that of the component. The component reads position [degrees] and
velocity [degrees/s] of the joint and gives the correction [degrees], which a sum2 of HAL adds to the motor's command;
that connection is the integrator's, and joint.N.motor-pos-fb must lose it again.
"""

import re
from dataclasses import dataclass
from typing import ClassVar

from ....base.quantities import shown
from ....model.excitation import HIGHEST, Line
from ..content import OrderContent
from ..format import Exact, Held
from ..points import Unfit, acting, float_in, rows_of, said_by, two_ways, ways, whole_in

LINE = re.compile(r"\{([0-9.]{1,12}), ([^,{}]{1,60}), ([^,{}]{1,60})\},?")
SET = re.compile(r"static const double (forward|backward)\[([0-9]{1,6})\]\[3\] = \{")
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
class HalComponent(Exact):
    """Source of a component for LinuxCNC's HAL.

    Attributes
    ----------
    component : str
        Name of the component, and of the file before `.comp`.
    """

    component: str = "order_table"
    name: ClassVar[str] = "hal"
    title: ClassVar[str] = "a HAL component"
    unit: ClassVar[str | None] = "rad"
    both_ways: ClassVar[bool] = True
    with_delay: ClassVar[bool] = True

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
        sets: dict[str, list[Line]] = {}
        counts: dict[str, int] = {}
        side = ""
        for number, plain in rows_of(text):
            if (match := SET.fullmatch(plain)) is not None:
                side = match.group(1)
                sets[side], counts[side] = [], int(match.group(2))
            elif (match := LINE.fullmatch(plain)) is not None and side:
                order, amplitude, phase = [float_in(number, side, part) for part in match.groups()]
                sets[side].append(Line(whole_in(number, "order", f"{order:.0f}", 0, HIGHEST), amplitude, phase))
        means = {side: float_in(1, f"mean_{side}", value) for side, value in MEAN.findall(text)}
        for side in sets:
            if len(sets[side]) != counts[side] or side not in means:
                raise Unfit(1, side, f"has {len(sets[side])} lines where it names {counts[side]}; it may be cut off")
        if "forward" not in sets or "\ncorrection = " not in text:
            raise Unfit(1, "file", "is no whole component; it may be cut off, write it again")
        content = {side: (means[side], tuple(line for line in lines if line.order > 0)) for side, lines in sets.items()}
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
