"""Units in which commands, reports and figures show angles and speeds."""

from typing import Any, NamedTuple

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


def sign(unit: str) -> str:
    """A unit such as "kg*m**2" as it is printed."""
    return unit.replace("**2", "²").replace("**3", "³").replace("*", "·")


def place(speeds: Speeds, omega: float) -> dict[str, Any]:
    """Speed of the base angle and of the motor; None where the base angle is a forcing phase."""
    return {"omega_rad_per_s": omega, "motor_speed_rpm": speeds.rpm(omega)}


def sizes(rad: float | None, name: str = "peak") -> dict[str, Any]:
    """An angle [rad] in radians and in arcsec."""
    return {f"{name}_rad": rad, f"{name}_arcsec": None if rad is None else rad / ARCSEC}
