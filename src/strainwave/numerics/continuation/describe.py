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
from ..stability.second_order import displacement_peaks, frozen, hill, multipliers, orbit_scales
from ..stability.special_points import finer_table, with_crossings
from .crests import with_crests
from .trace import Trace

NAMES = {
    FOLD: "fold",
    DOUBLING: "period doubling",
    BRANCH_POINT: "symmetry breaking / branch point",
    NEIMARK_SACKER: "Neimark-Sacker",
}


def describe(
    problem: Balance, parameter: str, found: Trace, tail: Tail | None, origin: str, *, locate: bool = True,
    floquet: NDArray[np.complex128] | None = None,
) -> Branch:  # fmt: skip
    """Add stability, peaks, crests, period doublings and branch points to a branch, and label the special points.

    Locating those of a general system takes far longer than the rest; without `locate` it has the points found alone,
    whose multipliers may be known.
    """
    points, labels = np.ascontiguousarray(found.points), found.labels
    status, message = _verdict(found, parameter, points[:, -1])
    tail = tail_along(problem, points) if tail is None else tail
    if locate:
        points, labels = with_crests(problem, points, labels)
    if problem.hill():
        points, labels, floquet, peaks = with_hill(problem, points, labels)
    else:
        points, labels, floquet, peaks = with_stability(problem, points, labels, locate, floquet)
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
        found.outcome == CLOSED, tail.share, origin, *verdict, crossings, tori, span=found.span or _ends(values),
    )  # fmt: skip


def _ends(values: Floats) -> tuple[float, float]:
    return (float(np.min(values)), float(np.max(values))) if len(values) else (np.nan, np.nan)


def with_hill(
    problem: Any, points: Floats, labels: Any
) -> tuple[Floats, Any, NDArray[np.complex128], Floats]:  # fmt: skip
    """Points of an oscillator's branch with its special points, their multipliers and largest |x|."""
    traces, peaks = hill(problem, points)
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


def _verdict(found: Trace, parameter: str, values: Floats) -> tuple[Status, str]:
    if found.message:
        return (Status.OK if found.outcome in (END, CLOSED) else Status.NO_CONVERGENCE), found.message
    if found.outcome in (END, CLOSED):
        return Status.OK, "reached both ends" if found.outcome == END else "closed"
    where = f"at {parameter} = {values[-1]:.6g}" if len(values) else "at its start"
    reason = {LOST: "no solution found", STUCK: "the step became too small"}.get(found.outcome, "too many points")
    return Status.NO_CONVERGENCE, f"the branch stops {where}: {reason}; take more harmonics or a smaller range"
