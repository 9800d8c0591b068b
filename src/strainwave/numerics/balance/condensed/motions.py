"""The motions of a condensed problem in all coordinates and states, from the unknowns and back to a first guess.

Disturbances of the orbits of a condensed problem: a constant matrix, and what varies along an orbit.
"""

from typing import Any, NamedTuple

import numpy as np

from ....base.law import breakpoints_of
from ....base.protocols import linear_part_of
from ....base.results import Floats
from ....compile.tree import leaf_of
from ..first_order import FirstOrder
from ..fourier import LOOKED, Samples, analysis, derivative, distances, false_position, synthesis
from ..linear_part import carried
from ..rates import base_speed
from ..truncation import few_of, share_of
from .pencil import condense, eliminated, to_complex, to_real

ANGLE = 1e-3  # least size [rad] of the motor's deviation, for differences


class Disturbances(NamedTuple):
    """y' = (a + b R c) y along orbits, y positions, speeds and states of a control.

    `twists` (orbits, laws, 2h+1) are what the laws see, `mean` (laws,) their stiffnesses in a, `deviation`
    (orbits, 2h+1) is the motor's, or None, and `speed` (orbits,) that of the harmonic 1 [rad/s]. `rate` [1/s] is that
    of the fastest disturbance.
    """

    problem: Any
    a: Floats
    b: Floats
    c: Floats
    mean: Floats
    rate: float
    twists: Floats
    deviation: Floats | None
    speed: Floats

    def feedbacks(self, psi: Floats, bases: list[Floats]) -> Floats:
        """R (n, feedbacks, seen) at places psi (n,) [rad], one orbit after another, each with its synthesis there."""
        part, count = self.problem.part, len(self.mean)
        u = samples(self.twists, bases)
        stiff = [law.stiffness(x) + 0.0 * x for law, x in zip(part.laws, u, strict=True)]
        gains = np.zeros((len(psi), self.b.shape[1], len(self.c)))
        for j in range(count):
            gains[:, j, j] = self.mean[j] - stiff[j]
        if self.deviation is None:
            return gains
        B, w = part.gear_damping, self.speed[:, None, None]
        pair = np.stack([self.twists[:, 0], self.deviation], axis=1)
        d, du, dd = samples(np.concatenate([pair[:, 1:], w * derivative(pair)], axis=1), bases)
        base = np.repeat(self.speed / self.problem.pencil.rate, [basis.shape[1] for basis in bases])
        slope, bend = self.error(psi / self.problem.pencil.rate + d)
        pull = stiff[0] * slope + B * bend * (base + dd)
        torque = part.laws[0].torque(u[0]) + B * du
        gains[:, 0, count + 1], gains[:, 0, count + 2] = pull, B * slope
        gains[:, -1, 0], gains[:, -1, count] = slope * stiff[0], slope * B
        gains[:, -1, count + 1], gains[:, -1, count + 2] = bend * torque - slope * pull, -slope * slope * B
        return gains

    def error(self, angle: Floats) -> tuple[Floats, Floats]:
        """First and second derivatives of the kinematic error at the motor's angles [rad]."""
        slope, bend = np.zeros_like(angle), np.zeros_like(angle)
        for order, even, odd in self.problem.gear.lines[1:]:
            c, s = np.cos(order * angle), np.sin(order * angle)
            slope += order * (odd * c - even * s)
            bend -= order * order * (even * c + odd * s)
        return slope, bend

    def crossings(self) -> list[Floats]:
        """Places [rad] of every orbit, in order, where a law has a breakpoint."""
        pairs = [(j, b) for j, law in enumerate(self.problem.part.laws) for b in breakpoints_of(law)]
        if not pairs:
            return [np.empty(0)] * len(self.twists)
        twist, breaks = map(np.array, zip(*pairs, strict=True))
        h = self.twists.shape[2] // 2
        places = LOOKED * (h + 1)
        d = (self.twists @ synthesis(h, places))[:, twist] - breaks[:, None]
        d = np.concatenate([d, d[..., :1]], axis=2)
        orbit, kink, m = np.nonzero(d[..., 1:] * d[..., :-1] < 0.0)
        step = 2.0 * np.pi / places
        ends = m * step, (m + 1) * step, d[orbit, kink, m], d[orbit, kink, m + 1]
        crossed = _refined(self.twists[orbit, twist[kink]], breaks[kink], *ends)
        return [np.sort(crossed[orbit == i]) for i in range(len(self.twists))]


