"""What a fitted loop gives: the law, its numbers with their intervals, the candidates compared, the samples."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ....base.above import above
from ....base.records import Labelled
from ....base.results import Floats
from ....model.laws.hysteresis import Parallel
from ....model.laws.springs import Play
from ..law_fit import Candidate, LawFit

SPRING_UNIT, TORQUE_UNIT, ANGLE_UNIT = "N*m/rad", "N*m", "rad"
UNITS = {
    "K1": SPRING_UNIT, "K2": SPRING_UNIT, "K3": SPRING_UNIT, "T1": TORQUE_UNIT, "T2": TORQUE_UNIT, "K": SPRING_UNIT,
    "torque_offset": TORQUE_UNIT, "half_gap": ANGLE_UNIT, "yield_twist": ANGLE_UNIT, "torsion_offset": ANGLE_UNIT,
    "lost_motion": ANGLE_UNIT, "hysteresis_loss": ANGLE_UNIT, "beta": "", "gamma": "",
}  # fmt: skip
SAID = {
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
    units: ClassVar[dict[str, str]] = UNITS
    said: ClassVar[dict[str, str]] = SAID
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
        """Block for a project file: gear, backlash, hysteresis; without the gear's `ratio` where it was not given."""
        entry = above("project_entry")
        spring = self.law.first if isinstance(self.law, Parallel) else self.law
        gap = f"backlash: {{half_gap: {spring.half_gap!r} rad}}\n" if isinstance(spring, Play) else ""
        spring = spring.law if isinstance(spring, Play) else spring
        ratio = "" if self.ratio is None else f"ratio: {self.ratio:g}, "
        rated = f"rated_torque: {self.rated_torque!r} N*m"
        beside = f"hysteresis: {entry(self.law.second)}\n" if isinstance(self.law, Parallel) else ""
        return f"gear: {{{ratio}law: {entry(spring)}, {rated}}}\n{gap}{beside}"

    def coordinates(self) -> Labelled:
        """Measured torsion of every sample."""
        return {"torsion": ("sample", self.torsion, "rad")}

    def headline(self) -> str:
        """What was fitted."""
        return (
            f"Fit of a loop: {len(self.torque)} samples, {self.cycles:.3g} cycle{'' if self.cycles == 1.0 else 's'}, "
            f"up to {np.max(np.abs(self.torque)):.4g} N*m; residual {self.residual_rms:.3g} N*m rms"
        )
