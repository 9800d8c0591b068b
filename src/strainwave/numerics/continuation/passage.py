"""A branch from one end of a frequency range to the other, with excursions outside it.

It starts from the linear response, from strong damping or from an integration, at either end. Where it leaves the range
with folds still ahead, or where other orbits exist at an end, it is followed outside until it comes back.
"""

from typing import Any, NamedTuple

import numpy as np

from ...base.branch_labels import CLOSED, END, LOST, RUNNING, STUCK, UNBOUNDED
from ...base.protocols import Balance
from ...base.results import Floats
from ...base.sentences import Sentence, Speed
from .coexisting import Coexisting
from .connected import new_orbits, same
from .starts import GROWTH, damped_start, settled_start
from .trace import Trace, points_at, solve, trace

BELOW, ABOVE = 3.0, 100.0  # how far outside the range, as factors, a branch may go before it comes back
EXCURSIONS = 20  # how often


class Passage(NamedTuple):
    """A range from `lo` to `hi` of a problem's parameter, and the steps in which branches are followed through it."""

    problem: Balance
    lo: float
    hi: float
    step: float

    def inside(self, first: Floats, upwards: bool) -> Trace:
        """Branch in the range from a point."""
        return trace(self.problem, first, 1.0 if upwards else -1.0, self.lo, self.hi, self.step, growth=GROWTH)

    def outside(self, first: Floats, factor: float) -> Trace:
        """Branch out of the range from a point at an end of it; above the range up to `factor` times its end."""
        upwards = first[-1] == self.hi
        ends = (self.hi, self.hi * factor) if upwards else (self.lo / BELOW, self.lo)
        way, width, patience = 1.0 if upwards else -1.0, 2.0 * self.hi, self.problem.patience()
        return trace(self.problem, first, way, *ends, self.step, width, GROWTH, patience)


def across(problem: Balance, lo: float, hi: float, step: float, coexisting: Coexisting) -> tuple[Trace, str]:
    """Branch through a range, and how it was found: the first of six ways that arrives, or else the longest.

    The branch passes the `coexisting` orbits at the ends of the range where it can; others that lie there are added.
    """
    best, origin = None, ""
    starts: list[Floats] = []
    ways = (
        (type(problem).linear_response, "the linear response"),
        (damped_start, "strong damping"),
        (settled_start, "an integration"),
    )
    for start, from_where in ways:
        for upwards, end in ((True, "lower"), (False, "upper")):
            first = start(problem, lo if upwards else hi)
            if first is not None and starts:
                first = solve(problem, first)
            if first is None or any(first[-1] == former[-1] and same(first, former) for former in starts):
                continue
            branch = across_range(Passage(problem, lo, hi, step), first, upwards, coexisting)
            if branch.outcome == LOST:
                continue
            starts.append(branch.points[0])
            if best is None or branch.outcome == END or len(branch.points) > len(best.points):
                best, origin = branch, f"from {from_where} at the {end} end of the range"
            if branch.outcome == END:
                return (branch if upwards else backwards(branch)), origin
            coexisting.note(problem, starts[-1:])
        if best is not None and best.outcome == UNBOUNDED:  # no other way helps
            break
    if best is None:
        sentence = Sentence(
            "no periodic response was found at omega = {}, neither from the linear response nor from strong damping "
            "nor by integration; the torque may be more than the law can bear: take less of it, or another range",
            Speed(lo, hi, between=" or "),
        )
        return Trace(np.empty((0, problem.size() + 1)), np.empty(0, int), LOST, sentence), "not found"
    return best, origin


def backwards(branch: Trace) -> Trace:
    """The same branch from its end to its start."""
    return Trace(branch.points[::-1], branch.labels[::-1], branch.outcome, branch.message)


