"""Least squares of a scan: mean, drift and lines of one direction of rotation, and what two directions say together."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...results import Floats

WORST_CONDITION = 1e6

Part = tuple[Floats, Floats]  # cosine and sine (2,) of a line, and their covariance (2, 2) over that of a sample


class Direction(NamedTuple):
    """Samples of one direction of rotation, angles ascending."""

    angle: Floats
    error: Floats

    @property
    def turns(self) -> float:
        """Turns scanned, the last sample's share included."""
        n = len(self.angle)
        return float(self.angle[-1] - self.angle[0]) * n / (n - 1) / (2.0 * np.pi)


class Fit(NamedTuple):
    """Least squares of one direction: (mean, drift, cos, sin, ...), the matrix (X'X)^-1, residual, and X's basis."""

    values: Floats
    inverse: Floats
    residual: Floats
    drift: bool
    basis: Floats

    def line(self, i: int) -> Part:
        """Line i: its cosine and sine, and their block of (X'X)^-1."""
        start = 1 + self.drift + 2 * i
        place = slice(start, start + 2)
        return self.values[place], self.inverse[place, place]

    def one_more(self, angle: Floats, order: int) -> Part | None:
        """The same of a line that would be fitted beside the others; None where the samples do not tell it apart."""
        X = np.column_stack([np.cos(order * angle), np.sin(order * angle)])
        X -= self.basis @ (self.basis.T @ X)
        gram = X.T @ X
        if not np.linalg.eigvalsh(gram)[0] > len(angle) / WORST_CONDITION:
            return None
        inverse = np.linalg.inv(gram)
        return inverse @ (X.T @ self.residual), inverse


def fit_lines(run: Direction, orders: Sequence[int], drift: bool) -> Fit:
    """Fit a mean, a drift if wanted, and the lines of these orders to one direction.

    Raises
    ------
    ValueError
        If there are too few samples, or they do not tell the orders apart.
    """
    theta, e = run
    unknowns = 1 + drift + 2 * len(orders)
    if len(theta) <= unknowns:
        raise ValueError(
            f"{len(theta)} samples are given for {unknowns} unknowns (mean, drift and two a line); measure more samples"
        )
    half = 0.5 * (theta[-1] - theta[0])
    columns = [np.ones_like(theta)] + [(theta - theta[0] - half) / half] * drift
    columns += [part for k in orders for part in (np.cos(k * theta), np.sin(k * theta))]
    X = np.column_stack(columns)
    u, s, vt = np.linalg.svd(X, full_matrices=False)
    if s[0] > WORST_CONDITION * s[-1]:
        raise ValueError(
            f"the samples do not tell the orders {', '.join(map(str, orders))} apart (gaps in the angle?); "
            "measure evenly over whole turns, or fit fewer orders"
        )
    values = vt.T @ ((u.T @ e) / s)
    return Fit(values, (vt.T / s**2) @ vt, e - X @ values, drift, u)


def together(parts: Sequence[Part]) -> Part:
    """A line as the mean over the directions."""
    values, covariances = (np.array(both) for both in zip(*parts, strict=True))
    return np.mean(values, axis=0), np.sum(covariances, axis=0) / len(parts) ** 2


def squared_amplitude(parts: Sequence[Part], samples: int) -> float:
    """Squared amplitude [rad^2] whose ratio to the noise is that of a line's cosine and sine.

    Evenly over whole turns it is the squared amplitude itself. Otherwise the mean, the drift and the other lines take a
    share of what a line gives, and cosine and sine are not equally sure: v' C^-1 v with the covariance C = (X'X)^-1.
    """
    values, covariance = together(parts)
    return float(2.0 / samples * values @ np.linalg.solve(covariance, values))
