"""mjbots moteus: the table of currents that its firmware adds in position mode, as lines of its configuration.

Confirmed by the firmware (mjbots/moteus, fw/bldc_servo.h, bldc_servo_structs.h) and its utils/compensate_cogging.py:
1024 values int8 over one turn of the commutation encoder, times cogging_dq_scale a current of the q axis [A], straight
lines between them and around, added to the current of position mode. The current is the torque over the torque constant
of the rotor. `moteus_tool --write-config` sends every line as it is, so the file has no remarks; what belongs to the
table beside its values is given again when it is read. Not confirmed: the sign of current and angle of a given motor.
"""

import re
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ....base.quantities import number, shown
from ..content import OrderContent
from ..format import Held, OrderFormat
from ..points import Points, Unfit, content_of, enter, float_in, highest_order, motion, rows_of, sampled, whole_in

POINTS, MOST = 1024, 127
SCALE = re.compile(r"conf set motor\.cogging_dq_scale (\S+)")
VALUE = re.compile(r"conf set motor\.cogging_dq_comp\.([0-9]{1,6}) (\S+)")


@dataclass(frozen=True)
class Moteus(OrderFormat):
    """Configuration of a moteus controller.

    Attributes
    ----------
    torque_constant : float
        Torque of the rotor per current of the q axis [N*m/A].
    """

    torque_constant: float
    name: ClassVar[str] = "moteus"
    title: ClassVar[str] = "moteus"
    unit: ClassVar[str | None] = "N*m"
    turn: ClassVar[str | None] = "motor"
    begin: ClassVar[str] = r"(?s).{0,4000}conf set motor\.cogging_dq_"

    def __post_init__(self) -> None:
        number("torque_constant", self.torque_constant, positive=True)

    def highest(self, table: OrderContent) -> int:
        """Two of the points a period."""
        return highest_order(POINTS)

    def why_highest(self, table: OrderContent) -> str:
        """The number of points."""
        return f"two of its {POINTS} points a period"

    def store(self, table: OrderContent) -> Held:
        """Round currents to 127 steps of the largest one."""
        exact = sampled(table, POINTS)
        current = exact.forward / self.torque_constant
        largest = float(np.max(np.abs(current)))
        if not largest <= float(np.finfo(np.float32).max):
            raise ValueError(f"the table asks for {largest:.3g} A, beyond 32 bits; check torque_constant")
        scale = float(np.float32(largest / MOST)) or 1.0
        values = np.clip(np.round(current / scale), -MOST, MOST)
        points = Points(values * (scale * self.torque_constant))
        stored = motion(points, table.zero)
        quantum = scale * self.torque_constant
        return Held(stored, motion(exact, table.zero), (scale, values.astype(int).tolist()), quantum, POINTS)

    def text(self, table: OrderContent, held: Held, comments: list[str]) -> str:
        """Write the lines of the configuration, all of which are sent to the controller."""
        scale, values = held.numbers
        rows = [f"conf set motor.cogging_dq_comp.{i} {value}" for i, value in enumerate(values)]
        return "\n".join([f"conf set motor.cogging_dq_scale {scale!r}", *rows, "conf write"]) + "\n"

    def parse(self, text: str) -> OrderContent:
        """Read scale and values; other lines are not looked at."""
        scale: float | None = None
        values: dict[int, int] = {}
        for line_number, line in rows_of(text):
            if (found := SCALE.fullmatch(line)) is not None:
                scale = float_in(line_number, "cogging_dq_scale", found.group(1))
            elif (found := VALUE.fullmatch(line)) is not None:
                place = whole_in(line_number, "cogging_dq_comp", found.group(1), 0, POINTS - 1)
                what = f"cogging_dq_comp.{place}"
                enter(values, line_number, what, place, whole_in(line_number, what, found.group(2), -128, 127))
            elif "cogging_dq" in line:
                raise Unfit(line_number, "file", f"{shown(line[:60])} is no line of the table; correct it")
        if scale is None or len(values) != POINTS:
            missing = "the scale" if scale is None else f"{POINTS - len(values)} of {POINTS} values"
            raise Unfit(1, "file", f"has not {missing}; it may be cut off, write it again")
        points = Points(np.array([values[i] for i in range(POINTS)]) * (scale * self.torque_constant))
        return content_of(points, {"unit": "N*m"})
