"""The plant that is exported: motor, gear and load of a drive train under the torques on its two shafts."""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ...base.law import breakpoints_of
from ...base.protocols import Law, with_parts
from ...base.quantities import checked, number, numbers, shown
from ...drive.state_space import state_space
from ...model.laws.dry import SMOOTHED, law_width, smoothed
from ...model.train.controls import FREE
from ...model.train.drive_train import DriveTrain, motor_motion
from ...model.train.motion import AtRest
from ...numerics.integration.methods import Dop8, FixedStep

INPUTS = (
    ("motor_torque", "N*m", "torque on the motor, held over the step"),
    ("load_torque", "N*m", "torque on the load along its motion; one that resists is negative"),
)
OUTPUTS = (
    ("motor_angle", "rad", "angle of the motor"),
    ("motor_speed", "rad/s", "speed of the motor"),
    ("load_angle", "rad", "angle of the load"),
    ("load_speed", "rad/s", "speed of the load"),
    ("pointing_error", "rad", "motor_angle/N - load_angle"),
    ("gear_torque", "N*m", "torque that the gear transmits, output side"),
)
LARGEST_STEP = 1.0  # in units of the fastest pole: beyond it explicit methods are inaccurate, and soon unstable
BEHIND_CORNER = 1.01  # times a breakpoint: the slope behind it


class Input(NamedTuple):
    """A torque that comes from outside."""

    value: Any

    def torque(self, angle: Any) -> Any:
        """Torque [N*m] at any base angle."""
        return self.value


@dataclass(frozen=True)
class Plant:
    """A drive train without its control loop, in fixed steps.

    Attributes
    ----------
    train : DriveTrain
        The train with a free motor at rest, without torques of its own.
    step : float
        Length of a step [s].
    method : Rk4 or Dop8
        Scheme of the steps.
    start : tuple of float
        State to begin with.
    fastest : float
        Fastest pole [1/s] at rest and where the laws are stiffest: what is small beside it is no speed.
    """

    train: DriveTrain
    step: float
    method: FixedStep
    start: tuple[float, ...]
    fastest: float

    def under(self, motor_torque: Any, load_torque: Any) -> DriveTrain:
        """Return the train under torques [N*m] on its shafts."""
        end = self.train.load.end()._replace(excitation=Input(load_torque))
        motor = self.train.motor._replace(excitation=Input(motor_torque))
        return self.train._replace(motor=motor, load=self.train.load.with_end(end))

    def outputs(self, y: Any) -> tuple[Any, ...]:
        """Values of `OUTPUTS` in a state."""
        train = self.train
        angle, speed = motor_motion(train, 0.0, y)
        error = train.load_error(y)
        return angle, speed, angle / train.N - error, train.load_speed(0.0, y), error, train.torque(0.0, y)

    def states(self) -> tuple[tuple[str, str], ...]:
        """Name and unit of every state."""
        names = tuple(name.replace("motor deviation", "motor angle") for name in self.train.state_names())
        return tuple((name, _unit(name)) for name in names)


def plant_of(train: Any, step: Any = None, method: Any = None, start: Any = None) -> Plant:
    """Plant of a drive train: its control, its reference and the torques of its own are left out.

    Parameters
    ----------
    train : DriveTrain
        Motor, gear and load.
    step : float, optional
        Length of a step [s]. Default: as many steps of the method per shortest time scale as it has.
    method : Rk4 or Dop8, optional
        Default: `Dop8()`.
    start : (states,) array_like, optional
        State to begin with, as of the train with a free motor. Default: zeros.

    Raises
    ------
    TypeError
        If the method has no fixed steps.
    ValueError
        If the step is too long for the fastest motion of the train, or `start` has another number of states.
    """
    train = checked(with_parts("export", train, "power_names"))
    method = Dop8() if method is None else method
    if not isinstance(method, FixedStep):
        raise TypeError(f"method is {shown(method)}; C code takes fixed steps: give Rk4() or Dop8()")
    train = smoothed(train._replace(motor=train.motor._replace(control=FREE), reference=AtRest(), omega=1.0))
    states = len(train.state_names())
    begun = (0.0,) * states if start is None else tuple(numbers("start", start, count=states).tolist())
    fastest = _fastest(train)
    unloaded = Plant(train, 0.0, method, begun, fastest).under(0.0, 0.0)
    longest = LARGEST_STEP / fastest if fastest else math.inf
    if step is None:
        step = 2.0 * math.pi * longest / method.steps if fastest else 1e-3
    step = number("step [s]", step, positive=True)
    if step > longest:
        raise ValueError(
            f"the step is {step:g} s but the fastest motion of the train allows {longest:.3g} s at most; use a "
            "shorter step"
        )
    return Plant(unloaded, step, method, begun, fastest)


def _fastest(train: DriveTrain) -> float:
    """Size [1/s] of the fastest pole of the train, at rest and where its laws are stiffest."""
    standstill = np.zeros(len(train.state_names()))
    stiff = standstill.copy()
    for index, law in ((0, train.law), *zip(train.twists(), train.load.couplings(), strict=True)):
        stiff[index] = _stiffest(law)
    return max(float(np.max(np.abs(state_space(train, at=state).poles))) for state in (standstill, stiff))


def _stiffest(law: Law) -> float:
    """Twist [rad] behind a breakpoint of a law where it is stiffest; 0 where that is none."""
    twists: list[float] = [0.0, *(BEHIND_CORNER * twist for twist in breakpoints_of(law))]
    return max(twists, key=lambda twist: float(law.stiffness(twist)) if len(twists) > 1 else 0.0)


def _unit(name: str) -> str:
    if " z" in name:
        return ""
    return "rad/s" if name.endswith("'") else "rad"


def creep_of(train: DriveTrain) -> list[str]:
    """A sentence on the dry friction of the shafts in code of equal steps, if there is any."""
    if not any(law_width(drag) for drag in (train.motor.drag, train.load.end().drag)):
        return []
    width = f"{SMOOTHED:g} rad/s of the motor and {SMOOTHED / train.N:.3g} rad/s of the load"
    return [f"dry friction is smoothed below {width}, where the shafts creep and do not stick"]
