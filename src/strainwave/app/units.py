"""Units in which commands, reports and figures show angles and speeds."""

from typing import NamedTuple

from ..units import ARCSEC
from .console import number


class AngleUnit(NamedTuple):
    """Unit in which a report shows angles of the output side, and its factor from radians."""

    name: str
    factor: float

    def text(self, rad: float) -> str:
        """Write an angle [rad] with its unit."""
        return f"{number(rad * self.factor)} {self.name}"


def angle_unit(largest: float) -> AngleUnit:
    """One unit for a whole report, by its largest angle [rad]: arcsec up to one degree, then mrad."""
    return AngleUnit("arcsec", 1.0 / ARCSEC) if largest / ARCSEC < 3600.0 else AngleUnit("mrad", 1e3)
