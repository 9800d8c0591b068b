"""Arc-length continuation of the solutions of a balance problem in one parameter.

The curve is followed in scaled unknowns: coefficients in units of the largest met so far, the parameter in units of
the range. Each step predicts with the cubic through the last two points and tangents, factors the bordered Jacobian
once at the prediction and corrects with it; the step length follows the size of the first correction. Turning points
of the parameter (folds) are located on the tangent.

Krack & Gross 2019, sec. 4 (continuation); Seydel 2010, Practical Bifurcation and Stability Analysis, secs. 4.4-4.6.
"""

from typing import Any

import numpy as np

from ...base.branch_labels import BOUND, CLOSED, END, FOLD, LOST, RUNNING, START, STEP, STUCK, TOP
from ...base.results import Floats
from ...compile.jit import borrowed, kernel, routine
from ..balance.linear_algebra import add, copy, divide, dot, factor, fill, substitute, weigh, weighted_norm
from ..roots import FA, FB, SHARE, A, B, narrow, next_place

Z0, T0, Z1, T1, Z, T, ROW, SCALE, HOME, AHEAD, LACK, CHANGE, ROWS = range(
    13
)  # rows of the state of a continuation; how many
SMALLEST_STEP, KINK = 1e-9, 1e-4  # steps below KINK may turn sharply: laws with kinks give curves with kinks
NOTHING_MOVES = 1e-12  # smallest unit of the coefficients: an orbit at rest has no size
TOLERANCE, NEGLIGIBLE = 1e-9, 1e-6  # of a correction, in scaled unknowns; of one by Newton's method
GRADES = 32.0  # a step changes by whole parts of the last one, so that points do not depend on rounding


@routine
def correct(problem: Any, n: int, state: Floats, target: float, a: Floats, pivots: Any, tries: int, full: bool) -> Any:
    """Solve residual = 0 and row . z = target from z in place; leave the tangent of the curve in row T.

    The Jacobian is factored at the prediction and again when corrections shrink too slowly or, if `full`, are not yet
    tiny (the tangent is then that of the solution). Returns whether it converged, the scaled size of the first
    correction and the sign of the determinant of the bordered Jacobian, which changes where another branch crosses.
    """
    problem, state, a, pivots = borrowed((problem, state, a, pivots))
    z, tangent, row, scale, lack, change = state[Z], state[T], state[ROW], state[SCALE], state[LACK], state[CHANGE]
    first, last, stale, sign = 0.0, 1e300, True, 0.0
    for i in range(tries):
        problem.residual(z, lack[:n])
        if stale:
            problem.linearise(z, a, change[:n])
            copy(change[:n], a[:n, n])
            copy(row, a[n])
            sign = factor(a, pivots)
            fill(0.0, tangent)
            tangent[n] = 1.0
            substitute(a, pivots, tangent)
        lack[n] = dot(row, z) - target
        substitute(a, pivots, lack)
        add(-1.0, lack, z)
        size = weighted_norm(lack, scale)
        if not size < 1e3:
            return False, first, sign
        if i == 0:
            first = size
        rate = size / last
        tiny = NEGLIGIBLE if stale else TOLERANCE  # after a Newton step the error is of the order of its square
        if size < tiny or (i > 0 and rate < 0.5 and rate * size < TOLERANCE):
            return True, first, sign
        stale = (i > 0 and rate > 0.1) or (full and size > 1e-6)
        last = size
    return False, first, sign


@routine
def hermite(s: float, d: float, state: Floats) -> None:
    """Row Z becomes the cubic through the last two points, d apart, at the fraction s (s > 1 extrapolates)."""
    r = 1.0 - s
    a, b = (1.0 + 2.0 * s) * r * r, s * r * r * d
    c, e = s * s * (3.0 - 2.0 * s), -s * s * r * d
    fill(0.0, state[Z])
    for row, weight in ((Z0, a), (T0, b), (Z1, c), (T1, e)):
        add(weight, state[row], state[Z])


@routine
def normalise(state: Floats, row: int) -> None:
    """Give a tangent unit scaled length, and write the row that measures length along it."""
    divide(weighted_norm(state[row], state[SCALE]), state[row])
    weigh(state[row], state[SCALE], state[ROW])


@routine
def passes_home(state: Floats) -> bool:
    """True if the last step passed the starting point of the branch in the starting direction."""
    d = chord(state)
    copy(state[Z1], state[Z])
    add(-1.0, state[HOME], state[Z])
    weigh(state[AHEAD], state[SCALE], state[ROW])
    after = dot(state[ROW], state[Z])
    before = after - dot(state[ROW], state[T])
    return before < 0.0 and after >= 0.0 and weighted_norm(state[Z], state[SCALE]) < 2.0 * d


