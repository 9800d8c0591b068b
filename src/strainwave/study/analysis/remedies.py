"""`remedies`: the peak of the error computed again with one number changed at a time.

A thing is changed by 10 %, and by 30 % where that changes the oscillation by less than 1 %; of two directions the one
that helps is kept. Changes of their own are a cancelled line and the next size and ratios of the gear's series.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from math import pi, sin, sqrt
from typing import Any

from ...base.number_text import number
from ...base.protocols import Law, lines_of
from ...base.results import SolveError
from ...base.sentences import listed
from ...base.terminal import silent
from ...drive.drive_response import DriveResponse
from ...drive.project import Project
from ...model.error_spectrum import accuracy_spectrum
from ...model.excitation import KinematicError
from ...model.gears import catalogue
from ...model.gears.gear import Gear
from ...model.orders import order_pair
from ..speed_map.avoid import Avoid
from .design_variables import DAMPING, DesignVariable, Subject, design_variables
from .load_cases import AtTorque, largest_case

CANCELLED = -1.0  # share of a line that nothing excites any more: it helps by definition, and is told apart
NO_EFFECT = 0.005  # relative change that is called none
LITTLE_EFFECT = 0.01  # relative change of the oscillation below which the larger change is tried
PEAK_RANGE = 0.25  # of the speed of the peak: how far laws with memory are followed about it
MOST_DRIVES, MEMORY_DRIVES = 60, 12  # changed drives that are followed, and of a law with memory, which take longer
MARGIN = 0.99  # of the limit, which a change has to reach: the short curve that judges it is within 1 %
DAMPING_DOUBT = -1.0 / 3.0, 2.0 / 3.0  # relative changes of an assumed damping: from 3 % of critical to 2 and 5 %
LOST_SHARE = 0.99  # of the largest oscillation: less than this without coexisting motions, and they are looked for
PEAK_SHIFT, PEAK_FALL = 0.1, 0.7  # relative change of the peak's speed, and the peak over that before: beyond, likewise


def other_gears(subject: Subject) -> Iterator[DesignVariable]:
    """The neighbours of a drive's gear in the catalogue, each as one change."""
    project = subject.project
    if project is None or project.gear is None:
        return
    for what, gear in neighbours(project.gear):
        yield DesignVariable(what, 0.0, gear.name, partial(with_gear, subject, project, gear), (1.0,), (0.0,))


def neighbours(gear: Gear) -> list[tuple[str, Gear]]:
    """Next size of the same ratio, next larger and next smaller ratio of the same size, where there are any."""
    sized = [g for g in catalogue.select(series=gear.series) if None not in (g.size, g.K1, g.K2, g.K3, g.T1, g.T2)]
    if gear not in sized:
        return []
    size = _size(gear)
    bigger = [g for g in sized if g.ratio == gear.ratio and _size(g) > size]
    same = [g for g in sized if g.size == gear.size]
    more, less = [g for g in same if g.ratio > gear.ratio], [g for g in same if g.ratio < gear.ratio]
    options = [
        ("next size of the gear", min(bigger, key=_size, default=None)),
        ("next larger ratio of the gear", min(more, key=_size, default=None)),
        ("next smaller ratio of the gear", max(less, key=_size, default=None)),
    ]
    return [(what, other) for what, other in options if other is not None]


def _size(gear: Gear) -> tuple[int, int]:
    """Size and ratio: the place of a gear in its series."""
    return gear.size or 0, gear.ratio


