"""Arcs of steady states of the slow flow: pieces of a curve that are traced from a state on it.

They are followed by pseudo-arclength continuation of (Re z, Im z, omega) in scaled units.

Keller 1977; Krack & Gross 2019, Harmonic Balance for Nonlinear Vibration Problems, sec. 4.2.
"""

import cmath
import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...base.results import Floats
from ...numerics.roots import bracketed_root
from .fixed_points import Flow, is_trivial

LARGEST_STEP, TURN, MOST_POINTS = 0.05, 0.16, 4000  # of an arc: step, turn of its tangent in one [rad], points
TANGENT_DEVIATION = 0.3  # of a step: a point farther from its tangent is on another branch
SAG = 0.15  # of a chord: the arc is not so far from it
AMPLITUDE_CHANGE = 0.5  # of the amplitude: largest change in a step, so that none passes a small one to the other phase
BIRTH_AMPLITUDE = 1e-6  # of the largest amplitude: a branch as small as this begins at a = 0, a steady state too
FLAT_AMPLITUDE = 1e-4  # of it: so near to its beginning, with a speed that stands still, rounding turns a branch around
FEW_STEPS, MANY_STEPS = 8, 40  # steps of Newton's method: where a shorter step helps, and where the curve must be met


@dataclass(frozen=True, eq=False)
class Curve:
    """The curve rates(z, omega) = 0 in the scaled unknowns (Re z/size, Im z/size, omega/width)."""

    flow: Flow
    size: float
    width: float
    _known: dict[bytes, tuple[Floats, Floats]] = field(default_factory=dict, repr=False)

    def split(self, point: Floats) -> tuple[complex, float]:
        """The state z [rad] and the speed omega [rad/s] of a point."""
        return self.size * complex(point[0], point[1]), self.width * float(point[2])

    def join(self, z: complex, omega: float) -> Floats:
        """The point of a state and a speed."""
        return np.array([z.real / self.size, z.imag / self.size, omega / self.width])

    def linear(self, point: Floats) -> tuple[Floats, Floats]:
        """Residual (2,) and its derivative (2, 3) to the scaled unknowns, both over size."""
        key = point.tobytes()
        if key not in self._known:  # points are come back to, for tangents, folds and crests
            z, omega = self.split(point)
            rate, by_z, by_omega = self.flow.at(omega).linearized(z)
            slope = by_omega * self.width / self.size
            matrix = np.column_stack([by_z, [slope.real, slope.imag]])
            self._known[key] = np.array([rate.real, rate.imag]) / self.size, matrix
        return self._known[key]

    def tangent(self, point: Floats, along: Floats) -> Floats:
        """Unit tangent, on the side of `along`; its last entry is det(d rates/d z), zero exactly at a fold."""
        _, matrix = self.linear(point)
        (a, b, c), (d, e, f) = matrix.tolist()
        direction = np.array([b * f - c * e, c * d - a * f, a * e - b * d])
        length = float(np.linalg.norm(direction))
        if not 0.0 < length < math.inf:
            return along
        return direction * (math.copysign(1.0, float(direction @ along)) / length)

    def correct(self, guess: Floats, along: Floats, iterations: int = MANY_STEPS) -> Floats | None:
        """Newton back to the curve in the plane through the guess across `along`; None where it does not converge."""
        point = guess
        for _ in range(iterations):
            if point[2] <= 0.0:
                return None
            residual, matrix = self.linear(point)
            system = np.vstack([matrix, along])
            try:
                step = np.linalg.solve(system, -np.append(residual, along @ (point - guess)))
            except np.linalg.LinAlgError:
                return None
            if not np.all(np.isfinite(step)):
                return None
            point = point + step
            if np.max(np.abs(step)) < 1e-7:  # what is left is of the order of its square
                return np.asarray(point)
        return None


@dataclass(frozen=True, eq=False)
class Arc:
    """A connected piece in the scaled unknowns: points (n, 3), the folds among them, ends inside the range of speeds.

    `born` are ends at a = 0, `stops` those at which no further point was found.
    """

    points: Floats
    folds: list[Floats]
    closed: bool = False
    born: tuple[Floats, ...] = ()
    stops: tuple[Floats, ...] = ()


