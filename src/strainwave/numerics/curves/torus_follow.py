"""The waves that a motion of two turns takes: at one speed, and along a curve through a range of speeds.

The balance begins with the waves that are driven. Where a torque has a wave that the balance leaves out and that would
move the drive by more than a share of the whole, that wave is taken in, and the balance solved again.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...base.branch_labels import STEP
from ...base.results import Floats, SolveError
from ...base.sentences import Sentence, Speed
from ..balance.linear_algebra import factor, substitute
from ..continuation.arc_length import ROW, SCALE, Z, buffers_for, correct
from ..continuation.trace import Trace, state_from, trace
from .torus_problem import Motion, Torus, linear_waves, torus

ROUNDS, MOST_WAVES, ALONG = 40, 800, 450  # of taking waves in, and waves at most: of a motion, and of a curve
COARSEST = 1e-7  # share of the whole in a wave that a motion of too many waves leaves out
WINDING = 150  # waves of a curve that winds, to which no more are added
HALVINGS, SETTLED, NEWTON = 6, 1e-10, 30  # of a step, its relative size at the end, and steps
MARGIN = 0.5  # of the share that may be left out: waves that are taken in leave less out than those looked for
SMALL_TORQUE = 1e-3  # of the share of what is left out: torques below it are not looked at
LOOKED_AT, BESIDE = 8, np.array([0, 3, -3, 8, -8])  # points where missing waves are looked for: all along, at a crest
LENGTH = 0.1
BESIDE_CREST = 1e-3  # of a step: a crest so close to a point is that point
ON_LEVEL, REFINED = 1e-9, 50  # relative distance of a crossing's size from its level, and steps to it
FEW_PAIRS = 4  # driven pairs up to which the balance begins with sums of three


@dataclass(frozen=True)
class TwoTurns:
    """Drive of a train in two turns: see `torus`; `pairs` are those of the torques, the lines and the pulls.

    The balance begins with the sums of these, and with those that are `likely` besides.
    """

    part: Any
    ratio: float
    lines: Floats
    pairs: tuple[tuple[int, int], ...]
    pulls: tuple[Any, ...] = ()
    likely: tuple[Any, ...] = ()

    def problem(self, pairs: Any) -> Torus:
        """The balance in some waves."""
        return torus(self.part, self.ratio, self.lines, sorted(pairs), self.pulls)


@np.errstate(over="ignore", invalid="ignore")  # a point beyond all floats is none
def newton(problem: Torus, z: Floats) -> Floats | None:
    """Point with the speed of z that solves a problem, by Newton's method with shortened steps; None where it fails."""
    n = problem.size()
    r, a, slope, pivots = np.empty(n), np.empty((n, n)), np.empty(n), np.empty(n, np.int64)
    problem.residual(z, r)
    for _ in range(NEWTON):
        problem.linearise(z, a, slope)
        if not factor(a, pivots):
            return None
        substitute(a, pivots, r)
        step, size, share = r.copy(), float(np.linalg.norm(r)), 1.0
        for _ in range(HALVINGS):
            after = np.append(z[:n] - share * step, z[n])
            problem.residual(after, r)
            trial = r.copy()
            substitute(a, pivots, trial)
            if np.linalg.norm(trial) <= (1.0 - 0.25 * share) * size:
                break
            share *= 0.5
        z = after
        if not np.all(np.isfinite(z)):
            return None
        if share * size <= SETTLED * max(float(np.linalg.norm(z[:n])), 1e-300):
            return z
    return None


