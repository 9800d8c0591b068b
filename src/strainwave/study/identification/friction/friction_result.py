"""What fitted friction gives: the law, its numbers with their intervals, the candidates compared, the runs."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

from ....records import Labelled, Result
from ....results import Floats
from ....sentences import on_screen
from ..fitted import ByName
from ..intervals import Interval, interval
from ..lack_of_fit import LackOfFit

UNITS = {
    "T_c": "N*m", "T_s": "N*m", "v_s": "rad/s", "B": "N*m*s/rad", "mu": "", "offset": "N*m", "sigma_0": "N*m/rad",
    "B_asymmetry": "N*m*s/rad", "D": "N*m*s^2/rad^2", "drift": "N*m", "T_c_forward": "N*m", "T_c_backward": "N*m",
}  # fmt: skip
BY_LOGARITHM = ("v_s", "sigma_0")  # scales: their interval is one of the logarithm


class FrictionCandidate(NamedTuple):
    """A candidate: its terms, its unknowns, and its error on runs that were left out.

    `error` is the root mean square [N*m], `worse` the mean difference of its square from the best candidate's in
    standard errors of that difference.
    """

    name: str
    unknowns: int
    error: float
    worse: float
    chosen: bool


@dataclass(frozen=True, eq=False)
class FrictionFit(ByName, Result):
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
    covariance : (m, m) array
        Of these numbers, in their order.
    freedom : (m,) array
        Degrees of freedom of their intervals.
    unidentified : dict of str to str
        What the runs do not tell, by its path, each with a sentence.
    comparison : tuple of FrictionCandidate
        The candidates by their error on runs left out, smallest first.
    reason : str
        Why this candidate was chosen.
    residual_rms : float
        Root mean square [N*m] of measured minus fitted torque.
    speed, torque, fitted : (n,) arrays
        Runs [rad/s], [N*m] and the fitted torque [N*m]; break-away at speed 0.
    remarks : tuple of str
        What limits the result.
    lack_of_fit : LackOfFit or None
        What the law misses beside what repeated runs differ by; None where no runs were repeated.
    """

    law: Any
    load_friction: Any
    values: dict[str, float]
    covariance: Floats
    freedom: Floats
    unidentified: dict[str, str]
    comparison: tuple[FrictionCandidate, ...]
    reason: str
    residual_rms: float
    speed: Floats
    torque: Floats
    fitted: Floats
    remarks: tuple[str, ...]
    lack_of_fit: LackOfFit | None = None

    rows: ClassVar[str] = "run"

    def interval(self, path: str, level: float = 0.95) -> Interval:
        """Interval (low, high) in SI that holds a number with the probability `level`; errors as `value`."""
        name = self._name(path)
        value, freedom = self.values[name], float(self.freedom[list(self.values).index(name)])
        if name in BY_LOGARITHM:
            low, high = interval(math.log(value), self.deviation(name) / value, freedom, level)
            return Interval(math.exp(max(low, -600.0)), math.exp(min(high, 600.0)))
        return super().interval(name, level)

    def _name(self, path: str) -> str:
        name = str(path).rpartition(".")[2]
        return super()._name({"sigma_2": "B"}.get(name, name))

    def coordinates(self) -> Labelled:
        """Speed of every run."""
        return {"speed": ("run", self.speed, "rad/s")}

    def variables(self) -> Labelled:
        """Measured and fitted torque and their difference."""
        return {
            "torque": ("run", self.torque, "N*m"),
            "fitted": ("run", self.fitted, "N*m"),
            "residual": ("run", self.torque - self.fitted, "N*m"),
        }

    def __str__(self) -> str:
        lines = [f"Fit of friction: {len(self.speed)} runs; residual {self.residual_rms:.3g} N*m rms"]
        if self.lack_of_fit is not None and self.lack_of_fit.found:
            lines.append(f"  {self.lack_of_fit}")
        for name, value in self.values.items():
            low, high = self.interval(name)
            lines.append(f"  {name:<14}{value:>12.5g}  ({low:.5g} .. {high:.5g}) {UNITS[name]}".rstrip())
        lines += [f"  {sentence}" for sentence in (*self.unidentified.values(), self.reason, *self.remarks)]
        if self.lack_of_fit is None:
            lines.append("  no runs were repeated: whether the law fits is not known")
        elif not self.lack_of_fit.found:
            lines.append(f"  {self.lack_of_fit}")
        return on_screen("\n".join(lines))

    __repr__ = __str__
