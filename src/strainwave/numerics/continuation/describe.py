"""Branches of periodic orbits described: stability, peaks, special points, and the result that users see.

What each point of a curve needs is done for all points of all curves at once: `together`.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...results import Branch, Floats, Orbit, Status
from ..balance.first_order import FirstOrder
from ..balance.fourier import from_blocks
from ..balance.guess import error_coefficients
from ..balance.second_order import all_orders
from ..balance.truncation import Tail, tail_along, tails_together
from ..labels import BRANCH_POINT, CLOSED, DOUBLING, END, FOLD, LOST, STUCK, TOP
from ..stability.first_order import described
from ..stability.second_order import displacement_peaks, frozen, grid_of, hill, multipliers, orbit_scales, steps_for
from ..stability.special_points import finer_table, with_crossings
from .trace import Trace, solve, with_velocity


@dataclass(frozen=True)
class Survey:
    """A traced curve (coefficients in blocks, parameter last) with all that depends on its own system.

    `series` holds the coefficients of x in blocks, `decay` is exp(-B period/(2J)) at every point, `tail` is None where
    `together` finds it.
    """

    problem: Any
    points: Floats
    labels: Any
    series: Floats
    omega: Floats
    decay: Floats
    traces: Floats
    peaks: Floats
    closed: bool
    tail: Tail | None
    origin: str
    status: Status
    message: str
    elsewhere: tuple[tuple[float, Floats], ...]


def describe(
    problem: Any, parameter: str, found: Trace, tail: Tail | None, origin: str, *, locate: bool = True
) -> Branch:  # fmt: skip
    """Add stability, peaks, period doublings and branch points to a branch, and label the special points.

    Locating those of a general system takes far longer than the rest; without `locate` it has its folds alone.
    """
    if isinstance(problem, FirstOrder):
        tail = tail_along(problem, found.points) if tail is None else tail
        points = np.ascontiguousarray(found.points)
        status, message = _verdict(found, parameter, points[:, -1])
        return described(problem, parameter, points, found.labels, found.outcome, tail, origin, status, message, locate)
    return together([survey(problem, parameter, found, tail, origin)], parameter)[0]


def survey(problem: Any, parameter: str, found: Trace, tail: Tail | None, origin: str) -> Survey:
    """Add what needs the system: traces of the period map, peaks, the crest, period doublings and branch points."""
    points, labels = np.ascontiguousarray(found.points), found.labels
    status, message = _verdict(found, parameter, points[:, -1])
    grid = grid_of(problem, steps_for(problem, points))
    points, labels, traces, peaks = with_crest(problem, grid, points, labels, *hill(problem, points, grid))
    omega, decay = orbit_scales(problem, points[:, -1])
    points, labels, added = with_crossings(problem, points, labels, traces, decay)
    if added:
        traces, peaks = hill(problem, points)
        located = labels > TOP
        traces[located] = hill(problem, points[located], finer_table(problem, points[located]))[0]
        omega, decay = orbit_scales(problem, points[:, -1])
    if parameter.startswith("error."):  # the kinematic error itself varies along the branch
        series = points[:, :-1] + error_coefficients(problem, points[:, -1])
        peaks = displacement_peaks(all_orders(problem, series))
    else:
        series = points[:, :-1] + problem.error
    closed = found.outcome == CLOSED
    said = closed, tail, origin, status, message, found.elsewhere
    return Survey(problem, points, labels, series, omega, decay, traces, peaks, *said)


def together(curves: list[Survey], parameter: str) -> list[Branch]:
    """Describe curves with equal harmonics, all at once: multipliers, coefficients, and orbits at special points."""

    def joined(arrays: list[Any]) -> Any:
        return arrays[0] if len(arrays) == 1 else np.concatenate(arrays)

    problem, turns = curves[0].problem, curves[0].problem.turns
    ends = np.cumsum([len(c.points) for c in curves]).tolist()
    omega, peaks, labels = (joined([getattr(c, name) for c in curves]) for name in ("omega", "peaks", "labels"))
    values = joined([c.points[:, -1] for c in curves])
    floquet = multipliers(joined([c.traces for c in curves]), joined([c.decay for c in curves]))
    if np.isnan(floquet).any():
        slow = joined([frozen(c.problem, c.points) for c in curves])
        floquet = np.where(np.isnan(floquet), slow, floquet)
    stable = np.abs(floquet[:, 0]) < 1.0
    wide = all_orders(problem, joined([c.series for c in curves]))
    coefficients = from_blocks(wide.T).T
    beyond = _tails(curves)
    special = np.flatnonzero((labels == FOLD) | (labels > TOP))
    found: dict[int, list[tuple[int, Orbit]]] = {FOLD: [], DOUBLING: [], BRANCH_POINT: []}
    names = {FOLD: "fold", DOUBLING: "period doubling", BRANCH_POINT: "symmetry breaking / branch point"}
    which = np.searchsorted(ends, special, side="right").tolist()
    for i, curve in zip(special.tolist(), which, strict=True):
        label, tail = int(labels[i]), beyond[curve]
        status, message = tail.verdict(Status.OK, "finished", parameter, float(omega[i]))
        states = with_velocity(coefficients[i], omega[i] / turns)
        orbit = Orbit(
            float(omega[i]), turns, states, float(peaks[i]), floquet[i], bool(stable[i]), tail.share, status, message,
            names[label], float(values[i]),
        )  # fmt: skip
        found[label].append((i, orbit))
    branches = []
    for c, tail, first, last in zip(curves, beyond, [0, *ends], ends, strict=False):
        own = slice(first, last)
        verdict = tail.verdict(c.status, c.message, parameter, float(omega[first]) if last > first else 0.0)
        arrays = (values[own], omega[own], coefficients[own], peaks[own], floquet[own], stable[own])
        folds, doublings, crossings = ([o for i, o in some if first <= i < last] for some in found.values())
        said = (c.closed, tail.share, c.origin, *verdict)
        branches.append(Branch(parameter, *arrays, folds, doublings, turns, *said, crossings))
    return branches


def _tails(curves: list[Survey]) -> list[Tail]:
    """Tails of the curves: those they have, and the others found all at once."""
    open_ = [c for c in curves if c.tail is None]
    found = iter(tails_together([c.problem for c in open_], [c.points for c in open_]) if open_ else ())
    return [next(found) if c.tail is None else c.tail for c in curves]


def with_crest(
    problem: Any, grid: Floats, points: Floats, labels: Any, traces: Floats, peaks: Floats
) -> tuple[Any, ...]:
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
    new = (found[None], np.array([TOP]), *hill(problem, found[None], grid))
    return tuple(
        np.concatenate([values[:place], value, values[place:]])
        for values, value in zip((points, labels, traces, peaks), new, strict=True)
    )


def _verdict(found: Trace, parameter: str, values: Floats) -> tuple[Status, str]:
    if found.message:
        return (Status.OK if found.outcome in (END, CLOSED) else Status.NO_CONVERGENCE), found.message
    if found.outcome in (END, CLOSED):
        return Status.OK, "reached both ends" if found.outcome == END else "closed"
    where = f"at {parameter} = {values[-1]:.6g}" if len(values) else "at its start"
    reason = {LOST: "no solution found", STUCK: "the step became too small"}.get(found.outcome, "too many points")
    return Status.NO_CONVERGENCE, f"the branch stops {where}: {reason}; take more harmonics or a smaller range"
