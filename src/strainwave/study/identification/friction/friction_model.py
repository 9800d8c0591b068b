"""Friction torque over the speed as a sum of terms, each in or out: least squares with one nonlinear unknown, v_s.

s is the direction of sliding: T = s (T_c + (T_s - T_c) exp(-(v/v_s)^2) + mu |load|) + B v + offset + B_asymmetry |v|.
Beside it stand D v |v| and s drift t, with t from 0 in the first run to 1 in the last. The offset is what the
directions differ by: T_c + offset forward, T_c - offset backward. Break-away torques are samples at no speed, t = 0.5.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from ....results import Floats

GRID = 25  # Stribeck speeds tried
FINEST = 1e-10
NEAR, COARSE = 3.0, 1e-3  # how far from a Stribeck speed that of some of the runs may lie, and how well it is found


class Runs(NamedTuple):
    """Constant-speed runs (n,): speed [rad/s], direction, torque [N*m], size of the load [N*m], weight [1/(N*m)], time.

    The time is the place among the runs, from 0 to 1.
    """

    speed: Floats
    side: Floats
    torque: Floats
    load: Floats
    weight: Floats
    time: Floats

    def some(self, keep: Floats) -> "Runs":
        """The runs that a mask keeps."""
        return Runs(*(column[keep] for column in self))


class Terms(NamedTuple):
    """What a candidate has beside dry friction."""

    viscous: bool
    stribeck: bool
    load: bool
    offset: bool
    viscous_sides: bool
    quadratic: bool = False
    drift: bool = False

    def names(self) -> tuple[str, ...]:
        """Names of the unknowns, in the order of a vector of them: the linear ones, then v_s."""
        given = ("B", self.viscous), ("rise", self.stribeck), ("mu", self.load), ("offset", self.offset)
        beside = ("B_asymmetry", self.viscous_sides), ("D", self.quadratic), ("drift", self.drift)
        more = (*given, *beside, ("v_s", self.stribeck))
        return ("T_c", *(name for name, there in more if there))

    def __str__(self) -> str:
        said = (
            "viscous", "Stribeck", "load-proportional", "sides differ", "viscous sides differ", "quadratic", "drift",
        )  # fmt: skip
        return ", ".join(["Coulomb", *(name for name, there in zip(said, self, strict=True) if there)])


class FrictionSolution(NamedTuple):
    """A candidate fitted: unknowns p (p,), weighted residual (n,) and Jacobian (n, p)."""

    terms: Terms
    p: Floats
    residual: Floats
    jacobian: Floats


def columns(terms: Terms, runs: Runs, v_s: float) -> Floats:
    """Columns (n, p) of the linear unknowns at a Stribeck speed [rad/s]."""
    found = {
        "T_c": runs.side, "B": runs.speed, "rise": runs.side * np.exp(-((runs.speed / v_s) ** 2)),
        "mu": runs.side * runs.load, "offset": np.ones_like(runs.speed), "B_asymmetry": np.abs(runs.speed),
        "D": runs.speed * np.abs(runs.speed), "drift": runs.side * runs.time,
    }  # fmt: skip
    return np.column_stack([found[name] for name in terms.names() if name != "v_s"])


def predicted(terms: Terms, p: Floats, runs: Runs) -> Floats:
    """Torque (n,) [N*m] of a candidate."""
    linear, v_s = (p[:-1], float(p[-1])) if terms.stribeck else (p, 1.0)
    return np.asarray(columns(terms, runs, v_s) @ linear)


def solve_terms(terms: Terms, runs: Runs, near: float | None = None) -> FrictionSolution:
    """Fit a candidate: linear least squares, in the Stribeck speed a search over its logarithm, or near a value."""
    target = runs.weight * runs.torque

    def at(v_s: float) -> tuple[Floats, float]:
        A = runs.weight[:, None] * columns(terms, runs, v_s)
        p = np.asarray(np.linalg.lstsq(A, target, rcond=None)[0], float)
        miss = target - A @ p
        return p, float(miss @ miss)

    if not terms.stribeck:
        p = at(1.0)[0]
        A = runs.weight[:, None] * columns(terms, runs, 1.0)
        return FrictionSolution(terms, p, target - A @ p, A)
    sizes, finest = np.abs(runs.speed[runs.speed != 0.0]), FINEST
    if near is None:
        tried = np.linspace(np.log(0.5 * np.min(sizes)), np.log(np.max(sizes)), GRID)
        best = int(np.argmin([at(float(np.exp(u)))[1] for u in tried]))
        ends = float(tried[max(best - 1, 0)]), float(tried[min(best + 1, GRID - 1)])
    else:
        ends, finest = (np.log(near / NEAR), np.log(near * NEAR)), COARSE
    found = minimize_scalar(lambda u: at(float(np.exp(u)))[1], bounds=ends, method="bounded", options={"xatol": finest})
    v_s = float(np.exp(found.x))
    linear = at(v_s)[0]
    rise = linear[terms.names().index("rise")]
    share = (runs.speed / v_s) ** 2
    along = rise * runs.side * np.exp(-share) * 2.0 * share / v_s
    A = runs.weight[:, None] * columns(terms, runs, v_s)
    return FrictionSolution(
        terms, np.append(linear, v_s), target - A @ linear, np.column_stack([A, runs.weight * along])
    )
