"""Orbits that coexist at one base frequency: where they may, and those known, from one number of harmonics to the next.

A vibration of harmonic k and amplitude a on top of an orbit needs |kappa(a) - J (k w)^2 + i B k w| a = D, with the
equivalent stiffness kappa of the law (describing function): a second one needs an amplitude at which
kappa(a) is about J (k w)^2 and a drive D that bears the damping there. Where that may be, `connected` looks for them.

Nayfeh & Mook 1979, Nonlinear Oscillations, sec. 4.1.1; Krack & Gross 2019, sec. 2.3 (one harmonic).
"""

from typing import Any

import numpy as np

from ...law import breakpoints_of
from ...results import Floats
from ..balance.first_order import FirstOrder
from ..balance.fourier import orders
from ..balance.guess import drive, one_harmonic
from .connected import ENOUGH, alike, connected, fitted, highest_harmonic, table_of

SIZES = np.geomspace(1e-4, 1.0, 40)  # amplitudes at which the law is asked, of the largest that the damping allows
LEAST = 1e-4  # damping that counts at least, of critical
SHARED = 0.03  # of the largest drive: what other harmonics of a larger motion may have
MOST = 1.4  # factor of J (k w)^2 for what one harmonic leaves out
MARGIN = 2.0  # factor of a drive that is too small for a second orbit


class Coexisting:
    """Orbits known at some base frequencies, carried from one number of harmonics to the next.

    `known` maps a frequency to tables of coefficients (2H+1, states), of the torsion for a `SecondOrder` problem;
    `unfinished` are frequencies at which a search was cut short.
    """

    def __init__(self) -> None:
        self.known: dict[float, list[Floats]] = {}
        self.searched: set[float] = set()
        self.unfinished: set[float] = set()
        self.apart: list[Floats] = []

    def guesses(self, problem: Any, value: float, passed: list[Floats]) -> list[Floats]:
        """Guesses at a frequency for orbits beside those passed there; searched for once, where there may be any."""
        if value not in self.searched and (not passed or may_coexist(problem, passed[0])):
            self.searched.add(value)
            found = connected(problem, value, passed[:1])
            self.known.setdefault(value, []).extend(found.tables)
            if not found.whole:
                self.unfinished.add(value)
        tables = [table for table in self.known.get(value, []) if not any(table is other for other in self.apart)]
        some = [fitted(problem, table, value) for table in tables]
        return [point for point in some if point is not None]

    def note(self, problem: Any, points: list[Floats]) -> None:
        """Keep orbits that were found by the way."""
        for point in points:
            self.known.setdefault(float(point[-1]), []).append(table_of(problem, point))

    def give_up(self, problem: Any, points: list[Floats]) -> None:
        """Look no more for a way to orbits to which none was found with harmonics enough; they remain known."""
        if problem.turns * ENOUGH > highest_harmonic(problem):
            return
        for point in points:
            table = table_of(problem, point)
            self.apart += [other for other in self.known[float(point[-1])] if alike(table, other, problem.turns)]


def may_coexist(problem: Any, point: Floats) -> bool:
    """Whether other orbits may exist at the frequency of a known one, from what one harmonic on top of it allows."""
    if isinstance(problem, FirstOrder):
        return not is_linear(problem, point)
    system, value = problem.system, float(point[-1])
    n = len(problem.tau)
    h = n // 2
    w = value / problem.turns * orders(h, problem.stride)
    mass, loss = system.J * w * w, np.maximum(system.B * w, LEAST * system.J * w * w)
    u = point[:n] @ problem.synthesis
    stiffness = system.law.stiffness(u) + 0.0 * u
    tangent = float(stiffness.mean())
    moving = u - point[0]
    square = float(moving @ moving)
    secant = float((system.law.torque(u) @ moving) / square) if square > 0.0 else tangent
    size = np.hypot(point[1 : h + 1], point[h + 1 : n])
    driven = np.maximum(np.abs(drive(system, w, problem.tau, problem.error)), np.hypot(secant - mass, loss) * size)
    # A larger motion drives harmonics that this one does not, above all where it reaches a corner of the law.
    driven = np.maximum(driven, (1.0 if breakpoints_of(system.law) else SHARED) * driven.max())
    top = MARGIN * float(np.max(driven / loss))
    if not top > 0.0:
        return False
    sizes = top * SIZES
    _, kappa = one_harmonic(system.law, float(problem.tau[0]), sizes)
    bear = np.searchsorted(sizes, MARGIN * driven / loss, side="right")  # how many of the amplitudes the drive bears
    low, high = (of.accumulate(kappa)[bear - 1] for of in (np.minimum, np.maximum))
    wide = (bear > 0) & (high - low > loss)
    for shift in (0.0, tangent - kappa[0]):  # alone, and on top of the orbit
        if np.any(wide & (low + shift < MOST * mass) & (high + shift > mass / MOST)):
            return True
    # a vibration that the varying stiffness of the orbit itself keeps up
    off = np.hypot(tangent - mass, loss)
    if off.min() > 2.0 * MARGIN * float(np.ptp(stiffness)):
        return False
    waves = np.abs(np.fft.rfft(stiffness)) * (2.0 / len(u))
    twice = (2 * orders(h, problem.stride)) // problem.stride
    pump = np.where(twice < len(waves), waves[np.minimum(twice, len(waves) - 1)], 0.0)
    return bool(np.any(off <= 0.5 * MARGIN * pump))


def is_linear(problem: FirstOrder, point: Floats) -> bool:
    """Whether the rates of a system do not depend on its states otherwise than linearly, near an orbit and far off."""
    a, b = (np.empty((len(problem.tau), len(problem.tau))) for _ in range(2))
    slope = np.empty(len(problem.tau))
    problem.linearise(point, None, a, slope)
    other = 3.0 * point
    other[-1] = point[-1]
    problem.linearise(other, None, b, slope)
    return bool(np.max(np.abs(a - b)) <= 1e-6 * np.max(np.abs(a)))
