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
from typing import Any, NamedTuple

import numpy as np

from ...compile.jit import as_python
from ...results import Floats
from ...tree import with_leaf
from ..balance.first_order import FirstOrder, first_order
from ..balance.fourier import orders
from ..balance.guess import drive, linear_response, one_harmonic
from ..balance.half_wave import is_half_wave, mirrored, odd_problem
from ..balance.harmonics import highest_order
from ..balance.second_order import CONSTANT, LINE, STRENGTH, SecondOrder, second_order
from ..labels import CLOSED, END, LOST
from .trace import LEAST_PIECE, solve, walk

ALIKE = 2e-3  # relative distance of the coefficients of one orbit, found with different numbers of harmonics
NEAR = 0.02  # relative distance to an orbit from which Newton's method goes to it
ENOUGH = 15  # harmonics of a search, or three times the highest order
WEAKEST, STRONGEST, STRONG = 1e-3, 1e3, 30.0  # factors of the strength: first, last, and last at least
MOST_TORQUE = 5.0  # constant torque at the end of its curve, of the largest torque of the law on the orbits known
BIAS = 0.02  # constant torque that breaks a symmetry, of the largest drive
MOST_FACTOR = 10.0  # of one line alone, at the ends of its curve
ROUNDING = 1e-9  # of the largest line: less is none
LEAST_LINE = 1e-3  # of the largest line: one below it is no way to other orbits
FASTEST = 2.0  # factor of the frequency, upwards and downwards
STEP, COARSE = 0.1, 0.2  # of an orbit's size and of the units of the parameters; for a general system
FINE = 0.02  # the same along the frequency
MOST_POINTS = 2500  # of all curves of a search
MOST_GENERAL, MOST_KINKED = 600, 150  # and for a general system, in NumPy; with breakpoints
WORK = 2e7  # of a general system: points times the square of the unknowns
LONGEST = 500  # points of one curve
SIZES = np.geomspace(1e-4, 1.0, 200)  # amplitudes at which the law is asked, of the largest that the damping allows
LEAST = 1e-4  # damping that counts at least, of critical
MANY = 10**9  # runs as Python in a process that has compiled nothing: what is looked for beside must not make it


def same(a: Floats, b: Floats, tolerance: float = 1e-5) -> bool:
    """Whether two points of a branch at one value of the parameter are the same."""
    return float(np.linalg.norm(a - b)) <= tolerance * float(np.linalg.norm(b[:-1]))


def new_orbits(problem: Any, some: list[Floats], known: list[Floats]) -> list[Floats]:
    """Orbits to which guesses lead, without the known ones; a guess next to a known orbit leads to it."""
    found: list[Floats] = []
    for guess in some:
        if any(same(guess, other, NEAR) for other in known):
            continue
        point = solve(problem, guess)
        if point is not None and not any(same(point, other) for other in [*known, *found]):
            found.append(point)
    return found


def alike(a: Floats, b: Floats, turns: int) -> bool:
    """Whether two tables are those of one orbit; over several turns, of copies shifted by whole turns of the base."""
    n = min(len(a), len(b))
    if turns > 1:
        a, b = (np.hypot(c[1::2], c[2::2]) for c in (a, b))
        n //= 2
    size = max(float(np.linalg.norm(a)), float(np.linalg.norm(b)))
    rest = np.hypot(np.linalg.norm(a[n:]), np.linalg.norm(b[n:]))
    return bool(np.hypot(np.linalg.norm(a[:n] - b[:n]), rest) <= ALIKE * size)


class Found(NamedTuple):
    """Tables of orbits, and whether every curve from them was followed to its end."""

    tables: list[Floats]
    whole: bool