def across_range(passage: Passage, first: Floats, upwards: bool, coexisting: Coexisting) -> Trace:
    """Follow the branch from its point at one end of a range to the other end, with excursions outside the range.

    The outcome is END only if the branch has points at both ends. Where other orbits exist at an end, it is followed
    outside until it comes back through them.
    """
    problem, lo, hi, _ = passage
    begin, far = (lo, hi) if upwards else (hi, lo)
    branch = passage.inside(first, upwards)
    if branch.outcome == LOST:
        return branch
    guesses = coexisting.guesses(problem, far, branch.points)
    branch, missed = extended(passage, branch, far, [problem.linear_response(far)], guesses)
    coexisting.note(problem, missed)
    coexisting.give_up(problem, missed)
    points, outcome = branch.points, branch.outcome
    if far not in points[:, -1] or outcome not in (END, CLOSED):
        ended = STUCK if outcome in (END, CLOSED) else outcome
        return Trace(points, branch.labels, ended, _ending(points, outcome, far))
    if outcome == END:
        guesses = coexisting.guesses(problem, begin, branch.points)
        longer, missed = extended(passage, backwards(branch), begin, [], guesses)
        coexisting.give_up(problem, missed)
        if longer.outcome in (END, CLOSED):
            branch = backwards(longer)
    return Trace(branch.points, branch.labels, END, "reached both ends")


def extended(
    passage: Passage, branch: Trace, goal: float, linear: list[Floats], guesses: list[Floats]
) -> tuple[Trace, list[Floats]]:
    """Follow a branch out of the range and back until it ends at `goal` and has passed every orbit known there.

    `linear` and `guesses` lead to orbits at `goal`; only `linear` ones send the branch far out. Returns the
    branch and those of the orbits that it does not pass.
    """
    problem, missed = passage.problem, list[Floats]()
    for _ in range(EXCURSIONS):
        if branch.outcome != END:
            break
        end, factor = float(branch.points[-1, -1]), ABOVE
        if end == goal:
            passed = points_at(branch.points, goal)
            quiet = new_orbits(problem, linear, passed)
            factor = ABOVE if quiet else BELOW
            missed = quiet + new_orbits(problem, guesses, passed + quiet)
            if not missed:
                break
        away = passage.outside(branch.points[-1], factor)
        if away.outcome != END or away.points[-1, -1] != end:
            if end != goal:
                break
            some = quiet if problem.patience() is None else missed
            branch, left = with_arcs(passage, branch, some, goal)
            return branch, left + missed[len(some) :]
        branch = continued(branch, away)
        if same(branch.points[-1], branch.points[0]):
            return Trace(branch.points, branch.labels, CLOSED), missed
        branch = continued(branch, passage.inside(branch.points[-1], end != passage.hi))
    return branch, missed


def continued(branch: Trace, by: Trace) -> Trace:
    """A branch and another one that begins where it ends."""
    points, labels = (branch.points, by.points[1:]), (branch.labels, by.labels[1:])
    return Trace(np.concatenate(points), np.concatenate(labels), by.outcome)


def with_arcs(passage: Passage, branch: Trace, orbits: list[Floats], goal: float) -> tuple[Trace, list[Floats]]:
    """A branch that ends at `goal`, and after it the arcs inside the range from other orbits there that return to it.

    Beyond the range they may join it or not. Returns also those of the orbits that are on no such arc.
    """
    missed: list[Floats] = []
    for orbit in orbits:
        if any(same(orbit, z) for z in points_at(branch.points, goal)):
            continue
        arc = passage.inside(orbit, goal != passage.hi)
        if arc.outcome == END and arc.points[-1, -1] == goal and len(arc.points) > 2:
            points, labels = (branch.points, arc.points[::-1]), (branch.labels, arc.labels[::-1])
            branch = Trace(np.concatenate(points), np.concatenate(labels), END)
        else:
            missed.append(orbit)
    return branch, missed


def _ending(points: Floats, outcome: int, far: float) -> str:
    """Sentence about a branch that does not reach the other end of its range."""
    first, last, end = Speed(points[0, -1]), Speed(points[-1, -1]), Speed(far)
    reasons: dict[int, tuple[Any, ...]] = {
        END: (
            "the branch from omega = {} leaves the range at {} for good and does not reach {}; the response there is "
            "on another branch: start the range near it", first, last, end,
        ),
        CLOSED: (
            "the branch from omega = {} is a closed loop and does not reach {}; start the range elsewhere", first, end,
        ),
        STUCK: (
            "the branch stops at omega = {}, where the step became too small with {} harmonics; take more harmonics or "
            "end the range before it", last, (points.shape[1] - 2) // 2,
        ),
        UNBOUNDED: (
            "the response grows without bound at omega = {}; give more damping or end the range before it", last,
        ),
        RUNNING: (
            "the branch stops at omega = {} after {} points; take fewer harmonics, fewer points or a smaller range",
            last, len(points),
        ),
    }  # fmt: skip
    return Sentence(*reasons[outcome])
