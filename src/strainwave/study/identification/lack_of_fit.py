"""Lack of fit: whether a law misses a measurement by more than its repetitions, or its noise, differ by.

Fisher 1922, J. R. Stat. Soc. 85, 597-612; Draper & Smith 1998, Applied Regression Analysis, 3rd ed., sec. 2.1.
"""

from typing import NamedTuple

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
