"""The linear drive train as a system of python-control."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...model.train.drive_train import DriveTrain
from .state_space import state_space


def to_control(train: DriveTrain, *, at: ArrayLike | None = None, speed: float = 0.0) -> Any:
    """Linearise a drive train for python-control (extra `control`).

    Parameters
    ----------
    train, at, speed
        As `state_space`, whose matrices these are: about standstill and zero states by default.

    Returns
    -------
    control.StateSpace
        Inputs `motor_torque`, unless the motor is held, and `load_torque` [N*m]; outputs `motor_angle` and `load_angle`
        [rad], deviations from the reference; states by the names of the train, with `_` and `_rate`.

    Raises
    ------
    ModuleNotFoundError
        If python-control is not installed.
    ValueError
        As `state_space`.
    """
    try:
        import control
    except ImportError:
        raise ModuleNotFoundError("this needs python-control; pip install 'strainwave[control]'") from None
    linear = state_space(train, at=at, speed=speed)
    outputs = np.zeros((2, len(linear.states)))
    if not train.motor.held:
        outputs[:, linear.states.index("motor deviation")] = 1.0, 1.0 / train.N
    outputs[1, [0, *train.twists()]] = -1.0
    return control.ss(
        linear.A, linear.B, outputs, np.zeros((2, len(linear.inputs))), remove_useless_states=False,
        inputs=list(map(_named, linear.inputs)), outputs=["motor_angle", "load_angle"],
        states=list(map(_named, linear.states)),
    )  # fmt: skip


def _named(name: str) -> str:
    """Name without what python-control gives a meaning to."""
    return name.replace(" ", "_").replace("'", "_rate")
