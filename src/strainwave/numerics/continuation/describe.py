"""Branches of periodic orbits described: stability, peaks, special points, and the result that users see.

What each point of a curve needs is done for all points at once.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...protocols import Balance
from ...results import Branch, Floats, Orbit, Status
from ..balance.fourier import from_blocks
from ..balance.rates import base_speed
from ..balance.truncation import Tail, tail_along
from ..labels import BRANCH_POINT, CLOSED, DOUBLING, END, FOLD, LOST, NEIMARK_SACKER, STUCK, TOP
from ..stability.first_order import with_stability
from ..stability.second_order import displacement_peaks, frozen, grid_of, hill, multipliers, orbit_scales, steps_for
from ..stability.special_points import finer_table, with_crossings
from .trace import Trace, solve

SAME = 1e-6  # relative distance of points that are one
NAMES = {
    FOLD: "fold",
    DOUBLING: "period doubling",
    BRANCH_POINT: "symmetry breaking / branch point",
    NEIMARK_SACKER: "Neimark-Sacker",
}


def describe(
    problem: Balance, parameter: str, found: Trace, tail: Tail | None, origin: str, *, locate: bool = True
) -> Branch:  # fmt: skip
    """Add stability, peaks, period doublings and branch points to a branch, and label the special points.

    Locating those of a general system takes far longer than the rest; without `locate` it has its folds alone.
    """
    points, labels = np.ascontiguousarray(found.points), found.labels
    status, message = _verdict(found, parameter, points[:, -1])
    tail = tail_along(problem, points) if tail is None else tail
    if problem.hill():
        points, labels, floquet, peaks = with_hill(problem, points, labels)
    else:
        points, labels = with_top(problem, points, labels)
        points, labels, floquet, peaks = with_stability(problem, points, labels, locate)
    series = problem.displacements(points)
    if parameter.startswith("error."):  # the kinematic error itself varies along the branch
        peaks = displacement_peaks(series)
    values, turns = points[:, -1].copy(), int(problem.turns)
    omega = base_speed(problem, values.copy())
    coefficients, stable = from_blocks(series.T).T, np.abs(floquet[:, 0]) < 1.0
    special: dict[int, list[Orbit]] = {label: [] for label in NAMES}
    for i in np.flatnonzero((labels == FOLD) | (labels > TOP)).tolist():
        label, w = int(labels[i]), float(omega[i])
        table = problem.motion(points[i], coefficients[i])
        said = tail.share, *tail.verdict(Status.OK, "finished", parameter, w), NAMES[label], float(values[i])
        special[label].append(Orbit(w, turns, table, float(peaks[i]), floquet[i], bool(stable[i]), *said))
    folds, doublings, crossings, tori = special.values()
    verdict = tail.verdict(status, message, parameter, float(omega[0]) if len(omega) else 0.0)
    return Branch(
        parameter, values, omega, coefficients, peaks, floquet, stable, folds, doublings, turns,
        found.outcome == CLOSED, tail.share, origin, *verdict, crossings, tori,
    )  # fmt: skip


def with_hill(
    problem: Any, points: Floats, labels: Any
) -> tuple[Floats, Any, NDArray[np.complex128], Floats]:  # fmt: skip
    """Points of an oscillator's branch with its crest and special points, their multipliers and largest |x|."""
    grid = grid_of(problem, steps_for(problem, points))
    points, labels, traces, peaks = with_crest(problem, grid, points, labels, *hill(problem, points, grid))
    decay = orbit_scales(problem, points[:, -1])[1]
    points, labels, added = with_crossings(problem, points, labels, traces, decay)
    if added:
        traces, peaks = hill(problem, points)
        located = labels > TOP
        traces[located] = hill(problem, points[located], finer_table(problem, points[located]))[0]
        decay = orbit_scales(problem, points[:, -1])[1]
    floquet = multipliers(traces, decay)
    if np.isnan(floquet).any():
        floquet = np.where(np.isnan(floquet), frozen(problem, points), floquet)
    return points, labels, floquet, peaks


def with_crest(
    problem: Any, grid: Floats, points: Floats, labels: Any, traces: Floats, peaks: Floats
) -> tuple[Any, ...]:
    """Insert the crest of a branch, with its trace."""
    found = crest(problem, points, peaks)
    if found is None:
        return points, labels, traces, peaks
    place, point = found
    new = (point[None], np.array([TOP]), *hill(problem, point[None], grid))
    return tuple(
        np.concatenate([values[:place], value, values[place:]])
        for values, value in zip((points, labels, traces, peaks), new, strict=True)
    )


def with_top(problem: Balance, points: Floats, labels: Any) -> tuple[Floats, Any]:
    """Points and labels of a general problem with that of the largest |x| among them, labelled TOP."""
    if len(points) < 3:
        return points, labels
    top = crest(problem, points, displacement_peaks(problem.displacements(points)))
    if top is None or np.min(np.linalg.norm(points - top[1], axis=1)) < SAME * np.linalg.norm(top[1]):
        return points, labels
    return np.insert(points, top[0], top[1], axis=0), np.insert(labels, top[0], TOP)


def crest(problem: Any, points: Floats, peaks: Floats) -> tuple[int, Floats] | None:
    """Place and point with the largest |x| of a branch, at the vertex of the parabola through three of its points."""
    i = int(np.argmax(peaks)) if len(peaks) else 0
    if not 0 < i < len(points) - 1:
        return None
    before, here, after = points[i - 1 : i + 2]
    a, b = float(np.linalg.norm(here - before)), float(np.linalg.norm(after - here))
    if a == 0.0 or b == 0.0:
        return None
    left, right = (peaks[i] - peaks[i - 1]) / a, (peaks[i + 1] - peaks[i]) / b
    bend = (right - left) / (a + b)
    s = -0.5 * (left + bend * a) / bend if bend < 0.0 else 0.0
    step, turn = (here - before) / a, ((after - here) / b - (here - before) / a) / (a + b)
    guess = here + s * (step + turn * (s + a))
    found = solve(problem, guess)
    if found is None or float(np.linalg.norm(found - guess)) > 0.1 * min(a, b):
        return None
    return (i if s < 0.0 else i + 1), found


def _verdict(found: Trace, parameter: str, values: Floats) -> tuple[Status, str]:
    if found.message:
        return (Status.OK if found.outcome in (END, CLOSED) else Status.NO_CONVERGENCE), found.message
    if found.outcome in (END, CLOSED):
        return Status.OK, "reached both ends" if found.outcome == END else "closed"
    where = f"at {parameter} = {values[-1]:.6g}" if len(values) else "at its start"
    reason = {LOST: "no solution found", STUCK: "the step became too small"}.get(found.outcome, "too many points")
    return Status.NO_CONVERGENCE, f"the branch stops {where}: {reason}; take more harmonics or a smaller range"
