"""Names of the motor's drive in sentences, and the train that a project has for a task."""

import re
from typing import Any

from ..base.quantities import checked
from ..model.train import controls
from ..model.train.controls import HERTZ
from ..model.train.drive_train import DriveTrain
from ..model.train.filters import Filtered, LoadEncoder, MixedEncoders, PositionIntegral


def motor_name(control: Any, inertia: float) -> str:
    """Name of a motor's drive: "held", "free", or its loop by bandwidth and damping on an inertia [kg*m^2]."""
    if (tuning := controls.tuning_of(control, inertia)) is not None:
        return str(tuning)
    if isinstance(control, controls.Lagged):
        return f"{motor_name(control.loop, inertia)}, lag {1e3 * control.lag:.4g} ms"
    if isinstance(control, PositionIntegral):
        return f"{motor_name(control.loop, inertia)}, T_p {1e3 * control.T_p:.4g} ms"
    if isinstance(control, LoadEncoder | MixedEncoders):
        mixed = f"both encoders, mixed at {control.frequency / HERTZ:.4g} Hz" if len(control) > 1 else ""
        return f"{motor_name(control.loop, inertia)}, position from {mixed or 'the load encoder'}"
    if isinstance(control, Filtered):
        kind = re.sub(r"(?<=[a-z])(?=[A-Z])", "-", type(control.filter).__name__.removesuffix("Filter")).lower()
        hertz = control.filter.frequency / HERTZ
        return f"{motor_name(control.loop, inertia)}, {kind} filter of {hertz:.4g} Hz"
    if isinstance(control, controls.CascadeLoop):
        gains = f"K_v {control.K_v:.4g} 1/s, K_p {control.K_p:.4g} N*m*s/rad"
        return f"cascade of {gains}, T_n {1e3 * control.T_n:.4g} ms"
    return re.sub(r"(?<=[a-z])(?=[A-Z])", " ", type(control).__name__).lower()


def train_of(project: Any, task: str) -> tuple[str, DriveTrain]:
    """The whole train of a project, or a train itself, for a purpose in words; and what drives its motor, in words.

    Where the file names no motor it is in the position loop of `motors`. A project without a train is a ValueError.
    """
    if isinstance(project, DriveTrain):
        return "", checked(project)
    trains: list[tuple[str, DriveTrain]] = list(project.motors().items())
    if not trains:
        raise ValueError(
            "this project has no whole drive train, as its damping or stiffness varies or its speeds are forcing "
            f"frequencies; {task} requires one: remove the variation, and give speeds of the motor or the load"
        )
    return trains[-1]
