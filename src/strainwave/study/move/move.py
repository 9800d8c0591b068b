"""`move`: a drive follows a profile, with gravity and payload, on its two inertias and the loop of its motor."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...base.law import has, spring_stiffness
from ...base.protocols import lines_of
from ...base.quantities import checked, interval, number
from ...base.results import Floats, SolveError
from ...base.units import ARCSEC, RPM
from ...drive.demands.motor_limits import PEAK, MotorLimits
from ...drive.demands.move_task import Feedforward, Task
from ...drive.demands.payload import Payload
from ...drive.friction.standstill import standing
from ...drive.project import Project
from ...drive.run import INPUTS, waiting
from ...drive.state_space import state_space
from ...model.gears.gear import Gear
from ...model.gears.limits import Finding, bearing_life, check_limits
from ...model.laws.dry import is_dry
from ...model.train.drive_train import DriveTrain
from ...model.train.motion import Segment
from ...numerics.integration.methods import Dopri5, Method
from ...numerics.integration.record import uninterrupted
from ...numerics.integration.simulate import simulate
from .demand import Motion, move_findings, refuse_heavy, standing_torque
from .follow import FollowedPath, follow
from .mover import Mover, mover_of
from .passes import Pass, crossings, part_of_beat, passes_of
from .path import Path
from .profiles import path_of
from .result import Move
from .servo import commanded_speed, limited_time, servo_train
from .settling import STEP_TIMES, Quintic, settling

ACCURATE = Dopri5(rtol=1e-10, atol=1e-13)
WINDOW = 60.0 * ARCSEC  # where nothing is given: the accuracy class of a gear
DECAY = 7.0  # time constants of the slowest vibration after the end: 0.1 % of it is left
TAIL_DURATIONS = 20.0  # durations of the profile that the run goes on at most
RESONANT = math.sqrt(0.5)  # damping ratio from which on a vibration has no resonance
STANDS = 1e-6  # of the mean speed of a profile: a motor that is never faster does not break away
STUCK = "The motor does not move: dry friction holds the motor during the whole move."


def move(
    project: Any,
    profile: Any = None,
    *,
    start: float | None = None,
    payload: Payload | None = None,
    gear: Gear | None = None,
    limits: MotorLimits | None = None,
    window: float | None = None,
    bands: Sequence[tuple[float, float]] = (),
    tail: float | None = None,
    method: Method = ACCURATE,
    limited: bool = False,
    feedforward: Feedforward | None = None,
) -> Move:
    """Move the load of a drive along a profile and say how well that goes.

    The whole train is integrated, its two inertias with the loop of its motor, from rest where gravity holds it. The
    motor's loop follows the profile times the ratio. A move that asks more of the motor than its limits is computed as
    if the motor had it, and fails (`Move.within_limits`); with `limited` the motor has no more torque than its limit
    at every speed, and the integrals of a cascade do not wind up meanwhile. Torques have their means; lines of a
    torque, which follow an angle at constant speed, are left out.

    Parameters
    ----------
    project : Project or DriveTrain
        The drive. A project that names neither a mode nor a loop of its motor gets a position loop of 30 Hz, and
        `remarks` says so.
    profile : Trapezoid, SCurve, AngleProfile, Dwell, str, or a list of them
        Angle of the load over time; a list is a duty cycle. A text is as "trapezoid, angle: 90 deg, time: 0.6 s", or
        the name of a CSV file. Default: that of the project file.
    start : float, optional
        Angle of the load at the begin [rad]. Default: that of the project file, of the first point of an
        `AngleProfile`, or 0.
    payload : Payload, optional
        Payload of the load beside what the drive has. Default: that of the project file. The gains of the motor's
        loop are not changed by it.
    gear : Gear, optional
        Record whose limits the move is compared with. Default: that of the project.
    limits : MotorLimits, optional
        Sheet of the motor: largest torque and speed, curves, rms torque, brake. Default: that of the project file.
    window : float, optional
        Largest distance from the error at rest [rad] of a settled load. Default: the limit of the project file, or 1
        arcmin.
    bands : sequence of (float, float)
        Motor speeds to avoid [rad/s], for instance `project.analyze().avoid.bands`.
    tail : float, optional
        Time [s] to follow the load after the end. Default: until the slowest vibration has decayed to 0.1 %, 20 times
        the profile at most.
    method : Dopri5, Rk4 or Dop8
        Integration method; steps end at every knot of the profile.
    limited : bool
        True to keep the torque of the motor within its limit at its speed, and the speed that a cascade's position
        loop asks for within the largest one; `remarks` says for how long they were at their limits.
    feedforward : Feedforward, optional
        Torque and speed that the motor is given beside its loop. Default: that of the project file, or the speed alone.

    Returns
    -------
    Move
        `pointing_error` [rad], `motor_torque` and `gear_torque` [N*m] over `time` [s]; `settling_time` [s] and
        the largest values; every value is finite.

    Raises
    ------
    ValueError
        If the profile is empty or goes back in time; if the law of the gear cannot hold the payload; if the motor has
        no loop, or a number is out of range; if `limited` has no limit, or one below what holds the load.
    SolveError
        If the integration stops early.
    """
    task = project.move or Task() if isinstance(project, Project) else Task()
    profile = task.profile or None if profile is None else profile
    if profile is None:
        fault = "there is no profile; give one, such as Trapezoid(angle, time), or a `move` in the project file"
        raise ValueError(fault)
    path = path_of(profile, task.start if start is None else start)
    mover = mover_of(project, gear, limits, task.payload if payload is None else payload)
    given = (window, task.window, getattr(project, "limit", None), WINDOW)
    window = number("window [rad]", next(value for value in given if value is not None), positive=True)
    spans = tuple(interval("bands [rad/s]", band) for band in tuple(bands))
    refuse_heavy(mover.train, path)
    y0 = _at_rest(mover.train, 0.0, float(path.angle[0]))
    poles = state_space(mover.train, at=y0).poles
    decay = _tail(poles, path)
    tail = decay if tail is None else number("tail [s]", tail, positive=True)
    shares = checked(feedforward or task.feedforward or Feedforward())
    if limited or shares != Feedforward():
        mover = _with_servo(mover, path, shares, limited)
        y0 = _at_rest(mover.train, 0.0, float(path.angle[0]))
    run = follow(mover.train, path, y0, tail, method)
    crossed = crossings(mover.train, path, _resonances(poles))
    passed: tuple[Pass, ...] = ()
    if crossed:
        smooth = follow(_without_error(mover.train), path, y0, tail, method)
        with_error = Quintic.through(run.t, *run.pointing(), run.steps)
        plain = Quintic.through(smooth.t, *smooth.pointing(), smooth.steps)
        t = with_error.dense(STEP_TIMES)
        passed = tuple(passes_of(crossed, mover.train, path, t, with_error.values(t) - plain.values(t)))
    if is_dry(mover.train) and (resting := standing(project)) and resting.hunts:
        mover = replace(mover, remarks=(*mover.remarks, f"At rest: {resting.hunting()}"))
    result = _result(mover, path, run, window, spans, passed, [*_rests(mover, path, run, decay, method)])
    return replace(result, fault=_fault(project, task.payload if payload is None else payload))


def _fault(project: Any, payload: Payload | None) -> str:
    """Sentence on a motor's loop that is unstable with a payload; empty of a stable one and of a train."""
    if not isinstance(project, Project) or project.train is None:
        return ""
    loaded = project if payload is None else replace(project, subject=checked(payload).on(project.train))
    return loaded.loop_fault


