"""Whether the loop of a motor is stable with its gear, and how far it is from that: poles of the linearised train."""

import re
from math import sqrt
from typing import Any

import numpy as np

from ...model.train.controls import Lagged
from ...model.train.drive_train import DriveTrain
from ...model.train.loops import FASTEST, HERTZ, Tuning, from_bandwidth, tuning_of
from ...results import SolveError
from .bode import bode
from .operating_point import operating_state

ROUNDING = 1e-9  # of the largest pole: less growth than this is none
LEAST, CLOSE = 1e-3, 1e-3  # smallest share of the bandwidth that is tried, and how near the margin is found


def motor_name(control: Any, inertia: float) -> str:
    """What drives a motor, in words: "held", "free", or its loop by bandwidth and damping on an inertia [kg*m^2]."""
    if (tuning := tuning_of(control, inertia)) is not None:
        return str(tuning)
    if isinstance(control, Lagged):
        return f"{motor_name(control.loop, inertia)}, lag {1e3 * control.lag:.4g} ms"
    return re.sub(r"(?<=[a-z])(?=[A-Z])", " ", type(control).__name__).lower()


def fastest_growth(train: DriveTrain) -> complex:
    """Pole [1/s] of the train about the state of its mean torques that grows fastest; 0 where none grows.

    States of a law with memory have poles at 0, which rounding puts on either side.
    """
    try:
        state = operating_state(train, train.omega)
    except (SolveError, TypeError):  # a law cannot carry the torque, or a torque has no mean
        state = np.zeros(len(train.state_names()))
    poles = bode(train, [1.0], source="load", at=state, speed=train.omega).poles
    fastest = complex(poles[int(np.argmax(poles.real))])
    return fastest if fastest.real > ROUNDING * float(np.max(np.abs(poles))) else 0j


def unstable(train: DriveTrain, inertia: float) -> str:
    """Say that a loop makes a train unstable, and the bandwidth up to which it would not; empty where it does not.

    A loop without a lag acts where it measures, puts in no energy and is always stable. What drives a train without
    its lag too, such as friction that falls with the speed, is not the loop's fault.

    Parameters
    ----------
    train : DriveTrain
        At its speed.
    inertia : float
        Inertia [kg*m^2, motor side] that the loop turns, as in `from_bandwidth`.
    """
    control = train.motor.control
    if not isinstance(control, Lagged) or not _grows(train, control) or _grows(train, control.loop):
        return ""
    pole = fastest_growth(train)
    said = f"is unstable with this gear: a vibration of {abs(pole) / HERTZ:.3g} Hz grows by {pole.real:.3g} 1/s"
    tuning = tuning_of(control, inertia)
    limit = None if tuning is None else _largest_stable(train, tuning, inertia)
    if tuning is None or limit is None:
        lag = f"a lag below {1e3 * control.lag:.3g} ms"
        return f"{said}; give the loop more damping (K_d by position, K_p by speed) or {lag}"
    return (
        f"{said}; with this damping and lag it is stable up to a bandwidth of {limit / HERTZ:.3g} Hz and has "
        f"{tuning.bandwidth / HERTZ:.3g} Hz"
    )


def _with(train: DriveTrain, control: Any) -> DriveTrain:
    return train._replace(motor=train.motor._replace(control=control))


def _grows(train: DriveTrain, control: Any) -> bool:
    return fastest_growth(_with(train, control)) != 0.0


def _largest_stable(train: DriveTrain, tuning: Tuning, inertia: float) -> float | None:
    """Largest bandwidth [rad/s] below that of a tuning at which the loop is stable; None where there is none."""

    def grows(bandwidth: float) -> bool:
        loop = from_bandwidth(bandwidth, inertia, tuning.damping, kind=tuning.kind, lag=tuning.lag)
        return _grows(train, loop)

    high = min(tuning.bandwidth, FASTEST / tuning.lag)
    low = 0.8 * high
    while grows(low):
        high, low = low, 0.8 * low
        if low < LEAST * tuning.bandwidth:
            return None
    while high / low > 1.0 + CLOSE:
        middle = sqrt(low * high)
        low, high = (low, middle) if grows(middle) else (middle, high)
    return low
