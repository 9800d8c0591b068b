"""The largest motion of a drive that beats, turn by turn, by the balance and by integration."""

import math
from typing import NamedTuple

import numpy as np

from ....base.results import Floats
from ....drive.drive_response import DriveResponse
from ....drive.project import Project
from ....drive.run import drive_run
from ....numerics.curves.torus_motion import BESIDE, largest_in_turns, largest_of_turns

TURN_SAMPLES = 512  # samples of a turn of the motor


class Beat(NamedTuple):
    """A motion that beats, turn by turn of the motor, until motor and output stand as before.

    Attributes
    ----------
    omega : float
        Speed of the motor [rad/s].
    turns : float
        Turns of the motor in a beat.
    balanced, integrated : (n,) arrays
        Largest |error - mean| [rad] over a turn that begins in each turn, by the balance and by integration from its
        state at angle 0, with the corners of the law; no integration of a free motor, of which nothing holds the speed.
    """

    omega: float
    turns: float
    balanced: Floats
    integrated: Floats

    @property
    def period(self) -> float:
        """Period [s]."""
        return 2.0 * math.pi * self.turns / self.omega

    @property
    def difference(self) -> float | None:
        """Largest difference of a turn by integration, relative to the largest turn; None without one."""
        has_turns = len(self.integrated) > 0
        return float(np.max(np.abs(self.integrated - self.balanced)) / np.max(self.balanced)) if has_turns else None


def beat_of(project: Project, response: DriveResponse) -> Beat | None:
    """The largest of the motions of a curve that a slow run-up or run-down meets; None where they do not beat."""
    waves, beat, train, top = response.curve.waves, response.curve.beat, project.whole, response.top
    if waves is None or beat is None or train is None or response.starts is None:
        return None
    omega, ratio = float(response.omega[top]), train.N
    balanced, integrated = largest_in_turns(waves.amplitudes[[top]], waves.pairs, ratio)[0], np.empty(0)
    if not train.motor.free:
        turns = np.arange(1, len(balanced) + 2)
        angles = 2.0 * np.pi / TURN_SAMPLES * np.arange(TURN_SAMPLES * (len(turns) + 2) + BESIDE + 1)
        run = drive_run(train._replace(omega=omega), response.starts[top], angles / omega)
        if run.trajectory.status:
            total = np.append(0.0, np.cumsum(run.pointing[1:] + run.pointing[:-1])) / (2.0 * TURN_SAMPLES)
            samples = TURN_SAMPLES * turns[:, None] + np.arange(-BESIDE, TURN_SAMPLES + BESIDE + 1)
            means = (total[TURN_SAMPLES:] - total[:-TURN_SAMPLES])[samples]
            integrated = np.roll(largest_of_turns(run.pointing[samples][None], means[None])[0], 1)
    return Beat(omega, beat, balanced, integrated)
