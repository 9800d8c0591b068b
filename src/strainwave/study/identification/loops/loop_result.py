"""What a fitted loop gives: the law, its numbers with their intervals, the candidates compared, the samples."""

from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ....base.above import above
from ....base.records import Labelled, Result
from ....base.results import Floats
from ....base.sentences import on_screen
from ....base.units import ARCSEC
from ....model.laws.hysteresis import Parallel
from ....model.laws.springs import Play
from ..fitted import ByName
from ..lack_of_fit import LackOfFit

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


class LoopCandidate(NamedTuple):
    """A candidate law: what it has, its unknowns, and its error in blocks that were left out.

    `error` is the root mean square [N*m] of blocks of samples under the fit to the others, `worse` the mean
    difference of its square from the best candidate's in standard errors of that difference.
    """

    name: str
    unknowns: int
    error: float
    worse: float
    chosen: bool


@dataclass(frozen=True, eq=False)
class LoopFit(ByName, Result):
    """A torsion law identified from a measured loop.

    Attributes
    ----------
    law : NamedTuple
        Spring of one to three slopes, behind its backlash (`Play`) and beside its hysteresis (`BoucWen`) as found.
    values : dict of str to float
        Numbers by their path: "K1", "K2", "K3", "T1", "T2", "half_gap", "K", "yield_twist", "beta", "gamma" of the law,
        "torsion_offset", "torque_offset", "lost_motion" and "hysteresis_loss" [rad].
    covariance : (m, m) array
        Of these numbers, in their order.
    freedom : (m,) array
        Degrees of freedom of their intervals.
    unidentified : dict of str to str
        What the loop does not tell, by its path, each with a sentence.
    comparison : tuple of LoopCandidate
        The candidates by their error in blocks left out, smallest first.
    reason : str
        Why this candidate was chosen.
    rated_torque : float
        Torque [N*m] of lost motion (at +-4 % of it) and hysteresis loss (after it).
    cycles : float
        Number of cycles measured.
    energy : float
        Energy [J] that the measured cycles dissipate, as far as they close.
    residual_rms : float
        Root mean square [N*m] of measured minus fitted torque.
    torsion, torque, fitted : (n,) arrays
        Measured samples [rad], [N*m] and the fitted torque [N*m].
    remarks : tuple of str
        What limits the result.
    ratio : float or None
        Ratio of the gear, for `yaml`.
    lack_of_fit : LackOfFit or None
        What the law misses along the loop beside the noise; None where the samples are too few to tell.
    """

    law: Any
    values: dict[str, float]
    covariance: Floats
    freedom: Floats
    unidentified: dict[str, str]
    comparison: tuple[LoopCandidate, ...]
    reason: str
    rated_torque: float
    cycles: float
    energy: float
    residual_rms: float
    torsion: Floats
    torque: Floats
    fitted: Floats
    remarks: tuple[str, ...]
    ratio: float | None = None
    lack_of_fit: LackOfFit | None = None

    rows: ClassVar[str] = "sample"

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

    def variables(self) -> Labelled:
        """Measured and fitted torque and their difference."""
        return {
            "torque": ("sample", self.torque, "N*m"),
            "fitted": ("sample", self.fitted, "N*m"),
            "residual": ("sample", self.torque - self.fitted, "N*m"),
        }

    def table(self) -> list[tuple[str, float, float, float, str]]:
        """Rows (name, value, low, high, unit) of the numbers, angles in arcmin."""
        found = []
        for name, value in self.values.items():
            low, high = self.interval(name)
            scale, unit = (60.0 * ARCSEC, "arcmin") if UNITS[name] == ANGLE_UNIT else (1.0, UNITS[name])
            found.append((SAID.get(name, name), value / scale, low / scale, high / scale, unit))
        return found

    @property
    def misses(self) -> str:
        """Sentence on what the law misses; empty where nothing shows that it does."""
        return str(self.lack_of_fit) if self.lack_of_fit is not None and self.lack_of_fit.found else ""

    def sentences(self) -> tuple[str, ...]:
        """What the samples do not tell, why this law was taken, what limits the result, whether the law fits."""
        fits = "" if self.misses else str(self.lack_of_fit or "the samples are too few to tell whether the law fits")
        told = (*dict.fromkeys(self.unidentified.values()), self.reason, *self.remarks, fits)
        return tuple(sentence for sentence in told if sentence)

    def __str__(self) -> str:
        lines = [
            f"Fit of a loop: {len(self.torque)} samples, {self.cycles:.3g} cycle{'s' * (self.cycles != 1.0)}, up to "
            f"{np.max(np.abs(self.torque)):.4g} N*m; residual {self.residual_rms:.3g} N*m rms"
        ]
        if self.misses:
            lines.append(f"  {self.misses}")
        for name, value, low, high, unit in self.table():
            lines.append(f"  {name:<26}{value:>12.5g}  ({low:.5g} .. {high:.5g}) {unit}")
        lines += [f"  {sentence}" for sentence in self.sentences()]
        return on_screen("\n".join(lines))
