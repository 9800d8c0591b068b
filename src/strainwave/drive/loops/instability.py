"""A motor's loop that its gear makes unstable, and the bandwidth or gain up to which it would be stable."""

from collections.abc import Callable
from math import sqrt

import numpy as np

from ...base.protocols import Control
from ...model.train import controls
from ...model.train.controls import HERTZ
from ...model.train.drive_train import DriveTrain
from ...model.train.filters import Filtered
from ..operating_point import mean_state
from .bode import bode

ROUNDING = 1e-9  # of the largest pole: less growth than this is none
LEAST_SHARE, MARGIN_TOLERANCE = 1e-3, 1e-3  # of the bandwidth: the smallest that is tried; and of the margin


def fastest_growth(train: DriveTrain) -> complex:
    """Pole [1/s] of the train about the state of its mean torques that grows fastest; 0 where none grows.

    States of a law with memory have poles at 0, which rounding puts on either side.
    """
    poles = bode(train, [1.0], source="load", at=mean_state(train), speed=train.omega).poles
    fastest = complex(poles[int(np.argmax(poles.real))])
    return fastest if fastest.real > ROUNDING * float(np.max(np.abs(poles))) else 0j


def instability(train: DriveTrain, inertia: float) -> str:
    """Say that a loop makes a train unstable, and the bandwidth up to which it would not; empty where it does not.

    A position or speed loop without a lag acts where it measures, puts in no energy and is always stable. What drives a
    train with such a loop too, such as friction that falls with the speed, is not the loop's fault.

    Parameters
    ----------
    train : DriveTrain
        At its speed.
    inertia : float
        Inertia [kg*m^2, motor side] that the loop turns, as in `from_bandwidth`.
    """
    control = train.motor.control
    core = controls.core_of(control)
    passive = controls.PositionLoop(core.K_p * core.K_v, core.K_p) if isinstance(core, controls.CascadeLoop) else core
    if passive is control or not _grows(train, control) or _grows(train, passive):
        return ""
    pole = fastest_growth(train)
    sentence = f"is unstable with this gear: a vibration of {abs(pole) / HERTZ:.3g} Hz grows by {pole.real:.3g} 1/s"
    tuning, lagged = controls.tuning_of(control, inertia), " and lag" if isinstance(control, controls.Lagged) else ""
    limit = None if tuning is None else _largest_stable(train, tuning, inertia)
    if tuning is None or limit is None:
        if isinstance(core, controls.CascadeLoop):
            return f"{sentence}; {_stable_cascade(train, control)}"
        if isinstance(control, Filtered) or isinstance(control.loop, Filtered):
            return f"{sentence}; without its filters{lagged} the loop is stable: move the filters to higher frequencies"
        lag = f"a lag below {1e3 * control.lag:.3g} ms"
        return f"{sentence}; increase the damping of the loop (K_d for position, K_p for speed), or give {lag}"
    return (
        f"{sentence}; with this damping{lagged} the loop is stable up to a bandwidth of {limit / HERTZ:.3g} Hz, but "
        f"has {tuning.bandwidth / HERTZ:.3g} Hz"
    )


def _grows(train: DriveTrain, control: Control) -> bool:
    return fastest_growth(train.with_motor(control=control)) != 0.0


def _stable_cascade(train: DriveTrain, control: Control) -> str:
    """Gain of a cascade that makes its train stable when it is smaller, and the value down to which."""
    core = controls.core_of(control)
    for name, unit in (("K_v", "1/s"), ("K_p", "N*m*s/rad")):
        value = getattr(core, name)

        def grows(gain: float, name: str = name) -> bool:
            return _grows(train, controls.with_core(control, core._replace(**{name: gain})))

        limit = _last_stable(grows, value)
        if limit is not None:
            return f"the loop is stable with {name} up to {limit:.3g} {unit}, but has {value:.3g}"
    return "give the loop a longer T_n or T_p, or another lag or filter"


def _largest_stable(train: DriveTrain, tuning: controls.Tuning, inertia: float) -> float | None:
    """Largest bandwidth [rad/s] below that of a tuning at which the loop is stable; None where there is none."""

    def grows(bandwidth: float) -> bool:
        loop = controls.from_bandwidth(bandwidth, inertia, tuning.damping, kind=tuning.kind, lag=tuning.lag)
        return _grows(train, loop)

    return _last_stable(grows, min(tuning.bandwidth, controls.FASTEST / tuning.lag if tuning.lag else tuning.bandwidth))


def _last_stable(grows: Callable[[float], bool], largest: float) -> float | None:
    """Largest value below one that grows at which nothing grows; None where there is none."""
    high, low = largest, 0.8 * largest
    while grows(low):
        high, low = low, 0.8 * low
        if low < LEAST_SHARE * largest:
            return None
    while high / low > 1.0 + MARGIN_TOLERANCE:
        middle = sqrt(low * high)
        low, high = (low, middle) if grows(middle) else (middle, high)
    return low