def passes(curve: Curve, points: Floats, z: complex, omega: float) -> bool:
    """True for an arc through a state, or through its copy shifted by whole forcing periods.

    The arc is met again in the plane through the state across the nearest chord: this serves at folds too, where two
    states of one speed lie close together.
    """
    copies = curve.flow.at(omega).setting.copies
    ahead = np.diff(points, axis=0)
    length = np.linalg.norm(ahead, axis=1)
    for turn in np.exp(2j * np.pi * np.arange(copies) / copies):
        state = curve.join(complex(z * turn), omega)
        with np.errstate(all="ignore"):
            share = np.sum((state - points[:-1]) * ahead, axis=1) / length**2
        foot = points[:-1] + share[:, None] * ahead
        beside = (np.abs(share - 0.5) <= 0.6) & (np.linalg.norm(state - foot, axis=1) <= SAG * length)
        for i in np.flatnonzero(beside).tolist():
            guess, along = _between(points[i], points[i + 1], float(share[i])), ahead[i] / length[i]
            solution = curve.correct(guess + along * float((state - guess) @ along), along)
            if solution is not None and _are_one(solution, state):
                return True
    return False


def new_part(curve: Curve, arc: Arc, arcs: list[Arc], start: Floats) -> Arc:
    """Part of an arc through its `start` that is on none of `arcs`; what was leapt over joins two arcs elsewhere."""

    def met(point: Floats) -> bool:
        z, omega = curve.split(point)
        return any(passes(curve, other.points, z, omega) for other in arcs)

    nearest = int(np.argmin(np.linalg.norm(arc.points - start, axis=1)))
    low, high = nearest, nearest
    while low > 0 and not met(arc.points[low - 1]):
        low -= 1
    while high + 1 < len(arc.points) and not met(arc.points[high + 1]):
        high += 1
    if high - low + 1 == len(arc.points):
        return arc
    kept = arc.points[low : high + 1]

    def inside(some: Iterable[Floats]) -> list[Floats]:
        return [point for point in some if np.any(np.all(kept == point, axis=1))]

    return Arc(kept, inside(arc.folds), False, tuple(inside(arc.born)), tuple(inside(arc.stops)))


def _between(a: Floats, b: Floats, share: float) -> Floats:
    """Point between two neighbours on a spiral about z = 0: with little damping a chord leaves the curve too far."""
    z, end = complex(a[0], a[1]), complex(b[0], b[1])
    z = z * (end / z) ** share if z and end else z + share * (end - z)
    return np.array([z.real, z.imag, a[2] + share * (b[2] - a[2])])


def _are_one(a: Floats, b: Floats) -> bool:
    return _distance(a, b) < 1e-6 * _size(b) + 1e-10


def trace(curve: Curve, start: Floats, lo: float, hi: float) -> Arc:
    """One branch through `start`: up in omega first, then, unless it has closed, the other way, joined in order."""
    first = curve.tangent(start, np.array([0.0, 0.0, 1.0]))
    ahead = _walk(curve, start, first, lo, hi)
    if ahead.closed:
        return ahead
    back = _walk(curve, start, -first, lo, hi)
    points = np.concatenate([back.points[:0:-1], ahead.points])
    return Arc(points, back.folds + ahead.folds, False, back.born + ahead.born, back.stops + ahead.stops)


