"""Operating point of a drive train that turns at constant speed, under its mean torques."""

from typing import Any

import numpy as np

from ..base.law import breakpoints_of, spring_stiffness, states_of, torque_of
from ..base.protocols import lacking, terms_of, with_parts
from ..base.quantities import SMALLEST, number, numbers
from ..base.results import Floats, SolveError
from ..base.sentences import Sentence, Speed
from ..model.excitation import Harmonic, NoError
from ..model.laws.dry import sliding
from ..model.laws.springs import Polynomial
from ..model.train.controls import Held
from ..model.train.drive_train import DriveTrain
from ..model.train.motion import Steady
from ..numerics.balance.rates import jacobians_at, rates_at
from ..numerics.operating_point import loaded_state

STEP = 0.1  # units of the states for differences: twists of 0.6 microrad
HELD, KINK_SHARE = Held(), 1e-9  # and a share of a torsion, beyond the kink at the end of a gap
ROUNDS, RATE_TOLERANCE = 50, 1e-9  # of Newton's method; rates of the solution by those of the train without twist
RATE_ROUNDING = 1e-14  # of the rates of a train with a twist: what rounding leaves of them


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

    Returns
    -------
    (states,) array
        The state, as `train.state_names()` lists it: angles [rad], rates [rad/s], and internal states of laws
        and controls.

    Raises
    ------
    ValueError
        If the speed, the angle or `near` is out of range.
    SolveError
        If the train has no such state: a law cannot carry its torque, and the sentence says how much it carries.
    TypeError
        If a torque has no mean, such as a profile.
    """
    train = with_mean_torques(with_parts("operating_state", train, "power_names"))
    speed, angle = number("speed", speed), number("angle", 0.0 if abs(angle) < SMALLEST else angle)  # as a run ends
    if not isinstance(near, tuple) or near:
        near = tuple(numbers("near", near, count=1 + states_of(train.law)).tolist())
    error = NoError() if speed else train.error
    held = sliding(train._replace(error=error, reference=Steady(), omega=speed), speed)
    if train.motor.free:
        state = operating_state(held.with_motor(control=HELD), speed, near=near, angle=angle)
        return np.concatenate([state[:2], np.zeros(2), state[2:]])
    names = held.state_names()
    state = np.zeros(len(names))
    tolerance = RATE_TOLERANCE * max(float(np.max(np.abs(_rates(held, angle, state)))), 1e-300)
    short, memory, turned = "", [_memory(names, i) for i in range(1 + len(held.load.couplings()))], 0
    kept = [j for places in memory for j in places]
    slack = not (near or lacking(held.law, "stiffness")) and not spring_stiffness(held.law, 0.0)
    if slack:  # where little torque is to be carried, that of a twist as wide as the gap has more rounding
        wide = np.append(2.0 * max(breakpoints_of(held.law), default=0.0), state[1:])
        tolerance = max(tolerance, RATE_ROUNDING * float(np.max(np.abs(_rates(held, angle, wide)))))
    largest = 1e-300  # a torque that vanishes as the load turns to its place is right to a share of what it was
    for _ in range(ROUNDS):
        # Its torque depends on where the load is: the state of a law with memory is that of its own slow load.
        torque = _torque_at_load(held, names, state, angle)
        largest = max(largest, abs(torque))
        short = short or _loaded(held, names, state, near, torque, angle)
        beside = _beside_gap(held, held.torsion(angle, tuple(state)), torque) if slack and not short else held
        if not _settle(beside, angle, state, kept, tolerance):
            break
        now = _torque_at_load(held, names, state, angle)
        if near or not (slack or any(memory)) or abs(now - torque) <= RATE_TOLERANCE * largest:
            return state
        turned += now * torque < 0.0
        if slack and turned > 1:  # each side of the gap leads to the other: the load rests between them
            state[0] -= held.torsion(angle, tuple(state))
            if _settle(held, angle, state, kept, tolerance):
                return state
            break
    reason = short or "Newton's method does not converge"
    raise SolveError(Sentence("no equilibrium under the mean torques was found at {}: {}", Speed(speed), reason))


def mean_state(train: DriveTrain) -> Floats | None:
    """State in which its mean torques hold a train; None where a law cannot carry them, or one has no mean."""
    try:
        return operating_state(train, train.omega)
    except (SolveError, TypeError):
        return None


def refuse_overload(train: DriveTrain) -> None:
    """SolveError where a law cannot carry the mean torques, with how much it carries."""
    train = with_mean_torques(train)
    names = train.state_names()
    state = np.zeros(len(names))
    if fault := _loaded(train, names, state, (), _torque_at_load(train, names, state, 0.0), 0.0):
        raise SolveError(fault)


def _settle(train: DriveTrain, angle: float, state: Floats, memory: list[int], tolerance: float) -> bool:
    """Newton's method on a state, the internal states of laws with memory as they are; whether the rates vanish."""
    rates = _rates(train, angle, state)
    for _ in range(ROUNDS):
        matrix = jacobians_at(train, np.full(1, angle), state[:, None], np.full(len(state), STEP))[:, :, 0]
        matrix[:, memory] = 0.0
        state -= np.linalg.lstsq(matrix, rates, rcond=1e-13)[0]
        rates = _rates(train, angle, state)
        if not np.all(np.isfinite(rates)):
            return False
        if float(np.max(np.abs(rates))) <= tolerance:
            return True
    return False


