"""Friction torque over the speed as a sum of terms, each in or out: least squares with one nonlinear unknown, v_s.

s is the direction of sliding: T = s (T_c + (T_s - T_c) exp(-(v/v_s)^2) + mu |load|) + B v + offset + B_asymmetry |v|.
Beside it stand D v |v| and s drift t, with t from 0 in the first run to 1 in the last. The offset is what the
directions differ by: T_c + offset forward, T_c - offset backward. Break-away torques are samples at no speed, t = 0.5.

Lack of fit: whether a law misses the means of repeated runs by more than these runs differ. What fitted friction gives:
the law, its numbers with their intervals, the candidates compared, the runs.
"""

from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar
from scipy.special import fdtrc, gammaincc

from ...base.records import Along
from ...base.results import Floats
from .law_fit import Candidate, LackOfFit, LawFit

FEWEST = 3  # degrees of freedom of the pure error
APART = 1e-3  # of the largest: speeds or loads that differ by less are one

GRID = 25  # Stribeck speeds tried
FINEST = 1e-10
NEAR, COARSE = 3.0, 1e-3  # how far from a Stribeck speed that of some of the runs may lie, and how well it is found

UNITS = {
    "T_c": "N*m", "T_s": "N*m", "v_s": "rad/s", "B": "N*m*s/rad", "mu": "", "offset": "N*m", "sigma_0": "N*m/rad",
    "B_asymmetry": "N*m*s/rad", "D": "N*m*s^2/rad^2", "drift": "N*m", "T_c_forward": "N*m", "T_c_backward": "N*m",
}  # fmt: skip


FrictionCandidate = Candidate


@dataclass(frozen=True, eq=False)
class FrictionFit(LawFit):
    """Friction identified from constant-speed runs.

    Attributes
    ----------
    law : NamedTuple
        Drag without load: `Coulomb` or `Stribeck`, with `Viscous`; `LuGre` where a presliding loop was given; with
        `QuadraticDamping`.
    load_friction : LoadFriction or None
        What is proportional to the transmitted torque, where the runs support it.
    values : dict of str to float
        Numbers by their path, as found: "T_c", "T_s", "v_s", "B", "D", "mu", "sigma_0", "offset", "B_asymmetry",
        "drift" (of dry friction from the first run to the last), "T_c_forward", "T_c_backward".
    covariance, freedom, unidentified, comparison, reason, residual_rms, remarks, lack_of_fit
        As of `LawFit`, with errors on runs left out.
    speed, torque, fitted : (n,) arrays
        Runs [rad/s], [N*m] and the fitted torque [N*m]; break-away at speed 0.
    """

    rows: ClassVar[str] = "run"
    places: ClassVar[Along] = {"run": {"speed": "rad/s"}}
    units: ClassVar[dict[str, str]] = UNITS
    unknown: ClassVar[str] = "no runs were repeated: whether the law fits is not known"
    by_logarithm: ClassVar[tuple[str, ...]] = ("v_s", "sigma_0")

    load_friction: Any
    speed: Floats

    def _name(self, path: str) -> str:
        name = str(path).rpartition(".")[2]
        return super()._name({"sigma_2": "B"}.get(name, name))

    def headline(self) -> str:
        """What was fitted."""
        return f"Fit of friction: {len(self.speed)} runs; residual {self.residual_rms:.3g} N*m rms"


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


UNKNOWNS = (
    "B",
    "rise",
    "mu",
    "offset",
    "B_asymmetry",
    "D",
    "drift",
    "v_s",
)  # of the terms, and the speed of `stribeck`
WORDS = ("viscous", "Stribeck", "load-proportional", "sides differ", "viscous sides differ", "quadratic", "drift")


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
        return ("T_c", *(name for name, there in zip(UNKNOWNS, (*self, self.stribeck), strict=True) if there))

    def named(self, p: Floats) -> dict[str, float]:
        """A vector of the unknowns by their names."""
        return dict(zip(self.names(), p.tolist(), strict=True))

    def __str__(self) -> str:
        return ", ".join(["Coulomb", *(name for name, there in zip(WORDS, self, strict=True) if there)])


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


def solve_terms(terms: Terms, runs: Runs, guess: float | None = None) -> FrictionSolution:
    """Fit a candidate: linear least squares, in the Stribeck speed a search over its logarithm, or near a value."""
    target = runs.weight * runs.torque

    def fit(v_s: float) -> FrictionSolution:
        A = runs.weight[:, None] * columns(terms, runs, v_s)
        p = np.asarray(np.linalg.lstsq(A, target, rcond=None)[0], float)
        return FrictionSolution(terms, p, target - A @ p, A)

    def cost(logarithm: float) -> float:
        miss = fit(float(np.exp(logarithm))).residual
        return float(miss @ miss)

    if not terms.stribeck:
        return fit(1.0)
    sizes, finest = np.abs(runs.speed[runs.speed != 0.0]), FINEST
    if guess is None:
        tried = np.linspace(np.log(0.5 * np.min(sizes)), np.log(np.max(sizes)), GRID)
        best = int(np.argmin(list(map(cost, tried))))
        ends = float(tried[max(best - 1, 0)]), float(tried[min(best + 1, GRID - 1)])
    else:
        ends, finest = (np.log(guess / NEAR), np.log(guess * NEAR)), COARSE
    v_s = float(np.exp(minimize_scalar(cost, bounds=ends, method="bounded", options={"xatol": finest}).x))
    solution, share = fit(v_s), (runs.speed / v_s) ** 2
    along = solution.p[terms.names().index("rise")] * runs.side * np.exp(-share) * 2.0 * share / v_s
    jacobian = np.column_stack([solution.jacobian, runs.weight * along])
    return solution._replace(p=np.append(solution.p, v_s), jacobian=jacobian)


def lack_of_fit(fit: FrictionSolution, runs: Runs, known: bool) -> LackOfFit | None:
    """Test a candidate against repeated runs, or runs of known standard errors; None where runs are too few."""
    residual, unit = fit.residual, 1.0 / float(np.median(runs.weight))
    if known:
        freedom = len(residual) - len(fit.p)
        square = float(residual @ residual)
        ratio = square / freedom
        return LackOfFit(unit, unit * ratio**0.5, ratio, float(gammaincc(0.5 * freedom, 0.5 * square)))
    group = _groups(runs)
    count = np.bincount(group)
    means = np.bincount(group, residual) / count
    pure, missed = float(np.sum((residual - means[group]) ** 2)), float(np.sum(count * means**2))
    own, other = len(residual) - len(count), len(count) - len(fit.p)
    if own < FEWEST or other < 1 or not pure > 0.0:
        return None
    ratio = missed / other / (pure / own)
    return LackOfFit(unit * (pure / own) ** 0.5, unit * (missed / other) ** 0.5, ratio, float(fdtrc(other, own, ratio)))


def _groups(runs: Runs) -> NDArray[np.int64]:
    """Number (n,) of the group of runs at one speed and load that every run belongs to."""
    columns = []
    for values in (runs.speed, runs.load, runs.side):
        order = np.argsort(values)
        steps = np.diff(values[order], prepend=values[order][0]) > APART * float(np.max(np.abs(values), initial=0.0))
        place = np.empty(len(values), int)
        place[order] = np.cumsum(steps)
        columns.append(place)
    return np.asarray(np.unique(np.column_stack(columns), axis=0, return_inverse=True)[1], np.int64).ravel()
