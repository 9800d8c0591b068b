"""Resonances that a move passes, and what each costs: the error that the kinematic error causes there."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...base.facts import Fact
from ...base.number_text import number
from ...base.protocols import lines_of
from ...base.results import Floats
from ...drive.train_curve import in_turns
from ...drive.two_turns import beat_said
from ...model.train.drive_train import DriveTrain
from .path import Path

SEGMENT_TIMES = 16  # times in a segment at which its angle is computed
TURN = 2.0 * np.pi * np.arange(4096) / 4096  # angles of the motor at which its kinematic error is computed


@dataclass(frozen=True)
class Pass:
    """One crossing of a speed at which a line of the kinematic error meets a natural frequency.

    Attributes
    ----------
    time : float
        Time [s] at which the motor's reference has that speed.
    speed : float
        Of the motor [rad/s].
    order : int
        Of the line of the kinematic error, per turn of the motor.
    frequency : float
        Natural frequency [rad/s] of small vibrations about rest at the begin of the move.
    largest : float
        Largest part of the pointing error [rad] that the kinematic error causes, from there to the next such crossing
        or the end of the motion: the difference from the same move without kinematic error.
    quasi_steady : float
        The same of a slow move [rad]: the largest kinematic error, of lines that beat along the path.
    turns : str
        The order as that of the turns to which it belongs, 2 - 2/101; empty where it is one of the motor's turn.
    """

    time: float
    speed: float
    order: float
    frequency: float
    largest: float
    quasi_steady: float
    turns: str = ""

    @property
    def amplification(self) -> float:
        """Error of the pass over that of a slow move."""
        return self.largest / self.quasi_steady

    def facts(self) -> tuple[Fact, ...]:
        """Its numbers."""
        return (
            Fact("time_s", self.time), Fact("speed_rpm", self.speed), Fact("order", self.order),
            Fact("frequency_rad_per_s", self.frequency), Fact("largest_rad", self.largest),
            Fact("quasi_steady_rad", self.quasi_steady), Fact("amplification", self.amplification),
        )  # fmt: skip

    def row(self, times: int) -> tuple[Fact, ...]:
        """Its row in a table, where it is the worst of so many."""
        return (
            Fact("", self.turns or f"{self.order:.6g}", "order"),
            Fact("", self.frequency / (2.0 * np.pi), "resonance [Hz]"),
            Fact("speed_rpm", self.speed, "crossed at motor speed"), Fact("", times, "crossings"),
            Fact("time_s", self.time, "worst crossing at"), Fact("largest_arcsec", self.largest, "largest error"),
            Fact("", number(self.amplification, 3), "ratio to slow move"),
        )  # fmt: skip


class Crossing(NamedTuple):
    """Time [s] and motor speed [rad/s] at which a path has a line of the error at a natural frequency [rad/s]."""

    time: float
    speed: float
    order: int
    frequency: float


def crossings(train: DriveTrain, path: Path, frequencies: Floats) -> list[Crossing]:
    """Crossings of a path by ascending time."""
    orders = sorted({line.order for line in lines_of(train.error) if line.amplitude and line.order > 0})
    rows = []
    for order in orders:
        for frequency in frequencies.tolist():
            speed = frequency / order
            rows += [Crossing(t, speed, order, frequency) for t in path.crossings(speed / train.N).tolist()]
    return sorted(rows)


def part_of_beat(train: DriveTrain, path: Path) -> Iterator[str]:
    """Sentence on a path that is shorter than the beat of its lines and of gravity."""
    try:
        beat, text = beat_said(train)
    except ValueError:  # nothing beats, or lines with neither turn
        return
    turned = train.N * float(np.ptp(path.motion_at(path.dense(SEGMENT_TIMES))[0])) / (2.0 * math.pi)
    if turned < beat:
        mean = train.N * path.travel() / (2.0 * math.pi * path.duration)
        yield (
            f"The error {text}, {beat / mean:.3g} s at the mean speed; the motor turns {turned:.4g} times in "
            f"{path.duration:.4g} s. The move covers part of the beat only: from another angle the error may be larger."
        )


def passes_of(crossed: list[Crossing], train: DriveTrain, path: Path, t: Floats, ripple: Floats) -> Iterator[Pass]:
    """Costs of crossings, from the part of the pointing error (n,) [rad] due to the kinematic error, at times [s]."""
    repeats = not any(line.order % 1 for line in lines_of(train.error))
    angles = TURN if repeats else train.N * path.motion_at(t)[0]
    slow = float(np.max(np.abs(train.error.value(angles))))
    ends = [end for _, end in path.motions()]
    for crossing, following in zip(crossed, [*crossed[1:], None], strict=True):
        until = min(end for end in ends if end >= crossing.time)
        until = until if following is None else min(until, following.time)
        inside = (t >= crossing.time) & (t <= until)
        largest = float(np.max(np.abs(ripple[inside]), initial=0.0))
        turns = in_turns(crossing.order, train) if crossing.order % 1 else ""
        yield Pass(*crossing, largest, slow, turns)
