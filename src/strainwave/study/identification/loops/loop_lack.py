"""Lack of fit of a loop: structure along the torsion that the noise of the samples does not give.

What a law misses comes again wherever the loop passes: it is a slow function of the torsion on the way up and on the
way down, the same in every cycle. Cosines over the torsion, for both directions, stand for it. Their coefficients are
judged by the noise beside them, with its colour as it is once they are allowed for, and by the noise with which
reversals are read (Wald's test; Draper & Smith 1998, Applied Regression Analysis, 3rd ed., sec. 2.1).
"""

from typing import NamedTuple

import numpy as np
from scipy.special import fdtrc

from ....results import Floats
from ..lack_of_fit import LackOfFit
from .loop_errors import RANK, scatter, shifts_of_begins
from .loop_path import Loop
from .loop_solve import Solution
from .restricted import Scatter, restricted

WAVES = 8  # cosines for each direction
ROWS = 24  # samples for each of them; below two cosines nothing is tested
LEFT = 1e-3  # of a column: what the unknowns leave of it when they can stand for it
SENSOR = 1e-4  # of the largest torque: errors along the loop that every sensor has


class Structure(NamedTuple):
    """Lack of fit of a loop, and its weighted residual (n,) without the structure that was found."""

    lack: LackOfFit
    noise: Floats


def structure(loop: Loop, fit: Solution) -> Structure | None:
    """Test a fit for structure along the torsion; None where samples are too few."""
    n, J = len(fit.residual), fit.jacobian[:, np.any(fit.jacobian != 0.0, axis=0)]
    own, sizes, _ = np.linalg.svd(J / np.linalg.norm(J, axis=0), full_matrices=False)
    own = own[:, sizes > RANK * sizes[0]]
    # at the corrected torsion, of which the residual tells nothing: the measured one shares its noise
    columns = _waves(loop, fit.torsion) * fit.weight[:, None]
    columns /= np.linalg.norm(columns, axis=0)
    left, sizes, _ = np.linalg.svd(columns - own @ (own.T @ columns), full_matrices=False)
    left = left[:, sizes > LEFT]
    m, freedom = left.shape[1], n - own.shape[1] - left.shape[1]
    if m == 0:
        return None
    c = left.T @ fit.residual
    noise = fit.residual - left @ c
    unit = 1.0 / float(np.median(fit.weight))
    known = restricted(np.column_stack([own, left]), noise)
    pulls = shifts_of_begins(loop, fit, left)
    sensor = n / m * (SENSOR * float(np.max(np.abs(loop.torque - np.mean(loop.torque)))) / unit) ** 2
    V = known.covariance[-m:, -m:] + pulls @ pulls.T + sensor * np.eye(m)
    ratio = float(c @ np.linalg.solve(V, c)) / m
    chance = float(fdtrc(m, float(np.min(known.freedom)), ratio))
    pure, missed = unit * float(noise @ noise / freedom) ** 0.5, unit * float(c @ c / n) ** 0.5
    return Structure(LackOfFit(pure, missed, ratio, chance, "loop"), noise)


def wider(loop: Loop, fit: Solution, found: Structure | None) -> Scatter:
    """Scatter of the unknowns; where structure was found at least that of the noise times the ratio."""
    known = scatter(loop, fit)
    if found is None or not found.lack.found:
        return known
    alone = np.diag(scatter(loop, fit._replace(residual=found.noise)).covariance) * found.lack.ratio
    own = np.diag(known.covariance)
    grown = np.sqrt(np.maximum(np.divide(alone, own, out=np.ones(len(own)), where=own > 0.0), 1.0))
    return known._replace(covariance=known.covariance * np.outer(grown, grown))


def _waves(loop: Loop, x: Floats) -> Floats:
    """Cosines (n, 2 WAVES or fewer) over the torsion x (n,), on the way up and on the way down."""
    count = min(WAVES, len(x) // (2 * ROWS))
    place = (x - np.min(x)) / np.ptp(x)
    waves = np.cos(np.pi * np.outer(place, np.arange(count if count > 1 else 0)))
    up = (loop.path.direction[loop.path.branch] > 0.0)[:, None]
    return np.hstack([waves * up, waves * ~up])
