"""`isolas`: responses that no sweep reaches, such as subharmonic loops, seeded by the slow flow and then continued.

Each steady state of the slow flow, and each orbit that a harmonic alone allows at an end of the range, becomes a guess
for harmonic balance with the period of its resonance; what converges is followed both ways until it closes. Where the
slow flow does not know the resonance or no state converges, the free vibration of the same frequency (the backbone) is
tried with all phases, and then integration from those states.

Nayfeh & Mook 1979, Nonlinear Oscillations, secs. 4.1.3, 4.1.4; Krack & Gross 2019, sec. 4.4 (isolated branches).
"""

from collections.abc import Iterator
from dataclasses import replace as with_changes
from typing import Any

import numpy as np

from .._dispatch import springs_only
from ..numerics.backbone import backbone
from ..numerics.balance import second_order
from ..numerics.branches import Trace, leaf_of, solve
from ..numerics.coexisting import guesses
from ..numerics.continuation import CLOSED, END, FOLD, STEP
from ..numerics.description import describe
from ..numerics.fourier import from_blocks
from ..numerics.guess import linear_response
from ..numerics.harmonics import MOST, highest_order, starting_harmonics
from ..numerics.integrate import Dopri5, simulate
from ..numerics.parameter_sweep import SECOND_ORDER, both_ways, embedded_series
from ..numerics.response import frequency_response
from ..numerics.switching import UPRIGHT
from ..numerics.truncation import CURVE, tail_along
from ..quantities import interval, replace, shown, with_parts
from ..results import Branch, Floats, SolveError
from ..theory.multiple_scales import slow_flow
from ..theory.resonance import SUBHARMONIC, Resonance

SPEEDS = 12  # at which the slow flow is asked
PHASES = 8
REACH = 3.0  # a loop may leave the range by this factor and is still followed until it closes
SPARSE = 5  # one in so many seeds is integrated
SETTLING = 150  # periods of integration before a guess is read


def isolas(
    system: Any,
    span: tuple[float, float],
    *,
    resonance: Resonance = SUBHARMONIC,
    harmonics: int | None = None,
    points: int = 200,
) -> list[Branch]:
    """Find the responses of a resonance that are no part of the main branch, and follow them until they close.

    Parameters
    ----------
    system : Oscillator
        The forced system.
    span : (float, float)
        Range of omega [rad/s] in which to look, 0 < low < high.
    resonance : Resonance
        p omega ~ q omega_0; the orbits take q turns of the base angle.
    harmonics : int, optional
        Highest harmonic of omega/q. Default: grown as in `frequency_response`.
    points : int
        About how many points to place on each.

    Returns
    -------
    list of Branch
        Without copies (orbits shifted by whole turns of the base angle). `closed` says whether it is a loop: it is
        followed outside the range too, up to three times its ends; a branch that does not close there is cut to the
        range. `origin` says how it was found. For q = 1 parts of the main branch are left out.

    Raises
    ------
    ValueError
        If the range is not 0 < low < high, `resonance` is none, or nothing alternates in the excitation.

    References
    ----------
    Nayfeh & Mook 1979, Nonlinear Oscillations, sec. 4.1.4.
    """
    system = with_parts("isolas", system, *SECOND_ORDER)
    springs_only("isolas", system)
    lo, hi = interval("the frequency range [rad/s]", span, positive=True)
    if not (isinstance(resonance, tuple) and len(resonance) == 2 and Resonance(*resonance).checked().q):
        raise ValueError(f"resonance is {shown(resonance)}; isolas need a Resonance(p, q) such as SUBHARMONIC")
    resonance = Resonance(*resonance).checked()
    period = resonance.q
    leaf = leaf_of(system, "omega")
    problem = second_order(system, leaf, leaf, starting_harmonics(system, harmonics, period, points), period)
    if np.all(np.abs(problem.tau[1:]) <= 1e-12 * abs(problem.tau[0])) and not np.any(problem.error):
        raise ValueError(
            "the excitation and the kinematic error are constant: without forcing no resonance responds; give one of "
            "them an amplitude"
        )
    main = [frequency_response(system, (lo, hi), harmonics=harmonics)] if period == 1 else []
    found: list[Branch] = []
    reached = False
    for seeds in (_first_seeds, _free_seeds, _settled_seeds):
        for guess, origin in seeds(problem, resonance, lo, hi):
            point = solve(problem, guess)
            if point is None or not _subharmonic(point, period):
                continue
            reached = True
            if any(_lies_on(problem, point, branch) for branch in [*main, *found]):
                continue
            found.append(_followed(problem, point, lo, hi, harmonics, 4.0 / points, origin))
        if reached:
            break
    return found


