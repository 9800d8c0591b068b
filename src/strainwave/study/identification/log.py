"""A log: measured channels over one time, in SI and radians.

Canonical names of channels are those of `CANONICAL`; a channel of another kind keeps the name that the user gives it.
Angles and speeds of the motor count on the motor's shaft, those of the load on the output's.

Stretches of a measured motion: rest, constant speed, run-up, run-down.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import groupby, pairwise
from typing import ClassVar, NamedTuple

import numpy as np
from scipy.ndimage import uniform_filter1d

from ...base.number_text import counted
from ...base.quantities import LARGEST, SMALLEST, joined, numbers, reals, shown
from ...base.records import Along, Labelled, Result
from ...base.results import Floats
from ...base.terminal import on_screen
from .run import CANONICAL, Run

GAP_STEPS = 1.5  # of the usual step: a longer one is a gap
SHORTEST_SHARE = 0.01  # of the log: a shorter stretch is "other"
SMOOTHED_SHARE = 0.01  # of the log: over it the speed is averaged
POINTS = 400  # of the averaged speed, through which straight lines are laid
SLOW_SHARE, NOISE_FACTOR = 2e-3, 8.0  # of the largest speed, and deviations of the averaged: bounds of slow stretches
COHERENT = 0.5  # squared correlation of both shafts' motions from which they have a ratio
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
        Deviation from a straight line, relative to the speed at the same time; at slow speeds `SLOW_SHARE` of the
        largest speed, or more in noise, is allowed.

    Returns
    -------
    tuple of LogSegment
        In the order of time.
    """
    width = max(1, int(SMOOTHED_SHARE * len(time)))
    parts = [piece for piece in pieces if piece.stop - piece.start > 1]
    smooth = {part.start: uniform_filter1d(speed[part], width, mode="nearest") for part in parts}
    largest = max((float(np.max(np.abs(v))) for v in smooth.values()), default=0.0)
    if largest < RESTING_SPEED or (angle is not None and float(np.ptp(angle)) < RESTING_ANGLE):
        return tuple(_segment("still", part, time, speed) for part in parts)
    shortest = SHORTEST_SHARE * (time[-1] - time[0])
    noise = max(float(np.std(np.diff(speed[part]))) for part in parts) / np.sqrt(2.0 * width)
    least = min(max(SLOW_SHARE * largest, NOISE_FACTOR * noise), tolerance * largest)
    stretches: list[LogSegment] = []
    for part in parts:
        straight = _pieces(time[part], smooth[part.start], tolerance, least)
        rows = [(kind, slice(part.start + a, part.start + b)) for kind, a, b in straight]
        stretches += [_segment(kind, where, time, speed) for kind, where in _joined(rows, time, shortest)]
    return tuple(stretches)


def _pieces(t: Floats, v: Floats, tolerance: float, least: float) -> list[tuple[str, int, int]]:
    """Kind, first and last+1 sample of each straight piece of the smoothed speed."""
    index = np.unique(np.linspace(0, len(t) - 1, min(len(t), POINTS)).astype(int))
    corners = {0, len(index) - 1}
    _corners(t[index], v[index], tolerance, least, corners)
    order = [int(index[i]) for i in sorted(corners)]
    pieces = []
    for a, b in pairwise(order):
        size, change = np.abs(v[a : b + 1]), v[b] - v[a]
        bound = max(tolerance * float(np.max(size)), least)
        if abs(change) <= bound:
            pieces.append(("still" if np.mean(size) <= least else "constant speed", a, b))
        elif v[a] * v[b] < 0.0 and min(abs(v[a]), abs(v[b])) > bound:  # through rest, and on in the other direction
            middle = a + int(np.argmin(size))
            pieces += [("run-down", a, middle), ("run-up", middle, b)]
        else:
            pieces.append(("run-up" if abs(v[b]) > abs(v[a]) else "run-down", a, b))
    pieces[-1] = (*pieces[-1][:2], len(t))
    return pieces


def _corners(t: Floats, v: Floats, tolerance: float, least: float, corners: set[int]) -> None:
    """Add the samples between which straight lines stay within the bounds (Ramer 1972, Douglas & Peucker 1973)."""
    open_, bounds = [(0, len(t) - 1)], np.maximum(tolerance * np.abs(v), least)
    while open_:
        a, b = open_.pop()
        if b - a < 2:
            continue
        inner = slice(a + 1, b)
        with np.errstate(over="ignore"):
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
    groups = [list(group) for _, group in groupby(rows, key=lambda row: row[0])]
    return [(group[0][0], slice(group[0][1].start, group[-1][1].stop)) for group in groups]


