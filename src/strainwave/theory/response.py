"""Response curves of the slow flow: every branch of steady states over a range of speeds, ordered along its arc.

Pseudo-arclength continuation of (Re z, Im z, omega) in scaled units (Keller 1977; Krack & Gross 2019, Harmonic Balance
for Nonlinear Vibration Problems, sec. 4.2), seeded by all steady states on a grid of speeds: closed loops are met too.
"""

import functools
import itertools
import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from ..numerics.brackets import bracketed_root
from ..results import Floats
from .fixed_points import Flow, fixed_points, is_stable, is_trivial, polish
from .slow_results import SlowBranch, SlowResponse

SEEDS, LARGEST_STEP, TURN, MOST_POINTS = 33, 0.05, 0.16, 4000
PER_CYCLE = 64  # samples of the fastest component: a peak between them is right to 1e-3


@dataclass(frozen=True, eq=False)
class Curve:
    """The curve rates(z, omega) = 0 in the scaled unknowns (Re z/size, Im z/size, omega/width)."""

    flow: Flow
    size: float
    width: float

    def split(self, point: Floats) -> tuple[complex, float]:
        """The state z [rad] and the speed omega [rad/s] of a point."""
        return self.size * complex(point[0], point[1]), self.width * float(point[2])

    def join(self, z: complex, omega: float) -> Floats:
        """The point of a state and a speed."""
        return np.array([z.real / self.size, z.imag / self.size, omega / self.width])

    def linear(self, point: Floats) -> tuple[Floats, Floats]:
        """Residual (2,) and its derivative (2, 3) to the scaled unknowns, both over size."""
        z, omega = self.split(point)
        here = self.flow.at(omega)
        rate = complex(here.rates(z))
        slope = here.speed_slope(z) * self.width / self.size
        matrix = np.column_stack([here.jacobian(z), [slope.real, slope.imag]])
        return np.array([rate.real, rate.imag]) / self.size, matrix

    def tangent(self, point: Floats, along: Floats) -> Floats:
        """Unit tangent, on the side of `along`; its last entry is det(d rates/d z), zero exactly at a fold."""
        _, matrix = self.linear(point)
        (a, b, c), (d, e, f) = matrix.tolist()
        direction = np.array([b * f - c * e, c * d - a * f, a * e - b * d])
        length = float(np.linalg.norm(direction))
        if not 0.0 < length < math.inf:
            return along
        return direction * (math.copysign(1.0, float(direction @ along)) / length)

    def correct(self, guess: Floats, along: Floats) -> Floats | None:
        """Newton back to the curve in the plane through the guess across `along`; None where it does not converge."""
        point = guess
        for _ in range(8):
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


def response(flow: Flow, lo: float, hi: float) -> SlowResponse:
    """Trace every branch of nontrivial steady states between two speeds [rad/s]."""
    speeds = np.linspace(lo, hi, SEEDS)
    seeds: list[tuple[complex, float]] = []
    trivial = []
    for omega in speeds:
        if flow.setting.sits_on(float(omega)):
            continue
        here = flow.at(float(omega))
        seeds += [(z, float(omega)) for z in fixed_points(here)]
        if is_trivial(here):
            trivial.append((float(omega), is_stable(here, 0j)))
    if not seeds:
        message = f"no steady state with a > 0 was found between {lo:.6g} and {hi:.6g} rad/s ({SEEDS} speeds searched)"
        return SlowResponse((), (), (), (0.5 * (lo + hi), 0.0), tuple(trivial), message)
    curve = Curve(flow, max(abs(z) for z, _ in seeds), hi - lo)
    arcs: list[tuple[Floats, bool]] = []
    for z, omega in seeds:
        if not any(_passes(curve, points, z, omega) for points, _ in arcs):
            arcs.append(_trace(curve, curve.join(z, omega), lo / curve.width, hi / curve.width))
    return _assembled(curve, arcs, tuple(trivial))


def _passes(curve: Curve, points: Floats, z: complex, omega: float) -> bool:
    """Whether an arc goes through a state, or through its copy shifted by whole forcing periods."""
    place = omega / curve.width
    here = curve.flow.at(omega)
    copies = np.exp(2j * np.pi * np.arange(here.setting.copies) / here.setting.copies)
    for i in np.flatnonzero((points[:-1, 2] - place) * (points[1:, 2] - place) <= 0.0):
        gap = points[i + 1, 2] - points[i, 2]
        guess = points[i] + (points[i + 1] - points[i]) * ((place - points[i, 2]) / gap if gap else 0.0)
        found = polish(here, curve.split(guess)[0])
        if found is not None and np.min(np.abs(found * copies - z)) < 1e-6 * abs(z):
            return True
    return False


def _trace(curve: Curve, start: Floats, lo: float, hi: float) -> tuple[Floats, bool]:
    """One branch through `start`: up in omega first, then, unless it has closed, the other way, joined in order."""
    ahead, closed = _walk(curve, start, curve.tangent(start, np.array([0.0, 0.0, 1.0])), lo, hi)
    if closed:
        return np.array(ahead), True
    back, _ = _walk(curve, start, -curve.tangent(start, np.array([0.0, 0.0, 1.0])), lo, hi)
    return np.array(back[:0:-1] + ahead), False


