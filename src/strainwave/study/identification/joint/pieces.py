"""Pieces of logs without gaps: the motor's angle on a fine grid, and the load's angle at its own times."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import BSpline, CubicSpline, make_interp_spline, make_lsq_spline
from scipy.ndimage import uniform_filter1d
from scipy.signal import savgol_filter

from ....base.quantities import joined
from ....base.results import Floats
from ..log import Log

GAP = 5.0  # usual steps: a longer one parts two pieces
FEWEST = 40  # samples of a piece
FAR = 0.05  # of a gear's ratio: what the angles may say otherwise
GRID_STEPS = 240_000  # of the grid in all: of longer logs parts are taken
PARTS = 8
KNOTS = 0.0025  # s, between knots of the motor's angle
MARGIN = 0.004  # s, at both ends of a piece: how far two encoders' stamps may be apart, and more is asked for
SMOOTH, LASTS = 9, 0.5  # samples over which speeds are averaged; s that one error of a reading lasts at most
ELSEWHERE = 64.0  # counts that a shaft turns from one place to the next
STILL = 1e-4  # rad of the load: nothing moves


class Angles(NamedTuple):
    """Angles of a log, each at its own times: (k,) times [s] and angles [rad] of the motor, (m,) of the load."""

    motor_time: Floats
    motor: Floats
    load_time: Floats
    load: Floats

    @property
    def times(self) -> tuple[Floats, Floats]:
        """Times of the motor's angles, and of the load's."""
        return self.motor_time, self.load_time

    def within(self, begin: float, end: float) -> "Angles":
        """The angles that were read from a time to another."""
        of_motor, of_load = ((time >= begin) & (time <= end) for time in self.times)
        return Angles(self.motor_time[of_motor], self.motor[of_motor], self.load_time[of_load], self.load[of_load])


@dataclass(frozen=True, eq=False)
class Piece:
    """A stretch of a log. `time`, `value` and `weight` are the load's, whose angles a fit compares.

    Attributes
    ----------
    begin, step : float
        Time of the first point of the grid, and its step [s].
    motor, motor_rate : (2 n + 1,) arrays
        Angle [rad] and speed [rad/s] of the motor at every half step.
    read_time, read : (k,) arrays
        Stamps [s] and readings [rad] of the motor.
    load, load_rate : (2 n + 1,) arrays
        The load's, by its own stamps.
    time, value : (m,) arrays
        Stamps [s] and angles [rad] of the load.
    counts, lasting : (2,) and (2, m) arrays
        Counts of the load's and the motor's encoder [rad of the load], 0 where readings are not counted; and for how
        many samples a reading's error lasts where a shaft moves by less than a count from one to the next.
    weight : (m,) array
        Of the load's angles.
    ratio : float
        Of the gear.
    log : int
        Which log it is from.
    """

    begin: float
    step: float
    motor: Floats
    motor_rate: Floats
    read_time: Floats
    read: Floats
    load: Floats
    load_rate: Floats
    time: Floats
    value: Floats
    counts: Floats
    lasting: Floats
    weight: Floats
    ratio: float
    log: int

    def __len__(self) -> int:
        return (len(self.motor) - 1) // 2

    @property
    def grid(self) -> Floats:
        """Times [s] of the half steps (2 n + 1,)."""
        return np.asarray(self.begin + 0.5 * self.step * np.arange(len(self.motor)))

    @property
    def turned(self) -> Floats:
        """Angles [rad] of the motor at the load's stamps (m,)."""
        return np.interp(self.time, self.grid, self.motor)

    def misread(self, rng: np.random.Generator, many: int) -> Floats:
        """Errors [rad of the load] that the motor's counts may have, and rates (2, 2 n + 1, many), at half steps."""
        count, ratio = self.counts[1] * self.ratio, self.ratio
        if count == 0.0:
            return np.zeros((2, len(self.motor), many))
        gone = np.cumsum(np.abs(np.diff(self.read, prepend=self.read[0]))) // (ELSEWHERE * count)
        stop = np.cumsum(np.diff(gone, prepend=0.0) > 0.0)  # rests apart are misread apart
        path = savgol_filter(self.read, SMOOTH, 3)[:, None] + count * rng.uniform(size=(stop[-1] + 1, many))[stop]
        error = through(self.read_time, (np.round(path / count) * count - path) / ratio)
        return np.array([error(self.grid), error(self.grid, 1)])

    def weighed(self, white: float) -> "Piece":
        """The piece weighed for readings that scatter so much [rad] from one to the next; noise blurs the counts."""
        each = self.counts**2 / 12.0
        blur = 4.0 * np.pi**2 * max(white**2 - each[0], 0.0) / (self.counts[0] ** 2 or 1.0)
        error = each[0] * np.exp(-min(blur, 100.0)) * self.lasting[0] + each[1] * self.lasting[1]
        return replace(self, weight=white / np.sqrt(white**2 + error)) if white > 0.0 else self


