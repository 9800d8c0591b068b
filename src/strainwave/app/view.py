"""What a report is about and the units in which it tells it: the one argument of its sections and figures."""

from typing import Any, NamedTuple

from ..files.project import Project
from ..sentences import Angle, Quantity, told
from ..speeds import Speeds
from ..study.analysis.analysis import Analysis
from .console import number
from .units import AngleUnit, angle_unit, place


class View(NamedTuple):
    """A project and its analysis, in the units of one report.

    Attributes
    ----------
    project : Project
        The drive, its speeds and what excites it, in SI.
    analysis : Analysis
        What was computed, in SI.
    angle : AngleUnit
        Unit of the angles of the output side: `angle.name`, and `angle.factor` from radians.
    """

    project: Project
    analysis: Analysis
    angle: AngleUnit

    @classmethod
    def of(cls, project: Project, analysis: Analysis) -> "View":
        """View in the unit that suits the largest error."""
        return cls(project, analysis, angle_unit(analysis.largest().peak))

    @property
    def speeds(self) -> Speeds:
        """The speeds of the project: `speeds.unit`, and `speeds.scale` from rad/s of the base angle."""
        return self.project.speeds

    def place(self, omega: float) -> dict[str, Any]:
        """Speed [rad/s] of the base angle as data, and that of the motor [rpm], if it has one."""
        return place(self.speeds, omega)

    def told(self, data: Any) -> Any:
        """Plain data with every sentence in it rendered in these units."""
        return told(data, self.write)

    def write(self, quantity: Quantity) -> str:
        """Write the values of a sentence: angles in one unit, speeds of the motor in rpm."""
        unit, factor, digits = self.speeds.unit, self.speeds.scale, 5
        if isinstance(quantity, Angle):
            unit, factor, digits = *self.angle, 4
        elif self.speeds.by_motor:
            unit += " at the motor"
        return quantity.written(lambda value: number(value * factor, min(digits, quantity.digits)), unit)
