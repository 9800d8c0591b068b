"""Disturbances of the orbits of a condensed problem: a constant matrix, and what varies along an orbit.

With the twist of the gear u = p_0 - e(phase + d), d the motor's deviation, a disturbance p of the coordinates obeys
M p'' + C p' + K p + g (T' u + B u') - e'' T d = 0 with u = g . p, g = (1, ..., -e', ...): constant but for T'(u), e'
and e''. The laws' mean stiffness is in the constant part; the rest are feedbacks on the gear, on each coupling whose
law is not linear and, where an error follows the motor, on the motor.
"""

from typing import Any, NamedTuple

import numpy as np

from ....law import breakpoints_of
from ....protocols import linear_part_of
from ....results import Floats
from ..fourier import synthesis
from ..panels import LOOKED, Samples, false_position
from ..rates import base_speed


class Disturbances(NamedTuple):
    """y' = (a + b R c) y along orbits, y positions, speeds and states of a control.

    `twists` (orbits, laws, 2h+1) are what the laws see, `mean` (laws,) their stiffnesses in a, `deviation`
    (orbits, 2h+1) is the motor's, or None, and `speed` (orbits,) that of the harmonic 1 [rad/s]. `rate` [1/s] is that
    of the fastest disturbance.
    """

    problem: Any
    a: Floats
    b: Floats
    c: Floats
    mean: Floats
    rate: float
    twists: Floats
    deviation: Floats | None
    speed: Floats

    def feedbacks(self, psi: Floats, bases: list[Floats]) -> Floats:
        """R (n, feedbacks, seen) at places psi (n,) [rad], one orbit after another, each with its synthesis there."""
        part, count = self.problem.part, len(self.mean)
        u = samples(self.twists, bases)
        stiff = [law.stiffness(x) + 0.0 * x for law, x in zip(part.laws, u, strict=True)]
        out = np.zeros((len(psi), self.b.shape[1], len(self.c)))
        for j in range(count):
            out[:, j, j] = self.mean[j] - stiff[j]
        if self.deviation is None:
            return out
        B, w = part.gear_damping, self.speed[:, None, None]
        pair = np.stack([self.twists[:, 0], self.deviation], axis=1)
        d, du, dd = samples(np.concatenate([pair[:, 1:], w * derivative(pair)], axis=1), bases)
        base = np.repeat(self.speed / self.problem.pencil.rate, [basis.shape[1] for basis in bases])
        slope, bend = self.error(psi / self.problem.pencil.rate + d)
        pull = stiff[0] * slope + B * bend * (base + dd)
        torque = part.laws[0].torque(u[0]) + B * du
        out[:, 0, count + 1], out[:, 0, count + 2] = pull, B * slope
        out[:, -1, 0], out[:, -1, count] = slope * stiff[0], slope * B
        out[:, -1, count + 1], out[:, -1, count + 2] = bend * torque - slope * pull, -slope * slope * B
        return out

    def error(self, angle: Floats) -> tuple[Floats, Floats]:
        """First and second derivatives of the kinematic error at the motor's angles [rad]."""
        slope, bend = np.zeros_like(angle), np.zeros_like(angle)
        for order, even, odd in self.problem.gear.lines[1:]:
            c, s = np.cos(order * angle), np.sin(order * angle)
            slope += order * (odd * c - even * s)
            bend -= order * order * (even * c + odd * s)
        return slope, bend

    def crossings(self) -> list[Floats]:
        """Places [rad] of every orbit, in order, where a law has a breakpoint."""
        pairs = [(j, b) for j, law in enumerate(self.problem.part.laws) for b in breakpoints_of(law)]
        if not pairs:
            return [np.empty(0)] * len(self.twists)
        twist, breaks = (np.array(x) for x in zip(*pairs, strict=True))
        h = self.twists.shape[2] // 2
        places = LOOKED * (h + 1)
        d = (self.twists @ synthesis(h, places))[:, twist] - breaks[:, None]
        d = np.concatenate([d, d[..., :1]], axis=2)
        orbit, kink, at = np.nonzero(d[..., 1:] * d[..., :-1] < 0.0)
        step = 2.0 * np.pi / places
        ends = at * step, (at + 1) * step, d[orbit, kink, at], d[orbit, kink, at + 1]
        found = _refined(self.twists[orbit, twist[kink]], breaks[kink], *ends)
        return [np.sort(found[orbit == i]) for i in range(len(self.twists))]


