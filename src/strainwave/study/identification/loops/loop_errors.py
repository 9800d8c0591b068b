"""Scatter of a loop's unknowns: coloured residuals, reversals read with noise, errors that cycles repeat.

The residual of a loop is coloured within a branch, which `restricted` knows. Two errors it does not see.
The torsion at which a branch begins is read off noisy samples, and shifts what the element does on the whole branch.
And what a law does not describe, or a quantised axis rounds, comes again in every cycle of the same amplitude: cycles
then tell less than their number says, by the correlation of their residuals at the same torsion.
"""

import math

import numpy as np

from ....results import Floats
from .loop_model import torque
from .loop_path import Loop
from .loop_solve import Solution
from .restricted import Scatter, restricted

BINS = 24  # of the torsion's range, over which residuals of two cycles are compared
ALIKE = 0.02  # of the range: branches that begin as close together do the same
SURE = 2.0  # standard deviations from which on a correlation is one
LEAST_TOLD = ("start", "kappa", "torsion_offset", "half_gap", "yield_twist", "K")  # first left out of dependent columns
UNTOLD = 1e3  # times its value: standard deviation of an unknown that was left out
RANK = 1e-9
BOUND = 1e6  # degrees of freedom of what stands at a bound


def scatter(loop: Loop, fit: Solution) -> Scatter:
    """Scatter of the unknowns of a fit; 0 for those that stand at a bound."""
    told = np.sum(fit.jacobian**2, axis=0) > 0.0
    told &= ~np.isin(fit.shape.names(), ["half_gap", "kappa"]) | (fit.p > 0.0)
    bound, names = ~told, np.array(fit.shape.names())
    for name in LEAST_TOLD:
        if not _apart(fit.jacobian[:, told]):
            told &= names != name
    J = fit.jacobian[:, told]
    found = restricted(J, fit.residual)
    covariance = found.covariance * repetition(loop, fit.residual) + _of_begins(loop, fit, J)
    whole, freedom = np.zeros((len(told), len(told))), BOUND * np.ones(len(told))
    whole[np.diag_indices(len(told))] = np.where(bound, 0.0, (UNTOLD * fit.p) ** 2)
    whole[np.ix_(told, told)], freedom[told] = covariance, found.freedom
    return Scatter(whole, freedom, found.phi)


def _apart(J: Floats) -> bool:
    """Whether the samples tell the columns (n, p) apart."""
    singular = np.linalg.svd(J / np.linalg.norm(J, axis=0), compute_uv=False)
    return bool(singular[-1] > RANK * singular[0])


def _of_begins(loop: Loop, fit: Solution, J: Floats) -> Floats:
    """Covariance (p, p) that the noise of the torsion at the reversals gives."""
    changes = np.linalg.solve(J.T @ J, shifts_of_begins(loop, fit, J))
    return np.asarray(changes @ changes.T)


def shifts_of_begins(loop: Loop, fit: Solution, J: Floats) -> Floats:
    """Products (p, branches) of columns (n, p) with what a standard deviation of each reversal changes."""
    if not fit.shape.n or loop.torsion_noise == 0.0:
        return np.zeros((J.shape[1], 1))
    p = fit.p.copy()
    spring = fit.shape._replace(n=0, free_beta=False)
    kept = [fit.shape.names().index(name) for name in spring.names()]
    both, alone = (torque(s, q, loop.path, fit.torsion).slope for s, q in ((fit.shape, p), (spring, p[kept])))
    shift = fit.weight * (both - alone)
    pulls = np.array(
        [J[mine].T @ shift[mine] for mine in (loop.path.branch == j for j in range(1, len(loop.path.begin)))]
    )
    return np.asarray(pulls.T * loop.begin_noise[1:])


def repetition(loop: Loop, residual: Floats) -> float:
    """Factor (at least 1) by which the variance grows because cycles of one amplitude repeat their residuals."""
    path, low, wide = loop.path, float(np.min(loop.torsion)), float(np.ptp(loop.torsion))
    place = np.minimum((BINS * (loop.torsion - low) / wide).astype(int), BINS - 1)
    means = np.full((len(path.begin), BINS), np.nan)
    for j in range(1, len(means)):
        mine = path.branch == j
        count = np.bincount(place[mine], minlength=BINS)
        sums = np.bincount(place[mine], residual[mine], minlength=BINS)
        means[j, count > 0] = sums[count > 0] / count[count > 0]
    products, squares, pairs, alike = 0.0, 0.0, 0, np.ones(len(means))
    for j in range(1, len(means)):
        for k in range(j + 1, len(means)):
            close = abs(path.begin[j] - path.begin[k]) < ALIKE * wide
            both = np.isfinite(means[j]) & np.isfinite(means[k])
            if path.direction[j] == path.direction[k] and close and np.any(both):
                a, b = means[j, both], means[k, both]
                products, squares = products + float(a @ b), squares + 0.5 * float(a @ a + b @ b)
                pairs += int(np.count_nonzero(both))
                alike[j] += 1.0
                alike[k] += 1.0
    if squares == 0.0:
        return 1.0
    same = products / squares
    return 1.0 + same * float(np.mean(alike[1:]) - 1.0) if same > SURE / math.sqrt(pairs) else 1.0
