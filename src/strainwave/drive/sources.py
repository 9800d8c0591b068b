"""Sources of the numbers of a project file, and the units of a drive's own parameters."""

from typing import NamedTuple


class Source(NamedTuple):
    """Origin of a number of a file: "catalogue", "assumed", "yours" or "measured"; `why` is of what it lacks."""

    name: str
    value: str
    word: str = "yours"
    why: str = ""


class DriveUnit(NamedTuple):
    """Unit of a drive's own parameter: the gain of the loop that it sets, its size, and the unit of that."""

    gain: str
    size: float
    unit: str
