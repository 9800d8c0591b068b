"""Stability of the orbits of a general balance problem, and their special points.

A disturbance y of an orbit obeys y' = A(t) y with the system's Jacobian A along the orbit; one period of that flow, by
the eighth-order method of DOP853 for all points of a branch at once, is the monodromy matrix, and its eigenvalues are
the multipliers. Three of its functions change sign where the orbit does: the product of 1 + m (period doubling), of
1 - m (fold, branch point) and of m_i m_j - 1 over all pairs (Neimark-Sacker, where a complex pair leaves the unit
circle).

Seydel 2010, Practical Bifurcation and Stability Analysis, secs. 7.2-7.4; Hairer & Wanner 1996, Solving Ordinary
Differential Equations II, sec. IV.5 (Gauss methods); Kuznetsov 2004, Elements of Applied
Bifurcation Theory, sec. 10.2 (test functions).
"""

import math
from collections.abc import Iterator
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...results import Floats
from ...tree import with_leaf
from ..balance.first_order import FirstOrder
from ..balance.panels import distance_along, pieces
from ..balance.rates import base_speed, jacobians_at
from ..integration.tableaus import DOP8_A, DOP8_B, DOP8_C
from ..labels import BRANCH_POINT, DOUBLING, FOLD, NEIMARK_SACKER
from .second_order import LARGEST_LOG, displacement_peaks
from .special_points import inserted, root_on_chord

_PLACES, _WEIGHTS = np.polynomial.legendre.leggauss(4)
GAUSS_C, GAUSS_B = 0.5 + 0.5 * _PLACES, 0.5 * _WEIGHTS
_POWERS = np.arange(1, 5)  # collocation: the rows integrate powers of the place exactly
GAUSS_A = GAUSS_C[:, None] ** _POWERS / _POWERS @ np.linalg.inv(GAUSS_C[:, None] ** (_POWERS - 1))
FINEST = 4096  # steps a period
PHASE = 0.3  # of the fastest eigenvalue in a step: errors of about 1e-11 a step


def monodromy(problem: FirstOrder, points: Floats) -> Floats:
    """Period maps (points, states, states) of disturbances of orbits (coefficients, parameter last).

    Of laws with breakpoints the steps end at the kinks of each orbit.
    """
    if problem.kinked:
        n = len(problem.sizes)
        return np.array([_between_kinks(problem, point[None, :]) for point in points]).reshape(-1, n, n)
    flow = np.tile(np.eye(len(problem.sizes)), (len(points), 1, 1))
    for h, matrices in _stages(problem, points):
        flow = _advanced(flow, h, matrices)
    return flow


def _between_kinks(problem: FirstOrder, point: Floats) -> Floats:
    """Period map (states, states) of one orbit: the product of the maps of all steps, which are found at once.

    By the Gauss method of order 8, whose places lie inside a step: at its ends the Jacobian jumps.
    """
    system, y = with_leaf(problem.system, problem.leaf, float(point[0, -1])), problem.series(point)[0]
    distance = distance_along(system, y, problem.turns)
    first, width = pieces(distance, problem.harmonics(), 2.0 * math.pi / _steps(problem, point))
    psi = first[:, None] + width[:, None] * GAUSS_C
    n, rows = len(problem.sizes), len(GAUSS_C) * len(problem.sizes)
    a = _matrices(problem, _systems(problem, point), point, psi.ravel())[0].reshape(*psi.shape, n, n)
    a *= (width * problem.turns / base_speed(problem, point[:, -1]))[:, None, None, None]
    coupled = np.einsum("ij,mikl->mikjl", GAUSS_A, a).reshape(-1, rows, rows)
    rates = np.linalg.solve(np.eye(rows) - coupled, a.reshape(-1, rows, n)).reshape(a.shape)
    flow = np.eye(n)
    for step in np.eye(n) + np.einsum("i,mikl->mkl", GAUSS_B, rates):
        flow = step @ flow
    return flow


def floquet_of(problem: Any, points: Floats) -> NDArray[np.complex128]:
    """Multipliers (points, states) of orbits of a problem, largest modulus first."""
    flow, orbits, times = problem.disturbed(points)
    return np.asarray(_floquet(flow, orbits) ** times)


def _floquet(problem: FirstOrder, points: Floats) -> NDArray[np.complex128]:
    """Multipliers (points, states) of orbits in all states, largest modulus first.

    Of orbits so slow that no steps resolve their disturbances: the exponential of the integral of the Jacobian's
    eigenvalues over a period (WKB), each followed by its rank among the real parts.
    """
    states = len(problem.sizes)
    phases = _phases(problem, points)
    slow = phases > 4.0 * PHASE * FINEST
    found = np.zeros((len(points), states), complex)
    if not slow.all():
        found[~slow] = multipliers_of(monodromy(problem, points[~slow]))
    for i in np.flatnonzero(slow):
        point = points[i : i + 1]
        psi = 2.0 * math.pi * np.arange(FINEST) / FINEST
        rates = np.linalg.eigvals(_matrices(problem, _systems(problem, point), point, psi)[0]).astype(complex)
        mean = np.mean(np.take_along_axis(rates, np.lexsort((rates.imag, rates.real), axis=1), axis=1), axis=0)
        log = mean * 2.0 * math.pi * problem.turns / base_speed(problem, point[:, -1])[0]
        found[i] = np.exp(np.minimum(log.real, LARGEST_LOG) + 1j * log.imag)[::-1]
    return found


