"""The variational equation of orbits (Floquet theory), no external disturbance: a constant matrix and what varies.

It says how a small disturbance of an orbit grows or decays. A condensed problem (`Condensed`) has the twists that the
laws of its system see as unknowns; all else is linear.
"""

from typing import Any, NamedTuple

import numpy as np

from ....base.law import breakpoints_of
from ....base.protocols import linear_part_of
from ....base.results import Floats
from ..fourier import LOOKED, Samples, derivative, false_position, synthesis
from ..rates import base_speed
from .gear import sample_error


class MotorError(NamedTuple):
    """A kinematic error that follows the motor: its `lines` (rows order, cosine, sine), and the damping of the gear.

    `rate` is the speed of the harmonic 1 over omega, `deviation` (orbits, 2h+1) the motor's [rad].
    """

    lines: Floats
    damping: float
    rate: float
    deviation: Floats


class Disturbances(NamedTuple):
    """y' = (a + b R c) y along orbits, y positions, speeds and states of a control.

    R has a row for the torque of each law, and of a kinematic error that follows the motor one for the torque on the
    motor. Its columns are for the twist of each law, and then for the rate of the gear's twist, the motor's angle and
    its speed. The gear is the first law.

    `twists` (orbits, laws, 2h+1) are what the laws see, `mean` (laws,) their stiffnesses in a, and `speed` (orbits,)
    is that of the harmonic 1 [rad/s]. `rate` [1/s] is that of the fastest disturbance.
    """

    laws: tuple[Any, ...]
    a: Floats
    b: Floats
    c: Floats
    mean: Floats
    rate: float
    twists: Floats
    speed: Floats
    error: MotorError | None = None

    def of(self, orbits: slice) -> Any:
        """Those of some of the orbits."""
        error = self.error and self.error._replace(deviation=self.error.deviation[orbits])
        return self._replace(twists=self.twists[orbits], speed=self.speed[orbits], error=error)

    def feedbacks(self, psi: Floats, bases: list[Floats]) -> Floats:
        """R (n, feedbacks, seen) at places psi (n,) [rad], one orbit after another, each with its synthesis there."""
        count, u = len(self.mean), samples(self.twists, bases)
        stiff = [law.stiffness(x) + 0.0 * x for law, x in zip(self.laws, u, strict=True)]
        gains = np.zeros((len(psi), self.b.shape[1], len(self.c)))
        gains[:, range(count), range(count)] = (self.mean[:, None] - stiff).T
        if self.error is None:
            return gains
        lines, B, rate_of_harmonic, deviation = self.error
        w, pair = self.speed[:, None, None], np.stack([self.twists[:, 0], deviation], axis=1)
        d, du, dd = samples(np.concatenate([pair[:, 1:], w * derivative(pair)], axis=1), bases)
        base = np.repeat(self.speed / rate_of_harmonic, [basis.shape[1] for basis in bases])
        error, slope, bend = np.empty((3, len(psi)))
        sample_error(lines, 1.0, psi / rate_of_harmonic, d, error, slope, bend)
        pull = stiff[0] * slope + B * bend * (base + dd)
        torque = self.laws[0].torque(u[0]) + B * du
        gear, motor = 0, count  # rows: torques
        twist, rate, angle, speed = 0, count, count + 1, count + 2  # columns: what they follow
        gains[:, gear, angle], gains[:, gear, speed] = pull, B * slope
        gains[:, motor, twist], gains[:, motor, rate] = slope * stiff[0], slope * B
        gains[:, motor, angle], gains[:, motor, speed] = bend * torque - slope * pull, -slope * slope * B
        return gains

    def crossings(self) -> list[Floats]:
        """Places [rad] of every orbit, in order, where a law has a breakpoint."""
        pairs = [(j, b) for j, law in enumerate(self.laws) for b in breakpoints_of(law)]
        if not pairs:
            return [np.empty(0)] * len(self.twists)
        twist, breaks = map(np.array, zip(*pairs, strict=True))
        h = self.twists.shape[2] // 2
        places = LOOKED * (h + 1)
        d = (self.twists @ synthesis(h, places))[:, twist] - breaks[:, None]
        d = np.concatenate([d, d[..., :1]], axis=2)
        orbit, kink, m = np.nonzero(d[..., 1:] * d[..., :-1] < 0.0)
        step = 2.0 * np.pi / places
        ends = m * step, (m + 1) * step, d[orbit, kink, m], d[orbit, kink, m + 1]
        crossed = _refined(self.twists[orbit, twist[kink]], breaks[kink], *ends)
        return [np.sort(crossed[orbit == i]) for i in range(len(self.twists))]


