"""Covariance of a least-squares fit with coloured residuals, and intervals by Student's t."""

from typing import NamedTuple

import numpy as np
from scipy.stats import t as student

from ...results import Floats


class Interval(NamedTuple):
    """Ends of an interval."""

    low: float
    high: float


def interval(value: float, deviation: float, freedom: float, level: float = 0.95) -> Interval:
    """Interval of a value by Student's t."""
    share = float(student.ppf(0.5 + 0.5 * level, freedom)) * deviation
    return Interval(value - share, value + share)


def sandwich(J: Floats, r: Floats) -> Floats:
    """Covariance (p, p) of a least-squares fit with the Jacobian (n, p) and the residual (n,), which may be coloured.

    Quadratic-spectral kernel with the bandwidth of Andrews 1991, Econometrica 59(3), 817-858.
    """
    n, p = J.shape
    scores = J * r[:, None]
    bread = np.linalg.inv(J.T @ J)
    power = np.sum(scores * scores, axis=0) + 1e-300
    rho = np.clip(np.sum(scores[1:] * scores[:-1], axis=0) / power, -0.97, 0.97)
    width = 1.3221 * (float(np.mean(4.0 * rho**2 / (1.0 - rho) ** 4)) * n) ** 0.2
    meat = scores.T @ scores
    for k in range(1, int(min(n - 1, 8.0 * width + 1.0)) + 1):
        x = 1.2 * np.pi * k / max(width, 1e-9)
        weight = 3.0 / x**2 * (np.sin(x) / x - np.cos(x))
        both = scores[k:].T @ scores[:-k]
        meat += weight * (both + both.T)
    return np.asarray(bread @ meat @ bread * n / (n - p))
