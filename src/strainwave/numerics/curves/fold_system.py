"""The equations that a fold satisfies while a second parameter varies, and their continuation.

A fold has a singular Jacobian: besides R(z, p; q) = 0 the scalar g of the bordered system [[J, b], [c', 0]] (v, g) =
(0, 1) vanishes. Its gradient is -w' dJ v with the left vector w, so second derivatives are needed along v alone
(differences of the Jacobian). Arc-length continuation of these n + 1 equations passes cusps, where both parameters
turn.

Govaerts 2000, Numerical Methods for Bifurcations of Dynamical Equilibria, secs. 3.3, 4.1 (minimally extended system).
"""

from typing import Any

import numpy as np

from ...quantities import replace
from ...results import Floats
from ..balance.linear_part import forced
from ..balance.work import linearised, newton
from ..roots import bracketed_root

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
        out = np.empty((n + 1, n + 2))
        out[:n, :n], out[:n, n] = matrix, column
        shift = np.zeros(n + 1)
        shift[:n] = 1e-5 * np.linalg.norm(z[:n]) * v / np.linalg.norm(v)
        change = linearised(problem, z + shift)[1] - linearised(problem, z - shift)[1]
        out[n, :n] = -(w @ change) * np.linalg.norm(v) / (2.0 * np.linalg.norm(shift))
        step = 1e-5 * max(abs(float(z[n])), 1e-6)
        shift[:n], shift[n] = 0.0, step
        change = linearised(problem, z + shift)[1] - linearised(problem, z - shift)[1]
        out[n, n] = -(w @ change @ v) / (2.0 * step)
        step = 1e-5 * max(abs(float(x[-1])), 1e-3 * self.width)
        above, below = linearised(self.at(x[-1] + step), z), linearised(self.at(x[-1] - step), z)
        out[:n, n + 1] = (above[0] - below[0]) / (2.0 * step)
        out[n, n + 1] = -(w @ (above[1] - below[1]) @ v) / (2.0 * step)
        return np.append(r, g), out

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