def with_gear(subject: Subject, project: Project, gear: Gear, _share: float = 0.0) -> Subject | str:
    """The drive with another gear of the catalogue, or why it cannot have it."""
    drive, old, by_motor = project.drive, project.gear, project.speeds.by_motor
    assert old is not None
    ratio = float(gear.ratio) if project.arrangement is None else abs(float(project.arrangement.ratio(gear.ratio)))
    faster = ratio / drive.N if by_motor else 1.0
    low, high = faster * subject.speeds[0], faster * subject.speeds[1]
    if not _contains(drive.law, old.law):
        return "the torsion law of the drive is not that of the catalogue"
    if by_motor and gear.max_speed is not None and high > gear.max_speed:
        return f"its input speed is limited to {gear.max_rpm:g} rpm"
    J_m = drive.J_m
    if gear.input_inertia is not None and old.input_inertia is not None:
        J_m += gear.input_inertia - old.input_inertia
    if not J_m > 0.0:
        return "the motor's inertia is less than that of its gear's wave generator"
    swap = drive._replace(J_m=J_m, N=ratio, law=with_part_swapped(drive.law, old.law, gear.law))
    inertia, before = (swap.J, drive.J) if project.motor == "free" else (swap.J_l, drive.J_l)
    other = swap._replace(B=drive.B * sqrt(gear.law.K1 / old.law.K1 * inertia / before))
    changed = subject.of_drive(other)._replace(speeds=(low, high))
    if subject.train is not None:
        train = subject.train._replace(N=ratio, B=other.B, law=other.law)
        changed = changed._replace(train=train.with_motor(J=J_m))  # its loop keeps its gains
    error = _error_with_gear(subject.model.error, old, gear, drive.N, ratio)
    return changed.with_model(changed.model._replace(error=error))


def _contains(law: Law, part: Any) -> bool:
    """True if a law is another one, or made of it."""
    if type(law) is type(part) and law == part:
        return True
    return isinstance(law, tuple) and any(_contains(item, part) for item in law)


def with_part_swapped(law: Law, old: Any, new: Any) -> Any:
    """A law with another one in the place of one of its parts."""
    if type(law) is type(old) and law == old:
        return new
    parts: Any = law
    if not hasattr(law, "_fields"):
        return law
    return parts._replace(**{name: with_part_swapped(part, old, new) for name, part in parts._asdict().items()})


def _error_with_gear(error: Any, old: Gear, gear: Gear, before: float, ratio: float) -> Any:
    """The same kinematic error, or that of the new gear's accuracy class where it was that of the old one's.

    Lines of the output's turn keep their repeats in it: their orders follow from the ratio, which was another `before`.
    """
    printed, new = old.accuracy, gear.accuracy
    if printed and new and lines_of(error) == accuracy_spectrum(printed).lines:
        return accuracy_spectrum(new)
    lines = [(line, *order_pair(line.order, before)) for line in lines_of(error)]
    if not lines:
        return error
    return KinematicError(tuple(line._replace(order=j + k / ratio if k else j) for line, j, k in lines))


@dataclass(frozen=True)
class Remedy:
    """Effect of a change of one number on the largest oscillation.

    Attributes
    ----------
    what : str
        The thing that is changed.
    share : float
        Relative change of the thing, 0.1 or -0.3; -1 of a line that is cancelled, 0 of a preload or a gear.
    by : float
        Change of a preload [N*m]; 0 of the others.
    ratio : float
        Largest oscillation over that without the change.
    at : float
        Speed [rad/s] of it.
    before, after : float or None
        What the thing is and what it becomes, in `unit`; None of a gear, and of a stiffness of 0 at rest.
    unit : str
        The unit in which engineers give the thing.
    gear : str
        Name of another gear; empty of all else.
    exceeds : bool or None
        Whether the oscillation is still above the limit of the drive; None where it has no limit, or is within 1 %
        below it.
    """

    what: str
    share: float
    by: float
    ratio: float
    at: float
    before: float | None = None
    after: float | None = None
    unit: str = ""
    gear: str = ""
    exceeds: bool | None = None

    @property
    def helps(self) -> bool:
        """True if it leaves less oscillation."""
        return self.ratio < 1.0 - NO_EFFECT

    @property
    def change(self) -> str:
        """Size of the change, in words."""
        if self.gear:
            return f"{self.gear} instead"
        if self.by:
            return f"{number(self.by, 3)} N·m more"
        if self.share == CANCELLED:
            return "cancelled by feed-forward"
        return f"{number(100.0 * abs(self.share))} % {'more' if self.share > 0.0 else 'less'}"

    def __str__(self) -> str:
        if self.gear:
            return f"{self.what}, {self.gear}"
        if self.share == CANCELLED:
            return f"{self.what} {self.change}"
        return f"{self.change} {'mean torque' if self.by else self.what}"


