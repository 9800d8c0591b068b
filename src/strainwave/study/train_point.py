"""Where the mean torques hold a drive train that turns at constant speed."""

from typing import Any

import numpy as np

from ..model.drive_train import DriveTrain
from ..model.excitation import Harmonic, NoError
from ..model.motion import Steady
from ..model.shafts import Elastic, Free, Held
from ..numerics.first_order import jacobians_at, rates_at
from ..quantities import with_parts
from ..results import Floats, SolveError

STEP = 0.1  # units of the states for differences: twists of 0.6 microrad
HELD = Held()
ROUNDS, CLOSE = 50, 1e-9  # of Newton's method, and rates of the solution relative to those of the train without twist


def operating_state(train: DriveTrain, speed: float, *, near: tuple[float, ...] = ()) -> Floats:
    """Find the state (states,) in which the mean torques hold a train at a constant motor speed.

    Friction of the shafts counts with that speed, gravity as at the angle 0; kinematic error and the lines of the
    torques do not. A free motor gets the torque that keeps the speed.

    Parameters
    ----------
    train : DriveTrain
        The train.
    speed : float
        Speed of the motor's reference [rad/s].
    near : tuple of float, optional
        Torsion [rad] of the gear and the internal states of its law near it, which choose among the equilibria of a
        law with memory.

    Raises
    ------
    SolveError
        If the train has no such state: a law cannot carry its torque.
    """
    train = with_mean_torques(with_parts("operating_state", train, "power_names"))
    held = train._replace(error=NoError(), reference=Steady(), omega=float(speed))
    if isinstance(train.motor.control, Free):
        state = operating_state(held._replace(motor=held.motor._replace(control=HELD)), speed, near=near)
        return np.concatenate([state[:2], np.zeros(2), state[2:]])
    names = held.state_names()
    state = np.zeros(len(names))
    largest = max(float(np.max(np.abs(_rates(held, state)))), 1e-300)
    if near:
        state[[0, *(i for i, name in enumerate(names) if name.startswith("gear z"))]] = near
    rates = _rates(held, state)
    for _ in range(ROUNDS):
        matrix = jacobians_at(held, np.zeros(1), state[:, None], np.full(len(state), STEP))[:, :, 0]
        state -= np.linalg.lstsq(matrix, rates, rcond=1e-13)[0]
        rates = _rates(held, state)
        if not np.all(np.isfinite(rates)):
            break
        if float(np.max(np.abs(rates))) <= CLOSE * largest:
            return state
    raise SolveError(f"the mean torques hold the train in no state at {speed:.6g} rad/s that Newton's method finds")


def _rates(train: DriveTrain, state: Floats) -> Floats:
    return rates_at(train, np.zeros(1), state[:, None])[:, 0]


def with_mean_torques(train: DriveTrain) -> DriveTrain:
    """Return the train with the mean torques alone."""
    motor = train.motor._replace(excitation=_mean(train.motor.excitation))
    return train._replace(motor=motor, load=_with_mean(train.load))


def _with_mean(load: Any) -> Any:
    if isinstance(load, Elastic):
        return load._replace(load=_with_mean(load.load))
    return load._replace(excitation=_mean(load.excitation))


def _mean(torque: Any) -> Harmonic:
    return Harmonic(0.0, mean=sum(h.mean for h in getattr(torque, "terms", (torque,))))
