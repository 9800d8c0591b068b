"""Verdict on a drive at its speeds, and the smallest change of one number that brings it under its limit.

The verdict goes by the oscillation of its error and by what the gear is asked for. On one curve of a drive, where no
analysis follows the others, it is decided as `analyze` decides.

Every step that is named was computed, under every load torque that has a curve. Steps are whole percents. Where none
suffices, what can only be exchanged is taken if it does: a line that is cancelled, another gear, a preload.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from math import ceil, copysign, exp, inf, isfinite, log1p
from math import log as ln
from typing import NamedTuple

from ...base.results import SolveError
from ...base.sentences import Angle, Sentence, Speed, listed
from ...drive.demands.motor_limits import Need
from ...drive.demands.usage import MotorUse, Usage, limit_findings
from ...drive.drive_response import DriveResponse
from ...drive.postures import titled
from ...drive.project import Project
from ...model.gears.limits import Finding, gravest
from ..speed_map.avoid import Avoid, out_of_reach, sees_load, speeds_to_avoid
from ..speed_map.error_equation import operating_point
from ..speed_map.intervals import Span, between, merged
from ..speed_map.ratings import with_ratings
from ..speed_map.rules import bands_of, beyond_sheet, rules_of
from ..speed_map.under_load import motions_of_curve
from .design_variables import DesignVariable, Subject
from .remedies import MARGIN, Allowance, Remedy, Trial, every_variable

TIE_RATIO = 1.001  # relative difference of two largest errors below which the steady one is named


class Answer(StrEnum):
    """Answer of the verdict."""

    ALL_RIGHT = "pass"
    BUT = "pass except at some speeds"
    NOT = "fail"


@dataclass(frozen=True)
class Verdict:
    """Verdict on a drive at its speeds, and the smallest change that brings its oscillation under the limit.

    Attributes
    ----------
    answer : Answer
        `BUT` where everything that is wrong is wrong at `speeds` alone.
    speeds : tuple of (float, float)
        Speeds of the base angle [rad/s] to keep out of: those to avoid, and those where a limit of the gear or the
        motor is passed.
    allowed : tuple of (float, float)
        The others of the range [rad/s].
    exceeded : tuple of Finding
        Limits of the gear and of the motor by which the drive fails; a mean speed above that of a duty cycle is none.
    change : Remedy or None
        The smallest change of those tried that brings the largest oscillation under its limit.
    fault : str
        That the motor's loop is unstable, which forbids every speed; empty where it is not.
    """

    answer: Answer
    speeds: tuple[Span, ...]
    allowed: tuple[Span, ...]
    exceeded: tuple[Finding, ...]
    change: Remedy | None = None
    fault: str = ""


def verdict_of(
    speeds: Span, bands: tuple[Span, ...], avoid: Avoid | None, usage: Usage, limits: tuple[Finding, ...],
    change: Remedy | None = None, motor: MotorUse | None = None, fault: str = "",
) -> Verdict:  # fmt: skip
    """Put together what is wrong with a drive and at which speeds.

    Parameters
    ----------
    speeds : (float, float)
        Range of the base-angle speed [rad/s].
    bands : tuple of (float, float)
        Speeds that are forbidden under any load.
    avoid : Avoid or None
        Those of them that its motions forbid; None where no motion is stable.
    usage : Usage
        Largest torques in the gear, which may be of motions that are on no curve.
    limits : tuple of Finding
        The run against each limit of the gear and of the motor.
    change : Remedy or None
        The smallest change that brings the oscillation under its limit.
    motor : MotorUse or None
        What the motions ask of the motor.
    fault : str
        That the motor's loop is unstable.
    """
    exceeded = tuple(finding for finding in limits if finding.fails)
    omegas = {usage.peak_torque: usage.at_peak, usage.average_torque: usage.at_average}
    if motor is not None:
        omegas[motor.torque] = motor.at
    exceeded_at = [omegas.get(f.value) if f.omega is None else f.omega for f in exceeded if f.unit != "rpm"]
    wider = [(low * (1.0 - 1e-9), high * (1.0 + 1e-9)) for low, high in bands]
    covered = all(p is not None and any(low <= p <= high for low, high in wider) for p in exceeded_at)
    bands = (speeds,) if avoid is None or fault else bands
    allowed = between(bands, speeds)
    if not bands and not exceeded and avoid is not None:
        answer = Answer.ALL_RIGHT
    else:
        answer = Answer.BUT if allowed and covered and avoid is not None else Answer.NOT
    return Verdict(answer, bands, allowed, exceeded, None if fault else change, fault)


class Judged(NamedTuple):
    """Verdict on one curve of a drive.

    Attributes
    ----------
    verdict : Verdict
        Answer, and speeds to keep out of.
    passes : bool or None
        Whether the drive passes; None where the project has no limit of the oscillation and fails by nothing else, and
        where other torques of its load have curves of their own.
    avoid : Avoid or None
        Speeds to avoid for the oscillation alone.
    used, motor : Usage, MotorUse or None
        What gear and motor must take, and at least what every torque on the load takes at steady speed.
    findings : tuple of Finding
        The same against the limits of the gear and of the motor.
    jumps : bool
        Whether a drive with a limit of its oscillation fails by jumps of a slow run-up or run-down.
    whole : bool
        Whether the curve goes through the whole range.
    leaves : str
        Where the motion is not stable, a sentence; empty where it is everywhere.
    below : str
        That the limit is below the oscillation of slow rotation, a sentence; empty where not.
    fails : bool
        Whether the drive fails by that.
    """

    verdict: Verdict
    passes: bool | None
    avoid: Avoid | None
    used: Usage
    motor: MotorUse | None
    findings: tuple[Finding, ...]
    jumps: bool = False
    whole: bool = True
    leaves: str = ""
    below: str = ""
    fails: bool = False

    @property
    def covered(self) -> bool:
        """True if a stable motion is known at every speed, so that the largest oscillation is that of the range."""
        return self.whole and self.avoid is not None and not self.avoid.unstable

    @property
    def failures(self) -> tuple[str, ...]:
        """Limits of the oscillation, the gear and the motor by which the drive fails, one out of reach, and jumps."""
        jumps = "The oscillation jumps in a slow run-up or run-down." if self.jumps else ""
        over = "" if self.fails or self.avoid is None else _above_limit(self.avoid)
        texts = self.verdict.fault, self.below if self.fails else over, jumps, self.leaves
        return (*filter(None, texts), *(finding.sentence for finding in gravest(self.findings) if finding.fails))

    @property
    def remarks(self) -> tuple[str, ...]:
        """Sentences on limits that are passed without a failure."""
        below = [self.below] if self.below and not self.fails else []
        return (*below, *(finding.sentence for finding in gravest(self.findings) if not finding.fails))


def judged(project: Project, response: DriveResponse) -> Judged:
    """Judge the motions of a curve, under the mean torque of the load, by the rules of `analyze`."""
    N, mean, loads, speeds = project.drive.N, project.mean_load_torque, project.other_loads, project.speeds
    usage, motor = response.demands(mean, project.load_torques, N)
    need = response.need(tuple((mean - load) / N for load in (mean, *loads)))
    fastest, resting = speeds.given[-1] if speeds.by_motor else None, max(map(abs, project.load_torques)) / N
    findings = limit_findings(project.gear, usage, fastest, project.motor_limits, motor, (need,), resting)
    avoid, bands = _bands(project, response, need)
    verdict = verdict_of(speeds.limits, bands, avoid, usage, findings, None, motor, project.loop_fault)
    passes: bool | None = verdict.answer is Answer.ALL_RIGHT
    if project.limit is None:
        passes = False if verdict.fault or verdict.exceeded or avoid is None or avoid.unstable else None
    jumps = project.limit is not None and response.sweep is not None and bool(response.sweep.jumping)
    passes = passes if loads[0] == loads[1] or not passes else None
    leaves = "" if avoid is None else _unstable_sentence(project, avoid.unstable)
    reason = "" if avoid is None else out_of_reach(avoid.limit, avoid.slow, project.train)
    below = f"{reason[0].upper()}{reason[1:]}." if reason else ""
    fails = bool(below) and verdict.answer is not Answer.ALL_RIGHT and not sees_load(project.train)
    return Judged(
        verdict, passes, avoid, usage, motor, findings, jumps=jumps, whole=response.status.found, leaves=leaves,
        below=below, fails=fails,
    )  # fmt: skip


def _bands(project: Project, response: DriveResponse, need: Need | None) -> tuple[Avoid | None, tuple[Span, ...]]:
    """Speeds that the motions of a curve forbid, and the same with the limits of gear and motor, which has a `need`.

    None for a drive whose spring cannot hold its load, and where no motion is stable.
    """
    system, rules = project.system(reduced=True), rules_of(None, None, None, project.limit)
    try:
        avoid = speeds_to_avoid(system, response, operating_point(system), rules.limit)
    except (ValueError, SolveError):
        return None, ()
    if avoid is None:
        return None, ()
    span = response.curve.span
    rules, loaded = with_ratings(rules, project, span), motions_of_curve(response, avoid.slow)
    bands = bands_of(loaded, rules, span, (), 0.0).forbidden.tolist()
    return avoid, merged([*map(tuple, bands), *beyond_sheet(() if need is None else (need,), rules.sheet)])


def _above_limit(avoid: Avoid) -> str:
    """The largest oscillation of a curve that is above its limit; "" within it."""
    if avoid.limit is None or avoid.largest <= avoid.limit:
        return ""
    text = "The oscillation reaches {} at {}, above the limit of {}."
    return Sentence(text, Angle(avoid.largest), Speed(avoid.at, digits=5), Angle(avoid.limit))


def _unstable_sentence(project: Project, bands: Sequence[Span]) -> str:
    """Sentence on the speeds at which the motion of a curve is not stable; empty without bands."""
    speeds = project.speeds
    places = listed(f"{speeds.own(low):.5g} to {speeds.own(high):.5g}" for low, high in bands)
    follows = "the drive jumps to another motion, or its motion does not repeat with every turn"
    return f"The steady motion is unstable at {places} {speeds.own_unit}: {follows}." if bands else ""


class JudgedPosture(NamedTuple):
    """A posture of the machine: its number from 1 on, its name, inertia [kg*m^2] and torque [N*m], and its answer.

    `peak` is its largest oscillation [rad], nan where no motion is stable, and `omega` the base-angle speed [rad/s].
    `exceeded` are the limits of gear and motor that it passes.
    """

    number: int
    name: str
    inertia: float
    torque: float
    answer: Answer
    peak: float
    omega: float
    exceeded: tuple[Finding, ...] = ()

    @property
    def title(self) -> str:
        """Its number and name."""
        return titled(self.number, self.name)

    @property
    def rank(self) -> tuple[int, float]:
        """Place in the order from the best posture to the worst: by the answer, then by the oscillation."""
        return list(Answer).index(self.answer), self.peak if self.peak > 0.0 else inf


HELP_RATIO = 0.99  # relative oscillation below which a thing is followed further
MOST_THINGS, MOST_STEPS = 3, 5  # things of which the step is searched, beside those that suffice; and steps of each
LEAST_CHANGE, MOST_CHANGE = -0.5, 1.0  # relative changes beyond which none is searched, but for what can be cancelled


def smallest_change(
    subject: Subject, curve: DriveResponse, avoid: Avoid, loaded: Sequence[Subject], torque: float,
    tried: tuple[Remedy, ...],
) -> Remedy | None:  # fmt: skip
    """Find the smallest step that suffices, beginning with what the remedies that were tried do.

    Parameters
    ----------
    subject : Subject
        The drive as it is, under the torque of its load with the largest oscillation.
    curve, avoid : DriveResponse, Avoid
        Its curve, and its speeds to avoid with the limit of its oscillation [rad].
    loaded : sequence of Subject
        The drive under all torques of its load, where it has a range of them.
    torque : float
        Largest torque in the gear [N*m].
    tried : tuple of Remedy
        What one step of each thing does.

    Returns
    -------
    Remedy or None
        None where the limit is not exceeded or not given, and where no change that suffices was found.
    """
    trial = Trial.of(subject, curve, avoid) if tried else None
    if trial is None or avoid.limit is None or avoid.largest <= avoid.limit:
        return None
    allowance, limit = Allowance.of(subject), MARGIN * avoid.limit
    ratio = limit / avoid.largest
    all_variables = list(every_variable(subject, curve, torque))
    helpful = [remedy for remedy in tried if _stepwise(remedy) and remedy.ratio < HELP_RATIO]
    steps: list[Remedy] = []
    enough = sum(remedy.ratio <= ratio for remedy in helpful)
    for remedy in sorted(helpful, key=lambda remedy: abs(_needed_share(remedy, ratio)))[: max(MOST_THINGS, enough)]:
        least = -1.0 if any(other.what == remedy.what and other.share == -1.0 for other in tried) else LEAST_CHANGE
        steps += _steps(trial, _variable_of(remedy, all_variables), remedy, ratio, least, allowance)
    steps.sort(key=lambda remedy: (abs(remedy.share), remedy.ratio))
    steps += [remedy for remedy in tried if not _stepwise(remedy) and remedy.ratio <= ratio]
    others = [one for one in loaded if one.load_torque != subject.load_torque]
    other_variables = [list(every_variable(other, curve, torque)) for other in others]
    for remedy in steps:
        same = [_variable_of(remedy, variables) for variables in other_variables]
        if all(_keeps_limit(limit, trial, variable, remedy.share, allowance) for variable in same):
            return remedy
    return None


def _steps(
    trial: Trial, variable: DesignVariable, tried: Remedy, ratio: float, least: float, allowance: Allowance
) -> list[Remedy]:  # fmt: skip
    """Computed steps of one thing that reach a relative oscillation, as long as drives may be followed.

    Where the motion jumps the oscillation goes with no power: a step between one that fails and one that reaches it.
    """
    steps = [tried]
    for _ in range(MOST_STEPS):
        reaches = min((abs(step.share) for step in steps if step.ratio <= ratio), default=inf)
        fails = max((size for step in steps if (size := abs(step.share)) < reaches), default=0.0)
        share = copysign(_needed_share(steps[-1], ratio) if steps[-1].ratio < HELP_RATIO else 0.0, tried.share)
        if isfinite(reaches) and not fails < abs(share) <= reaches:
            share = copysign(ceil(round(50.0 * (fails + reaches), 6)) / 100.0, share)
        if not least <= share <= MOST_CHANGE or share == -1.0 or any(share == remedy.share for remedy in steps):
            break
        changed = variable.changed_by(share)
        if isinstance(changed, str) or not allowance.take():
            break
        after = trial.remedy(variable, share, changed)
        if after is None or (after.ratio >= HELP_RATIO and not isfinite(reaches)):
            break
        steps.append(after)
    return [remedy for remedy in steps if remedy.ratio <= ratio]


def _keeps_limit(limit: float, trial: Trial, variable: DesignVariable, share: float, allowance: Allowance) -> bool:
    """True if a change keeps the oscillation [rad] under another load torque within a limit."""
    changed = variable.changed_by(share)
    if isinstance(changed, str) or not allowance.take():
        return False
    try:
        top = trial.largest(changed)
    except SolveError:  # its law cannot carry the torque
        return False
    return top is not None and top[1] <= limit


def _needed_share(remedy: Remedy, ratio: float) -> float:
    """Share, in whole percents, with which an oscillation that goes with a power of the thing reaches a ratio."""
    share = exp(min(log1p(remedy.share) * ln(ratio) / ln(remedy.ratio), 10.0)) - 1.0
    return copysign(ceil(round(100.0 * abs(share), 6)) / 100.0, share)


def _stepwise(remedy: Remedy) -> bool:
    """True if the thing can be changed by any share."""
    return not remedy.by and remedy.share not in (0.0, -1.0)


def _variable_of(remedy: Remedy, design_variables: list[DesignVariable]) -> DesignVariable:
    """Number that a remedy has changed."""
    cancelled = remedy.share == -1.0
    return next(k for k in design_variables if k.what == remedy.what and (k.changes == (1.0,)) == cancelled)