def _segment(kind: str, rows: slice, time: Floats, speed: Floats) -> LogSegment:
    t, v = time[rows], speed[rows]
    far = t - np.mean(t)
    slope = float(np.dot(far, v) / np.dot(far, far)) if len(t) > 1 else 0.0
    return LogSegment(kind, float(t[0]), float(t[-1]), rows, float(np.mean(v)), slope)


class Gap(NamedTuple):
    """Times [s] of the samples before and after missing ones."""

    start: float
    stop: float


@dataclass(frozen=True, eq=False)
class Log(Result):
    """Measured channels over one time.

    Attributes
    ----------
    time : (n,) array
        Times [s], ascending.
    channels : dict of str to (n,) array
        Values by name, in SI and radians; angles are unwrapped.
    units : dict of str to str
        Unit of each channel.
    notes : tuple of str
        What reading has guessed and changed, a sentence each.
    doubts : tuple of str
        What is not plausible in the channels, a sentence each.
    own : dict of str to (times, values)
        Channels that were measured at times of their own [s], as they were; `channels` has them interpolated.
    """

    time: Floats
    channels: dict[str, Floats]
    units: dict[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()
    own: dict[str, tuple[Floats, Floats]] = field(default_factory=dict)

    rows: ClassVar[str] = "time"
    places: ClassVar[Along] = {"time": {"time": "s"}}

    def __post_init__(self) -> None:
        object.__setattr__(self, "time", numbers("time [s] of a log", self.time))
        n, channels = self.time.size, {}
        if n < 2 or np.min(np.diff(self.time)) <= SMALLEST:
            raise ValueError(f"a log has two times or more, finite and ascending; these are {n} that are not")
        for name, values in self.channels.items():
            channels[name] = array = reals(values)
            if not np.all(np.abs(array) <= LARGEST) or array.shape != (n,):
                form = f"has the shape {array.shape}" if array.size else f"is {shown(values)}"
                raise ValueError(f"channel {shown(name)} {form}; give {n} finite values, up to {LARGEST:g}")
        object.__setattr__(self, "channels", channels)
        object.__setattr__(self, "units", {c: self.units.get(c, CANONICAL.get(c, "")) for c in self.channels})

    def __len__(self) -> int:
        return len(self.time)

    @property
    def step(self) -> float:
        """Mean time from sample to sample [s], gaps left out."""
        return float(np.mean(self._steps))

    @property
    def rate(self) -> float:
        """Samples per second [Hz]."""
        return 1.0 / self.step

    @property
    def jitter(self) -> float:
        """Standard deviation of the steps from sample to sample [s], gaps left out; 0 of a uniform log."""
        return float(np.std(self._steps))

    @property
    def _steps(self) -> Floats:
        """Steps [s] of time that are no gaps."""
        steps = np.diff(self.time)
        return steps[steps < GAP_STEPS * np.median(steps)]

    @property
    def gaps(self) -> tuple[Gap, ...]:
        """Gaps between samples: steps of time longer than 1.5 usual ones."""
        steps = np.diff(self.time)
        index = np.flatnonzero(steps >= GAP_STEPS * np.median(steps))
        return tuple(Gap(float(self.time[i]), float(self.time[i + 1])) for i in index)

    @property
    def ratio(self) -> float | None:
        """Ratio of the motor's motion to the load's, by angles or speeds; None without both or a motion of both.

        The gear's ratio, where both shafts were measured on their own.
        """
        for kind in ("angle", "speed"):
            motor, load = self.channels.get(f"motor_{kind}"), self.channels.get(f"load_{kind}")
            if motor is None or load is None:
                continue
            finite = np.isfinite(motor) & np.isfinite(load)
            motor, load = motor[finite], load[finite]
            if kind == "angle":
                motor, load = motor - np.mean(motor), load - np.mean(load)
            together = np.dot(load, motor)
            if together**2 > COHERENT * np.dot(load, load) * np.dot(motor, motor):
                return float(abs(together / np.dot(load, load)))
        return None

    @property
    def moving(self) -> bool:
        """True if the log has the angle or the speed of a shaft, which `segments` needs."""
        return any(f"{shaft}_{kind}" in self.channels for shaft in ("motor", "load") for kind in ("angle", "speed"))

    def unbroken(self) -> tuple[slice, ...]:
        """Samples from gap to gap."""
        edges = [0, *(int(i) for i in np.searchsorted(self.time, [gap.stop for gap in self.gaps])), len(self.time)]
        return tuple(slice(a, b) for a, b in pairwise(edges))

    def channel(self, name: str) -> Floats:
        """Values (n,) of a channel.

        Raises
        ------
        ValueError
            If the log has none of this name.
        """
        if name not in self.channels:
            names = f"{joined(self.channels)}: name one of these, or read the log again"
            raise ValueError(f"the log has no channel {shown(name)}; it has {names}")
        return self.channels[name]

    def cut(self, start: float = -math.inf, stop: float = math.inf) -> "Log":
        """Samples with start <= time <= stop [s]; their times stay.

        Raises
        ------
        ValueError
            If fewer than two samples are left.
        """
        keep = (self.time >= start) & (self.time <= stop)
        if np.count_nonzero(keep) < 2:
            ends = f"{self.time[0]:.6g} .. {self.time[-1]:.6g} s"
            raise ValueError(f"fewer than two samples are within {start:.6g} .. {stop:.6g} s; the log has {ends}")
        inside = {n: (t >= start) & (t <= stop) for n, (t, _) in self.own.items()}
        rows = {n: (t[inside[n]], v[inside[n]]) for n, (t, v) in self.own.items()}
        return replace(self, time=self.time[keep], channels={n: v[keep] for n, v in self.channels.items()}, own=rows)

    @cached_property
    def _motion(self) -> tuple[Floats, Floats | None]:
        """Speed [rad/s], and angle [rad] if there is one, of the shaft that was measured."""
        for shaft in ("load", "motor"):
            angle, speed = self.channels.get(f"{shaft}_angle"), self.channels.get(f"{shaft}_speed")
            if speed is not None:
                return speed, angle
            if angle is not None:
                return np.gradient(angle, self.time), angle
        names = joined(self.channels) or "none"
        raise ValueError(f"segments need the angle or the speed of a shaft, as load_angle; the channels are {names}")

    def segments(self, tolerance: float = 0.1) -> tuple[LogSegment, ...]:
        """Stretches of rest, of constant speed, of run-up and run-down.

        The speed, averaged over a hundredth of the log, is followed by straight lines within the tolerance. The load's
        speed is taken where there is one, else that of its angle, else the motor's.

        Parameters
        ----------
        tolerance : float
            Deviation from a straight line, relative to the speed at the same time; 0.002 of the largest speed, or more
            in noise, is always allowed.

        Returns
        -------
        tuple of LogSegment
            In the order of time, without overlap; a stretch of less than a hundredth of the log, and of what is none of
            the four kinds, is "other".

        Raises
        ------
        ValueError
            If the log has neither angle nor speed.
        """
        if not 0.0 < tolerance < 1.0:
            raise ValueError(f"the tolerance is {tolerance}; give a fraction of the speed, as 0.1")
        speed, angle = self._motion
        return segments(self.time, speed, angle, self.unbroken(), tolerance)

    def run(self, channel: str, angle: str | None = None, *, part: LogSegment | None = None) -> Run:
        """One channel over the angle of a shaft, for `order_scan`.

        Parameters
        ----------
        channel : str
            The quantity.
        angle : str, optional
            Channel of the angle. Default: `load_angle`, else `motor_angle`.
        part : LogSegment, optional
            Stretch of the log. Default: the whole log.

        Returns
        -------
        Run
            Time, angle and value of the same samples, and the unit; of a channel with times of its own at those times.

        Raises
        ------
        ValueError
            If there is no such channel.
        """
        if angle is None:
            angle = next((name for name in ("load_angle", "motor_angle") if name in self.channels), "load_angle")
        rows = slice(None) if part is None else part.rows
        value, turned, time = self.channel(channel)[rows], self.channel(angle)[rows], self.time[rows]
        if channel in self.own:
            times, values = self.own[channel]
            inside = (times >= time[0]) & (times <= time[-1])
            time, value = times[inside], values[inside]
            turned = np.interp(time, *self.own.get(angle, (self.time, self.channel(angle))))
        return Run(time, turned, value, self.units[channel])

    def variables(self) -> Labelled:
        """The channels over the time."""
        return {name: ("time", values, self.units[name]) for name, values in self.channels.items()}

    @property
    def length(self) -> str:
        """Samples, time and rate, in words."""
        return f"{len(self)} samples, {self.time[0]:.6g} to {self.time[-1]:.6g} s, {self.rate:.6g} Hz"

    def __str__(self) -> str:
        lines = [f"Log: {self.length}, {counted(len(self.gaps), 'gap')}"]
        for n, v in self.channels.items():
            lines.append(f"  {n}: {np.min(v):.4g} .. {np.max(v):.4g} {self.units[n]}".rstrip())
        remarks = [("note", note) for note in self.notes] + [("doubt", doubt) for doubt in self.doubts]
        return on_screen("\n".join([*lines, *(f"  {kind}: {text}" for kind, text in remarks)]))