def with_other_damping(subject: Subject, drive: DriveResponse, avoid: Avoid) -> tuple[Remedy, ...]:
    """The largest oscillation with less and with more damping (`DAMPING_DOUBT`); empty of a gear without damping."""
    trial = Trial.of(subject, drive, avoid)
    variable = next((k for k in every_variable(subject, drive, 0.0) if k.what == DAMPING), None)
    if trial is None or variable is None:
        return ()
    changed = [(share, variable.changed_by(share)) for share in DAMPING_DOUBT]
    tried = [trial.remedy(variable, share, other) for share, other in changed if not isinstance(other, str)]
    return tuple(remedy for remedy in tried if remedy is not None)


def at_worst(
    subject: Subject, drive: DriveResponse, avoid: Avoid, cases: tuple[AtTorque, ...]
) -> tuple[Subject, DriveResponse, Avoid]:
    """The drive under the load torque of the largest oscillation; as it is where the load has one torque."""
    worst = largest_case(cases)
    if worst is None:
        return subject, drive, avoid
    return under(subject, worst.torque), worst.drive, worst.avoid or avoid


def under(subject: Subject, torque: float) -> Subject:
    """The drive of a project under one constant torque [N*m] of its load."""
    assert subject.project is not None
    loaded = subject.project.under(torque)
    train = None if subject.train is None else loaded.train or loaded.whole
    return subject._replace(system=loaded.system(subject.system.omega, reduced=True), train=train, load_torque=torque)


def remedies(
    subject: Subject,
    response: DriveResponse,
    avoid: Avoid,
    torque: float,
    progress: Callable[[str], None] = silent,
    drives: int | None = None,
) -> tuple[tuple[Remedy, ...], tuple[str, ...]]:
    """Compute the peak again with one thing changed at a time.

    Parameters
    ----------
    subject : Subject
        The drive, with its range of the base-angle speed [rad/s].
    response, avoid : DriveResponse, Avoid
        Its curve and its largest oscillation.
    torque : float
        Largest torque in the gear [N*m]; 10 % of it is the change of the preload.
    progress : callable
        Told every change before it is tried.
    drives : int, optional
        Changed drives after which nothing more is begun; what is left out is named. Default: `MOST_DRIVES`, or
        `MEMORY_DRIVES` where the law has memory.

    Returns
    -------
    tuple of Remedy
        The most helpful first.
    tuple of str
        What was left out, and why.
    """
    trial = Trial.of(subject, response, avoid)
    if trial is None:
        return (), ("what would help: the peak of the oscillation was not found again",)
    allowance = Allowance.of(subject, drives)
    helpful, left, late = [], [], []
    for variable in every_variable(subject, response, torque):
        if allowance.left <= 0:
            late.append(variable.what)
            continue
        best, why = trial.best(variable, progress, allowance)
        if best is None:
            left.append(f"{variable.what}: {why}")
        else:
            helpful.append(best)
    if late:
        left.append(f"{listed(dict.fromkeys(late))}: not tried after {allowance.drives} other changes")
    return tuple(sorted(helpful, key=lambda remedy: remedy.ratio)), tuple(left)


def every_variable(subject: Subject, response: DriveResponse, torque: float) -> Iterator[DesignVariable]:
    """Everything that can be turned or exchanged on a drive with that curve and largest torque [N*m] in the gear."""
    top = response.largest_oscillation()
    waves: Any = response.curve if response.curve.waves is None else response.curve.waves

    def amplitude_in_turn(order: float) -> float:  # of the motor: a wave of the output's turn drifts a little
        return float(waves.amplitude(order)[top]) * sin(pi * min(order, 0.5))

    return chain(other_gears(subject), design_variables(subject, amplitude_in_turn, torque))


@dataclass
class Allowance:
    """Count of changed drives that may be followed, so that every machine finds the same."""

    drives: int
    left: int

    @classmethod
    def of(cls, subject: Subject, drives: int | None = None) -> "Allowance":
        """That of a drive, or a given one."""
        drives = (MEMORY_DRIVES if subject.has_memory else MOST_DRIVES) if drives is None else drives
        return cls(drives, drives)

    def take(self) -> bool:
        """Use one up, and say whether there was one."""
        self.left -= 1
        return self.left >= 0


