"""A profile in CSV: time and angle of the load, with their units in the names of the columns."""

from pathlib import Path
from typing import NamedTuple

from ..base.quantities import checked
from ..study.move.profiles import AngleProfile
from .scan_file import check_signs, find_columns, from_header, read_numbers, read_rows
from .yaml_text import FileError, Problem, as_path, complaint, read_text

LARGEST = 64 * 1024 * 1024
COLUMNS = {"time": ("time", "s"), "angle": ("angle", "rad")}
HINT = "name the columns with their units: time [s], angle [deg]"


def read_profile(path: str | Path, *, delimiter: str = ",", decimal: str = ".") -> AngleProfile:
    """Read times and angles of the load.

    Parameters
    ----------
    path : str or Path
        CSV of at most 64 MiB with the columns `time` and `angle` and their units: "time [s], angle [deg]". Other
        columns, empty lines, lines that begin with # and those above the names of the columns are left out.
    delimiter, decimal : str
        What stands between columns and before decimals, never guessed: German tables have ";" and ",".

    Returns
    -------
    AngleProfile

    Raises
    ------
    FileError
        If the file cannot be read, a column or its unit is missing, a number is wrong, or time goes back; a ValueError
        with one line per problem, `file:line:column: field: fact, value, remedy`.
    ValueError
        If delimiter and decimal sign cannot go together.
    """
    path = as_path(path)
    check_signs(delimiter, decimal)
    text = read_text(path, "profile", LARGEST)
    if isinstance(text, Problem):
        raise FileError(complaint(path, [text]))
    problems: list[Problem] = []
    rows = from_header(list(read_rows(text, delimiter, problems)), "time")
    if not problems and len(rows) < 3:
        problems.append(Problem(1, 1, "file", f"has fewer than two points; {HINT}, and give one line per point"))
    columns = [] if problems else find_columns(*rows[0], COLUMNS, delimiter, problems, HINT)
    table = None if problems else read_numbers(rows, columns, decimal, problems)
    if problems or table is None:
        raise FileError(complaint(path, problems))
    times, angles = (table * [column.factor for column in columns]).T.tolist()
    back = next((i for i in range(len(times) - 1) if not times[i] < times[i + 1]), None)
    if back is not None:
        said = (
            f"{table[back + 1, 0]:.9g} stands after {table[back, 0]:.9g}; a profile goes forward in time: correct or "
        )
        place = Problem(rows[back + 2][0], columns[0].place + 1, "time", said + "remove the line")
        raise FileError(complaint(path, [place]))
    profile: AngleProfile = checked(AngleProfile(tuple(times), tuple(angles)))
    return profile


class ProfileFile(NamedTuple):
    """A part of a profile that is in a CSV file beside the project file."""

    file: str
