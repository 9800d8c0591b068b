"""`frequency_response`: a whole curve of periodic orbits, from one end of a frequency range to the other.

The curve starts from the linear response, or from strong damping, at one end and is followed to the other; where it
leaves the range with folds still ahead, it is followed outside until it comes back. The number of harmonics grows
until the last two are negligible.
"""

from dataclasses import replace as with_changes
from typing import Any

import numpy as np

from .._jit import with_leaf
from ..quantities import checked, interval
from ..results import Branch, Floats, SolveError
from .branches import UNBOUNDED, Trace, describe, largest_tail, leaf_of, solve, trace
from .continuation import CLOSED, END, LOST, RUNNING, STUCK
from .first_order import FirstOrder, balance_of
from .guess import linear_response
from .half_wave import is_odd_on, odd_problem
from .harmonics import MOST, most_harmonics, starting_harmonics
from .integrate import simulate
from .remarks import remarks

TAIL = 1e-6  # the last two harmonics may hold this share of the whole
MOST_HARMONICS = MOST
BELOW, ABOVE = 3.0, 100.0  # how far outside the range, as factors, a branch may go before it comes back
EXCURSIONS = 20  # how often
GROWTH = 1e7  # an orbit this many times larger than at the start of its branch has no bound
SETTLING = 200  # periods integrated


def frequency_response(
    system: Any,
    span: tuple[float, float],
    *,
    harmonics: int | None = None,
    period: int = 1,
    points: int = 200,
    throw: bool = False,
) -> Branch:
    """Follow the response of a forced system through a range of base frequency.

    Parameters
    ----------
    system : Oscillator, or any NamedTuple with `rhs(phase, y)` and a field `omega`
        The system; its own `omega` does not matter. The general form may have a method `jacobian(phase, y)`; its
        methods must take arrays, and it runs in NumPy.
    span : (float, float)
        Range of omega [rad/s], 0 < low < high.
    harmonics : int, optional
        Highest harmonic H of omega/period. Default: grown until the last two are negligible (1e-6), at most 127, or
        31 with friction or memory.
    period : int
        Turns of the base angle per orbit.
    points : int
        About how many points to place; more where the curve bends.
    throw : bool
        Raise instead of returning a branch that ends inside the range.

    Returns
    -------
    Branch
        In arc order from one end of the range to the other, with stability, folds and period doublings. Where the
        curve leaves the range and comes back, the points outside are in it too.

    Raises
    ------
    ValueError
        If the range is not 0 < low < high, or `harmonics`, `period` or `points` is not positive.
    SolveError
        If `throw` is true and the branch does not reach both ends.

    References
    ----------
    Krack & Gross 2019, Harmonic Balance for Nonlinear Vibration Problems, secs. 2-4.
    """
    system = checked(system)
    lo, hi = interval("the frequency range", span)
    if not lo > 0.0:
        raise ValueError(
            f"the frequency range is {lo:g} .. {hi:g} rad/s; it must be 0 < low < high (at rest there is no response)"
        )
    leaf = leaf_of(system, "omega")
    system = with_leaf(system, leaf, (lo * hi) ** 0.5)
    h = starting_harmonics(system, harmonics, period, points)
    while True:
        problem = balance_of(system, leaf, leaf, h, period)
        problem, found, origin = symmetric_across(problem, lo, hi, 4.0 / points)
        tail = largest_tail(problem, found.points)
        if harmonics is not None or (tail <= TAIL and found.outcome == END) or h >= most_harmonics(system):
            break
        h = min(2 * h + 1, most_harmonics(system))
    branch = describe(problem, "omega", found, tail, origin)
    branch = with_changes(branch, message="; ".join([branch.message, *remarks(problem, branch, found.points)]))
    if throw and not branch.status:
        raise SolveError(branch.message)
    return branch


def symmetric_across(problem: Any, lo: float, hi: float, step: float) -> tuple[Any, Trace, str]:
    """`across` by odd harmonics alone where that is possible; and the problem that was solved."""
    odd = odd_problem(problem)
    if odd is not None:
        found, origin = across(odd, lo, hi, step)
        if found.outcome == END and is_odd_on(odd, found.points):
            return odd, found, origin
    return problem, *across(problem, lo, hi, step)


def across(problem: Any, lo: float, hi: float, step: float) -> tuple[Trace, str]:
    """Branch through a range, and how it was found: the first of six ways that arrives, or else the longest."""
    best, origin = None, ""
    starts: list[Floats] = []
    ways = (
        (linear_start, "the linear response"),
        (damped_start, "strong damping"),
        (settled_start, "an integration"),
    )
    for start, from_where in ways:
        for upwards, end in ((True, "lower"), (False, "upper")):
            first = start(problem, lo if upwards else hi)
            if first is None or any(first[-1] == other[-1] and same(first, other) for other in starts):
                continue
            starts.append(first)
            found = whole(problem, first, lo, hi, step, upwards)
            if best is None or found.outcome == END or len(found.points) > len(best.points):
                best, origin = found, f"from {from_where} at the {end} end of the range"
            if found.outcome == END:
                return (found if upwards else backwards(found)), origin
        if best is not None and best.outcome == UNBOUNDED:  # no other way helps
            break
    if best is None:
        sentence = (
            f"no periodic response was found at omega = {lo:.6g} or {hi:.6g} rad/s, neither from the linear response "
            "nor from strong damping nor by integration; the torque may be more than the law can bear: take less of "
            "it, or another range"
        )
        return Trace(np.empty((0, len(problem.tau) + 1)), np.empty(0, int), LOST, sentence), "not found"
    return best, origin


