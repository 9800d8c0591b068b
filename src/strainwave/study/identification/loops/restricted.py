"""Scatter of least squares with residuals of first-order colour, whose colour is estimated with the fit allowed for.

Unknowns take the slow part of the residual with them, so that its own correlation is too small: the sandwich, which
goes by it, is too narrow where colour is strong or samples are few. The restricted likelihood of r = phi r_before + e
(Patterson & Thompson 1971, Biometrika 58(3), 545-554; Cheang & Reinsel 2000, J. Am. Stat. Assoc. 95, 1173-1184, for
autoregressions) counts what the fit took. The larger variance of the two is kept for each unknown: the sandwich sees
residuals that grow with the motion.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.signal import lfilter

from ....results import Floats
from ..intervals import spread

COLOURS = np.linspace(-0.9, 0.98, 20)  # phi tried
NONE = 1e-300


class Scatter(NamedTuple):
    """Covariance (p, p) of the unknowns, degrees of freedom (p,) of its diagonal, and the colour phi."""

    covariance: Floats
    freedom: Floats
    phi: float


def restricted(jacobian: Floats, residual: Floats) -> Scatter:
    """Scatter of least squares with the jacobian (n, p) and the residual (n,): coloured, and perhaps uneven."""
    n, p = jacobian.shape
    sizes = np.linalg.norm(jacobian, axis=0)
    basis, triangle = np.linalg.qr(jacobian / sizes)
    phi = _colour(basis, residual)
    innovation = _innovations(_white(basis, phi), _white(residual, phi))
    # V is the covariance of the residual: basis' V basis by the filter that takes white noise to it
    passed = lfilter([1.0], [1.0, -phi], basis[::-1], axis=0)[::-1]
    passed[0] /= math.sqrt(1.0 - phi * phi)
    back = np.linalg.inv(triangle) / sizes[:, None]
    power = float(innovation @ innovation) / (n - p)
    covariance = power * back @ (passed.T @ passed) @ back.T
    own = spread(jacobian, residual)
    wider = np.sqrt(np.maximum(np.diag(own.covariance) / np.maximum(np.diag(covariance), NONE), 1.0))
    freedom = max((n - p) * (1.0 - abs(phi)) / (1.0 + abs(phi)), 1.0)
    return Scatter(covariance * np.outer(wider, wider), np.full(p, freedom), phi)


def _white(values: Floats, phi: float) -> Floats:
    """Take the colour phi out of columns (n, ...); the first row keeps its scatter."""
    found = np.array(values)
    found[1:] -= phi * values[:-1]
    found[0] *= math.sqrt(1.0 - phi * phi)
    return found


def _innovations(basis: Floats, residual: Floats) -> Floats:
    Q = np.linalg.qr(basis)[0]
    return np.asarray(residual - Q @ (Q.T @ residual))


def _colour(basis: Floats, residual: Floats) -> float:
    """Colour phi of largest restricted likelihood."""
    n, p = basis.shape

    def cost(phi: float) -> float:
        Q, triangle = np.linalg.qr(_white(basis, phi))
        white = _white(residual, phi)
        miss = white - Q @ (Q.T @ white)
        size = 2.0 * float(np.sum(np.log(np.abs(np.diag(triangle)) + NONE)))
        power = math.log(float(miss @ miss) + NONE)
        return float((n - p) * power - math.log(1.0 - phi * phi) + size)

    best = int(np.argmin([cost(phi) for phi in COLOURS.tolist()]))
    ends = COLOURS[max(best - 1, 0)], COLOURS[min(best + 1, len(COLOURS) - 1)]
    found = minimize_scalar(cost, bounds=ends, method="bounded", options={"xatol": 1e-4})
    return float(found.x)


def derived_freedom(rates: Floats, covariance: Floats, freedom: Any) -> Floats:
    """Degrees of freedom (m,) of numbers with the derivatives rates (m, p) by the unknowns: Satterthwaite's rule."""
    shares = rates**2 * np.diag(covariance)
    total = np.maximum(np.sum(shares**2 / freedom, axis=1), NONE)
    return np.asarray(np.maximum(np.sum(shares, axis=1) ** 2 / total, 1.0))
