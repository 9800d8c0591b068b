"""Orbits that coexist at one base frequency: where they may, and those known, from one number of harmonics to the next.

A vibration of harmonic k and amplitude a on top of an orbit needs |kappa(a) - J (k w)^2 + i B k w| a = D, with the
equivalent stiffness kappa of the law (describing function): a second one needs an amplitude at which
kappa(a) is about J (k w)^2 and a drive D that bears the damping there. Where that may be, `connected` looks for them.

Nayfeh & Mook 1979, Nonlinear Oscillations, sec. 4.1.1; Krack & Gross 2019, sec. 2.3 (one harmonic).
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...law import breakpoints_of
from ...results import Floats
from ..balance.first_order import FirstOrder
from ..balance.fourier import orders
from ..balance.guess import drive, one_harmonic
from ..labels import END
from .connected import ENOUGH, alike, connected
from .trace import Trace

SIZES = np.geomspace(1e-5, 1.0, 50)  # amplitudes at which the law is asked, of the largest that the damping allows
LEAST = 1e-4  # damping that counts at least, of critical
SHARED = 0.03  # of the largest drive: what other harmonics of a larger motion may have
MOST = 1.4  # factor of J (k w)^2 for what one harmonic leaves out
MARGIN = 2.0  # factor of a drive that is too small for a second orbit


class Coexisting:
    """Orbits known at some base frequencies, carried from one number of harmonics to the next.

    `known` maps a frequency to tables of coefficients (2H+1, states), of the torsion for a `SecondOrder` problem;
    `alone` are frequencies at which one orbit is all there can be, `unfinished` those at which a search was cut short.
    """

    def __init__(self) -> None:
        self.known: dict[float, list[Floats]] = {}
        self.searched: set[float] = set()
        self.alone: set[float] = set()
        self.begun = False
        self.unfinished: set[float] = set()
        self.apart: list[Floats] = []

    def begin(self, problem: Any, curve: Trace) -> bool:
        """Begin to search, if it has not begun and other orbits may exist at an end of a curve; whether it begins."""
        if self.begun or not len(curve.points):
            return False
        self.begun = True
        ends = curve.points[[0, -1]]
        may = may_coexist(problem, ends)
        self.alone = {*ends[~may, -1].tolist()} - {*ends[may, -1].tolist()}
        return bool(may.any()) or curve.outcome != END

    def guesses(self, problem: Any, value: float, passed: list[Floats]) -> list[Floats]:
        """Guesses at a frequency for orbits beside those passed there; searched for once, where there may be any."""
        if self.begun and value not in self.searched and value not in self.alone:
            self.searched.add(value)
            found = connected(problem, value, passed[:1])
            self.known.setdefault(value, []).extend(found.tables)
            if not found.whole:
                self.unfinished.add(value)
        tables = [table for table in self.known.get(value, []) if not any(table is other for other in self.apart)]
        some = [problem.fitted(table, value) for table in tables]
        return [point for point in some if point is not None]

    def note(self, problem: Any, points: list[Floats]) -> None:
        """Keep orbits that were found by the way."""
        for point in points:
            self.known.setdefault(float(point[-1]), []).append(problem.table(point))

    def give_up(self, problem: Any, points: list[Floats]) -> None:
        """Look no more for a way to orbits to which none was found with harmonics enough; they remain known."""
        if problem.turns * ENOUGH > problem.highest():
            return
        for point in points:
            table = problem.table(point)
            self.apart += [other for other in self.known[float(point[-1])] if alike(table, other, problem.turns)]


def may_coexist(problem: Any, points: Floats) -> NDArray[np.bool_]:
    """Whether other orbits may exist at the frequencies of known ones, from what one harmonic on top of each allows."""
    if isinstance(problem, FirstOrder):
        return np.array([not is_linear(problem, point) for point in points])
    system, n = problem.system, len(problem.tau)
    h = n // 2
    w = points[:, -1:] / problem.turns * orders(h, problem.stride)
    mass = system.J * w * w
    loss = np.maximum(system.B * w, LEAST * mass)
    u = points[:, :n] @ problem.synthesis
    stiffness = system.law.stiffness(u) + 0.0 * u
    tangent = stiffness.mean(axis=1, keepdims=True)
    moving = u - points[:, :1]
    square = np.square(moving).sum(axis=1, keepdims=True)
    work = (system.law.torque(u) * moving).sum(axis=1, keepdims=True)
    secant = np.divide(work, square, out=tangent.copy(), where=square > 0.0)
    size = np.hypot(points[:, 1 : h + 1], points[:, h + 1 : n])
    driven = np.maximum(np.abs(drive(system, w, problem.tau, problem.error)), np.hypot(secant - mass, loss) * size)
    # A larger motion drives harmonics that this one does not, above all where it reaches a corner of the law.
    driven = np.maximum(driven, (1.0 if breakpoints_of(system.law) else SHARED) * driven.max(axis=1, keepdims=True))
    reach = MARGIN * driven / loss
    top = float(reach.max())
    if not top > 0.0:
        return np.zeros(len(points), bool)
    sizes = top * SIZES
    _, kappa = one_harmonic(system.law, float(problem.tau[0]), sizes)
    bear = np.searchsorted(sizes, reach, side="right")  # how many of the amplitudes the drive bears
    low, high = (of.accumulate(kappa)[bear - 1] for of in (np.minimum, np.maximum))
    wide = (bear > 0) & (high - low > loss)
    least, most = mass / MOST, MOST * mass
    above = tangent - kappa[0]  # of an orbit: on top of it the stiffness is that much larger
    may = wide & (((low < most) & (high > least)) | ((low + above < most) & (high + above > least)))
    # a vibration that the varying stiffness of the orbit itself keeps up
    off = np.hypot(tangent - mass, loss)
    if np.any(off < 2.0 * MARGIN * np.ptp(stiffness, axis=1, keepdims=True)):
        waves = np.abs(np.fft.rfft(stiffness)) * (2.0 / u.shape[1])
        twice = (2 * orders(h, problem.stride)) // problem.stride
        inside = twice < waves.shape[1]
        may |= inside & (off <= 0.5 * MARGIN * waves[:, np.where(inside, twice, 0)])
    found: NDArray[np.bool_] = may.any(axis=1)
    return found


def is_linear(problem: FirstOrder, point: Floats) -> bool:
    """Whether the rates of a system do not depend on its states otherwise than linearly, near an orbit and far off."""
    a, b = (np.empty((len(problem.tau), len(problem.tau))) for _ in range(2))
    slope = np.empty(len(problem.tau))
    problem.linearise(point, None, a, slope)
    other = 3.0 * point
    other[-1] = point[-1]
    problem.linearise(other, None, b, slope)
    return bool(np.max(np.abs(a - b)) <= 1e-6 * np.max(np.abs(a)))