def missing(problem: Torus, points: Floats, aim: float) -> dict[tuple[int, int], Any]:
    """Waves beside those of a problem that its torques at points (n, ...) would move by more than a share of the whole.

    With the complex amplitudes (n, coordinates) that they would have.
    """
    motion, blocks = problem.moved(points), problem.blocks(points)
    rows, columns = problem.shape
    spectrum = np.fft.fft2(motion.torque.reshape(*motion.torque.shape[:-1], *problem.shape)) * (2.0 / (rows * columns))
    spectrum.reshape(*motion.torque.shape)[..., np.concatenate([problem.plus[0], problem.minus[0]])] = 0.0
    top = np.max(np.abs(motion.torque), axis=-1)[..., None, None] + 1e-300
    fast, slow = np.nonzero(np.any(np.abs(spectrum) > SMALL_TORQUE * aim * top, axis=(0, 1))[: rows // 2 + 1])
    cells = np.column_stack([fast, np.where(slow > columns // 2, slow - columns, slow)])
    cells = cells[(cells[:, 0] > 0) | (cells[:, 1] > 0)]
    if not len(cells):
        return {}
    pairs = cells @ problem.basis
    torques = np.moveaxis(spectrum[..., cells[:, 0], cells[:, 1]], 0, -1)
    moved = answers(problem, motion, points, pairs @ np.array([1.0, 1.0 / problem.ratio]), torques)
    sizes = np.linalg.norm(blocks[..., 1:], axis=-1).T
    share = np.abs(moved) / np.maximum(sizes, 1e-6 * sizes.max(axis=1, keepdims=True) + 1e-300)[:, None]
    counted = np.flatnonzero(share.max(axis=(0, 2)) > aim)
    waves = {tuple(pairs[i].tolist()): -moved[:, i] for i in counted.tolist()}
    return {upper(*pair): wave if pair == upper(*pair) else wave.conj() for pair, wave in waves.items()}


def answers(problem: Torus, motion: Motion, points: Floats, orders: Floats, torques: Any) -> Any:
    """Amplitudes (n, P, coordinates) that torques move a drive by at orders (P,), with the mean stiffness of points."""
    driven = np.zeros((len(orders), len(problem.part.inertia)))
    linear = linear_waves(problem.part, problem.linear.retained, orders, driven)
    stiff = linear.stiffness(points[:, -1])[0][..., :-1].copy()
    for (a, b), samples in motion.by_place.items():
        stiff[..., a, b] += np.mean(samples, axis=-1)[:, None]
    for (a, b), samples in motion.by_rate.items():
        stiff[..., a, b] += 1j * orders * np.mean(samples, axis=-1)[:, None]
    return np.linalg.solve(stiff, torques[..., None])[..., 0]


def upper(j: int, k: int) -> tuple[int, int]:
    """The same wave with j > 0, or j = 0 and k > 0."""
    return (j, k) if j > 0 or (j == 0 and k > 0) else (-j, -k)


def carried_over(old: Torus, new: Torus, points: Floats) -> Floats:
    """Points (n, ...) of a problem as those of one with more waves."""
    h, size = len(old.pairs) - 1, 2 * len(new.pairs) - 1
    index = {pair: i for i, pair in enumerate(map(tuple, new.pairs.tolist()))}
    columns = np.array([index[pair] for pair in map(tuple, old.pairs.tolist())])
    out = np.zeros((len(points), len(new.linear.retained), size))
    blocks = points[:, :-1].reshape(len(points), len(old.linear.retained), -1)
    out[..., columns] = blocks[..., : h + 1]
    out[..., len(new.pairs) - 1 + columns[1:]] = blocks[..., h + 1 :]
    return np.column_stack([out.reshape(len(points), -1), points[:, -1]])


def with_sums(pairs: Any) -> set[tuple[int, int]]:
    """Pairs with the sums and differences of three of them, which a cubic law makes; of many, of two."""
    signed = [(s * j, s * k) for j, k in pairs for s in (1, -1)]
    sums = set(signed)
    for _ in range(2 if len(pairs) <= FEW_PAIRS else 1):
        sums |= {(a + c, b + d) for a, b in sums for c, d in signed}
    return {(j, k) for j, k in sums if j > 0 or (j == 0 and k > 0)}


def at_speed(
    driven: TwoTurns, omega: float, aim: float, guess: tuple[Torus, Floats] | None = None
) -> tuple[Torus, Floats]:
    """Problem and point of the motion at a speed [rad/s], next to a guess or to the response at rest.

    Raises
    ------
    SolveError
        If Newton's method finds none.
    """
    pairs = (
        with_sums(driven.pairs) | {*driven.likely}
        if guess is None
        else {*driven.pairs, *map(tuple, guess[0].pairs[1:].tolist())}
    )
    problem = driven.problem(pairs)
    z = np.append(np.zeros(problem.size()), omega)
    if guess is not None:
        z = carried_over(guess[0], problem, guess[1][None])[0]
        z[-1] = omega
    for _ in range(ROUNDS):
        solution = newton(problem, z)
        if solution is None:
            raise SolveError(
                Sentence("no motion of two turns was found at {}; follow it from another speed", Speed(omega))
            )
        missed = {*missing(problem, solution[None], aim)}
        while len(pairs | missed) > MOST_WAVES and aim < COARSEST:
            aim *= 10.0
            missed = {*missing(problem, solution[None], aim)}
        if not missed:
            return problem, solution
        pairs |= missed
        if len(pairs) > MOST_WAVES:
            break
        old, problem = problem, driven.problem(pairs)
        z = carried_over(old, problem, solution[None])[0]
    raise SolveError(Sentence("a motion of two turns at {} takes more than {} waves", Speed(omega), len(pairs)))


def along(driven: TwoTurns, lo: float, hi: float, aim: float) -> tuple[Torus, Trace, bool]:
    """Problem and curve of the motions through a range of speeds [rad/s] from its upper end; whether no wave lacks."""
    problem, z = at_speed(driven, hi, aim)
    was_cut = False
    for _ in range(ROUNDS):
        balance: Any = problem
        solution = trace(balance, z, -1.0, lo, hi, LENGTH, pieces=1)
        points = solution.points
        if not len(points):
            raise SolveError(Sentence("the curve of motions of two turns is lost at {}", Speed(hi)))
        top = int(np.argmax(np.linalg.norm(points[:, :-1], axis=1)))
        turning = np.flatnonzero(solution.labels > STEP)
        places = np.concatenate([top + BESIDE, turning, np.linspace(0, len(points) - 1, LOOKED_AT).astype(int)])
        sample = np.clip(places, 0, len(points) - 1)
        lacking = missing(problem, points[sample], aim)
        if solution.is_cut and (was_cut or not lacking or len(problem.pairs) > WINDING):
            text = (
                "the curve of motions of two turns winds at {}; give the drive more damping, or end the range above it"
            )
            raise SolveError(Sentence(text, Speed(float(points[-1, -1]))))
        if not lacking:
            return problem, solution, True
        was_cut = solution.is_cut  # a curve of too few waves may wind where that of more does not
        wider = with_missing(driven, problem, points[sample], np.gradient(points, axis=0)[sample], MARGIN * aim)
        if len(wider.pairs) > ALONG:
            break
        z, problem = carried_over(problem, wider, z[None])[0], wider
    return problem, solution, False


def with_missing(driven: TwoTurns, problem: Torus, points: Floats, chords: Floats, aim: float) -> Torus:
    """A problem with the waves that motions near some points (n, ...) take besides, with chords of the curve there.

    The points, those at a crest first, have these waves as they are moved, while these make fewer and fewer others.
    Then the motions at the crest are solved for; at all points where waves make more and more others. Where they are
    more than a curve may have, all motions are solved for from the beginning, which takes fewer.
    """
    begun, lacking, before = (problem, points, chords), missing(problem, points, aim), MOST_WAVES
    while lacking and len(lacking) < before and len(problem.pairs) <= ALONG:
        old, problem, before = problem, _with(driven, problem, lacking), len(lacking)
        points, chords = carried_over(old, problem, points), carried_over(old, problem, chords)
        blocks, h = problem.blocks(points), len(problem.pairs) - 1
        for i, pair in enumerate(map(tuple, problem.pairs.tolist())):
            if pair in lacking:
                blocks[..., i], blocks[..., h + i] = lacking[pair].T.real, -lacking[pair].T.imag
        lacking = missing(problem, points, aim)
    if beyond := len(problem.pairs) > ALONG:
        problem, points, chords = begun
    old = problem
    for pair in list(zip(points, chords, strict=True))[: None if lacking or beyond else len(BESIDE)]:
        z, chord = carried_over(old, problem, np.array(pair))
        corrected = on_plane(problem, z, chord)
        while (
            corrected is not None
            and len(problem.pairs) <= ALONG
            and (lacking := missing(problem, corrected[None], aim))
        ):
            wider = _with(driven, problem, lacking)
            z, chord = carried_over(problem, wider, np.array([corrected, chord]))
            corrected, problem = on_plane(wider, z, chord), wider
    return problem


def _with(driven: TwoTurns, problem: Torus, more: Any) -> Torus:
    """The problem with more waves."""
    return driven.problem({*map(tuple, problem.pairs[1:].tolist()), *more})


def on_plane(problem: Torus, z: Floats, chord: Floats) -> Floats | None:
    """Point of the curve in the plane through a point across a chord: at a crest too, which more waves move."""
    n, state = problem.size(), state_from(z, float(z[-1]))
    a, pivots, _ = buffers_for(problem)
    state[Z], state[ROW] = z, chord * state[SCALE] ** 2
    with np.errstate(all="ignore"):
        solved = correct(problem, n, state, float(state[ROW] @ z), a, pivots, NEWTON, False)[0]
    return state[Z] if solved else None


def with_crests(problem: Torus, points: Floats, measure: Callable[[Floats], Floats]) -> tuple[Floats, Floats]:
    """Points (n, ...) of a curve with those at the crests of a measure (n,), by parabolas through three; and this."""
    sizes = measure(points)
    for _ in range(2):
        rows, values = list(points), sizes.tolist()
        for i in (1 + np.flatnonzero((sizes[1:-1] > sizes[:-2]) & (sizes[1:-1] >= sizes[2:])))[::-1].tolist():
            w, y = points[i - 1 : i + 2, -1] - points[i, -1], sizes[i - 1 : i + 2] - sizes[i]
            if w[0] * w[2] >= 0.0:  # beside a fold
                continue
            left, right = y[0] / w[0], y[2] / w[2]
            shift = (left * w[2] - right * w[0]) / (2.0 * (left - right))
            side = 0 if shift * w[0] > 0.0 else 2
            share = shift / w[side]
            z = newton(problem, (1.0 - share) * points[i] + share * points[i - 1 + side])
            if z is not None and share > BESIDE_CREST:
                rows.insert(i + side // 2, z)
                values.insert(i + side // 2, float(measure(z[None])[0]))
        points, sizes = np.array(rows), np.array(values)
    return points, sizes


def with_crossings(
    problem: Torus, points: Floats, values: Floats, measure: Callable[[Floats], Floats], level: float
) -> tuple[Floats, Floats]:
    """Points (n, ...) of a curve with those where a measure (n,) crosses a level, by the Illinois method; and this.

    Dowell & Jarratt 1971, A modified regula falsi method, BIT 11, 168-174.
    """
    off, rows, measured = values - level, list(points), values.tolist()
    for i in np.flatnonzero(off[:-1] * off[1:] < 0.0)[::-1].tolist():
        ends, sizes, last = [points[i], points[i + 1]], [float(off[i]), float(off[i + 1])], -1
        for _ in range(REFINED):
            share = sizes[0] / (sizes[0] - sizes[1])
            z = newton(problem, ends[0] + share * (ends[1] - ends[0]))
            if z is None:
                break
            size = float(measure(z[None])[0]) - level
            if abs(size) <= ON_LEVEL * level:
                rows.insert(i + 1, z)
                measured.insert(i + 1, size + level)
                break
            side = int(size * sizes[0] < 0.0)
            ends[side], sizes[side] = z, size
            sizes[1 - side] *= 0.5 if side == last else 1.0
            last = side
    return np.array(rows), np.array(measured)
