"""What would make the error smaller: its peak computed again with one thing changed at a time.

A thing is changed by 10 %, and by 30 % where that changes the oscillation by less than 1 %; of two directions the one
that helps is kept. A line that is cancelled and another gear of the catalogue are changes of their own.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import chain

import numpy as np

from ....results import SolveError
from ....sentences import listed
from ...response.response import ExactResponse
from ..avoid import Avoid
from ..drive_response import DriveResponse
from ..load_range import LoadCase, LoadRange, worst_of
from ..runup import silent
from ..usage import Usage
from .knobs import Knob, knobs
from .other_gears import other_gears
from .peak import Top, largest
from .subject import Subject

LITTLE = 0.01  # relative change of the oscillation below which the larger change is tried
NEAR = 0.25  # of the speed of the peak: how far laws with memory are followed about it
MOST, WITH_MEMORY = 60, 12  # changed drives that are followed, and those whose law has memory, which take longer
LOST = 0.99  # of the largest oscillation: less than this without coexisting motions, and they are looked for


@dataclass(frozen=True)
class Remedy:
    """What a change of one thing does to the largest oscillation.

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
        Whether the oscillation is still above the limit of the drive; None where it has no limit.
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
    def per_unit(self) -> float | None:
        """Relative change of the oscillation for one `unit` more of the thing; None where there is no such number."""
        if self.before is None or self.after is None or self.after == self.before:
            return None
        return (self.ratio - 1.0) / (self.after - self.before)


def what_helps(
    subject: Subject, drive: DriveResponse, avoid: Avoid | None, cases: tuple[LoadCase, ...], load: LoadRange | None,
    used: Usage, progress: Callable[[str], None],
) -> tuple[tuple[Remedy, ...], tuple[str, ...]]:  # fmt: skip
    """Remedies of a drive that has speeds to avoid: under the load torque of the largest oscillation."""
    if avoid is None or not avoid.bands:
        return (), ()
    subject, drive, avoid = at_worst(subject, drive, avoid, cases, load)
    return remedies(subject, drive.response, avoid, used.peak_torque, progress)


def at_worst(
    subject: Subject, drive: DriveResponse, avoid: Avoid, cases: tuple[LoadCase, ...], load: LoadRange | None
) -> tuple[Subject, DriveResponse, Avoid]:
    """The drive under the load torque of the largest oscillation; as it is where the load has one torque."""
    worst = worst_of(cases)
    if load is None or worst is None:
        return subject, drive, avoid
    return under(subject, load, worst.torque), worst.drive, worst.avoid or avoid


def under(subject: Subject, load: LoadRange, torque: float) -> Subject:
    """The drive under one constant torque [N*m] of its load."""
    system, train = load.at(torque)
    system = system._replace(omega=subject.system.omega)
    return subject._replace(system=system, train=None if subject.train is None else train, load_torque=torque)


def remedies(
    subject: Subject,
    response: ExactResponse,
    avoid: Avoid,
    torque: float,
    progress: Callable[[str], None] = silent,
    most: int | None = None,
) -> tuple[tuple[Remedy, ...], tuple[str, ...]]:
    """Compute the peak again with one thing changed at a time.

    Parameters
    ----------
    subject : Subject
        The drive, with its range of the base-angle speed [rad/s].
    response, avoid : ExactResponse, Avoid
        Its curve and its largest oscillation.
    torque : float
        Largest torque in the gear [N*m]; 10 % of it is the change of the preload.
    progress : callable
        Told every change before it is tried.
    most : int, optional
        Changed drives after which nothing more is begun; what is left out is named. Default: `MOST`, or `WITH_MEMORY`
        where the law has memory.

    Returns
    -------
    tuple of Remedy
        The most helpful first.
    tuple of str
        What was left out, and why.
    """
    trial = Trial.of(subject, response, avoid)
    if trial is None:
        return (), ("what would help: the peak is not found again",)
    allowance = Allowance.of(subject, most)
    found, left, late = [], [], []
    for knob in every_knob(subject, response, torque):
        if allowance.left <= 0:
            late.append(knob.what)
            continue
        best, why = trial.best(knob, progress, allowance)
        if best is None:
            left.append(f"{knob.what}: {why}")
        else:
            found.append(best)
    if late:
        left.append(f"{listed(dict.fromkeys(late))}: left out after {allowance.most} changed drives")
    return tuple(sorted(found, key=lambda remedy: remedy.ratio)), tuple(left)


