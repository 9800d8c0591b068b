"""Orbits at one base frequency that curves in three parameters connect with a known one.

All that alternates in the excitation is multiplied by a factor, from next to nothing on; a constant torque is added to
it, up to where it governs; the frequency goes down and up. What is met where the factor is 1, the constant torque 0 and
the frequency the first is an orbit of the system. The curves bend over at folds and come back, through all orbits that
they connect; from each new orbit all are followed again, until there is no new one or a number of points is reached.
Orbits of a system with half-wave symmetry may lack it: one more curve along the factor, with a little constant torque,
turns into them where they begin on the others (imperfect bifurcation).

Krack & Gross 2019, Harmonic Balance for Nonlinear Vibration Problems, sec. 4 (continuation).
"""

import math
from typing import NamedTuple

import numpy as np

from ...base.branch_labels import CLOSED, END, LOST
from ...base.protocols import Balance
from ...base.results import Floats
from ..balance.harmonics import mirrored
from ..balance.linear_part import CONSTANT, STRENGTH, driven_lines
from .trace import LEAST_PIECE, solve, trace

SAME_ORBIT = 2e-3  # relative distance of the coefficients of one orbit, found with different numbers of harmonics
NEAR_ORBIT = 0.02  # relative distance to an orbit from which Newton's method goes to it
LEAST_STRENGTH = 1e-3  # first factor of the strength
MOST_TORQUE = 5.0  # constant torque at the end of its curve, of the largest torque of the law on the orbits known
MOST_FACTOR = 10.0  # of one line alone, at the ends of its curve
FREQUENCY_FACTOR = 2.0  # factor of the frequency, upwards and downwards
FREQUENCY_STEP = 0.02  # steps along the frequency, of an orbit's size and of the frequency
CURVE_POINTS = 500  # points of one curve


def same(a: Floats, b: Floats, tolerance: float = 1e-5) -> bool:
    """True for two points of a branch at one value of the parameter that are the same."""
    return float(np.linalg.norm(a - b)) <= tolerance * float(np.linalg.norm(b[:-1]))


def new_orbits(problem: Balance, guesses: list[Floats], former: list[Floats]) -> list[Floats]:
    """Orbits to which guesses lead, without the known ones; a guess next to a known orbit leads to it."""
    orbits: list[Floats] = []
    for guess in guesses:
        if any(same(guess, orbit, NEAR_ORBIT) for orbit in former):
            continue
        point = solve(problem, guess)
        if point is not None and not any(same(point, orbit) for orbit in [*former, *orbits]):
            orbits.append(point)
    return orbits


def alike(a: Floats, b: Floats, turns: int) -> bool:
    """True for two tables of one orbit; over several turns, of copies shifted by whole turns of the base."""
    n = min(len(a), len(b))
    if turns > 1:
        a, b = np.hypot(a[1::2], a[2::2]), np.hypot(b[1::2], b[2::2])
        n //= 2
    size = max(float(np.linalg.norm(a)), float(np.linalg.norm(b)))
    tail = np.hypot(np.linalg.norm(a[n:]), np.linalg.norm(b[n:]))
    return bool(np.hypot(np.linalg.norm(a[:n] - b[:n]), tail) <= SAME_ORBIT * size)


class Connected(NamedTuple):
    """Tables of orbits; `complete` if every curve from them was followed to its end."""

    tables: list[Floats]
    complete: bool


def connected(problem: Balance, value: float, starts: list[Floats]) -> Connected:
    """The orbits at a frequency that the curves connect with each other and with `starts`, and these."""
    full = problem.to_search(value)
    some = [z for z in (full.fitted(problem.table(point), value) for point in starts) if z is not None]
    search, biased = _Search(full, value), full.biased()
    if biased is not None:
        search.left += CURVE_POINTS
        some += search.from_weak(biased)
    return search.explored(full.odd() or full, some, mirrors=biased is not None)


