"""Torque along a measured path of torsion: three slopes behind a gap beside Bouc-Wen, in closed form, with derivatives.

Between two reversals the element of Bouc-Wen (A = 1, beta + gamma = 1) depends on the way since the reversal alone.
With a = z/yield_twist along the motion and the way s in yield twists its equation is da/ds = 1 - a^n for a > 0 and
1 + kappa |a|^n for a < 0, kappa = beta - gamma, which n = 1 and n = 2 solve by exponentials and by (hyperbolic)
tangents. The spring has the slope K1 up to the torsion x1 behind the gap, K2 up to x2 and K3 beyond.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from ....base.results import Floats, Integers

SPRING = ("K1", "K2", "K3", "x1", "x2")
STEP = 1e-6  # of a central difference, relative
FULL_STATE = 1.0 - 1e-12  # of the yield twist: the largest state at a start


class Shape(NamedTuple):
    """Shape of a candidate law: slopes of the spring, a gap, exponent of Bouc-Wen (0: none), whether beta is free.

    A record of several pieces has a state at the start of each.
    """

    slopes: int
    gap: bool
    n: int
    free_beta: bool
    pieces: int = 1

    def starts(self) -> tuple[str, ...]:
        """Names of the states at the starts."""
        return tuple(f"start {i}" for i in range(1, self.pieces + 1)) if self.n else ()

    def names(self) -> tuple[str, ...]:
        """Names of the unknowns, in the order of a vector of them."""
        spring = {1: ("K1",), 2: ("K1", "K2", "x1"), 3: SPRING}[self.slopes]
        element = ("K", "yield_twist", *(("kappa",) if self.free_beta else ()), *self.starts()) if self.n else ()
        gap = ("half_gap",) if self.gap else ()
        # a straight line does not tell the offsets of both axes apart
        offsets = ("torque_offset",) if self.slopes == 1 and not self.gap else ("torsion_offset", "torque_offset")
        return (*spring, *gap, *element, *offsets)

    def named(self, p: Floats) -> dict[str, float]:
        """A vector of the unknowns by their names."""
        return dict(zip(self.names(), p.tolist(), strict=True))

    def __str__(self) -> str:
        spring = {1: "one slope", 2: "two slopes", 3: "three slopes"}[self.slopes]
        beta = "beta fitted" if self.free_beta else "beta = gamma"
        element = f", Bouc-Wen n = {self.n}, {beta}" if self.n else ""
        return spring + (", backlash" if self.gap else "") + element


class Path(NamedTuple):
    """Way of the torsion: for every sample its branch; of every branch its direction and where it begins [rad].

    `first` are the branches that begin a piece of the record, where the state is not that of the branch before.
    """

    branch: Integers
    direction: Floats
    begin: Floats
    first: tuple[int, ...] = (0,)


def state_after(a: Any, s: Any, n: int, kappa: float) -> Any:
    """State a(s) after a way s (...) in yield twists from the state a (...) along the motion."""
    root = math.sqrt(kappa)
    negative = np.minimum(a, 0.0)
    if n == 1:
        to_zero = -negative if kappa < STEP else np.log1p(-kappa * negative) / kappa
        past_zero = np.maximum(s - to_zero, 0.0)
        rising = negative + s if kappa < STEP else (1.0 - (1.0 - kappa * negative) * np.exp(-kappa * s)) / kappa
        settled = 1.0 - (1.0 - np.maximum(a, 0.0)) * np.exp(-past_zero)
    else:
        to_zero = -negative if kappa < STEP else -np.arctan(root * negative) / root
        past_zero = np.maximum(s - to_zero, 0.0)
        short = np.minimum(s, to_zero)
        rising = negative + s if kappa < STEP else np.tan(root * short + np.arctan(root * negative)) / root
        settled = np.tanh(past_zero + np.arctanh(np.minimum(np.maximum(a, 0.0), FULL_STATE)))
    return np.where(s < to_zero, rising, settled)


def states(path: Path, torsion: Floats, n: int, twist: float, kappa: float, starts: Floats) -> Floats:
    """State z/yield_twist (n,) of the element at every sample, along the positive torsion."""
    given, state, begins = dict(zip(path.first, starts, strict=True)), 0.0, np.empty(len(path.direction))
    for j, direction in enumerate(path.direction):
        begins[j] = direction * given.get(j, state)
        if j + 1 < len(begins):
            stroke = direction * (path.begin[j + 1] - path.begin[j]) / twist
            state = direction * min(float(state_after(begins[j], max(stroke, 0.0), n, kappa)), FULL_STATE)
    direction = path.direction[path.branch]
    stroke = np.maximum(direction * (torsion - path.begin[path.branch]), 0.0) / twist
    return np.asarray(direction * state_after(begins[path.branch], stroke, n, kappa))


class Torque(NamedTuple):
    """Torque (n,) [N*m] of a law along a path, its slope over the torsion (n,), and its derivatives (n, p)."""

    value: Floats
    slope: Floats
    jacobian: Floats


def torque(shape: Shape, p: Floats, path: Path, torsion: Floats, names: tuple[str, ...] | None = None) -> Torque:
    """Torque of a candidate law with the unknowns p (p,) along a path, at torsions (n,) [rad].

    Its derivatives are those over all unknowns, or over those that are named.
    """
    names = shape.names() if names is None else names
    values = shape.named(p)
    columns: dict[str, Floats] = {}
    value, slope = _spring(shape, values, torsion - values.get("torsion_offset", 0.0), columns)
    columns["torsion_offset"] = -slope
    columns["torque_offset"] = np.ones_like(torsion)
    if shape.n:
        element, rise = _element(shape, values, path, torsion, columns, names)
        value, slope = value + element, slope + rise
    value = value + values["torque_offset"]
    jacobian = [columns[name] for name in names]
    return Torque(value, slope, np.column_stack(jacobian) if jacobian else np.empty((len(value), 0)))


def _spring(shape: Shape, p: dict[str, float], x: Floats, columns: dict[str, Floats]) -> tuple[Floats, Floats]:
    """Torque and slope of the spring behind its gap, and its derivatives."""
    K1, K2, K3 = p["K1"], p.get("K2", p["K1"]), p.get("K3", p.get("K2", p["K1"]))
    x1, x2 = p.get("x1", math.inf), p.get("x2", math.inf)
    side, depth = np.sign(x), np.abs(x) - p.get("half_gap", 0.0)
    touching = depth > 0.0 if shape.gap else np.ones(len(x), bool)
    depth = np.maximum(depth, 0.0)
    first, below = np.minimum(depth, x1), np.minimum(depth, x2)
    second, third = below - first, depth - below
    slope = np.asarray(np.where(depth > x2, K3, np.where(depth > x1, K2, K1)) * touching, float)
    columns |= {"K1": side * first, "K2": side * second, "K3": side * third, "half_gap": -side * slope}
    columns["x1"] = np.where(depth > x1, side * (K1 - K2), 0.0)
    columns["x2"] = np.where(depth > x2, side * (K2 - K3), 0.0)
    return side * (K1 * first + K2 * second + K3 * third), slope


def _element(
    shape: Shape, p: dict[str, float], path: Path, x: Floats, columns: dict[str, Floats], names: tuple[str, ...]
) -> tuple[Floats, Floats]:
    """Torque and slope of Bouc-Wen, and derivatives over those named: twist, kappa, start by central differences."""
    K, twist, kappa = p["K"], p["yield_twist"], p.get("kappa", 0.0)
    start = np.array([p[name] for name in shape.starts()])

    def z(twist: float, kappa: float, start: Floats) -> Floats:
        return twist * states(path, x, shape.n, twist, kappa, start)

    state = z(twist, kappa, start)
    columns["K"] = state
    if "yield_twist" in names:
        h = STEP * twist
        columns["yield_twist"] = K * (z(twist + h, kappa, start) - z(twist - h, kappa, start)) / (2.0 * h)
    for i, name in enumerate(shape.starts() if shape.starts()[0] in names else ()):
        short, beyond = start.copy(), start.copy()
        short[i], beyond[i] = max(start[i] - STEP, -FULL_STATE), min(start[i] + STEP, FULL_STATE)
        rate = K * (z(twist, kappa, beyond) - z(twist, kappa, short)) / (beyond[i] - short[i])
        # later branches have forgotten the start, or differ by less than rounding
        early = (path.branch >= path.first[i]) & (path.branch <= path.first[i] + 3)
        columns[name] = np.where(early, rate, 0.0)
    if "kappa" in names:
        low, high = max(kappa - 1e-4, 0.0), kappa + 1e-4
        columns["kappa"] = K * (z(twist, high, start) - z(twist, low, start)) / (high - low)
    along = path.direction[path.branch] * state / twist
    slope = K * np.where(along > 0.0, 1.0 - along**shape.n, 1.0 + kappa * np.abs(along) ** shape.n)
    return K * state, np.maximum(slope, 0.0)
