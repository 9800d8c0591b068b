"""Result of a fitted loop: the law, its numbers with their intervals, the candidates compared, the samples."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ....base.above import above
from ....base.facts import Fact
from ....base.number_text import unit_text
from ....base.records import Along
from ....base.results import Floats
from ....model.laws.hysteresis import Parallel
from ....model.laws.springs import Play
from ..law_fit import LawFit, LoopCandidate

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
    unknown: ClassVar[str] = "too few samples to test whether the law fits"

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
            Fact("", f"{len(self.torque)} samples, {self.cycles:.3g} cycles; values with 95 % intervals", "{}"),
            Fact("numbers", self.numbers()),
            Fact("", tuple(tuple(map(Fact, [""] * 5, row, heads)) for row in rows), "{}"),
            Fact("unidentified", self.unidentified),
            Fact("", "candidate laws by prediction error [N·m] on omitted blocks of samples", "{}"),
            Fact("comparison", tuple(map(LoopCandidate.facts, self.comparison)), "{}"),
            Fact("reason", self.reason), Fact("", self.sentences(), "{}"),
            Fact("rated_torque_N_m", self.rated_torque), Fact("cycles", self.cycles),
            Fact("energy_J", self.energy, "the cycles dissipate {}"),
            Fact("residual_rms_N_m", self.residual_rms, "the residual is {} rms"),
            Fact("samples", len(self.torque)), Fact("lack_of_fit", lacking), Fact("remarks", self.remarks),
            Fact("project", self.yaml),
        )  # fmt: skip