def _walk(curve: Curve, start: Floats, along: Floats, lo: float, hi: float) -> tuple[list[Floats], bool]:
    points, step, first = [start], 0.2 * LARGEST_STEP, along
    while len(points) < MOST_POINTS and step > 1e-9:
        point = curve.correct(points[-1] + step * along, along)
        tangent = None if point is None else curve.tangent(point, along)
        turned = math.inf if tangent is None else math.acos(min(1.0, float(tangent @ along)))
        if point is None or tangent is None or turned > 2.5 * TURN:
            step *= 0.4
            continue
        if not lo <= point[2] <= hi:
            points += _clipped(curve, points[-1], point, lo if point[2] < lo else hi)
            return points, False
        travelled, left = float((point - start) @ first), float((points[-1] - start) @ first)
        if len(points) > 4 and left < 0.0 <= travelled and float(np.linalg.norm(point - start)) < 2.0 * step:
            return [*points, start], True
        points.append(point)
        along = tangent
        step = min(LARGEST_STEP, step * min(2.0, max(0.5, TURN / max(turned, 1e-9))))
    return points, False


def _clipped(curve: Curve, inside: Floats, outside: Floats, bound: float) -> list[Floats]:
    """The point at which an arc leaves the range of speeds."""
    share = (bound - inside[2]) / (outside[2] - inside[2])
    z, omega = curve.split(inside + share * (outside - inside))
    found = polish(curve.flow.at(omega), z)
    return [] if found is None or share < 1e-9 else [curve.join(found, omega)]


def _special(curve: Curve, a: Floats, b: Floats, measure: Any) -> Floats | None:
    """Point between two neighbours at which `measure(point, tangent)`, of opposite signs there, vanishes."""
    chord = b - a
    length = float(np.linalg.norm(chord))
    chord = chord / length

    def at(share: float) -> Floats:
        guess = a + share * length * chord
        point = curve.correct(guess, chord)
        return guess if point is None else point

    def value(share: float) -> float:
        point = at(share)
        return float(measure(point, curve.tangent(point, chord)))

    if value(0.0) * value(1.0) >= 0.0:
        return None
    return at(bracketed_root(value, 0.0, 1.0, xtol=1e-13))


def _distance(a: Floats, b: Floats) -> float:
    return float(np.linalg.norm(b - a))


def _height(top: tuple[float, float]) -> float:
    return top[1]


def _fold(_: Floats, tangent: Floats) -> float:
    return float(tangent[2])


def _top(point: Floats, tangent: Floats) -> float:
    return float(point[:2] @ tangent[:2])


def _assembled(curve: Curve, arcs: list[tuple[Floats, bool]], trivial: tuple[tuple[float, bool], ...]) -> SlowResponse:
    folds: list[tuple[float, float]] = []
    tops: list[tuple[float, float]] = []
    branches = []
    for points, closed in arcs:
        ahead = np.diff(points, axis=0)
        tangents = [curve.tangent(p, d) for p, d in zip(points, np.vstack([ahead, ahead[-1:]]), strict=True)]
        kept = [points[0]]
        for i, (a, b) in enumerate(itertools.pairwise(points)):
            special = []
            for measure, record in ((_fold, folds), (_top, tops)):
                if measure(a, tangents[i]) * measure(b, tangents[i + 1]) < 0.0:
                    point = _special(curve, a, b, measure)
                    if point is not None:
                        z, omega = curve.split(point)
                        record.append((omega, abs(z)))
                        special.append(point)
            kept += sorted(special, key=functools.partial(_distance, a))
            kept.append(b)
        branches.append(_branch(curve, np.array(kept), closed))
    branches.sort(key=lambda branch: float(np.max(branch.amplitude)), reverse=True)
    for branch in branches:
        i = int(np.argmax(branch.amplitude))
        tops.append((float(branch.omega[i]), float(branch.amplitude[i])))
    peak = max(tops, key=_height)
    folds.sort()
    counts = f"{len(branches)} branch(es), {len(folds)} fold(s)"
    message = f"{counts}, largest amplitude {peak[1]:.6g} rad at omega = {peak[0]:.6g} rad/s"
    return SlowResponse(tuple(branches), tuple(f[0] for f in folds), tuple(f[1] for f in folds), peak, trivial, message)


def _branch(curve: Curve, points: Floats, closed: bool) -> SlowBranch:
    z = curve.size * (points[:, 0] + 1j * points[:, 1])
    omega = curve.width * points[:, 2]
    flows = [curve.flow.at(float(w)) for w in omega]
    stable = np.array([is_stable(flow, complex(point)) for flow, point in zip(flows, z, strict=True)])
    peak = np.array([_peak(flow, complex(point)) for flow, point in zip(flows, z, strict=True)])
    return SlowBranch(omega, np.abs(z), -np.angle(z), peak, stable, closed)


def _peak(flow: Flow, z: complex) -> float:
    """Largest |x| [rad] of the motion e + u0 + F + Re(z E) on samples."""
    s = flow.setting
    ratio = s.resonance.ratio or Fraction(1)
    samples = PER_CYCLE * ratio.denominator * max(math.ceil(ratio), *s.orders, 1)
    theta = 2.0 * np.pi * ratio.denominator * np.arange(samples) / samples
    x = s.u0 + s.forced(theta) + s.system.error.value(theta) + (z * np.exp(1j * float(ratio) * theta)).real
    return float(np.max(np.abs(x)))
