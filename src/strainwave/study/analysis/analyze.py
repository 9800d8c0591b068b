"""`analyze`: stability, resonances, the response through the speed range, single speeds in time, and advice."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ...compile.blas import one_thread
from ...law import is_spring
from ...model.gears.gear import Gear
from ...model.oscillator import Oscillator
from ...model.train.drive_train import DriveTrain
from ...model.varying import VaryingOscillator
from ...results import SolveError
from ...speeds import Speeds
from ...theory.lyapunov import lyapunov
from ...theory.slow_flow.resonance import NONRESONANT, Resonance
from ...theory.stability_proof import Obstacle, StabilityProof
from ..move.demands import MotorLimits
from ..response.resonances import OperatingPoint, Regime, operating_point, regimes
from ..response.response import ExactResponse, exact_response
from .analysis import Analysis
from .avoid import in_run, speeds_to_avoid
from .drive_response import DriveResponse, of_equation
from .gear_studies import loop_of, parametric_of
from .in_time import TimeCase, speeds_in_time, time_case
from .load_range import LoadCase, LoadRange, load_cases, over_all, searched
from .motor_cases import motor_cases
from .plausible import implausible
from .remedies import Source, Subject, what_helps
from .resonance_tops import with_tops
from .runup import RunUp, run_up, silent
from .train_curve import has_curve, refuse_free, train_curve
from .train_study import TrainStudy, train_study
from .usage import MotorUse, Usage, limit_findings, most_asked, most_used, usage
from .verdict import smallest_change, verdict_of

Told = Callable[[str, float], None]

FEWEST, FINE = 20, 300  # points of the response curve in the band of a resonance, and of one drawn for it alone


@one_thread
def analyze(
    system: Oscillator | VaryingOscillator,
    speeds: Speeds,
    *,
    gear: Gear | None = None,
    train: DriveTrain | None = None,
    rated_torque: float | None = None,
    limit: float | None = None,
    source: Source | None = None,
    load: LoadRange | None = None,
    has_reference: bool = True,
    motors: Mapping[str, DriveTrain] | None = None,
    whole: DriveTrain | None = None,
    motor_limits: MotorLimits | None = None,
    advice: bool = True,
    progress: Told = silent,
) -> Analysis:
    """Analyse a drive over a range of speeds, or at single ones.

    Parameters
    ----------
    system : Oscillator or VaryingOscillator
        The error equation; its omega is replaced by the speeds.
    speeds : Speeds
        The range, or the single speeds; where the base angle is the motor's, its speed is the gear's input speed.
    gear : Gear, optional
        Record whose limits the run is compared with.
    train : DriveTrain, optional
        The whole train at constant speed, where the error equation leaves something of it out.
    rated_torque : float, optional
        Rated torque [N*m], full load of the hysteresis loop.
    limit : float, optional
        Largest oscillation of the error [rad] that the drive may have, for the speeds to avoid.
    source : Source, optional
        What the error equation is made of, for what would help.
    load : LoadRange, optional
        Torques of the load, where it has a range of them.
    has_reference : bool
        Whether the motor follows a reference motion: not that of an error equation with a free motor.
    motors : mapping of str to DriveTrain, optional
        The train with each motor that the drive may have, where that is not known.
    whole : DriveTrain, optional
        The whole train also where the error equation leaves nothing out, for the torque of the motor.
    motor_limits : MotorLimits, optional
        Largest torque and speed of the motor, which the verdict judges.
    advice : bool
        Whether it is computed what would help.
    progress : callable
        Told before every step what is done now, and the share of the work that is done; default: nobody.

    Raises
    ------
    ValueError
        If the motor is free and the train has parts that the error equation leaves out.
    SolveError
        If the law cannot carry the mean torque, or no simulation finishes.
    """
    if train is not None:
        refuse_free(train)
    limits = speeds.limits
    system = system._replace(omega=0.5 * (limits[0] + limits[1]))
    progress("operating point and stability", 0.0)
    point = operating_point(system)
    stability = _proof(system, point)
    progress("response curve", 0.02)
    exact = exact_response(system, limits, coexisting=train is None or searched(system.law))
    found, close = _resonances(system, limits, point, exact, progress)
    sweep = run_up(system, limits, exact, point, lambda share: progress("run-up and run-down", 0.4 + 0.2 * share))
    if not any(motion.status for motion in (*sweep.up, *sweep.down)):
        raise SolveError(f"no simulated speed reached a steady motion: {sweep.up[0].message}")
    cases = _in_time(system, speeds, point, found, sweep, progress)
    single = tuple(case.omega for case in cases)
    study = None if train is None else _whole_train(train, system, limits, point, exact, single, gear, progress)
    curve, ramp = (None, None) if study is None else (study.curve, study.run_alone)
    drive = of_equation(system, exact, has_reference, None if train else whole) if curve is None else curve
    avoid = speeds_to_avoid(system, drive.response, point, limit, None if ramp is None else in_run(*ramp))
    by_load: tuple[LoadCase, ...] = ()
    if load is not None:
        alone = speeds_to_avoid(system, drive.response, point, limit)  # without the run-up
        as_it_is = LoadCase(load.own, drive, alone)
        by_load = load_cases(load, limits, limit, as_it_is, lambda t: progress(f"load torque {t:.4g} N*m", 0.86))
        avoid = over_all(avoid, by_load)
    others = motor_cases(motors or {}, limits, lambda name: progress(f"motor {name}", 0.87))
    progress("hysteresis and varying stiffness", 0.88)
    used = most_used(_used(system, exact, sweep, cases, study), *(case.drive.usage for case in by_load))
    loop, no_loop = loop_of(system.law, used.peak_torque, rated_torque)
    parametric, not_searched = parametric_of(system, limits)
    if advice:
        progress("what would help", 0.9)
    subject = Subject(system, None if curve is None else train, limits, source)
    motor = _asked_of_motor(drive, by_load, study)
    findings = limit_findings(gear, used, speeds.given[-1] if speeds.by_motor else None, motor_limits, motor)
    helps, not_tried = (
        what_helps(subject, drive, avoid, by_load, load, used, lambda what: progress(f"what would help: {what}", 0.9))
        if advice
        else ((), ())
    )
    change = smallest_change(subject, drive, avoid, by_load, load, used.peak_torque, helps)
    curves = tuple(case.drive for case in by_load) or (drive,)
    verdict = verdict_of(limits, curves, avoid, used, findings, change, motor)
    return Analysis(
        system, limits, point, stability, found, exact, close, sweep, cases, drive, by_load, others, used, findings,
        loop, parametric, study, avoid, helps, not_tried, verdict, (*no_loop, *not_searched),
        tuple(implausible(gear, rated_torque, loop, used)), motor,
    )  # fmt: skip


def _resonances(
    system: Any, limits: tuple[float, float], point: OperatingPoint, exact: ExactResponse, progress: Told
) -> tuple[tuple[Regime, ...], dict[Resonance, ExactResponse]]:
    """Resonances with their maxima, and the curve once more around those that are too narrow for its points."""
    progress("resonances by multiple scales", 0.2)
    found = regimes(system, point, limits)
    close = {}
    for near in (regime for regime in found if _narrow(regime, exact)):
        progress(f"response curve around the {near.name}", 0.3)
        close[near.resonance] = exact_response(system, near.band(), FINE, coexisting=searched(system.law))
    return with_tops(found, system, exact, close), close


def _in_time(
    system: Any, speeds: Speeds, point: OperatingPoint, found: tuple[Regime, ...], sweep: RunUp, progress: Told
) -> tuple[TimeCase, ...]:
    """Single speeds in time."""
    chosen, cases = speeds_in_time(found, sweep, speeds.limits, speeds.single), []
    for i, (name, omega, regime) in enumerate(chosen):
        progress(f"{name} in time", 0.6 + 0.2 * i / len(chosen))
        resonance = NONRESONANT if regime is None else regime.resonance
        cases.append(time_case(name, system._replace(omega=omega), resonance, point))
    return tuple(cases)


def _whole_train(
    train: DriveTrain, system: Any, limits: tuple[float, float], point: OperatingPoint, exact: ExactResponse,
    single: tuple[float, ...], gear: Gear | None, progress: Told,
) -> TrainStudy:  # fmt: skip
    """The whole drive train beside its error equation."""
    progress("whole drive train", 0.8)
    curve = train_curve(train, limits) if has_curve(train) else None
    return train_study(
        train, system, limits, curve, exact, point, single, gear,
        lambda part: progress(f"whole drive train: {part}", 0.85),
    )  # fmt: skip


def _used(
    system: Any, exact: ExactResponse, sweep: RunUp, cases: tuple[TimeCase, ...], study: TrainStudy | None
) -> Usage:
    """What the gear is asked for: by the whole train and its run-up, or by the error equation without its curve."""
    if study is None or study.curve is None:
        used = usage(system, exact, (*sweep.up, *sweep.down, *(case.steady for case in cases)))
    else:
        used = study.curve.usage
    return used if study is None or study.ramp is None else study.ramp.added_to(used)


def _asked_of_motor(
    drive: DriveResponse, by_load: tuple[LoadCase, ...], study: TrainStudy | None
) -> MotorUse | None:  # fmt: skip
    """What the steady motions under every load, and the run-up, ask of the motor."""
    steady = [use and use._replace(load=case.torque) for case in by_load for use in (case.drive.motor,)]
    ramp = None if study is None or study.ramp is None else study.ramp.motor()
    return most_asked([*(steady or [drive.motor]), ramp])


def _proof(system: Any, point: OperatingPoint) -> StabilityProof:
    """Lyapunov's certificate, or why this law has none."""
    if is_spring(system):
        return lyapunov(system)
    obstacle = Obstacle(
        "the law of the gear has friction or memory",
        "Lyapunov's direct method with V(x, v) does not know its internal states; the multipliers of the computed "
        "response say which motions are stable",
    )
    return StabilityProof.refused(system, point.mean_torque, obstacle)


def _narrow(regime: Regime, exact: ExactResponse) -> bool:
    """Whether a resonance of the main branch has too few points of the response curve in its band."""
    if regime.response is None or not regime.response.branches or regime.resonance.q != 1:
        return False
    low, high = regime.band()
    return int(np.sum((exact.curve.omega > low) & (exact.curve.omega < high))) < FEWEST