def angles_of(log: Log | Mapping[str, Any], which: int) -> Angles:
    """Angles of the motor and of the load, each as it was sampled.

    Raises
    ------
    ValueError
        If an angle is missing.
    """
    arrays: list[Floats] = []
    for name in ("motor_angle", "load_angle"):
        if (channel := channel_of(log, name)) is None:
            channels = log.channels if isinstance(log, Log) else [key for key in log if key != "time"]
            raise ValueError(
                f"log {which + 1} has no channel {name!r}; it has {joined(channels)}: name its column. Without both "
                "angles no torsion is seen, and the stiffness and the load's inertia are tied; order_scan reads lines "
                "of a torque"
            )
        t, values = channel
        if len(t) > 1 and np.min(steps := np.diff(t)) <= 0.0:
            raise ValueError(f"log {which + 1}: stamps go back or repeat at {t[np.argmin(steps)]:.9g} s; sort it")
        arrays += [t, values]
    return Angles(*arrays)


def channel_of(log: Log | Mapping[str, Any], name: str) -> tuple[Floats, Floats] | None:
    """Times and finite readings of a channel as it was sampled; None where the log has none."""
    if isinstance(log, Log):
        if name not in log.channels:
            return None
        time, values = log.own.get(name, (log.time, log.channels[name]))
    else:
        if name not in log:
            return None
        time, values = np.asarray(log["time"], float), np.asarray(log[name], float)
    if values.shape != time.shape:
        raise ValueError(f"channel {name!r} has the shape {values.shape}, and its times {time.shape}; give one length")
    good = np.isfinite(values) & np.isfinite(time)
    return time[good], values[good]


def pieces_of(logs: Sequence[Any], ratio: float, step: float) -> tuple[list[Piece], float]:
    """Pieces of all logs, and the direction of the load against the motor, 1 or -1.

    Raises
    ------
    ValueError
        If the angles are not those of a gear of this ratio, nothing moves, or too little is left.
    """
    raw = [angles_of(log, i) for i, log in enumerate(logs)]
    sense = _sense(raw, ratio)
    stretches = [(i, *part) for i, one in enumerate(raw) for part in _stretches(one)]
    if not stretches:
        raise ValueError(f"no section of the logs has {FEWEST} gapless samples of both angles; record longer sections")
    many = sum((end - begin) / step for _, begin, end in stretches)
    if many > GRID_STEPS:
        stretches = _parts(stretches, GRID_STEPS * step)
    pieces = [piece for i, a, b in stretches if (piece := _piece(raw[i], i, a, b, step, sense, ratio)) is not None]
    if not pieces:
        steps = float(np.median(np.diff(raw[0].load_time)))
        raise ValueError(
            f"the load's angle has {steps:.3g} s between its readings, too few for a joint that rings; log faster, or "
            "give the unit of the time"
        )
    return pieces, sense


def _sense(raw: Sequence[Angles], ratio: float) -> float:
    """Direction of the load against the motor, by the slope of one angle over the other."""
    rows = []
    for i, angles in enumerate(raw):
        if (fewest := min(map(len, angles.times))) < FEWEST:
            raise ValueError(f"log {i + 1} has {fewest} samples of an angle; {FEWEST} are the least")
        sampled = np.interp(angles.load_time, angles.motor_time, angles.motor)
        rows.append((sampled - np.mean(sampled), angles.load - np.mean(angles.load)))
    motor, load = np.concatenate([r[0] for r in rows]), np.concatenate([r[1] for r in rows])
    for name, turned in (("motor_angle", np.ptp(motor) / ratio), ("load_angle", np.ptp(load))):
        if turned < STILL:
            raise ValueError(f"{name} stays within {turned:.2g} rad of the load: nothing moves; record a motion")
    slope = float(load @ motor / (load @ load))
    if abs(abs(slope) / ratio - 1.0) > FAR:
        raise ValueError(f"the motor turns {abs(slope):.4g} times as far as the load, {_why(abs(slope), ratio)}")
    return float(np.sign(slope))


def _why(slope: float, ratio: float) -> str:
    """Cause of an unlike ratio, and the remedy."""
    fact = f"and the gear's ratio is {ratio:g}"
    for factor, cause in (
        (1.0 / ratio**2, "the angles are swapped: motor_angle is that of the load, load_angle that of the motor"),
        (1.0 / ratio, "both angles refer to one shaft: give the motor angle on the motor shaft"),
        (np.pi / 180.0, "the motor's angle is read in rad and seems to be in another unit than the load's: give units"),
        (180.0 / np.pi, "the motor's angle seems to be in deg and was read in rad: give units"),
        (2.0 * np.pi, "the load's angle seems to be in rev and was read in rad: give units"),
        (0.5 / np.pi, "the motor's angle seems to be in rev and was read in rad: give units"),
    ):
        if abs(slope / (ratio * factor) - 1.0) < FAR:
            return f"{fact}; {cause}"
    return f"{fact}; use the gear of the log, or give both angles on their own shafts"