def disturbances(problem: Any, points: Floats) -> Disturbances | None:
    """Disturbances of the orbits; None where the parameter that varies is no speed, or where inertias are missing."""
    part = problem.part
    if part.loose >= 0 and not np.any(part.integral):
        part = linear_part_of(part.disturbed)
    if part is None or problem.leaf != problem.omega_leaf or not len(points):
        return None
    M, C, K = part.inertia, part.damping.copy(), part.stiffness.copy()
    heavy = np.flatnonzero(np.any(M != 0.0, axis=1))
    massless = np.setdiff1d(np.arange(len(M)), heavy)
    if 2 * len(heavy) + len(massless) != problem.state_count() + len(part.values) - len(problem.part.values):
        return None
    twists, laws = problem.series(points), problem.part.laws
    u = twists[:, : len(laws)] @ problem.synthesis
    stiff = [law.stiffness(u[:, j]) + 0.0 * u[:, j] for j, law in enumerate(laws)]
    mean = np.array([np.mean(k) for k in stiff])
    C[0, 0] += part.gear_damping
    K[range(len(laws)), range(len(laws))] += mean
    loaded = [*range(len(laws)), *([len(laws)] if part.follows else [])]
    a, b = first_order_of(M, C, K, heavy, massless, loaded)
    position = np.eye(len(a))[: len(heavy)]  # the coordinates that laws see, and the motor's, are the first
    speed = np.eye(len(a))[len(heavy) : 2 * len(heavy)]
    c = position[: len(laws)]
    if part.follows:
        c = np.concatenate([c, speed[:1], position[[len(laws)]], speed[[len(laws)]]])
    extremes = [a + b[:, : len(laws)] * (mean - [f(k) for k in stiff]) @ c[: len(laws)] for f in (np.min, np.max)]
    rate = max(float(np.max(np.abs(np.linalg.eigvals(x)))) for x in (a, *extremes))
    w = problem.pencil.rate * base_speed(problem, points[:, -1])
    deviation = twists[:, len(laws)] if part.follows else None
    return Disturbances(problem, a, b, c, mean, rate, twists[:, : len(laws)], deviation, w)


def samples(series: Floats, bases: list[Floats]) -> Floats:
    """Samples (k, n) of series (orbits, k, 2h+1), one orbit after another, each with its synthesis."""
    return np.concatenate([y @ basis for y, basis in zip(series, bases, strict=True)], axis=1)


def first_order_of(M: Floats, C: Floats, K: Floats, heavy: Any, massless: Any, loaded: Any) -> tuple[Floats, Floats]:
    """Matrix of positions, speeds and coordinates without inertia (`massless`), and of torques on `loaded` ones."""
    m, inverse = len(heavy), np.linalg.inv(M[np.ix_(heavy, heavy)])
    n = 2 * m + len(massless)
    a, unit = np.zeros((n, n)), np.eye(len(M))[:, loaded]
    a[:m, m : 2 * m] = np.eye(m)
    rows = slice(2 * m, n)
    if len(massless):
        inverse_c = np.linalg.inv(C[np.ix_(massless, massless)])
        a[rows, :m] = -inverse_c @ K[np.ix_(massless, heavy)]
        a[rows, m : 2 * m] = -inverse_c @ C[np.ix_(massless, heavy)]
        a[rows, rows] = -inverse_c @ K[np.ix_(massless, massless)]
    through = C[np.ix_(heavy, massless)]
    a[m : 2 * m, :m] = -inverse @ (K[np.ix_(heavy, heavy)] + through @ a[rows, :m])
    a[m : 2 * m, m : 2 * m] = -inverse @ (C[np.ix_(heavy, heavy)] + through @ a[rows, m : 2 * m])
    a[m : 2 * m, rows] = -inverse @ (K[np.ix_(heavy, massless)] + through @ a[rows, rows])
    b = np.zeros((n, len(loaded)))
    b[m : 2 * m] = inverse @ unit[heavy]
    return a, b


