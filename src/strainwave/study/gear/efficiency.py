"""Efficiency of a gear at constant speed, from its load-proportional friction and the drag on its motor."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...base.law import states_of, torque_of
from ...base.protocols import with_parts
from ...base.quantities import numbers, shown
from ...base.results import Floats
from ...base.units import RPM


@dataclass(frozen=True)
class Efficiency:
    """Output over input power of a gear at constant speed.

    Attributes
    ----------
    torque : (loads,) array
        Torque [N*m, output side] that the gear transmits.
    speed : (speeds,) array
        Speed of the motor [rad/s].
    driving : (speeds, loads) array
        The motor drives the load: T v/N over the motor's power.
    back_driving : (speeds, loads) array
        The load drives the motor: power that arrives there over T v/N. Negative where the load alone does not turn it.
    back_driving_torque : (speeds,) array
        Torque [N*m, output side] with which the load alone keeps the motor turning.
    """

    torque: Floats
    speed: Floats
    driving: Floats
    back_driving: Floats
    back_driving_torque: Floats

    def __str__(self) -> str:
        low, high = float(np.min(self.driving)), float(np.max(self.driving))
        rpm = self.speed / RPM
        return (
            f"Efficiency at {self.torque.min():.4g} to {self.torque.max():.4g} N*m and {rpm.min():.4g} to "
            f"{rpm.max():.4g} rpm of the motor: {100 * low:.1f} to {100 * high:.1f} %; the load turns the motor from "
            f"{self.back_driving_torque.min():.3g} N*m on"
        )

    __repr__ = __str__


def efficiency(train: Any, torque: ArrayLike, speed: ArrayLike) -> Efficiency:
    """Find the efficiency of a train's gear over load and speed.

    At the constant motor speed v a motor that drives the load torque T gives (T + T_f)/N + T_d, and one that the load
    drives receives (T - T_f)/N - T_d: T_f is the friction of the meshing at T and v, T_d the motor's drag at v.

    Parameters
    ----------
    train : DriveTrain
        The train: its ratio, its `friction` and the drag of its motor count.
    torque : float or (loads,) array_like
        Torques T [N*m, output side] that the gear transmits; positive.
    speed : float or (speeds,) array_like
        Speeds of the motor [rad/s]; positive.

    Returns
    -------
    Efficiency
        `driving` and `back_driving` efficiency (speeds, loads; numbers up to 1), and the `back_driving_torque`
        [N*m, output side].

    Raises
    ------
    ValueError
        If a torque or a speed is not positive.
    TypeError
        If `train` is not a drive train, or its motor's drag has memory.
    """
    train = with_parts("efficiency", train, "power_names")
    drag = train.motor.drag
    if states_of(drag):
        raise TypeError(
            f"efficiency takes a drag that is a function of the speed, and the motor has {shown(drag)}; give Coulomb, "
            "Stribeck or Viscous"
        )
    T, v = _positive("torque [N*m]", torque), _positive("speed [rad/s]", speed)
    N, column = train.N, v[:, None]
    of_drag = np.array([float(torque_of(drag, 0.0, float(one), ())) for one in v])
    mesh = train.friction.torque(T, column) + 0.0 * column
    given, left = (T + mesh) / N + of_drag[:, None], (T - mesh) / N - of_drag[:, None]
    share = train.friction.torque(1.0, v) + 0.0 * v
    return Efficiency(T, v, T / N / given, left / (T / N), N * of_drag / (1.0 - share))


def _positive(name: str, values: ArrayLike) -> Floats:
    found = numbers(name, values)
    if not np.all(found > 0.0):
        raise ValueError(f"{name} is {shown(values)}; give one or more positive numbers")
    return found
