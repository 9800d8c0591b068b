"""`isolas`: responses that no sweep reaches, such as subharmonic loops, found from several kinds of seeds and followed.

Seeds are the steady states of the slow flow, orbits that one harmonic allows at an end of the range, motions on which
random starts settle, and free vibrations of the frequency in question (the backbone) with all phases. Each becomes a
guess for harmonic balance with the period of the resonance; what converges and is new is followed both ways until it
closes or leaves the range.

They are looked for at the powers of 2^(1/8) rad/s inside the range (of 2^(1/16), 2^(1/32), ... where that makes fewer
than eight), at both ends, and at the system's own speed. A wider range looks at them all, and at others.

Nayfeh & Mook 1979, Nonlinear Oscillations, secs. 4.1.3, 4.1.4; Krack & Gross 2019, sec. 4.4 (isolated branches).

Which orbits are one motion: on a branch already, shifted by whole forcing periods, or mirrored.
"""

from collections.abc import Iterator
from dataclasses import replace as with_changes
from itertools import chain
from typing import Any

import numpy as np

from ...base.branch_labels import CLOSED, END, FOLD, STEP
from ...base.law import repeating, springs_only
from ...base.protocols import Balance, with_parts
from ...base.quantities import interval, leaf_of, replace
from ...base.results import Branch, Floats, SolveError
from ...numerics.attractors.attractors import Motion
from ...numerics.attractors.random_starts import Search, settled_motions
from ...numerics.attractors.settle import SEEN
from ...numerics.balance.fourier import stretched
from ...numerics.balance.harmonics import MOST_HARMONICS, grown, highest_order, starting_harmonics
from ...numerics.balance.rates import SAME
from ...numerics.balance.second_order import second_order
from ...numerics.balance.truncation import CURVE, Tail, tail_along
from ...numerics.continuation.connected import connected
from ...numerics.continuation.trace import Trace, describe, solve
from ...numerics.curves.backbone import backbone
from ...numerics.curves.branch_to_birth import apart_from_shorter, both_ways, subharmonic_places
from ...numerics.curves.response import frequency_response
from ...theory.resonance import SUBHARMONIC, Resonance
from ...theory.slow_flow.flow import slow_flow
from ..speed_map.search import amplitudes_at

REACH = 3.0  # a loop may leave the range by this factor and is still followed until it closes
MOST_TAIL = 1e-4  # tail of a settled motion at which harmonic balance takes it up; the branch then takes more
STEP_SHARES = (1.0, 0.5, 0.25)  # of a step, where a branch was followed back and forth
WIDTH = 1e6  # times the first speed
PROBES = (0.2, 0.5, 0.8)  # where along a new branch a known one is looked for
PER_OCTAVE, FEWEST_SPEEDS, MOST_SPEEDS = 8, 8, 4096
PHASES = 8


