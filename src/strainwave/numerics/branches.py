"""Branches of periodic orbits: solved at a point, traced, and described with stability, folds and period doublings."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from .._jit import run
from ..quantities import parameters
from ..results import Branch, Floats, Orbit, Status
from .balance import is_light
from .continuation import CLOSED, END, FOLD, LOST, RUNNING, SCALE, START, STEP, STUCK, TOP, Z1, buffers_for, follow
from .first_order import FirstOrder
from .floquet import displacement_peaks, hill, multipliers, orbit_scales
from .fourier import from_blocks
from .guess import error_coefficients
from .half_wave import all_orders
from .special_points import BRANCH_POINT, DOUBLING, finer_table, with_crossings
from .variational import described, tail_of_states

MOST_PIECES = 40
PIECE = 512  # points per call of the kernel: between calls the user can interrupt
AIM = 1e-3
UNBOUNDED = 5  # outcome of a trace, after those of `continuation`


@dataclass(frozen=True)
class Trace:
    """Points of a branch (coefficients in blocks, parameter last), what each is, and how the branch ended.

    `message` is the sentence about the end, where the one that `describe` finds for the outcome does not tell enough.
    """

    points: Floats
    labels: Any
    outcome: int
    message: str = ""


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
    state, buffers = state_from(guess, abs(at) + 1e-12), buffers_for(problem)
    count, _, _ = _run(problem, state, 1.0, START, at, at, 1.0, 1.0, AIM, buffers, points, labels)
    return points[0] if count else None


def _run(problem: Any, *arguments: Any) -> Any:
    with np.errstate(all="ignore"):  # a step that fails is taken again, shorter
        if isinstance(problem, FirstOrder):
            return follow(problem, *arguments)
        return run(follow, problem, *arguments, light=is_light(problem))


def trace(
    problem: Any,
    guess: Floats,
    direction: float,
    lo: float,
    hi: float,
    step: float,
    width: float | None = None,
    growth: float = np.inf,
) -> Trace:
    """Follow one branch from a guess (coefficients, parameter) inside [lo, hi] until it leaves or closes.

    `step` is in units of the orbit's size and of `width` of the parameter (default: the range). The outcome is
    UNBOUNDED where the orbit is `growth` times larger than at the start.
    """
    state = state_from(guess, width or hi - lo)
    pieces: list[Floats] = []
    labels: list[Any] = []
    ds, outcome, mode = 0.1 * step, RUNNING, START
    buffers = buffers_for(problem)
    while outcome == RUNNING and len(pieces) < MOST_PIECES:
        points, kinds = np.empty((PIECE, len(guess))), np.empty(PIECE, np.int64)
        count, outcome, ds = _run(problem, state, direction, mode, lo, hi, ds, step, AIM, buffers, points, kinds)
        pieces.append(points[:count])
        labels.append(kinds[:count])
        mode = STEP
        if growth < np.inf:
            large = np.linalg.norm(points[:count, :-1], axis=1) > growth * np.linalg.norm(pieces[0][0, :-1])
            if np.any(large):
                end = int(np.argmax(large)) + 1
                pieces[-1], labels[-1], outcome = points[:end], kinds[:end], UNBOUNDED
    points, kinds = in_order(np.concatenate(pieces), np.concatenate(labels))
    if outcome == CLOSED:
        points[-1] = points[0]  # the last step went a little past the start
    return Trace(points, kinds, outcome)


def in_order(points: Floats, labels: Any) -> tuple[Floats, Any]:
    """Put folds and amplitude maxima in the order of the arc.

    They are listed before the end of the step in which they were found, the fold first, but may lie just outside it.
    """
    order = np.arange(len(labels))
    for i in np.flatnonzero((labels == FOLD) | (labels == TOP)):
        for a in (i, i - 1):  # with its right neighbour, then with its left one
            if 0 < a < len(order) - 2:
                near, first, second, far = points[order[a - 1 : a + 3]]
                ahead = far - near
                if (second - first) @ ahead < 0.0 and np.linalg.norm(second - near) < np.linalg.norm(first - near):
                    order[a], order[a + 1] = order[a + 1], order[a]
    return points[order], labels[order]


def tail_of(points: Floats) -> Floats:
    """Size of the last two harmonics relative to the whole, at every point (coefficients in blocks)."""
    h = points.shape[1] // 2
    last = [k for k in (h - 1, h, 2 * h - 1, 2 * h) if k > 0]
    whole_size = np.maximum(np.linalg.norm(points, axis=1), 1e-300)
    return np.asarray(np.linalg.norm(points[:, last], axis=1) / whole_size)


def largest_tail(problem: Any, points: Floats) -> float:
    """Largest tail of the points of a branch (parameter last), of the worst state."""
    if isinstance(problem, FirstOrder):
        return tail_of_states(problem, points)
    return float(np.max(tail_of(all_orders(problem, points[:, :-1])), initial=0.0))


def describe(problem: Any, parameter: str, found: Trace, tail: float, origin: str) -> Branch:
    """Add stability, peaks, period doublings and branch points to a branch, and label the special points."""
    points, labels = np.ascontiguousarray(found.points), found.labels
    status, message = _verdict(found, parameter, points[:, -1])
    if isinstance(problem, FirstOrder):
        return described(problem, parameter, points, labels, found.outcome, tail, origin, status, message)
    n = points.shape[1] - 1
    points, labels, traces, peaks = with_crest(problem, points, labels, *hill(problem, points))
    points, labels, added = with_crossings(problem, points, labels, traces)
    if added:
        traces, peaks = hill(problem, points)
        located = labels > TOP
        traces[located] = hill(problem, points[located], finer_table(problem, points[located]))[0]
    values = points[:, n]
    omega, decay = orbit_scales(problem, values)
    floquet = multipliers(traces, decay)
    stable = np.abs(floquet[:, 0]) < 1.0
    error = problem.error
    if parameter.startswith("error."):  # the kinematic error itself varies along the branch
        error = error_coefficients(problem, values)
        peaks = displacement_peaks(all_orders(problem, points[:, :n] + error))
    wide = all_orders(problem, points[:, :n] + error)
    coefficients = from_blocks(wide.T).T

    def special(label: int, name: str) -> list[Orbit]:
        return [
            Orbit(
                float(omega[i]), problem.turns, with_velocity(coefficients[i], omega[i] / problem.turns),
                float(peaks[i]), floquet[i], bool(stable[i]), float(tail_of(wide[i : i + 1])[0]), Status.OK,
                "finished", name, float(values[i]),
            )
            for i in np.flatnonzero(labels == label)
        ]  # fmt: skip

    return Branch(
        parameter, values, omega, coefficients, peaks, floquet, stable, special(FOLD, "fold"),
        special(DOUBLING, "period doubling"), problem.turns, found.outcome == CLOSED, tail, origin, status, message,
        special(BRANCH_POINT, "symmetry breaking / branch point"),
    )  # fmt: skip


def with_crest(problem: Any, points: Floats, labels: Any, traces: Floats, peaks: Floats) -> tuple[Any, ...]:
    """Insert the point with the largest |x| of the branch, where the parabola through three points has its vertex."""
    i = int(np.argmax(peaks)) if len(peaks) else 0
    if not 0 < i < len(points) - 1:
        return points, labels, traces, peaks
    before, here, after = points[i - 1 : i + 2]
    a, b = float(np.linalg.norm(here - before)), float(np.linalg.norm(after - here))
    if a == 0.0 or b == 0.0:
        return points, labels, traces, peaks
    left, right = (peaks[i] - peaks[i - 1]) / a, (peaks[i + 1] - peaks[i]) / b
    bend = (right - left) / (a + b)
    s = -0.5 * (left + bend * a) / bend if bend < 0.0 else 0.0
    step, turn = (here - before) / a, ((after - here) / b - (here - before) / a) / (a + b)
    guess = here + s * (step + turn * (s + a))
    found = solve(problem, guess)
    if found is None or float(np.linalg.norm(found - guess)) > 0.1 * min(a, b):
        return points, labels, traces, peaks
    place = i if s < 0.0 else i + 1
    new = (found, TOP, *(values[0] for values in hill(problem, found[None])))
    return tuple(
        np.insert(values, place, value, axis=0)
        for values, value in zip((points, labels, traces, peaks), new, strict=True)
    )


def with_velocity(x: Floats, w: float) -> Floats:
    """Coefficients (2H+1, 2) of x and x' from those of x, with fundamental frequency w [rad/s]."""
    k = np.arange(1, len(x) // 2 + 1)
    v = np.zeros_like(x)
    v[1::2], v[2::2] = k * w * x[2::2], -k * w * x[1::2]
    return np.stack([x, v], axis=1)


def _verdict(found: Trace, parameter: str, values: Floats) -> tuple[Status, str]:
    if found.message:
        return (Status.OK if found.outcome in (END, CLOSED) else Status.NO_CONVERGENCE), found.message
    if found.outcome in (END, CLOSED):
        return Status.OK, "reached both ends" if found.outcome == END else "closed"
    where = f"at {parameter} = {values[-1]:.6g}" if len(values) else "at its start"
    reason = {LOST: "no solution found", STUCK: "the step became too small"}.get(found.outcome, "too many points")
    return Status.NO_CONVERGENCE, f"the branch stops {where}: {reason}; take more harmonics or a smaller range"