def _refined(series: Floats, value: Floats, low: Floats, high: Floats, first: Floats, last: Floats) -> Floats:
    """Places [rad] between `low` and `high` where series (n, 2h+1) have a value."""
    h = series.shape[1] // 2

    def missing(psi: Floats) -> Floats:
        return np.asarray(np.sum(series * Samples(psi, psi).basis(h).T, axis=1) - value)

    return false_position(missing, low, high, first, last)


def errors(problem: Any, series: Floats) -> Floats:
    """Coefficients (points, 2h+1) of the kinematic error, from those of the blocks."""
    if not problem.part.follows:
        return np.broadcast_to(problem.gear.error, series[:, 0].shape)
    angles = problem.angles + series[:, -1] @ problem.synthesis
    return np.asarray((problem.part.error.value(angles) + 0.0 * angles) @ problem.analysis)


def coordinates(problem: Any, points: Floats) -> tuple[Any, Any]:
    """All coordinates (points, h+1, n), complex, the first of them x, but for what a control holds; `condense`'s s."""
    blocks = problem.series(points).copy()
    blocks[:, 0] += errors(problem, blocks)
    s = np.empty((len(points), *problem.stiff[0].shape), complex)
    condense(problem.pencil, base_speed(problem, points[:, -1]), 1.0, s, None)
    return eliminated(problem.pencil, s, np.moveaxis(to_complex(blocks), 1, 2)), s


def held_torque(problem: Any, points: Floats, s: Any, p: Any) -> Floats:
    """Mean torque [N*m] (points,) that a control holds, from the balance of its motor; s is what `condense` left."""
    pencil, loose, n = problem.pencil, problem.pencil.loose, s.shape[2]
    given = pencil.forces[loose, 0].real + pencil.per_speed[loose] * base_speed(problem, points[:, -1])
    torque = given - p[:, 0].real @ pencil.matrices[2, loose]
    if not problem.part.follows:
        return np.asarray(torque)
    seen = len(problem.blocks)
    gear = s[:, :, 0, n] - np.sum(s[:, :, 0, :seen] * p[:, :, :seen], axis=2)
    angles = problem.angles + problem.series(points)[:, -1] @ problem.synthesis
    slope = problem.part.error.slope(angles) + 0.0 * angles
    return np.asarray(torque + np.mean(slope * (to_real(gear) @ problem.synthesis), axis=1))


def states(problem: Any, points: Floats) -> Floats:
    """Coefficients (points, states, 2h+1) of all states, in blocks, at every `every`-th harmonic."""
    (p, s), part = coordinates(problem, points), problem.part
    if problem.pencil.controls and np.any(part.integral):
        p[:, 0] += held_torque(problem, points, s, p)[:, None] * part.integral
    w = problem.pencil.rate * base_speed(problem, points[:, -1])[:, None] * np.arange(p.shape[1])
    waves = p @ part.values.T + 1j * w[..., None] * (p @ part.rates.T)
    return to_real(np.moveaxis(waves, 2, 1))


