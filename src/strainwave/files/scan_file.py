"""A measured error scan in a text table, as `read_log` reads it: a line of column names with units, a line per sample.

Every unit must stand in the column's name, `angle [deg]` or `angle (deg)`, or beside the name that the caller gives.

A profile in CSV: time and angle of the load, with their units in the names of the columns. A motor's torque over its
speed, and postures, likewise.
"""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..base.quantities import checked, shown
from ..base.results import Floats
from ..drive.asked import Curve, curve_fault
from ..drive.postures import Posture
from ..study.move.profiles import AngleProfile
from .logs.names import named
from .logs.table import columns_in_si, read_table, refuse, rising_columns
from .yaml_text import FileError

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


POSTURE_UNITS = {"inertia": "kg*m**2", "torque": "N*m", "coupling": "N*m/rad"}
POSTURE_FORM = "name the columns with their units: inertia [kg*m^2], torque [N*m], coupling [N*m/rad]"
COLUMNS = {"time": ("time", "s"), "angle": ("angle", "rad")}
FORM = "name the columns with their units: time [s], angle [deg]"
FORWARD = "a profile goes forward in time: correct or remove the line"


def read_profile(
    path: str | os.PathLike[str], *, delimiter: str | None = None, decimal: str | None = None
) -> AngleProfile:
    """Read times and angles of the load.

    Parameters
    ----------
    path : str or Path
        Text in any dialect that `read_log` reads, with the columns `time` and `angle` and their units: "time [s],
        angle [deg]". Other columns and lines above the names of the columns are left out.
    delimiter, decimal : str, optional
        Column separator and decimal sign. Default: those with which the text is a table; where this is so in two ways,
        the file is refused.

    Returns
    -------
    AngleProfile
        `times` [s] and `angles` [rad] of the load.

    Raises
    ------
    FileError
        If the file cannot be read, a column or its unit is missing, a number is wrong, or time goes back; a ValueError
        with one line, `file:line:column: field: fact, value, remedy`.
    """
    path = Path(path)
    file, _, lines = read_table(path, delimiter, decimal, kind="profile")
    if len(lines) < 2:
        raise refuse(path, f"has fewer than two points; {FORM}, and give one line per point")
    times, angles = rising_columns(path, file, lines, COLUMNS, FORM, FORWARD)
    profile: AngleProfile = checked(AngleProfile(tuple(times.tolist()), tuple(angles.tolist())))
    return profile


def read_torque_curve(path: str | os.PathLike[str], column: str) -> Curve:
    """Read speeds [rad/s] and torques [N*m] of a motor: the columns `speed` and `column`, or `torque`, with units.

    Raises
    ------
    FileError
        If the file cannot be read, a column or its unit is missing, a number is wrong, speeds do not ascend from 0, or
        a torque is negative.
    """
    path = Path(path)
    file, _, lines = read_table(path, None, None, kind="torque curve")
    named_so = column in [named(one.name).name for one in file]
    form = f"name the columns with their units: speed [rpm], {column} [N*m]"
    fields = {"speed": ("speed", "rad/s"), column: (column if named_so else "torque", "N*m")}
    speeds, torques = rising_columns(path, file, lines, fields, form, "give speeds that ascend: sort the lines")
    curve = tuple(zip(speeds.tolist(), torques.tolist(), strict=True))
    if fault := curve_fault(curve):
        raise refuse(path, fault)
    return curve


def read_postures(path: str | os.PathLike[str]) -> tuple[Posture, ...]:
    """Read postures: the column `inertia`, and where they are there `torque` and `coupling`, with units.

    Returns
    -------
    tuple of Posture
        In the order of the file: `inertia` [kg*m^2] of the load, `torque` [N*m] of gravity and the stiffness of the
        `coupling` [N*m/rad], None where the file has none.

    Raises
    ------
    FileError
        If the file cannot be read, a column or its unit is missing, a number is wrong, or an inertia or a stiffness is
        not positive.
    """
    path = Path(path)
    file, _, lines = read_table(path, None, None, kind="table of postures")
    present = {named(column.name).name for column in file} | {"inertia"}
    if other := sorted(present - POSTURE_UNITS.keys()):
        raise refuse(path, f"has the column {shown(other[0])}, which no posture has; {POSTURE_FORM}")
    fields = {name: (name, unit) for name, unit in POSTURE_UNITS.items() if name in present}
    columns, indices = columns_in_si(path, file, lines, fields, POSTURE_FORM)
    for name, values, index in zip(fields, columns, indices, strict=True):
        if name != "torque" and np.any(values <= 0.0):
            i = int(np.argmax(values <= 0.0))
            raise refuse(path, f"is {values[i]:g}; write a value above zero", lines[i], index + 1, name)
    rows = zip(*(values.tolist() for values in columns), strict=True)
    return tuple(Posture(**dict(zip(fields, row, strict=True))) for row in rows)


class ProfileFile(NamedTuple):
    """A part of a profile that is in a CSV file beside the project file."""

    file: str
