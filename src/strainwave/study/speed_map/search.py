"""Motions that do not join the main curve: random starts at speeds spread over the range settle on them.

What a trajectory settles on and no curve has is followed by harmonic balance through the range, or else kept as it is.
Other starts are motions of a neighbouring load, free vibrations, and what goes on where a known motion ends.
"""

from collections.abc import Iterator
from math import ceil
from typing import Any, NamedTuple

import numpy as np

from ...base.law import breakpoints_of, depends, is_spring, spring_stiffness, states_of, torque_of, torsion
from ...base.quantities import leaf_of
from ...base.results import Booleans, Floats, largest_between
from ...base.series import largest_of_samples
from ...drive.response import TurnResponse, of_equation
from ...drive.train_curve import of_train, torque_in
from ...model.oscillator import Oscillator
from ...model.train.drive_train import DriveTrain
from ...model.train.train_forms import AtLoad
from ...numerics.attractors.random_starts import box_at, starts_in
from ...numerics.attractors.settle import SEEN, Bounded, Settled, settled
from ...numerics.balance.choice import balance_of
from ...numerics.balance.fourier import with_velocity
from ...numerics.balance.harmonics import MOST_HARMONICS, highest_order
from ...numerics.balance.linear_part import one_harmonic
from ...numerics.balance.rates import number_of_states
from ...numerics.balance.second_order import second_order
from ...numerics.balance.truncation import tail_along
from ...numerics.continuation.trace import describe, series_of, solve
from ...numerics.curves.branch_to_birth import both_ways
from ...numerics.integration.methods import Dopri5
from ...numerics.integration.simulate import simulate
from ...theory.slow_flow.setting import active_orders
from .motions import HIGH, LOW, OMEGA, OSCILLATION, LooseMotion, MotionCurve, extremes, stable_runs

MOTION_DIFFERENCE = 0.03  # of the reach of a motion, by which the ends of one motion differ at most
DECAY_CONSTANTS, LEAST_TURNS, MOST_TURNS = 20.0, 8, 3000  # time constants and turns that transients have to die
MOST_STEPS = 500_000  # of a start, some seconds: a drive with parts that decay in microseconds takes more
LOOSE_TURNS = 256  # turns after which a motion that is not followed is measured
STAGES = 4  # shares of that time after which those on known motions end
ESCAPE_FACTOR = 100.0  # times the largest start or motion, beyond which a trajectory does not come back
ROUGH_TOLERANCE = 1e-5  # tolerance of the integration: what it leads to is solved again
POINTS = 60  # about so many of a curve
LONG_REACH, EXTRA_HARMONICS = 0.015, 4  # relative distance, and harmonics beyond the orders, of motions of many turns
PER_ORDER, PER_HARMONIC = 32, 8  # samples of a cycle of the highest order, and of the highest harmonic of a curve
OTHER_DISTANCE = 0.1  # of the reach of a trajectory, beyond which harmonic balance has found another motion
MOST_CURVES, MOST_PERIODS = 12, 4  # curves at most under one load, and turns of a motion on one
USUAL_HARMONICS = 48  # harmonics of a curve that counts as one; its time grows with their square
RANDOM_STARTS, SEED = 4, 14  # random starts at every speed
PHASES, MEMORY_PHASES = 4, 24  # of a free vibration; of a driven one with memory, where few lead to the large motion
VIBRATION_TURNS, AMPLITUDES = (1, 2, 3), 49  # periods of a line that a free vibration may take; of the backbone
BESIDE_SHARES, NEXT_SHARE = (0.01, 0.02), 0.06  # of its speed: beside a motion that is not followed, up to the next one
END_DISTANCES = 2e-4, 6e-4, 2e-3  # relative distances from the end of a stable run at which others are looked for


class MotionStart(NamedTuple):
    """Start of a trajectory: speed [rad/s], state at base angle 0, turns of the motor that its motion takes."""

    omega: float
    state: tuple[float, ...]
    turns: int


class SearchResult(NamedTuple):
    """New curves, motions that no curve has, whether all starts had time to settle, and states that led to motions."""

    curves: tuple[MotionCurve, ...]
    loose: tuple[LooseMotion, ...]
    settled: bool
    seeds: tuple[MotionStart, ...]