def _followed(
    problem: Any, point: Floats, lo: float, hi: float, harmonics: int | None, step: float, origin: str
) -> Branch:
    """Follow a branch through a point with as many harmonics as it needs."""
    while True:
        trace = both_ways(problem, point, lo / REACH, hi * REACH, step)
        if trace.outcome == CLOSED:  # again, in steps that suit the loop
            size = float(np.ptp(trace.points[:, -1]))
            trace = both_ways(problem, point, lo / REACH, hi * REACH, step, size)
        else:
            trace = both_ways(problem, point, lo, hi, step)
        tail = tail_along(problem, trace.points)
        h = len(problem.tau) // 2
        if harmonics is not None or tail.worst <= CURVE or h >= MOST:
            break
        h = min(2 * h + 1, MOST)
        finer = second_order(problem.system, problem.leaf, problem.omega_leaf, h, problem.turns)
        series = from_blocks(point[:-1] + problem.error)
        better = solve(finer, embedded_series(finer, np.append(series, point[-1])))
        if better is None:
            break
        problem, point = finer, better
    trace, born = _one_copy(trace, problem.turns)
    trace, omega = _with_own_speed(problem, trace), trace.points[:, -1]
    if born:
        meets = f"meets the response of one turn at omega = {omega[0]:.6g} and {omega[-1]:.6g} rad/s"
        trace = with_changes(trace, message=meets)
    elif trace.outcome == CLOSED:
        ends = f"closed, omega = {omega.min():.9g} .. {omega.max():.9g} rad/s"
        trace = with_changes(trace, message=ends)
    return describe(problem, "omega", trace, tail, origin)


def _one_copy(trace: Trace, period: int) -> tuple[Trace, bool]:
    """Where a loop passes through orbits of one turn, that part of it which holds each orbit once.

    Orbits of two turns end at period doublings of the main response; beyond it the loop goes on through the same
    orbits, shifted by one turn.
    """
    if trace.outcome != CLOSED or period == 1:
        return trace, False
    part = trace.points[:, _own_harmonics(trace.points.shape[1], period)]
    flips = np.flatnonzero(np.sum(part[1:] * part[:-1], axis=1) < 0.0)
    if len(flips) != 2:
        return trace, False
    kept = np.r_[flips[1] + 1 : len(part) - 1, 0 : flips[0] + 1]
    size = np.linalg.norm(part[kept], axis=1)
    upright = (trace.labels[kept] == FOLD) & (size < UPRIGHT * np.max(size))
    return Trace(trace.points[kept], np.where(upright, STEP, trace.labels[kept]), END), True


def _with_own_speed(problem: Any, trace: Trace) -> Trace:
    """The branch with points at the system's own omega."""
    points, labels, omega = trace.points, trace.labels, problem.system.omega
    side = points[:, -1] - omega
    for i in np.flatnonzero(side[1:] * side[:-1] < 0.0)[::-1]:
        share = side[i] / (side[i] - side[i + 1])
        guess = points[i] + share * (points[i + 1] - points[i])
        guess[-1] = omega
        there = solve(problem, guess)
        if there is not None and np.linalg.norm(there - guess) < np.linalg.norm(points[i + 1] - points[i]):
            points, labels = np.insert(points, i + 1, there, axis=0), np.insert(labels, i + 1, STEP)
    return Trace(points, labels, trace.outcome)


def _own_harmonics(size: int, period: int) -> list[int]:
    """Places (in blocks) of the harmonics that an orbit of one turn does not have."""
    h = size // 2 - 1
    rest = [k for k in range(1, h + 1) if k % period]
    return rest + [h + k for k in rest]


def _subharmonic(point: Floats, period: int) -> bool:
    """Whether an orbit really takes `period` turns: more than rounding beside the harmonics of one turn."""
    own = point[_own_harmonics(len(point), period)]
    return period == 1 or bool(np.linalg.norm(own) > 1e-6 * np.linalg.norm(point[:-1]))


def _lies_on(problem: Any, point: Floats, branch: Branch) -> bool:
    """Whether an orbit, or a copy of it shifted by whole turns, is on a branch: equal harmonics at its frequency."""
    n, omega = len(point) - 1, float(point[-1])
    h = n // 2
    x = point[:-1] + problem.error
    mine = np.hypot(x[1 : h + 1], x[h + 1 :])
    size = float(np.linalg.norm(mine))
    side, stretch = branch.omega - omega, problem.turns // branch.period
    for i in np.flatnonzero(side[1:] * side[:-1] <= 0.0):
        width = side[i] - side[i + 1]
        share = float(side[i] / width) if width != 0.0 else 0.0
        series = (1.0 - share) * branch.coefficients[i] + share * branch.coefficients[i + 1]
        there = solve(problem, embedded_series(problem, np.append(series, omega), stretch))
        if there is None:
            continue
        y = there[:-1] + problem.error
        if np.linalg.norm(np.hypot(y[1 : h + 1], y[h + 1 :]) - mine) < 1e-5 * size:
            return True
    return False