def connected(problem: Any, value: float, known: list[Floats]) -> Found:
    """The orbits at a frequency that the curves connect with each other and with known ones, and these."""
    with as_python(MANY, compiled=True):
        if isinstance(problem, FirstOrder):
            few = _with_few_harmonics(problem, value)
            some = [z for z in (few.fitted(problem.table(point), value) for point in known) if z is not None]
            return _Search(few, value, STRONG).explored(few, some)
        size = _driven(problem)
        highest = 1 + problem.stride * int(np.max(np.flatnonzero(size > ROUNDING * size.max()), initial=0))
        most = max(ENOUGH * problem.turns, 3 * highest)
        system = with_leaf(problem.system, problem.omega_leaf, value)
        full = second_order(system, problem.omega_leaf, problem.omega_leaf, most, problem.turns)
        some = [z for z in (full.fitted(problem.table(point), value) for point in known) if z is not None]
        search = _Search(full, value, _strongest(full, value), is_half_wave(full))
        if search.half_wave:
            search.left += LONGEST
            some += search.from_weak(_biased(full))
        return search.explored(odd_problem(full) or full, some)


def _biased(problem: SecondOrder) -> SecondOrder:
    """The problem with a little constant torque: its curves turn into orbits without the symmetry where these begin."""
    tau = problem.tau.copy()
    tau[0] = BIAS * float(_driven(problem).max())
    return problem._replace(tau=tau)


def _with_few_harmonics(problem: FirstOrder, value: float) -> FirstOrder:
    """The problem at a frequency with the harmonics of a search: their cube is what its points cost."""
    system, leaf = with_leaf(problem.system, problem.omega_leaf, value), problem.omega_leaf
    few = max(ENOUGH, math.ceil(3 * highest_order(system) * problem.turns))
    if few >= problem.highest():
        return problem._replace(system=system, omega=value)
    return first_order(system, leaf, leaf, few, problem.turns)._replace(sizes=problem.sizes)