def _walk(curve: Curve, start: Floats, along: Floats, lo: float, hi: float) -> Arc:
    """Follow a branch from `start` until it closes or leaves the range of scaled speeds."""
    points: list[Floats] = [start]
    folds: list[Floats] = []
    step, first = 0.2 * LARGEST_STEP, along
    may_vanish = is_trivial(curve.flow.at(curve.split(start)[1]))
    while len(points) < MOST_POINTS and step > 1e-9:
        last = points[-1]
        guess = _ahead(last, step * along)
        point = curve.correct(guess, along, FEW_STEPS)
        tangent = None if point is None else curve.tangent(point, along)
        turned = math.inf if tangent is None else math.acos(min(1.0, float(tangent @ along)))
        if point is None or tangent is None or turned > 2.5 * TURN or _leaps(last, guess, point):
            step *= 0.4
            continue
        closed = _meets(curve, start, first, last, point)
        if closed:  # a fold between the start and this point has been met before
            point, tangent = start, first
        turns = along[2] * tangent[2] < 0.0 and not (may_vanish and _size(point) < FLAT_AMPLITUDE)
        fold = special(curve, last, point, lambda _, along: float(along[2])) if turns else None
        for end in [point] if fold is None else [fold, point]:
            if not lo <= end[2] <= hi:
                edge = _clipped(curve, points[-1], end, lo if end[2] < lo else hi)
                return Arc(np.array(points + edge), folds)
            points.append(end)
            folds += [end] if end is fold else []
        if closed:
            return Arc(np.array(points), folds, True)
        if may_vanish and _size(point) < BIRTH_AMPLITUDE:
            end = np.array([0.0, 0.0, point[2]])
            return Arc(np.array([*points, end]), folds, born=(end,))
        along = tangent
        largest = LARGEST_STEP * max(1.0, _size(point))
        step = min(largest, step * min(2.0, max(0.5, TURN / max(turned, 1e-9))))
    return Arc(np.array(points), folds, stops=(points[-1],))


def _ahead(origin: Floats, step: Floats) -> Floats:
    """The point to which a step leads that keeps its angle to the direction of z."""
    z, dz = complex(origin[0], origin[1]), complex(step[0], step[1])
    if abs(dz) <= abs(z):
        dz = z * (cmath.exp(dz / z) - 1.0)
    return np.asarray(origin + np.array([dz.real, dz.imag, step[2]]))


def _leaps(origin: Floats, guess: Floats, point: Floats) -> bool:
    """True for a step that may have gone to another branch, or past a = 0."""
    off, change = _distance(point, guess), math.hypot(point[0] - origin[0], point[1] - origin[1])
    return off > TANGENT_DEVIATION * _distance(guess, origin) or change > AMPLITUDE_CHANGE * _size(origin)


def _meets(curve: Curve, start: Floats, first: Floats, origin: Floats, point: Floats) -> bool:
    """True if the step from `origin` to `point` passes the start of the walk in the direction in which it began."""
    left, travelled = float((origin - start) @ first), float((point - start) @ first)
    if not left < 0.0 <= travelled or _distance(point, start) > 2.0 * _distance(point, origin):
        return False
    guess = _between(origin, point, left / (left - travelled))
    solution = curve.correct(guess + first * float((start - guess) @ first), first)
    return solution is not None and _are_one(solution, start)


def _clipped(curve: Curve, inside: Floats, outside: Floats, bound: float) -> list[Floats]:
    """The point at which an arc leaves the range of speeds."""

    def excess(point: Floats, _: Floats) -> float:
        return float(point[2]) - bound

    edge = special(curve, inside, outside, excess)
    return [] if edge is None else [np.array([edge[0], edge[1], bound])]


def special(curve: Curve, a: Floats, b: Floats, measure: Any) -> Floats | None:
    """Point between two neighbours at which `measure(point, tangent)`, of opposite signs there, vanishes."""
    chord = b - a
    length = float(np.linalg.norm(chord))
    if length == 0.0:
        return None
    chord, offset = chord / length, np.zeros(3)

    def solved(share: float) -> Floats:
        nonlocal offset  # the way from the chord to the last point, which is nearly that of the next
        guess = _between(a, b, share)
        point = curve.correct(guess + offset, chord)
        if point is None:
            return guess
        offset = point - guess
        return point

    def value(share: float) -> float:
        point = solved(share)
        return float(measure(point, curve.tangent(point, chord)))

    if value(0.0) * value(1.0) >= 0.0:
        return None
    return solved(bracketed_root(value, 0.0, 1.0, xtol=1e-13))


def _size(point: Floats) -> float:
    return math.hypot(point[0], point[1])


def _distance(a: Floats, b: Floats) -> float:
    return float(np.linalg.norm(b - a))
