"""A law identified from measured torques: candidates compared, lack of fit, and the numbers of the one that is taken.

Lack of fit: whether a law misses a measurement by more than its repetitions, or its noise, differ by. Fisher 1922,
J. R. Stat. Soc. 85, 597-612; Draper & Smith 1998, Applied Regression Analysis, 3rd ed., sec. 2.1.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ...base.records import Labelled
from ...base.results import Floats
from ...base.sentences import on_screen
from ...base.units import ARCSEC
from .fitted import Fit

WITHIN = 2.0  # standard errors of the difference from the best candidate
RARE = 0.01  # probability below which chance is not believed
SAID = {
    "runs": ("it misses the runs by {} N*m rms, and they differ by", "{} times wider for it", "runs differ by"),
    "loop": (
        "it misses the torque along the loop by {} N*m rms, beside noise of",
        "at least {} times those of the noise alone",
        "the residual along the loop is noise of",
    ),
}  # fmt: skip


class LackOfFit(NamedTuple):
    """What a law misses, beside what repetitions differ by.

    Attributes
    ----------
    pure : float
        Root mean square [N*m] by which a run differs from others at its speed and load; of a loop its noise.
    missed : float
        The same of what the law misses: of runs as it would be with pure error alone, of a loop that along the torsion.
    ratio : float
        Mean square of what the law misses over that which pure error gives it (F).
    probability : float
        Of a ratio as large by chance.
    of : str
        What the law was fitted to: "runs", "loop".
    """

    pure: float
    missed: float
    ratio: float
    probability: float
    of: str = "runs"

    @property
    def found(self) -> bool:
        """Whether the law does not fit."""
        return self.probability < RARE

    def __str__(self) -> str:
        misses, wider, pure = SAID[self.of]
        chance = f"(probability {self.probability:.2g})"
        if not self.found:
            return f"no lack of fit: {pure} {self.pure:.3g} N*m rms {chance}"
        return (
            f"the law does not fit: {misses.format(f'{self.missed:.3g}')} {self.pure:.3g} N*m {chance}; the intervals "
            f"are {wider.format(f'{self.ratio**0.5:.3g}')}, and do not hold what the law lacks"
        )


class Candidate(NamedTuple):
    """A candidate law: what it has, its unknowns, and its error on samples or runs that were left out.

    `error` is the root mean square [N*m] under the fit to the others, `worse` the mean difference of its square from
    the best candidate's in standard errors of that difference.
    """

    name: str
    unknowns: int
    error: float
    worse: float
    chosen: bool


def compared(
    fits: Sequence[tuple[str, int]], errors: Floats, unit: float, place: str, most: float = math.inf
) -> tuple[int, tuple[Candidate, ...], str]:
    """The simplest candidate within two standard errors of the best, the table, and the reason.

    Parameters
    ----------
    fits : sequence of (str, int)
        Name and number of unknowns of every candidate.
    errors : (candidates, m) array
        Squared errors of parts that were left out.
    unit : float
        Of their roots [N*m].
    place : str
        What was left out, in words.
    most : float
        Mean squared error of the best up to which others are near it, relative.
    """
    means = errors.mean(axis=1)
    best = int(np.argmin(means))
    difference = errors - errors[best]
    spreads = np.std(difference, axis=1, ddof=1) / np.sqrt(errors.shape[1])
    worse = np.divide(difference.mean(axis=1), spreads, out=np.zeros(len(fits)), where=spreads > 0.0)
    near = np.flatnonzero((worse <= WITHIN) & (means <= most))
    choice = min(near.tolist(), key=lambda i: (fits[i][1], means[i]))
    rows = tuple(
        Candidate(fits[i][0], fits[i][1], unit * float(means[i]) ** 0.5, float(worse[i]), i == choice)
        for i in np.argsort(means, kind="stable").tolist()
    )
    said = f"{fits[choice][0]}: error {unit * means[choice] ** 0.5:.3g} N*m {place}"
    if choice == best:
        return choice, rows, f"{said}, the smallest of {len(fits)} candidates"
    return choice, rows, (
        f"{said}, within two standard errors of the smallest, {unit * means[best] ** 0.5:.3g} N*m, of {fits[best][0]}, "
        f"which has {fits[best][1] - fits[choice][1]} more unknowns"
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class LawFit(Fit):
    """A law identified from measured torques, the best of several candidates.

    Attributes
    ----------
    law : NamedTuple
        As found.
    values : dict of str to float
        Numbers by their path.
    covariance : (m, m) array
        Of these numbers, in their order.
    freedom : (m,) array
        Degrees of freedom of their intervals.
    unidentified : dict of str to str
        What the measurement does not tell, by its path, each with a sentence.
    comparison : tuple of Candidate
        The candidates by their error in what was left out, smallest first.
    reason : str
        Why this candidate was chosen.
    residual_rms : float
        Root mean square [N*m] of measured minus fitted torque.
    torque, fitted : (n,) arrays
        Measured and fitted torque [N*m].
    remarks : tuple of str
        What limits the result.
    lack_of_fit : LackOfFit or None
        What the law misses beside noise or repetitions; None where that is not known.
    """

    units: ClassVar[dict[str, str]]
    said: ClassVar[dict[str, str]] = {}
    unknown: ClassVar[str]  # sentence where it is not known whether the law fits

    law: Any
    values: dict[str, float]
    covariance: Floats
    freedom: Floats
    unidentified: dict[str, str]
    comparison: tuple[Candidate, ...]
    reason: str
    residual_rms: float
    torque: Floats
    fitted: Floats
    remarks: tuple[str, ...]
    lack_of_fit: LackOfFit | None

    def variables(self) -> Labelled:
        """Measured and fitted torque and their difference."""
        columns = {"torque": self.torque, "fitted": self.fitted, "residual": self.torque - self.fitted}
        return {name: (self.rows, values, "N*m") for name, values in columns.items()}

    def table(self) -> list[tuple[str, float, float, float, str]]:
        """Rows (name, value, low, high, unit) of the numbers, angles in arcmin."""
        found = []
        for name, value in self.values.items():
            low, high = self.interval(name)
            scale, unit = (60.0 * ARCSEC, "arcmin") if self.units[name] == "rad" else (1.0, self.units[name])
            found.append((self.said.get(name, name), value / scale, low / scale, high / scale, unit))
        return found

    @property
    def misses(self) -> str:
        """Sentence on what the law misses; empty where nothing shows that it does."""
        return str(self.lack_of_fit) if self.lack_of_fit is not None and self.lack_of_fit.found else ""

    def sentences(self) -> tuple[str, ...]:
        """What the measurement does not tell, why this law was taken, what limits the result, whether the law fits."""
        fits = "" if self.misses else str(self.lack_of_fit or self.unknown)
        told = (*dict.fromkeys(self.unidentified.values()), self.reason, *self.remarks, fits)
        return tuple(sentence for sentence in told if sentence)

    def headline(self) -> str:
        """What was fitted."""
        return f"{type(self).__name__}: residual {self.residual_rms:.3g} N*m rms"

    def __str__(self) -> str:
        lines = [self.headline(), *([f"  {self.misses}"] if self.misses else [])]
        for name, value, low, high, unit in self.table():
            lines.append(f"  {name:<26}{value:>12.5g}  ({low:.5g} .. {high:.5g}) {unit}".rstrip())
        return on_screen("\n".join([*lines, *(f"  {sentence}" for sentence in self.sentences())]))
