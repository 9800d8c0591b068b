"""A project with its analysis, and the units in which commands, reports and figures show its angles and speeds."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

from ..base import units
from ..base.number_text import number, rounded
from ..base.sentences import AT_MOTOR, Angle, Quantity, told
from ..base.units import ARCSEC
from ..drive.project import Project
from ..drive.speeds import Speeds
from ..plot.panels import Axis

if TYPE_CHECKING:
    from ..study.analysis.analysis import Analysis


class AngleUnit(NamedTuple):
    """Unit in which a report shows angles of the output side, and its factor from radians."""

    name: str
    factor: float

    def axis(self, name: str) -> Axis:
        """Axis of angles in this unit."""
        return Axis(name, self.name, 1.0 / self.factor)

    def text(self, rad: float, digits: int = 4) -> str:
        """Write an angle [rad] with its unit."""
        return f"{number(rad * self.factor, digits)} {self.name}"


def angle_unit(largest: float) -> AngleUnit:
    """One unit for a whole report, by its largest angle [rad]."""
    name, size = units.angle_unit(largest)
    return AngleUnit(name, 1.0 / size)


def speed_data(speeds: Speeds, omega: float) -> dict[str, Any]:
    """Speed of the base angle and of the motor; None where the base angle is a forcing phase."""
    return {"omega_rad_per_s": omega, "motor_speed_rpm": speeds.rpm(omega)}


def sizes(rad: float | None, name: str = "peak") -> dict[str, Any]:
    """An angle [rad] in radians and in arcsec."""
    return {f"{name}_rad": rad, f"{name}_arcsec": None if rad is None else rad / ARCSEC}


class View(NamedTuple):
    """A project and its analysis, in the units of one report.

    Attributes
    ----------
    project : Project
        The drive, its speeds and what excites it, in SI.
    analysis : Analysis
        Results of the analysis, in SI.
    angle : AngleUnit
        Unit of the angles of the output side: `angle.name`, and `angle.factor` from radians.
    """

    project: Project
    analysis: "Analysis"
    angle: AngleUnit

    @classmethod
    def of(cls, project: Project, analysis: "Analysis") -> "View":
        """View in the unit that suits the largest error."""
        return cls(project, analysis, angle_unit(analysis.largest().peak))

    @property
    def speeds(self) -> Speeds:
        """The speeds of the project: `speeds.unit`, and `speeds.scale` from rad/s of the base angle."""
        return self.project.speeds

    def speed_data(self, omega: float) -> dict[str, Any]:
        """Speed [rad/s] of the base angle as data, and that of the motor [rpm], if it has one."""
        return speed_data(self.speeds, omega)

    def rendered(self, data: object) -> Any:
        """Plain data with every sentence in it rendered in these units."""
        return told(data, self.write)

    def write(self, quantity: Quantity) -> str:
        """Write the values of a sentence: angles in one unit, speeds of the motor in rpm."""
        unit = f"{self.speeds.unit}{AT_MOTOR}" if self.speeds.by_motor else self.speeds.unit
        return writer(self.project, self.angle, unit, self.speeds.scale)(quantity)


def writer(project: Project, angle: AngleUnit, speed: str, scale: float) -> Callable[[Quantity], str]:
    """Function that writes the values of a sentence on a project; `scale` turns rad/s into a unit of speed."""

    def write(quantity: Quantity) -> str:
        unit, factor, digits = (*angle, 4) if isinstance(quantity, Angle) else (speed, scale, 5)
        digits, given = min(digits, quantity.digits), (project.limit, *project.speeds.given, *project.speeds.limits)

        def written(value: float, rounding: int) -> str:
            shown = digits if value in given else project.digits(digits)
            return number(rounded(value * factor, shown, rounding), shown)

        return quantity.written(written, unit)

    return write