def backwards(found: Trace) -> Trace:
    """The same branch from its end to its start."""
    return Trace(found.points[::-1], found.labels[::-1], found.outcome, found.message)


def linear_start(problem: Any, value: float) -> Floats | None:
    """Solution at a value of the parameter near the linear response."""
    return solve(problem, linear_response(problem, value))


def damped_start(problem: Any, value: float) -> Floats | None:
    """Solution at a value of the parameter that a branch in the damping B connects with strong damping.

    With damping strong enough the orbit is near the linear response and alone; the branch comes down from there to the
    damping asked for, unless orbits grow beyond all bounds on the way.
    """
    if isinstance(problem, FirstOrder):
        return None
    damping = leaf_of(problem.system, "B")
    if problem.leaf == damping:
        return None
    system = with_leaf(problem.system, problem.leaf, float(value))
    damped = problem._replace(system=system, leaf=damping)
    strong = max(system.B, system.J * abs(system.omega))
    for _ in range(20):
        found = solve(damped, linear_response(damped, strong))
        if found is not None:
            break
        strong *= 4.0
    else:
        return None
    way = trace(damped, found, -1.0, system.B, strong, 0.2, growth=GROWTH)
    if way.outcome != END or way.points[-1, -1] != system.B:
        return None
    return solve(problem, np.append(way.points[-1, :-1], value))


def settled_start(problem: Any, value: float) -> Floats | None:
    """Solution at a value of the parameter near the motion to which an integration from rest has settled."""
    system = with_leaf(problem.system, problem.leaf, float(value))
    general = isinstance(problem, FirstOrder)
    base = float(getattr(system, "omega", 1.0))
    turn = 2.0 * np.pi * problem.turns / base
    times = turn * SETTLING + problem.angles / base
    try:
        motion = simulate(system, np.zeros(len(problem.sizes) if general else 2), np.concatenate([[0.0], times]))
    except ValueError:  # there is no motion from rest
        return None
    if not motion.status:
        return None
    states = motion.y[:, 1:] @ problem.analysis[:, : len(problem.error)]
    series = states / problem.sizes[:, None] if general else states[0] - problem.error
    return solve(problem, np.append(series, value))


def whole(problem: Any, first: Floats, lo: float, hi: float, step: float, upwards: bool) -> Trace:
    """Follow the branch from its point at one end of a range to the other end, with excursions outside the range.

    The outcome is END only if the branch has points at both ends.
    """
    far = hi if upwards else lo
    latest = trace(problem, first, 1.0 if upwards else -1.0, lo, hi, step, growth=GROWTH)
    pieces, labels = [latest.points], [latest.labels]
    outcome = latest.outcome
    for _ in range(EXCURSIONS):
        if outcome != END:
            break
        last = latest.points[-1]
        end = float(last[-1])
        if end == far and same(linear_start(problem, far), last):
            break
        outside = (hi, hi * ABOVE) if end == hi else (lo / BELOW, lo)
        away = trace(problem, last, 1.0 if end == hi else -1.0, *outside, step, 2.0 * hi, GROWTH)
        if away.outcome != END or away.points[-1, -1] != end:
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
    points, kinds = np.concatenate(pieces), np.concatenate(labels)
    if far in points[:, -1] and outcome in (END, CLOSED):
        return Trace(points, kinds, END, "reached both ends")
    return Trace(points, kinds, STUCK if outcome in (END, CLOSED) else outcome, _ending(points, outcome, far))


def same(a: Floats | None, b: Floats) -> bool:
    """Whether two points of a branch at one value of the parameter are the same; None is the same as any."""
    return a is None or float(np.linalg.norm(a - b)) <= 1e-5 * float(np.linalg.norm(b[:-1]))


def _ending(points: Floats, outcome: int, far: float) -> str:
    """Sentence about a branch that does not reach the other end of its range."""
    first, last, most = points[0, -1], points[-1, -1], (points.shape[1] - 2) // 2
    reasons = {
        END: f"the branch from omega = {first:.6g} leaves the range at {last:.6g} rad/s for good and does not reach "
        f"{far:.6g} rad/s; the response there is on another branch: start the range near it",
        CLOSED: f"the branch from omega = {first:.6g} rad/s is a closed loop and does not reach {far:.6g} rad/s; start "
        "the range elsewhere",
        STUCK: f"the branch stops at omega = {last:.6g} rad/s, where the step became too small with {most} harmonics; "
        "take more harmonics or end the range before it",
        UNBOUNDED: f"the response grows without bound at omega = {last:.6g} rad/s; give more damping or end the range "
        "before it",
        RUNNING: f"the branch stops at omega = {last:.6g} rad/s after {len(points)} points; take fewer harmonics, "
        "fewer points or a smaller range",
    }
    return reasons[outcome]
