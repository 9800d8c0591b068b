"""Where the mean torques hold a drive train that turns at constant speed."""

from typing import Any

import numpy as np

from ...law import states_of, torque_of
from ...model.excitation import Harmonic, NoError
from ...model.train.controls import Held
from ...model.train.drive_train import DriveTrain
from ...model.train.motion import Steady
from ...numerics.balance.first_order import jacobians_at, rates_at
from ...numerics.loading import loaded_state
from ...quantities import with_parts
from ...results import Floats, SolveError

STEP = 0.1  # units of the states for differences: twists of 0.6 microrad
HELD = Held()
ROUNDS, CLOSE = 50, 1e-9  # of Newton's method, and rates of the solution relative to those of the train without twist


def operating_state(
    train: DriveTrain, speed: float, *, near: tuple[float, ...] = (), angle: float = 0.0
) -> Floats:  # fmt: skip
    """Find the state (states,) in which the mean torques hold a train at a constant motor speed.

    Every law is taken where a slow load from rest brings it, so that one that softens is below its largest torque.

    Friction of the shafts counts with that speed, gravity with that angle; the lines of the torques do not, nor does
    the kinematic error, except at standstill. A free motor gets the torque that keeps the speed.

    Parameters
    ----------
    train : DriveTrain
        The train.
    speed : float
        Speed of the motor's reference [rad/s].
    near : tuple of float, optional
        Torsion [rad] of the gear and the internal states of its law near it, which choose among the equilibria of a
        law with memory. Default: where a slow load from rest leads.
    angle : float
        Angle of the motor's reference [rad].

    Raises
    ------
    SolveError
        If the train has no such state: a law cannot carry its torque, and the sentence says how much it carries.
    TypeError
        If a torque has no mean, such as a profile.
    """
    train = with_mean_torques(with_parts("operating_state", train, "power_names"))
    error = NoError() if speed else train.error
    held = train._replace(error=error, reference=Steady(), omega=float(speed))
    if train.motor.free:
        state = operating_state(held._replace(motor=held.motor._replace(control=HELD)), speed, near=near, angle=angle)
        return np.concatenate([state[:2], np.zeros(2), state[2:]])
    names = held.state_names()
    state = np.zeros(len(names))
    largest = max(float(np.max(np.abs(_rates(held, angle, state)))), 1e-300)
    short = _loaded(held, names, state, near, angle)
    rates = _rates(held, angle, state)
    for _ in range(ROUNDS):
        matrix = jacobians_at(held, np.full(1, angle), state[:, None], np.full(len(state), STEP))[:, :, 0]
        state -= np.linalg.lstsq(matrix, rates, rcond=1e-13)[0]
        rates = _rates(held, angle, state)
        if not np.all(np.isfinite(rates)):
            break
        if float(np.max(np.abs(rates))) <= CLOSE * largest:
            return state
    said = short or "Newton's method finds none"
    raise SolveError(f"the mean torques hold the train in no state at {speed:.6g} rad/s: {said}")


def _loaded(train: DriveTrain, names: tuple[str, ...], state: Floats, near: tuple[float, ...], angle: float) -> str:
    """Set the twists to those that carry the load's torque at a motor angle [rad]; a sentence where a law cannot."""
    laws, end = (train.law, *train.load.couplings()), train.load.end()
    turning = train.omega * train.reference.slope(0.0) / train.N
    drag = torque_of(end.drag, angle / train.N, turning, (0.0,) * states_of(end.drag))
    torque = float(drag - end.excitation.torque(0.0))
    for i, law in enumerate(laws):
        if not hasattr(law, "stiffness"):
            continue
        name = f"coupling {i}" if i else "gear"
        places = [j for j, other in enumerate(names) if other == name or other.startswith(f"{name} z")]
        if i == 0:
            places = [0, *places]
        try:
            state[places] = near if near and i == 0 else loaded_state(law, torque)
        except (ValueError, SolveError) as error:
            return str(error)
    return ""


def _rates(train: DriveTrain, angle: float, state: Floats) -> Floats:
    return rates_at(train, np.full(1, angle), state[:, None])[:, 0]


def with_mean_torques(train: DriveTrain) -> DriveTrain:
    """Return the train with the mean torques alone."""
    motor, end = (shaft._replace(excitation=_mean(shaft.excitation)) for shaft in (train.motor, train.load.end()))
    return train._replace(motor=motor, load=train.load.with_end(end))


def _mean(torque: Any) -> Harmonic:
    if not hasattr(torque, "mean") and not hasattr(torque, "terms"):
        raise TypeError(
            f"a {type(torque).__name__} has no mean torque; put Harmonic(0.0, mean=...) in its place, with the torque "
            "at the time in question"
        )
    return Harmonic(0.0, mean=sum(h.mean for h in getattr(torque, "terms", (torque,))))
