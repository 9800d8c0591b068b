"""Demands of motions on gear and motor, against the limits of datasheet and project file."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...model.gears.gear import Gear
from ...model.gears.limits import Finding, check_limits
from .motor_limits import MotorLimits, Need, motor_findings, sheet_findings


@dataclass(frozen=True)
class Usage:
    """The torque in the gear, T(u) + B u' at the output, in the steady motions of a speed range.

    Attributes
    ----------
    peak_torque, at_peak : float
        Largest size [N*m], and the base-angle speed [rad/s] there.
    average_torque, at_average : float
        Largest cubic mean over a turn [N*m], and the base-angle speed [rad/s] there.
    """

    peak_torque: float
    at_peak: float
    average_torque: float
    at_average: float


class MotorUse(NamedTuple):
    """Largest demands of the motions of a speed range on the motor.

    Attributes
    ----------
    torque, at : float
        Largest size of its torque [N*m, motor side], and the base-angle speed [rad/s] there.
    holding : float
        Largest size of its mean over a turn [N*m], which loads, gravity and friction take at steady speeds.
    load : float or None
        Torque [N*m] of the load at the largest, where it has a range of them.
    in_run_up : bool
        Whether the largest is in the run-up, what its acceleration takes left out.
    run_up : float or None
        Largest size of the torque [N*m] in the run-up, its acceleration included; None without one.
    """

    torque: float
    at: float
    holding: float
    load: float | None = None
    in_run_up: bool = False
    run_up: float | None = None


def largest_motor_use(some: Iterable[MotorUse | None]) -> MotorUse | None:
    """The use with the largest torque, with the largest mean and run-up torque of all; None where none is known."""
    uses = [use for use in some if use is not None]
    if not uses:
        return None
    run_ups = [use.run_up for use in uses if use.run_up is not None]
    top = max(uses, key=lambda use: use.torque)
    return top._replace(holding=max(use.holding for use in uses), run_up=max(run_ups, default=None))


def largest_usage(*some: Usage) -> Usage:
    """The largest torque and the largest cubic mean of several."""
    peak, mean = max(some, key=lambda u: u.peak_torque), max(some, key=lambda u: u.average_torque)
    return Usage(peak.peak_torque, peak.at_peak, mean.average_torque, mean.at_average)


def limit_findings(
    gear: Gear | None, usage: Usage, fastest: float | None, limits: MotorLimits | None = None,
    motor: MotorUse | None = None, needs: Iterable[Need | None] = (), resting: float | None = None,
) -> tuple[Finding, ...]:  # fmt: skip
    """Compare motions with the limits of the gear and of the motor; `Finding.fails` says by which a drive fails.

    `fastest` is the largest input speed [rad/s], None where it is not known. It counts as the mean speed too: every
    speed of the range may be kept up. `needs` is what the motions ask of the motor at every speed, `resting` the torque
    of the load at rest [N*m, motor side].
    """
    findings: tuple[Finding, ...] = ()
    if gear is not None:
        findings = check_limits(
            gear, peak_torque=usage.peak_torque, average_torque=usage.average_torque, max_speed=fastest,
            average_speed=fastest,
        )  # fmt: skip
    if limits is None:
        return findings
    asked_of = [need for need in needs if need is not None]
    torque, holding = (None, 0.0) if motor is None else (motor.torque, motor.holding)
    if motor is not None and motor.in_run_up:
        asked_of.append(Need(np.array([motor.at]), np.array([motor.torque]), np.zeros(1), np.ones(0, bool)))
    torque = None if limits.peak_torque and asked_of else torque
    simple = motor_findings(limits, torque, fastest, holding)
    return (*findings, *simple, *sheet_findings(limits, asked_of, fastest, resting))
