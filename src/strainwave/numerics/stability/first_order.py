"""Stability of the orbits of a general balance problem, and their special points.

A disturbance y of an orbit obeys y' = A(t) y with the system's Jacobian A along the orbit; one period of that flow, by
Gauss's method of order 8 (`panel_map`), is the monodromy matrix, and its eigenvalues are the multipliers. Three of
its functions change sign where the orbit does: the product of 1 + m (period doubling), of 1 - m (fold, branch point)
and of m_i m_j - 1 over all pairs (Neimark-Sacker, where a complex pair leaves the unit circle).

Seydel 2010, Practical Bifurcation and Stability Analysis, secs. 7.2-7.4; Kuznetsov 2004, Elements of Applied
Bifurcation Theory, sec. 10.2 (test functions).
"""

import math
from itertools import combinations
from typing import Any

import numpy as np

from ...base.branch_labels import BRANCH_POINT, DOUBLING, FOLD, NEIMARK_SACKER
from ...base.results import Complexes, Floats
from ...base.series import remembered
from ...compile.jit import kernel_as, routine
from ...compile.tree import with_leaf
from ..balance.first_order import FirstOrder
from ..balance.first_order_at import pieces_of, state_at
from ..balance.fourier import LOOKED as LOOKED_AT_KINKS
from ..balance.fourier import Samples, pieces
from ..balance.rates import base_speed
from .gauss_steps import GAUSS_PLACES, gauss_step, gauss_steps
from .panel_map import maps_through_panels, resolved
from .second_order import LARGEST_LOG
from .special_points import changes, inserted, root_on_chord

FINEST = 4096  # steps a period
PHASE = 0.6  # of the fastest eigenvalue in a step: errors of 4e-10 a step
KINKED = 2.0  # the same where steps end at kinks, whose places have errors of 4e-8
EIGENVALUE_PLACES = 32  # places a period where the fastest eigenvalue is looked for
SQUARES = 5  # of a matrix: the 32nd root of the size of its 32nd power is its fastest eigenvalue, or a little more
SLOW = 1.2 * FINEST  # angle of the fastest disturbance in a period [rad] that no steps resolve
C = tuple(GAUSS_PLACES.tolist())
SLOW_PLACES, SAME_RATE = (32, 64, 256, FINEST), 1e-5  # angles of a slow turn; relative change of a mean rate
EVEN = 16  # numbers of steps are multiples of it, so that orbits share tables


def floquet_of(problem: Any, points: Floats) -> Complexes:
    """Multipliers (points, states) of orbits of a problem, largest modulus first."""
    resolvable = problem.disturbances(points)
    if resolvable is not None and resolved(resolvable):
        return np.asarray(multipliers_of(maps_through_panels(resolvable)) ** problem.every)
    flow, orbits, times = problem.disturbed(points)
    return np.asarray(_floquet(flow, orbits) ** times)


def _floquet(problem: FirstOrder, points: Floats) -> Complexes:
    """Multipliers (points, states) of orbits in all states, largest modulus first.

    Of orbits so slow that no steps resolve their disturbances: the exponential of the integral of the Jacobian's
    eigenvalues over a period (WKB), each followed by its rank among the real parts.
    """
    flow, (phases, *_) = period_maps(problem, points)
    slow = phases > SLOW
    values = np.zeros(flow.shape[:2], complex)
    values[~slow] = multipliers_of(flow[~slow])
    for i in np.flatnonzero(slow):
        point = points[i : i + 1]
        mean = _mean_rates(problem, point)
        log = mean * 2.0 * math.pi * problem.turns / base_speed(problem, point[:, -1])[0]
        values[i] = np.exp(np.minimum(log.real, LARGEST_LOG) + 1j * log.imag)[::-1]
    return values


def _mean_rates(problem: FirstOrder, point: Floats) -> Complexes:
    """Means over a turn (states,) of the Jacobian's eigenvalues, ordered at each angle; more angles until they stay."""
    mean = np.zeros(0)
    for count in SLOW_PLACES:
        before, psi = mean, 2.0 * math.pi * np.arange(count) / count
        rates = np.linalg.eigvals(_matrices(problem, point, psi)[0]).astype(complex)
        mean = np.mean(np.take_along_axis(rates, np.lexsort((rates.imag, rates.real), axis=1), axis=1), axis=0)
        if len(before) and np.all(np.abs(mean - before) <= SAME_RATE * np.abs(mean)):
            break
    return np.asarray(mean)


def period_maps(problem: FirstOrder, points: Floats, hill: bool = False) -> tuple[Floats, Floats]:
    """Period maps of orbits; with `hill` without their mean growth, in a form that neither under- nor overflows.

    Abel's formula: the determinant of a period map is the exponential of the integral of A's trace. Without its share
    of the trace A gives a map of determinant 1. Of laws with breakpoints the steps end at the kinks of each orbit.

    Returns
    -------
    (points, states, states), (3, points) arrays
        M, and for each point what `map_along` returns: an angle, s and d. With `hill` the period map is exp(d + s) M,
        where exp(s) M has the determinant 1; else it is M.
    """
    flow = np.tile(np.eye(len(problem.sizes)), (len(points), 1, 1))
    returned = [
        problem.run_as(problem.native, "samples", map_along, point, hill, period_map)
        for point, period_map in zip(np.ascontiguousarray(points), flow, strict=True)
    ]
    return flow, np.array(returned, float).reshape(-1, 3).T


