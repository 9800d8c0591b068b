"""What steady motions ask of the gear: the largest torque and the cubic mean, against the datasheet's limits."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from ...model.gears.gear import Gear
from ...model.gears.limits import Finding, check_limits, cubic_mean
from ...series import largest_of_samples
from ..response.response import ExactResponse
from ..response.steady import SteadyMotion
from .time_case import cycle_of


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


def limit_findings(gear: Gear, used: Usage, fastest: float | None) -> tuple[Finding, ...]:
    """Compare a run with the gear's limits; `fastest` is the largest input speed [rad/s], None where it is not known.

    The speed counts as the mean speed too: every speed of the range may be kept up.
    """
    return check_limits(
        gear, peak_torque=used.peak_torque, average_torque=used.average_torque, max_speed=fastest, average_speed=fastest
    )


def gravest(findings: tuple[Finding, ...]) -> tuple[Finding, ...]:
    """Limits that were passed: of the peak torques and of the speeds only the gravest."""
    beyond = {f.limit: f for f in findings if f.exceeded}
    for grave, less in (
        ("max_rpm", "average_rpm"),
        ("momentary_torque", "repeated_peak_torque"),
        ("ratcheting_torque", "momentary_torque"),
        ("buckling_torque", "ratcheting_torque"),
    ):
        if grave in beyond:
            beyond.pop(less, None)
    return tuple(beyond.values())
