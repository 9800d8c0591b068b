"""Stretches of a measured motion: rest, constant speed, run-up, run-down."""

from collections.abc import Iterable
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.ndimage import uniform_filter1d

from ....results import Floats

SHORTEST = 0.01  # of the log: a shorter stretch is "other"
SMOOTHED = 0.01  # of the log: over it the speed is averaged
POINTS = 400  # of the averaged speed, through which straight lines are laid
SLOW, NOISY = 2e-3, 8.0  # of the largest speed, and deviations of the averaged speed: bounds of slow stretches
RESTING_ANGLE, RESTING_SPEED = 1e-4, 1e-4  # [rad], [rad/s]: the whole log is at rest below one of them


class LogSegment(NamedTuple):
    """A stretch of a log.

    Attributes
    ----------
    kind : str
        "still", "constant speed", "run-up" (the size of the speed grows), "run-down" or "other".
    start, stop : float
        Times of its first and last sample [s].
    rows : slice
        Its samples.
    speed, acceleration : float
        Mean speed [rad/s], and slope of the straight line that is nearest to the speed [rad/s^2].
    """

    kind: str
    start: float
    stop: float
    rows: slice
    speed: float
    acceleration: float


def segments(
    time: Floats, speed: Floats, angle: Floats | None, pieces: Iterable[slice], tolerance: float
) -> tuple[LogSegment, ...]:
    """Cut a motion into stretches.

    Parameters
    ----------
    time, speed : (n,) arrays
        Times [s] and speeds [rad/s].
    angle : (n,) array or None
        Angle [rad], which shows whether anything moves at all.
    pieces : iterable of slice
        Samples between which none are missing: no stretch goes across.
    tolerance : float
        Deviation from a straight line, relative to the speed; at slow speeds what noise and `SLOW` allow.

    Returns
    -------
    tuple of LogSegment
        In the order of time.
    """
    width = max(1, int(SMOOTHED * len(time)))
    parts = [piece for piece in pieces if piece.stop - piece.start > 1]
    smooth = {part.start: uniform_filter1d(speed[part], width, mode="nearest") for part in parts}
    largest = max((float(np.max(np.abs(v))) for v in smooth.values()), default=0.0)
    rests = largest < RESTING_SPEED or (angle is not None and float(np.ptp(angle)) < RESTING_ANGLE)
    if rests:
        return tuple(_segment("still", part, time, speed) for part in parts)
    shortest = SHORTEST * (time[-1] - time[0])
    noise = max(float(np.std(np.diff(speed[part]))) for part in parts) / np.sqrt(2.0 * width)
    least = min(max(SLOW * largest, NOISY * noise), tolerance * largest)
    found: list[LogSegment] = []
    for part in parts:
        straight = _pieces(time[part], smooth[part.start], tolerance, least)
        rows = [(kind, slice(part.start + a, part.start + b)) for kind, a, b in straight]
        found += [_segment(kind, where, time, speed) for kind, where in _joined(rows, time, shortest)]
    return tuple(found)


def _pieces(t: Floats, v: Floats, tolerance: float, least: float) -> list[tuple[str, int, int]]:
    """Kind, first and last+1 sample of each straight piece of the smoothed speed."""
    at = np.unique(np.linspace(0, len(t) - 1, min(len(t), POINTS)).astype(int))
    corners = {0, len(at) - 1}
    _corners(t[at], v[at], tolerance, least, corners)
    order = [int(at[i]) for i in sorted(corners)]
    found = []
    for a, b in pairwise(order):
        size, change = np.abs(v[a : b + 1]), v[b] - v[a]
        bound = max(tolerance * float(np.max(size)), least)
        if abs(change) <= bound:
            found.append(("still" if np.mean(size) <= least else "constant speed", a, b))
        elif v[a] * v[b] < 0.0 and min(abs(v[a]), abs(v[b])) > bound:  # through rest, and on in the other direction
            middle = a + int(np.argmin(size))
            found += [("run-down", a, middle), ("run-up", middle, b)]
        else:
            found.append(("run-up" if abs(v[b]) > abs(v[a]) else "run-down", a, b))
    found[-1] = (*found[-1][:2], len(t))
    return found


def _corners(t: Floats, v: Floats, tolerance: float, least: float, corners: set[int]) -> None:
    """Add the samples between which straight lines stay within the bounds (Ramer 1972, Douglas & Peucker 1973)."""
    open_, bounds = [(0, len(t) - 1)], np.maximum(tolerance * np.abs(v), least)
    while open_:
        a, b = open_.pop()
        if b - a < 2:
            continue
        inner = slice(a + 1, b)
        off = np.abs(v[inner] - np.interp(t[inner], t[[a, b]], v[[a, b]])) / bounds[inner]
        worst = a + 1 + int(np.argmax(off))
        if off[worst - a - 1] > 1.0:
            corners.add(worst)
            open_ += [(a, worst), (worst, b)]


def _joined(rows: list[tuple[str, slice]], time: Floats, shortest: float) -> list[tuple[str, slice]]:
    """Neighbours of one kind as one stretch; what is then too short is "other"."""
    joined = _neighbours(rows)
    named = [(kind if time[r.stop - 1] - time[r.start] >= shortest else "other", r) for kind, r in joined]
    return _neighbours(named)


def _neighbours(rows: list[tuple[str, slice]]) -> list[tuple[str, slice]]:
    found: list[tuple[str, slice]] = []
    for kind, r in rows:
        if found and found[-1][0] == kind:
            found[-1] = (kind, slice(found[-1][1].start, r.stop))
        else:
            found.append((kind, r))
    return found


def _segment(kind: str, rows: slice, time: Floats, speed: Floats) -> LogSegment:
    t, v = time[rows], speed[rows]
    far = t - np.mean(t)
    slope = float(np.dot(far, v) / np.dot(far, far)) if len(t) > 1 else 0.0
    return LogSegment(kind, float(t[0]), float(t[-1]), rows, float(np.mean(v)), slope)
