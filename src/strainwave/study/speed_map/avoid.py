"""`Avoid`: speeds to avoid for the motions of a drive, and the largest oscillation and the peaks among them."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...base.units import ARCSEC
from ...drive.drive_response import DriveResponse
from ...drive.jumps import pieces_of
from ...model.train.drive_train import DriveTrain
from .error_equation import PEAK_AMPLIFICATION, OperatingPoint, quasi_static
from .intervals import Span, as_intervals, between, common, complement, merged
from .rules import bands_of, rules_of
from .size_curve import SizeCurve
from .under_load import motions_of_curve


@dataclass(frozen=True)
class Avoid:
    """Speeds to avoid for the motion of a drive, and how large it is there.

    The oscillation is the largest |x - mean|, in a run-up that of `in_run`. Without a limit a speed is avoided where it
    is above twice that of quasi-static rotation. A peak is the largest of all motions around it that are above
    1/sqrt(2) of it.

    Attributes
    ----------
    bands : tuple of (float, float)
        Speeds of the base angle [rad/s], ascending and apart.
    largest, at : float
        Largest oscillation in the range [rad], and its speed [rad/s].
    slow : float
        Oscillation [rad] when the drive turns slowly.
    peaks : tuple of (float, float)
        Speed [rad/s] and oscillation [rad] of every peak, by ascending speed; empty where there is a limit.
    limit : float or None
        Largest oscillation [rad] that the drive may have; None where nothing is given.
    passed : tuple of (float, float)
        Speeds that the run-up adds to the bands.
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
    passed: SizeCurve | None = None,
) -> Avoid | None:  # fmt: skip
    """Apply the limit [rad], or twice the quasi-static error, to the stable motions of one curve; None without any.

    `passed` are the motions of a run-up that has torques which the curve has not (`in_run`).
    """
    slow = quasi_static(system, point)
    if response.sweep is None or not len(response.counted):
        return None
    rules = rules_of(None, None, None, limit)
    bands = bands_of(motions_of_curve(response, slow), rules, response.curve.span, (), 0.0).forbidden
    return avoid_in_bands(response, slow, limit, merged(bands.tolist()), passed)


def avoid_in_bands(
    response: DriveResponse, slow: float, limit: float | None, bands: tuple[Span, ...], passed: SizeCurve | None = None
) -> Avoid | None:  # fmt: skip
    """Speeds to avoid of a curve whose forbidden `bands` are decided; None where none of its motions is stable.

    `slow` [rad] is the oscillation of slow rotation; `passed` as of `speeds_to_avoid`.
    """
    if response.sweep is None or not len(response.counted):
        return None
    motions, unstable = _stable_sizes(response), without_stable(response)
    omega, largest = _largest(motions)
    tops = [] if limit is not None else motions.peaks(PEAK_AMPLIFICATION * slow)
    peaks = tuple(sorted((float(motions.omega[i]), float(motions.sizes[i])) for i in tops))
    avoid = Avoid(bands, largest, omega, slow, peaks, limit, unstable=unstable)
    if passed is None:
        return avoid
    above = as_intervals(passed.above(PEAK_AMPLIFICATION * slow if limit is None else limit))
    added = common(above, complement(as_intervals(bands), response.curve.span))
    return replace(avoid, passed=merged(added.tolist()), largest_passed=_largest(passed))


def without_stable(response: DriveResponse) -> tuple[Span, ...]:
    """Speeds [rad/s] at which no motion of a curve is stable, or the one that a sweep comes to loses its stability.

    The drive leaves it there, or repeats after more turns.
    """
    curve, flips = response.curve, () if response.sweep is None else response.sweep.flips
    first, last = curve.span
    inside = (np.clip(curve.omega[piece], first, last) for piece in pieces_of(curve, curve.stable))
    return merged([*between(merged((np.min(run), np.max(run)) for run in inside), (first, last)), *flips])


def _stable_sizes(response: DriveResponse) -> SizeCurve:
    """Oscillation of the stable motions of a curve."""
    visited = response.visited()
    return SizeCurve(response.omega[visited], response.oscillation[visited], np.diff(visited) == 1)


def band_above(response: DriveResponse, limit: float) -> Span | None:
    """Band [rad/s] with the largest oscillation, above a limit [rad], jumps merged into it; None within the limit."""
    motions = _stable_sizes(response)
    speed = float(motions.omega[np.argmax(motions.sizes)])
    jumping = [] if response.sweep is None else [(band.low, band.high) for band in response.sweep.jumping]
    above = motions.above(limit)
    return next((band for band in merged([*jumping, *above]) if above and band[0] <= speed <= band[1]), None)


def _largest(motions: SizeCurve) -> tuple[float, float]:
    """Speed [rad/s] and oscillation [rad] of the largest motion."""
    top = int(np.argmax(motions.sizes))
    return float(motions.omega[top]), float(motions.sizes[top])


def out_of_reach(limit: float | None, slow: float, train: DriveTrain | None = None) -> str:
    """Sentence on a limit of the oscillation [rad] below that of slow rotation [rad]; empty where it is above.

    A loop on an encoder of the load takes that oscillation away at speeds that it follows.
    """
    if limit is None or limit >= slow:
        return ""
    if sees_load(train):
        return (
            f"the limit of {limit / ARCSEC:.4g} arcsec is below the gear error at very low speed, "
            f"{slow / ARCSEC:.4g} arcsec: it can be met only where the loop on the load's encoder reduces this error"
        )
    return (
        f"the limit of {limit / ARCSEC:.4g} arcsec is below the gear error at very low speed, {slow / ARCSEC:.4g} "
        "arcsec: it can be met only above the resonances"
    )


def sees_load(train: DriveTrain | None) -> bool:
    """True if a loop of the motor has an encoder on the load."""
    return train is not None and hasattr(train.motor.control, "at_load")
