"""What motions ask of the gear and of the motor, against the limits of the datasheet and of the project file."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, NamedTuple

from ...model.gears.gear import Gear
from ...model.gears.limits import Finding, check_limits, cubic_mean
from ...series import largest_of_samples
from ..move.demands import MotorLimits, motor_findings
from ..response.response import ExactResponse
from ..response.steady import SteadyMotion
from .in_time import cycle_of


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
    """What the motions of a speed range ask of the motor.

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


def most_asked(some: Iterable[MotorUse | None]) -> MotorUse | None:
    """The largest torques of several, of those that are known."""
    known = [use for use in some if use is not None]
    if not known:
        return None
    run_up = max((use.run_up for use in known if use.run_up is not None), default=None)
    top = max(known, key=lambda use: use.torque)
    return top._replace(holding=max(use.holding for use in known), run_up=run_up)


def usage(system: Any, exact: ExactResponse, motions: Iterable[SteadyMotion]) -> Usage:
    """Find the largest torques in the gear over the steady motions that were found.

    Parameters
    ----------
    system : Oscillator
        The error equation; its omega is replaced.
    exact : ExactResponse
        Response curve, of which the points count that a slow run-up or run-down visits.
    motions : iterable of SteadyMotion
        Simulated motions, which count too where they finished: some are on no curve.
    """
    found = [(m.omega, cycle_of(system._replace(omega=m.omega), m).torque) for m in motions if m.status]
    visited = exact.visited()
    if len(visited):
        found += zip(exact.curve.omega[visited], exact.torque(system)[visited], strict=True)
    peak, at_peak = max((float(largest_of_samples(torque[None])[0]), float(omega)) for omega, torque in found)
    mean, at_mean = max((cubic_mean(torque), float(omega)) for omega, torque in found)
    return Usage(peak, at_peak, mean, at_mean)


def most_used(*some: Usage) -> Usage:
    """The largest torques of several."""
    peak, mean = max(some, key=lambda u: u.peak_torque), max(some, key=lambda u: u.average_torque)
    return Usage(peak.peak_torque, peak.at_peak, mean.average_torque, mean.at_average)


def limit_findings(
    gear: Gear | None, used: Usage, fastest: float | None, limits: MotorLimits | None = None,
    motor: MotorUse | None = None,
) -> tuple[Finding, ...]:  # fmt: skip
    """Compare motions with the limits of the gear and of the motor; `Finding.fails` says by which a drive fails.

    `fastest` is the largest input speed [rad/s], None where it is not known. It counts as the mean speed too: every
    speed of the range may be kept up.
    """
    found: tuple[Finding, ...] = ()
    if gear is not None:
        found = check_limits(
            gear, peak_torque=used.peak_torque, average_torque=used.average_torque, max_speed=fastest,
            average_speed=fastest,
        )  # fmt: skip
    if limits is None:
        return found
    torque, holding = (None, 0.0) if motor is None else (motor.torque, motor.holding)
    return found + motor_findings(limits, torque, fastest, holding)
