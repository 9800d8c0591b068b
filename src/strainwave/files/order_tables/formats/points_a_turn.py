"""Points over one turn that a control or drive holds: SINUMERIK, moteus and OnStepX."""

import math
import re
from dataclasses import dataclass
from math import pi

import numpy as np

from ....base.quantities import number, positive_count, shown
from ..content import OrderContent
from ..format import Held, OfPoints, OrderFormat
from ..points import (
    MOST_POINTS,
    Points,
    Unfit,
    content_of,
    enter,
    float_in,
    highest_order,
    motion,
    rows_of,
    said_by,
    sampled,
    whole_in,
)

DIGITS, DEGREE = 9, pi / 180.0
AXIS = re.compile(r"[A-Z][A-Z0-9_]{0,31}")
ASSIGNED = re.compile(
    r"\$AA_ENC_COMP(_STEP|_MIN|_MAX|_IS_MODULO)?\[([01]),(?:([0-9]{1,6}),)?([A-Z][A-Z0-9_]*)\] *= *(\S+)"
)
POINTS, LARGEST = 1024, 127  # points of moteus, and the largest of a signed byte
SCALE = re.compile(r"conf set motor\.cogging_dq_scale (\S+)")
VALUE = re.compile(r"conf set motor\.cogging_dq_comp\.([0-9]{1,6}) (\S+)")
DAY, FEWEST = 86400, 61  # sidereal seconds of a day, and entries of OnStepX
ENTRY = re.compile(r":WR\[?([0-9]{1,6}),([+-]?[0-9]{1,6})\]?#")
SAVE = ":$QZ!#"