def _map_loops(problem: Any, point: Floats, hill: bool, flow: Floats) -> Any:
    n, h = len(problem.sizes), problem.harmonics
    series, strength, speed = problem.take(point)
    phase = fastest(problem, series, strength) / speed
    if phase > SLOW and not hill:
        return phase, 0.0, 0.0
    least = max(64, 4 * h + 4 if problem.kinks > 0 else 8 * h + 4)
    fine = min(float(FINEST), max(float(least), math.ceil(phase / (KINKED if problem.kinks > 0 else PHASE))))
    if problem.kinks == 0:
        fine = EVEN * math.ceil(fine / EVEN)
    steps = int(fine)
    room = steps + problem.kinks * LOOKED_AT_KINKS * (h + 1) + 2
    first, width = np.empty(room), np.empty(room)
    if problem.kinks > 0:
        steps = pieces_of(problem, series, 2.0 * math.pi / steps, first, width)
    else:
        for s in range(steps):
            first[s], width[s] = 2.0 * math.pi * s / steps, 2.0 * math.pi / steps
    w, state = np.empty((4, 2 * n, n)), np.empty(n)
    a, m, step, size, decay = np.empty((4, n, n)), np.empty((4 * n, 5 * n)), np.empty((2, n, n)), 0.0, 0.0
    for s in range(steps):
        for i in range(4):
            psi = first[s] + width[s] * C[i]
            state_at(series, psi, state)
            problem.slopes(psi, state, w, strength, a[i])
        more, less = gauss_step(a, width[s] / speed, hill, m, step, flow)
        size, decay = size + more, decay + less
    return phase, size, decay


@kernel_as(_map_loops)
def map_along(problem: FirstOrder, point: Floats, hill: bool, flow: Floats) -> tuple[float, float, float]:
    """Carry a flow (states, states) along an orbit: the angle of its fastest disturbance, and what `gauss_step` gives.

    Nothing is carried where the angle is above SLOW and the map is to be as it is.
    """
    phase = float(_phases(problem, point[None])[0])
    if phase > SLOW and not hill:
        return phase, 0.0, 0.0
    n, y = len(problem.sizes), problem.series(point[None])[0]
    psi, basis, width = _places(problem, point, y, phase)
    a = np.moveaxis(problem.along(problem.slopes, float(point[-1]), problem.turns * psi, y @ basis), 2, 0)
    times = width * problem.turns / base_speed(problem, point[-1:])
    return phase, *gauss_steps(a.reshape(-1, len(GAUSS_PLACES), n, n), times, hill, flow)


@routine
def fastest(problem: Any, series: Floats, strength: float) -> float:
    """Bound [rad] of the fastest eigenvalue along an orbit, times 2 pi: as `_phases`, in units of harmonic 1."""
    n, log = len(problem.sizes), -math.inf
    w, state = np.empty((4, 2 * n, n)), np.empty(n)
    a, power = np.empty((n, n)), np.empty((n, n))
    for i in range(EIGENVALUE_PLACES):
        psi = 2.0 * math.pi * i / EIGENVALUE_PLACES
        state_at(series, psi, state)
        problem.slopes(psi, state, w, strength, a)
        for j in range(n):
            for k in range(n):
                a[j, k] *= problem.sizes[k] / problem.sizes[j]
        log_size = 0.0
        for _ in range(SQUARES):
            size = 1e-300
            for j in range(n):
                for k in range(n):
                    size = max(size, abs(a[j, k]))
            for j in range(n):
                for k in range(n):
                    power[j, k] = a[j, k] / size
            for j in range(n):
                for k in range(n):
                    total = 0.0
                    for q in range(n):
                        total += power[j, q] * power[q, k]
                    a[j, k] = total
            log_size = 2.0 * (log_size + math.log(size))
        square = 0.0
        for j in range(n):
            for k in range(n):
                square += a[j, k] * a[j, k]
        log = max(log, log_size + math.log(max(math.sqrt(square), 1e-300)))
    return 2.0 * math.pi * math.exp(log / 2.0**SQUARES)


def _places(problem: FirstOrder, point: Floats, y: Floats, phase: float) -> tuple[Floats, Floats, Floats]:
    """Places psi [rad] of Gauss's method in all steps of a period, the synthesis there, and lengths [rad] of steps."""
    h = problem.harmonics()
    if not problem.kinked:
        steps = EVEN * math.ceil(_steps(8 * h + 4, phase / PHASE) / EVEN)
        return *_table(h, steps), np.full(steps, 2.0 * math.pi / steps)
    system = with_leaf(problem.system, problem.leaf, float(point[-1]))
    longest = 2.0 * math.pi / _steps(4 * h + 4, phase / KINKED)
    first, width = pieces(system, y, problem.turns, longest)
    psi = (first[:, None] + width[:, None] * GAUSS_PLACES).ravel()
    return psi, Samples(psi, psi).basis(h), width


