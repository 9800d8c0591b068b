"""Linear part of a drive train: inertias, dampings and stiffnesses around its gear, as matrices.

Its coordinates are the dynamic error x, the twists of the couplings, the motor's deviation from its reference and the
states of its control: Lagrange's equations of `theory.derivation`, in which a shaft whose angle is the sum a . p of
coordinates has the inertia J a a^T, and so on. The twists that laws see come first, the motor's deviation next where a
kinematic error follows it.
"""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ...base.law import depends, states_of, torque_of, z_rate_of
from ...base.protocols import lacking, orders_of
from ...base.results import Floats
from ..excitation import NoError
from ..laws.friction import NoFriction
from .commanded import Commanded, TorqueDriven
from .controls import Free, Nudged, PositionLoop, SpeedLoop, core_of, inertia_of
from .motion import AtRest, Steady
from .shafts import Motor

SIZES = (1e-9, 1e-3, 1.0, 1e3)  # twists [rad] and speeds [rad/s] at which a law is asked whether it is linear
TINY = 1e-300
ROUNDING, FEWEST = 1e-12, 64  # of torques in balance, and places of a turn where their mean is taken
WEAK = 1e-3  # of the base speed: loop that moves the multiplier 1 of a mean that nothing holds just below 1


@dataclass(frozen=True)
class TrainPart:
    """The `LinearPart` of a drive train; see `protocols`."""

    train: Any
    inertia: Floats
    damping: Floats
    stiffness: Floats
    per_speed: Floats
    laws: tuple[Any, ...]
    follows: bool
    loose: int
    zero_mean: Floats
    integral: Floats
    values: Floats
    rates: Floats
    disturbed: Any
    motor: Floats
    load: Floats

    @property
    def gear_damping(self) -> float:
        """Damping [N*m*s/rad] across the gear."""
        return float(self.train.B)

    @property
    def error(self) -> Any:
        """Kinematic error of the gear."""
        return self.train.error

    def forces(self, angles: Floats) -> Floats:
        """Torques (n, samples) of motor and load at base angles [rad], on the coordinates."""
        motor, load = self.train.motor.excitation, self.train.load.end().excitation
        zero = np.zeros(len(angles))
        return np.outer(self.motor, motor.torque(angles) + zero) + np.outer(self.load, load.torque(angles) + zero)


def linear_part(train: Any, at_load: bool = False) -> TrainPart | None:
    """Linear part of a train; None where a part of it is neither linear nor a law of its own twist.

    Parameters
    ----------
    train : DriveTrain
        The train at constant mean speed.
    at_load : bool
        True if its first states are the pointing error and its rate; a mean motor torque that keeps the
        mean speed is then taken for granted where nothing holds the mean angle.
    """
    held, end = train.motor.held, train.load.end()
    if isinstance(core_of(train.motor.control), Commanded | TorqueDriven):
        raise TypeError(
            f"the torque of the motor comes from outside ({type(train.motor.control).__name__}()), so that it has no "
            "motions of its own; give the motor a loop, such as SpeedLoop, or take ClosedLoop(train, controller)"
        )
    control = None if held else _control(train.motor.control)
    drags = _drag(train.motor.drag), _drag(end.drag)
    rough = depends(train.law) != 1 or lacking(train.load, "chain") or (control is None and not held) or None in drags
    rubs = not held and not isinstance(train.friction, NoFriction)  # a motor that is held takes it and goes on
    still = isinstance(train.reference, AtRest) and isinstance(train.error, NoError)  # else with the base angle
    if rough or rubs or not (still or isinstance(train.reference, Steady)):
        return None
    chain = train.load.chain()
    stiffnesses = [_stiffness(law) for _, _, law in chain]
    if any(k is None and depends(law) != 1 for k, (_, _, law) in zip(stiffnesses, chain, strict=True)):
        return None
    part = _assembled(train, at_load, control, drags, stiffnesses)
    return part if at_load or part.loose < 0 or np.any(part.integral) or _in_balance(part) else None