@routine
def dominant(problem: Any, state: Floats) -> int:
    """Harmonic with the largest amplitude of x at the latest point."""
    z, best, top = state[Z1], 1, -1.0
    for k in range(1, problem.harmonics() + 1):
        even, odd = problem.harmonic(z, k)
        size = even**2 + odd**2
        if size > top:
            best, top = k, size
    return best


@routine
def indicator(problem: Any, state: Floats, z: int, t: int, kind: int, k: int) -> float:
    """Function with a root at a special point: the tangent's parameter (FOLD), the growth of harmonic k of x (TOP)."""
    n = state.shape[1] - 1
    if kind == FOLD:
        return float(state[t, n])
    h = problem.harmonics()
    even, odd = problem.harmonic(state[z], k)
    return float((even * state[t, k] + odd * state[t, h + k]) / (even * even + odd * odd + 1e-300))


@routine
def record(state: Floats, row: int, label: int, points: Floats, labels: Any, count: int) -> int:
    """Store a point of the branch; returns how many there are."""
    copy(state[row], points[count])
    labels[count] = label
    return count + 1


TRIES, LIMIT = 5, 6  # entries of a bracket after those of `roots`
BEFORE, BEYOND, CLOSE = -0.5, 1.5, 5e-10  # ends of an opened bracket, and how near they come, in steps
SEARCHING, FOUND, NOTHING = 0, 1, 2


@routine
def bracketed(problem: Any, state: Floats, kind: int, k: int, bracket: Floats) -> bool:
    """Open a bracket for a special point between the last two points, if there is one (of TOP, maxima only)."""
    first, last = indicator(problem, state, Z0, T0, kind, k), indicator(problem, state, Z1, T1, kind, k)
    if not (first * last < 0.0 and (kind == FOLD or first > 0.0)):
        return False
    bracket[A], bracket[FA], bracket[B], bracket[FB], bracket[SHARE] = 0.0, first, 1.0, last, first / (first - last)
    bracket[TRIES], bracket[LIMIT] = 0.0, 1e-8 * max(abs(first), abs(last))
    return True


@routine
def narrowed(bracket: Floats, value: float) -> int:
    """Put the value at the next place into the bracket; tells whether to go on, or what came of it.

    The tangent stored with a step is that of its prediction: a special point next to an end of the step may lie just
    outside it. A bracket that shrinks onto that end is therefore opened once to the other side of it.
    """
    bracket[TRIES] += 1.0
    if abs(value) <= bracket[LIMIT]:
        return FOUND
    if bracket[TRIES] > 80.0:
        return NOTHING
    narrow(bracket, next_place(bracket, CLOSE), value)
    if abs(bracket[B] - bracket[A]) > 2.0 * CLOSE:
        return SEARCHING
    if bracket[B] == 0.0 or bracket[B] == 1.0:
        bracket[B], bracket[FB], bracket[SHARE] = BEFORE if bracket[B] == 0.0 else BEYOND, -value, 0.5
        return SEARCHING
    return NOTHING if bracket[B] == BEFORE or bracket[B] == BEYOND else FOUND


@routine
def chord(state: Floats) -> float:
    """Row T becomes the last step; returns its scaled length."""
    copy(state[Z1], state[T])
    add(-1.0, state[Z0], state[T])
    return weighted_norm(state[T], state[SCALE])


@routine
def predict(state: Floats, mode: int, ds: float, bracket: Floats, bound: float) -> float:
    """Write the prediction to row Z and the row that fixes the unknown to ROW; returns what the row must give."""
    n = state.shape[1] - 1
    scale = state[SCALE]
    if mode == STEP:
        fill(1.0 / max(dot(state[Z1, :n], state[Z1, :n]) ** 0.5, 1.0 / scale[0]), scale[:n])
        normalise(state, T0)
        normalise(state, T1)
        d = chord(state)
        if d > 0.0:
            hermite(1.0 + ds / d, d, state)
        else:
            copy(state[Z1], state[Z])
            add(ds, state[T1], state[Z])
        return float(dot(state[ROW], state[Z1])) + ds
    if mode in (FOLD, TOP):
        d = chord(state)
        normalise(state, T)
        hermite(next_place(bracket, CLOSE), d, state)
        return float(dot(state[ROW], state[Z]))
    if mode == START:
        copy(state[Z1], state[Z])
    else:
        hermite((bound - state[Z0, n]) / (state[Z1, n] - state[Z0, n]), chord(state), state)
        state[Z, n] = bound
    fill(0.0, state[ROW])
    state[ROW, n] = 1.0
    return float(state[Z, n])