@remembered
def _table(harmonics: int, steps: int) -> tuple[Floats, Floats]:
    psi = 2.0 * math.pi / steps * (np.arange(steps)[:, None] + GAUSS_PLACES).ravel()
    return psi, Samples(psi, psi).basis(harmonics)


def _steps(least: int, enough: float) -> int:
    return min(FINEST, max(64, least, math.ceil(enough)))


def _matrices(problem: FirstOrder, points: Floats, psi: Floats) -> Floats:
    """Jacobians (points, psi, states, states) along every orbit."""
    n, basis = len(problem.sizes), Samples(psi, psi).basis(problem.harmonics())
    out = np.empty((len(points), n, n, len(psi)))
    for point, y, matrices in zip(points, problem.series(points), out, strict=True):
        matrices[:] = problem.along(problem.slopes, float(point[-1]), problem.turns * psi, y @ basis)
    return np.moveaxis(out, 3, 1)


def _phases(problem: FirstOrder, points: Floats) -> Floats:
    """Angle [rad] (points,) through which the fastest disturbance turns, or the exponent by which it decays; or more.

    The size of a high power of a matrix tells its largest eigenvalue without looking for all of them.
    """
    power = _matrices(problem, points, 2.0 * math.pi * np.arange(EIGENVALUE_PLACES) / EIGENVALUE_PLACES)
    power = power / problem.sizes[:, None] * problem.sizes
    log = np.zeros(power.shape[:2])
    for _ in range(SQUARES):
        size = np.maximum(np.max(np.abs(power), axis=(2, 3)), 1e-300)
        power = power / size[..., None, None]
        power = power @ power
        log = 2.0 * (log + np.log(size))
    log += np.log(np.maximum(np.linalg.norm(power, axis=(2, 3)), 1e-300))
    period = 2.0 * math.pi * problem.turns / base_speed(problem, points[:, -1])
    return np.asarray(np.exp(np.max(log, axis=1, initial=-np.inf) / 2**SQUARES) * period)


def multipliers_of(flow: Floats) -> Complexes:
    """Eigenvalues (points, states) of period maps, largest modulus first."""
    values = np.linalg.eigvals(flow).astype(complex)
    return np.asarray(np.take_along_axis(values, np.argsort(-np.abs(values), axis=1, kind="stable"), axis=1), complex)


def tests_of(multipliers: Complexes) -> dict[int, Floats]:
    """Functions that change sign at a period doubling, a fold or branch point, and a Neimark-Sacker point."""
    pairs = list(combinations(range(multipliers.shape[1]), 2))
    with np.errstate(over="ignore", invalid="ignore"):  # of a turn that is long beside what grows in it
        torus = np.prod([multipliers[:, i] * multipliers[:, j] - 1.0 for i, j in pairs], axis=0).real if pairs else None
        tests = {
            DOUBLING: np.prod(1.0 + multipliers, axis=1).real,
            BRANCH_POINT: np.prod(1.0 - multipliers, axis=1).real,
        }
    return tests if torus is None else tests | {NEIMARK_SACKER: torus}


def with_special_points(problem: Any, points: Floats, labels: Any, floquet: Complexes) -> tuple[Floats, Any, Complexes]:
    """Insert the period doublings, branch points and Neimark-Sacker points of a branch, with their multipliers."""
    tests = tests_of(floquet)
    specials = []
    for label, values in tests.items():
        for i in changes(values, points):
            near_fold = FOLD in labels[max(0, i - 1) : i + 3]
            point = None if label == BRANCH_POINT and near_fold else _located(problem, points[i], points[i + 1], label)
            if point is not None:
                specials.append((i, label, point))
    if not specials:
        return points, labels, floquet
    points, labels, places, added = inserted(points, labels, specials)
    return points, labels, np.insert(floquet, places, floquet_of(problem, added), axis=0)


def _located(problem: Any, first: Floats, last: Floats, label: int) -> Floats | None:
    """Point between two points of a branch where a test vanishes; None where no such special point is there."""

    def test(point: Floats) -> float:
        return float(tests_of(floquet_of(problem, point[None, :]))[label][0])

    best = root_on_chord(problem, first, last, test)
    if best is not None and label == NEIMARK_SACKER:
        values = floquet_of(problem, best[None, :])[0]
        nearest = values[np.argmin(np.abs(np.abs(values) - 1.0))]
        if abs(abs(nearest) - 1.0) > 1e-6 or abs(nearest.imag) < 1e-6:
            return None
    return best


def with_stability(
    problem: Any, points: Floats, labels: Any, locate: bool, floquet: Complexes | None = None
) -> tuple[Floats, Any, Complexes]:
    """Points of a branch with its special points, if they are to be located, and their multipliers.

    `floquet` are the multipliers of the points, where they are known.
    """
    if floquet is None:
        floquet = floquet_of(problem, points) if len(points) else np.empty((0, problem.state_count()), complex)
    if locate and len(points) > 1:
        points, labels, floquet = with_special_points(problem, points, labels, floquet)
    return points, labels, floquet
