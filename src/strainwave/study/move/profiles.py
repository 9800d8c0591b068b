"""Parts of a profile: how the angle of the load is to go with time. A list of parts is a duty cycle.

Every part begins where the one before has ended, and begins and ends at rest. Angles are those of the load [rad].
"""

from itertools import pairwise
from math import cbrt, inf, sqrt
from typing import Any, NamedTuple

import numpy as np

from ...base import quantities
from ...base.above import above
from ...base.protocols import lacking
from ...base.quantities import LARGEST, checked, number, shown
from ...base.results import Floats
from .path import Path

THIRD = 1.0 / 3.0  # of the time for each ramp: the motor needs the least rms torque for a load of pure inertia
EQUAL = 4  # points of the same angle in a row that are a dwell
PARTS = "a Trapezoid, an SCurve, an AngleProfile, a Dwell, or a list of them"


class Trapezoid(NamedTuple):
    """Move by an angle with constant acceleration, constant speed and constant deceleration.

    It takes `time`, the share `ramp` of it for each of the two ramps; or as little as the largest `speed` and
    `acceleration` allow. Give one or the other.
    """

    angle: quantities.Angle
    time: quantities.Time = 0.0
    ramp: quantities.Ratio = THIRD
    speed: quantities.AngularSpeed = 0.0
    acceleration: quantities.AngularAcceleration = 0.0

    def path(self) -> Path:
        """Path from angle 0 on."""
        return _ramped_path(self, 0.0, inf)

    def check(self) -> None:
        """Refuse an angle of 0, shares that leave no time, and limits together with a time (ValueError)."""
        _check_timed(self, ("speed", "acceleration"))


class SCurve(NamedTuple):
    """Move by an angle with constant jerk: like `Trapezoid`, the acceleration of its ramps rises and falls linearly.

    It takes `time`, the share `ramp` of it for each of the two ramps, and of a ramp the share `rounding` for the rise
    and the fall of the acceleration; or as little as the largest `speed`, `acceleration` and `jerk` allow.

    References
    ----------
    Biagiotti & Melchiorri, Trajectory Planning for Automatic Machines and Robots, 2008, sec. 3.4 (double S, from rest
    to rest).
    """

    angle: quantities.Angle
    time: quantities.Time = 0.0
    ramp: quantities.Ratio = THIRD
    rounding: quantities.Ratio = 0.5
    speed: quantities.AngularSpeed = 0.0
    acceleration: quantities.AngularAcceleration = 0.0
    jerk: quantities.AngularJerk = 0.0

    def path(self) -> Path:
        """Path from angle 0 on."""
        return _ramped_path(self, self.rounding, self.jerk)

    def check(self) -> None:
        """Refuse an angle of 0, shares that leave no time, and limits together with a time (ValueError)."""
        _check_timed(self, ("speed", "acceleration", "jerk"))
        if not 0.0 < self.rounding <= 0.5:
            raise ValueError(f"SCurve.rounding is {self.rounding:g}; it must be above 0 and at most 0.5")


class Dwell(NamedTuple):
    """Wait for a time."""

    time: quantities.Time

    def path(self) -> Path:
        """Path from angle 0 on."""
        return Path.of_pieces([(self.time, 0.0, 0.0)], 0.0)

    def check(self) -> None:
        """Refuse a time that is not positive (ValueError)."""
        if not self.time > 0.0:
            raise ValueError(f"Dwell.time is {self.time:g} s; it must be positive")


class AngleProfile(NamedTuple):
    """Angle of the load through points in time: cubic splines, at rest at the first and at the last point.

    Four or more points of the same angle in a row are a dwell, with a spline of its own before and after it; points of
    one angle alone are a dwell too. The speed is continuous everywhere, the acceleration but for the ends of dwells.
    """

    times: tuple[quantities.Time, ...]
    angles: tuple[quantities.Angle, ...]

    def path(self) -> Path:
        """Path from angle 0 on."""
        t, angle = np.array(self.times) - self.times[0], np.array(self.angles) - self.angles[0]
        edges = [0, *_ends_of_dwells(angle), len(t) - 1]
        parts = [_spline_path(t[i : j + 1], angle[i : j + 1]) for i, j in pairwise(edges) if i < j]
        return Path.joined(parts, 0.0)

    def check(self) -> None:
        """Refuse fewer than two points, unequal numbers of both, and times that do not increase (ValueError)."""
        if len(self.times) != len(self.angles) or len(self.times) < 2:
            raise ValueError(
                f"AngleProfile has {len(self.times)} times and {len(self.angles)} angles; give two or more of both, "
                "equally many"
            )
        for i, (before, after) in enumerate(pairwise(self.times)):
            since = before - self.times[0], after - self.times[0]
            if not since[0] < since[1]:
                if before == after:
                    fact = f"repeats {before:.9g} s"
                elif before > after:
                    fact = f"goes back from {before:.9g} s to {after:.9g} s"
                else:
                    fact = f"has {before:.9g} s and {after:.9g} s, equally long after {self.times[0]:.9g} s,"
                raise ValueError(
                    f"AngleProfile.times {fact} at point {i + 2}; a profile goes forward in time: correct or remove "
                    "the point"
                )