def hill_map(problem: FirstOrder, points: Floats) -> tuple[Floats, Floats, Floats]:
    """Period maps without their mean growth, in a form that neither under- nor overflows.

    Abel's formula: the determinant of a period map is the exponential of the integral of A's trace. Without its share
    of the trace A gives a map of determinant 1.

    Returns
    -------
    (points, states, states), (points,), (points,) arrays
        M, s and d: the period map is exp(d + s) M, where exp(s) M has the determinant 1.
    """
    flow = np.tile(np.eye(len(problem.sizes)), (len(points), 1, 1))
    size, decay = np.zeros(len(points)), np.zeros(len(points))
    for h, matrices in _stages(problem, points):
        mean = np.trace(matrices, axis1=2, axis2=3) / matrices.shape[-1]
        flow = _advanced(flow, h, matrices - mean[..., None, None] * np.eye(matrices.shape[-1]))
        decay += h[:, 0, 0] * (mean @ np.array(DOP8_B))
        largest = np.max(np.abs(flow), axis=(1, 2))
        flow /= largest[:, None, None]
        size += np.log(largest)
    return flow, size, decay


def _stages(problem: FirstOrder, points: Floats) -> Iterator[tuple[Floats, Floats]]:
    """Length (points, 1, 1) [s] of every step of a period, and the matrices at the stages of the method."""
    steps = _steps(problem, points)
    system = _systems(problem, points)
    h = 2.0 * math.pi / steps * problem.turns / base_speed(problem, points[:, -1])[:, None, None]
    for i in range(steps):
        yield h, _matrices(problem, system, points, 2.0 * math.pi * (i + np.array(DOP8_C)) / steps)


def _advanced(flow: Floats, h: Floats, matrices: Floats) -> Floats:
    """Flow after a step of the eighth-order method."""
    rates: list[Floats] = []
    for stage, weights in enumerate(DOP8_A):
        moved = flow + h * sum(a * rate for a, rate in zip(weights, rates, strict=True) if a)
        rates.append(matrices[:, stage] @ moved)
    return np.asarray(flow + h * sum(b * rate for b, rate in zip(DOP8_B, rates, strict=True) if b))


def _systems(problem: FirstOrder, points: Floats) -> Any:
    return with_leaf(problem.system, problem.leaf, points[:, -1, None])


def _matrices(problem: FirstOrder, system: Any, points: Floats, psi: Floats) -> Floats:
    """Jacobians (points, psi, states, states) along every orbit."""
    k = np.arange(1, problem.harmonics() + 1)[:, None]
    basis = np.vstack([np.ones((1, len(psi))), np.cos(k * psi), np.sin(k * psi)])
    y = np.moveaxis(problem.series(points) @ basis, 1, 0)
    angles = np.broadcast_to(problem.turns * psi, y.shape[1:])
    return np.moveaxis(jacobians_at(system, angles, y, problem.sizes, problem.difference()), (0, 1), (2, 3))


def _steps(problem: FirstOrder, points: Floats) -> int:
    phase = float(np.max(_phases(problem, points[:: max(1, len(points) // 16)]), initial=0.0))
    return min(FINEST, max(64, 8 * problem.harmonics() + 4, math.ceil(phase / PHASE)))


def _phases(problem: FirstOrder, points: Floats) -> Floats:
    """Angle [rad] (points,) through which the fastest disturbance turns, or the exponent by which it decays."""
    psi = 2.0 * math.pi * np.arange(64) / 64
    rates = np.linalg.eigvals(_matrices(problem, _systems(problem, points), points, psi))
    period = 2.0 * math.pi * problem.turns / base_speed(problem, points[:, -1])
    return np.asarray(np.max(np.abs(rates), axis=(1, 2)) * period)


def multipliers_of(flow: Floats) -> NDArray[np.complex128]:
    """Eigenvalues (points, states) of period maps, largest modulus first."""
    values = np.linalg.eigvals(flow).astype(complex)
    return np.asarray(np.take_along_axis(values, np.argsort(-np.abs(values), axis=1, kind="stable"), axis=1), complex)


def tests_of(multipliers: NDArray[np.complex128]) -> dict[int, Floats]:
    """What changes sign at a period doubling, a fold or branch point, and a Neimark-Sacker point."""
    pairs = list(combinations(range(multipliers.shape[1]), 2))
    torus = np.prod([multipliers[:, i] * multipliers[:, j] - 1.0 for i, j in pairs], axis=0).real if pairs else None
    found = {
        DOUBLING: np.prod(1.0 + multipliers, axis=1).real,
        BRANCH_POINT: np.prod(1.0 - multipliers, axis=1).real,
    }
    return found if torus is None else found | {NEIMARK_SACKER: torus}


def with_special_points(
    problem: Any, points: Floats, labels: Any, floquet: NDArray[np.complex128]
) -> tuple[Floats, Any, NDArray[np.complex128]]:
    """Insert the period doublings, branch points and Neimark-Sacker points of a branch, with their multipliers."""
    tests = tests_of(floquet)
    found = []
    for label, values in tests.items():
        for i in np.flatnonzero(values[1:] * values[:-1] < 0.0):
            near_fold = FOLD in labels[max(0, i - 1) : i + 3]
            point = None if label == BRANCH_POINT and near_fold else _located(problem, points[i], points[i + 1], label)
            if point is not None:
                found.append((int(i), label, point))
    if not found:
        return points, labels, floquet
    points, labels, places, added = inserted(points, labels, found)
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
    problem: Any, points: Floats, labels: Any, locate: bool
) -> tuple[Floats, Any, NDArray[np.complex128], Floats]:
    """Points of a branch with its special points, if they are to be located, their multipliers and largest |x|."""
    floquet = floquet_of(problem, points) if len(points) else np.empty((0, problem.state_count()), complex)
    if locate and len(points) > 1:
        points, labels, floquet = with_special_points(problem, points, labels, floquet)
    peaks = displacement_peaks(problem.displacements(points)) if len(points) else np.empty(0)
    return points, labels, floquet, peaks
