"""Branches of periodic orbits: solved at a point, traced and described, with folds that the steps passed over."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import accumulate, compress
from typing import Any

import numpy as np

from ...base import branch_labels
from ...base.branch_labels import CLOSED, END, FOLD, LOST, RUNNING, START, TOP
from ...base.protocols import Balance
from ...base.results import Branch, Complexes, Floats, Integers, Orbit, Status
from ...base.series import highest_between, largest_size, oscillation, weights_at
from ..balance.first_order import linearised
from ..balance.fourier import from_blocks
from ..balance.rates import base_speed
from ..balance.truncation import Tail, tail_along
from ..stability import second_order as stability
from ..stability.first_order import with_stability
from ..stability.special_points import finer_table, inserted, root_on_chord, with_crossings
from .arc_length import ROWS, SCALE, Z1, buffers_for, follow

NAMES = {
    FOLD: "fold",
    branch_labels.DOUBLING: "period doubling",
    branch_labels.BRANCH_POINT: "symmetry breaking / branch point",
    branch_labels.NEIMARK_SACKER: "Neimark-Sacker",
}

LEAST_CREST = 0.01  # of the largest value on the curve: lower crests stay as they are
MOST_CRESTS = 200  # the highest of a curve: more are rounding
CREST_REACH = 2  # points to both sides of a crest
ROUNDS, SETTLED = 10, 1e-12  # solutions of a crest, and the relative rise above one that is none
FORESEEN_ERROR = 4e-11  # error of the polynomial, squared, of a rise: a quarter of it is left to rise
CREST_RISE = 1e-3  # relative rise above the points from which on crests are looked for once more
STEP_DEVIATION = 0.03  # of the step between two points: what is farther from the polynomial may be on another branch
SAME_ARC = 1e-6  # of the arc of these: what is nearer is one point
SAME_POINT = 1e-6  # relative distance below which two points are one
SMALL_MEAN = 1e-6  # of the largest |x|: with a smaller mean both crests are one

Measure = Callable[[Floats], Floats]

MOST_PIECES = 40
LEAST_PIECE = 5  # points that a piece must have room for
PIECE = 512  # points per call of the kernel: between calls the user can interrupt
AIM = 1e-3

FOLD_REACH = 2  # points on either side among which the fold of a turn is


def with_missed_folds(problem: Balance, points: Floats, labels: Any) -> tuple[Floats, Any]:
    """Insert the folds at which the parameter (last of every point) turns and no fold is marked."""
    rise = np.diff(points[:, -1])
    for i in (np.flatnonzero(rise[1:] * rise[:-1] < 0.0) + 1)[::-1].tolist():
        if FOLD in labels[max(0, i - FOLD_REACH) : i + FOLD_REACH + 1]:
            continue
        for j in (i, i + 1):
            first, last = points[j - 1], points[j]
            slope = partial(_slope, problem, last - first)
            fold = root_on_chord(problem, first, last, slope)
            if fold is not None:
                points, labels = np.insert(points, j, fold, axis=0), np.insert(labels, j, FOLD)
                break
    return points, labels


def _slope(problem: Balance, chord: Floats, point: Floats) -> float:
    """Part along the parameter of the tangent that goes along the chord."""
    n = len(point) - 1
    _, matrix, column = linearised(problem, point)
    scale = np.full(n + 1, max(float(np.linalg.norm(point[:-1])), 1e-300))
    scale[-1] = max(abs(float(point[-1])), 1e-300)
    row = chord / scale
    bordered = np.block([[matrix, column[:, None]], [row[None, :] / scale]]) * scale
    tangent = np.linalg.solve(bordered, np.eye(n + 1)[n])
    return float(tangent[-1] / np.linalg.norm(tangent))


@dataclass(frozen=True)
class Trace:
    """Points of a branch (coefficients in blocks, parameter last), what each is, and how the branch ended.

    `message` is the sentence about the end, where the one that `describe` finds for the outcome does not tell enough;
    `elsewhere` holds values of the parameter and tables of orbits there through which the branch does not pass; `span`
    is the range that the branch was to be followed through, and may leave in between.
    """

    points: Floats
    labels: Any
    outcome: int
    message: str = ""
    elsewhere: tuple[tuple[float, Floats], ...] = ()
    span: tuple[float, float] | None = None

    @property
    def is_cut(self) -> bool:
        """True if it has as many points as it may have, and would go on."""
        return self.outcome == RUNNING


def points_at(points: Floats, value: float) -> list[Floats]:
    """Points of a branch at one value of the parameter."""
    return list(points[points[:, -1] == value])


def state_from(guess: Floats, width: float) -> Floats:
    """State of a continuation that starts at a guess (coefficients, parameter), the latter in units of `width`."""
    state = np.zeros((ROWS, len(guess)))
    state[Z1] = guess
    state[SCALE] = 1.0 / max(_size(guess[:-1]), 1e-12)
    state[SCALE, -1] = 1.0 / width
    return state


def solve(problem: Balance, guess: Floats) -> Floats | None:
    """Solution at the parameter of a guess, or None."""
    points, labels = np.empty((5, len(guess))), np.empty(5, np.int64)
    value = float(guess[-1])
    state, buffers = state_from(guess, abs(value) + 1e-12), buffers_for(problem)
    count, _, _ = _run(problem, state, 1.0, START, value, value, 1.0, 1.0, AIM, buffers, points, labels)
    return points[0] if count else None


def _run(problem: Balance, *arguments: Any) -> Any:
    with np.errstate(all="ignore"):  # a step that fails is taken again, shorter
        return problem.run(follow, *arguments)


def trace(
    problem: Balance,
    guess: Floats,
    direction: float,
    lo: float,
    hi: float,
    step: float,
    width: float | None = None,
    growth: float = np.inf,
    max_points: int | None = None,
    pieces: int = MOST_PIECES,
) -> Trace:
    """Follow one branch from a guess (coefficients, parameter) inside [lo, hi] until it leaves or closes.

    `step` is in units of the orbit's size and of `width` of the parameter (default: the range). The outcome is
    UNBOUNDED where the orbit is `growth` times larger than at the start. With `max_points` it is RUNNING after about
    so many points, given as they were taken, without a second look at folds; else after so many calls of the kernel.
    """
    state = state_from(guess, width or hi - lo)
    parts: list[Floats] = []
    labels: list[Any] = []
    ds, outcome, mode = 0.1 * step, RUNNING, START
    buffers, left = buffers_for(problem), PIECE * pieces if max_points is None else max_points
    while outcome == RUNNING and left >= LEAST_PIECE:
        piece = min(PIECE, left)
        points, kinds = np.empty((piece, len(guess))), np.empty(piece, np.int64)
        count, outcome, ds = _run(problem, state, direction, mode, lo, hi, ds, step, AIM, buffers, points, kinds)
        parts.append(points[:count])
        labels.append(kinds[:count])
        mode = branch_labels.STEP
        left -= piece
        if growth < np.inf and outcome != LOST:
            motions = points[:count, :-1]
            large = np.vecdot(motions, motions) > (growth * _size(parts[0][0, :-1])) ** 2
            if large.any():
                end = int(np.argmax(large)) + 1
                parts[-1], labels[-1], outcome = points[:end], kinds[:end], branch_labels.UNBOUNDED
    points, kinds = np.concatenate(parts), np.concatenate(labels)
    if max_points is None:
        put_in_order(points, kinds)
        points, kinds = with_missed_folds(problem, points, kinds)
        if outcome == CLOSED:
            points[-1] = points[0]  # the last step went a little past the start
    return Trace(points, kinds, outcome)


def put_in_order(points: Floats, labels: Any) -> None:
    """Put folds and amplitude maxima among points in the order of the arc.

    They are listed before the end of the step in which they were found, the fold first, but may lie just outside it.
    """
    weights = np.ones(points.shape[1])
    for i in np.flatnonzero((labels == FOLD) | (labels == TOP)):
        for a in (i, i - 1):  # with its right neighbour, then with its left one
            if not 0 < a < len(labels) - 2:
                continue
            last, one, other, after = points[a - 1 : a + 3]
            # both the motion and the parameter count by their sizes
            weights[-1] = one[:-1] @ one[:-1] / max(one[-1] ** 2, other[-1] ** 2, 1e-300)
            step = weights * (other - one)
            if step @ (after - last) < 0.0 and step @ (other + one - 2.0 * last) < 0.0:
                points[[a, a + 1]], labels[[a, a + 1]] = points[[a + 1, a]], labels[[a + 1, a]]


def with_crests(problem: Balance, points: Floats, labels: Integers) -> tuple[Floats, Any, tuple[Floats, Floats]]:
    """Points, labels, and x with largest |x|, of a curve with the crests of |x| and |x - mean| in it, labelled TOP.

    A crest that rises far above its neighbours may be a false one, at a corner of the law: they are looked for again.
    """
    series = series_of(problem, points)
    peaks = largest_size(series)
    for _ in range(ROUNDS):
        sizes: list[tuple[Measure, Floats]] = [(largest_size, peaks)]
        if np.any(np.abs(series[:, 0]) > SMALL_MEAN * peaks):
            sizes.append((oscillation, oscillation(series)))
        crests: list[tuple[int, int, Floats]] = []
        risen = 1.0
        for measure, values in sizes:
            for i in crests_of(values):
                seam = points[i, -1] in (points[i - 1, -1], points[i + 1, -1])
                crest = None if seam else _crest(problem, points, i, series, values, measure)
                if crest is None:
                    continue
                gap = i if crest[0] > 0.0 else i - 1
                neighbours = [*points[gap : gap + 2], *(point for index, _, point in crests if index == gap)]
                if all(_apart(crest[1], point) > SAME_POINT for point in neighbours):  # often the two crests are one
                    crests.append((gap, TOP, crest[1]))
                    risen = max(risen, crest[2] / np.max(values))
        if crests:
            points, labels, places, _ = inserted(points, labels, crests)
            series = series_of(problem, points)
            peaks = np.insert(peaks, places, largest_size(series[np.add(places, range(len(places)))]))
        if risen <= 1.0 + CREST_RISE:
            break
    return points, labels, (series, peaks)


def crests_of(values: Floats) -> list[int]:
    """Places of the highest values that are above both neighbours, and no less than a hundredth of the largest."""
    inner = values[1:-1]
    above = (inner >= values[:-2]) & (inner > values[2:]) & (inner > LEAST_CREST * np.max(values, initial=0.0))
    places = 1 + np.flatnonzero(above)
    return sorted(places[np.argsort(-values[places], kind="stable")[:MOST_CRESTS]].tolist())


def _crest(
    problem: Balance, points: Floats, i: int, series: Floats, sizes: Floats, measure: Measure
) -> tuple[float, Floats, float] | None:
    """Crest next to a point, after which it lies where the first number is positive, and its size; None at the point.

    It is the highest place of the polynomial through five points, solved for at the parameter there, or nearer to
    a known point where that is far from the polynomial.
    """
    around, centre = slice(max(i - CREST_REACH, 0), i + CREST_REACH + 1), min(i, CREST_REACH)
    scale = max(_size(points[i, :-1]), 1e-300)
    step = np.diff(points[around], axis=0) / scale
    step[:, -1] *= scale / max(abs(float(points[i, -1])), 1e-300)
    lengths = np.sqrt(np.vecdot(step, step)).tolist()
    arc = [0.0, *accumulate(lengths)]
    least = SAME_ARC * arc[-1]
    distinct = [True, *(length > least for length in lengths)]
    if not (distinct[centre] and distinct[centre + 1]):
        return None
    first, mid, last = arc[centre - 1 : centre + 2]
    best, size, crest, share = mid, float(sizes[i]), None, 1.0
    arc, window, series = list(compress(arc, distinct)), points[around][distinct], series[around][distinct]
    for _ in range(ROUNDS):
        s, top = highest_between(np.array(arc), series, first, last, measure is oscillation)
        nearest = min(arc, key=lambda place: abs(place - s))
        s = nearest + share * (s - nearest)
        if abs(top - size) <= SETTLED * top or not first < s < last or abs(s - nearest) <= least:
            break
        guess = weights_at(arc, s) @ window
        point = solve(problem, guess)
        if point is None or _size((point - guess)[:-1]) > STEP_DEVIATION * scale * lengths[centre - (s <= mid)]:
            share *= 0.5
            continue
        share = 1.0
        solved = series_of(problem, point[None])
        value = float(measure(solved)[0])
        rise = value - size
        if (s > best) == (rise >= 0.0):
            first = min(s, best)
        else:
            last = max(s, best)
        if rise >= 0.0:
            best, size, crest = s, value, (s - mid, point, value)
        if abs(rise) <= SETTLED * size or (value - top) ** 2 <= FORESEEN_ERROR * size * rise:
            break  # what is left to rise is rounding
        arc.append(s)
        window, series = np.concatenate([window, point[None]]), np.concatenate([series, solved])
    return crest


def _apart(a: Floats, b: Floats) -> float:
    """Distance of two points, of the motion and of the speed, relative to their sizes."""
    return _size(a[:-1] - b[:-1]) / max(_size(b[:-1]), 1e-150) + float(abs(a[-1] / b[-1] - 1.0))


def _size(a: Floats) -> float:
    return math.sqrt(a @ a)


def series_of(problem: Balance, points: Floats) -> Floats:
    """Coefficients (points, 2H+1) of x: mean, cos 1, sin 1, ..."""
    return np.asarray(from_blocks(problem.displacements(points).T).T)


def describe(
    problem: Balance, parameter: str, curve: Trace, tail: Tail | None, origin: str, *, locate: bool = True,
    floquet: Complexes | None = None, sizes: tuple[Floats, Floats] | None = None,
) -> Branch:  # fmt: skip
    """Add stability, peaks, crests, period doublings and branch points to a branch, and label the special points.

    Locating those of a general system takes far longer than the rest; without `locate` it has the points found alone,
    whose multipliers may be known, and `sizes`, as `with_crests` gives them.
    """
    points, labels = np.ascontiguousarray(curve.points), curve.labels
    status, message = ending(curve, parameter, points[:, -1])
    tail = tail_along(problem, points) if tail is None else tail
    if locate:
        points, labels, sizes = with_crests(problem, points, labels)
    points, labels, floquet = with_multipliers(problem, points, labels, locate, floquet)
    if sizes is None or len(sizes[0]) != len(points):
        sizes = (series := series_of(problem, points)), largest_size(series)
    coefficients, peaks = sizes
    values, turns = points[:, -1].copy(), int(problem.turns)
    omega = base_speed(problem, values.copy())
    stable = np.abs(floquet[:, 0]) < branch_labels.DECAYS
    special: dict[int, list[Orbit]] = {label: [] for label in NAMES}
    for i in np.flatnonzero((labels == FOLD) | (labels > TOP)).tolist():
        label, w = int(labels[i]), float(omega[i])
        table = problem.motion(points[i], coefficients[i])
        details = tail.share, *tail.verdict(Status.OK, "finished", parameter, w), NAMES[label], float(values[i])
        special[label].append(Orbit(w, turns, table, float(peaks[i]), floquet[i], bool(stable[i]), *details))
    folds, doublings, crossings, tori = special.values()
    verdict = tail.verdict(status, message, parameter, float(omega[0]) if len(omega) else 0.0)
    return Branch(
        parameter, values, omega, coefficients, peaks, floquet, stable, folds, doublings, turns,
        curve.outcome == CLOSED, tail.share, origin, *verdict, crossings, tori, span=curve.span or _ends(values),
    )  # fmt: skip


def _ends(values: Floats) -> tuple[float, float]:
    return (float(np.min(values)), float(np.max(values))) if len(values) else (np.nan, np.nan)


def with_multipliers(
    problem: Balance, points: Floats, labels: Any, locate: bool = True, floquet: Any = None
) -> tuple[Floats, Any, Complexes]:
    """Points of a branch, and their multipliers; with its special points, those of an oscillator always."""
    if problem.hill():
        return with_hill(problem, points, labels)
    return with_stability(problem, points, labels, locate, floquet)


def with_hill(problem: Any, points: Floats, labels: Any) -> tuple[Floats, Any, Complexes]:
    """Points of an oscillator's branch with its special points, and their multipliers."""
    traces = stability.hill(problem, points)
    decay = stability.orbit_scales(problem, points[:, -1])[1]
    points, labels, added = with_crossings(problem, points, labels, traces, decay)
    if added:
        traces = stability.hill(problem, points)
        located = labels > TOP
        traces[located] = stability.hill(problem, points[located], finer_table(problem, points[located]))
        decay = stability.orbit_scales(problem, points[:, -1])[1]
    floquet = stability.multipliers(traces, decay)
    if np.isnan(floquet).any():
        floquet = np.where(np.isnan(floquet), stability.frozen(problem, points), floquet)
    return points, labels, floquet


def ending(curve: Trace, parameter: str, values: Floats) -> tuple[Status, str]:
    """Status of a curve through values of a parameter at its end, and the sentence."""
    if curve.message:
        return (Status.OK if curve.outcome in (END, CLOSED) else Status.NO_CONVERGENCE), curve.message
    if curve.outcome in (END, CLOSED):
        return Status.OK, "reached both ends" if curve.outcome == END else "closed"
    location = f"at {parameter} = {values[-1]:.6g}" if len(values) else "at its start"
    reason = {LOST: "no solution found", branch_labels.STUCK: "the step became too small"}.get(
        curve.outcome, "too many points"
    )
    return Status.NO_CONVERGENCE, f"the branch stops {location}: {reason}; take more harmonics or a smaller range"