def _with_servo(mover: Mover, path: Path, shares: Feedforward, limited: bool) -> Mover:
    """The mover with feedforward, and with the limit of its motor's torque."""
    if limited and not math.isfinite(mover.limits.most):
        raise ValueError("a limited move needs the largest motor torque; give limits=MotorLimits(torque) or max_torque")
    holding = standing_torque(mover.train, path) if limited else 0.0
    train = servo_train(mover.train, mover.limits if limited else MotorLimits(), holding, shares)
    return replace(mover, train=train, limited=limited)


def _standing(train: DriveTrain, t: float, angle: float) -> DriveTrain:
    """The drive at a time [s] with its reference at an angle of the load [rad]."""
    return train._replace(reference=Segment(t, train.N * angle, 0.0, 0.0, 0.0))


def _is_loose(train: DriveTrain, t: float, state: Any) -> bool:
    """True for a spring that holds nothing in a state at a time [s]: states beside it are equilibria as well."""
    springs = [(train.law, train.torsion(t, state))]
    springs += [(law, state[i]) for i, law in zip(train.twists(), train.load.couplings(), strict=True)]
    return any(has(law, "stiffness") and float(spring_stiffness(law, u)) == 0.0 for law, u in springs)


def _at_rest(train: DriveTrain, t: float, angle: float) -> Floats:
    """State (states,) in which the drive rests at a time [s] with its reference at an angle of the load [rad]."""
    standing = _standing(train, t, angle)
    try:
        return waiting(standing, t)
    except SolveError as error:
        reason = str(error).removesuffix("; give the initial state y0")
        raise SolveError(f"the drive cannot hold the load at {math.degrees(angle):.4g} deg: {reason}") from error


