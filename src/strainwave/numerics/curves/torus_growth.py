"""Growth of the disturbances of a motion of two turns."""

import math
from fractions import Fraction
from typing import Any

import numpy as np

from ...base.results import Floats
from ..balance.condensed.disturbances import first_order_of
from .torus_motion import LARGEST_TURNS, highest
from .torus_problem import Torus

STARTS, RESOLVED = 16, 1e-6  # slow angles at first, and the share of the highest waves of a map in the end
LEAST_STEPS, PER_ORDER, PHASE, FINEST = 24, 16, 0.4, 2048  # steps a turn: per order, and [rad] of what is fastest
MILD_FACTOR = 2.0  # times that angle, by the fourth root, where the stiffness varies less along the motion
FINER = {"none": 1.0, "shift": 4.0, "mean": 8.0}  # steps by the disturbance left out; those beside it hardly grow
STEPS = np.unique([2**a * b for a in range(1, 12) for b in (4, 5, 6, 7)])  # of a turn: curves take few of these
ENTRIES = 4_000_000  # of all matrices at a time
BATCH_ENTRIES = 60_000  # entries of matrices that are multiplied at a time: these and their powers stay in the cache
SQUARED = 4  # slow waves of a map in one of the motion: where a beat has no more turns, each has its own map


def growth(problem: Torus, flow: Any, points: Floats) -> Floats:
    """Rates (n,) [1/s] at which the disturbances of motions that last longest grow; negative of stable ones.

    `flow` is the part whose disturbances are meant: that of the problem, but for a mean that a control holds in its
    own states. The angle of a motor that nothing holds may be any: this disturbance is left out, which neither grows
    nor decays. Its speed is not: it grows where the torque that the motor needs falls with the speed.

    A turn of the first angle of the basis maps them by a matrix that is periodic in the second angle: it is found at
    some of these angles and interpolated at those that the motion has, whose product over all turns tells the rate.
    """
    (j, k), (_, q) = problem.basis.tolist()
    first, starts = j + k / problem.ratio, STARTS if problem.shape[1] > 1 else 1
    exact = Fraction(problem.ratio).limit_denominator(LARGEST_TURNS)
    count = Fraction(q * exact.denominator, j * exact.numerator + k * exact.denominator).denominator
    if abs(float(exact) - problem.ratio) > 1e-12 * problem.ratio:
        count = math.ceil(problem.ratio * first / q)
    flows, steps = _first_order(problem, flow, points)
    result, angles = np.empty(len(points)), min(starts, count)
    if problem.shape[1] > 1 and SQUARED * np.max(np.abs(problem.cells[:, 1])) >= count:
        angles = count
    for number in np.unique(steps).tolist():
        batch = max(1, ENTRIES // (2 * angles * number * flows[0].shape[0] ** 2))
        i = np.flatnonzero(steps == number)
        for part in np.array_split(i, math.ceil(len(i) / batch)):
            result[part] = _rates(problem, flows, points[part], number, angles, count)
    return np.asarray(result * first * points[:, -1] / (2.0 * np.pi * count))


def _rates(problem: Torus, flows: Any, points: Floats, steps: int, starts: int, count: int) -> Floats:
    """Logarithms (n,) of the largest multipliers over `count` turns of the first angle, but for that of a mean."""
    maps = turn_maps(problem, flows, points, steps, 2.0 * np.pi * np.arange(starts) / starts)
    while True:
        waves = np.fft.fft(maps, axis=1) / starts
        order = np.fft.fftfreq(starts, 1.0 / starts)
        size = np.abs(waves).max(axis=(0, 2, 3))
        if starts == count or size[np.abs(order) >= max(1, 3 * starts // 8)].max(initial=0.0) <= RESOLVED * size.max():
            break
        if 2 * starts < count:
            between = turn_maps(problem, flows, points, steps, 2.0 * np.pi * (np.arange(starts) + 0.5) / starts)
            maps, starts = np.stack([maps, between], axis=2).reshape(len(maps), -1, *maps.shape[2:]), 2 * starts
        else:
            starts = count
            maps = turn_maps(problem, flows, points, steps, 2.0 * np.pi * np.arange(starts) / starts)
    (j, k), (_, q) = problem.basis.tolist()
    advance = 2.0 * np.pi * q / (problem.ratio * j + k)
    flat, logarithm = waves.reshape(len(points), starts, -1), np.zeros(len(points))
    along, batch = maps[:, :0], max(1, ENTRIES // maps[:, 0].size)
    for turns in np.array_split(np.arange(count), math.ceil(count / batch)):
        some = (np.exp(1j * advance * np.outer(turns, order)) @ flat).real
        along = np.concatenate([along, some.reshape(len(points), -1, *maps.shape[2:])], axis=1)
        while along.shape[1] > 1:
            even = along.shape[1] // 2 * 2
            along = np.concatenate([along[:, 1:even:2] @ along[:, :even:2], along[:, even:]], axis=1)
            largest = np.abs(along).max(axis=(2, 3), keepdims=True)
            along, logarithm = along / largest, logarithm + np.log(largest).sum(axis=(1, 2, 3))
    values = np.linalg.eigvals(along[:, 0])
    if flows[-1] == "mean":
        apart = np.abs(values * np.exp(np.minimum(logarithm, 700.0))[:, None] - 1.0)
        values[np.arange(len(values)), apart.argmin(axis=1)] = 0.0
    return np.asarray(logarithm + np.log(np.maximum(np.abs(values).max(axis=1), 1e-300)))


def _first_order(problem: Torus, flow: Any, points: Floats) -> tuple[Any, Any]:
    """Matrix of the disturbances, that of the torques, the place of each of these, and that left out; steps of a turn.

    Where nothing but the motor's own angle drives it, a motion may begin at any time: the disturbance "shift".
    """
    heavy = np.flatnonzero(np.any(flow.inertia != 0.0, axis=1))
    massless, loaded = np.setdiff1d(np.arange(len(flow.inertia)), heavy), problem.linear.retained
    damping = flow.damping.copy()
    damping[0, 0] += flow.gear_damping
    a, b = first_order_of(flow.inertia, damping, flow.stiffness, heavy, massless, loaded)
    any_mean = flow.loose >= 0 and not np.any(flow.integral)
    forced = not flow.follows or np.any(problem.linear.matrices[0, 1:, :, -1])
    left_out = "none" if not any_mean else "mean" if forced else "shift"
    flows = a, b, np.searchsorted(heavy, loaded), heavy, massless, left_out
    motion = problem.moved(points)
    mean = disturbed(flows, motion, points[:, -1:], lambda samples: samples.mean(axis=-1, keepdims=True))
    fastest = np.abs(np.linalg.eigvals(np.moveaxis(mean[..., 0], 2, 0))).max(axis=1)
    first = float(problem.basis[0] @ np.array([1.0, 1.0 / problem.ratio]))
    stiff = [motion.by_place[i, i] for i in range(len(problem.part.laws))]
    varies = np.max([np.ptp(each, axis=-1) / (np.abs(each).max(axis=-1) + 1e-300) for each in stiff], axis=0)
    phase = PHASE * np.clip(np.maximum(varies, 1e-300) ** -0.25, 1.0, MILD_FACTOR)
    steps = np.maximum(PER_ORDER * highest(problem, points), 2.0 * np.pi * fastest / points[:, -1] / phase) / first
    steps *= FINER[left_out]
    return flows, STEPS[np.searchsorted(STEPS, np.clip(steps, LEAST_STEPS, FINEST))]


def disturbed(flows: Any, motion: Any, w: Floats, measure: Any) -> Floats:
    """Matrices (states, states, points, samples) of disturbances along motions, of a measure of their samples."""
    a, b, column, heavy = flows[:4]
    matrices = np.empty((*a.shape, *measure(motion.by_place[0, 0]).shape))
    matrices[:] = a[..., None, None]
    for some, first, factor in ((motion.by_place, 0, 1.0), (motion.by_rate, len(heavy), 1.0 / w)):
        for (i, j), samples in some.items():
            matrices[:, first + column[j]] -= b[:, i, None, None] * measure(factor * samples)
    return matrices


def at_equal_angles(problem: Torus, flows: Any, points: Floats, angles: Floats, matrices: Floats) -> Floats:
    """Matrices of the disturbances z that are compared at equal angles theta of the motor, without its row and column.

    z' = A z - y' z_w / theta', with the rates y' of the states and the disturbance z_w of the motor's.
    """
    heavy, massless = flows[3:5]
    motor, turned, rates = int(np.searchsorted(heavy, problem.part.loose)), problem.pairs @ angles, []
    even, odd = np.cos(turned), np.sin(turned)
    for z in points:
        turning = 1j * (problem.orders * z[-1])[:, None]
        waves = turning * problem.coordinates(z)
        states = np.concatenate([waves[:, heavy], turning * waves[:, heavy], waves[:, massless]], axis=1).T
        rates.append(states.real @ even - states.imag @ odd)
    along = np.stack(rates, axis=1)
    matrices[:, len(heavy) + motor] -= along / (along[motor] + points[:, -1:])
    return np.delete(np.delete(matrices, motor, axis=0), motor, axis=1)


def product(a: Floats, b: Floats) -> Floats:
    """Products of matrices (n, n, ...): sums over long rows while they are small, which is quicker than one by one."""
    return np.asarray(np.einsum("ij...,jk...->ik...", a, b))


def turn_maps(problem: Torus, flows: Any, points: Floats, steps: int, starts: Floats) -> Floats:
    """Maps (points, starts, states, states) of disturbances over a turn of the first angle from second ones on.

    Magnus's method of order 4: Blanes et al. 2009, The Magnus expansion and some of its applications, Physics Reports
    470, sec. 5; the exponential function to order 8, and what it makes of volumes exactly.
    """
    j, k = problem.basis[0].tolist()
    nodes = np.arange(steps)[:, None] + 0.5 + np.array([-1.0, 1.0]) * math.sqrt(3.0) / 6.0
    first = nodes.ravel() * 2.0 * np.pi / steps
    sampled, w, turn = at_crossings(problem, first, starts), points[:, -1:], j + k / problem.ratio
    matrices = disturbed(flows, sampled.moved(points), w, lambda samples: samples)
    if flows[-1] == "shift":
        matrices = at_equal_angles(problem, flows, points, sampled.angles, matrices)
    n, count = len(matrices), len(starts)
    matrices = matrices.reshape(n, n, -1, len(first))
    scale = np.repeat(2.0 * np.pi / steps / (points[:, -1] * turn), count)
    maps, batch = np.empty((len(points) * count, n, n)), max(1, BATCH_ENTRIES // (n * n * len(first)))
    for i in np.array_split(np.arange(len(maps)), math.ceil(len(maps) / batch)):
        maps[i] = through(matrices[:, :, i] * scale[i, None])
    return maps.reshape(len(points), count, n, n)


def through(matrices: Floats) -> Floats:
    """Maps (m, n, n) over all steps from the matrices (n, n, m, 2 steps) at their nodes, times the step."""
    one, two = matrices[..., ::2], matrices[..., 1::2]
    x = 0.5 * (one + two) + math.sqrt(3.0) / 12.0 * (product(two, one) - product(one, two))
    n = len(x)
    unit, mean = np.eye(n)[..., None, None], np.trace(x) / n
    x = (x - mean * unit) * 0.5
    square = product(x, x)
    cube = product(square, x)
    high = product(cube, unit / 720.0 + x / 5040.0 + square / 40320.0)
    maps = unit + x + 0.5 * square + product(cube, unit / 6.0 + x / 24.0 + square / 120.0 + high)
    maps = product(maps, maps)
    while maps.shape[-1] > 1:
        left = product(maps[..., 1::2], maps[..., : maps.shape[-1] - 1 : 2])
        maps = left if maps.shape[-1] % 2 == 0 else np.concatenate([left, maps[..., -1:]], axis=-1)
    return np.moveaxis(maps[..., 0] * np.exp(mean.sum(axis=1)), 2, 0)


def at_crossings(problem: Torus, first: Floats, starts: Floats) -> Torus:
    """The problem with samples at first angles (n,) of the basis, on ways that begin at second angles (m,) [rad]."""
    (j, k), (_, q) = problem.basis.tolist()
    slow = (starts[:, None] / q + first / (problem.ratio * j + k)).ravel()
    angles = np.array([(np.tile(first, len(starts)) - k * slow) / j, slow])
    cells, group = np.unique(problem.cells[:, 1], return_inverse=True)
    ways = np.exp(1j * np.outer(starts, cells))
    along = np.exp(1j / (j + k / problem.ratio) * np.outer(problem.orders, first))
    sampled = problem._replace(
        turned=problem.line_pairs @ angles, slow=slow, memory={}, angles=angles,
        crossing=(np.concatenate([ways.real, -ways.imag], axis=1), along, [group == i for i in range(len(cells))]),
    )  # fmt: skip
    return sampled._replace(still_error=sampled.error(0.0))
