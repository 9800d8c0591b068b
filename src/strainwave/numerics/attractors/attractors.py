"""Attractors among settled lanes: periodic orbits by `find_orbit`, and which lanes ended on which."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np

from ...base.protocols import System, omega_of
from ...base.results import Floats, Integers, Orbit, SolveError
from ..balanced_orbit import find_orbit
from ..integration.methods import Dopri5
from ..integration.simulate import simulate
from ..shooting import coefficients_of
from .settle import Settled

END_GAP = 1e-3  # of a state's size: lanes as near as this to an attractor's point have ended on it
SAME_TURN = 1e-6  # of a state's size: two turns that agree so well are one
MOST_SETTLED = 200  # settled motions that are looked at one by one
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
        True if that is below 1.
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
        exact = np.isfinite(self.multiplier)
        kind = (
            f"{'stable' if self.stable else 'unstable'}, multiplier {self.multiplier:.4f}" if exact else "by eye only"
        )
        x, v = self.points[0, :2]
        return f"period {self.period}, amplitude {self.amplitude:.5g}, {kind}, through ({x:.5g}, {v:.5g})"


def recognised(system: System, ends: Settled) -> tuple[Integers, tuple[Attractor, ...]]:
    """Label (lanes,) of the attractor on which every lane ended (-3: on none), and the attractors, largest first."""
    label = np.full(len(ends.period), NOT_RECOGNISED, np.int64)
    motions: list[Attractor] = []
    for motion, scale, lanes in islice(motions_among(system, ends, np.arange(len(label))), MOST_SETTLED):
        attractor = _attractor(system, ends, int(lanes[0]), motion, scale)
        index = next((i for i, former in enumerate(motions) if _same(former, attractor, scale)), len(motions))
        if index == len(motions):
            motions.append(attractor)
        label[lanes] = index
    order = np.argsort([-np.count_nonzero(label == i) for i in range(len(motions))], kind="stable")
    rank = np.empty(len(motions) + 1, np.int64)
    rank[order], rank[-1] = np.arange(len(motions)), NOT_RECOGNISED
    return rank[np.maximum(label, -1)], tuple(motions[i] for i in order)


def distance(points: Floats, states: Floats, scale: Floats) -> Floats:
    """Distance (lanes,) of states (states, lanes) to the nearest of the points (period, states), in state sizes."""
    gaps = np.abs(points[:, :, None] - states[None]) / scale[None, :, None]
    return np.asarray(np.min(np.max(gaps, axis=1), axis=0))


def _same(old: Attractor, seen: Attractor, scale: Floats) -> bool:
    return old.period == seen.period and bool(distance(old.points, seen.points[:1].T, scale)[0] < 10.0 * END_GAP)


def _attractor(system: Any, ends: Settled, lane: int, motion: "Motion", scale: Floats) -> Attractor:
    """Attractor on which a settled lane is, with its motion and the sizes (states,) of its states."""
    turns, y = motion.turns, motion.samples
    orbit = _orbit(system, y, turns, scale)
    if orbit is None:
        low, high = float(ends.lowest[lane]), float(ends.highest[lane])
        return Attractor(turns, low, high, y[:, ::PER_TURN].T, np.nan, False)
    points = orbit.state(np.asarray(2.0 * np.pi * np.arange(turns + 1), float))
    fewer = fewest(points, turns, scale, SAME_TURN)
    if fewer < turns:
        orbit = _orbit(system, y[:, : fewer * PER_TURN], fewer, scale) or orbit
    x = orbit.state(np.asarray(np.linspace(0.0, 2.0 * np.pi * fewer, 4096 * fewer), float))[0]
    low, high, size = float(np.min(x)), float(np.max(x)), float(np.max(np.abs(orbit.multipliers)))
    return Attractor(fewer, low, high, points[:, :fewer].T, size, orbit.stable)


def fewest(points: Floats, turns: int, scale: Floats, tolerance: float) -> int:
    """Smallest divisor of the turns after which the first of the points (states, turns + 1) comes back."""
    for n in range(1, turns):
        if turns % n == 0 and np.all(np.abs(points[:, n] - points[:, 0]) < tolerance * scale):
            return n
    return turns


def _orbit(system: System, y: Floats, turns: int, scale: Floats) -> Orbit | None:
    """Periodic orbit near the samples (states, samples) of one period; None where it is not found there."""
    try:
        orbit = find_orbit(system, guess=coefficients_of(y, 31 * turns), period=turns)
    except (ValueError, TypeError, SolveError):  # a system without periodic orbits that `find_orbit` can look for
        return None
    gap = np.abs(orbit.state(0.0) - y[:, 0]) / scale if orbit.status.found else np.array([np.inf])
    return orbit if float(np.max(gap)) < 20.0 * END_GAP else None


@dataclass(frozen=True, eq=False)
class Motion:
    """A settled motion: its shortest period in turns and samples (states, 64 turns) over it, from base phase 0 on."""

    omega: float
    turns: int
    samples: Floats


def motions_among(system: System, ends: Settled, lanes: Integers) -> Iterator[tuple[Motion, Floats, Integers]]:
    """The different motions on which lanes of one frequency have settled, the shortest periods first.

    With each the sizes (states,) of its states, and the lanes that are on it.
    """
    waiting = lanes[ends.period[lanes] > 0]
    waiting = waiting[np.argsort(ends.period[waiting], kind="stable")]
    omega = float(omega_of(system))
    while len(waiting):
        turns, state = int(ends.period[waiting[0]]), ends.state[:, waiting[0]]
        times = 2.0 * np.pi / omega * np.arange(turns * PER_TURN + 1) / PER_TURN
        method = Dopri5(rtol=1e-10, atol=1e-14 * float(np.max(np.abs(state)) + 1e-12))
        run = simulate(system, state, times, method=method)
        scale = np.maximum(np.max(np.abs(run.y), axis=1), 1e-300)
        turns = fewest(run.y[:, ::PER_TURN], turns, scale, END_GAP)
        motion = Motion(omega, turns, run.y[:, : turns * PER_TURN])
        reached = distance(motion.samples[:, ::PER_TURN].T, ends.state[:, waiting], scale) < END_GAP
        reached[0] = True
        yield motion, scale, waiting[reached]
        waiting = waiting[~reached]
