"""CSV files that a project file names: profiles of the load, torque curves of the motor, postures.

Every unit stands in the name of its column, `angle [deg]` or `angle (deg)`.
"""

import os
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...base.quantities import checked, shown
from ...drive.demands.motor_limits import Curve, curve_fault
from ...drive.postures import Posture
from ...study.move.profiles import AngleProfile
from ..logs.names import named
from ..logs.table import columns_in_si, read_table, refuse, rising_columns

POSTURE_UNITS = {"inertia": "kg*m**2", "torque": "N*m", "coupling": "N*m/rad"}
POSTURE_FORM = "name the columns with their units: inertia [kg*m^2], torque [N*m], coupling [N*m/rad]"
PROFILE_COLUMNS = {"time": ("time", "s"), "angle": ("angle", "rad")}
PROFILE_FORM = "name the columns with their units: time [s], angle [deg]"
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
        raise refuse(path, f"has fewer than two points; {PROFILE_FORM}, and give one line per point")
    times, angles = rising_columns(path, file, lines, PROFILE_COLUMNS, PROFILE_FORM, FORWARD)
    return checked(AngleProfile(tuple(times.tolist()), tuple(angles.tolist())))


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
        raise refuse(path, f"has the column {shown(other[0])}, unknown for postures; {POSTURE_FORM}")
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
