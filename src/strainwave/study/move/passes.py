"""Resonances that a move passes, and what each costs: the error that the kinematic error causes there."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...model.train.drive_train import DriveTrain
from ...protocols import lines_of
from ...results import Floats
from .path import Path

TURN = 2.0 * np.pi * np.arange(4096) / 4096


@dataclass(frozen=True)
class Pass:
    """One crossing of a speed at which a line of the kinematic error meets a natural frequency.

    Attributes
    ----------
    time : float
        When the motor's reference has that speed [s].
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
        The same of a slow move [rad]: the largest kinematic error.
    """

    time: float
    speed: float
    order: int
    frequency: float
    largest: float
    quasi_steady: float

    @property
    def amplification(self) -> float:
        """How many times the error of a slow move the pass has."""
        return self.largest / self.quasi_steady


def crossings(train: DriveTrain, path: Path, frequencies: Floats) -> list[tuple[float, float, int, float]]:
    """Times [s], ascending, at which a path has a line of the error at a frequency: (time, speed, order, frequency)."""
    orders = sorted({line.order for line in lines_of(train.error) if line.amplitude and line.order > 0})
    found = []
    for order in orders:
        for frequency in frequencies.tolist():
            speed = frequency / order
            found += [(t, speed, order, frequency) for t in path.crossings(speed / train.N).tolist()]
    return sorted(found)


def passes(crossed: list[Any], error: Any, path: Path, t: Floats, ripple: Floats) -> tuple[Pass, ...]:
    """Costs of crossings, from what of the pointing error (n,) [rad] the kinematic error causes at times [s]."""
    slow = float(np.max(np.abs(error.value(TURN))))
    ends = [end for _, end in path.motions()]
    found = []
    for i, (time, speed, order, frequency) in enumerate(crossed):
        following = [crossed[i + 1][0]] if i + 1 < len(crossed) else []
        until = min([*following, *(end for end in ends if end >= time)])
        inside = (t >= time) & (t <= until)
        largest = float(np.max(np.abs(ripple[inside]), initial=0.0))
        found.append(Pass(time, speed, order, frequency, largest, slow))
    return tuple(found)
