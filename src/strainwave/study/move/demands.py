"""What a profile asks of a rigid drive, and what a motion asks of a motor against its limits."""

import math
from typing import Any, NamedTuple

import numpy as np

from ...law import states_of, torque_of
from ...model.gears.limits import Finding
from ...model.train.drive_train import DriveTrain
from ...numerics.loading import loaded_state
from ...protocols import lacking
from ...quantities import AngularSpeed, Torque, number
from ...results import Floats, SolveError
from ...units import RPM
from .path import Path

STRONGER, SLOWER = "take a stronger motor, another ratio or less load", "drive slower, or take a smaller ratio"
EACH = 16  # samples in a segment: gravity varies little in it


class MotorLimits(NamedTuple):
    """Largest torque [N*m] and speed [rad/s] of a motor; infinite where nothing is known."""

    torque: Torque = math.inf
    speed: AngularSpeed = math.inf

    def check(self) -> None:
        """Refuse limits that are not positive (ValueError)."""
        for name in self._fields:
            if getattr(self, name) != math.inf:
                number(f"MotorLimits.{name}", getattr(self, name), positive=True)


def motor_findings(
    limits: MotorLimits, torque: float | None, speed: float | None, holding: float = 0.0,
    remedies: tuple[str, str] = (STRONGER, SLOWER),
) -> tuple[Finding, ...]:  # fmt: skip
    """Compare a motor's largest torque [N*m] and speed [rad/s] with its limits, where both are known.

    `holding` is the part of the torque that loads and friction take at steady speed, `remedies` what helps beyond.
    """
    found = []
    rpm = None if speed is None else speed / RPM
    parts = (("torque", torque, limits.torque, "N*m"), ("speed", rpm, limits.speed / RPM, "rpm"))
    for (name, value, bound, unit), remedy in zip(parts, remedies, strict=True):
        if value is None or not math.isfinite(bound):
            continue
        beyond = Finding(f"motor {name}", value, bound, unit, "").exceeded
        end = f"within its limit of {bound:.4g} {unit}"
        if beyond:
            steady = name == "torque" and holding > bound
            alone = f" (loads and friction alone take {holding:.4g} N*m)" if steady else ""
            end = f"above its limit of {bound:.4g} {unit}{alone}; {remedy}"
        sentence = f"The {name} of the motor reaches {value:.4g} {unit}, {end}."
        found.append(Finding(f"motor {name}", value, bound, unit, sentence))
    return tuple(found)


class Demand(NamedTuple):
    """Of a rigid drive, at times (m,) of a profile [s].

    `angle` of the load [rad], `speed` of the motor [rad/s]; torques [N*m]: `holding` at the output, of gravity,
    friction and the load's own mean torque, and `motor`, all that the motor has to give.
    """

    t: Floats
    angle: Floats
    speed: Floats
    holding: Floats
    motor: Floats


def demand_of(train: DriveTrain, path: Path, stretch: float = 1.0) -> Demand:
    """What a path asks of a train without its elasticity, with the accelerations of one so many times as long."""
    t = path.dense(EACH)
    angle, speed, acceleration = path.at(np.append(np.nextafter(t[:-1], np.inf), t[-1]))
    acceleration = acceleration / stretch**2
    end, N = train.load.end(), train.N
    holding = _drag(end.drag, angle, speed) - end.excitation.torque(t)
    passed = holding + (end.J + sum(J for J, _, _ in train.load.chain())) * acceleration
    lost = _drag(train.motor.drag, N * angle, N * speed) + train.friction.torque(passed, N * speed) / N
    given = train.motor.J * N * acceleration + passed / N + lost
    return Demand(t, angle, N * speed, holding, given)


def refuse_heavy(train: DriveTrain, path: Path) -> None:
    """Refuse a load that is beyond what the law of the gear carries (ValueError)."""
    asked = demand_of(train, path)
    at = int(np.argmax(np.abs(asked.holding)))
    pull = float(asked.holding[at])
    if lacking(train.law, "stiffness"):
        return
    try:
        loaded_state(train.law, pull)
    except (ValueError, SolveError) as error:
        raise ValueError(
            f"the load pulls with {abs(pull):.4g} N*m at {np.degrees(asked.angle[at]):.4g} deg, which the gear does "
            f"not hold: {error}; take a lighter payload, a shorter arm or a larger gear"
        ) from error


def move_findings(
    train: DriveTrain, path: Path, limits: MotorLimits, torque: float, speed: float
) -> tuple[Finding, ...]:
    """What a move asks of the motor, its vibration included, against the limits; what helps goes by the profile."""
    asked = demand_of(train, path)
    fastest, largest = float(np.max(np.abs(asked.speed))), float(np.max(np.abs(asked.motor)))
    smoother = "take a longer time, a smoother profile or a stronger motor"
    of_torque = _stretched(train, path, limits.torque) if largest > limits.torque else smoother
    of_speed = smoother
    if fastest > limits.speed:
        need = _up(path.duration * fastest / limits.speed)
        of_speed = f"stretch it from {path.duration:.4g} s to {need} s or more, or take a smaller ratio"
    without = "the move is computed as if the motor had that; "
    holding = float(np.max(np.abs(demand_of(train, path, math.inf).motor)))
    return motor_findings(limits, torque, speed, holding, (without + of_torque, without + of_speed))


def _stretched(train: DriveTrain, path: Path, most: float) -> str:
    """By how much to stretch a profile whose torque is too large, by bisection; friction stays that of its speed."""

    def too_large(stretch: float) -> bool:
        return float(np.max(np.abs(demand_of(train, path, stretch).motor))) > most

    if too_large(math.inf):
        return "without any acceleration it still asks too much: take a stronger motor or a larger ratio"
    low, high = 1.0, 2.0
    while too_large(high):
        low, high = high, 2.0 * high
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if too_large(middle) else (low, middle)
    return f"stretch it from {path.duration:.4g} s to {_up(high * path.duration)} s or more, or take a stronger motor"


def _up(value: float) -> str:
    """Four digits, rounded up."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 3)
    return f"{math.ceil(value / unit * (1.0 - 1e-12)) * unit:.4g}"


def _drag(law: Any, angle: Floats, speed: Floats) -> Floats:
    torque = torque_of(law, angle, speed, (0.0 * angle,) * states_of(law))
    return np.asarray(torque + 0.0 * angle)