def _without_error(train: DriveTrain) -> DriveTrain:
    """The same train with lines of the kinematic error of amplitude 0: of the same class to the compiler."""
    lines = tuple(line._replace(amplitude=0.0) for line in lines_of(train.error))
    return train._replace(error=train.error._replace(lines=lines))


def _resonances(poles: Any) -> Floats:
    """Natural frequencies [rad/s] of vibrations with a resonance, ascending."""
    return np.sort(np.abs(poles[(poles.imag > 0.0) & (-poles.real < RESONANT * np.abs(poles))]))


def _tail(poles: Any, path: Path) -> float:
    """Time [s] in which the slowest vibration decays, but for those that do not."""
    rates = -poles.real[-poles.real > 1e-9 * np.max(np.abs(poles))]
    return min(TAIL_DURATIONS * path.duration, DECAY / float(np.min(rates, initial=np.inf)))


def _times_at_limits(run: FollowedPath, torque: Floats, speed: Floats, limits: MotorLimits) -> Iterator[str]:
    """Times for which the motor was at its limits, a sentence each."""
    beyond = limited_time(commanded_speed(run.train, run.t, tuple(run.y)), run.t, limits.fastest)
    if beyond:
        limit = f"{limits.fastest / RPM:.5g} rpm"
        yield f"The speed commanded by the position loop was at its limit of {limit} for {beyond:.4g} s."
    yield f"The motor torque was at its limit for {limited_time(torque, run.t, limits.at(PEAK, speed)):.4g} s."


