"""One run: a measured quantity over the angle of a shaft."""

from dataclasses import dataclass

from ...results import Floats


@dataclass(frozen=True, eq=False)
class Run:
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
