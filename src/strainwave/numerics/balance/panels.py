"""Samples of a periodic motion that end at its kinks, so that Fourier integrals are exact for laws with breakpoints.

A torque with corners, sampled at equal steps, leaves in the balance equations a kink wherever a sample passes a
corner: false folds, and steps of a continuation as short as these kinks are near. Here the period is cut where the
motion crosses breakpoints, or turns where a law has memory, and every piece is integrated by Gauss's rule: the samples
move with the motion, and the equations are as smooth as the integrals are.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...compile.jit import kernel_as, routine, run
from ...law import breakpoints_of, torsion
from ...protocols import lacking
from ...results import Floats
from ..addressed import corner_distances, system_by_address
from ..roots import FA, FB, SHARE, A, B, narrow, next_place
from .fourier import synthesis

PLACES, WEIGHTS = np.polynomial.legendre.leggauss(16)
PHASE = 6.0  # of the highest harmonic along a panel [rad]: products of four harmonics are integrated to 1e-10
LOOKED = 12  # places a harmonic at which crossings are looked for
SEVERAL = 100  # runs in NumPy, a second of them at most, before they are compiled
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
    places = LOOKED * (y.shape[1] // 2 + 1)
    there, turns = y @ synthesis(y.shape[1] // 2, places), float(turns)
    kinks = len(distances(system, np.zeros(1), there[:, :1]))
    found, count = np.empty(kinks * places), 0
    if kinks and (lacking(system, "_fields") or lacking(system, "kinks")):  # compiled code does not know them
        count = crossings(system, turns, y, there, found)
    elif kinks:
        known = system_by_address(system, len(y), kinks=kinks)
        count = run(crossings, known, turns, y, there, found, after=SEVERAL)
    return cut(np.sort(found[:count]), longest)


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


def _crossings_loops(system: Any, turns: float, y: Any, there: Any, found: Any) -> int:
    count, states, places = 0, there.shape[0], there.shape[1]
    state, d, bracket = np.empty(states), np.empty((3, len(found) // places)), np.empty(5)
    for i in range(places + 1):
        for j in range(states):
            state[j] = there[j, i % places]
        corner_distances(system, turns * 2.0 * math.pi * (i % places) / places, state, d[0])
        for k in range(d.shape[1]):
            if i > 0 and (d[0, k] < 0.0) != (d[1, k] < 0.0):
                low, high = 2.0 * math.pi * (i - 1) / places, 2.0 * math.pi * i / places
                bracket[A], bracket[FA], bracket[B], bracket[FB], bracket[SHARE] = low, d[1, k], high, d[0, k], 0.5
                while abs(bracket[B] - bracket[A]) > CLOSE and bracket[FA] != 0.0:
                    psi = next_place(bracket, 0.5 * CLOSE)
                    _state_at(y, psi, state)
                    corner_distances(system, turns * psi, state, d[2])
                    narrow(bracket, psi, d[2, k])
                found[count] = bracket[A] % (2.0 * math.pi)
                count += 1
        d[1] = d[0]
    return count


@routine
def _state_at(y: Any, psi: float, state: Any) -> None:
    h, cosine, sine, c, s = y.shape[1] // 2, math.cos(psi), math.sin(psi), 1.0, 0.0
    for j in range(len(state)):
        state[j] = y[j, 0]
    for k in range(1, h + 1):
        c, s = c * cosine - s * sine, s * cosine + c * sine
        for j in range(len(state)):
            state[j] += c * y[j, k] + s * y[j, h + k]


@kernel_as(_crossings_loops)
def crossings(system: Any, turns: float, y: Floats, there: Floats, found: Floats) -> int:
    """Write the places [rad] where distances of a motion change sign, and return their number.

    `there` are its states (states, places) at equal steps; `found` has room for kinks times places. In NumPy all are
    found at once.
    """
    places = there.shape[1]
    grid = 2.0 * np.pi * np.arange(places + 1) / places
    values = distances(system, turns * grid[:-1], there)
    values = np.concatenate([values, values[:, :1]], axis=1)
    kink, at = np.nonzero((values[:, 1:] < 0.0) != (values[:, :-1] < 0.0))
    if len(at):
        which, h = np.arange(len(at)), y.shape[1] // 2

        def of(psi: Floats) -> Floats:
            return np.asarray(distances(system, turns * psi, y @ Samples(psi, psi).basis(h))[kink, which])

        found[: len(at)] = false_position(of, grid[at], grid[at + 1], values[kink, at], values[kink, at + 1])
    return len(at)


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
