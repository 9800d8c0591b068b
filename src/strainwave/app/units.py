"""Units in which commands, reports and figures show angles and speeds."""

from typing import NamedTuple

from ..sentences import Angle, Quantity
from ..speeds import Speeds
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


class Units(NamedTuple):
    """Units of a face: it renders every sentence with `write`, once."""

    angle: AngleUnit
    speeds: Speeds

    def write(self, quantity: Quantity) -> str:
        """Write the values of a sentence: angles in one unit, speeds of the motor in rpm."""
        unit, factor, digits = self.speeds.unit, self.speeds.scale, 5
        if isinstance(quantity, Angle):
            unit, factor, digits = *self.angle, 4
        elif self.speeds.by_motor:
            unit += " at the motor"
        return quantity.written(lambda value: number(value * factor, min(digits, quantity.digits)), unit)