def linear_response(problem: Any, value: float) -> Floats:
    """Guess (coefficients, parameter): the response of the laws' tangents where they carry the mean torques."""
    count, size = problem.blocks.shape
    omega = float(base_speed(problem, np.asarray(value)))
    s = np.empty(problem.stiff[0].shape, complex)
    condense(problem.pencil, omega, 1.0, s, None)
    n, laws = problem.pencil.matrices.shape[1], problem.part.laws
    means = [carried(law, float(s[0, i, n].real)) for i, law in enumerate(laws)]
    matrix = s[:, :count, :count].copy()
    force = s[:, :count, n] - matrix[:, :, 0] * to_complex(problem.gear.error)[:, None]
    for i, law in enumerate(laws):
        matrix[:, i, i] += float(law.stiffness(means[i]))
    matrix[:, 0, 0] += 1j * problem.gear_damping * problem.pencil.rate * omega * np.arange(size // 2 + 1)
    p = np.zeros((size // 2 + 1, count), complex)
    p[1:] = (np.linalg.pinv(matrix[1:], rcond=1e-14) @ force[1:, :, None])[..., 0]
    p[0, : len(laws)] = means
    if count > len(laws):
        remainder = s[0, -1 + count, n] - s[0, count - 1, : len(laws)] @ p[0, : len(laws)]
        holds = s[0, count - 1, count - 1]
        p[0, -1] = remainder / holds if holds else 0.0
    return np.append(to_real(p.T).ravel(), value)


def left_out(problem: Any, points: Floats) -> tuple[Floats, Floats]:
    """Parameter at some points of a curve, and the shares (values, 1 + blocks) left out there, of x and blocks."""
    selected = points[few_of(points)]
    blocks, h = problem.series(selected), problem.harmonics()
    top, count = 3 * h + 8, len(problem.blocks)
    samples = 3 * top
    n, k = problem.pencil.matrices.shape[1], np.arange(h + 1, top + 1)
    s = np.empty((len(selected), top + 1, n, n + 1), complex)
    omega = base_speed(problem, selected[:, -1])
    quiet = problem.pencil._replace(forces=np.zeros((n, top + 1), complex), per_speed=np.zeros(n))
    with np.errstate(all="ignore"):
        condense(quiet, omega, 1.0, s, None)
        matrix, force = s[:, :, :count, :count].copy(), np.zeros((len(selected), top + 1, count), complex)
        for i, law in enumerate(problem.part.laws):
            u = blocks[:, i] @ synthesis(h, samples)
            force[..., i] = -to_complex((law.torque(u) + 0.0 * u) @ analysis(top, samples))
            matrix[..., i, i] += np.mean(law.stiffness(u) + 0.0 * u, axis=1)[:, None]
        matrix[..., 0, 0] += 1j * problem.gear_damping * problem.pencil.rate * omega[:, None] * np.arange(top + 1)
        p = np.zeros_like(force)
        p[:, k] = np.linalg.solve(matrix[:, k], force[:, k, :, None])[..., 0]
        x = eliminated(quiet, s, p) @ problem.part.values[0]
    size = np.linalg.norm(blocks, axis=2)
    size = np.maximum(size, 1e-6 * np.max(size, axis=0))
    x_size = np.linalg.norm(problem.displacements(selected), axis=1)
    return selected[:, -1], np.column_stack(
        [share_of(np.linalg.norm(x, axis=1), x_size), share_of(np.linalg.norm(p, axis=1), size)]
    )


def disturbed(problem: Any, points: Floats) -> tuple[FirstOrder, Floats, int]:
    """Orbits in all states over one of the parts in which they repeat; and how many of them there are."""
    system, h = problem.part.disturbed, problem.harmonics()
    series, samples = states(problem, points), len(problem.angles)
    sizes = np.max(np.linalg.norm(series, axis=2), axis=0, initial=0.0)
    sizes = np.where(sizes > 0.0, sizes, 1.0)
    if problem.part.follows:  # differences of an angle that is added to the base angle
        sizes = np.where(problem.part.values[:, len(problem.part.laws)] != 0.0, np.maximum(sizes, ANGLE), sizes)
    kinked = len(distances(system, np.zeros(1), np.zeros((len(sizes), 1)))) > 0
    leaf = leaf_of(system, "omega")
    flow = FirstOrder(
        system, leaf, leaf, problem.turns / problem.every, sizes, problem.synthesis, problem.analysis,
        analysis(2 * h, samples), problem.angles, kinked,
    )  # fmt: skip
    omega = base_speed(problem, points[:, -1])
    return flow, np.column_stack([(series / sizes[:, None]).reshape(len(points), -1), omega]), problem.every
