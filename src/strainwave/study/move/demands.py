"""What a profile asks of a rigid drive, and the profiles that no drive of this motor and gear can follow."""

import math
from typing import Any, NamedTuple

import numpy as np

from ...law import states_of, torque_of
from ...model.gears.gear import Gear
from ...model.train.drive_train import DriveTrain
from ...numerics.loading import loaded_state
from ...protocols import lacking
from ...quantities import AngularSpeed, Torque, number
from ...results import Floats, SolveError
from ...units import RPM
from .path import Path

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


def refuse_impossible(train: DriveTrain, path: Path, gear: Gear | None, limits: MotorLimits) -> None:
    """Refuse a load that the gear cannot hold and a profile that the motor cannot follow (ValueError)."""
    asked = demand_of(train, path)
    _refuse_heavy(train, asked, gear)
    fastest = float(np.max(np.abs(asked.speed)))
    if fastest > limits.speed:
        need = path.duration * fastest / limits.speed
        raise ValueError(
            f"the profile turns the motor at {fastest / RPM:.4g} rpm, above its {limits.speed / RPM:.4g} rpm; stretch "
            f"it from {path.duration:.4g} s to {_up(need)} s or more, or take a smaller ratio"
        )
    at = int(np.argmax(np.abs(asked.motor)))
    if abs(asked.motor[at]) > limits.torque:
        raise ValueError(
            f"the profile asks {abs(asked.motor[at]):.4g} N*m of the motor at {asked.t[at]:.4g} s, above its "
            f"{limits.torque:.4g} N*m; {_stretched(train, path, limits.torque)}"
        )


def _refuse_heavy(train: DriveTrain, asked: Demand, gear: Gear | None) -> None:
    """Refuse a load that is beyond the momentary torque of the gear, or beyond what its law carries (ValueError)."""
    at = int(np.argmax(np.abs(asked.holding)))
    pull = float(asked.holding[at])
    said = f"the load pulls with {abs(pull):.4g} N*m at {np.degrees(asked.angle[at]):.4g} deg"
    remedy = "take a lighter payload, a shorter arm or a larger gear"
    if gear is not None and gear.momentary_torque is not None and abs(pull) > gear.momentary_torque:
        most = f"{gear.name} holds at most {gear.momentary_torque:g} N*m (momentary torque)"
        raise ValueError(f"{said}, and {most}; {remedy}")
    if not lacking(train.law, "stiffness"):
        try:
            loaded_state(train.law, pull)
        except (ValueError, SolveError) as error:
            raise ValueError(f"{said}, which the gear does not hold: {error}; {remedy}") from error


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
