"""Motions of a condensed problem: what its unknowns mean in all coordinates and states, and a first guess of them.

A condensed problem (`Condensed`) balances the torques of a system's laws in the few coordinates that these see; its
unknowns are Fourier coefficients of them, block by block. All else in the system is linear: `condense` eliminates it.
Its table s (points, harmonics, n, n + 1) has dynamic stiffnesses, and forces in the last column.
"""

from typing import Any

import numpy as np

from ....base.results import Floats
from ....compile.tree import leaf_of
from ..first_order import FirstOrder
from ..fourier import analysis, distances, synthesis
from ..linear_part import carried
from ..rates import base_speed
from ..truncation import few_of, share_of
from .pencil import condense, eliminated, to_complex, to_real

ANGLE = 1e-3  # least size [rad] of the motor's deviation, for differences


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
    pencil, loose, force = problem.pencil, problem.pencil.loose, s.shape[2]
    given = pencil.forces[loose, 0].real + pencil.per_speed[loose] * base_speed(problem, points[:, -1])
    torque = given - p[:, 0].real @ pencil.matrices[2, loose]
    if not problem.part.follows:
        return np.asarray(torque)
    seen = len(problem.blocks)
    gear = s[:, :, 0, force] - np.sum(s[:, :, 0, :seen] * p[:, :, :seen], axis=2)
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
        motor = len(laws)  # the block after those of the laws
        remainder = s[0, motor, n] - s[0, motor, :motor] @ p[0, :motor]
        p[0, motor] = remainder / holds if (holds := s[0, motor, motor]) else 0.0
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
