"""`analyze`: stability, resonances, the response through the speed range, single speeds in time, and advice."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from ...base.blas import one_thread
from ...base.law import is_spring
from ...base.number_text import number
from ...base.results import SolveError
from ...base.sentences import Angle, Sentence, Speed
from ...base.terminal import Progress, silent
from ...drive.demands.usage import MotorUse, Usage, largest_motor_use, largest_usage, limit_findings
from ...drive.drive_response import DriveResponse
from ...drive.friction.standstill import standing
from ...drive.project import Project
from ...drive.response import exact_response
from ...drive.speeds import Speeds
from ...drive.train_curve import refuse_free, unfollowed
from ...drive.two_turns import NONE_STABLE, beating_response
from ...model.oscillator import VaryingOscillator
from ...model.train.drive_train import DriveTrain
from ...numerics.curves.torus_motion import largest_sizes
from ...theory.lyapunov import lyapunov
from ...theory.parametric import ParametricResonance, parametric_resonances
from ...theory.resonance import NONRESONANT, Resonance
from ...theory.stability_proof import Obstacle, StabilityProof
from ..gear.hysteresis_loop import loop_of
from ..move.move import move
from ..move.result import Move
from ..speed_map.avoid import Avoid
from ..speed_map.decide import Decision, decide
from ..speed_map.error_equation import OperatingPoint, operating_point
from ..speed_map.intervals import complement, merged
from ..speed_map.motions import OMEGA, OSCILLATION
from ..speed_map.ramp import in_run
from ..speed_map.ratings import findings_under
from ..speed_map.rules import rules_of
from ..speed_map.under_load import seeks_coexisting
from .analysis import Analysis
from .cautions import implausible
from .design_variables import Subject
from .load_cases import AtTorque, avoid_under_all, load_cases
from .pace import Stage, paced
from .regimes import Regime, is_narrow, regimes, with_tops
from .remedies import Remedy, at_worst, remedies, under, with_other_damping
from .time_domain.beat import beat_of
from .time_domain.run_up_check import RunUp, run_up_and_down
from .time_domain.time_case import TimeCase, speeds_in_time, time_case, usage
from .train_study import TrainStudy, motor_cases, train_study
from .verdict import Answer, JudgedPosture, smallest_change, verdict_of

Advice = tuple[tuple[Remedy, ...], tuple[str, ...], Remedy | None, tuple[Remedy, ...]]
NO_ADVICE: Advice = (), (), None, ()

CURVES, STANDSTILL = 5 / 6, 11 / 12  # shares of the stage of the train at which they begin
LOOP, HELP, MOVE = 1 / 13, 3 / 13, 10 / 13  # shares of the stage of advice at which they begin
FINE_POINTS = 300  # points of a curve that is drawn for one resonance alone


@one_thread
def analyze(
    project: Project, progress: Progress | None = None, *, advice: bool = True, resonances: bool = True
) -> Analysis:
    """Analyse a drive over a range of speeds, or at single ones.

    Parameters
    ----------
    project : Project
        The drive, its speeds and what is asked of it.
    progress : callable, optional
        Told before every step what is done now, and the share of the work that is done.
    advice : bool
        Whether it is computed what would help.
    resonances : bool
        Whether they are computed by multiple scales; nothing of the verdict rests on them.

    Raises
    ------
    ValueError
        If the motor is free and the train has parts that the error equation leaves out.
    SolveError
        If the law cannot carry the mean torque, or no simulation finishes.
    """
    train, speeds, limit = project.train, project.speeds, project.limit
    progress = paced(project, progress or silent)
    if train is not None:
        refuse_free(train)
    system, limits = project.system(reduced=True), speeds.limits
    progress(Stage.POINT.text, Stage.POINT.at())
    point = operating_point(system)
    stability = _proof(system, point)
    progress(Stage.CURVE.text, Stage.CURVE.at())
    exact = project.equation_response(coexisting=train is None or seeks_coexisting(system.law))
    all_regimes, close, sweep, cases = _of_one_turn(project, system, point, exact, resonances, progress)
    single = tuple(case.omega for case in cases)
    study = None if train is None else _whole_train(project, train, system, point, exact, single, progress)
    curve, ramp = (None, None) if study is None else (study.curve, study.run_alone)
    drive = curve or exact
    progress(Stage.LOADS.text, Stage.LOADS.at())
    rules = rules_of(None, None, None, limit)
    decided = decide(project, rules, progress=lambda share: progress(Stage.LOADS.text, Stage.LOADS.at(share)))
    by_load = load_cases(project, decided)
    run = None if ramp is None else in_run(*ramp)
    avoid = None if unfollowed(train, curve) else avoid_under_all(drive, decided, by_load, limit, run)
    study = _with_gravity(project, study, (drive, *(case.drive for case in by_load)), progress) if advice else study
    motors = {} if project.motor_named else project.motors()
    other_motors = tuple(motor_cases(motors, limits, lambda name: progress(f"motor {name}", Stage.ADVICE.at())))
    progress("hysteresis and varying stiffness", Stage.ADVICE.at(LOOP))
    largest = largest_usage(_used(system, exact, sweep, cases, study), *(case.drive.usage for case in by_load))
    loop, no_loop = loop_of(system.law, largest.peak_torque, project.rated_torque)
    parametric, not_searched = _parametric_of(system, limits)
    followed = project.train or project.whole if exact.curve.beat else None if curve is None else train
    subject = Subject(system, followed, limits, project)
    motor = _asked_of_motor(drive, by_load, study)
    fastest = speeds.given[-1] if speeds.by_motor else None
    curves = tuple(case.drive for case in by_load) or (drive,)
    needs, resting = [curve.need() for curve in curves], _resting(decided)
    findings = limit_findings(project.gear, largest, fastest, project.motor_limits, motor, needs, resting)
    helps, not_tried, change, damped = (
        _advice(subject, drive, avoid, by_load, largest.peak_torque, progress) if advice and avoid else NO_ADVICE
    )
    fault = project.loop.fault if project.loop else ""
    verdict = verdict_of(limits, decided_bands(decided), avoid, largest, findings, change, motor, fault)
    postures = judged_postures(decided)
    answers = verdict.answer, *(row.answer for row in postures)
    verdict = replace(verdict, answer=max(answers, key=list(Answer).index))
    progress("the move of the project file", Stage.ADVICE.at(MOVE))
    moved, unmoved = _move_of(project)
    if moved is not None and moved.failures:
        verdict = replace(verdict, answer=Answer.NOT)
    return Analysis(
        system=system, speeds=limits, point=point, stability=stability, regimes=all_regimes, exact=exact, close=close,
        run_up=sweep, cases=cases, drive=drive, load_cases=by_load, motors=other_motors, usage=largest, limits=findings,
        loop=loop, parametric=parametric, train=study, avoid=avoid, remedies=helps, not_tried=not_tried,
        verdict=verdict, remarks=tuple(no_loop + not_searched + unmoved),
        doubts=tuple(implausible(project.gear, project.rated_torque, loop, largest)), motor=motor, other_damping=damped,
        postures=postures, beat=beat_of(project, drive), moved=moved, project=project,
    )  # fmt: skip


def _advice(
    subject: Subject,
    drive: DriveResponse,
    avoid: Avoid,
    by_load: tuple[AtTorque, ...],
    torque: float,
    progress: Progress,
) -> Advice:
    """Remedies under the torque with the largest oscillation, the one that suffices under all, and other damping."""

    def tell(what: str) -> None:
        progress(f"{Stage.ADVICE.text}: {what}", Stage.ADVICE.at(HELP))

    progress(Stage.ADVICE.text, Stage.ADVICE.at(HELP))
    worst = at_worst(subject, drive, avoid, by_load)
    helps, not_tried = remedies(*worst, torque, tell) if avoid.bands else ((), ())
    change = smallest_change(*worst, [under(subject, case.torque) for case in by_load], torque, helps)
    return helps, not_tried, change, with_other_damping(*worst)


def _resting(decided: Decision) -> float:
    """Torque [N*m, motor side] of the load at rest, the largest of all loads."""
    return max(abs(torque) / one.drive.N for one in decided.projects for torque in one.load_torques)


def decided_bands(decided: Decision) -> tuple[tuple[float, float], ...]:
    """Speeds [rad/s] that are forbidden under some load, or between two."""
    return merged(complement(decided.allowed, decided.span).tolist())


def judged_postures(decided: Decision) -> tuple[JudgedPosture, ...]:
    """Every posture of a project with its answer and its largest oscillation."""
    rows: list[JudgedPosture] = []
    for case, one, project, bands in zip(
        decided.load_cases, decided.by_load, decided.projects, decided.bands, strict=True
    ):
        if case.posture is None:
            continue
        answer = Answer.ALL_RIGHT if not len(bands.forbidden) else Answer.BUT if len(bands.allowed) else Answer.NOT
        exceeded = findings_under(project, one)
        if any(limit.fails for limit in exceeded):
            answer = Answer.NOT
        tops = [run[np.argmax(run[:, OSCILLATION])] for run, _ in one.runs]
        top = max(tops, key=lambda row: float(row[OSCILLATION]), default=np.full(2, math.nan))
        inertia, torque = float(project.drive.J_l), project.mean_load_torque
        first = len(rows) + 1, case.posture.name, inertia, torque, answer
        rows.append(JudgedPosture(*first, float(top[OSCILLATION]), float(top[OMEGA]), exceeded))
    return tuple(rows)


def _of_one_turn(
    project: Project, system: Any, point: OperatingPoint, exact: DriveResponse, resonances: bool, progress: Progress
) -> tuple[tuple[Regime, ...], dict[Resonance, DriveResponse], RunUp, tuple[TimeCase, ...]]:
    """Resonances, a simulated run-up, and single speeds in time, of motions that repeat with every turn.

    Where motions beat all of it is empty.
    """
    if exact.curve.beat:
        if project.train is None and exact.sweep is None:
            raise SolveError(NONE_STABLE)
        return (), {}, RunUp((), (), np.empty(0), np.empty(0)), ()
    limits = project.speeds.limits
    all_regimes, close = _resonances(system, limits, point, exact, progress) if resonances else ((), {})
    sweep = run_up_and_down(
        system, limits, exact, point, lambda share: progress(Stage.RUN_UP.text, Stage.RUN_UP.at(share))
    )
    return all_regimes, close, sweep, _in_time(system, project.speeds, point, all_regimes, sweep, progress)


def _resonances(
    system: Any, limits: tuple[float, float], point: OperatingPoint, exact: DriveResponse, progress: Progress
) -> tuple[tuple[Regime, ...], dict[Resonance, DriveResponse]]:
    """Resonances with their maxima, and the curve once more around those that are too narrow for its points."""
    progress(Stage.RESONANCES.text, Stage.RESONANCES.at())
    all_regimes = regimes(system, point, limits)
    close = {}
    for narrow in (regime for regime in all_regimes if is_narrow(regime, exact)):
        progress(f"response curve around the {narrow.name}", Stage.RESONANCES.at(0.5))
        close[narrow.resonance] = exact_response(
            system, narrow.band(), FINE_POINTS, coexisting=seeks_coexisting(system.law)
        )
    return with_tops(all_regimes, system, exact, close), close


def _in_time(
    system: Any, speeds: Speeds, point: OperatingPoint, regimes: tuple[Regime, ...], sweep: RunUp, progress: Progress
) -> tuple[TimeCase, ...]:
    """Single speeds in time."""
    chosen, cases = speeds_in_time(regimes, sweep, speeds.limits, speeds.single), []
    for i, (name, omega, regime) in enumerate(chosen):
        progress(f"motion in time, {name}", Stage.IN_TIME.at(i / len(chosen)))
        resonance = NONRESONANT if regime is None else regime.resonance
        cases.append(time_case(name, system._replace(omega=omega), resonance, point))
    return tuple(cases)


def _whole_train(
    project: Project, train: DriveTrain, system: Any, point: OperatingPoint, exact: DriveResponse,
    single: tuple[float, ...], progress: Progress,
) -> TrainStudy:  # fmt: skip
    """The whole drive train beside its error equation."""
    progress(Stage.TRAIN.text, Stage.TRAIN.at())
    study = train_study(
        train, system, project.speeds.limits, project.train_response(), exact, point, single=single, gear=project.gear,
        progress=lambda part: progress(f"{Stage.TRAIN.text}: {part}", Stage.TRAIN.at(CURVES)),
    )  # fmt: skip
    progress("standstill", Stage.TRAIN.at(STANDSTILL))
    resting = standing(project)
    if resting is None:
        return study
    return replace(study, resting=resting, remarks=(*study.remarks, *resting.sentences()))


def _with_gravity(
    project: Project, study: TrainStudy | None, curves: tuple[DriveResponse, ...], progress: Progress
) -> TrainStudy | None:
    """The study with the motions that have gravity exactly, where the curves of `quasi-static` torques leave it out."""
    if study is None or study.curve is None or not study.curve.without_angle:
        return study
    progress("gravity with its stiffness", Stage.ADVICE.at())
    try:
        exact = beating_response(project.whole, project.speeds.limits, project.limit)
    except (ValueError, SolveError) as error:
        sentence = Sentence("Gravity is computed as a constant torque at each load angle, not exactly: {}.", error)
        return replace(study, remarks=(*study.remarks, sentence))
    waves, visited = exact.curve.waves, exact.counted
    if waves is None or not len(visited):
        text = "With gravity as an exact function of the load angle, no steady motion is stable in this speed range."
        return replace(study, remarks=(*study.remarks, text))
    fast = waves.amplitudes[visited] * (1.0 - np.sinc(waves.orders))  # without the mean of a turn around each angle
    sizes = largest_sizes(fast, waves.pairs, project.drive.N)
    size, omega = float(np.max(sizes)), float(exact.omega[visited[np.argmax(sizes)]])
    change = 100.0 * (size / max(float(curve.oscillation[curve.top]) for curve in curves) - 1.0)
    text = "With gravity as an exact function of the load angle, the oscillation about the slow mean reaches "
    text += "{} at {}: {} % {} than with constant torques instead of gravity."
    difference = number(abs(change), 2), "more" if change > 0.0 else "less"
    sentence = Sentence(text, Angle(size), Speed(omega, digits=5), *difference)
    if exact.rounding:
        sentence += f" In this computation, {exact.rounding}."
    return replace(study, gravity=(omega, size), remarks=(*study.remarks, sentence))


def _used(
    system: Any, exact: DriveResponse, sweep: RunUp, cases: tuple[TimeCase, ...], study: TrainStudy | None
) -> Usage:
    """Torques of the gear: of the whole train and its run-up, or of the error equation without its curve."""
    if study is None or study.curve is None:
        used = usage(system, exact, (*sweep.up, *sweep.down, *(case.steady for case in cases)))
    else:
        used = study.curve.usage
    return used if study is None or study.ramp is None else study.ramp.added_to(used)


def _asked_of_motor(
    drive: DriveResponse, by_load: tuple[AtTorque, ...], study: TrainStudy | None
) -> MotorUse | None:  # fmt: skip
    """Demands of the steady motions under every load, and of the run-up, on the motor."""
    steady = [use and use._replace(load=case.torque) for case in by_load for use in (case.drive.motor,)]
    ramp = None if study is None or study.ramp is None else study.ramp.motor()
    return largest_motor_use([*(steady or [drive.motor]), ramp])


def _proof(system: Any, point: OperatingPoint) -> StabilityProof:
    """Lyapunov's certificate, or why this law has none."""
    if is_spring(system):
        return lyapunov(system)
    obstacle = Obstacle(
        "the torsion law of the gear has friction or hysteresis",
        "Lyapunov's direct method with V(x, v) has no term for the internal states of this law; the Floquet "
        "multipliers of the computed response show which motions are stable",
    )
    return StabilityProof.refused(system, point.mean_torque, obstacle)


def _parametric_of(system: Any, speeds: tuple[float, float]) -> tuple[tuple[ParametricResonance, ...], list[str]]:
    """Parametric resonances of a stiffness that varies, in a range of speeds [rad/s], or why none are searched for."""
    if not isinstance(system, VaryingOscillator):
        return (), []
    try:
        return tuple(parametric_resonances(system, speeds)), []
    except ValueError as error:
        return (), [Sentence("Parametric resonances are not searched for: {}.", error)]


def _move_of(project: Project) -> tuple[Move | None, list[str]]:
    """The move that the file of a project asks for, or why it is not computed."""
    if project.move is None or not project.move.profile:
        return None, []
    try:
        return move(project), []
    except (ValueError, SolveError) as error:
        return None, [Sentence("The move of the project file is not computed: {}.", error)]