class _Search:
    """A search at one frequency: the problem, and how many points its curves may still have."""

    def __init__(self, problem: Balance, value: float) -> None:
        self.problem, self.value = problem, value
        self.strengths = math.log(LEAST_STRENGTH), math.log(problem.strongest())
        self.left, self.step = problem.budget()
        self.complete = True

    def explored(self, first: Balance, former: list[Floats], mirrors: bool) -> Connected:
        """Tables of all orbits that the curves connect; `first` may have the odd harmonics alone.

        With `mirrors` minus an orbit, half a turn later, is one too, from which no curve need be followed.
        """
        full, ways = self.problem, self.problem.ways()
        orbits = new_orbits(full, self.from_weak(first), [])
        followed: dict[int, list[Floats]] = {leaf: [] for leaf in ways} | {STRENGTH: list(orbits)}
        orbits += new_orbits(full, former, orbits)
        while True:
            pairs = ((leaf, z) for leaf in ways for z in orbits if not any(same(z, o, 1e-3) for o in followed[leaf]))
            leaf, orbit = next(pairs, (STRENGTH, None))
            if orbit is None or self.left < LEAST_PIECE:
                return Connected([full.table(z) for z in orbits], self.complete and orbit is None)
            met = [orbit, *self.met(full, leaf, orbit, orbits)]
            met += [mirrored(z) for z in met if mirrors]
            followed[leaf] += met
            orbits += new_orbits(full, met, orbits)

    def from_weak(self, problem: Balance) -> list[Floats]:
        """Guesses for orbits: those on the curve along the strength from the weak response of a problem."""
        weak = problem.linear_response(self.value)
        weak[:-1][np.arange(problem.size()) % (2 * problem.harmonics() + 1) > 0] *= LEAST_STRENGTH
        met = self.met(problem, STRENGTH, weak, [], weak=True)
        return [z for z in (self.problem.fitted(problem.table(point), self.value) for point in met) if z is not None]

    def bounds(self, leaf: int, orbits: list[Floats]) -> tuple[float, float, float, float]:
        """First and last value of a parameter, its unit, and the length of a step."""
        if leaf == STRENGTH:
            return *self.strengths, 2.0, self.step
        if leaf == self.problem.omega_leaf:
            return self.value / FREQUENCY_FACTOR, self.value * FREQUENCY_FACTOR, self.value, FREQUENCY_STEP
        if leaf == CONSTANT:
            torques = [float(driven_lines(self.problem)[2].max())]
            torques += [np.abs(self.problem.system.law.torque(z[:-1] @ self.problem.synthesis)).max() for z in orbits]
            largest = MOST_TORQUE * float(np.max(torques))
            return -largest, largest, largest / MOST_TORQUE, self.step
        return -MOST_FACTOR, MOST_FACTOR, 2.0, self.step

    def met(self, problem: Balance, leaf: int, start: Floats, former: list[Floats], weak: bool = False) -> list[Floats]:
        """Orbits of the system itself on the curve from a weak response, or both ways from an orbit."""
        low, high, unit, step = self.bounds(leaf, former)
        target = self.value if leaf == problem.omega_leaf else 0.0
        first = np.append(start[:-1], low if weak else target)
        guesses: list[Floats] = []
        for direction in (1.0,) if weak else (1.0, -1.0):
            max_points = min(CURVE_POINTS, self.left)
            if max_points < LEAST_PIECE:
                break
            curve = trace(problem._replace(leaf=leaf), first, direction, low, high, step, unit, max_points=max_points)
            self.left -= len(curve.points)
            self.complete = self.complete and curve.outcome in (END, CLOSED)
            side = curve.points[:, -1] - target
            for i in np.flatnonzero((side[1:] >= 0.0) != (side[:-1] >= 0.0)):
                share = side[i] / (side[i] - side[i + 1])
                guess = curve.points[i] + share * (curve.points[i + 1] - curve.points[i])
                guesses.append(np.append(guess[:-1], self.value))
            if curve.outcome in (CLOSED, LOST):
                break
        return new_orbits(problem, guesses, [])