def _result(
    mover: Mover, path: Path, run: FollowedPath, window: float, bands: tuple[tuple[float, float], ...],
    passed: tuple[Pass, ...], rests: list[float],
) -> Move:  # fmt: skip
    train = run.train
    error, motor, gear, speed = run.seen()
    peaks, remarks = run.peaks(), (*mover.remarks, *part_of_beat(train, path))
    if mover.limited:
        peaks[1] = min(peaks[1], mover.limits.most)
        remarks = (*remarks, *_times_at_limits(run, motor, speed, mover.limits))
    rms = [math.sqrt(max(integral, 0.0) / path.duration) for integral in run.means[:3]]
    average = math.cbrt(run.means[3] / (turned := train.N * path.travel()))
    curve = Quintic.through(run.t, *run.pointing(), run.steps)
    stands = is_dry(train) and peaks[3] * path.duration < STANDS * turned
    times = zip(path.motions(), _waits(path, run), rests, strict=True)
    settled = tuple(None if stands else settling(curve, final, window, end, until) for (_, end), until, final in times)
    energy = np.asarray(train.energy(run.t, tuple(run.y)))
    gap = energy - energy[0] - np.sum(run.work[:INPUTS], axis=0) + np.sum(run.work[INPUTS:], axis=0)
    scale = max(float(np.max(np.abs(run.work))), float(np.max(np.abs(energy))), 1e-300)
    mean_speed = turned / path.duration
    findings: tuple[Finding, ...] = ()
    if mover.gear is not None:
        findings = check_limits(
            mover.gear, peak_torque=peaks[2], average_torque=average, max_speed=peaks[3], average_speed=mean_speed
        )
    motion = Motion(run.t, motor, speed, peaks[1], rms[1], peaks[3], mean_speed)
    findings += tuple(move_findings(train, path, mover.limits, motion))
    keep = np.append(True, np.diff(run.t) > 0.0)
    last = np.flatnonzero(path.moving)[-1]  # the last segment of the last motion
    return Move(
        time=run.t[keep],
        reference=np.asarray(train.reference.value(run.t))[keep] / train.N,
        reference_speed=np.asarray(train.reference.slope(run.t))[keep],
        pointing_error=error[keep],
        motor_torque=motor[keep],
        gear_torque=gear[keep],
        motor_speed=speed[keep],
        duration=path.duration,
        window=window,
        settling_time=settled[-1],
        settling_times=settled,
        rest_error=rests[-1],
        end_error=float(error[np.flatnonzero(run.segment == last)[-1]]),
        peak_error=peaks[0],
        rms_error=rms[0],
        peak_motor_torque=peaks[1],
        rms_motor_torque=rms[1],
        peak_gear_torque=peaks[2],
        rms_gear_torque=rms[2],
        average_gear_torque=average,
        peak_speed=peaks[3],
        average_speed=mean_speed,
        life=None if mover.gear is None else bearing_life(mover.gear, average, mean_speed),
        findings=findings,
        warnings=tuple(finding.sentence for finding in findings if finding.exceeded),
        bands=bands,
        time_in_bands=tuple(path.time_within(low / train.N, high / train.N) for low, high in bands),
        passes=passed,
        work={name: float(value) for name, value in zip(train.power_names(), run.work[:, -1], strict=True)},
        stored=float(energy[-1] - energy[0]),
        imbalance=float(np.max(np.abs(gap))) / scale,
        remarks=(*remarks, *[STUCK] * stands),
        K_t=mover.limits.K_t if math.isfinite(mover.limits.K_t) else None,
    )


def _waits(path: Path, run: FollowedPath) -> list[float]:
    """Times [s] until which the drive waits after every motion: the next one, or the end of the run."""
    return [begin for begin, _ in path.motions()[1:]] + [float(run.t[-1])]


def _rests(mover: Mover, path: Path, run: FollowedPath, decay: float, method: Method) -> Iterator[float]:
    """Error at rest [rad] after every motion.

    It is that of the equilibrium there, or, where this depends on the way, that to which the drive comes when it waits
    for longer than it does by the time [s] in which its vibration decays.
    """
    for (_, end), until in zip(path.motions(), _waits(path, run), strict=True):
        angle = float(path.motion_at(np.array([end]))[0][0])
        standing = _standing(mover.train, end, angle)
        state: Any = None if mover.depends_on_past else tuple(_at_rest(mover.train, end, angle))
        if state is None or _is_loose(standing, end, state):
            state_there = run.y[:, np.searchsorted(run.t, until)]
            on = uninterrupted(simulate(standing, state_there, (until, until + decay), method=method))
            if not on.status:
                raise SolveError(f"the motion cannot be computed until rest: {on.message}")
            state = tuple(on.y[:, -1])
        yield float(mover.train.pointing_error(state))
