"""Demand of a profile on a rigid drive, and of a move on its motor, against the limits of the motor."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ...base.law import states_of, torque_of
from ...base.protocols import Law, lacking
from ...base.results import Floats, SolveError
from ...drive.demands import motor_limits
from ...drive.demands.motor_limits import PEAK, RMS, MotorLimits, Need
from ...model.gears.limits import Finding
from ...model.laws.dry import settled
from ...model.train.drive_train import DriveTrain
from ...numerics.operating_point import loaded_state
from .path import Path

SEGMENT_SAMPLES = 16  # samples in a segment: gravity varies little in it


class Demand(NamedTuple):
    """Of a rigid drive, at times (m,) of a profile [s].

    `angle` of the load [rad], `speed` of the motor [rad/s]; torques [N*m]: `holding` at the output, of gravity,
    friction and the load's own mean torque, `resting` the same at rest, and `motor`, all that the motor has to give.
    """

    t: Floats
    angle: Floats
    speed: Floats
    holding: Floats
    resting: Floats
    motor: Floats


class Motion(NamedTuple):
    """Demand of a move on the motor.

    Times (n,) [s] with its torque [N*m] and speed [rad/s]; largest and rms torque, largest and mean speed.
    """

    t: Floats
    torque: Floats
    speed: Floats
    peak_torque: float
    rms_torque: float
    peak_speed: float
    mean_speed: float


def demand_of(train: DriveTrain, path: Path, stretch: float = 1.0) -> Demand:
    """Demand of a path on a train without its elasticity, with the accelerations of one so many times as long."""
    t = path.dense(SEGMENT_SAMPLES)
    angle, speed, acceleration = path.motion_at(np.append(np.nextafter(t[:-1], np.inf), t[-1]))
    acceleration = acceleration / stretch**2
    end, N = train.load.end(), train.N
    holding = _drag_torque(end.drag, angle, speed) - end.excitation.torque(t)
    passed = holding + train.load_inertia * acceleration
    lost = _drag_torque(train.motor.drag, N * angle, N * speed) + train.friction.torque(passed, N * speed) / N
    given = train.motor.J * N * acceleration + passed / N + lost
    resting = _drag_torque(end.drag, angle, 0.0 * speed) - end.excitation.torque(t)
    return Demand(t, angle, N * speed, holding, resting, given)


def standing_torque(train: DriveTrain, path: Path) -> float:
    """Largest torque [N*m] that a motor gives at the rests of a path, of a rigid drive."""
    t = np.array([0.0, *(end for _, end in path.motions())])
    angle, end, still = path.motion_at(t)[0], train.load.end(), 0.0 * t
    holding = _drag_torque(end.drag, angle, still) - end.excitation.torque(t)
    return float(np.max(np.abs(_drag_torque(train.motor.drag, train.N * angle, still) + holding / train.N)))


def refuse_heavy(train: DriveTrain, path: Path) -> None:
    """Refuse a load that is beyond what the law of the gear carries (ValueError)."""
    demand = demand_of(train, path)
    worst = int(np.argmax(np.abs(demand.holding)))
    pull = float(demand.holding[worst])
    if lacking(train.law, "stiffness"):
        return
    try:
        loaded_state(train.law, pull)
    except (ValueError, SolveError) as error:
        raise ValueError(
            f"the load torque is {abs(pull):.4g} N*m at {np.degrees(demand.angle[worst]):.4g} deg, too large for the "
            f"gear: {error}; use a lighter payload, a shorter arm or a larger gear"
        ) from error


def move_findings(train: DriveTrain, path: Path, limits: MotorLimits, motion: Motion) -> Iterator[Finding]:
    """Demand of a move on the motor, its vibration included, against the limits; the remedy goes by the profile."""
    demand = demand_of(train, path)
    over = float(np.max(np.abs(demand.speed))) / limits.fastest
    smoother = "use a longer time, a smoother profile or a stronger motor"
    of_torque = _stretch_advice(train, path, limits) if _too_large(demand, limits) else smoother
    of_speed = _stretch_sentence(path, over, "use a smaller ratio") if over > 1.0 else smoother
    computed = "the move is computed with unlimited motor torque; "
    remedies = computed + of_torque, computed + of_speed
    holding = float(np.max(np.abs(demand_of(train, path, math.inf).motor)))
    peak = None if limits.peak_torque else motion.peak_torque
    yield from motor_limits.motor_findings(limits, peak, motion.peak_speed, holding, remedies)
    if limits.peak_torque:
        size = np.abs(motion.torque)
        need = Need(np.abs(motion.speed), size, size, np.zeros(len(size) - 1, bool))
        yield motor_limits.torque_finding(limits, PEAK, [need], computed + of_torque)
    if limits.lasts:
        yield _lasting(train, path, limits, motion)
    yield from motor_limits.sheet_findings(
        limits, [], motion.mean_speed, float(np.max(np.abs(demand.resting))) / train.N
    )


def _lasting(train: DriveTrain, path: Path, limits: MotorLimits, motion: Motion) -> Finding:
    """The rms torque of a profile that is repeated without end against the continuous torque at its speeds.

    The mean of (torque/continuous torque)^2 over the profile must be at most 1. The bound is the continuous torque with
    the same mean: that of each speed, weighted by the heat there.
    """
    inside = motion.t <= path.duration
    t, torque, allowed = motion.t[inside], motion.torque[inside], limits.at(RMS, motion.speed[inside])
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(torque == 0.0, 0.0, torque / allowed)
        held = float(np.abs(demand_of(train, path, math.inf).motor[-1] / limits.at(RMS, 0.0)))
    heat, relative = float(np.trapezoid(torque * torque, t)), float(np.trapezoid(share * share, t))
    bound = math.sqrt(heat / relative) if relative > 0.0 else float(np.min(allowed))
    remedy = "use a stronger motor"
    if held < 1.0 and path.duration < relative < math.inf:
        pause = _rounded_up((relative - path.duration) / (1.0 - held * held))
        remedy = f"add a rest of {pause} s at the end of every cycle, or {remedy}"
    fact = f"The rms motor torque over the profile is {motion.rms_torque:.4g} N*m, the continuous torque {{}}"
    return motor_limits.short_finding(RMS, motion.rms_torque, bound, fact, remedy)


def _too_large(demand: Demand, limits: MotorLimits) -> bool:
    return bool(np.any(np.abs(demand.motor) > limits.at(PEAK, demand.speed)))


def _stretch_advice(train: DriveTrain, path: Path, limits: MotorLimits) -> str:
    """Stretch by a rigid drive of a profile whose torque is too large; friction stays that of its speed."""

    def too_large(stretch: float) -> bool:
        demand = demand_of(train, path, stretch)
        return _too_large(demand._replace(speed=demand.speed / stretch), limits)

    if too_large(math.inf):
        return "the torque is too large even without acceleration; use a stronger motor or a larger ratio"
    low, high = 1.0, 2.0
    while too_large(high):
        low, high = high, 2.0 * high
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if too_large(middle) else (low, middle)
    return _stretch_sentence(path, high, "use a stronger motor")


def _stretch_sentence(path: Path, factor: float, other: str) -> str:
    """The advice to take so many times as long; the vibration, which is another one then, is not in it."""
    need = f"lengthen the move from {path.duration:.4g} s to at least {_rounded_up(factor * path.duration)} s"
    return f"{need} (rigid drive; vibration may require more), or {other}"


def _rounded_up(value: float) -> str:
    """Four digits, rounded up."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 3)
    return f"{math.ceil(value / unit * (1.0 - 1e-12)) * unit:.4g}"


def _drag_torque(law: Law, angle: Floats, speed: Floats) -> Floats:
    law = settled(law)
    return np.asarray(torque_of(law, angle, speed, (0.0 * angle,) * states_of(law)) + 0.0 * angle)