def _memory(names: tuple[str, ...], index: int) -> list[int]:
    """Places of the internal states of the law of the gear (0) or of a coupling among the states of a train."""
    name = f"coupling {index}" if index else "gear"
    return [j for j, other in enumerate(names) if other.startswith(f"{name} z")]


def _torque_at_load(train: DriveTrain, names: tuple[str, ...], state: Floats, angle: float) -> float:
    """Torque [N*m] that the load takes where it stands in a state of a train."""
    end = train.load.end()
    turning = train.omega * train.reference.slope(0.0) / train.N
    deviation = float(state[2]) if "motor deviation" in names else 0.0
    load_angle = (angle + deviation) / train.N - float(train.load_error(state))
    drag = torque_of(end.drag, load_angle, turning, (0.0,) * states_of(end.drag))
    return float(drag - end.excitation.torque(0.0))


def _loaded(
    train: DriveTrain, names: tuple[str, ...], state: Floats, guess: tuple[float, ...], torque: float, angle: float
) -> str:
    """Set the twists to those that carry a torque [N*m] at the load; a sentence where a law cannot.

    The error of the gear has its part of the angle between motor and load: without it a gap may count as closed.
    """
    for i, law in enumerate((train.law, *train.load.couplings())):
        if lacking(law, "stiffness"):
            continue
        places = [names.index(f"coupling {i}") if i else 0, *_memory(names, i)]
        try:
            state[places] = guess if guess and i == 0 else loaded_state(law, torque)
        except (ValueError, SolveError) as error:
            return str(error)
    state[0] += state[0] - train.torsion(angle, tuple(state))
    return ""


def _beside_gap(train: DriveTrain, u: float, torque: float) -> DriveTrain:
    """The train with a straight law through a torsion [rad] and its torque [N*m], as steep as its own beyond it."""
    stiffness = float(spring_stiffness(train.law, u * (1.0 + KINK_SHARE)))
    return train._replace(law=Polynomial((torque - stiffness * u, stiffness))) if stiffness else train


def _rates(train: DriveTrain, angle: float, state: Floats) -> Floats:
    return rates_at(train, np.full(1, angle), state[:, None])[:, 0]


def with_mean_torques(train: DriveTrain) -> DriveTrain:
    """Return the train with the mean torques alone."""
    motor, end = train.motor, train.load.end()
    return train.with_motor(excitation=mean_torque(motor.excitation)).with_load(excitation=mean_torque(end.excitation))


def repeats(torque: Any) -> bool:
    """True if a torque is a function of an angle with a mean, not of the time."""
    return not (lacking(torque, "mean") and lacking(torque, "terms"))


def mean_torque(torque: Any) -> Harmonic:
    """Mean of a torque as a constant one (TypeError where it has none, such as a profile)."""
    if not repeats(torque):
        raise TypeError(
            f"a {type(torque).__name__} has no mean torque; put Harmonic(0.0, mean=...) in its place, with the torque "
            "at the time in question"
        )
    return Harmonic(0.0, mean=sum(h.mean for h in terms_of(torque)))


def with_more(torque: Any, by: float) -> Any:
    """The torque with a mean that is larger by a torque [N*m]."""
    first, *others = terms_of(torque)
    first = first._replace(mean=first.mean + by)
    return first if lacking(torque, "terms") else torque._replace(terms=(first, *others))
