"""Whether a drive is all right at its speeds: the oscillation of its error and what the gear is asked for."""

from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise

import numpy as np

from ....model.gears.limits import Finding
from ....results import Floats
from ....units import RPM
from ..avoid import Avoid, Motions, Speeds, merged
from ..drive_response import DriveResponse
from ..remedies import Remedy
from ..usage import MotorUse, Usage

TORQUES = ("repeated_peak_torque", "momentary_torque", "ratcheting_torque", "buckling_torque")
INPUT_SPEEDS = ("max_rpm", "motor speed")


class Answer(StrEnum):
    """What the verdict is."""

    ALL_RIGHT = "all right"
    BUT = "all right but for some speeds"
    NOT = "not all right"


@dataclass(frozen=True)
class Verdict:
    """Whether a drive is all right at its speeds, and the smallest change that brings its oscillation under the limit.

    Attributes
    ----------
    answer : Answer
        `BUT` where everything that is wrong is wrong at `speeds` alone.
    speeds : tuple of (float, float)
        Speeds of the base angle [rad/s] to keep out of: those to avoid, and those where a limit of the gear or the
        motor is passed.
    allowed : tuple of (float, float)
        The others of the range [rad/s].
    exceeded : tuple of Finding
        Limits of the gear and of the motor by which the drive fails; a mean speed above that of a duty cycle is none.
    change : Remedy or None
        The smallest change of those tried that brings the largest oscillation under its limit.
    """

    answer: Answer
    speeds: tuple[Speeds, ...]
    allowed: tuple[Speeds, ...]
    exceeded: tuple[Finding, ...]
    change: Remedy | None = None


def verdict_of(
    speeds: Speeds, curves: tuple[DriveResponse, ...], avoid: Avoid | None, used: Usage, limits: tuple[Finding, ...],
    change: Remedy | None = None, motor: MotorUse | None = None, turns: int = 1,
) -> Verdict:  # fmt: skip
    """Put together what is wrong with a drive and at which speeds.

    Parameters
    ----------
    speeds : (float, float)
        Range of the base-angle speed [rad/s].
    curves : tuple of DriveResponse
        Steady motions of the drive, one curve for each load torque.
    avoid : Avoid or None
        Speeds to avoid under any of them; None where no motion is stable.
    used : Usage
        Largest torques in the gear, which may be of motions that are on no curve.
    limits : tuple of Finding
        The run against each limit of the gear and of the motor.
    change : Remedy or None
        The smallest change that brings the oscillation under its limit.
    motor : MotorUse or None
        What the motions ask of the motor.
    turns : int
        Turns of the base angle in one of the motor.
    """
    exceeded = tuple(finding for finding in limits if finding.fails)
    beyond = merged(band for finding in exceeded for band in _where(finding, speeds, curves, turns))
    at = {used.peak_torque: used.at_peak, used.average_torque: used.at_average}
    if motor is not None:
        at[motor.torque] = motor.at
    told = all(finding.unit == "rpm" or _in(beyond, at[finding.value]) for finding in exceeded)
    bands = merged([*(() if avoid is None else avoid.bands), *beyond])
    allowed = _others(speeds, bands)
    if not bands and not exceeded and avoid is not None:
        answer = Answer.ALL_RIGHT
    else:
        answer = Answer.BUT if allowed and told and avoid is not None else Answer.NOT
    return Verdict(answer, bands, allowed, exceeded, change)


def _where(finding: Finding, speeds: Speeds, curves: tuple[DriveResponse, ...], turns: int) -> list[Speeds]:
    """Speeds at which a limit of the gear or the motor is passed."""
    if finding.limit in INPUT_SPEEDS:
        return [(max(speeds[0], turns * finding.bound * RPM), speeds[1])]
    found = []
    for curve in curves:
        at = curve.visited()
        torque = _limited(finding.limit, curve)
        if torque is None:
            continue
        found += Motions(curve.omega[at], torque[at], np.diff(at) == 1).above(finding.bound)
    return found


def _limited(limit: str, curve: DriveResponse) -> Floats | None:
    """Torque [N*m] at every point of a curve that a limit is about; None where it is not known."""
    if limit == "motor torque":
        return curve.motor_torque
    return curve.torque if limit in TORQUES else curve.mean_torque


def _in(bands: tuple[Speeds, ...], omega: float) -> bool:
    return any(low * (1.0 - 1e-9) <= omega <= high * (1.0 + 1e-9) for low, high in bands)


def _others(speeds: Speeds, bands: tuple[Speeds, ...]) -> tuple[Speeds, ...]:
    """The rest of a range of speeds."""
    edges = [speeds[0], *(end for band in bands for end in band), speeds[1]]
    rest = list(pairwise(edges))[::2]
    return tuple((low, high) for low, high in rest if high > low * (1.0 + 1e-9))
