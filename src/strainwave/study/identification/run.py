"""One stretch of a measurement in which a shaft turns one way: a quantity over time and angle; names of channels."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import numpy as np

from ...base.quantities import LARGEST, number, reals, samples_of
from ...base.results import Floats

CANONICAL = {
    "motor_angle": "rad", "load_angle": "rad", "motor_speed": "rad/s", "load_speed": "rad/s", "motor_torque": "N*m",
    "load_torque": "N*m", "torque": "N*m", "torsion": "rad", "current": "A", "input": "", "output": "",
}  # fmt: skip
FEWEST_SAMPLES = 32
SLOW_WAVES = 12  # waves over the travel, at most, that friction and drift along it may have
STILL_RAD = 1e-9  # rad
CLIPPED_SHARE, CLIPPED_ROW = 0.005, 3  # share of the samples at an extreme value, samples in a row there


@dataclass(frozen=True, eq=False)
class Run:
    """A quantity measured while a shaft turns one way.

    Attributes
    ----------
    time : (n,) array
        Times [s], ascending.
    angle : (n,) array
        Angle [rad] of the shaft whose turns orders count, unwrapped; any part of a turn does.
    value : (n,) array
        What was measured: an angle, a torque, a current, a speed.
    unit : str
        Its unit.

    Raises
    ------
    ValueError
        If the arrays do not fit, hold what is no number, the time does not ascend, or the shaft does not turn one way.
    """

    time: Floats
    angle: Floats
    value: Floats
    unit: str = ""

    def __post_init__(self) -> None:
        columns = {name: column(name, getattr(self, name)) for name in ("time", "angle", "value")}
        shapes = {name: values.shape for name, values in columns.items()}
        if len(set(shapes.values())) > 1 or columns["time"].ndim != 1:
            listing = ", ".join(f"{name} {shape}" for name, shape in shapes.items())
            raise ValueError(f"a run has arrays of the shapes {listing}; give one length")
        if len(columns["time"]) < FEWEST_SAMPLES:
            raise ValueError(f"a run has {len(columns['time'])} samples; give {FEWEST_SAMPLES} at least")
        for name, values in columns.items():
            object.__setattr__(self, name, values)
        refuse_descending(self.time)
        steps = np.sign(self.travel) * np.diff(self.angle)
        back = -float(np.sum(steps[steps < 0.0]))
        if not abs(self.travel) > STILL_RAD:
            raise ValueError(f"the angle stays at {self.angle[0]:.6g} rad; a run needs a shaft that turns")
        if back > 0.2 * abs(self.travel):
            raise ValueError(
                f"the angle goes back by {back:.4g} rad in all while it travels {abs(self.travel):.4g} rad; a run "
                "needs a shaft that turns one way: give forward and backward motion as two runs"
            )

    @property
    def travel(self) -> float:
        """Angle travelled [rad], negative backward."""
        return float(self.angle[-1] - self.angle[0])

    @property
    def speed(self) -> float:
        """Mean speed [rad/s], negative backward."""
        return self.travel / float(self.time[-1] - self.time[0])

    @property
    def turns(self) -> float:
        """Turns travelled."""
        return abs(self.travel) / (2.0 * np.pi)

    def slow_columns(self, lowest: float) -> Floats:
        """Columns (n, m): mean, drift and slow waves along the travel, all slower than half of the lowest order.

        Beside a parabola and a cubic, few cosines hold a smooth drift: these have its slopes at both ends.
        """
        s = (self.angle - self.angle[0]) / self.travel
        many = int(np.clip(0.5 * lowest * self.turns, 0, SLOW_WAVES))
        waves = [np.cos(np.pi * m * s) for m in range(2, many + 1)]
        smooth = [(s - 0.5) ** m for m in (2, 3) if m <= len(waves)]
        return np.column_stack([np.ones_like(s), s - 0.5, *smooth, *waves])

    def angle_before(self, delay: float) -> Floats:
        """Angle (n,) [rad] a time [s] before each sample; beyond the ends at the mean speed there."""
        return angle_before(self.time, self.angle, number("delay [s]", delay))


def column(name: str, values: Any, item: str = "sample") -> Floats:
    """Finite real numbers as a new array, or say which of the samples is none (ValueError)."""
    array = reals(values)
    good = np.abs(array) <= LARGEST
    if not np.all(good):
        i = int(np.flatnonzero(~good)[0])
        raise ValueError(f"{name} of {item} {i} is {array.flat[i]}; remove the {item}")
    return samples_of(name, values)


def refuse_descending(values: Floats, name: str = "time", unit: str = "s", remedy: str = "times must ascend") -> None:
    """Refuse times, or other values, that do not ascend (ValueError)."""
    if not np.all(np.diff(values) > 0.0):
        i = int(np.flatnonzero(np.diff(values) <= 0.0)[0])
        after = f"{values[i + 1]:.9g} {unit} of sample {i + 1} stands after {values[i]:.9g} {unit}"
        raise ValueError(f"{name} {after}; {remedy}")


def angle_before(time: Floats, angle: Floats, delay: float) -> Floats:
    """Angle (n,) [rad] a time [s] before each of two samples or more; beyond the ends at the mean speed there."""
    moments = time - delay
    delayed = np.interp(moments, time, angle)
    many = max(2, len(time) // 50)
    for end, part in ((0, slice(0, many)), (-1, slice(-many, None))):
        t, a = time[part], angle[part]
        rate = float(a[-1] - a[0]) / float(t[-1] - t[0])
        out = moments < time[0] if end == 0 else moments > time[-1]
        delayed[out] = angle[end] + rate * (moments[out] - time[end])
    return np.asarray(delayed)


def saturated(values: Floats) -> Iterator[tuple[float, str, float]]:
    """Extreme values that many samples in a row have exactly: level, "smallest" or "largest", and share of all."""
    levels, counts = np.unique(values, return_counts=True)
    if len(levels) < 10:  # a switch, or a channel that is constant
        return
    for end, beside, extreme in ((0, 1, "smallest"), (-1, -2, "largest")):
        level, count = float(levels[end]), int(counts[end])
        if level == 0.0 or count < CLIPPED_SHARE * len(values) or count < 5 * counts[beside]:
            continue
        if max(sum(1 for _ in run) for at_level, run in groupby(values == level) if at_level) >= CLIPPED_ROW:
            yield level, extreme, count / len(values)