@dataclass(frozen=True)
class Sinumerik(
    OfPoints, name="sinumerik", title="SINUMERIK's $AA_ENC_COMP", unit="rad", turn="output",
    ends=1, decimals=DIGITS, begin=r"(?s).{0,8000}\$AA_ENC_COMP\[",
    more="; set MD38000 $MA_MM_ENC_COMP_MAX_POINTS and give it as capacity",
):  # fmt: skip
    """Part program for $AA_ENC_COMP.

    Confirmed by Siemens' Function Manuals (Extended Functions, K3: Compensations, 03/2013, 6FC5397-1BP40-3BA1;
    SINUMERIK 808D, 01/2017): $AA_ENC_COMP[e,N,AXi] value of point N, 8 bytes; _STEP, _MIN and _MAX in the unit of the
    axis; with _IS_MODULO 1 the table repeats, 0 to 360 degrees with both ends given; straight lines between the points;
    the value is added to the actual position, a positive one moves the axis in the negative direction, so it is the
    negative of our correction, and the axis jumps by the value at its reference point when the table begins to act. The
    808D holds 200 points, others MD38000 $MA_MM_ENC_COMP_MAX_POINTS. Values are written while MD32700
    $MA_ENC_COMP_ENABLE is 0, and act with 1 on a referenced axis, alike in both directions.

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

    def __post_init__(self) -> None:
        if not isinstance(self.axis, str) or not AXIS.fullmatch(self.axis):
            raise ValueError(f"axis is {shown(self.axis)}; give the name of a machine axis, for example 'AX1'")
        capacity = positive_count("capacity", self.capacity, MOST_POINTS + 1)
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
        values, count = held.numbers.values[0], held.numbers.length
        rows = [
            "%_N_" + self.axis + "_EEC_INI",
            *(f"; {line}" for line in comments),
            "CHANDATA(1)",
            *(f"$AA_ENC_COMP[0,{i},{self.axis}]={values[i % count] + 0.0:.{DIGITS}f}" for i in range(count + 1)),
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
        for line_number, line in rows_of(text):
            if not line.upper().startswith("$AA_ENC_COMP"):
                continue
            match = ASSIGNED.match(line)
            if match is None or (match.group(1) is None) is (match.group(3) is None):
                raise Unfit(line_number, "file", f"{shown(line[:60])} is no assignment of $AA_ENC_COMP; correct it")
            kind, _, place, _, value = match.groups()
            if place is None:
                settings[kind] = float_in(line_number, f"$AA_ENC_COMP{kind}", value)
            else:
                at = whole_in(line_number, "point", place, 0, MOST_POINTS)
                enter(values, line_number, f"point {at}", at, float_in(line_number, f"point {at}", value))
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
            Points(-DEGREE * np.array([[values[i] for i in range(count)]])), {"unit": "rad", "turn": "output"} | fields
        )


@dataclass(frozen=True)
class Moteus(
    OrderFormat, name="moteus", title="moteus", unit="N*m", turn="motor", width=1,
    begin=r"(?s).{0,4000}conf set motor\.cogging_dq_",
):  # fmt: skip
    """Configuration of a moteus controller.

    Confirmed by the firmware (mjbots/moteus, fw/bldc_servo.h, bldc_servo_structs.h) and its
    utils/compensate_cogging.py: 1024 values int8 over one turn of the commutation encoder, times cogging_dq_scale a
    current of the q axis [A], straight lines between them and around, added to the current of position mode. The
    current is the torque over the torque constant of the rotor. `moteus_tool --write-config` sends every line as it is,
    so the file has no remarks; what belongs to the table beside its values is given again when it is read. Not
    confirmed: the sign of current and angle of a given motor.

    Attributes
    ----------
    torque_constant : float
        Torque of the rotor per current of the q axis [N*m/A].
    """

    torque_constant: float

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
        current = exact.values / self.torque_constant
        largest = float(np.max(np.abs(current)))
        if not largest <= float(np.finfo(np.float32).max):
            raise ValueError(f"the table asks for {largest:.3g} A, beyond 32 bits; check torque_constant")
        scale = float(np.float32(largest / LARGEST)) or 1.0
        values = np.clip(np.round(current / scale), -LARGEST, LARGEST)
        points = Points(values * (scale * self.torque_constant))
        stored = motion(points, table.zero)
        quantum = scale * self.torque_constant
        return Held(stored, motion(exact, table.zero), (scale, values[0].astype(int).tolist()), quantum, POINTS)

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
        points = Points(np.array([[values[i] for i in range(POINTS)]]) * (scale * self.torque_constant))
        return content_of(points, {"unit": "N*m"})


@dataclass(frozen=True)
class OnStepX(
    OrderFormat, name="onstepx", title="OnStepX", unit="rad", turn="motor", needs_mean=False,
    width=1, begin=rf"\s*{ENTRY.pattern}",
):  # fmt: skip
    """Commands for the table of the periodic error correction.

    Confirmed by OnStepX's sources (mount/pec: Pec.cpp, Pec.command.cpp; Config.defaults.h): `:WR[n,sn]#` sets entry n
    to sn steps, -128 to 127, for one sidereal second; `:$QZ!#` saves the table; the second that is playing takes the
    entry before it; entries begin at the index of the worm; a table has 61 entries at least and PEC_BUFFER_SIZE_LIMIT,
    720 unless configured, at most; what is played is at most one sidereal rate; it plays only while tracking. Entries
    are rates: the correction is their sum, so a constant part has no effect, and straight lines join the seconds. The
    worm of the commands is the motor of the table here: its turn takes 86400/ratio sidereal seconds. Commands have no
    remarks; ratio and steps_per_degree are given again when the file is read. Not confirmed: the sense in which a given
    mount turns.

    Attributes
    ----------
    steps_per_degree : float
        AXIS1_STEPS_PER_DEGREE of the mount, at the output.
    ratio : float, optional
        Turns of the table's motor per turn of the output. Default: that of the table.
    capacity : int
        PEC_BUFFER_SIZE_LIMIT of the mount.
    """

    steps_per_degree: float
    ratio: float | None = None
    capacity: int = 720

    def __post_init__(self) -> None:
        number("steps_per_degree", self.steps_per_degree, positive=True)
        positive_count("capacity", self.capacity, 30_000)
        if self.ratio is not None:
            number("ratio", self.ratio, positive=True)

    @property
    def _steps(self) -> float:
        """Steps per rad of the output."""
        return self.steps_per_degree * 180.0 / math.pi

    def seconds(self, ratio: float | None) -> int:
        """Sidereal seconds of a turn of the motor."""
        if self.ratio is not None and ratio is not None and self.ratio != ratio:
            raise ValueError(f"option ratio is {self.ratio:g} and that of the table {ratio:g}; leave one out")
        ratio = self.ratio or ratio
        if ratio is None:
            raise ValueError("OnStepX needs the seconds of a motor turn; give the ratio to the table or as an option")
        seconds = DAY / ratio
        if abs(seconds - round(seconds)) > 1e-6:
            raise ValueError(
                f"at the ratio {ratio:g} a turn of the motor takes {seconds:.6g} sidereal seconds; OnStepX counts "
                "whole ones"
            )
        if not FEWEST <= round(seconds) <= self.capacity:
            raise ValueError(
                f"a turn of the motor takes {round(seconds)} sidereal seconds; OnStepX holds {FEWEST} to "
                f"{self.capacity}: set PEC_BUFFER_SIZE_LIMIT and give it as capacity"
            )
        return round(seconds)

    def highest(self, table: OrderContent) -> int:
        """More than two seconds a period."""
        return highest_order(self.seconds(table.ratio))

    def why_highest(self, table: OrderContent) -> str:
        """The seconds of a turn."""
        return f"two of the {self.seconds(table.ratio)} sidereal seconds of a turn a period"

    def store(self, table: OrderContent) -> Held:
        """Round the sum of the steps, so that no error adds up, and take its differences."""
        exact = sampled(table, self.seconds(table.ratio))
        sums = np.round(self._steps * (exact.values[0] - exact.values[0, 0]))  # whole steps stay so at another constant
        entries = np.roll(sums, -1) - sums  # steps in the second that begins here
        most = min(LARGEST, math.floor(self.steps_per_degree / 240.0))
        if np.max(np.abs(entries)) > most:
            raise ValueError(
                f"the table asks for {np.max(np.abs(entries)):.0f} steps in one sidereal second; OnStepX plays at most "
                f"{most}, one sidereal rate or {LARGEST} steps: correct fewer or lower orders"
            )
        stored = Points(sums[None] / self._steps)
        played = np.roll(entries, -1).astype(int).tolist()  # the second that is playing takes the entry before it
        return Held(motion(stored, table.zero), motion(exact, table.zero), played, 1.0 / self._steps, len(played))

    def text(self, table: OrderContent, held: Held, comments: list[str]) -> str:
        """Write a command a second, and the one that saves."""
        return "\n".join([*(f":WR{n},{steps:+d}#" for n, steps in enumerate(held.numbers)), SAVE]) + "\n"

    def parse(self, text: str) -> OrderContent:
        """Read the commands and add the steps up; the constant part is left at 0."""
        entries: dict[int, int] = {}
        for line_number, plain in rows_of(text):
            if plain == SAVE:
                continue
            match = ENTRY.fullmatch(plain)
            if match is None:
                raise Unfit(line_number, "file", f"{shown(plain[:60])} is no command of the table; write :WRn,sn#")
            place = whole_in(line_number, "entry", match.group(1), 0, self.capacity - 1)
            what = f"entry {place}"
            enter(entries, line_number, what, place, whole_in(line_number, what, match.group(2), -128, 127))
        count = len(entries)
        if count < FEWEST or set(entries) != set(range(count)):
            raise Unfit(1, "file", f"has {count} entries that do not follow each other from 0; it may be cut off")
        if self.ratio is not None and self.seconds(None) != count:
            raise Unfit(
                1, "file", f"has {count} entries where a turn takes {self.seconds(None)} seconds; is the ratio right?"
            )
        steps = np.roll([entries[n] for n in range(count)], 1)
        if steps.sum() != 0:
            raise Unfit(1, "file", f"adds up to {steps.sum()} steps a turn; it must return to 0, or the mount drifts")
        sums = np.concatenate([[0.0], np.cumsum(steps)[:-1]])
        fields = {"unit": "rad", "ratio": self.ratio or DAY / count}
        return content_of(Points((sums - np.mean(sums))[None] / self._steps), fields)