def disturbances(problem: Any, points: Floats) -> Disturbances | None:
    """Disturbances of the orbits; None where the parameter that varies is no speed, or where inertias are missing."""
    part = problem.part
    if part.loose >= 0 and not np.any(part.integral):
        part = linear_part_of(part.disturbed)
    if part is None or problem.leaf != problem.omega_leaf or not len(points):
        return None
    M, C, K = part.inertia, part.damping.copy(), part.stiffness.copy()
    heavy = np.flatnonzero(np.any(M != 0.0, axis=1))
    massless = np.setdiff1d(np.arange(len(M)), heavy)
    if 2 * len(heavy) + len(massless) != problem.state_count() + len(part.values) - len(problem.part.values):
        return None
    twists, laws = problem.series(points), problem.part.laws
    u = twists[:, : len(laws)] @ problem.synthesis
    stiff = [law.stiffness(u[:, j]) + 0.0 * u[:, j] for j, law in enumerate(laws)]
    mean = np.array([np.mean(k) for k in stiff])
    C[0, 0] += part.gear_damping
    K[range(len(laws)), range(len(laws))] += mean
    loaded = [*range(len(laws)), *([len(laws)] if part.follows else [])]
    a, b = first_order_of(M, C, K, heavy, massless, loaded)
    position, speed = np.split(np.eye(len(a))[: 2 * len(heavy)], 2)
    c, motor = position[: len(laws)], [len(laws)]  # the coordinates that laws see, and the motor's, are the first
    if part.follows:
        c = np.concatenate([c, speed[:1], position[motor], speed[motor]])
    extremes = [a + b[:, : len(laws)] * (mean - [f(k) for k in stiff]) @ c[: len(laws)] for f in (np.min, np.max)]
    rate = max(float(np.max(np.abs(np.linalg.eigvals(x)))) for x in (a, *extremes))
    harmonic = problem.pencil.rate
    w, error = harmonic * base_speed(problem, points[:, -1]), None
    if part.follows:
        error = MotorError(problem.gear.lines, problem.part.gear_damping, harmonic, twists[:, len(laws)])
    return Disturbances(laws, a, b, c, mean, rate, twists[:, : len(laws)], w, error)


def samples(series: Floats, bases: list[Floats]) -> Floats:
    """Samples (k, n) of series (orbits, k, 2h+1), one orbit after another, each with its synthesis."""
    return np.concatenate([y @ basis for y, basis in zip(series, bases, strict=True)], axis=1)


def first_order_of(M: Floats, C: Floats, K: Floats, heavy: Any, massless: Any, loaded: Any) -> tuple[Floats, Floats]:
    """Matrix of positions, speeds and coordinates without inertia (`massless`), and of torques on `loaded` ones."""
    m, n = len(heavy), 2 * len(heavy) + len(massless)
    position, speed, following = slice(m), slice(m, 2 * m), slice(2 * m, n)
    inverse, inverse_c = np.linalg.inv(M[np.ix_(heavy, heavy)]), np.linalg.inv(C[np.ix_(massless, massless)])
    a, b, through = np.zeros((n, n)), np.zeros((n, len(loaded))), C[np.ix_(heavy, massless)]
    a[position, speed] = np.eye(m)
    for columns, of_massless, of_heavy in (
        (position, K[np.ix_(massless, heavy)], K[np.ix_(heavy, heavy)]),
        (speed, C[np.ix_(massless, heavy)], C[np.ix_(heavy, heavy)]),
        (following, K[np.ix_(massless, massless)], K[np.ix_(heavy, massless)]),
    ):
        a[following, columns] = -inverse_c @ of_massless
        a[speed, columns] = -inverse @ (of_heavy + through @ a[following, columns])
    b[speed] = inverse @ np.eye(len(M))[np.ix_(heavy, loaded)]
    return a, b


def _refined(series: Floats, value: Floats, low: Floats, high: Floats, first: Floats, last: Floats) -> Floats:
    """Places [rad] between `low` and `high` where series (n, 2h+1) have a value."""
    h = series.shape[1] // 2

    def missing(psi: Floats) -> Floats:
        return np.asarray(np.sum(series * Samples(psi, psi).basis(h).T, axis=1) - value)

    return false_position(missing, low, high, first, last)
