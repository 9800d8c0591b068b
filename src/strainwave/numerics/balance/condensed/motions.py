"""The motions of a condensed problem in all coordinates and states, from the unknowns and back to a first guess."""

from typing import Any

import numpy as np

from ....results import Floats
from ....tree import leaf_of
from ..first_order import FirstOrder
from ..fourier import analysis, synthesis
from ..one_harmonic import carried
from ..panels import distances
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


def coordinates(problem: Any, points: Floats) -> Any:
    """All coordinates (points, h+1, n), complex, the first of them x."""
    blocks = problem.series(points).copy()
    blocks[:, 0] += errors(problem, blocks)
    s = np.empty((len(points), *problem.stiff[0].shape), complex)
    condense(problem.pencil, base_speed(problem, points[:, -1]), 1.0, s, np.empty_like(s))
    return eliminated(problem.pencil, s, np.moveaxis(to_complex(blocks), 1, 2))


def states(problem: Any, points: Floats) -> Floats:
    """Coefficients (points, states, 2h+1) of all states, in blocks, at every `every`-th harmonic."""
    p, part = coordinates(problem, points), problem.part
    w = problem.pencil.rate * base_speed(problem, points[:, -1])[:, None] * np.arange(p.shape[1])
    waves = p @ part.values.T + 1j * w[..., None] * (p @ part.rates.T)
    return to_real(np.moveaxis(waves, 2, 1))


def linear_response(problem: Any, value: float) -> Floats:
    """Guess (coefficients, parameter): the response of the laws' tangents where they carry the mean torques."""
    count, size = problem.blocks.shape
    omega = float(base_speed(problem, np.asarray(value)))
    s = np.empty(problem.stiff[0].shape, complex)
    condense(problem.pencil, omega, 1.0, s, np.empty_like(s))
    n, laws = problem.pencil.matrices.shape[1], problem.part.laws
    means = [carried(law, float(s[0, i, n].real)) for i, law in enumerate(laws)]
    matrix = s[:, :count, :count].copy()
    force = s[:, :count, n] - matrix[:, :, 0] * to_complex(problem.gear.error)[:, None]
    for i, law in enumerate(laws):
        matrix[:, i, i] += float(law.stiffness(means[i]))
    matrix[:, 0, 0] += 1j * problem.gear_damping * problem.pencil.rate * omega * np.arange(size // 2 + 1)
    p = np.zeros((size // 2 + 1, count), complex)
    for k in range(1, len(p)):
        p[k] = np.linalg.lstsq(matrix[k], force[k], rcond=1e-14)[0]
    p[0, : len(laws)] = means
    if count > len(laws) and problem.pencil.loose < 0:
        rest = s[0, -1 + count, n] - s[0, count - 1, : len(laws)] @ p[0, : len(laws)]
        holds = s[0, count - 1, count - 1]
        p[0, -1] = rest / holds if holds else 0.0
    return np.append(to_real(p.T).ravel(), value)


def left_out(problem: Any, points: Floats) -> tuple[Floats, Floats]:
    """Parameter at some points of a curve, and the shares (values, 1 + blocks) left out there, of x and blocks."""
    few = points[few_of(points)]
    blocks, h = problem.series(few), problem.harmonics()
    most, count = 3 * h + 8, len(problem.blocks)
    samples = 3 * most
    n, k = problem.pencil.matrices.shape[1], np.arange(h + 1, most + 1)
    s = np.empty((len(few), most + 1, n, n + 1), complex)
    omega = base_speed(problem, few[:, -1])
    quiet = problem.pencil._replace(forces=np.zeros((n, most + 1), complex), per_speed=np.zeros(n))
    with np.errstate(all="ignore"):
        condense(quiet, omega, 1.0, s, np.empty_like(s))
        matrix, force = s[:, :, :count, :count].copy(), np.zeros((len(few), most + 1, count), complex)
        for i, law in enumerate(problem.part.laws):
            u = blocks[:, i] @ synthesis(h, samples)
            force[..., i] = -to_complex((law.torque(u) + 0.0 * u) @ analysis(most, samples))
            matrix[..., i, i] += np.mean(law.stiffness(u) + 0.0 * u, axis=1)[:, None]
        matrix[..., 0, 0] += 1j * problem.gear_damping * problem.pencil.rate * omega[:, None] * np.arange(most + 1)
        p = np.zeros_like(force)
        p[:, k] = np.linalg.solve(matrix[:, k], force[:, k, :, None])[..., 0]
        x = eliminated(quiet, s, p) @ problem.part.values[0]
    known = np.linalg.norm(blocks, axis=2)
    known = np.maximum(known, 1e-6 * np.max(known, axis=0))
    own = np.linalg.norm(problem.displacements(few), axis=1)
    return few[:, -1], np.column_stack(
        [share_of(np.linalg.norm(x, axis=1), own), share_of(np.linalg.norm(p, axis=1), known)]
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


def spread(series: Floats, every: int) -> Floats:
    """Series (..., 2h+1) in blocks with harmonics `every`, 2 `every`, ..., as one with all (..., 2 every h + 1)."""
    if every == 1:
        return series
    h = series.shape[-1] // 2
    out = np.zeros((*series.shape[:-1], 2 * every * h + 1))
    out[..., 0] = series[..., 0]
    out[..., every : every * h + 1 : every] = series[..., 1 : h + 1]
    out[..., every * h + every :: every] = series[..., h + 1 :]
    return out


def gathered(series: Floats, every: int, h: int) -> Floats:
    """The first h of the harmonics `every`, 2 `every`, ... of series (..., 2H+1) in blocks, cut or filled up."""
    top = series.shape[-1] // 2
    out, n = np.zeros((*series.shape[:-1], 2 * h + 1)), min(h, top // every)
    out[..., 0] = series[..., 0]
    out[..., 1 : n + 1] = series[..., every : every * n + 1 : every]
    out[..., h + 1 : h + n + 1] = series[..., top + every : top + every * n + 1 : every]
    return out
