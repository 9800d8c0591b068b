"""The whole analysis of a drive: stability, resonances, response through the speed range, single speeds in time."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ...law import is_spring
from ...model.gears.gear import Gear
from ...model.gears.limits import Finding
from ...model.oscillator import Oscillator
from ...model.train.drive_train import DriveTrain
from ...model.varying import VaryingOscillator
from ...records import Labelled, Result
from ...results import SolveError
from ...sentences import on_screen
from ...speeds import Speeds
from ...theory.lyapunov import lyapunov
from ...theory.slow_flow.resonance import NONRESONANT, Resonance
from ...theory.stability_proof import Obstacle, StabilityProof
from ..gear.parametric import ParametricResonance
from ..response.by_integration import response_through
from ..response.resonances import OperatingPoint, Regime, operating_point, regimes
from ..response.response import ExactResponse
from .avoid import Avoid, in_run, speeds_to_avoid
from .cases import speeds_in_time
from .cautions import cautions
from .drive_response import DriveResponse, of_equation
from .gear_studies import GearLoop, loop_of, parametric_of
from .load_range import LoadCase, LoadRange, load_cases, over_all
from .motor_cases import MotorCase, motor_cases
from .plausible import implausible
from .remedies import Remedy, Source, Subject, what_helps
from .resonance_tops import with_tops
from .runup import RunUp, run_up, silent
from .time_case import TimeCase, time_case
from .train_curve import has_curve, refuse_free, train_curve
from .train_study import Ramp, TrainStudy, train_study
from .usage import Usage, limit_findings, most_used, usage

FEWEST, FINE = 20, 300  # points of the response curve in the band of a resonance, and of one drawn for it alone
LESS = 1.001  # relative difference of two largest errors below which the steady one is named


class Largest(NamedTuple):
    """The largest |error| [rad] of an analysis, the base-angle speed [rad/s] there, its motion and its method.

    `torque` is the constant torque [N*m] of the load there, where the drive has a range of them; None otherwise.
    """

    peak: float
    omega: float
    of: str
    method: str
    torque: float | None = None


@dataclass(frozen=True, eq=False)
class Analysis(Result):
    """Everything that the report shows about a drive.

    Attributes
    ----------
    system : Oscillator or VaryingOscillator
        The error equation at the middle of the range.
    speeds : (float, float)
        Range of the base-angle speed [rad/s].
    point : OperatingPoint
        Equilibrium under the mean torque.
    stability : StabilityProof
        Lyapunov's certificate of the drive without excitation.
    regimes : tuple of Regime
        Resonances of all excitation lines, by ascending speed.
    exact : ExactResponse
        Response of the error equation through the range, with stability, folds and jumps.
    close : dict of Resonance to ExactResponse
        The response once more around those resonances that are too narrow for the points of `exact`.
    run_up : RunUp
        Simulated run-up and run-down, its independent check.
    cases : tuple of TimeCase
        Single speeds in time.
    drive : DriveResponse
        Steady motions of the drive: of the whole train where there is a curve of it, else of the error equation.
    load_cases : tuple of LoadCase
        The same under the torques of the load's range, ascending; empty where it has one torque.
    motors : tuple of MotorCase
        The drive with other motors, where nothing says which it has; empty otherwise.
    usage : Usage
        What the steady motions ask of the gear: those of the whole drive train and its run-up, where there are any.
    limits : tuple of Finding
        The same against each limit of the gear's datasheet; empty for a gear that is given by its law alone.
    loop : GearLoop or None
        Hysteresis loop of a law with friction or memory.
    parametric : tuple of ParametricResonance
        Of a stiffness that varies, in the speed range.
    train : TrainStudy or None
        The whole drive train, where the error equation leaves something of it out.
    avoid : Avoid or None
        Speeds to avoid; None where no motion is stable.
    remedies : tuple of Remedy
        What would make the error smaller, the most helpful first; empty where no speed is to be avoided. Where the load
        has a range of torques they are for the torque with the largest oscillation.
    not_tried : tuple of str
        What else would have been tried, and why it was not.
    remarks : tuple of str
        Why a part is missing.
    doubts : tuple of str
        Results that no gear gives.
    """

    system: Oscillator | VaryingOscillator
    speeds: tuple[float, float]
    point: OperatingPoint
    stability: StabilityProof
    regimes: tuple[Regime, ...]
    exact: ExactResponse
    close: dict[Resonance, ExactResponse]
    run_up: RunUp
    cases: tuple[TimeCase, ...]
    drive: DriveResponse
    load_cases: tuple[LoadCase, ...]
    motors: tuple[MotorCase, ...]
    usage: Usage
    limits: tuple[Finding, ...]
    loop: GearLoop | None
    parametric: tuple[ParametricResonance, ...]
    train: TrainStudy | None
    avoid: Avoid | None
    remedies: tuple[Remedy, ...]
    not_tried: tuple[str, ...]
    remarks: tuple[str, ...]
    doubts: tuple[str, ...] = ()

    def coordinates(self) -> Labelled:
        """As of the response."""
        return self.response.coordinates()

    def variables(self) -> Labelled:
        """Those of the response that the drive's largest error is read from."""
        return self.response.variables()

    def __str__(self) -> str:
        worst, (low, high) = self.largest(), self.speeds
        lines = [
            f"Analysis: {low:.6g} .. {high:.6g} rad/s of the base angle, {len(self.regimes)} resonances",
            f"  largest {self.drive.name} {worst.peak:.6g} rad at {worst.omega:.6g} rad/s ({worst.of}, {worst.method})",
            f"  largest torque in the gear {self.usage.peak_torque:.6g} N*m at {self.usage.at_peak:.6g} rad/s",
            f"  {len(self.remedies)} remedies, {len(self.warnings)} warnings; `exact`, `train`, `avoid` and the others "
            "hold them",
        ]
        return on_screen("\n".join(lines))

    __repr__ = __str__

    @property
    def warnings(self) -> tuple[str, ...]:
        """Sentences about what went wrong or needs care."""
        return tuple(cautions(self))

    @property
    def train_curve(self) -> DriveResponse | None:
        """Steady motions of the whole drive train, where it has any that repeat."""
        return None if self.train is None else self.train.curve

    @property
    def run_alone(self) -> Ramp | None:
        """Run-up of the whole drive train, where it alone has all torques of it."""
        return None if self.train is None else self.train.run_alone

    @property
    def response(self) -> ExactResponse:
        """The curve that the drive's largest error is read from: of the whole train where there is one."""
        return self.drive.response

    @property
    def curves(self) -> tuple[tuple[float | None, DriveResponse], ...]:
        """Every curve of the drive, with the constant torque [N*m] of the load where it has a range of them."""
        return tuple((case.torque, case.drive) for case in self.load_cases) or ((None, self.drive),)

    def largest(self) -> Largest:
        """Largest |error| that a sweep meets, of the whole train where there is one: steady, or in its run-up.

        Of the error equation it is on the curve, or simulated where the curve has no motion as large.
        """
        of = "error equation" if self.train_curve is None else "whole drive train"
        found = []
        for torque, drive in self.curves:
            at = drive.response.largest()
            if at is not None:
                peak, omega = float(drive.peak[at]), float(drive.omega[at])
                found.append(Largest(peak, omega, of, drive.response.method, torque))
        best = max(found, key=lambda largest: largest.peak, default=None)
        if (ramp := self.run_alone) is not None:
            run = Largest(*ramp.largest(ramp.run.pointing), "run-up of the whole drive train", "integration")
            return run if best is None or self.train_curve is None or run.peak > LESS * best.peak else best
        worst = self.run_up.worst()
        if best is None or (self.train_curve is None and best.peak < worst.peak / LESS):
            return Largest(worst.peak, worst.omega, "error equation", "integration")
        return best

    def largest_oscillation(self) -> Largest:
        """Largest |error - mean| on the curves of the drive, where a slow run-up or run-down goes."""
        of = "error equation" if self.train_curve is None else "whole drive train"
        found = []
        for torque, drive in self.curves:
            visited, sizes = drive.visited(), drive.oscillation
            at = visited[int(np.argmax(sizes[visited]))]
            found.append(Largest(float(sizes[at]), float(drive.omega[at]), of, drive.response.method, torque))
        return max(found, key=lambda largest: largest.peak)


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
    progress: Callable[[str, float], None] = silent,
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
    exact = response_through(system, limits)
    progress("resonances by multiple scales", 0.2)
    found = regimes(system, point, limits)
    close = {}
    for near in (regime for regime in found if _narrow(regime, exact)):
        progress(f"response curve around the {near.name}", 0.3)
        close[near.resonance] = response_through(system, near.band(), FINE)
    found = with_tops(found, system, exact, close)
    sweep = run_up(system, limits, exact, point, lambda share: progress("run-up and run-down", 0.4 + 0.2 * share))
    if not any(motion.status for motion in (*sweep.up, *sweep.down)):
        raise SolveError(f"no simulated speed reached a steady motion: {sweep.up[0].message}")
    chosen = speeds_in_time(found, sweep, limits, speeds.single)
    cases = []
    for i, (name, omega, regime) in enumerate(chosen):
        progress(f"{name} in time", 0.6 + 0.2 * i / len(chosen))
        resonance = NONRESONANT if regime is None else regime.resonance
        cases.append(time_case(name, system._replace(omega=omega), resonance, point))
    study = None
    if train is not None:
        progress("whole drive train", 0.8)
        study = train_study(
            train, system, limits, train_curve(train, limits) if has_curve(train) else None, exact, point, gear,
            lambda part: progress(f"whole drive train: {part}", 0.85),
        )  # fmt: skip
    curve, ramp = (None, None) if study is None else (study.curve, study.run_alone)
    drive = of_equation(system, exact, has_reference) if curve is None else curve
    avoid = speeds_to_avoid(system, drive.response, point, limit, None if ramp is None else in_run(*ramp))
    by_load: tuple[LoadCase, ...] = ()
    if load is not None:
        as_it_is = LoadCase(load.own, drive, avoid)
        by_load = load_cases(load, limits, limit, as_it_is, lambda t: progress(f"load torque {t:.4g} N*m", 0.86))
        avoid = over_all(avoid, by_load)
    others = motor_cases(motors or {}, limits, lambda name: progress(f"motor {name}", 0.87))
    progress("hysteresis and varying stiffness", 0.88)
    motions = (*sweep.up, *sweep.down, *(case.steady for case in cases))
    used = usage(system, exact, motions) if curve is None else curve.usage
    used = most_used(used, *(case.drive.usage for case in by_load))
    if study is not None and study.ramp is not None:
        used = study.ramp.added_to(used)
    loop, no_loop = loop_of(system.law, used.peak_torque, rated_torque)
    parametric, not_searched = parametric_of(system, limits)
    progress("what would help", 0.9)
    subject = Subject(system, None if curve is None else train, limits, source)
    helps, not_tried = what_helps(
        subject, drive, avoid, by_load, load, used, lambda what: progress(f"what would help: {what}", 0.9)
    )  # fmt: skip
    return Analysis(
        system, limits, point, stability, found, exact, close, sweep, tuple(cases), drive, by_load, others, used,
        () if gear is None else limit_findings(gear, used, speeds.given[-1] if speeds.by_motor else None),
        loop, parametric, study, avoid, helps, not_tried, (*no_loop, *not_searched),
        tuple(implausible(gear, rated_torque, loop, used)),
    )  # fmt: skip


def _proof(system: Any, point: OperatingPoint) -> StabilityProof:
    """Lyapunov's certificate, or why this law has none."""
    if is_spring(system):
        return lyapunov(system)
    obstacle = Obstacle(
        f"{type(system.law).__name__} has friction or memory",
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