@dataclass(frozen=True)
class Trial:
    """Method by which changed drives are followed, and the largest oscillation without a change.

    Attributes
    ----------
    speeds : (float, float)
        Range of the speed [rad/s] through which they are followed.
    harmonics : int
        Of the curve.
    coexisting : bool
        Whether coexisting motions are looked for.
    pairs : tuple of (int, int)
        Waves of motions that beat; empty of others.
    before : (float, float)
        Speed [rad/s] and size [rad] of the largest oscillation without a change.
    avoid : Avoid
        Speeds to avoid without a change.
    """

    speeds: tuple[float, float]
    harmonics: int
    coexisting: bool
    pairs: tuple[tuple[int, int], ...]
    before: tuple[float, float]
    avoid: Avoid

    @classmethod
    def of(cls, subject: Subject, response: DriveResponse, avoid: Avoid) -> "Trial | None":
        """Follow a drive without a change; None where that finds no motion."""
        speeds = subject.speeds
        if subject.has_memory:
            speeds = max(speeds[0], (1.0 - PEAK_RANGE) * avoid.at), min(speeds[1], (1.0 + PEAK_RANGE) * avoid.at)
        harmonics = response.curve.coefficients.shape[1] // 2
        same, waves = subject._replace(speeds=speeds), response.curve.waves
        if waves is not None:  # of motions that beat one curve is followed, and this is it
            pairs = tuple(map(tuple, waves.pairs[1:].tolist()))
            return cls(speeds, harmonics, True, pairs, (avoid.at, avoid.largest), avoid)
        for coexisting in (bool(response.curve.elsewhere), True):
            before = same.largest(harmonics, coexisting, ())
            if before is not None and (coexisting or before[1] > LOST_SHARE * avoid.largest):
                return cls(speeds, harmonics, coexisting, (), before, avoid)
        return None

    def best(
        self, variable: DesignVariable, progress: Callable[[str], None], allowance: Allowance
    ) -> tuple[Remedy | None, str]:  # fmt: skip
        """The most helpful change of one thing, which is finished once it is begun; without one, why."""
        tried, reason = [], ""
        for sign in variable.signs:
            for size in variable.changes:
                share = sign * size
                progress(f"{variable.what}, {share:+.0%}" if share else variable.what)
                changed = variable.changed_by(share)
                if isinstance(changed, str):
                    reason = changed
                    break
                allowance.take()
                remedy = self.remedy(variable, share, changed)
                if remedy is None:
                    reason = "no steady motion was found with the change"
                    break
                tried.append(remedy)
                if abs(remedy.ratio - 1.0) >= LITTLE_EFFECT:
                    break
            if tried and tried[-1].ratio < 1.0 - LITTLE_EFFECT:
                break
        return min(tried, key=lambda remedy: remedy.ratio, default=None), reason

    def largest(self, changed: Subject) -> tuple[float, float] | None:
        """Speed [rad/s] and size [rad] of the largest oscillation of a changed drive.

        Coexisting motions are looked for where the peak has left its place or has fallen by more than 30 %: a
        change that moves a fold out of the range of speeds leaves a curve that never meets the large motion.
        """
        top = changed.largest(self.harmonics, self.coexisting, self.pairs)
        if top is None or self.coexisting:
            return top
        moved = abs(top[0] / self.before[0] - 1.0) > PEAK_SHIFT or top[1] < PEAK_FALL * self.before[1]
        return changed.largest(self.harmonics, True, self.pairs) if moved else top

    def remedy(self, variable: DesignVariable, share: float, changed: Subject) -> Remedy | None:
        """Effect of a change of one number by a share; None where no steady motion is found with it."""
        try:
            after = self.largest(changed if share == 0.0 else changed._replace(speeds=self.speeds))
        except SolveError:  # its law cannot carry the mean torque
            return None
        if after is None:
            return None
        ratio, limit = after[1] / self.before[1], self.avoid.limit
        step = share * variable.by if variable.by else 0.0
        size = ratio * self.avoid.largest
        exceeds = None if limit is None or MARGIN * limit < size <= limit else size > limit
        remedy = Remedy(variable.what, 0.0 if step else share, step, ratio, after[0], exceeds=exceeds)
        if share == 0.0:
            return replace(remedy, gear=variable.unit)
        if not step and not variable.value:  # a stiffness of nothing at rest, with backlash
            return remedy
        value = variable.value + step if step else (1.0 + share) * variable.value
        return replace(remedy, before=variable.value, after=value, unit=variable.unit)
