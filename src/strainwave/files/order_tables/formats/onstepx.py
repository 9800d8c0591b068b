"""OnStepX (telescope mounts): commands that write the table of the periodic error correction of axis 1.

Confirmed by OnStepX's sources (mount/pec: Pec.cpp, Pec.command.cpp; Config.defaults.h): `:WR[n,sn]#` sets entry n to sn
steps, -128 to 127, for one sidereal second; `:$QZ!#` saves the table; the second that is playing takes the entry before
it; entries begin at the index of the worm; a table has 61 entries at least and PEC_BUFFER_SIZE_LIMIT, 720 unless
configured, at most; what is played is at most one sidereal rate; it plays only while tracking. Entries are rates: the
correction is their sum, so a constant part has no effect, and straight lines join the seconds. The worm of the commands
is the motor of the table here: its turn takes 86400/ratio sidereal seconds. Commands have no remarks; ratio and
steps_per_degree are given again when the file is read. Not confirmed: the sense in which a given mount turns.
"""

import math
import re
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ....base.quantities import number, positive_count, shown
from ..content import OrderContent
from ..format import Held, OrderFormat
from ..points import Points, Unfit, content_of, enter, highest_order, motion, rows_of, sampled, whole_in

DAY, FEWEST, LARGEST = 86400, 61, 127
ENTRY = re.compile(r":WR\[?([0-9]{1,6}),([+-]?[0-9]{1,6})\]?#")
SAVE = ":$QZ!#"


@dataclass(frozen=True)
class OnStepX(OrderFormat):
    """Commands for the table of the periodic error correction.

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
    name: ClassVar[str] = "onstepx"
    title: ClassVar[str] = "OnStepX"
    unit: ClassVar[str | None] = "rad"
    turn: ClassVar[str | None] = "motor"
    needs_mean: ClassVar[bool] = False
    begin: ClassVar[str] = rf"\s*{ENTRY.pattern}"

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
        sums = np.round(self._steps * (exact.forward - exact.forward[0]))  # whole steps stay so at another constant
        entries = np.roll(sums, -1) - sums  # steps in the second that begins here
        most = min(LARGEST, math.floor(self.steps_per_degree / 240.0))
        if np.max(np.abs(entries)) > most:
            raise ValueError(
                f"the table asks for {np.max(np.abs(entries)):.0f} steps in one sidereal second; OnStepX plays at most "
                f"{most}, one sidereal rate or {LARGEST} steps: correct fewer or lower orders"
            )
        stored = Points(sums / self._steps)
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
        return content_of(Points((sums - np.mean(sums)) / self._steps), fields)