def has_period(point: Floats, period: int) -> bool:
    """True if an orbit takes `period` turns and no fewer: more than rounding beside the harmonics of fewer."""
    size = float(np.linalg.norm(point[:-1]))
    multiples = (period // n for n in range(1, period) if period % n == 0)
    parts = (point[subharmonic_places(len(point) // 2 - 1, multiple)] for multiple in multiples)
    return all(np.linalg.norm(part) > 1e-6 * size for part in parts)


def is_on_branch(problem: Any, point: Floats, branch: Branch) -> bool:
    """True if an orbit, or a copy of it, is on a branch: the same motion at its frequency."""
    omega = float(point[-1])
    side, stretch = branch.omega - omega, problem.turns // branch.period
    for i in np.flatnonzero(side[1:] * side[:-1] <= 0.0):
        width = side[i] - side[i + 1]
        share = float(side[i] / width) if width != 0.0 else 0.0
        series = (1.0 - share) * branch.coefficients[i] + share * branch.coefficients[i + 1]
        orbit = solve(problem, problem.point(stretched(series[:, None], stretch), omega))
        if orbit is not None and are_copies(point[:-1] + problem.error, orbit[:-1] + problem.error, problem.turns):
            return True
    return False


def are_copies(x: Floats, y: Floats, period: int) -> bool:
    """True if two series (blocks) are one motion but for whole forcing periods, or half turns and a mirror."""
    h = len(x) // 2
    k = np.arange(h + 1)
    a = np.append(x[0], x[1 : h + 1] - 1j * x[h + 1 :])
    b = np.append(y[0], y[1 : h + 1] - 1j * y[h + 1 :])
    halves = np.arange(2 * period)[:, None]
    shifted = b * np.exp(1j * np.pi * k * halves / period) * (-1.0) ** halves
    return bool(np.min(np.linalg.norm(shifted - a, axis=1)) < 1e-5 * np.linalg.norm(a))


def speeds(speed: float, lo: float, hi: float) -> Floats:
    """Speeds [rad/s] in a range at which orbits are looked for, rising."""
    per_octave = PER_OCTAVE
    while True:
        first, last = np.ceil(per_octave * np.log2(lo)), np.floor(per_octave * np.log2(hi))
        if last - first + 1 >= FEWEST_SPEEDS or per_octave >= MOST_SPEEDS:
            break
        per_octave *= 2
    grid = 2.0 ** (np.arange(first, last + 1) / per_octave)
    inside = [speed] if lo <= speed <= hi else []
    return np.unique(np.concatenate([[lo, hi], inside, grid[(grid > lo) & (grid < hi)]]))


def slow_seeds(problem: Any, resonance: Resonance, grid: Floats) -> Iterator[tuple[Floats, str]]:
    """Orbits at the ends of the range; steady states of the slow flow, stable and unstable."""
    if resonance.q == 1:
        for omega in (float(grid[0]), float(grid[-1])):
            for table in connected(problem, omega, []).tables:
                guess = problem.fitted(table, omega)
                if guess is not None:
                    yield guess, f"seeded by an orbit of the excitation at other strengths, omega = {omega:.6g} rad/s"
    for omega in grid.tolist():
        try:
            states = slow_flow(replace(problem.system, {"omega": omega}), resonance).steady_states()
        except (ValueError, SolveError):
            continue
        for s in states:
            if s.amplitude > 0.0:
                origin = (
                    f"seeded by the slow flow of the {resonance.p}:{resonance.q} resonance at omega = {omega:.6g} "
                    f"rad/s, a = {s.amplitude:.6g} ({'stable' if s.stable else 'unstable'})"
                )
                yield _with_component(problem, omega, resonance.p, s.amplitude, s.phase), origin


def free_seeds(problem: Any, resonance: Resonance, grid: Floats) -> Iterator[tuple[Floats, str]]:
    """Free vibrations of the frequency p omega/q, with phases all around."""
    size = float(np.linalg.norm(problem.linear_response(np.sqrt(grid[0] * grid[-1]))[:-1])) or 1.0
    curve = backbone(
        problem.system, size * np.geomspace(1e-2, 1e2, 41), harmonics=max(7, highest_order(problem.system))
    )
    for omega in grid.tolist():
        for a in amplitudes_at((curve.amplitude, curve.omega), resonance.p * omega / resonance.q):
            for phase in 2.0 * np.pi * np.arange(PHASES) / PHASES:
                origin = (
                    f"seeded by the free vibration of {resonance.p}/{resonance.q} of omega = {omega:.6g} rad/s, "
                    f"amplitude {a:.6g}, phase {phase:.3g}"
                )
                yield _with_component(problem, omega, resonance.p, a, float(phase)), origin


def _with_component(problem: Any, omega: float, p: int, amplitude: float, phase: float) -> Floats:
    """Linear response plus amplitude cos(p angle - phase), in coefficients of the orbit's own angle."""
    z: Floats = problem.linear_response(omega)
    z[p], z[problem.harmonics() + p] = amplitude * np.cos(phase), amplitude * np.sin(phase)
    return z


def table_of(motion: Motion) -> Floats:
    """Table (2H+1, 1) of the first state of a settled motion: mean, cos 1, sin 1, ..."""
    spectrum = np.fft.rfft(motion.samples[0]) * (2.0 / motion.samples.shape[1])
    series = np.empty(2 * len(spectrum) - 3)  # the last of the spectrum belongs to a harmonic with no room for its sine
    series[0], series[1::2], series[2::2] = 0.5 * spectrum[0].real, spectrum[1:-1].real, -spectrum[1:-1].imag
    return series[:, None]


class Isolas(list[Branch]):
    """Branches that are no part of the main one, a list; `message` says what was searched and what else was met."""

    def __init__(self, branches: list[Branch], message: str) -> None:
        super().__init__(branches)
        self.message = message

    def __str__(self) -> str:
        return "\n".join([*map(str, self), self.message])


def isolas(
    system: Any,
    span: tuple[float, float],
    *,
    resonance: Resonance = SUBHARMONIC,
    harmonics: int | None = None,
    points: int = 200,
) -> Isolas:
    """Find the responses of a resonance that are no part of the main branch, and follow them through the range.

    Parameters
    ----------
    system : Oscillator
        The forced system.
    span : (float, float)
        Range of omega [rad/s] in which to look, 0 < low < high.
    resonance : Resonance
        p omega ~ q omega_0; the orbits take q forcing periods.
    harmonics : int, optional
        Highest harmonic of omega/q. Default: grown as in `frequency_response`.
    points : int
        About how many points to place on each.

    Returns
    -------
    list of Branch
        Each has `omega` [rad/s] and `peak`, largest |x| [rad], in arc order. Without copies (orbits shifted by whole
        forcing periods, or mirrored and shifted by half a turn). `closed` says whether it is a loop: it is followed
        outside the range too, up to three times its ends; a branch that does not close there is cut to the range.
        `origin` says how it was found. For q = 1 parts of the main branch are left out. The list has a `message`: the
        speeds that were searched, the number of random starts and how long they ran, and what they settled on that is
        not in the list: motions of other periods (up to 8 turns), and starts that did not settle. The starts are the
        same in every run.

    Raises
    ------
    ValueError
        If the range is not 0 < low < high <= 1e6 low, `resonance` is none, or nothing alternates in the excitation.
    SolveError
        If the random starts take more than 4e8 steps at first, or 3.2e9 later: a wide range, low speeds, light damping.

    References
    ----------
    Nayfeh & Mook 1979, Nonlinear Oscillations, sec. 4.1.4.
    """
    system = repeating("isolas", with_parts("isolas", system, *SAME))
    springs_only("isolas", system)
    lo, hi = interval("the frequency range [rad/s]", span, positive=True)
    if hi > WIDTH * lo:
        raise ValueError(f"the frequency range ends at {hi / lo:.3g} times its start; take at most {WIDTH:g} times")
    resonance = Resonance.of(resonance)
    period = resonance.q
    if not period:
        raise ValueError("isolas need a resonance, such as SUBHARMONIC")
    leaf = leaf_of(system, "omega")
    problem = second_order(system, leaf, leaf, starting_harmonics(system, harmonics, period, points), period)
    if np.all(np.abs(problem.tau[1:]) <= 1e-12 * abs(problem.tau[0])) and not np.any(problem.error):
        raise ValueError(
            "the excitation and the kinematic error are constant: without forcing no resonance responds; give one of "
            "them an amplitude"
        )
    grid = speeds(system.omega, lo, hi)
    branches = [frequency_response(system, (lo, hi), harmonics=harmonics)] if period == 1 else []
    main = len(branches)
    search = settled_motions(problem, grid)
    lost: list[Motion] = []
    seeds = chain(
        _points(problem, slow_seeds(problem, resonance, grid)),
        _points(problem, free_seeds(problem, resonance, grid)),
        _settled_points(problem, search, harmonics, lost),
    )
    for balance, point, origin in seeds:
        if not has_period(point, period) or any(is_on_branch(balance, point, branch) for branch in branches):
            continue
        branch = _follow_branch(balance, point, lo, hi, harmonics, 4.0 / points, origin)
        if not any(is_on_branch(balance, probe, other) for other in branches for probe in _probes(balance, branch)):
            branches.append(branch)
    return Isolas(branches[main:], _sentence(search, period, len(branches) - main, lost))


def _points(problem: Any, seeds: Iterator[tuple[Floats, str]]) -> Iterator[tuple[Any, Floats, str]]:
    """The orbits to which guesses lead."""
    for guess, origin in seeds:
        point = solve(problem, guess)
        if point is not None:
            yield problem, point, origin


def _settled_points(
    problem: Balance, search: Search, harmonics: int | None, lost: list[Motion]
) -> Iterator[tuple[Any, Floats, str]]:
    """The orbits on which random starts settled; those that harmonic balance does not confirm are added to `lost`."""
    for motion in search.motions:
        if motion.turns != problem.turns:
            continue
        point, table, h = None, table_of(motion), problem.harmonics()
        while point is None:
            finer = second_order(problem.system, problem.leaf, problem.omega_leaf, h, problem.turns)
            guess = finer.point(table, motion.omega)
            if harmonics is not None or h >= MOST_HARMONICS or tail_along(problem, guess[None], 0.0).worst <= MOST_TAIL:
                point = solve(finer, guess)
                if harmonics is not None or h >= MOST_HARMONICS:
                    break
            h = min(2 * h + 1, MOST_HARMONICS)
        if point is None:
            lost.append(motion)
            continue
        yield finer, point, f"reached from random initial states at omega = {motion.omega:.6g} rad/s"


def _probes(problem: Balance, branch: Branch) -> Iterator[Floats]:
    """Some orbits of a branch."""
    for share in PROBES:
        i = int(share * (len(branch) - 1))
        point = solve(problem, problem.point(branch.coefficients[i, :, None], float(branch.omega[i])))
        if point is not None:
            yield point


def _sentence(search: Search, period: int, branches: int, lost: list[Motion]) -> str:
    """Sentence on the search, and on motions that are not in the list."""
    tried = search.omegas
    sentences = [
        f"{branches} branch(es) of orbits of {_turns(period)}; searched at {len(tried)} speeds, omega = {tried[0]:.6g} "
        f".. {tried[-1]:.6g} rad/s, by the slow flow, by free vibrations, and from {search.starts} random starts each "
        f"up to |x| = {search.reach:.3g} rad that ran for at most {search.turns} turns"
    ]
    for turns in sorted({m.turns for m in search.motions} - {period}):
        speeds = [m.omega for m in search.motions if m.turns == turns]
        sentences.append(
            f"initial states also settled on motions of {_turns(turns)} at omega = {_band(speeds)} rad/s: "
            f"see isolas with Resonance(1, {turns})" + (" and frequency_response" if turns == 1 else "")
        )
    if lost:
        listing = ", ".join(f"{w:.6g}" for w in dict.fromkeys(m.omega for m in lost))
        sentences.append(
            f"settled motions at omega = {listing} rad/s were not found by harmonic balance: use more harmonics"
        )
    if search.unsettled:
        listing = ", ".join(f"{w:.6g}" for w in search.loose)
        sentences.append(
            f"{search.unsettled} starts, at omega = {listing} rad/s, did not settle on a period of up to {SEEN} turns "
            "(chaos, a longer period or a slow transient)"
        )
    if search.diverged:
        sentences.append(f"{search.diverged} initial states diverged")
    return "; ".join(sentences)


def _band(values: list[float]) -> str:
    low, high = min(values), max(values)
    return f"{low:.6g}" if low == high else f"{low:.6g} .. {high:.6g}"


def _turns(number: int) -> str:
    return f"{number} turn" if number == 1 else f"{number} turns"


def _follow_branch(
    problem: Balance, point: Floats, lo: float, hi: float, harmonics: int | None, step: float, origin: str
) -> Branch:
    """Follow a branch through a point with as many harmonics as it needs, or as many as its orbit is found with."""
    best: tuple[Trace, list[float], Tail] | None = None

    def follow(h: int, _: float) -> tuple[tuple[Trace, list[float], Tail], float]:
        nonlocal problem, point, best
        if best is not None:
            finer = second_order(problem.system, problem.leaf, problem.omega_leaf, h, problem.turns)
            better = solve(finer, finer.point(problem.state_table(problem.table(point)), float(point[-1])))
            if better is None:
                return best, 0.0
            problem, point = finer, better
        for share in STEP_SHARES:
            trace, born = _follow_both_ways(problem, point, lo, hi, share * step)
            if not _turns_back(trace):
                break
        best = trace, born, tail_along(problem, trace.points, np.inf)
        return best, best[-1].worst

    h = problem.harmonics()
    trace, born, tail = grown(follow, h, MOST_HARMONICS if harmonics is None else h, CURVE)
    trace, omega = _with_set_speed(problem, trace), trace.points[:, -1]
    if born:
        places = " and ".join(f"{end:.6g}" for end in born)
        trace = with_changes(trace, message=f"meets the response of one turn at omega = {places} rad/s")
    elif trace.outcome == CLOSED:
        ends = f"closed, omega = {omega.min():.9g} .. {omega.max():.9g} rad/s"
        trace = with_changes(trace, message=ends)
    return describe(problem, "omega", trace, tail, origin)


def _follow_both_ways(problem: Any, point: Floats, lo: float, hi: float, step: float) -> tuple[Trace, list[float]]:
    """The branch through a point: all of it where it closes or ends at orbits of one turn, else what the range has.

    And where [rad/s] it ends at orbits of one turn. A trace would go on there through the same orbits, shifted by one
    turn, turn back, or take the main response: rounding decides.
    """
    apart = apart_from_shorter(problem, point)
    for first, last in ((lo / REACH, hi * REACH), (lo, hi)):
        trace = both_ways(problem, point, first, last, step, apart=apart)
        ends = trace.points[[0, -1], -1].tolist() if trace.outcome == END else []
        born = [end for end in ends if first < end < last]
        if trace.outcome == CLOSED or len(born) == 2:  # again, in steps that suit it
            width = float(np.ptp(trace.points[:, -1]))
            return both_ways(problem, point, first, last, step, width, apart=apart), born
    return trace, born


def _turns_back(trace: Trace) -> bool:
    """True if a fold is on a branch twice: a step past a branch point may turn round, and follow all of it again."""
    folds = trace.points[trace.labels == FOLD]
    if len(folds) < 2:
        return False
    gaps = np.linalg.norm(folds[:, None] - folds, axis=2) + np.diag(np.full(len(folds), np.inf))
    return bool(np.min(gaps / np.linalg.norm(folds[:, :-1], axis=1)) < 1e-5)


def _with_set_speed(problem: Balance, trace: Trace) -> Trace:
    """The branch with points at the system's own omega."""
    points, labels, omega = trace.points, trace.labels, problem.system.omega
    side = points[:, -1] - omega
    for i in np.flatnonzero(side[1:] * side[:-1] < 0.0)[::-1]:
        guess = points[i] + side[i] / (side[i] - side[i + 1]) * (points[i + 1] - points[i])
        guess[-1] = omega
        orbit = solve(problem, guess)
        if orbit is not None and np.linalg.norm(orbit - guess) < np.linalg.norm(points[i + 1] - points[i]):
            points, labels = np.insert(points, i + 1, orbit, axis=0), np.insert(labels, i + 1, STEP)
    return Trace(points, labels, trace.outcome)