Part = Trapezoid | SCurve | Dwell | AngleProfile


def parts_of(profile: Any) -> tuple[Part, ...]:
    """Parts of a profile, one or a list of them, each an object or a text as the command takes it.

    Raises
    ------
    ValueError
        If there are none, or a part has a number that is out of range.
    """
    parts = tuple(profile) if lacking(profile, "path") and not isinstance(profile, str) else (profile,)
    if not parts:
        raise ValueError(f"the profile is empty; give {PARTS}")
    return tuple(checked(above("profile_part")(part) if isinstance(part, str) else part) for part in parts)


def path_of(profile: Any, start: float | None = None) -> Path:
    """Path of a whole profile from an angle [rad] of the load on: that of its first point, or 0, where none is given.

    Errors as `parts_of`, and a ValueError for a profile that moves nothing.
    """
    parts = parts_of(profile)
    first = parts[0].angles[0] if isinstance(parts[0], AngleProfile) else 0.0
    path = Path.joined([part.path() for part in parts], first if start is None else number("start [rad]", start))
    if not np.any(path.moving):
        raise ValueError(f"the profile only waits for {path.duration:g} s; give an angle to move by")
    if not path.travel() > 0.0:
        fault = f"the profile starts at {path.angle[0]:g} rad, too large to resolve angles; start closer to 0"
        raise ValueError(fault)
    return path


def _ramped_path(part: Trapezoid | SCurve, rounding: float, j: float) -> Path:
    """Path of a part from angle 0 on: in its time, or within its limits, the jerk [rad/s^3] one of them."""
    if part.time:
        ramp = part.ramp * part.time
        return _symmetric_path(part.angle, ramp, rounding * ramp, part.time - 2.0 * ramp)
    q, v, a = abs(part.angle), part.speed, part.acceleration
    rise = min(a / j, sqrt(v / j))
    ramp = rise + max(v / a, rise)
    if q < v * ramp:  # the speed is not reached
        rise = min(a / j, cbrt(q / (2.0 * j)))
        ramp = max(2.0 * rise, 0.5 * rise + sqrt(0.25 * rise * rise + q / a))
        return _symmetric_path(part.angle, ramp, rise, 0.0)
    return _symmetric_path(part.angle, ramp, rise, q / v - ramp)


def _symmetric_path(angle: float, ramp: float, rise: float, cruise: float) -> Path:
    """Path with two ramps of a time [s], each with two rises of the acceleration, and a constant speed between."""
    a = angle / (ramp + cruise) / (ramp - rise)
    if not rise:
        pieces = [(ramp, a, 0.0), (cruise, 0.0, 0.0), (ramp, -a, 0.0)]
    else:
        j, flat = a / rise, ramp - 2.0 * rise
        up = [(rise, 0.0, j), (flat, a, 0.0), (rise, a, -j)]
        pieces = [*up, (cruise, 0.0, 0.0), (rise, 0.0, -j), (flat, -a, 0.0), (rise, -a, j)]
    duration = 2.0 * ramp + cruise
    return Path.of_pieces([piece for piece in pieces if piece[0] > 1e-12 * duration], angle)


def _spline_path(t: Floats, angle: Floats) -> Path:
    """Path through points, at rest at both ends; the same angle throughout is a dwell."""
    if np.ptp(angle) == 0.0:
        return Path.of_pieces([(float(t[-1] - t[0]), 0.0, 0.0)], 0.0)
    from scipy.interpolate import CubicSpline  # a third of a second of every start, where a project has no such part

    third, second, first, value = CubicSpline(t, angle, bc_type="clamped").c
    return Path(t - t[0], value - angle[0], first, 2.0 * second, 6.0 * third, float(angle[-1] - angle[0]))


def _ends_of_dwells(angle: Floats) -> list[int]:
    """Numbers of the first and the last point of every dwell."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], np.diff(angle) == 0.0, [False]]).astype(int)))
    return [int(k) for i, j in edges.reshape(-1, 2) if j - i >= EQUAL - 1 for k in (i, j)]


def _check_timed(part: Any, limits: tuple[str, ...]) -> None:
    """Refuse a part that takes no time, or is given by a time and by limits."""
    name, given = type(part).__name__, [limit for limit in limits if getattr(part, limit)]
    if not part.angle:
        raise ValueError(f"{name}.angle is 0; give an angle to move by, or a Dwell to wait")
    if bool(part.time) == bool(given):
        fact = f"a time and {' and '.join(given)}" if given else "neither a time nor limits"
        raise ValueError(f"{name} has {fact}; give the time, or the largest {', '.join(limits)}")
    for field in ("time",) if part.time else limits:
        if not getattr(part, field) > 0.0:
            raise ValueError(f"{name}.{field} is {getattr(part, field):g}; it must be positive")
    if part.time and not abs(part.angle) / part.time / part.time < LARGEST:
        raise ValueError(f"{name}.time is {part.time:g} s for {shown(part.angle)} rad; give a longer time")
    if not 0.0 < part.ramp <= 0.5:
        raise ValueError(f"{name}.ramp is {part.ramp:g}; it must be above 0 and at most 0.5")
