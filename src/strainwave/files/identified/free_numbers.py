"""Which numbers of a project are free unless others are named: those that the torsion of a log's law tells."""

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np

from ...law import states_of, torque_of
from ...model.excitation import KinematicError
from ...results import Floats
from ...study.identification.identified import Identified
from ...tree import numbers
from .places import Places

STIFFNESSES = ("K", "K1", "K2", "K3", "yield_twist")  # numbers of a law that are free unless others are named
SEEN = 1e-3  # of the torque: what changing a number by its own size must change
HALVINGS = 60

Range = tuple[float, float]


def usual(places: Places, reach: Range, also: Collection[str] = ()) -> tuple[list[str], list[str]]:
    """Names that are free unless others are given, and stiffnesses that a range of torsion [rad] does not tell.

    Stiffnesses that are known to be told may be named.
    """
    found, kept = stiffnesses(places, places.train, reach, also)
    found.append("damping.B")
    if isinstance(places.train.error, KinematicError):
        for i in range(len(places.train.error.lines)):
            found += [f"kinematic_error.{i}.{field}" for field in ("amplitude", "phase")]
    return [*found, "torsion.offset"], kept


def stiffnesses(
    places: Places, train: Any, reach: Range, also: Collection[str] = ()
) -> tuple[list[str], list[str]]:  # fmt: skip
    """Names of a law's stiffnesses that a range of its torsion [rad] tells, and of those that it does not."""
    told: list[str] = []
    kept: list[str] = []
    for path, owner, field, value in numbers(train):
        name = places.name(path)
        if path.startswith("law.") and field in STIFFNESSES and isinstance(value, float) and name:
            seen = name in also or hasattr(owner, "states") or _matters(owner, field, value, reach)
            (told if seen else kept).append(name)
    return told, kept


def _matters(law: Any, field: str, value: float, reach: Range) -> bool:
    """Whether a number of a spring changes its torque in a range of torsion."""
    x = np.linspace(*reach, 201)
    before, after = law.torque(x), law._replace(**{field: 1.5 * value}).torque(x)
    return bool(np.max(np.abs(after - before)) > SEEN * np.max(np.abs(before)))


def expected_range(train: Any, logs: Sequence[Mapping[str, Any]]) -> Range:
    """Least and largest torsion [rad] of the law in logs, from the load that the train holds.

    Two encoders tell the torsion up to a constant. It follows from the mean torque: gravity and other loads twist the
    gear to one side.
    """
    parts = [_twisted(train, log) for log in logs]
    return min(float(np.min(x)) for x in parts), max(float(np.max(x)) for x in parts)


def _twisted(train: Any, log: Mapping[str, Any]) -> Floats:
    """Measured torsion with the mean at which the law has the mean torque of the load."""
    x = np.asarray(log["torsion"], float)
    known = np.isfinite(x)
    time, motor = np.asarray(log["time"], float)[known], np.asarray(log["motor_angle"], float)[known]
    x = x[known]
    load, speed = motor / train.N - x, np.gradient(motor, time) / train.N
    drag = torque_of(train.load.drag, load, speed, (0.0,) * states_of(train.load.drag))
    pull = np.asarray(log["load_torque"], float)[known] if "load_torque" in log else train.load.excitation.torque(0.0)
    mean = float(np.mean(drag) - np.mean(pull)) + train.load.J * float(speed[-1] - speed[0]) / float(time[-1] - time[0])
    x = x - np.mean(x)

    def torque(shift: float) -> float:
        return float(np.mean(torque_of(train.law, x + shift, 0.0 * x, (0.0 * x,) * states_of(train.law))))

    size = float(np.ptp(x))
    while abs(torque(np.copysign(size, mean))) < abs(mean) and size < 1.0:
        size *= 2.0
    low, high = -size, size
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if torque(middle) < mean else (low, middle)
    return np.asarray(x + 0.5 * (low + high))


def found_range(found: Identified, logs: Sequence[Mapping[str, Any]]) -> Range:
    """Least and largest torsion [rad] of the law in logs, by the offset and the kinematic error that were found."""
    offset = found.value("x.offset") if "x.offset" in found.names else 0.0
    parts = []
    for log in logs:
        motor = np.asarray(log["motor_angle"], float)
        parts.append(np.asarray(log["torsion"], float) - offset - found.system.error.value(motor))
    return min(float(np.nanmin(x)) for x in parts), max(float(np.nanmax(x)) for x in parts)
