"""`frequency_response` and its relatives: whole curves of periodic orbits, with stability, folds and period doublings.

The curve starts from the linear response at one end of the range and is followed to the other; where it leaves the
range with folds still ahead, it is followed outside until it comes back. The number of harmonics grows until the last
two are negligible.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from .._jit import run, with_leaf
from ..quantities import checked, parameters
from ..results import Branch, Floats, Orbit, SolveError, Status
from .balance import second_order
from .continuation import CLOSED, END, FOLD, LOST, RUNNING, SCALE, START, STEP, STUCK, TOP, Z1, follow
from .floquet import displacement_peaks, hill, multipliers, orbit_scales
from .fourier import from_blocks
from .guess import error_coefficients, linear_response
from .special_points import BRANCH_POINT, DOUBLING, with_crossings

TAIL = 1e-6  # the last two harmonics may hold this share of the whole
MOST_HARMONICS = 127
MOST_PIECES = 40
PIECE = 512  # points per call of the kernel: between calls the user can interrupt
REACH = 3.0  # how far outside the range, as a factor, a branch may go before it comes back
AIM = 1e-3


@dataclass(frozen=True)
class Trace:
    """Points of a branch (coefficients in blocks, parameter last), what each is, and how the branch ended."""

    points: Floats
    labels: Any
    outcome: int


def leaf_of(system: Any, path: str) -> int:
    """Place of a float parameter among the float parameters of a system.

    Raises
    ------
    ValueError
        If the path names no float parameter.
    """
    paths = [p.path for p in parameters(system) if isinstance(p.value, float)]
    if path not in paths:
        raise ValueError(f"{type(system).__name__} has no continuous parameter {path!r}; it has {', '.join(paths)}")
    return paths.index(path)


def state_from(guess: Floats, width: float) -> Floats:
    """State of a continuation that starts at a guess (coefficients, parameter), the latter in units of `width`."""
    state = np.zeros((10, len(guess)))
    state[Z1] = guess
    state[SCALE] = 1.0 / max(float(np.linalg.norm(guess[:-1])), 1e-12)
    state[SCALE, -1] = 1.0 / width
    return state


def solve(problem: Any, guess: Floats) -> Floats | None:
    """Solution at the parameter of a guess, or None."""
    points, labels = np.empty((5, len(guess))), np.empty(5, np.int64)
    at = float(guess[-1])
    count, _, _ = run(
        follow, problem, state_from(guess, abs(at) + 1e-12), 1.0, START, at, at, 1.0, 1.0, AIM, points, labels
    )
    return points[0] if count else None


def trace(problem: Any, guess: Floats, direction: float, lo: float, hi: float, step: float) -> Trace:
    """Follow one branch from a guess (coefficients, parameter) inside [lo, hi] until it leaves or closes."""
    state = state_from(guess, hi - lo)
    pieces: list[Floats] = []
    labels: list[Any] = []
    ds, outcome, mode = 0.1 * step, RUNNING, START
    while outcome == RUNNING and len(pieces) < MOST_PIECES:
        points, kinds = np.empty((PIECE, len(guess))), np.empty(PIECE, np.int64)
        count, outcome, ds = run(follow, problem, state, direction, mode, lo, hi, ds, step, AIM, points, kinds)
        pieces.append(points[:count])
        labels.append(kinds[:count])
        mode = STEP
    return Trace(*in_order(np.concatenate(pieces), np.concatenate(labels)), outcome)


def in_order(points: Floats, labels: Any) -> tuple[Floats, Any]:
    """Put a fold and an amplitude maximum that one step found (the fold first) into the order of the arc."""
    both = 1 + np.flatnonzero((labels[1:-2] == FOLD) & (labels[2:-1] == TOP))
    fold, top = (np.linalg.norm(points[both + i] - points[both - 1], axis=1) for i in (0, 1))
    swap = both[top < fold]
    order = np.arange(len(labels))
    order[swap], order[swap + 1] = swap + 1, swap
    return points[order], labels[order]


def whole(problem: Any, lo: float, hi: float, step: float, upwards: bool) -> Trace:
    """Follow the branch from the linear response at one end to the other end, with excursions outside the range."""
    start, far = (lo, hi) if upwards else (hi, lo)
    latest = trace(problem, linear_response(problem, start), 1.0 if upwards else -1.0, lo, hi, step)
    pieces, labels = [latest.points], [latest.labels]
    for _ in range(20):
        if latest.outcome != END:
            break
        last = latest.points[-1]
        end = float(last[-1])
        if end == far and _same(solve(problem, linear_response(problem, far)), last):
            break
        outside = (hi, hi * REACH) if end == hi else (lo / REACH, lo)
        away = trace(problem, last, 1.0 if end == hi else -1.0, *outside, step)
        if away.outcome != END or away.points[-1, -1] != end:
            break
        latest = trace(problem, away.points[-1], -1.0 if end == hi else 1.0, lo, hi, step)
        pieces += [away.points[1:], latest.points[1:]]
        labels += [away.labels[1:], latest.labels[1:]]
    return Trace(np.concatenate(pieces), np.concatenate(labels), latest.outcome)


def _same(a: Floats | None, b: Floats) -> bool:
    return a is None or float(np.linalg.norm(a - b)) <= 1e-5 * float(np.linalg.norm(b[:-1]))


def tail_of(points: Floats) -> Floats:
    """Size of the last two harmonics relative to the whole, at every point (coefficients in blocks)."""
    h = points.shape[1] // 2
    last = [k for k in (h - 1, h, 2 * h - 1, 2 * h) if k > 0]
    whole_size = np.maximum(np.linalg.norm(points, axis=1), 1e-300)
    return np.asarray(np.linalg.norm(points[:, last], axis=1) / whole_size)


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
    system : Oscillator
        The system; its own `omega` does not matter.
    span : (float, float)
        Range of omega [rad/s], 0 < low < high.
    harmonics : int, optional
        Highest harmonic H of omega/period. Default: grown until the last two are negligible (1e-6), at most 127.
    period : int
        Turns of the base angle per orbit.
    points : int
        About how many points to place; more where the curve bends.
    throw : bool
        Raise instead of returning a branch that ends inside the range.

    Returns
    -------
    Branch
        In arc order from one end of the range to the other, with stability, folds and period doublings.

    Raises
    ------
    ValueError
        If the range is not 0 < low < high, or `harmonics` is not positive.
    SolveError
        If `throw` is true and the branch does not reach the other end.

    References
    ----------
    Krack & Gross 2019, Harmonic Balance for Nonlinear Vibration Problems, secs. 2-4.
    """
    system = checked(system)
    lo, hi = float(span[0]), float(span[1])
    if not 0.0 < lo < hi < np.inf:
        raise ValueError(
            f"the frequency range is {lo:g} .. {hi:g} rad/s; it must be 0 < low < high (at rest there is no response)"
        )
    if harmonics is not None and harmonics < 1:
        raise ValueError(f"harmonics is {harmonics}; at least 1 is needed")
    leaf = leaf_of(system, "omega")
    h = harmonics or 7 * period
    while True:
        problem = second_order(system, leaf, leaf, h, period)
        found = whole(problem, lo, hi, 4.0 / points, True)
        if found.outcome != END or found.points[-1, -1] != hi:
            other = whole(problem, lo, hi, 4.0 / points, False)
            if other.outcome == END and other.points[-1, -1] == lo:
                found = Trace(other.points[::-1], other.labels[::-1], END)
        tail = float(np.max(tail_of(found.points[:, :-1]), initial=0.0))
        if harmonics is not None or tail <= TAIL or h >= MOST_HARMONICS:
            break
        h = min(2 * h + 1, MOST_HARMONICS)
    branch = describe(problem, "omega", found, tail, "from the linear response at the lower end of the range")
    if throw and not branch.status:
        raise SolveError(branch.message)
    return branch