class Coordinates(NamedTuple):
    """Places of the coordinates of a train: x first, twists that laws see, the motor and its control, other twists.

    `motor` is the place of the motor's deviation, behind which the states of its control stand: `motor_count` in all,
    0 of a motor that is held. `twists` are the places of the couplings' twists, from the gear on.
    """

    size: int
    motor: int
    motor_count: int
    twists: tuple[int, ...]

    @classmethod
    def of(cls, train: Any, stiffnesses: list[float | None]) -> "Coordinates":
        """Coordinates of a train whose couplings have these stiffnesses, None where a law sees the twist."""
        soft = [i for i, k in enumerate(stiffnesses) if k is None]
        motor, motor_count = 1 + len(soft), 0 if train.motor.held else 1 + states_of(train.motor.control)
        hard = [i for i, k in enumerate(stiffnesses) if k is not None]
        places = [*range(1, motor), *range(motor + motor_count, motor + motor_count + len(hard))]
        of_coupling = dict(zip([*soft, *hard], places, strict=True))
        twists = tuple(of_coupling[i] for i in range(len(stiffnesses)))
        return cls(motor + motor_count + len(hard), motor, motor_count, twists)


def _assembled(train: Any, at_load: bool, control: Any, drags: Any, stiffnesses: list[float | None]) -> TrainPart:
    """Matrices of a train on its coordinates, shaft by shaft from the gear on; then the motor with its control."""
    at = Coordinates.of(train, stiffnesses)
    chain, end, held, N, n = train.load.chain(), train.load.end(), train.motor.held, train.N, at.size
    unit, motor_at = np.eye(n), at.motor
    motor = np.zeros(n) if held else unit[motor_at]
    M, C, K = np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n))
    speed, per_speed = float(isinstance(train.reference, Steady)), np.zeros(n)
    angle = motor / N - unit[0]  # of the shaft behind the gear
    for (J, B, _), stiffness, place in zip(chain, stiffnesses, at.twists, strict=True):
        twist = unit[place]
        M += J * np.outer(angle, angle)
        C += B * np.outer(twist, twist)
        K += (stiffness or 0.0) * np.outer(twist, twist)
        angle = angle - twist
    M += end.J * np.outer(angle, angle)
    C += drags[1] * np.outer(angle, angle)
    per_speed -= drags[1] * speed / N * angle
    integral, zero_mean, loose = np.zeros(n), motor, -1
    if not held:
        M[motor_at, motor_at] += train.motor.J + inertia_of(train.motor.control)
        C[motor_at, motor_at] += drags[0]
        per_speed -= drags[0] * speed * motor
        indices = np.arange(motor_at, motor_at + at.motor_count)
        C[np.ix_(indices, indices)] += control[1]
        on_load = hasattr(train.motor.control, "at_load")
        position = motor - N * (unit[0] + sum(unit[place] for place in at.twists)) if on_load else motor
        K[indices] += np.outer(control[0][:, 0], position) + control[0][:, 1:] @ unit[indices[1:]]
        integral[indices] = _means(control[0])
        if np.any(integral):
            loose, zero_mean = motor_at, position
        elif not (np.any(K[motor_at]) or np.any(K[:, motor_at])):
            loose = motor_at
    weak = loose >= 0 and not np.any(integral)
    values, rates = _states(at, train, at_load)
    return TrainPart(
        train, inertia=M, damping=C, stiffness=K, per_speed=per_speed,
        laws=(train.law, *(law for (_, _, law), k in zip(chain, stiffnesses, strict=True) if k is None)),
        follows=not held and not isinstance(train.error, NoError), loose=loose, zero_mean=zero_mean, integral=integral,
        values=values, rates=rates, motor=motor, load=angle,
        disturbed=train._replace(motor=_weakly_held(train.motor, train.omega)) if weak else train,
    )  # fmt: skip


def _means(stiffness: Floats) -> Floats:
    """Mean deviation as seen, 0, and states of an integrating control that holds a torque of 1 N*m; zeros of another.

    Its states rest where K z is 0 in all rows but the first, which is the torque: where that leaves the deviation no
    choice, the control holds any torque.
    """
    means, rows = np.zeros(len(stiffness)), stiffness[1:]
    if not len(rows):
        return means
    rows = rows / np.maximum(np.max(np.abs(rows), axis=1, keepdims=True), TINY)
    inner = rows[:, 1:]
    rank = np.linalg.matrix_rank
    if rank(inner) < len(inner) and rank(rows) == len(rows):
        held = np.linalg.svd(inner)[2][-1]
        torque = float(stiffness[0, 1:] @ held)
        if torque:
            means[1:] = held / torque
    return means