def _stretches(angles: Angles) -> list[tuple[float, float]]:
    """Begins and ends of the stretches in which neither channel has a gap."""
    first, last = max(t[0] for t in angles.times), min(t[-1] for t in angles.times)
    holes: list[tuple[float, float]] = []
    for t in angles.times:
        steps = np.diff(t)
        indices = np.flatnonzero(steps > max(GAP * float(np.median(steps)), 1e-9))
        holes += [(float(t[i]), float(t[i + 1])) for i in indices]
    stretches, begin = [], first
    for a, b in sorted(holes):
        if a > begin:
            stretches.append((begin, min(a, last)))
        begin = max(begin, b)
    stretches.append((begin, last))
    return [(a, b) for a, b in stretches if min(np.sum((t >= a) & (t <= b)) for t in angles.times) >= FEWEST]


def _parts(stretches: list[tuple[int, float, float]], seconds: float) -> list[tuple[int, float, float]]:
    """Parts of the longest stretches, evenly spread, so many seconds in all."""
    total = sum(b - a for _, a, b in stretches)
    parts = []
    for i, a, b in stretches:
        many = max(round(PARTS * (b - a) / total), 1)
        each = seconds * (b - a) / total / many
        parts += [(i, begin, begin + each) for begin in np.linspace(a, b - each, many).tolist()]
    return parts


def _piece(
    raw: Angles, log: int, begin: float, end: float, step: float, sense: float, ratio: float
) -> Piece | None:  # fmt: skip
    """The piece of a log from a time to another; None where it has too few samples.

    The motor's angle is a spline over the grid, which begins with its first reading. The load's angle is a spline over
    the grid too, and its readings are kept at their own stamps, but for those at the margins.
    """
    angles = raw.within(begin, end)
    if min(map(len, angles.times)) < FEWEST:
        return None
    first, stamps, load = angles.motor_time[0], angles.load_time, sense * angles.load
    n = int((angles.motor_time[-1] - first) / step)
    grid = 0.5 * step * np.arange(2 * n + 1)
    inside = (stamps >= first + MARGIN) & (stamps <= first + grid[-1] - MARGIN)
    if np.count_nonzero(inside) < FEWEST:
        return None
    turned, followed = through(angles.motor_time - first, angles.motor), CubicSpline(stamps - first, load)
    within = np.clip(grid, stamps[0] - first, stamps[-1] - first)
    time, value, usual = stamps[inside], load[inside], float(np.median(np.diff(stamps)))
    counts = np.array([count_of(load), count_of(angles.motor) / ratio])
    shafts = value, np.interp(time, angles.motor_time, angles.motor) / ratio
    lasting = np.array([_lasting(time, shaft, count, usual) for shaft, count in zip(shafts, counts, strict=True)])
    return Piece(
        begin=float(first), step=step, motor=turned(grid), motor_rate=turned(grid, 1), read_time=angles.motor_time,
        read=angles.motor, load=followed(within), load_rate=followed(within, 1), time=time, value=value, counts=counts,
        lasting=lasting, weight=np.ones(len(time)), ratio=ratio, log=log,
    )  # fmt: skip


def through(time: Floats, values: Floats) -> BSpline:
    """Fifth-degree spline through readings, or nearest to them where they are closer than `KNOTS`."""
    many = round(KNOTS / float(np.median(np.diff(time))))
    if many < 2:
        return make_interp_spline(time, values, k=5)
    inner = time[3 * many : -3 * many : many]
    return make_lsq_spline(time, values, np.concatenate([[time[0]] * 6, inner, [time[-1]] * 6]), k=5)


def count_of(values: Floats) -> float:
    """Count of an encoder [rad], the least change of its readings; 0 where they are not counted."""
    steps = np.diff(np.unique(values))
    if len(steps) < 2:
        return 0.0
    count = float(np.min(steps[steps > 1e-12], initial=np.inf))
    multiples = steps / count
    return count if np.all(np.abs(multiples - np.round(multiples)) < 0.05) else 0.0


def _lasting(time: Floats, values: Floats, count: float, step: float) -> Floats:
    """For how many samples (m,) the error of a counted reading lasts beyond the first."""
    speed = np.abs(np.gradient(uniform_filter1d(values, SMOOTH), time))
    return np.asarray(np.maximum(np.minimum(count / np.maximum(speed, 1e-300), LASTS) / step - 1.0, 0.0))