def disturbances(problem: Any, points: Floats) -> Disturbances | None:
    """Disturbances of the orbits; None where the parameter that varies is no speed, or where inertias are missing."""
    part = problem.part if problem.part.loose < 0 else linear_part_of(problem.part.disturbed)
    if part is None or problem.leaf != problem.omega_leaf or not len(points):
        return None
    M, C, K = part.inertia, part.damping.copy(), part.stiffness.copy()
    moving = np.flatnonzero(np.any(M != 0.0, axis=1))
    rest = np.setdiff1d(np.arange(len(M)), moving)
    if 2 * len(moving) + len(rest) != problem.state_count() + len(part.values) - len(problem.part.values):
        return None
    twists, laws = problem.series(points), problem.part.laws
    u = twists[:, : len(laws)] @ problem.synthesis
    stiff = [law.stiffness(u[:, j]) + 0.0 * u[:, j] for j, law in enumerate(laws)]
    mean = np.array([np.mean(k) for k in stiff])
    C[0, 0] += part.gear_damping
    K[range(len(laws)), range(len(laws))] += mean
    at = [*range(len(laws)), *([len(laws)] if part.follows else [])]
    a, b = _first_order(M, C, K, moving, rest, at)
    position = np.eye(len(a))[: len(moving)]  # the coordinates that laws see, and the motor's, are the first
    speed = np.eye(len(a))[len(moving) : 2 * len(moving)]
    c = position[: len(laws)]
    if part.follows:
        c = np.concatenate([c, speed[:1], position[[len(laws)]], speed[[len(laws)]]])
    extremes = [a + b[:, : len(laws)] * (mean - [f(k) for k in stiff]) @ c[: len(laws)] for f in (np.min, np.max)]
    rate = max(float(np.max(np.abs(np.linalg.eigvals(x)))) for x in (a, *extremes))
    w = problem.pencil.rate * base_speed(problem, points[:, -1])
    deviation = twists[:, len(laws)] if part.follows else None
    return Disturbances(problem, a, b, c, mean, rate, twists[:, : len(laws)], deviation, w)


def samples(series: Floats, bases: list[Floats]) -> Floats:
    """Samples (k, n) of series (orbits, k, 2h+1), one orbit after another, each with its synthesis."""
    return np.concatenate([y @ basis for y, basis in zip(series, bases, strict=True)], axis=1)


def derivative(series: Floats) -> Floats:
    """Derivatives by the angle of series (..., 2h+1) in blocks."""
    h = series.shape[-1] // 2
    k, out = np.arange(1, h + 1), np.zeros_like(series)
    out[..., 1 : h + 1], out[..., h + 1 :] = k * series[..., h + 1 :], -k * series[..., 1 : h + 1]
    return out


def _first_order(M: Floats, C: Floats, K: Floats, moving: Any, rest: Any, at: list[int]) -> tuple[Floats, Floats]:
    """Matrix of positions, speeds and coordinates without inertia (`rest`), and of torques on coordinates `at`."""
    m, inverse = len(moving), np.linalg.inv(M[np.ix_(moving, moving)])
    n = 2 * m + len(rest)
    a, unit = np.zeros((n, n)), np.eye(len(M))[:, at]
    a[:m, m : 2 * m] = np.eye(m)
    rows = slice(2 * m, n)
    if len(rest):
        own = np.linalg.inv(C[np.ix_(rest, rest)])
        a[rows, :m], a[rows, m : 2 * m] = -own @ K[np.ix_(rest, moving)], -own @ C[np.ix_(rest, moving)]
        a[rows, rows] = -own @ K[np.ix_(rest, rest)]
    through = C[np.ix_(moving, rest)]
    a[m : 2 * m, :m] = -inverse @ (K[np.ix_(moving, moving)] + through @ a[rows, :m])
    a[m : 2 * m, m : 2 * m] = -inverse @ (C[np.ix_(moving, moving)] + through @ a[rows, m : 2 * m])
    a[m : 2 * m, rows] = -inverse @ (K[np.ix_(moving, rest)] + through @ a[rows, rows])
    b = np.zeros((n, len(at)))
    b[m : 2 * m] = inverse @ unit[moving]
    return a, b


def _refined(series: Floats, value: Floats, low: Floats, high: Floats, below: Floats, above: Floats) -> Floats:
    """Places [rad] between `low` and `high` where series (n, 2h+1) have a value."""
    h = series.shape[1] // 2

    def missing(psi: Floats) -> Floats:
        return np.asarray(np.sum(series * Samples(psi, psi).basis(h).T, axis=1) - value)

    return false_position(missing, low, high, below, above)