def every_knob(subject: Subject, response: ExactResponse, torque: float) -> Iterator[Knob]:
    """Everything that can be turned or exchanged on a drive with that curve and largest torque [N*m] in the gear."""
    at = response.visited()[np.argmax(response.curve.oscillation[response.visited()])]
    return chain(knobs(subject, response.curve.coefficients[at], torque), other_gears(subject))


@dataclass
class Allowance:
    """How many changed drives may be followed: a count, so that every machine finds the same."""

    most: int
    left: int

    @classmethod
    def of(cls, subject: Subject, most: int | None = None) -> "Allowance":
        """That of a drive, or a given one."""
        most = (WITH_MEMORY if subject.has_memory else MOST) if most is None else most
        return cls(most, most)

    def take(self) -> bool:
        """Use one up, and say whether there was one."""
        self.left -= 1
        return self.left >= 0


@dataclass(frozen=True)
class Trial:
    """How changed drives are followed, and the largest oscillation without a change."""

    speeds: tuple[float, float]
    how: tuple[int, bool]
    before: Top
    avoid: Avoid

    @classmethod
    def of(cls, subject: Subject, response: ExactResponse, avoid: Avoid) -> "Trial | None":
        """Follow a drive without a change; None where that finds no motion."""
        speeds = subject.speeds
        if subject.has_memory:
            speeds = max(speeds[0], (1.0 - NEAR) * avoid.at), min(speeds[1], (1.0 + NEAR) * avoid.at)
        harmonics = response.curve.coefficients.shape[1] // 2
        same = subject._replace(speeds=speeds)
        for coexisting in (bool(response.curve.elsewhere), True):
            before = largest(same, harmonics, coexisting)
            if before is not None and (coexisting or before[1] > LOST * avoid.largest):
                return cls(speeds, (harmonics, coexisting), before, avoid)
        return None

    def best(
        self, knob: Knob, progress: Callable[[str], None], allowance: Allowance
    ) -> tuple[Remedy | None, str]:  # fmt: skip
        """The most helpful change of one thing, which is finished once it is begun; without one, why."""
        tried, why = [], ""
        for sign in knob.signs:
            for size in knob.changes:
                share = sign * size
                progress(f"{knob.what}, {share:+.0%}" if share else knob.what)
                changed = knob.turned(share)
                if isinstance(changed, str):
                    why = changed
                    break
                allowance.take()
                remedy = self.remedy(knob, share, changed)
                if remedy is None:
                    why = "no steady motion was found with the change"
                    break
                tried.append(remedy)
                if abs(remedy.ratio - 1.0) >= LITTLE:
                    break
            if tried and tried[-1].ratio < 1.0 - LITTLE:
                break
        return min(tried, key=lambda remedy: remedy.ratio, default=None), why

    def remedy(self, knob: Knob, share: float, changed: Subject) -> Remedy | None:
        """What a change of one thing by a share does; None where no steady motion is found with it."""
        try:
            after = largest(changed if share == 0.0 else changed._replace(speeds=self.speeds), *self.how)
        except SolveError:  # its law cannot carry the mean torque
            return None
        if after is None:
            return None
        ratio, limit = after[1] / self.before[1], self.avoid.limit
        by = share * knob.by if knob.by else 0.0
        exceeds = None if limit is None else ratio * self.avoid.largest > limit
        if share == 0.0:
            return Remedy(knob.what, 0.0, 0.0, ratio, after[0], gear=knob.unit, exceeds=exceeds)
        if not by and not knob.value:  # a stiffness of nothing at rest, with backlash
            return Remedy(knob.what, share, 0.0, ratio, after[0], exceeds=exceeds)
        value = knob.value + by if by else (1.0 + share) * knob.value
        return Remedy(
            knob.what, 0.0 if by else share, by, ratio, after[0], knob.value, value, knob.unit, exceeds=exceeds
        )  # fmt: skip