def _states(at: Coordinates, train: Any, at_load: bool) -> tuple[Floats, Floats]:
    """Tables (states, n) of the states in the order of the train's: those that are no rates, and the rates."""
    unit, zero = np.eye(at.size), np.zeros(at.size)
    first = unit[0] + (sum(unit[place] for place in at.twists) if at_load else 0.0)
    if at_load and not (train.motor.held or train.motor.free):
        first = first - unit[at.motor] / train.N
    values, rates = [first, zero], [zero, first]
    if not train.motor.held:
        values, rates = [*values, unit[at.motor], zero], [*rates, zero, unit[at.motor]]
    for place in range(at.motor + 1, at.motor + at.motor_count):
        values, rates = [*values, unit[place]], [*rates, zero]
    for place in at.twists:
        values, rates = [*values, unit[place], zero], [*rates, zero, unit[place]]
    return np.array(values), np.array(rates)


def _in_balance(part: TrainPart) -> bool:
    """True if the mean torques on a motor that nothing holds leave its mean speed alone; with an error they do not."""
    if part.follows or part.per_speed[part.loose] != 0.0:
        return False
    motor, load = part.train.motor.excitation, part.train.load.end().excitation
    places = FEWEST + 2 * math.ceil(max((0.0, *orders_of(motor), *orders_of(load))))  # no order repeats at all of them
    angles = 2.0 * np.pi * np.arange(places) / places
    shares = (
        part.motor[part.loose] * np.mean(motor.torque(angles)),
        part.load[part.loose] * np.mean(load.torque(angles)),
    )
    largest = max(float(np.max(np.abs(part.forces(angles)[part.loose]))), 1e-300)
    return bool(abs(sum(shares)) <= ROUNDING * largest)


def _weakly_held(motor: Motor, omega: float) -> Motor:
    """The motor with a loop far slower than its reference, for one without: it takes the place of an exact 1."""
    inertia = motor.J + inertia_of(motor.control)
    weak = WEAK * omega * inertia
    if isinstance(motor.control, Free):
        return motor._replace(control=Nudged(weak, 0.125 * WEAK * omega * weak))
    if isinstance(motor.control, SpeedLoop):
        return motor._replace(control=motor.control._replace(K_i=WEAK * omega * max(motor.control.K_p, weak)))
    if isinstance(motor.control, PositionLoop):
        damping = max(motor.control.K_d, weak)
        return motor._replace(control=motor.control._replace(K_p=WEAK * omega * damping, K_d=damping))
    return motor


def _control(control: Any) -> tuple[Floats, Floats] | None:
    """Stiffness and damping matrices (deviation and states of the control) of a linear one; None of another."""
    n = states_of(control)

    def answers(x: Any, v: Any, *z: Any) -> tuple[Any, ...]:
        return torque_of(control, x, v, z), *z_rate_of(control, x, v, z)

    columns = _linear(answers, 2 + n)
    if columns is None:
        return None
    K, C = np.zeros((1 + n, 1 + n)), np.zeros((1 + n, 1 + n))
    sign = np.array([1.0, *[-1.0] * n])
    K[:, 0], C[:, 0], K[:, 1:] = sign * columns[:, 0], sign * columns[:, 1], sign[:, None] * columns[:, 2:]
    C[1:, 1:] += np.eye(n)
    return K, C


def _drag(law: Any) -> float | None:
    """Damping [N*m*s/rad] of a drag that is proportional to the speed; None of another."""
    if states_of(law):
        return None
    columns = _linear(lambda x, v: (torque_of(law, x, v, ()),), 2)
    return None if columns is None or columns[0, 0] != 0.0 else float(columns[0, 1])


def _stiffness(law: Any) -> float | None:
    """Stiffness [N*m/rad] of a linear law of the twist; None of another."""
    if depends(law) != 1:
        return None
    columns = _linear(lambda x: (law.torque(x),), 1)
    return None if columns is None else float(columns[0, 0])


def _linear(function: Any, n: int) -> Floats | None:
    """Matrix of a linear function of n numbers; None where it is not linear at values of all sizes."""
    mixed = np.outer(np.cos(1.0 + 2.0 * np.arange(n)), [*SIZES, *(-size for size in SIZES)])
    y = np.hstack([np.eye(n), mixed])
    with np.errstate(all="ignore"):
        values = np.array([0.0 * y[0] + row for row in function(*y)])
        columns = values[:, :n].copy()
        linear = np.all(np.abs(values - columns @ y) <= ROUNDING * (np.abs(columns) @ np.abs(y)))
    return columns if linear else None
