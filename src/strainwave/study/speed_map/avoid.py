"""Span to avoid for the motion of a drive, of one curve or as it was decided, and the size of the motion."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...base.units import ARCSEC
from ...drive.drive_response import DriveResponse
from ...drive.jumps import pieces_of
from ...model.train.drive_train import DriveTrain
from .bands import AMPLIFIED, Motions, quasi_static
from .intervals import Span, as_intervals, between, common, complement, merged
from .resonances import OperatingPoint
from .rules import Rules, bands_of
from .under_load import of_curve


@dataclass(frozen=True)
class Avoid:
    """Span to avoid for the motion of a drive, and how large it is there.

    The oscillation is the largest |x - mean|, in a run-up that of `in_run`. Without a limit a speed is avoided where it
    is above twice that of quasi-static rotation. A peak is the largest of all motions around it that are above
    1/sqrt(2) of it.

    Attributes
    ----------
    bands : tuple of (float, float)
        Span of the base angle [rad/s], ascending and apart.
    largest, at : float
        Largest oscillation in the range [rad], and its speed [rad/s].
    slow : float
        Oscillation [rad] when the drive turns slowly.
    peaks : tuple of (float, float)
        Speed [rad/s] and oscillation [rad] of every peak, by ascending speed; empty where there is a limit.
    limit : float or None
        Largest oscillation [rad] that the drive may have; None where nothing is given.
    passed : tuple of (float, float)
        Span that the run-up adds to the bands.
    largest_passed : (float, float) or None
        Speed [rad/s] and size [rad] of the largest oscillation of that run-up; None where the curve has all torques.
    unstable : tuple of (float, float)
        Those of the bands in which no motion of the curve is stable, or the one that a slow run-up or run-down comes to
        loses its stability: the drive leaves it there, or repeats after more turns than its excitation.
    apart : (float, float) or None
        Speed [rad/s] and oscillation [rad] of the largest motion that the curve has not, where the search found any.
    """

    bands: tuple[Span, ...]
    largest: float
    at: float
    slow: float
    peaks: tuple[tuple[float, float], ...] = ()
    limit: float | None = None
    passed: tuple[Span, ...] = ()
    largest_passed: tuple[float, float] | None = None
    unstable: tuple[Span, ...] = ()
    apart: tuple[float, float] | None = None


def speeds_to_avoid(
    system: Any, response: DriveResponse, point: OperatingPoint, limit: float | None = None,
    passed: Motions | None = None,
) -> Avoid | None:  # fmt: skip
    """Apply the rules to the stable motions of one curve; None where there are none.

    `passed` are those of a run-up that has torques which the curve has not (`in_run`).
    """
    slow = quasi_static(system, point)
    if response.sweep is None or not len(response.counted):
        return None
    rules, span = Rules(limit, AMPLIFIED if limit is None else None), response.curve.span
    bands = bands_of(of_curve(response, slow), rules, span, (), 0.0).forbidden
    return avoided(response, slow, limit, merged(bands.tolist()), passed)


def avoided(
    response: DriveResponse, slow: float, limit: float | None, bands: tuple[Span, ...], passed: Motions | None = None
) -> Avoid | None:  # fmt: skip
    """The speeds to avoid that were decided, with the motions of the curve; None where none is stable."""
    if response.sweep is None or not len(response.counted):
        return None
    motions = _counted(response)
    tops = [] if limit is not None else motions.peaks(AMPLIFIED * slow)
    peaks = tuple(sorted((float(motions.omega[i]), float(motions.sizes[i])) for i in tops))
    met: tuple[Span, ...] = ()
    top = None if passed is None else _largest(passed)
    if passed is not None:
        above = as_intervals(passed.above(AMPLIFIED * slow if limit is None else limit))
        met = merged(common(above, complement(as_intervals(bands), response.curve.span)).tolist())
    omega, largest = _largest(motions)
    return Avoid(bands, largest, omega, slow, peaks, limit, met, top, without_stable(response))


def without_stable(response: DriveResponse) -> tuple[Span, ...]:
    """Span [rad/s] at which no motion of a curve is stable, or the one that a sweep comes to loses its stability.

    The drive leaves it there, or repeats after more turns.
    """
    curve, flips = response.curve, () if response.sweep is None else response.sweep.flips
    first, last = curve.span
    inside = (np.clip(curve.omega[piece], first, last) for piece in pieces_of(curve, curve.stable))
    return merged([*between(merged((np.min(run), np.max(run)) for run in inside), (first, last)), *flips])


def _counted(response: DriveResponse) -> Motions:
    """Stable motions of a curve."""
    visited = response.visited()
    return Motions(response.omega[visited], response.oscillation[visited], np.diff(visited) == 1)


def band_above(response: DriveResponse, limit: float) -> Span | None:
    """Span [rad/s] around the largest oscillation with one above a limit [rad], or between jumps; else None."""
    motions = _counted(response)
    speed = float(motions.omega[np.argmax(motions.sizes)])
    jumping = [] if response.sweep is None else [(band.low, band.high) for band in response.sweep.jumping]
    above = motions.above(limit)
    return next((band for band in merged([*jumping, *above]) if above and band[0] <= speed <= band[1]), None)


def _largest(motions: Motions) -> tuple[float, float]:
    top = int(np.argmax(motions.sizes))
    return float(motions.omega[top]), float(motions.sizes[top])


def out_of_reach(limit: float | None, slow: float, train: DriveTrain | None = None) -> str:
    """That a limit of the oscillation [rad] is below that of slow rotation [rad], in one sentence; empty where not.

    A loop on an encoder of the load takes that oscillation away at speeds that it follows.
    """
    if limit is None or limit >= slow:
        return ""
    if sees_load(train):
        return (
            f"the limit of {limit / ARCSEC:.4g} arcsec is below the error of the gear in slow rotation, "
            f"{slow / ARCSEC:.4g} arcsec: it can be met where the loop on the load's encoder takes that away"
        )
    return (
        f"the limit of {limit / ARCSEC:.4g} arcsec is below the error of quasi-static rotation, {slow / ARCSEC:.4g} "
        "arcsec: it can be met above the resonances only"
    )


def sees_load(train: DriveTrain | None) -> bool:
    """True if a loop of the motor has an encoder on the load."""
    return train is not None and hasattr(train.motor.control, "at_load")
