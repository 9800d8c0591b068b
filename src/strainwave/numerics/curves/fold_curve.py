"""`fold_curve`: where a fold lies while a second parameter varies, around the cusps where two folds meet.

The equations that a fold satisfies while a second parameter varies, and their continuation.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...base.arguments import typed
from ...base.law import repeating, springs_only
from ...base.protocols import with_parts
from ...base.quantities import checked, interval, replace, shown, whole
from ...base.results import Floats, Orbit, SolveError, Status
from ...compile.tree import leaf_of
from ..balance.first_order import linearised, newton
from ..balance.fourier import from_blocks
from ..balance.harmonics import starting_harmonics
from ..balance.linear_part import forced
from ..balance.rates import SAME
from ..balance.second_order import second_order
from ..balance.truncation import LOOKED_AT, tail_along
from ..operating_point import bracketed_root
from ..stability.second_order import displacement_peaks
from .parameter_response import value_at

MOST_POINTS = 2000
SMALLEST_STEP = 1e-7


class FoldSystem:
    """The equations of a fold in the unknowns (coefficients, p, q)."""

    def __init__(self, problem: Any, path: str, width: float) -> None:
        self.problem, self.path, self.width = problem, path, width
        self.n = problem.size()
        self.b = self.c = np.ones(self.n) / np.sqrt(self.n)
        self.special: list[tuple[float, float, bool]] = []

    def at(self, q: float) -> Any:
        """The balance problem at a value of the second parameter."""
        p = self.problem
        system = replace(p.system, {self.path: float(q)})
        tau, error = forced(system, p.angles, p.analysis)
        return p._replace(system=system, tau=tau, error=error)

    def linearised(self, x: Floats) -> tuple[Floats, Floats]:
        """Values (n + 1) of the equations at x = (coefficients, p, q), and their derivatives (n + 1, n + 2)."""
        n, z = self.n, x[:-1]
        problem = self.at(x[-1])
        r, matrix, column = linearised(problem, z)
        unit = np.zeros(n + 1)
        unit[n] = 1.0
        size = float(np.linalg.norm(matrix)) / np.sqrt(n)  # gives b and c the units of the Jacobian
        bordered = np.block([[matrix, size * self.b[:, None]], [size * self.c[None, :], np.zeros((1, 1))]])
        v, w = np.linalg.solve(bordered, unit), np.linalg.solve(bordered.T, unit)
        g, v, w = v[n], v[:n], w[:n]
        self.right, self.left = v / np.linalg.norm(v), w / np.linalg.norm(w)
        jacobian = np.empty((n + 1, n + 2))
        jacobian[:n, :n], jacobian[:n, n] = matrix, column
        shift = np.zeros(n + 1)
        shift[:n] = 1e-5 * np.linalg.norm(z[:n]) * v / np.linalg.norm(v)
        change = linearised(problem, z + shift)[1] - linearised(problem, z - shift)[1]
        jacobian[n, :n] = -(w @ change) * np.linalg.norm(v) / (2.0 * np.linalg.norm(shift))
        step = 1e-5 * max(abs(float(z[n])), 1e-6)
        shift[:n], shift[n] = 0.0, step
        change = linearised(problem, z + shift)[1] - linearised(problem, z - shift)[1]
        jacobian[n, n] = -(w @ change @ v) / (2.0 * step)
        step = 1e-5 * max(abs(float(x[-1])), 1e-3 * self.width)
        upper, lower = linearised(self.at(x[-1] + step), z), linearised(self.at(x[-1] - step), z)
        jacobian[:n, n + 1] = (upper[0] - lower[0]) / (2.0 * step)
        jacobian[n, n + 1] = -(w @ (upper[1] - lower[1]) @ v) / (2.0 * step)
        return np.append(r, g), jacobian

    def scale(self, x: Floats) -> Floats:
        """Units of the unknowns: the size of the orbit, p itself, the range of q."""
        out = np.full(len(x), max(float(np.linalg.norm(x[:-2])), 1e-300))
        out[-2], out[-1] = max(abs(float(x[-2])), 1e-300), self.width
        return out

    def corrected(self, x: Floats, row: Floats | None) -> Floats | None:
        """Fold next to x, in the plane through x across `row` (scaled), or at the q of x; None where Newton fails."""
        scale = self.scale(x)
        if row is None:
            row = np.zeros(len(x))
            row[-1] = 1.0
        _, derivative = self.linearised(x)  # the first b, c are arbitrary: take the singular vectors
        u, _, vt = np.linalg.svd(derivative[: self.n, : self.n])
        self.b, self.c = u[:, -1], vt[-1]
        across, target = row / scale, float(row @ (x / scale))

        def equations(x: Floats) -> tuple[Floats, Floats]:
            values, derivative = self.linearised(x)
            return np.append(values, across @ x - target), np.vstack([derivative, across])

        return newton(equations, x, scale, 1e-11, most=15, far=10.0)

    def tangent(self, x: Floats, before: Floats) -> Floats:
        """Unit tangent (scaled) of the fold curve at x, in the direction of `before`."""
        _, derivative = self.linearised(x)
        null: Floats = np.linalg.svd(derivative * self.scale(x))[2][-1]
        return null if null @ before > 0.0 else -null


def follow_fold(extended: FoldSystem, start: Floats, direction: float, lo: float, hi: float, ds: float) -> Any:
    """Points of the fold curve in one direction, and whether it left the range."""
    ahead = np.zeros(len(start))
    ahead[-1] = direction
    points, x, most = [start], start, ds
    t = extended.tangent(x, ahead)
    while len(points) < MOST_POINTS and ds > SMALLEST_STEP:
        scale = extended.scale(x)
        new = extended.corrected(x + ds * t * scale, t)
        turned = None if new is None else extended.tangent(new, t)
        if new is None or turned is None or turned @ t < 0.95:
            ds *= 0.4
            continue
        if t[-1] * turned[-1] < 0.0:
            _mark_turn(extended, x, new, t, turned)
        if not lo <= new[-1] <= hi:
            bound = hi if new[-1] > hi else lo
            share = (bound - x[-1]) / (new[-1] - x[-1])
            guess = x + share * (new - x)
            guess[-1] = bound
            end = extended.corrected(guess, None)
            return (points if end is None else [*points, end]), True
        points.append(new)
        x, t, ds = new, turned, min(most, 1.4 * ds)
    return points, False


def _mark_turn(extended: FoldSystem, first: Floats, last: Floats, t0: Floats, t1: Floats) -> None:
    """Locate where the second parameter turns; a cusp where the first one does too."""
    chord = last - first
    row = chord / extended.scale(first)
    point, tangent = first, t0

    def ahead(s: float) -> float:
        nonlocal point, tangent
        if s in (0.0, 1.0):
            return float((t1 if s else t0)[-1])
        new = extended.corrected(first + s * chord, row / np.linalg.norm(row))
        if new is None:
            return 0.0  # ends the search where it is
        point, tangent = new, extended.tangent(new, t0)
        return float(tangent[-1])

    bracketed_root(ahead, 0.0, 1.0, xtol=1e-10)
    extended.special.append((float(point[-1]), float(point[-2]), bool(abs(tangent[-2]) < 1e-3)))


@dataclass(frozen=True, eq=False)
class FoldCurve:
    """A fold (where a response jumps) against a second parameter.

    Attributes
    ----------
    parameter, folded : str
        Path of the second parameter, and of the one in which the branch turns ("omega").
    values : (n,) array
        The second parameter, in arc order.
    turns : (n,) array
        Value of `folded` at the fold: the frequency [rad/s] of the jump.
    coefficients : (n, 2H+1) array
        Fourier coefficients of x at the fold: mean, cos 1, sin 1, ...
    peak : (n,) array
        Largest |x| at the fold.
    cusps : tuple of (float, float)
        (second parameter, `folded`) where two folds meet and vanish: beyond it nothing jumps.
    extremes : tuple of (float, float)
        The same where the second parameter turns but `folded` does not: branches merge, or an isola is born.
    period : int
        Turns of the base angle per orbit.
    tail : float
        Largest share of x that the harmonics left out hold, estimated from the torque.
    status : Status
        `Status.OK`; `Status.TRUNCATED` where `tail` is above 1e-3; or why the curve ends inside the range.
    message : str
        One sentence.
    """

    parameter: str
    folded: str
    values: Floats
    turns: Floats
    coefficients: Floats
    peak: Floats
    cusps: tuple[tuple[float, float], ...]
    extremes: tuple[tuple[float, float], ...]
    period: int
    tail: float
    status: Status
    message: str

    @property
    def omega(self) -> Floats:
        """Frequency [rad/s] of the fold at every point, where the branch turns in omega."""
        if self.folded != "omega":
            raise ValueError(f"this branch turns in {self.folded}, not in omega; read .turns")
        return self.turns

    def amplitude(self, k: int) -> Floats:
        """Amplitude (n,) of harmonic k of x at the fold, 0-to-peak; k = 0 gives the mean."""
        x, k = self.coefficients, whole("k", k)
        if 2 * k >= x.shape[1]:
            return np.zeros(len(x))
        return np.asarray(np.hypot(x[:, 2 * k - 1], x[:, 2 * k])) if k else x[:, 0].copy()

    def __len__(self) -> int:
        return len(self.values)

    def __str__(self) -> str:
        cusps = ", ".join(f"{self.parameter} = {v:.9g}, {self.folded} = {w:.9g}" for v, w in self.cusps) or "none"
        return (
            f"FoldCurve: {len(self)} points, {self.parameter} {self.values.min():.6g} .. {self.values.max():.6g}, "
            f"{self.folded} {self.turns.min():.6g} .. {self.turns.max():.6g}\n"
            f"  cusps: {cusps}\n  {self.message}"
        )

    __repr__ = __str__


@typed
def fold_curve(
    system: Any,
    fold: Orbit,
    path: str,
    span: tuple[float, float],
    *,
    parameter: str = "omega",
    harmonics: int | None = None,
    points: int = 60,
) -> FoldCurve:
    """Follow a fold while a second parameter varies, both ways from the system's own value.

    Parameters
    ----------
    system : Oscillator
        The system that the fold belongs to.
    fold : Orbit
        One of `Branch.folds` of that system.
    path : str
        Path of the second parameter: "excitation.amplitude", "B", "law.alpha", ...
    span : (float, float)
        Its range (SI); the system's own value must lie in it.
    parameter : str
        Path of the parameter in which the fold turns.
    harmonics : int, optional
        Highest harmonic. Default: that of the fold.
    points : int
        About how many points to place.

    Returns
    -------
    FoldCurve
        `values` (n,) of the second parameter in its SI unit, the speed of the fold `turns` [rad/s] and its `peak`,
        largest |x| [rad]: through the given fold, from where the curve leaves the range to where it leaves it again;
        both folds of an overhanging peak where their cusp lies in the range.

    Raises
    ------
    ValueError
        If the orbit is no fold, or the system's value lies outside the range.
    SolveError
        If the fold is not one of this system.

    References
    ----------
    Govaerts 2000, Numerical Methods for Bifurcations of Dynamical Equilibria, secs. 3.3 and 4.1.
    """
    system = repeating("fold_curve", with_parts("fold_curve", system, *SAME))
    springs_only("fold_curve", system)
    for name in (path, parameter):
        leaf_of(system, name)
    if path == parameter:
        raise ValueError(f"the fold turns in {parameter}; the second parameter must be another one, not {path}")
    if not isinstance(fold, Orbit):
        raise ValueError(f"the fold is {shown(fold)}; take one of Branch.folds")
    if fold.label != "fold":
        raise ValueError(f"the orbit is labelled {fold.label!r}; take one of Branch.folds")
    system = checked(replace(system, {"omega": fold.omega, parameter: fold.value}))
    lo, hi = interval(f"the range of {path}", span, positive=path in ("omega", "J"))
    value = value_at(system, path)
    if not lo <= value <= hi:
        raise ValueError(f"the system has {path} = {value:g}, outside the range {lo:g} .. {hi:g}; widen the range")
    leaf, omega_leaf = leaf_of(system, parameter), leaf_of(system, "omega")
    h = starting_harmonics(system, len(fold.coefficients) // 2 if harmonics is None else harmonics, fold.period, points)
    problem = second_order(system, leaf, omega_leaf, h, fold.period)
    extended = FoldSystem(problem, path, hi - lo)
    start = extended.corrected(np.append(problem.point(fold.coefficients, fold.value), value), None)
    if start is None:
        raise SolveError(
            f"there is no fold of this system at {parameter} = {fold.value:.9g} and {path} = {value:g}; take one from "
            "the folds of its own frequency_response"
        )
    up, ends_up = follow_fold(extended, start, 1.0, lo, hi, 4.0 / points)
    down, ends_down = follow_fold(extended, start, -1.0, lo, hi, 4.0 / points)
    curve = np.array([*down[:0:-1], *up])
    x = np.array([z[:-2] + extended.at(z[-1]).error for z in curve])
    special = [s for s in extended.special if lo <= s[0] <= hi]
    good = ends_up and ends_down
    message = f"leaves the range at {path} = {curve[0, -1]:.6g} and {curve[-1, -1]:.6g}"
    if not good:
        message = f"stops between {path} = {curve[0, -1]:.6g} and {curve[-1, -1]:.6g}; take more harmonics"
    tails = [tail_along(extended.at(z[-1]), z[None, :-1]) for z in curve[:: max(1, len(curve) // LOOKED_AT)]]
    tail = max(tails)
    verdict = tail.verdict(Status.OK if good else Status.NO_CONVERGENCE, message, parameter, fold.omega)
    return FoldCurve(
        path, parameter, curve[:, -1], curve[:, -2], from_blocks(x.T).T, displacement_peaks(x),
        tuple(s[:2] for s in special if s[2]), tuple(s[:2] for s in special if not s[2]), fold.period,
        tail.share, *verdict,
    )  # fmt: skip
