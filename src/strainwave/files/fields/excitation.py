"""The group `excitation` of a project file: lines of the kinematic error, torques of the motor and the load."""

import math
from collections.abc import Iterator
from typing import Any

from ...model.excitation import Line
from .kinds import PHASE, Either, Items, Quantity, Whole, Wrong
from .rows import Fields, Group, field, needed, rows_of

MOST_LINES = 64
CATALOGUE = "catalogue"  # in place of an accuracy: the one that the gear's record gives
LINE = "{order: 2, amplitude: 23 arcsec}"
TORQUE_LINE = "{order: 1, amplitude: 0.1 N*m}"
TORQUE = Quantity("N*m")
ORDER = Whole(
    1, 1000, "write how often the line repeats per turn, for example 2",
    "is not between 1 and 1000; a constant part belongs in 'mean'",
)  # fmt: skip


def ascending(low: float, high: float, what: str) -> Iterator[Wrong]:
    """Refuse a range whose end is not above its begin."""
    if low >= high:
        yield Wrong(("to",), f"the range does not ascend; write the smaller {what} after 'from'")


class ErrorLine(Group):
    """One line of the kinematic error."""

    order: int = needed(ORDER, "2", "How often the line repeats per turn of the base angle.")
    amplitude: float = needed(Quantity("rad", "not negative"), "23 arcsec", "Amplitude of the line, 0-to-peak.")
    phase: float = field(PHASE, "90 deg", "Phase of its cosine.", 0.0)

    @property
    def line(self) -> Line:
        """The line as an object of the model."""
        return Line(self.order, self.amplitude, self.phase)

    @classmethod
    def of(cls, line: Any) -> "ErrorLine":
        """A line with a size, the phase moved by half a turn where the amplitude is negative."""
        phase = line.phase if line.amplitude >= 0.0 else line.phase + math.pi
        return cls(order=line.order, amplitude=abs(line.amplitude), phase=phase or None)


class TorqueLine(ErrorLine):
    """One line of a torque."""

    order: int = rows_of(ErrorLine)["order"]._replace(example="1")  # type: ignore[assignment]
    amplitude: float = needed(Quantity("N*m", "not negative"), "0.1 N*m", "Amplitude of the line, 0-to-peak.")


class TorqueRange(Group):
    """A mean torque that lies anywhere between two, as that of gravity on an arm does."""

    from_: float = needed(TORQUE, "-60 N*m", "Lower end of the range.")
    to: float = needed(TORQUE, "60 N*m", "Upper end of the range.")

    def check(self) -> Iterator[Wrong]:
        """Refuse a range that does not ascend."""
        return ascending(self.from_, self.to, "torque")


class TorqueSpec(Group):
    """Torque on a free motor, on the motor side."""

    mean: float | TorqueRange = field(TORQUE, "5 N*m", "Mean of the torque.", 0.0)
    lines: tuple[TorqueLine, ...] = field(Items(Fields(TorqueLine), most=MOST_LINES), f"[{TORQUE_LINE}]",
        "Lines of the torque.", ())  # fmt: skip

    @property
    def range(self) -> tuple[float, float] | None:
        """Least and largest mean [N*m] where the file gives a range of them."""
        return (self.mean.from_, self.mean.to) if isinstance(self.mean, TorqueRange) else None


class LoadTorqueSpec(TorqueSpec):
    """Torque on the load, on the output side; a resisting torque is negative."""

    mean: float | TorqueRange = field(Either(TORQUE, Fields(TorqueRange)), "{from: -60 N*m, to: 60 N*m}",
        "Mean of the torque, or the range in which it lies, as for gravity on an arm.", 0.0)  # fmt: skip


class ExcitationSpec(Group):
    """What drives the error; something periodic must be there."""

    accuracy: float | str | None = field(Quantity("rad", "positive", CATALOGUE), "1 arcmin",
        "Accuracy of the gear, peak-to-peak, in place of lines; catalogue for that of its record.")  # fmt: skip
    kinematic_error: tuple[ErrorLine, ...] = field(Items(Fields(ErrorLine), most=MOST_LINES), f"[{LINE}]",
        "Lines of the kinematic error, on the output side.", ())  # fmt: skip
    motor_torque: TorqueSpec | None = field(TorqueSpec, f"{{mean: 5 N*m, lines: [{TORQUE_LINE}]}}")
    load_torque: LoadTorqueSpec | None = field(LoadTorqueSpec, f"{{mean: 5 N*m, lines: [{TORQUE_LINE}]}}")
