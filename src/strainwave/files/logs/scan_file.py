"""A measured error scan in a text table, as `read_log` reads it: a line of column names with units, a line per sample.

Every unit must stand in the column's name, `angle [deg]` or `angle (deg)`, or beside the name that the caller gives.
"""

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...base.results import Floats
from ..yaml_text import FileError
from .names import named
from .table import read_table, rising_columns

OURS, VENDORS, BACKWARD, ANGLE = "error", "ate", "backward", "angle"
HINT = "name the columns with their units: angle [deg], error [arcsec], or give --angle, --error, --backward"
ASCEND = "angles must ascend: average repeated ones, the way back is a file of its own (--back)"


@dataclass(frozen=True, eq=False)
class ScanFile:
    """Samples of a scan file, angles ascending.

    Attributes
    ----------
    angle, error : (n,) arrays
        Angle of the file's shaft and error theta_m/N - theta_l [rad].
    backward : (n,) array or None
        Error in the other direction of rotation at the same angles, where the file has such a column.
    last : int
        Line of the last sample.
    """

    angle: Floats
    error: Floats
    backward: Floats | None
    last: int

    def __str__(self) -> str:
        each = "each direction" if self.backward is not None else "one direction"
        return (
            f"Scan file: {len(self.angle)} samples in {each}, {self.angle[0]:.6g} .. {self.angle[-1]:.6g} rad\n"
            f"  error {np.min(self.error):.4g} .. {np.max(self.error):.4g} rad"
        )

    __repr__ = __str__


def read_scan(
    path: str | os.PathLike[str],
    *,
    angle: str = ANGLE,
    error: str | None = None,
    backward: str | None = None,
    ate: bool = False,
    delimiter: str | None = None,
    decimal: str | None = None,
    reverse: bool = False,
) -> ScanFile:
    """Read a measured error scan.

    Parameters
    ----------
    path : str or Path
        Text in any dialect that `read_log` reads; lines above the names of the columns are left out.
    angle, error, backward : str, optional
        Names of the columns, with their units where the file does not give them: "Winkel [deg]". Default: `angle`,
        `error` (theta_m/N - theta_l) or `ate` (vendors' theta_l - theta_m/N), and `backward` if there is one.
    ate : bool
        True where the named columns hold the vendors' error; a column called `ate` does.
    delimiter, decimal : str, optional
        Column separator and decimal sign. Default: those with which the text is a table; where this is so in two ways,
        the file is refused.
    reverse : bool
        True for a run in the backward direction, whose angles may descend throughout.

    Returns
    -------
    ScanFile
        `angle`, ascending, `error` and `backward` (None without that column): (n,) arrays [rad].

    Raises
    ------
    FileError
        If the file cannot be read, a column or its unit is missing, a number is wrong, or angles do not ascend; a
        ValueError with one line, `file:line:column: field: fact, value, remedy`.
    """
    path = Path(path)
    fields = {ANGLE: angle, OURS: error, BACKWARD: backward}
    file, _, lines = read_table(path, delimiter, decimal, kind="scan file")
    names = [named(column.name).name for column in file]
    vendors = error is None and OURS not in names and VENDORS in names
    fields[OURS] = error or (VENDORS if vendors else OURS)
    fields[BACKWARD] = backward or (BACKWARD if BACKWARD in names else None)
    requested = {field: (text, "rad") for field, text in fields.items() if text is not None}
    columns = rising_columns(path, file, lines, requested, HINT, ASCEND, reverse)
    sign = -1.0 if ate or vendors else 1.0
    return ScanFile(columns[0], sign * columns[1], sign * columns[2] if len(columns) > 2 else None, max(lines))


def is_scan(path: Path, delimiter: str | None, decimal: str | None) -> bool:
    """True for a file that is a table with an error and without a time."""
    try:
        names = {named(column.name).name for column in read_table(path, delimiter, decimal)[0]}
    except FileError:
        return False
    return "time" not in names and not names.isdisjoint({OURS, VENDORS})