@routine
def begin(state: Floats, direction: float) -> None:
    """Take the corrected point in row Z as the first of a branch."""
    n = state.shape[1] - 1
    fill(1.0 / max(dot(state[Z, :n], state[Z, :n]) ** 0.5, NOTHING_MOVES), state[SCALE, :n])
    fill(0.0, state[T1])
    add(direction, state[T], state[T1])
    normalise(state, T1)
    for old, new in ((T1, T0), (T1, AHEAD), (Z, Z0), (Z, Z1), (Z, HOME)):
        copy(state[old], state[new])


@routine
def advance(state: Floats, ds: float) -> bool:
    """Take the corrected point as the next of the branch, unless the tangent turned too far in a long step."""
    normalise(state, T)
    turn = dot(state[ROW], state[T1])
    if turn < 0.9 and (ds > KINK or turn < 0.0):
        return False
    for old, new in ((Z1, Z0), (T1, T0), (Z, Z1), (T, T1)):
        copy(state[old], state[new])
    return True


def buffers_for(problem: Any) -> Any:
    """Buffers of `follow` for a problem."""
    n = problem.size()
    return np.empty((n + 1, n + 1)), np.empty(n + 1, np.int64), np.zeros(7)


@kernel
def follow(
    problem: Any, state: Floats, direction: float, mode: int, lo: float, hi: float, ds: float, ds_max: float,
    aim: float, buffers: Any, points: Floats, labels: Any,
) -> Any:  # fmt: skip
    """Follow a branch until it ends or `points` is nearly full.

    A new branch starts (mode START) by correcting the guess in row Z1 at its parameter and goes towards `direction`.
    `lo` and `hi` bound the parameter. Returns the number of points, the outcome and the step, with which a call in
    mode STEP goes on.
    """
    problem, state, points, labels = borrowed(problem), borrowed(state), borrowed(points), borrowed(labels)
    a, pivots, bracket = borrowed(buffers)
    n = state.shape[1] - 1
    count, outcome, search, harmonic, bound, length = 0, RUNNING, TOP, 1, hi, 0.0
    side = 0.0  # sign of the determinant at the last point; unknown where a call goes on in mode STEP
    while outcome == RUNNING and (count < len(points) - 4 or mode > STEP):
        target = predict(state, mode, ds, bracket, bound)
        good, first, sign = correct(problem, n, state, target, a, pivots, 40 if mode == START else 8, mode != STEP)
        if mode == START:
            if not good:
                outcome = LOST
                break
            begin(state, direction)
            side = sign * direction
            count, mode = record(state, Z, START, points, labels, count), STEP
            continue
        if mode == STEP:
            # A far correction may end on another branch, and one that nearly touches this one is on its other side.
            on_branch = good and (ds < KINK or (first < 0.25 * ds and sign * side >= 0.0))
            if not (on_branch and advance(state, ds)):
                ds *= 0.4
                if ds < SMALLEST_STEP:
                    outcome = STUCK
                continue
            change = min(1.6, max(0.5, (aim / max(first, 1e-300)) ** 0.25))
            ds = min(ds_max, ds * np.floor(GRADES * change + 0.5) / GRADES)
            side = sign
            search, harmonic, length = STEP, dominant(problem, state), chord(state)
        elif mode == BOUND:
            if not good:
                return count, STUCK, ds
            return record(state, Z, END, points, labels, count), END, ds
        else:
            normalise(state, T)
            good = good and first < 0.25 * length
            result = narrowed(bracket, indicator(problem, state, Z, T, mode, harmonic)) if good else NOTHING
            if result == SEARCHING:
                continue
            if result == FOUND and lo <= state[Z, n] <= hi:
                count = record(state, Z, mode, points, labels, count)
            search, mode = mode, STEP
        while search < TOP and mode == STEP:  # special points between Z0 and Z1
            search += 1
            if bracketed(problem, state, search, harmonic, bracket):
                mode = search
        if mode == STEP:
            if lo <= state[Z1, n] <= hi:
                count = record(state, Z1, STEP, points, labels, count)
                if passes_home(state):
                    outcome = CLOSED
            else:
                bound, mode = (hi if state[Z1, n] > hi else lo), BOUND
    return count, outcome, ds