def search(
    case: Any, known_curves: tuple[MotionCurve, ...], speeds: Floats, seeds: tuple[MotionStart, ...],
    span: tuple[float, float],
) -> SearchResult:  # fmt: skip
    """Look for stable motions that no known curve has, and follow them.

    Parameters
    ----------
    case : Case
        The drive under its load.
    known_curves : tuple of Motions
        Curves that are known.
    speeds : (n,) array
        Speeds [rad/s] at which starts are integrated; may be empty.
    seeds : tuple of Settling
        Further starts.
    span : (float, float)
        Range of speeds [rad/s].
    """
    curves, loose, new, settled = known_curves, list[LooseMotion](), list[MotionStart](), True
    fresh = known_curves if len(speeds) else ()
    while len(speeds) or seeds:
        result = _search_once(case, curves, speeds, seeds, span, len(curves) - len(known_curves))
        curves, loose, new = (*curves, *result.curves), [*loose, *result.loose], [*new, *result.seeds]
        settled = settled and result.settled
        ends = (seed for curve in (*fresh, *result.curves) for seed in starts_beyond_ends(case.system, curve, span))
        seeds = (*ends, *(starts_beside(result.seeds, span) if len(speeds) else ()))
        fresh, speeds = (), np.empty(0)
    return SearchResult(curves[len(known_curves) :], tuple(loose), settled, tuple(new))


def _search_once(
    case: Any, known_curves: tuple[MotionCurve, ...], speeds: Floats, seeds: tuple[MotionStart, ...],
    span: tuple[float, float], earlier: int,
) -> SearchResult:  # fmt: skip
    """`search` from starts at these speeds and from these seeds alone; `earlier` of the curves are from it already."""
    system, spring = case.system, is_spring(case.equation)
    omega, start = starts_at(case, speeds) if len(speeds) else (np.empty(0), np.empty((0, 0)))
    if seeds:
        given = np.array([seed.state for seed in seeds]).T
        omega = np.append(omega, [seed.omega for seed in seeds])
        start = np.concatenate([start.reshape(len(given), -1), given], axis=1)
    ends, settled = _march_starts(case, omega, start, known_curves)
    curves, loose, new = known_curves, list[LooseMotion](), list[MotionStart]()
    effort = sum(map(_effort, known_curves[len(known_curves) - earlier :]))
    while lanes := _unknown_lanes(curves, omega, ends):
        lane = max(lanes, key=lambda i: float(ends.highest[i] - ends.lowest[i]))
        low, high = float(ends.lowest[lane]), float(ends.highest[lane])
        seed = MotionStart(float(omega[lane]), tuple(ends.state[:, lane].tolist()), int(ends.period[lane]))
        followed = spring and 0 < seed.turns <= MOST_PERIODS and effort < MOST_CURVES
        whole_range = len(speeds) > 0 or seed.turns < MOST_PERIODS
        count = curves[0].branch.coefficients.shape[1] // 2 if whole_range else highest_order(system) + EXTRA_HARMONICS
        orbit = solve_orbit(system, seed, count) if followed else None
        on_curve = orbit is not None and _is_on_curve(curves, orbit)
        curve = None
        if orbit is not None and not on_curve:
            curve = follow_curve(system, orbit, _reach(seed, span, whole_range), known_curves[0].every, case.level)
        if curve is not None:
            curves, new, effort = (*curves, curve), [*new, seed], effort + _effort(curve)
        elif settled and not on_curve:
            unfollowed = _loose_motion(system, seed, 0.5 * (high - low), curves)
            if unfollowed is not None:
                loose.append(unfollowed)
                new += [seed] if seed.turns else []
        same = np.abs(ends.lowest - low) + np.abs(ends.highest - high) < MOTION_DIFFERENCE * (high - low)
        if not (spring and seed.turns):  # the largest of those that are not followed stands for all at its speed
            same |= (ends.period == 0) | (not spring)
        ends.diverged[same & (omega == seed.omega)] = True  # looked at once
    return SearchResult(curves[len(known_curves) :], tuple(loose), settled, tuple(new))