def _speeds(problem: Any, lo: float, hi: float) -> Floats:
    own = [problem.system.omega] if lo <= problem.system.omega <= hi else []
    return np.array([*own, *np.geomspace(lo, hi, SPEEDS + 2)[1:-1]])


def _with_component(problem: Any, omega: float, p: int, amplitude: float, phase: float) -> Floats:
    """Linear response plus amplitude cos(p angle - phase), in coefficients of the orbit's own angle."""
    z = linear_response(problem, omega)
    h = len(problem.tau) // 2
    z[p], z[h + p] = amplitude * np.cos(phase), amplitude * np.sin(phase)
    return z


def _first_seeds(problem: Any, resonance: Resonance, lo: float, hi: float) -> Iterator[tuple[Floats, str]]:
    """What a harmonic alone allows at the ends of the range, through which branches may enter, and the slow flow."""
    if resonance.q == 1:
        for omega, some in guesses(problem, (lo, hi)).items():
            for guess in some:
                yield guess, f"seeded by what one harmonic allows at the end of the range, omega = {omega:.6g} rad/s"
    yield from _slow_seeds(problem, resonance, lo, hi)


def _slow_seeds(problem: Any, resonance: Resonance, lo: float, hi: float) -> Iterator[tuple[Floats, str]]:
    """Steady states of the slow flow, stable and unstable."""
    for omega in _speeds(problem, lo, hi):
        try:
            states = slow_flow(replace(problem.system, {"omega": float(omega)}), resonance).steady_states()
        except (ValueError, SolveError):
            continue
        for s in states:
            if s.amplitude > 0.0:
                origin = (
                    f"seeded by the slow flow of the {resonance.p}:{resonance.q} resonance at omega = {omega:.6g} "
                    f"rad/s, a = {s.amplitude:.6g} ({'stable' if s.stable else 'unstable'})"
                )
                yield _with_component(problem, float(omega), resonance.p, s.amplitude, s.phase), origin


def _free_seeds(problem: Any, resonance: Resonance, lo: float, hi: float) -> Iterator[tuple[Floats, str]]:
    """Free vibrations of the frequency p omega/q, with phases all around."""
    size = float(np.linalg.norm(linear_response(problem, np.sqrt(lo * hi))[:-1])) or 1.0
    curve = backbone(
        problem.system, size * np.geomspace(1e-2, 1e2, 41), harmonics=max(7, highest_order(problem.system))
    )
    for omega in _speeds(problem, lo, hi):
        side = curve.omega - resonance.p * omega / resonance.q
        for i in np.flatnonzero(side[1:] * side[:-1] < 0.0):
            share = side[i] / (side[i] - side[i + 1])
            a = float((1.0 - share) * curve.amplitude[i] + share * curve.amplitude[i + 1])
            for phase in 2.0 * np.pi * np.arange(PHASES) / PHASES:
                origin = (
                    f"seeded by the free vibration of {resonance.p}/{resonance.q} of omega = {omega:.6g} rad/s, "
                    f"amplitude {a:.6g}, phase {phase:.3g}"
                )
                yield _with_component(problem, float(omega), resonance.p, a, float(phase)), origin


def _settled_seeds(problem: Any, resonance: Resonance, lo: float, hi: float) -> Iterator[tuple[Floats, str]]:
    """What an integration from the free vibrations settles on."""
    samples = len(problem.angles)
    for guess, origin in list(_free_seeds(problem, resonance, lo, hi))[::SPARSE]:
        system = replace(problem.system, {"omega": float(guess[-1])})
        turn = 2.0 * np.pi * problem.turns / system.omega
        series = guess[:-1] + problem.error
        h = len(series) // 2
        start = (float(np.sum(series[: h + 1])), float(np.arange(1, h + 1) @ series[h + 1 :]) * 2.0 * np.pi / turn)
        times = np.concatenate([[0.0], turn * (SETTLING + np.arange(samples) / samples)])
        run = simulate(system, start, times, method=Dopri5(rtol=1e-7, atol=1e-12))
        if run.status:
            settled = np.append(run.y[0, 1:] @ problem.analysis - problem.error, guess[-1])
            yield settled, f"settled by integration; {origin}"
