"""`Path`: the angle of the load over a whole profile, as segments of constant jerk from knot to knot."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...base.results import Booleans, Floats
from ...model.train.motion import Segment


@dataclass(frozen=True, eq=False)
class Path:
    """Angle of the load over time, at rest at its begin and its end.

    Attributes
    ----------
    knots : (n + 1,) array
        Times [s] at which the segments begin, and the end.
    angle, speed, acceleration, jerk : (n,) arrays
        Of the load at the begin of each segment [rad, rad/s, rad/s^2, rad/s^3]; the jerk is constant in it.
    last : float
        Angle [rad] at the end.
    """

    knots: Floats
    angle: Floats
    speed: Floats
    acceleration: Floats
    jerk: Floats
    last: float

    @classmethod
    def of_pieces(cls, pieces: list[tuple[float, float, float]], last: float) -> "Path":
        """Path from rest at angle 0 through pieces (time [s], acceleration at its begin, jerk) to rest at `last`."""
        rows, t, angle, speed = [], 0.0, 0.0, 0.0
        for h, a, j in pieces:
            rows.append((t, angle, speed, a, j))
            t, angle, speed = t + h, angle + h * (speed + h * (0.5 * a + h * j / 6.0)), speed + h * (a + 0.5 * h * j)
        knots, angles, speeds, accelerations, jerks = np.array(rows, float).T
        return cls(np.append(knots, t), angles, speeds, accelerations, jerks, last)

    @classmethod
    def joined(cls, parts: list["Path"], start: float) -> "Path":
        """Paths one after the other, from time 0 and an angle [rad] on; each begins where the one before ended."""
        knots, angles = [np.zeros(1)], []
        for part in parts:
            angles.append(part.angle + start)
            knots.append(part.knots[1:] + knots[-1][-1])
            start += part.last
        speed = np.concatenate([part.speed for part in parts])
        acceleration = np.concatenate([part.acceleration for part in parts])
        jerk = np.concatenate([part.jerk for part in parts])
        return cls(np.concatenate(knots), np.concatenate(angles), speed, acceleration, jerk, start)

    @property
    def duration(self) -> float:
        """Time [s] from the begin to the end."""
        return float(self.knots[-1])

    @property
    def moving(self) -> Booleans:
        """True for each segment (n,) in which the load moves."""
        return np.asarray((self.speed != 0.0) | (self.acceleration != 0.0) | (self.jerk != 0.0))

    def motions(self) -> list[tuple[float, float]]:
        """Begin and end [s] of every motion: the stretches between the dwells."""
        edges = np.flatnonzero(np.diff(np.concatenate([[False], self.moving, [False]]).astype(int)))
        return [(float(self.knots[i]), float(self.knots[j])) for i, j in edges.reshape(-1, 2)]

    def motion_at(self, t: Floats) -> tuple[Floats, Floats, Floats]:
        """Angle [rad], speed [rad/s] and acceleration [rad/s^2] of the load at times (m,); at rest after the end."""
        i = np.clip(np.searchsorted(self.knots, t, side="right") - 1, 0, len(self.angle) - 1)
        part = self.segments(i, 1.0)
        over = np.asarray(t) >= self.knots[-1]
        values = (part.value(t), part.slope(t), part.curvature(t))
        end_values = (self.last, 0.0, 0.0)
        angle, speed, acceleration = [np.where(over, end, value) for value, end in zip(values, end_values, strict=True)]
        return angle, speed, acceleration

    def segments(self, i: Any, N: float) -> Segment:
        """Segments number i (m,) of a motor with a ratio N to the load: one, its fields arrays."""
        fields: Any = (self.angle, self.speed, self.acceleration, self.jerk)
        begin: Any = self.knots[i]
        return Segment(begin, *(N * field[i] for field in fields))

    def dense(self, each: int) -> Floats:
        """Times [s] with so many equal steps in each segment."""
        share = np.arange(each) / each
        return np.append((self.knots[:-1, None] + share * np.diff(self.knots)[:, None]).ravel(), self.knots[-1])

    def crossings(self, speed: float) -> Floats:
        """Times [s], ascending, at which the size of the load's speed passes a level [rad/s] above 0."""
        return np.unique(np.concatenate([self._at_speed(level) for level in (speed, -speed)]))

    def time_within(self, low: float, high: float) -> float:
        """Time [s] for which the size of the load's speed is between two levels [rad/s]."""
        ends = [self.crossings(level) for level in (low, high) if level > 0.0]
        times = np.unique(np.concatenate([self.knots, *ends]))
        speed = np.abs(self.motion_at(0.5 * (times[1:] + times[:-1]))[1])
        return float(np.sum(np.diff(times)[(speed >= low) & (speed <= high)]))

    def travel(self) -> float:
        """Angle [rad] that the load turns by, back and forth."""
        times = np.unique(np.concatenate([self.knots, self._at_speed(0.0)]))
        return float(np.sum(np.abs(np.diff(self.motion_at(times)[0]))))

    def _at_speed(self, level: float) -> Floats:
        """Times [s] at which the speed passes a level: zeros of v - level + a s + j s^2/2 inside the segments."""
        v, a, half, h = self.speed - level, self.acceleration, 0.5 * self.jerk, np.diff(self.knots)
        with np.errstate(divide="ignore", invalid="ignore"):
            # the stable form of the quadratic formula: q/(j/2) and v/q, the second alone where the jerk is 0
            q = -0.5 * (a + np.copysign(np.sqrt(a * a - 4.0 * half * v), a))
            roots = np.array([q / half, v / q])
        inside = (roots >= 0.0) & (roots <= h)  # nan, where there is no zero, is not
        return np.asarray((self.knots[:-1] + roots)[inside])