def _effort(curve: MotionCurve) -> float:
    """Effort of one curve with its harmonics, in curves of usual length."""
    return max(1.0, float(curve.branch.coefficients.shape[1] // 2 / USUAL_HARMONICS) ** 2)


def _reach(seed: MotionStart, span: tuple[float, float], whole_range: bool) -> tuple[float, float]:
    """Range in which a motion is followed: the whole, or what is near one of many turns that goes on from another."""
    if whole_range:
        return span
    return max(span[0], seed.omega * (1.0 - LONG_REACH)), min(span[1], seed.omega * (1.0 + LONG_REACH))


class SolvedMotion(NamedTuple):
    """A point of a balance problem from which a curve is followed, and the extremes of the error there [rad]."""

    problem: Any
    point: Floats
    low: float
    high: float


def solve_orbit(system: Any, seed: MotionStart, per_turn: int) -> SolvedMotion | None:
    """Solve for the orbit on which a trajectory settled, with so many harmonics a turn; None without it."""
    leaf, turns = leaf_of(system, "omega"), seed.turns
    at_speed = system._replace(omega=seed.omega)
    h = min(MOST_HARMONICS, turns * per_turn)
    if h < turns * highest_order(system):
        return None
    problem: Any = balance_of(at_speed, leaf, leaf, h, turns, folded=False)
    angles = problem.angles
    run = simulate(at_speed, seed.state, np.append(angles, 2.0 * angles[-1] - angles[-2]) / seed.omega)
    if not run.status:
        return None
    point = solve(problem, problem.sampled(run.y[:, : len(angles)], seed.omega))
    if point is None:
        return None
    lows, highs = extremes(series_of(problem, point[None]))
    x = run.y[0]
    apart = max(abs(float(np.min(x)) - lows[0]), abs(float(np.max(x)) - highs[0]))
    if apart > OTHER_DISTANCE * float(np.ptp(x)):
        return None
    return SolvedMotion(problem, point, float(lows[0]), float(highs[0]))


def follow_curve(
    system: Any, start: SolvedMotion, span: tuple[float, float], per_turn: int, train: DriveTrain | None = None
) -> MotionCurve | None:
    """Follow a solved motion through the range; None where no step from it succeeds. `train` has the ratio."""
    trace = both_ways(start.problem, start.point, *span, 4.0 / POINTS)
    if not len(trace.points):
        return None
    tail = tail_along(start.problem, trace.points)
    branch = describe(start.problem, "omega", trace, tail, "settled on", locate=False)
    if isinstance(system, AtLoad):
        return MotionCurve(of_train(system, TurnResponse(start.problem, trace.points, branch)), per_turn)
    return MotionCurve(of_equation(system, branch, train=train), per_turn)


def _is_on_curve(curves: tuple[MotionCurve, ...], start: SolvedMotion) -> bool:
    """True if a solved motion is on one of the curves, stable there or not; one of more turns is on none of fewer."""
    omega, least = float(start.point[-1]), MOTION_DIFFERENCE * (start.high - start.low)
    for curve in (curve for curve in curves if curve.turns % start.problem.turns == 0):
        side = curve.table[:, OMEGA] - omega
        for i in np.flatnonzero(side[1:] * side[:-1] <= 0.0):
            share = side[i] / (side[i] - side[i + 1]) if side[i] != side[i + 1] else 0.0
            row = curve.table[i] + share * (curve.table[i + 1] - curve.table[i])
            if max(abs(row[LOW] - start.low), abs(row[HIGH] - start.high)) <= least:
                return True
    return False


def _march_starts(case: Any, omega: Floats, start: Floats, curves: tuple[MotionCurve, ...]) -> tuple[Settled, bool]:
    """Integrate starts until each is on a known motion or its transients have died; whether all had time for it.

    Transients take a time, not a number of turns: only speeds of one octave are marched together.
    """
    octave = np.floor(np.log2(omega / np.min(omega)))
    groups = [np.flatnonzero(octave == k) for k in np.unique(octave)]
    results = [_march_octave(case, omega[group], start[:, group], curves) for group in groups]
    order = np.argsort(np.concatenate(groups))
    names = "state", "period", "diverged", "lowest", "highest"
    parts = [np.concatenate([getattr(ends, name) for ends, _ in results], axis=-1)[..., order] for name in names]
    return Settled(*parts), all(enough for _, enough in results)


def _march_octave(case: Any, omega: Floats, start: Floats, curves: tuple[MotionCurve, ...]) -> tuple[Settled, bool]:
    """`_march_starts` of starts whose speeds are within an octave."""
    system = case.system
    B, J = (system.B, system.J) if isinstance(system, Oscillator) else (system.train.B, system.train.load.end().J)
    turns = 2.0 * J / B * float(np.max(omega)) / (2.0 * np.pi) if B > 0.0 else MOST_TURNS
    longest = int(np.clip(ceil(DECAY_CONSTANTS * turns), LEAST_TURNS, MOST_TURNS))
    sizes = [float(np.median(curve.table[:, OSCILLATION])) for curve in curves]
    smooth = isinstance(system, Oscillator) and is_spring(system) and not breakpoints_of(system.law)
    method = None if smooth else Dopri5(rtol=ROUGH_TOLERANCE, atol=ROUGH_TOLERANCE * min(sizes), max_steps=MOST_STEPS)
    twists = start[0], torsion(system, 0.0, tuple(start)), *(curve.table[:, [LOW, HIGH]] for curve in curves)
    bound = ESCAPE_FACTOR * max(start_reach(case, np.sort(omega)), *(float(np.max(np.abs(twist))) for twist in twists))
    model, path = (system, "omega") if smooth else (Bounded(system, bound), "system.omega")
    first = longest // STAGES
    ends = settled(
        model, {path: omega}, start, settle=first, longest=STAGES * first + 6 * SEEN, method=method, threads=1,
        recognised=lambda ends: _are_known(curves, omega, ends),
    )  # fmt: skip
    return ends, longest >= DECAY_CONSTANTS * turns and not np.any(ends.period < 0)


def _unknown_lanes(curves: tuple[MotionCurve, ...], omega: Floats, ends: Settled) -> list[int]:
    """Numbers of the lanes on new motions: those that settled, and those that reach beyond all known motions."""
    good = ~ends.diverged & ~_are_known(curves, omega, ends)
    lanes = np.flatnonzero(good).tolist()
    return [lane for lane in lanes if ends.period[lane] or _reaches_beyond(curves, omega, ends, lane)]


def _are_known(curves: tuple[MotionCurve, ...], omega: Floats, ends: Settled) -> Booleans:
    """True for each lane (n,) that is on a motion of these curves."""
    matched = np.zeros(len(omega), bool)
    for w in np.unique(omega):
        lanes = np.flatnonzero(omega == w)
        for row in (row for curve in curves for row in curve.rows_at(float(w))):
            apart = np.maximum(np.abs(ends.lowest[lanes] - row[LOW]), np.abs(ends.highest[lanes] - row[HIGH]))
            matched[lanes] |= apart <= MOTION_DIFFERENCE * (row[HIGH] - row[LOW])
    return matched


def _reaches_beyond(curves: tuple[MotionCurve, ...], omega: Floats, ends: Settled, lane: int) -> bool:
    """True if a lane that did not settle reaches beyond the largest motion at its speed."""
    rows = [row for curve in curves for row in curve.rows_at(float(omega[lane]))]
    if not rows:
        return True
    low, high = min(row[LOW] for row in rows), max(row[HIGH] for row in rows)
    margin = MOTION_DIFFERENCE * (high - low)
    return bool(ends.lowest[lane] < low - margin or ends.highest[lane] > high + margin)


def _loose_motion(system: Any, seed: MotionStart, size: float, curves: tuple[MotionCurve, ...]) -> LooseMotion | None:
    """A motion that is not followed, integrated on; None where that leads to a known one, slowly as beyond a fold.

    One that does not repeat is as large as the search saw it, `size` [rad], or larger.
    """
    at_speed = system._replace(omega=seed.omega)
    count = max(PER_ORDER * highest_order(system), PER_HARMONIC * curves[0].branch.coefficients.shape[1] // 2)
    angles = 2.0 * np.pi * np.append(0.0, LOOSE_TURNS + np.arange(SEEN * count + 1) / count)
    run = simulate(at_speed, seed.state, angles / seed.omega)
    if not run.status:
        return LooseMotion(seed.omega, size, float("inf"), seed.turns)
    angles, y, v, step = angles[1:], run.y[:, 1:], run.rate[0, 1:], np.diff(angles[1:]) / seed.omega
    torque = torque_in(at_speed, angles, tuple(y))[None, :-1]
    mean, span = float(np.mean(y[0, :-1])), float(np.ptp(y[0]))
    shifted = y[0] - mean - span, y[0] - mean + span
    sizes = np.array([largest_between(step, x[:-1], v[:-1], x[1:], v[1:]) - span for x in shifted])
    ends = Settled(y[:, -1:], np.zeros(1, int), np.zeros(1, bool), mean - sizes[:1], mean + sizes[1:])
    if _are_known(curves, np.array([seed.omega]), ends)[0]:
        return None
    reach = max(*sizes.tolist(), 0.0 if seed.turns else size)
    return LooseMotion(seed.omega, reach, float(largest_of_samples(torque)[0]), seed.turns)


def starts_beyond_ends(system: Any, curve: MotionCurve, span: tuple[float, float]) -> Iterator[MotionStart]:
    """Starts beyond the ends of the stable runs of a curve, from its state there.

    Where a motion doubles its period or begins to beat, others go on from it, which attract few states.
    """
    branch, states = curve.branch, number_of_states(system)
    for run in stable_runs(branch):
        for end, side in ((run[0], -1.0), (run[-1], 1.0)):
            omega = float(branch.omega[end])
            series = with_velocity(branch.coefficients[end], omega / curve.turns)
            state = (series[0] + np.sum(series[1::2], axis=0)).tolist()
            for share in END_DISTANCES:
                if span[0] < (speed := omega * (1.0 + side * share)) < span[1]:
                    yield MotionStart(speed, (*state, *(0.0,) * (states - 2)), curve.turns)


def starts_beside(seeds: tuple[MotionStart, ...], span: tuple[float, float]) -> tuple[MotionStart, ...]:
    """The same states beside their speeds, where the motions that no curve has go on, but towards the next seed."""
    speeds, moved = np.array([seed.omega for seed in seeds]), list[MotionStart]()
    for seed in seeds:
        for side in (-1.0, 1.0):
            away = side * (speeds / seed.omega - 1.0)
            if not np.any((away > 0.0) & (away < NEXT_SHARE)):
                moved += [seed._replace(omega=seed.omega * (1.0 + side * share)) for share in BESIDE_SHARES]
    return tuple(seed for seed in moved if span[0] < seed.omega < span[1])


def starts_at(case: Any, speeds: Floats) -> tuple[Floats, Floats]:
    """Speeds (lanes,) and states (states, lanes) of random starts and of free vibrations that an order may keep up."""
    problem = _spring_problem(case)
    equation = problem.system
    draws = np.random.default_rng(SEED).random((4, RANDOM_STARTS))
    free = _free_vibration(equation, case.point.mean_torque, start_reach(case, speeds))
    orders, spring = active_orders(equation), is_spring(case.equation)
    lanes, starts = list[float](), list[Floats]()
    for omega in speeds.tolist():
        blocks = [starts_in(box_at(problem, omega), draws)]
        driven = set() if spring else {k * omega for k in orders}
        for nu in sorted({k * omega / q for k in orders for q in VIBRATION_TURNS}):
            count = MEMORY_PHASES if nu in driven else PHASES
            phases = 2.0 * np.pi * (np.arange(count) + 0.3) / count
            for a in amplitudes_at(free, nu):
                blocks.append(np.array([case.point.x + a * np.cos(phases), -a * nu * np.sin(phases)]))
        starts += blocks
        lanes += [omega] * sum(block.shape[1] for block in blocks)
    start = np.concatenate([np.empty((2, 0)), *starts], axis=1)
    more = np.zeros((number_of_states(case.system) - 2, start.shape[1]))
    return np.array(lanes), np.concatenate([start, more])


def start_reach(case: Any, speeds: Floats) -> float:
    """Largest distance [rad] of a start from the operating point, at ascending speeds (n,) [rad/s]."""
    problem = _spring_problem(case)
    return max(box_at(problem, float(w)).size for w in speeds[[0, -1]])


def _spring_problem(case: Any) -> Any:
    """Harmonic balance of the error equation of a case with the springs of its law alone, for the boxes of starts."""
    law = case.equation.law
    equation = case.equation._replace(law=law if depends(law) == 1 else Springs(law))
    leaf = leaf_of(equation, "omega")
    return second_order(equation, leaf, leaf, highest_order(equation))


class Springs(NamedTuple):
    """Springs of a law while nothing slips, without friction and memory."""

    law: Any

    def torque(self, x: Any) -> Any:
        """Torque [N*m] at torsion x [rad]."""
        return torque_of(self.law, x, 0.0, (0.0,) * states_of(self.law))

    def stiffness(self, x: Any) -> Any:
        """Slope [N*m/rad] at torsion x [rad]."""
        return spring_stiffness(self.law, x)

    def breakpoints(self) -> tuple[float, ...]:
        """Torsions [rad] where a spring has a kink."""
        return tuple(breakpoints_of(self.law))


def _free_vibration(equation: Oscillator, mean: float, reach: float) -> tuple[Floats, Floats]:
    """Amplitudes [rad] and frequencies [rad/s] of the free vibration by one harmonic, up to the largest of a start."""
    amplitude = reach * np.geomspace(1e-3, 1.0, AMPLITUDES)
    stiffness = one_harmonic(equation.law, mean, amplitude)[1]
    return amplitude, np.sqrt(np.maximum(stiffness, 0.0) / equation.J)


def amplitudes_at(free: tuple[Floats, Floats], nu: float) -> list[float]:
    """Amplitudes [rad] of the free vibration at a frequency [rad/s]."""
    amplitude, side = free[0], free[1] - nu
    index = np.flatnonzero(side[1:] * side[:-1] < 0.0)
    share = side[index] / (side[index] - side[index + 1])
    return list((amplitude[index] + share * (amplitude[index + 1] - amplitude[index])).tolist())
