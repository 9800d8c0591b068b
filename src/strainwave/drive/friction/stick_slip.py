"""Steady motions at speeds at which dry friction lets a shaft stick or slip: by integration in time.

Where both shafts keep turning one way, well above the speed by which friction has fallen, it is a constant torque, and
the balance of a motion that repeats with every turn holds. Elsewhere the drive is integrated.
"""

import logging
import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ...base.results import Booleans, Branch, Floats, SolveError, Trajectory
from ...base.sentences import Sentence, Speed
from ...model.laws.dry import parted
from ...model.train.drive_train import DriveTrain
from ...numerics.integration.methods import Rodas
from ...numerics.integration.simulate import simulate
from ...numerics.integration.steps import dense_weights
from ..drive_response import DriveResponse
from ..operating_point import operating_state
from ..state_space import state_space

SPEEDS = 7  # that are integrated, evenly over the logarithm
SETTLING, SETTLINGS = 16.0, 5  # time constants of the slowest motion without a stop before, and how often at most
LONGEST_SPAN, FEWEST_STEPS, PARTS = 240.0, 2000, 4  # time constants, steps and parts of each at which sizes count
METHOD = Rodas(rtol=1e-5, atol=1e-7, max_steps=2_000_000)
SLOWEST_POLE = 1e-9  # of the largest pole: a smaller one is no motion

log = logging.getLogger(__name__)


class Sizes(NamedTuple):
    """Largest sizes of a motion in time.

    Oscillation and size of the error [rad], size of the error across the gear [rad], of the torque in the gear and its
    cubic mean, of that of the motor, its mean and its rms [N*m]. `part` is 1 where they are of less than a turn; the
    size of the error is then that about its mean.
    """

    oscillation: float
    peak: float
    across: float
    torque: float
    mean_torque: float
    motor_torque: float
    motor_mean: float
    motor_rms: float
    part: float


def slides(train: Any, rough: DriveTrain, angles: Floats, y: Any) -> Booleans:
    """True (motions,) if no shaft comes so near to rest that its dry friction lets it stick.

    The motions are steady ones of a `train` whose shafts slide, over whole turns: at `angles` (samples,) of the motor
    it has the states y (states, motions, samples). `rough` is the same train with its dry friction.
    """

    def is_fast(speed: Any, drag: Any) -> Booleans:
        return np.asarray(np.min(np.broadcast_to(speed, y[0].shape), axis=-1) > parted(drag))

    slides_at_load = is_fast(train.load_speed(angles, y), rough.load.end().drag)
    if train.motor.held:
        return slides_at_load
    return slides_at_load & is_fast(train.motor_speed(angles, y), rough.motor.drag)


def with_slips(response: DriveResponse, train: DriveTrain, keep: Booleans) -> DriveResponse:
    """The response with sizes by integration where its motions are not to `keep`, in points of a curve in arc order."""
    curve = response.curve
    low, high = float(np.min(curve.omega[~keep])), float(np.max(curve.omega[~keep]))
    speeds = np.geomspace(low, high, SPEEDS) if high > low else np.array([low])
    rows, rest = [], from_rest(train)
    for i, speed in enumerate(speeds.tolist()):
        log.info("stick and slip at %.4g rad/s, %d of %d", speed, i + 1, len(speeds))
        rows.append(in_time(train, speed, rest))
    table, order = np.array(rows).T, np.argsort(curve.omega)

    def mixed(name: str, values: Any, slow: bool = False) -> Any:
        if values is None:
            return None
        slipping = table[Sizes._fields.index(name)]
        if slow:  # what varies over the turn is beside the slips of a part of it
            slipping = slipping + table[-1] * np.interp(speeds, curve.omega[order], values[order])
        return np.where(keep, values, np.interp(np.log(curve.omega), np.log(speeds), slipping))

    oscillation = mixed("oscillation", curve.oscillation, True)
    falls = state_space(train, at=operating_state(train, low), speed=low)
    why = "" if falls.stable else ", and friction that falls with speed makes the loop unstable"
    sentence = Sentence(
        "from {} to {} a shaft may stick{}: values there are from time integrations at {} speeds",
        Speed(low), Speed(high), why, len(speeds),
    )  # fmt: skip
    sized: Branch = replace(
        curve, peak=mixed("peak", curve.peak, True), envelope=np.column_stack([oscillation, oscillation]),
        stable=curve.stable | ~keep, folds=[fold for fold in curve.folds if not low <= fold.omega <= high],
        message=Sentence("{}; {}", curve.message, sentence),
    )  # fmt: skip
    others = {name: mixed(name, getattr(response, name)) for name in Sizes._fields[2:-1]}
    return replace(response, curve=sized, **others)


def from_rest(train: DriveTrain) -> tuple[Floats, float]:
    """State of a train at rest, and the time constant [s] of its slowest motion; 0 where none decays."""
    state = operating_state(train, 0.0)
    poles = state_space(train, at=state).poles
    decays = -poles.real[poles.real < -SLOWEST_POLE * np.max(np.abs(poles))]
    return state, 1.0 / float(np.min(decays)) if len(decays) else 0.0


def in_time(train: DriveTrain, speed: float, rest: tuple[Floats, float] | None = None) -> Sizes:
    """Sizes of the motion of a train at a speed [rad/s] of its motor, as it begins from `rest`."""
    moving, (state, slowest) = train._replace(omega=speed), rest or from_rest(train)
    stays, turn, time = state_space(train, at=state, speed=speed).stable, 2.0 * math.pi / speed, 0.0
    if not train.motor.held:
        state = np.array([*state[:3], -speed, *state[4:]])  # behind its reference
    slowest = slowest or turn
    length = min(turn, LONGEST_SPAN * slowest)

    def followed(span: float, method: Rodas) -> Trajectory:
        run = simulate(moving, state, (time, time + span), method=method)
        if not run.status:
            raise SolveError(f"the motion with dry friction at {speed:.4g} rad/s is not followed: {run.message}")
        return run

    for _ in range(SETTLINGS):
        run = followed(SETTLING * slowest, METHOD)
        state, time = run.y[:, -1], run.t[-1]
        if stays and np.all(np.diff(run.t) > 0.0):  # without a stop, where a time stands twice
            length = turn
            break
    run = followed(length, replace(METHOD, largest_step=length / FEWEST_STEPS))
    h, parts = np.diff(run.t), np.arange(PARTS)[:, None] / PARTS
    ends, weights = (run.y[:, :-1], run.rate[:, :-1], run.y[:, 1:], run.rate[:, 1:]), dense_weights(parts, h)[:4]
    states: Any = sum(weight * value[:, None] for weight, value in zip(weights, ends, strict=True))
    y = tuple(np.moveaxis(states, 1, 2).reshape(len(state), -1))
    t = (run.t[:-1] + parts * h).T.ravel()
    phase = speed * t
    error, torque, motor = moving.pointing_error(y), moving.torque(phase, y), moving.motor_torque(phase, y)
    error, torque, motor = (np.asarray(value + 0.0 * t) for value in (error, torque, motor))

    def mean(value: Floats) -> float:
        return float(np.trapezoid(value, t) / (t[-1] - t[0]))

    off, size, part = np.max(np.abs(error - mean(error))), np.abs(torque), length < turn
    return Sizes(
        float(off), float(off if part else np.max(np.abs(error))), float(np.max(np.abs(y[0]))), float(np.max(size)),
        math.cbrt(mean(size**3)), float(np.max(np.abs(motor))), mean(motor), math.sqrt(mean(motor * motor)),
        float(part),
    )  # fmt: skip
