"""The motor of a move as its drive has it: its torque limited, with anti-windup."""

from typing import Annotated, Any, NamedTuple

import numpy as np

from ...base.choices import larger, select, smaller
from ...base.law import class_of, share, torque_of, z_rate_of
from ...base.quantities import Torque
from ...compile.jit import chosen
from ...drive.asked import MotorLimits
from ...model.train.controls import CascadeLoop, Lagged, core_of, inertia_of, states_inside
from ...model.train.drive_train import DriveTrain
from ...model.train.filters import Filtered, PositionIntegral


class Limited(NamedTuple):
    """A loop whose motor gives a torque of at most `most`, the torque beside the loop's included.

    The integral of a cascade gives back what the limit took, with its own time constant T_n (back-calculation; Astrom &
    Hagglund, PID Controllers, 2nd ed. 1995, sec. 3.5); that of its position loop waits. `back` is 1/K_p, 0 of another
    loop.
    """

    loop: Any
    most: Torque
    back: Annotated[float, "rad/(N*m*s)"]

    def states(self) -> int:
        """Number of internal states."""
        return states_inside(self)

    def torque(self, x: Any, v: Any, z: Any) -> Any:
        """Torque [N*m] against the deviation that the loop asks for."""
        return torque_of(self.loop, x, v, z)

    def z_rate(self, x: Any, v: Any, z: Any) -> Any:
        """Rates of the internal states without the limit."""
        return z_rate_of(self.loop, x, v, z)

    def driven(self, J: Any, torque: Any, excitation: Any, reference: Any, deviation: Any, z: Any) -> Any:
        """What `controlled` returns."""
        x, v = deviation
        states, heavy = share(self.loop, z), inertia_of(self.loop)
        asked = excitation - torque_of(self.loop, x, v, states)
        asked = asked - heavy * ((torque + asked + heavy * reference) / (J + heavy) - reference)
        applied = larger(smaller(asked, self.most), -self.most)
        acceleration = (torque + applied) / J
        rates = unwound(self.loop, z_rate_of(self.loop, x, v, states), (applied - asked) * self.back)
        return acceleration, applied - excitation, (v, acceleration - reference, *rates)


@chosen
def unwound(loop: Any, rates: Any, cut: Any) -> Any:
    """Rates of the states of a loop, from those without a limit and what it took [rad/s]."""
    classes = _classes(loop)
    if CascadeLoop not in classes:
        return _plain
    return _both if PositionIntegral in classes else _speed


def _classes(loop: Any) -> tuple[Any, ...]:
    """Classes of a loop and of the loops inside it, or of what stands for them in the compiler."""
    if class_of(loop) not in (Lagged, Filtered, PositionIntegral):
        return (class_of(loop),)
    return (class_of(loop), *_classes((loop.types if hasattr(loop, "instance_class") else loop)[0]))


def _plain(loop: Any, rates: Any, cut: Any) -> Any:
    return rates


def _speed(loop: Any, rates: Any, cut: Any) -> Any:
    return (*rates[:-1], rates[-1] - cut)


def _both(loop: Any, rates: Any, cut: Any) -> Any:
    return (*rates[:-2], select(cut == 0.0, rates[-2], 0.0), rates[-1] - cut)


def limited(train: DriveTrain, limits: MotorLimits, holding: float) -> DriveTrain:
    """The train with its motor's torque limited, which must be above what holds its load [N*m] (ValueError)."""
    most, motor = limits.torque, train.motor
    if not np.isfinite(most):
        raise ValueError("limited needs the largest torque of the motor; give limits=MotorLimits(torque) or max_torque")
    if motor.held:
        raise ValueError("limited needs a loop; an ideally held motor takes any torque: give motor: {loop: ...}")
    if holding >= most:
        raise ValueError(
            f"loads and friction alone take {holding:.4g} N*m of the motor, whose limit is {most:.4g} N*m: it does not "
            "hold its load; take a stronger motor, a larger ratio or less load"
        )
    core = core_of(motor.control)
    back = 1.0 / core.K_p if isinstance(core, CascadeLoop) else 0.0
    return train._replace(motor=motor._replace(control=Limited(motor.control, most, back)))


def limited_time(torque: Any, t: Any, most: float) -> float:
    """Time [s] of samples (n,) of the motor's torque [N*m] at the limit."""
    at_limit = np.abs(torque) >= most * (1.0 - 1e-9)
    return float(np.sum(np.diff(t)[at_limit[1:] & at_limit[:-1]]))
