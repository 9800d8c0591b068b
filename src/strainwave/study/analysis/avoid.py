"""Which speeds to avoid: around the peaks of the computed curve or above a limit, and in bands between jumps.

A steady curve is under constant mean torques: under several where that of the load lies anywhere in a range, as gravity
on an arm does. Where a torque follows the load's own angle, the run-up has it, and the speeds of its peaks are avoided.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from math import ceil, inf, log, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...base.law import depends
from ...base.protocols import orders_of
from ...base.results import Floats
from ...base.series import largest_of_samples, sizes_of_samples
from ...base.units import ARCSEC
from ...drive.drive_response import DriveResponse
from ...drive.jumps import pieces_of
from ...drive.run import DriveRun
from ...drive.two_turns import is_beating
from ...model.train.drive_train import DriveTrain
from .resonances import OperatingPoint

HALF_POWER = sqrt(0.5)
NARROW = 1e-3  # relative width of a band of speeds below which it is none: a step of the curve, or what rounding leaves
PER_ORDER, MANY, STARTS = 64, 500, 192  # places in a cycle of an order; turns in one of which lines meet, starts in one
AMPLIFIED = 2.0  # times the error of quasi-static rotation, from which on a peak is one

Speeds = tuple[float, float]


@dataclass(frozen=True)
class Avoid:
    """Speeds to avoid: in the half-power band of a peak, or where a limit is exceeded in its place; and in hysteresis.

    The oscillation is the largest |x - mean|, in a run-up that of `in_run`. A peak is more than twice that of
    quasi-static rotation, and the largest of all motions around it that are above 1/sqrt(2) of it: its half-power band.

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
        Those of the bands that the run-up adds, as it met them.
    largest_passed : (float, float) or None
        Speed [rad/s] and size [rad] of the largest oscillation of that run-up; None where the curve has all torques.
    unstable : tuple of (float, float)
        Those of the bands in which no motion of the curve is stable, or the one that a slow run-up or run-down comes to
        loses its stability: the drive leaves it there, or repeats after more turns than its excitation.
    """

    bands: tuple[Speeds, ...]
    largest: float
    at: float
    slow: float
    peaks: tuple[tuple[float, float], ...] = ()
    limit: float | None = None
    passed: tuple[Speeds, ...] = ()
    largest_passed: tuple[float, float] | None = None
    unstable: tuple[Speeds, ...] = ()


class Motions(NamedTuple):
    """Motions in the order of a curve or a sweep: speeds, oscillations, and whether each is joined to the next."""

    omega: Floats
    sizes: Floats
    joined: Any

    def run(self, i: int, level: float) -> tuple[int, int]:
        """First and last of the motions around number i that are above a level."""
        low = np.flatnonzero(self.sizes[:i] <= level)
        high = np.flatnonzero(self.sizes[i:] <= level)
        return int(low[-1]) + 1 if len(low) else 0, i + int(high[0]) - 1 if len(high) else len(self.sizes) - 1

    def band(self, first: int, last: int, level: float) -> Speeds:
        """Speeds between which such a run lies, its ends by linear interpolation."""
        ends = [*self.omega[first : last + 1]]
        for inside, outside in ((first, first - 1), (last, last + 1)):
            if 0 <= outside < len(self.omega) and self.joined[min(inside, outside)]:
                share = (self.sizes[inside] - level) / (self.sizes[inside] - self.sizes[outside])
                ends.append(self.omega[inside] + share * (self.omega[outside] - self.omega[inside]))
        return float(min(ends)), float(max(ends))

    def above(self, level: float) -> list[Speeds]:
        """Bands of all motions above a level."""
        bands, i = [], 0
        while i < len(self.omega):
            if self.sizes[i] > level:
                first, i = self.run(i, level)
                bands.append(self.band(first, i, level))
            i += 1
        return bands

    def half_power(self, peaks: list[int]) -> list[Speeds]:
        """Half-power bands of peaks, by their numbers."""
        levels = [HALF_POWER * self.sizes[i] for i in peaks]
        return [self.band(*self.run(i, level), level) for i, level in zip(peaks, levels, strict=True)]

    def peaks(self, least: float) -> list[int]:
        """Numbers of those above `least` that are the largest in their half-power band."""
        padded = np.concatenate([[-np.inf], self.sizes, [-np.inf]])
        high = (self.sizes > least) & (self.sizes >= padded[:-2]) & (self.sizes > padded[2:])
        return [int(i) for i in np.flatnonzero(high) if self.sizes[i] == self._highest(int(i))]

    def _highest(self, i: int) -> float:
        first, last = self.run(i, HALF_POWER * self.sizes[i])
        return float(np.max(self.sizes[first : last + 1]))


def in_run(run: DriveRun, begin: float) -> Motions | None:
    """Oscillation of the pointing error in every turn of the motor of a run, from a time [s] on.

    It is the largest distance in the turn from the mean of the turns: a line through the mean of each turn at its
    middle. That mean follows what changes slowly, the torque of the load's own angle for one. At a constant speed it is
    |x - mean| of a steady motion. None of a run of less than three turns.
    """
    keep = run.trajectory.t >= begin
    t, speed, error = run.trajectory.t[keep], run.motor_speed[keep], run.pointing[keep]
    starts = turns(t, speed)
    if len(starts) < 4:
        return None
    ends, starts = starts[1:], starts[:-1]
    error, speed, counts = error[: ends[-1]], speed[: ends[-1]], ends - starts
    means, middles = np.add.reduceat(error, starts) / counts, 0.5 * (starts + ends - 1)
    slow = np.interp(np.arange(len(error)), _longer(middles), _longer(means))
    sizes = np.maximum.reduceat(sizes_of_samples(error - slow), starts)
    return Motions(np.add.reduceat(speed, starts) / counts, sizes, np.ones(len(starts), bool))


def turns(t: Floats, speed: Floats) -> NDArray[np.int64]:
    """Numbers of the samples with which each turn of the motor begins, the last of which may not be whole."""
    angle = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(t))]) / (2.0 * np.pi)
    return np.searchsorted(angle, np.arange(int(angle[-1]) + 1))


def _longer(row: Any) -> Floats:
    """A row with one number more at each end, on a straight line."""
    return np.concatenate([[2.0 * row[0] - row[1]], row, [2.0 * row[-1] - row[-2]]])


def speeds_to_avoid(
    system: Any, response: DriveResponse, point: OperatingPoint, limit: float | None = None,
    passed: Motions | None = None,
) -> Avoid | None:  # fmt: skip
    """Apply the rule of `Avoid` to the stable motions of a curve; None where there are none.

    `passed` are those of a run-up that has torques which the curve has not (`in_run`).
    """
    if response.sweep is None or not len(response.counted):
        return None
    motions = _counted(response)
    slow = quasi_static(system, point)
    nowhere = without_stable(response)
    tops = [] if limit is not None else motions.peaks(AMPLIFIED * slow)
    high = motions.half_power(tops) if limit is None else motions.above(limit)
    bands = [*nowhere, *((band.low, band.high) for band in response.sweep.jumping), *high]
    peaks = tuple(sorted((float(motions.omega[i]), float(motions.sizes[i])) for i in tops))
    met = () if passed is None else merged(_met(passed, AMPLIFIED * slow, limit))
    top = None if passed is None else _largest(passed)
    omega, largest = _largest(motions)
    return Avoid(merged([*bands, *met]), largest, omega, slow, peaks, limit, met, top, nowhere)


def without_stable(response: DriveResponse) -> tuple[Speeds, ...]:
    """Speeds [rad/s] at which no motion of a curve is stable, or the one that a sweep comes to loses its stability.

    The drive leaves it there, or repeats after more turns.
    """
    curve, flips = response.curve, () if response.sweep is None else response.sweep.flips
    first, last = curve.span
    inside = (np.clip(curve.omega[piece], first, last) for piece in pieces_of(curve, curve.stable))
    return merged([*between(merged((np.min(run), np.max(run)) for run in inside), (first, last)), *flips])


def _counted(response: DriveResponse) -> Motions:
    """Stable motions of a curve."""
    at = response.visited()
    return Motions(response.omega[at], response.oscillation[at], np.diff(at) == 1)


def band_above(response: DriveResponse, limit: float) -> Speeds | None:
    """Speeds [rad/s] around the largest oscillation with one above a limit [rad], or between jumps; else None."""
    motions = _counted(response)
    at = float(motions.omega[np.argmax(motions.sizes)])
    jumping = [] if response.sweep is None else [(band.low, band.high) for band in response.sweep.jumping]
    above = motions.above(limit)
    return next((band for band in merged([*jumping, *above]) if above and band[0] <= at <= band[1]), None)


def _largest(motions: Motions) -> tuple[float, float]:
    at = int(np.argmax(motions.sizes))
    return float(motions.omega[at]), float(motions.sizes[at])


def _met(motions: Motions, least: float, limit: float | None) -> list[Speeds]:
    """Bands of a run-up: above the limit, or within half power of its peaks and of the largest of them."""
    if limit is not None:
        return motions.above(limit)
    tops = motions.peaks(least)
    highest = motions.above(HALF_POWER * max(motions.sizes[tops])) if tops else []
    return motions.half_power(tops) + highest


def quasi_static(system: Any, point: OperatingPoint) -> float:
    """Oscillation [rad] of a drive that follows its excitation without inertia; of a beat in its largest turn."""
    count, beats = PER_ORDER * ceil(max((1, *orders_of(system)))), is_beating(system.error)
    angles = 2.0 * np.pi * np.arange(MANY * count if beats else count) / count
    twist = (system.excitation.torque(angles) - point.mean_torque) / (point.stiffness if point.stiffness > 0.0 else inf)
    error = system.error.value(angles) + twist + 0.0 * angles
    if not beats:
        return float(largest_of_samples((error - np.mean(error))[None])[0])
    sums, step = np.append(0.0, np.cumsum(error)), max(1, count // STARTS)
    means = (sums[count:-1] - sums[: -count - 1] + 0.5 * (error[count:] - error[:-count])) / count
    turns, mean = np.lib.stride_tricks.sliding_window_view(error, count + 1), means[::step]
    worst = step * int(np.argmax(np.maximum(turns[::step].max(axis=1) - mean, mean - turns[::step].min(axis=1))))
    return float(largest_of_samples((turns[worst] - means[worst])[None])[0])


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
    """Whether a loop of the motor has an encoder on the load."""
    return train is not None and hasattr(train.motor.control, "at_load")


def between(bands: Iterable[tuple[float, ...]], within: Speeds, narrow: float = NARROW) -> tuple[Speeds, ...]:
    """What of a range no band covers; bands are ascending and apart, and relatively `narrow` rests are none."""
    rest = list(pairwise([within[0], *(end for band in bands for end in band), within[1]]))[::2]
    return tuple((float(low), float(high)) for low, high in rest if high > low * (1.0 + narrow) or len(rest) == 1)


def merged(bands: Iterable[tuple[float, ...]]) -> tuple[Speeds, ...]:
    """Bands of speed, ascending and apart."""
    bands_apart: list[list[float]] = []
    for low, high in sorted(bands):
        if bands_apart and low <= bands_apart[-1][1]:
            bands_apart[-1][1] = max(bands_apart[-1][1], high)
        else:
            bands_apart.append([low, high])
    return tuple((low, high) for low, high in bands_apart)


def searched(law: Any) -> bool:
    """Whether motions apart from a torque's curve are looked for: with memory or a gap that takes most of the time."""
    return depends(law) == 1 and bool(law.stiffness(0.0) > 0.0)


def hulls_between(first: tuple[Speeds, ...], second: tuple[Speeds, ...]) -> Iterator[Speeds]:
    """Hulls of the bands of two torques that belong together: each with the nearest of the other torque."""
    for here, there in ((first, second), (second, first)):
        for band in here:
            if there:
                near = min(there, key=lambda other: abs(log(_middle(other) / _middle(band))))
                yield min(band[0], near[0]), max(band[1], near[1])


def _middle(band: Speeds) -> float:
    return sqrt(band[0] * band[1])
