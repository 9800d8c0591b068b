"""A branch from one end of a frequency range to the other, with excursions outside it.

It starts from the linear response, from strong damping or from an integration, at either end. Where it leaves the range
with folds still ahead, or where other orbits exist at an end, it is followed outside until it comes back.

Orbits that coexist at one base frequency, from one number of harmonics to the next; `connected` looks for them.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from ...base.protocols import CLOSED, END, LOST, RUNNING, STUCK, UNBOUNDED, Balance, omega_of
from ...base.results import Floats
from ...base.sentences import Sentence, Speed
from ...compile.tree import with_leaf
from ..balance.harmonics import SEARCH_PER_TURN
from ..integration.simulate import simulate
from .connected import alike, connected, new_orbits, same
from .trace import Trace, solve, trace

BELOW, ABOVE = 3.0, 100.0  # how far outside the range, as factors, a branch may go before it comes back
EXCURSIONS = 20  # how often
GROWTH = 1e7  # an orbit this many times larger than at the start of its branch has no bound
SETTLING = 200  # periods integrated


class Coexisting:
    """Orbits known at some base frequencies, carried from one number of harmonics to the next.

    `known` maps a frequency to tables of coefficients (2H+1, states), of the torsion for a `SecondOrder` problem;
    `alone` are frequencies at which one orbit is all there can be, `unfinished` those at which a search was cut short.
    """

    def __init__(self) -> None:
        self.known: dict[float, list[Floats]] = {}
        self.searched: set[float] = set()
        self.alone: set[float] = set()
        self.begun = False
        self.unfinished: set[float] = set()
        self.apart: list[Floats] = []

    def begin(self, problem: Balance, curve: Trace) -> bool:
        """Begin to search, if it has not begun and other orbits may exist at an end of a curve; whether it begins."""
        if self.begun or not len(curve.points):
            return False
        self.begun = True
        ends = curve.points[[0, -1]]
        may = problem.several_at(ends)
        self.alone = {*ends[~may, -1].tolist()} - {*ends[may, -1].tolist()}
        return bool(may.any()) or curve.outcome != END

    def guesses(self, problem: Balance, value: float, points: Floats) -> list[Floats]:
        """Guesses at a frequency for orbits beside those of a branch; searched for once, where there may be any."""
        if self.begun and value not in self.searched and value not in self.alone:
            self.searched.add(value)
            search = connected(problem, value, points_at(points, value)[:1])
            self.known.setdefault(value, []).extend(search.tables)
            if not search.complete:
                self.unfinished.add(value)
        tables = [table for table in self.known.get(value, []) if not any(table is other for other in self.apart)]
        some = [problem.fitted(table, value) for table in tables]
        return [point for point in some if point is not None]

    def note(self, problem: Balance, points: list[Floats]) -> None:
        """Keep orbits that were found by the way."""
        for point in points:
            self.known.setdefault(float(point[-1]), []).append(problem.table(point))

    def give_up(self, problem: Balance, points: list[Floats]) -> None:
        """Look no more for a way to orbits to which none was found with harmonics enough; they remain known."""
        if problem.turns * SEARCH_PER_TURN > problem.highest():
            return
        for point in points:
            table = problem.table(point)
            self.apart += [other for other in self.known[float(point[-1])] if alike(table, other, problem.turns)]


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
            branch = across_range(problem, first, lo, hi, step, upwards, coexisting)
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


def linear_start(problem: Balance, value: float) -> Floats | None:
    """Solution at a value of the parameter near the linear response."""
    return solve(problem, problem.linear_response(value))


def damped_start(problem: Balance, value: float) -> Floats | None:
    """Solution at a value of the parameter that a branch in the damping B connects with strong damping.

    With damping strong enough the orbit is near the linear response and alone; the branch comes down from there to the
    damping asked for, unless orbits grow beyond all bounds on the way.
    """
    damping = problem.damping_leaf()
    if damping is None or problem.leaf == damping:
        return None
    system = with_leaf(problem.system, problem.leaf, float(value))
    damped = problem._replace(system=system, leaf=damping)
    strong = max(system.B, system.J * abs(system.omega))
    for _ in range(20):
        start = solve(damped, damped.linear_response(strong))
        if start is not None:
            break
        strong *= 4.0
    else:
        return None
    branch = trace(damped, start, -1.0, system.B, strong, 0.2, growth=GROWTH)
    if branch.outcome != END or branch.points[-1, -1] != system.B:
        return None
    return solve(problem, np.append(branch.points[-1, :-1], value))


def settled_start(problem: Balance, value: float) -> Floats | None:
    """Solution at a value of the parameter near the motion to which an integration from rest has settled."""
    system = with_leaf(problem.system, problem.leaf, float(value))
    base = float(omega_of(system))
    turn = 2.0 * np.pi * problem.turns / base
    times = turn * SETTLING + problem.angles / base
    try:
        motion = simulate(system, np.zeros(problem.state_count()), np.concatenate([[0.0], times]))
    except ValueError:  # there is no motion from rest
        return None
    if not motion.status:
        return None
    return solve(problem, problem.sampled(motion.y[:, 1:], value))


def across_range(
    problem: Balance, first: Floats, lo: float, hi: float, step: float, upwards: bool, coexisting: Coexisting
) -> Trace:  # fmt: skip
    """Follow the branch from its point at one end of a range to the other end, with excursions outside the range.

    The outcome is END only if the branch has points at both ends. Where other orbits exist at an end, it is followed
    outside until it comes back through them.
    """
    begin, far = (lo, hi) if upwards else (hi, lo)
    branch = trace(problem, first, 1.0 if upwards else -1.0, lo, hi, step, growth=GROWTH)
    if branch.outcome == LOST:
        return branch
    guesses = coexisting.guesses(problem, far, branch.points)
    branch, missed = extended(problem, branch, lo, hi, step, far, [problem.linear_response(far)], guesses)
    coexisting.note(problem, missed)
    coexisting.give_up(problem, missed)
    points, outcome = branch.points, branch.outcome
    if far not in points[:, -1] or outcome not in (END, CLOSED):
        return Trace(
            points, branch.labels, STUCK if outcome in (END, CLOSED) else outcome, _ending(points, outcome, far)
        )
    if outcome == END:
        guesses = coexisting.guesses(problem, begin, branch.points)
        longer, missed = extended(problem, backwards(branch), lo, hi, step, begin, [], guesses)
        coexisting.give_up(problem, missed)
        if longer.outcome in (END, CLOSED):
            branch = backwards(longer)
    return Trace(branch.points, branch.labels, END, "reached both ends")


def extended(
    problem: Balance, branch: Trace, lo: float, hi: float, step: float, goal: float, linear: list[Floats],
    guesses: list[Floats],
) -> tuple[Trace, list[Floats]]:  # fmt: skip
    """Follow a branch out of the range and back until it ends at `goal` and has passed every orbit known there.

    `linear` and `guesses` lead to orbits at `goal`; only `linear` ones send the branch far out. Returns the
    branch and those of the orbits that it does not pass.
    """
    pieces, labels, outcome = [branch.points], [branch.labels], branch.outcome
    missed: list[Floats] = []
    for _ in range(EXCURSIONS):
        last = pieces[-1][-1]
        end = float(last[-1])
        if outcome != END:
            break
        factor = ABOVE
        if end == goal:
            passed = [z for piece in pieces for z in points_at(piece, goal)]
            quiet = new_orbits(problem, linear, passed)
            factor = ABOVE if quiet else BELOW
            missed = quiet + new_orbits(problem, guesses, passed + quiet)
            if not missed:
                break
        outside = (hi, hi * factor) if end == hi else (lo / BELOW, lo)
        away = trace(problem, last, 1.0 if end == hi else -1.0, *outside, step, 2.0 * hi, GROWTH, problem.patience())
        if away.outcome != END or away.points[-1, -1] != end:
            if end == goal:
                some = quiet if problem.patience() is None else missed
                curve = Trace(np.concatenate(pieces), np.concatenate(labels), outcome)
                curve, left = with_arcs(problem, curve, some, lo, hi, step, goal)
                return curve, left + missed[len(some) :]
            break
        pieces.append(away.points[1:])
        labels.append(away.labels[1:])
        if same(away.points[-1], pieces[0][0]):
            outcome = CLOSED
            break
        latest = trace(problem, away.points[-1], -1.0 if end == hi else 1.0, lo, hi, step, growth=GROWTH)
        pieces.append(latest.points[1:])
        labels.append(latest.labels[1:])
        outcome = latest.outcome
    return Trace(np.concatenate(pieces), np.concatenate(labels), outcome), missed


def with_arcs(
    problem: Balance, branch: Trace, orbits: list[Floats], lo: float, hi: float, step: float, goal: float
) -> tuple[Trace, list[Floats]]:  # fmt: skip
    """A branch that ends at `goal`, and after it the arcs inside the range from other orbits there that return to it.

    Beyond the range they may join it or not. Returns also those of the orbits that are on no such arc.
    """
    missed: list[Floats] = []
    for orbit in orbits:
        if any(same(orbit, z) for z in points_at(branch.points, goal)):
            continue
        arc = trace(problem, orbit, -1.0 if goal == hi else 1.0, lo, hi, step, growth=GROWTH)
        if arc.outcome == END and arc.points[-1, -1] == goal and len(arc.points) > 2:
            points = np.concatenate([branch.points, arc.points[::-1]])
            labels = np.concatenate([branch.labels, arc.labels[::-1]])
            branch = replace(branch, points=points, labels=labels)
        else:
            missed.append(orbit)
    return branch, missed


def points_at(points: Floats, value: float) -> list[Floats]:
    """Points of a branch at one value of the parameter."""
    return list(points[points[:, -1] == value])


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