def _driven(problem: SecondOrder) -> Floats:
    """Amplitudes [N*m] of what drives the harmonics of a problem."""
    w = problem.system.omega / problem.turns * orders(len(problem.tau) // 2, problem.stride)
    size: Floats = np.abs(drive(problem.system, w, problem.tau, problem.error))
    return size


def _strongest(problem: SecondOrder, value: float) -> float:
    """Factor of the strength at which every line alone has passed its last fold, by one harmonic."""
    w, size = value / problem.turns * orders(len(problem.tau) // 2), _driven(problem)
    lines = np.flatnonzero(size > LEAST_LINE * size.max())
    if not len(lines):
        return STRONG
    mass, size = problem.system.J * (w * w)[lines, None], size[lines, None]
    loss = np.maximum(problem.system.B * w[lines, None], LEAST * mass)
    sizes = float(np.max(size / loss)) * SIZES
    _, stiffness = one_harmonic(problem.system.law, float(problem.tau[0]), sizes)
    pull = np.hypot(stiffness - mass, loss) * sizes
    folds = np.where(pull[:, 1:] < pull[:, :-1], pull[:, :-1] / size, 0.0)
    return min(STRONGEST, max(STRONG, 1.5 * float(np.max(folds))))


def _ways(problem: Any) -> list[int]:
    """Virtual leaves along which orbits are connected: of several lines each one has its own strength too."""
    if isinstance(problem, FirstOrder):
        return [problem.omega_leaf, STRENGTH]
    size = _driven(problem)
    lines = 1 + np.flatnonzero(size > LEAST_LINE * size.max())
    weakest_first = lines[np.argsort(size[lines - 1])].tolist()
    return [CONSTANT, STRENGTH, problem.omega_leaf, *(LINE - k for k in weakest_first if len(lines) > 1)]


class _Search:
    """A search at one frequency: the problem, and how many points its curves may still have."""

    def __init__(self, problem: Any, value: float, strongest: float, half_wave: bool = False) -> None:
        self.problem, self.value, self.half_wave = problem, value, half_wave
        self.strengths = math.log(WEAKEST), math.log(strongest)
        self.left = MOST_POINTS
        if isinstance(problem, FirstOrder):
            self.left = MOST_KINKED if problem.kinked else min(MOST_GENERAL, int(WORK / len(problem.tau) ** 2))
        self.whole = True

    def explored(self, first: Any, known: list[Floats]) -> Found:
        """Tables of all orbits that the curves connect; `first` may have the odd harmonics alone."""
        full = self.problem
        found = new_orbits(full, self.from_weak(first), [])
        ways = _ways(full)
        done: dict[int, list[Floats]] = {leaf: [] for leaf in ways} | {STRENGTH: list(found)}
        found += new_orbits(full, known, found)
        while True:
            some = ((leaf, z) for leaf in ways for z in found if not any(same(z, o, 1e-3) for o in done[leaf]))
            leaf, orbit = next(some, (STRENGTH, None))
            if orbit is None or self.left < LEAST_PIECE:
                return Found([full.table(z) for z in found], self.whole and orbit is None)
            met = self.with_mirrored(self.met(full, leaf, orbit, found))
            done[leaf] += [*self.with_mirrored([orbit]), *met]
            found += new_orbits(full, met, found)

    def with_mirrored(self, some: list[Floats]) -> list[Floats]:
        """Orbits, and minus the same half a turn later where these are orbits too."""
        return [*some, *(mirrored(z) for z in some if self.half_wave)]

    def from_weak(self, problem: Any) -> list[Floats]:
        """Guesses for orbits: those on the curve along the strength from the weak response of a problem."""
        weak = linear_response(problem, self.value)
        n = len(problem.error) if isinstance(problem, FirstOrder) else len(weak) - 1
        weak[:-1][np.arange(len(weak) - 1) % n > 0] *= WEAKEST
        met = self.met(problem, STRENGTH, weak, [], weak=True)
        return [z for z in (self.problem.fitted(problem.table(point), self.value) for point in met) if z is not None]

    def bounds(self, leaf: int, found: list[Floats]) -> tuple[float, float, float, float]:
        """First and last value of a parameter, its unit, and the length of a step."""
        if leaf == STRENGTH:
            return *self.strengths, 2.0, COARSE if isinstance(self.problem, FirstOrder) else STEP
        if leaf == self.problem.omega_leaf:
            return self.value / FASTEST, self.value * FASTEST, self.value, FINE
        if leaf == CONSTANT:
            torques = [float(_driven(self.problem).max())]
            torques += [np.abs(self.problem.system.law.torque(z[:-1] @ self.problem.synthesis)).max() for z in found]
            most = MOST_TORQUE * float(np.max(torques))
            return -most, most, most / MOST_TORQUE, STEP
        return -MOST_FACTOR, MOST_FACTOR, 2.0, STEP

    def met(self, problem: Any, leaf: int, start: Floats, known: list[Floats], weak: bool = False) -> list[Floats]:
        """Orbits of the system itself on the curve from a weak response, or both ways from an orbit."""
        low, high, unit, step = self.bounds(leaf, known)
        own = self.value if leaf == problem.omega_leaf else 0.0
        first = np.append(start[:-1], low if weak else own)
        found: list[Floats] = []
        for direction in (1.0,) if weak else (1.0, -1.0):
            most = min(LONGEST, self.left)
            if most < LEAST_PIECE:
                break
            way = walk(problem._replace(leaf=leaf), first, direction, low, high, step, unit, most=most)
            self.left -= len(way.points)
            self.whole = self.whole and way.outcome in (END, CLOSED)
            side = way.points[:, -1] - own
            for i in np.flatnonzero((side[1:] >= 0.0) != (side[:-1] >= 0.0)):
                share = side[i] / (side[i] - side[i + 1])
                guess = way.points[i] + share * (way.points[i + 1] - way.points[i])
                found.append(np.append(guess[:-1], self.value))
            if way.outcome in (CLOSED, LOST):
                break
        return new_orbits(problem, found, [])
