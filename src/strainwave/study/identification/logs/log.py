"""A log: measured channels over one time, in SI and radians.

Canonical names of channels are those of `CANONICAL`; a channel of another kind keeps the name that the user gives it.
Angles and speeds of the motor count on the motor's shaft, those of the load on the output's.
"""

import math
import os
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import ClassVar, NamedTuple

import numpy as np

from ....archive import ENDINGS, as_file, atomic, listed
from ....records import Labelled, Result
from ....results import Floats
from ....sentences import on_screen
from ..run import Run
from .motion import LogSegment, segments

CANONICAL = {
    "motor_angle": "rad", "load_angle": "rad", "motor_speed": "rad/s", "load_speed": "rad/s", "motor_torque": "N*m",
    "load_torque": "N*m", "torque": "N*m", "torsion": "rad", "current": "A", "input": "", "output": "",
}  # fmt: skip
HOLE = 1.5  # of the usual step: a longer one is a gap


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
    """

    time: Floats
    channels: dict[str, Floats]
    units: dict[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()

    rows: ClassVar[str] = "time"

    def __post_init__(self) -> None:
        n = len(self.time)
        if n < 2 or not np.all(np.isfinite(self.time)) or np.min(np.diff(self.time)) <= 0.0:
            raise ValueError(f"a log has two times or more, finite and ascending; these are {n} that are not")
        for name, values in self.channels.items():
            if np.shape(values) != (n,) or not np.all(np.isfinite(values)):
                raise ValueError(f"channel {name!r} has the shape {np.shape(values)}; give {n} finite values")
        known = {name: self.units.get(name, CANONICAL.get(name, "")) for name in self.channels}
        object.__setattr__(self, "units", known)

    def __len__(self) -> int:
        return len(self.time)

    @property
    def step(self) -> float:
        """Mean time from sample to sample [s], gaps left out."""
        steps = np.diff(self.time)
        return float(np.mean(steps[steps < HOLE * np.median(steps)]))

    @property
    def rate(self) -> float:
        """Samples per second [Hz]."""
        return 1.0 / self.step

    @property
    def jitter(self) -> float:
        """Standard deviation of the steps from sample to sample [s], gaps left out; 0 of a uniform log."""
        steps = np.diff(self.time)
        return float(np.std(steps[steps < HOLE * np.median(steps)]))

    @property
    def gaps(self) -> tuple[Gap, ...]:
        """Where samples are missing: steps of time longer than 1.5 usual ones."""
        steps = np.diff(self.time)
        at = np.flatnonzero(steps >= HOLE * np.median(steps))
        return tuple(Gap(float(self.time[i]), float(self.time[i + 1])) for i in at)

    @property
    def ratio(self) -> float | None:
        """How many times as far as the load the motor turns, by angles or speeds; None without both or without motion.

        The gear's ratio, where both shafts were measured on their own.
        """
        for kind in ("angle", "speed"):
            motor, load = (self.channels.get(f"{shaft}_{kind}") for shaft in ("motor", "load"))
            if motor is None or load is None:
                continue
            shift = np.mean(load) if kind == "angle" else 0.0
            far = load - shift
            if np.any(far != 0.0):
                return float(abs(np.dot(far, motor - np.mean(motor) * (kind == "angle")) / np.dot(far, far)))
        return None

    @property
    def moving(self) -> bool:
        """Whether the log has the angle or the speed of a shaft, which `segments` needs."""
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
            there = ", ".join(self.channels)
            raise ValueError(f"the log has no channel {name!r}; it has {there}: name one of these, or read it again")
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
        return replace(self, time=self.time[keep], channels={n: v[keep] for n, v in self.channels.items()})

    @cached_property
    def _motion(self) -> tuple[Floats, Floats | None]:
        """Speed [rad/s], and angle [rad] if there is one, of the shaft that was measured."""
        for shaft in ("load", "motor"):
            angle, speed = (self.channels.get(f"{shaft}_{kind}") for kind in ("angle", "speed"))
            if speed is not None:
                return speed, angle
            if angle is not None:
                return np.gradient(angle, self.time), angle
        there = ", ".join(self.channels) or "none"
        raise ValueError(f"segments need the angle or the speed of a shaft, as load_angle; the channels are {there}")

    def segments(self, tolerance: float = 0.1) -> tuple[LogSegment, ...]:
        """Stretches of rest, of constant speed, of run-up and run-down.

        The speed, averaged over a hundredth of the log, is followed by straight lines within the tolerance. The load's
        speed is taken where there is one, else that of its angle, else the motor's.

        Parameters
        ----------
        tolerance : float
            Deviation from a straight line, relative to the largest speed.

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
            raise ValueError(f"the tolerance is {tolerance}; give a fraction of the largest speed, as 0.1")
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
            Time, angle and value of the same samples, and the unit.

        Raises
        ------
        ValueError
            If there is no such channel.
        """
        if angle is None:
            angle = (
                "motor_angle" if "load_angle" not in self.channels and "motor_angle" in self.channels else "load_angle"
            )
        rows = slice(None) if part is None else part.rows
        value, turned = self.channel(channel)[rows], self.channel(angle)[rows]
        return Run(self.time[rows], turned, value, self.units[channel])

    def coordinates(self) -> Labelled:
        """Times of the samples."""
        return {"time": ("time", self.time, "s")}

    def variables(self) -> Labelled:
        """The channels over the time."""
        return {name: ("time", values, self.units[name]) for name, values in self.channels.items()}

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write as other results do, or as CSV (`.csv`) that `read_log` reads; the file appears when it is complete.

        Raises
        ------
        ValueError
            If the ending is another.
        """
        path = as_file(path)
        if path.suffix in ENDINGS:
            return super().save(path)
        if path.suffix != ".csv":
            raise ValueError(
                f"cannot save a log as {path.name!r}; use a name that ends in {listed((*ENDINGS, '.csv'))}"
            )
        header = ",".join(["time [s]", *(f"{name} [{self.units[name]}]" for name in self.channels)]).replace(" []", "")
        with atomic(path) as part:
            table = np.column_stack([self.time, *self.channels.values()])
            np.savetxt(part, table, delimiter=",", header=header, comments="", fmt="%.17g")
        return path

    def __str__(self) -> str:
        rows = [
            f"  {name}: {np.min(v):.4g} .. {np.max(v):.4g} {self.units[name]}".rstrip()
            for name, v in self.channels.items()
        ]
        return on_screen(
            "\n".join(
                [
                    f"Log: {len(self)} samples, {self.time[0]:.6g} .. {self.time[-1]:.6g} s, {self.rate:.6g} Hz, "
                    f"{len(self.gaps)} gaps",
                    *rows,
                    *(f"  note: {note}" for note in self.notes),
                    *(f"  doubt: {doubt}" for doubt in self.doubts),
                ]
            )
        )

    __repr__ = __str__
