"""Attractors recognised among settled lanes: periodic orbits by `find_orbit`, and which lanes ended on which."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...protocols import omega_of
from ...results import Floats, Orbit, SolveError
from ..integration.methods import Dopri5
from ..integration.simulate import simulate
from ..orbits.find_orbit import find_orbit
from .settle import Settled

NEAR = 1e-3  # of a state's size: lanes as near as this to an attractor's point have ended on it
SAME = 1e-6  # of a state's size: two turns that agree so well are one
MOST = 200  # settled motions that are looked at one by one
PER_TURN = 64  # samples of the motion from which an orbit's coefficients are guessed
NOT_RECOGNISED = -3


@dataclass(frozen=True, eq=False)
class Attractor:
    """A periodic motion on which initial states end.

    Attributes
    ----------
    period : int
        Turns of the base angle after which it repeats.
    lowest, highest : float
        Extremes of the first state [rad].
    points : (period, states) array
        States at base phase 0, turn after turn.
    multiplier : float
        Largest modulus of its Floquet multipliers; nan where `find_orbit` did not find it.
    stable : bool
        Whether that is below 1.
    """

    period: int
    lowest: float
    highest: float
    points: Floats
    multiplier: float
    stable: bool

    @property
    def peak(self) -> float:
        """Largest absolute value of the first state [rad]."""
        return max(abs(self.lowest), abs(self.highest))

    @property
    def amplitude(self) -> float:
        """Half the distance between its extremes [rad]."""
        return 0.5 * (self.highest - self.lowest)

    def __str__(self) -> str:
        known = np.isfinite(self.multiplier)
        kind = (
            f"{'stable' if self.stable else 'unstable'}, multiplier {self.multiplier:.4f}" if known else "by eye only"
        )
        x, v = self.points[0, :2]
        return f"period {self.period}, amplitude {self.amplitude:.5g}, {kind}, through ({x:.5g}, {v:.5g})"


def recognised(system: Any, ends: Settled) -> tuple[NDArray[np.int64], tuple[Attractor, ...]]:
    """Label (lanes,) of the attractor on which every lane ended (-3: on none), and the attractors, largest first."""
    label = np.full(len(ends.period), NOT_RECOGNISED, np.int64)
    found: list[Attractor] = []
    waiting = np.flatnonzero(ends.period > 0)
    waiting = waiting[np.argsort(ends.period[waiting], kind="stable")]
    for _ in range(MOST):
        if not len(waiting):
            break
        lane = waiting[0]
        seen, scale = _attractor(system, ends, int(lane))
        place = next((i for i, known in enumerate(found) if _same(known, seen, scale)), len(found))
        if place == len(found):
            found.append(seen)
        near = distance(found[place].points, ends.state[:, waiting], scale) < NEAR
        near[0] = True
        label[waiting[near]] = place
        waiting = waiting[~near]
    order = np.argsort([-np.count_nonzero(label == i) for i in range(len(found))], kind="stable")
    rank = np.empty(len(found) + 1, np.int64)
    rank[order], rank[-1] = np.arange(len(found)), NOT_RECOGNISED
    return rank[np.maximum(label, -1)], tuple(found[i] for i in order)


def distance(points: Floats, states: Floats, scale: Floats) -> Floats:
    """Distance (lanes,) of states (states, lanes) to the nearest of the points (period, states), in state sizes."""
    gaps = np.abs(points[:, :, None] - states[None]) / scale[None, :, None]
    return np.asarray(np.min(np.max(gaps, axis=1), axis=0))


def _same(known: Attractor, seen: Attractor, scale: Floats) -> bool:
    return known.period == seen.period and bool(distance(known.points, seen.points[:1].T, scale)[0] < 10.0 * NEAR)


def _attractor(system: Any, ends: Settled, lane: int) -> tuple[Attractor, Floats]:
    """Attractor on which a settled lane is, and the sizes (states,) of its states."""
    turns, state = int(ends.period[lane]), ends.state[:, lane]
    turn = 2.0 * np.pi / float(omega_of(system))
    grid = np.linspace(0.0, turns * turn, turns * PER_TURN + 1)
    run = simulate(system, state, grid, method=Dopri5(rtol=1e-10, atol=1e-14 * float(np.max(np.abs(state)) + 1e-12)))
    y = run.y
    scale = np.maximum(np.max(np.abs(y), axis=1), 1e-300)
    turns = fewest(y[:, ::PER_TURN], turns, scale, NEAR)
    y = y[:, : turns * PER_TURN]
    orbit = _orbit(system, y, turns, scale)
    if orbit is None:
        low, high = float(ends.lowest[lane]), float(ends.highest[lane])
        return Attractor(turns, low, high, y[:, ::PER_TURN].T, np.nan, False), scale
    points = orbit.state(np.asarray(2.0 * np.pi * np.arange(turns + 1), float))
    fewer = fewest(points, turns, scale, SAME)
    if fewer < turns:
        orbit = _orbit(system, y[:, : fewer * PER_TURN], fewer, scale) or orbit
    x = orbit.state(np.asarray(np.linspace(0.0, 2.0 * np.pi * fewer, 4096 * fewer), float))[0]
    low, high, size = float(np.min(x)), float(np.max(x)), float(np.max(np.abs(orbit.multipliers)))
    return Attractor(fewer, low, high, points[:, :fewer].T, size, orbit.stable), scale


def fewest(points: Floats, turns: int, scale: Floats, near: float) -> int:
    """Smallest divisor of the turns after which the first of the points (states, turns + 1) comes back."""
    for n in range(1, turns):
        if turns % n == 0 and np.all(np.abs(points[:, n] - points[:, 0]) < near * scale):
            return n
    return turns


def _orbit(system: Any, y: Floats, turns: int, scale: Floats) -> Orbit | None:
    """Periodic orbit near the samples (states, samples) of one period; None where it is not found there."""
    samples = y.shape[1]
    spectrum = np.fft.rfft(y, axis=1).T * (2.0 / samples)
    h = min(len(spectrum) - 1, 31 * turns)
    series = np.empty((2 * h + 1, len(y)))
    series[0], series[1::2], series[2::2] = spectrum[0].real / 2.0, spectrum[1 : h + 1].real, -spectrum[1 : h + 1].imag
    try:
        orbit = find_orbit(system, guess=series, period=turns)
    except (ValueError, TypeError, SolveError):  # a system without periodic orbits that `find_orbit` can look for
        return None
    gap = np.abs(orbit.state(0.0) - y[:, 0]) / scale if orbit.status.found else np.array([np.inf])
    return orbit if float(np.max(gap)) < 20.0 * NEAR else None
