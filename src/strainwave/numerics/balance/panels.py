"""Samples of a periodic motion that end at its kinks, so that Fourier integrals are exact for laws with breakpoints.

A torque with corners, sampled at equal steps, leaves in the balance equations a kink wherever a sample passes a
corner: false folds, and steps of a continuation as short as these kinks are near. Here the period is cut where the
motion crosses breakpoints, or turns where a law has memory, and every piece is integrated by Gauss's rule: the samples
move with the motion, and the equations are as smooth as the integrals are.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...law import breakpoints_of, torsion
from ...protocols import lacking
from ...results import Floats
from .fourier import synthesis

PLACES, WEIGHTS = np.polynomial.legendre.leggauss(16)
PHASE = 6.0  # of the highest harmonic along a panel [rad]: products of four harmonics are integrated to 1e-10
LOOKED = 12  # places a harmonic at which crossings are looked for
TRIES, CLOSE = 20, 1e-11  # steps towards a crossing, and how near [rad]; the integrals err by the square of it


class Samples(NamedTuple):
    """Places psi (n,) [rad] of a period with their weights (n,), which add up to 1."""

    psi: Floats
    weights: Floats

    def basis(self, harmonics: int) -> Floats:
        """Table (2H+1, n): mean, cosines and sines at the samples."""
        turning = np.broadcast_to(np.exp(1j * self.psi), (harmonics, len(self.psi)))
        waves = np.cumprod(turning, axis=0)
        return np.concatenate([np.ones((1, len(self.psi))), waves.real, waves.imag])

    def analysis(self, basis: Floats) -> Floats:
        """Table (n, 2H+1) that turns samples into coefficients in blocks."""
        table = 2.0 * self.weights * basis
        table[0] *= 0.5
        return np.asarray(table.T)


def distances(system: Any, angles: Floats, y: Floats) -> Floats:
    """Distances (kinks, ...) from all corners of the laws in the states y (states, ...) at base angles [rad].

    A system tells them by `kinks(phase, y)`: what vanishes at a corner, the torsion less a breakpoint or, of a law with
    memory, a rate or an internal state. Else it has `breakpoints` of its torsion; one without kinks has none.
    """
    if not lacking(system, "kinks"):
        found = system.kinks(angles, tuple(y))
    else:
        u = torsion(system, angles, tuple(y))
        found = [u - b for b in breakpoints_of(system)]
    return np.array([np.broadcast_to(d, y.shape[1:]) for d in found], float)


def samples_between(system: Any, y: Floats, turns: float) -> Samples:
    """Samples of a period of a motion, states with coefficients y (states, 2H+1), cut at its kinks."""
    first, width = pieces(system, y, turns, PHASE / (y.shape[1] // 2))
    psi = first[:, None] + 0.5 * width[:, None] * (1.0 + PLACES)
    return Samples(psi.ravel(), (width[:, None] * WEIGHTS / (4.0 * np.pi)).ravel())


def pieces(system: Any, y: Floats, turns: float, longest: float) -> tuple[Floats, Floats]:
    """Starts and lengths (n,) [rad] of pieces of a period of a motion, none above `longest`, cut at its kinks."""
    return cut(crossings(system, float(turns), y), longest)


def cut(cuts: Floats, longest: float) -> tuple[Floats, Floats]:
    """Starts and lengths (n,) [rad] of pieces of a period, none above `longest`, between `cuts` in order."""
    ends = np.concatenate([cuts, [cuts[0] + 2.0 * np.pi]]) if len(cuts) else np.array([0.0, 2.0 * np.pi])
    lengths = np.diff(ends)
    parts = np.maximum(1, np.ceil(lengths / longest)).astype(int)
    width = np.repeat(lengths / parts, parts)
    number = np.arange(len(width)) - np.repeat(np.cumsum(parts) - parts, parts)  # of a part in its piece
    return np.repeat(ends[:-1], parts) + width * number, width


def panels(system: Any, y: Floats, turns: float, wide: int) -> tuple[Floats, Floats, Floats]:
    """As `FirstOrder.places` for states with coefficients y (states, 2H+1), cut at the kinks of the motion."""
    h = y.shape[1] // 2
    samples = samples_between(system, y, turns)
    basis = samples.basis(wide * h)
    own = np.concatenate([basis[: h + 1], basis[wide * h + 1 : (wide + 1) * h + 1]])
    return turns * samples.psi, own, samples.analysis(basis)


def crossings(system: Any, turns: float, y: Floats) -> Floats:
    """Places (n,) [rad], in order, where distances from corners change sign along a motion."""
    h = y.shape[1] // 2
    places = LOOKED * (h + 1)
    grid = 2.0 * np.pi * np.arange(places + 1) / places
    values = distances(system, turns * grid[:-1], y @ synthesis(h, places))
    values = np.concatenate([values, values[:, :1]], axis=1)
    kink, at = np.nonzero((values[:, 1:] < 0.0) != (values[:, :-1] < 0.0))
    which = np.arange(len(at))

    def of(psi: Floats) -> Floats:
        return np.asarray(distances(system, turns * psi, y @ Samples(psi, psi).basis(h))[kink, which])

    return np.sort(false_position(of, grid[at], grid[at + 1], values[kink, at], values[kink, at + 1]))


def false_position(of: Callable[[Floats], Floats], low: Floats, high: Floats, below: Any, above: Any) -> Floats:
    """Places (n,) [rad] in [0, 2 pi) between `low` and `high` where functions change sign (Illinois).

    `of` gives all of them at such places; `below` and `above` are their values at the ends.
    """
    side, psi = np.zeros(len(low)), low
    for _ in range(TRIES):
        before, psi = psi, (low * above - high * below) / (above - below)
        here = of(psi)
        same = here * below > 0.0
        above = np.where(same & (side > 0.0), 0.5 * above, above)
        below = np.where(~same & (side < 0.0), 0.5 * below, below)
        low, below = np.where(same, psi, low), np.where(same, here, below)
        high, above = np.where(same, high, psi), np.where(same, above, here)
        side = np.where(same, 1.0, -1.0)
        if np.all(np.abs(psi - before) < CLOSE) or not np.all(above != below):
            break
    return np.asarray(psi % (2.0 * np.pi))
