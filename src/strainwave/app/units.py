"""Units in which commands, reports and figures show angles and speeds."""

import math
from typing import NamedTuple

from .console import number

RPM = 60.0 / (2.0 * math.pi)
ARCSEC = 180.0 * 3600.0 / math.pi


class AngleUnit(NamedTuple):
    """Unit in which a report shows angles of the output side, and its factor from radians."""

    name: str
    factor: float

    def text(self, rad: float) -> str:
        """Write an angle [rad] with its unit."""
        return f"{number(rad * self.factor)} {self.name}"


def angle_unit(largest: float) -> AngleUnit:
    """One unit for a whole report, by its largest angle [rad]: arcsec up to one degree, then mrad."""
    return AngleUnit("arcsec", ARCSEC) if largest * ARCSEC < 3600.0 else AngleUnit("mrad", 1e3)
