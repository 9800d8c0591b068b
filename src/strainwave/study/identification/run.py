"""One run: a measured quantity over the angle of a shaft."""

from dataclasses import dataclass

from ...records import Labelled, Result
from ...results import Floats


@dataclass(frozen=True, eq=False)
class Run(Result):
    """A measured quantity over time and angle.

    Attributes
    ----------
    time, angle : (n,) arrays
        Time [s] and angle of the shaft [rad].
    value : (n,) array
        The quantity.
    unit : str
        Its unit, in SI.
    """

    time: Floats
    angle: Floats
    value: Floats
    unit: str = ""

    rows = "time"

    def coordinates(self) -> Labelled:
        """Times and angles of the samples."""
        return {"time": ("time", self.time, "s"), "angle": ("time", self.angle, "rad")}

    def variables(self) -> Labelled:
        """The quantity over the time."""
        return {"value": ("time", self.value, self.unit)}
