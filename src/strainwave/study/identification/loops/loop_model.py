"""Torque along a measured path of torsion: three slopes behind a gap beside Bouc-Wen, in closed form, with derivatives.

Between two reversals the element of Bouc-Wen (A = 1, beta + gamma = 1) depends on the way since the reversal alone.
With a = z/yield_twist along the motion and the way s in yield twists its equation is da/ds = 1 - a^n for a > 0 and
1 + kappa |a|^n for a < 0, kappa = beta - gamma, which n = 1 and n = 2 solve by exponentials and by (hyperbolic)
tangents. The spring has the slope K1 up to the torsion x1 behind the gap, K2 up to x2 and K3 beyond.

What a fitted loop gives: the law, its numbers with their intervals, the candidates compared, the samples.
"""

import math
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ....base.above import above
from ....base.facts import Fact
from ....base.number_text import unit_text
from ....base.records import Along
from ....base.results import Floats, Integers
from ....model.laws.hysteresis import Parallel
from ....model.laws.springs import Play
from ..law_fit import Candidate, LawFit

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


SPRING_UNIT, TORQUE_UNIT, ANGLE_UNIT = "N*m/rad", "N*m", "rad"
UNITS = {
    "K1": SPRING_UNIT, "K2": SPRING_UNIT, "K3": SPRING_UNIT, "T1": TORQUE_UNIT, "T2": TORQUE_UNIT, "K": SPRING_UNIT,
    "torque_offset": TORQUE_UNIT, "half_gap": ANGLE_UNIT, "yield_twist": ANGLE_UNIT, "torsion_offset": ANGLE_UNIT,
    "lost_motion": ANGLE_UNIT, "hysteresis_loss": ANGLE_UNIT, "beta": "", "gamma": "",
}  # fmt: skip
NUMBER_WORDS = {
    "K": "stiffness of the element", "yield_twist": "yield twist", "half_gap": "backlash, half gap",
    "torsion_offset": "offset of the torsion", "torque_offset": "offset of the torque", "lost_motion": "lost motion",
    "hysteresis_loss": "hysteresis loss",
}  # fmt: skip


LoopCandidate = Candidate


@dataclass(frozen=True, eq=False)
class LoopFit(LawFit):
    """A torsion law identified from a measured loop.

    Attributes
    ----------
    law : NamedTuple
        Spring of one to three slopes, behind its backlash (`Play`) and beside its hysteresis (`BoucWen`) as found.
    values : dict of str to float
        Numbers by their path: "K1", "K2", "K3", "T1", "T2", "half_gap", "K", "yield_twist", "beta", "gamma" of the law,
        "torsion_offset", "torque_offset", "lost_motion" and "hysteresis_loss" [rad].
    covariance, freedom, unidentified, comparison, reason, residual_rms, remarks, lack_of_fit
        As of `LawFit`, with errors in blocks left out.
    rated_torque : float
        Torque [N*m] of lost motion (at +-4 % of it) and hysteresis loss (after it).
    cycles : float
        Number of cycles measured.
    energy : float
        Energy [J] that the measured cycles dissipate, as far as they close.
    torsion, torque, fitted : (n,) arrays
        Measured samples [rad], [N*m] and the fitted torque [N*m].
    ratio : float or None
        Ratio of the gear, for `yaml`.
    """

    rows: ClassVar[str] = "sample"
    places: ClassVar[Along] = {"sample": {"torsion": "rad"}}
    units: ClassVar[dict[str, str]] = UNITS
    words: ClassVar[dict[str, str]] = NUMBER_WORDS
    unknown: ClassVar[str] = "the samples are too few to tell whether the law fits"

    rated_torque: float
    cycles: float
    energy: float
    torsion: Floats
    ratio: float | None = None

    @property
    def lost_motion(self) -> float:
        """Lost motion [rad] of the law at +-4 % of the rated torque."""
        return self.values["lost_motion"]

    @property
    def hysteresis_loss(self) -> float:
        """Hysteresis loss [rad] of the law: width of its loop at no torque after the rated torque."""
        return self.values["hysteresis_loss"]

    @property
    def yaml(self) -> str:
        """Block for a project file: gear, backlash, hysteresis, source; without the gear's `ratio` where it lacks."""
        entry = above("project_entry")
        spring = self.law.first if isinstance(self.law, Parallel) else self.law
        gap = f"backlash: {{half_gap: {spring.half_gap!r} rad}}\n" if isinstance(spring, Play) else ""
        spring = spring.law if isinstance(spring, Play) else spring
        ratio = "" if self.ratio is None else f"ratio: {self.ratio:g}, "
        rated = f"rated_torque: {self.rated_torque!r} N*m"
        beside = f"hysteresis: {entry(self.law.second)}\n" if isinstance(self.law, Parallel) else ""
        parts = ("gear.law", *(part.partition(":")[0] for part in (gap, beside) if part))
        measured = ", ".join(f"{part}: measured" for part in parts)
        return f"gear: {{{ratio}law: {entry(spring)}, {rated}}}\n{gap}{beside}sources: {{{measured}}}\n"

    def headline(self) -> str:
        """Fitted law, in one line."""
        return (
            f"Fit of a loop: {len(self.torque)} samples, {self.cycles:.3g} cycle{'' if self.cycles == 1.0 else 's'}, "
            f"up to {np.max(np.abs(self.torque)):.4g} N*m; residual {self.residual_rms:.3g} N*m rms"
        )

    def facts(self) -> tuple[Fact, ...]:
        """Everything that is said of the fit, once, with the intervals of 95 %."""
        lack, heads = self.lack_of_fit, ("number", "value", "from", "to", "unit")
        rows = [(*row, unit_text(unit)) for *row, unit in self.table()]
        lacking = lack and {
            "found": lack.found, "noise_N_m": lack.pure, "missed_N_m": lack.missed, "ratio": lack.ratio,
            "probability": lack.probability,
        }  # fmt: skip
        return (
            Fact("", (self.misses,) if self.misses else (), "{}"),
            Fact("", f"{len(self.torque)} samples, {self.cycles:.3g} cycles; numbers with the interval of 95 %", "{}"),
            Fact("numbers", self.numbers()),
            Fact("", tuple(tuple(map(Fact, [""] * 5, row, heads)) for row in rows), "{}"),
            Fact("unidentified", self.unidentified),
            Fact("", "candidates, by their error [N·m] in blocks of samples left out", "{}"),
            Fact("comparison", tuple(map(Candidate.facts, self.comparison)), "{}"),
            Fact("reason", self.reason), Fact("", self.sentences(), "{}"),
            Fact("rated_torque_N_m", self.rated_torque), Fact("cycles", self.cycles),
            Fact("energy_J", self.energy, "the cycles dissipate {}"),
            Fact("residual_rms_N_m", self.residual_rms, "the residual is {} rms"),
            Fact("samples", len(self.torque)), Fact("lack_of_fit", lacking), Fact("remarks", self.remarks),
            Fact("project", self.yaml),
        )  # fmt: skip