def describe(problem: Any, parameter: str, found: Trace, tail: float, origin: str) -> Branch:
    """Add stability, peaks, period doublings and branch points to the points of a branch, and label the special ones."""
    points, labels = np.ascontiguousarray(found.points), found.labels
    n = points.shape[1] - 1
    traces, peaks = hill(problem, points)
    points, labels, added = with_crossings(problem, points, labels, traces)
    if added:
        traces, peaks = hill(problem, points)
    values = points[:, n]
    omega, decay = orbit_scales(problem, values)
    floquet = multipliers(traces, decay)
    stable = np.abs(floquet[:, 0]) < 1.0
    error = problem.error
    if parameter.startswith("error."):  # the kinematic error itself varies along the branch
        error = error_coefficients(problem, values)
        peaks = displacement_peaks(points[:, :n] + error)
    coefficients = from_blocks((points[:, :n] + error).T).T

    def special(label: int, name: str) -> list[Orbit]:
        return [
            Orbit(
                float(omega[i]), problem.turns, with_velocity(coefficients[i], omega[i] / problem.turns),
                float(peaks[i]), floquet[i], bool(stable[i]), float(tail_of(points[i : i + 1, :n])[0]), Status.OK,
                "finished", name, float(values[i]),
            )
            for i in np.flatnonzero(labels == label)
        ]  # fmt: skip

    status, message = _verdict(found, parameter, values)
    return Branch(
        parameter, values, omega, coefficients, peaks, floquet, stable, special(FOLD, "fold"),
        special(DOUBLING, "period doubling"), problem.turns, found.outcome == CLOSED, tail, origin, status, message,
        special(BRANCH_POINT, "symmetry breaking / branch point"),
    )  # fmt: skip


def with_velocity(x: Floats, w: float) -> Floats:
    """Coefficients (2H+1, 2) of x and x' from those of x, with fundamental frequency w [rad/s]."""
    k = np.arange(1, len(x) // 2 + 1)
    v = np.zeros_like(x)
    v[1::2], v[2::2] = k * w * x[2::2], -k * w * x[1::2]
    return np.stack([x, v], axis=1)


def _verdict(found: Trace, parameter: str, values: Floats) -> tuple[Status, str]:
    if found.outcome in (END, CLOSED):
        return Status.OK, "reached both ends" if found.outcome == END else "closed"
    where = f"at {parameter} = {values[-1]:.6g}" if len(values) else "at its start"
    reason = {LOST: "no solution found", STUCK: "the step became too small"}.get(found.outcome, "too many points")
    return Status.NO_CONVERGENCE, f"the branch stops {where}: {reason}; take more harmonics or a smaller range"
