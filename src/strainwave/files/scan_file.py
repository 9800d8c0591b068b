"""A measured error scan in CSV: one line of column names with units, one line per sample.

Lines above the one that names the column of angles are left out. Nothing is guessed: a semicolon between columns and a
comma in numbers must be said, and every unit must stand in the column's name, `angle [deg]` or `angle (deg)`, or
beside the name that the caller gives. Complaints name the options of the command line; the arguments of `read_scan` are
called the same without dashes.

A profile in CSV: time and angle of the load, with their units in the names of the columns.
"""

import csv
import io
import re
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..base.quantities import checked, convert
from ..base.results import Floats
from ..base.units import NUMBER
from ..study.move.profiles import AngleProfile
from .yaml_text import Problem, as_path, refuse, shown, text_of

LARGEST = 64 * 1024 * 1024
MOST_SHOWN, MOST_ABOVE = 20, 100  # problems, and lines above the names of the columns
OURS, VENDORS, BACKWARD, ANGLE = "error", "ate", "backward", "angle"
HINT = "name the columns with their units: angle [deg], error [arcsec]"


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


class Column(NamedTuple):
    """A column of the file: its name, its place, the factor to radians."""

    name: str
    place: int
    factor: float


def read_scan(
    path: str | Path,
    *,
    angle: str = ANGLE,
    error: str | None = None,
    backward: str | None = None,
    ate: bool = False,
    delimiter: str = ",",
    decimal: str = ".",
    reverse: bool = False,
) -> ScanFile:
    """Read a measured error scan.

    Parameters
    ----------
    path : str or Path
        CSV of at most 64 MiB in UTF-8, or in UTF-16 with its mark; empty lines, lines that begin with # and those above
        the names of the columns are left out.
    angle, error, backward : str, optional
        Names of the columns, with their units where the file does not give them: "Winkel [deg]". Default: `angle`,
        `error` (theta_m/N - theta_l) or `ate` (vendors' theta_l - theta_m/N), and `backward` if there is one.
    ate : bool
        Whether the named columns hold the vendors' error; a column called `ate` does.
    delimiter, decimal : str
        What stands between columns and before decimals, never guessed: German tables have ";" and ",".
    reverse : bool
        Whether the file is a run in the backward direction, whose angles may descend throughout.

    Returns
    -------
    ScanFile
        In rad.

    Raises
    ------
    FileError
        If the file cannot be read or a number is wrong; a ValueError with one line per problem,
        `file:line:column: field: fact, value, remedy`.
    ValueError
        If delimiter and decimal sign cannot go together.
    """
    path = as_path(path)
    check_signs(delimiter, decimal)
    wanted = {ANGLE: angle, OURS: error, BACKWARD: backward}
    for field, name in wanted.items():
        if not isinstance(name, str) and (name is not None or field == ANGLE):
            raise TypeError(f"{field} is {name!r}; give the name of a column as text, with its unit: 'Winkel [deg]'")
    text = text_of(path, "scan file", LARGEST)
    problems: list[Problem] = []
    rows = from_header(list(read_rows(text, delimiter, problems)), angle)
    columns: list[Column] = []
    if not problems and len(rows) < 2:
        problems.append(Problem(1, 1, "file", f"has no samples; {HINT}, and give one line per sample"))
    if not problems:
        columns, vendors = _columns(*rows[0], wanted, delimiter, problems)
        ate = ate or vendors
    refuse(path, problems)
    lines = [line for line, _ in rows[1:]]
    table = read_numbers(rows, columns, decimal, problems)
    if not problems:
        if reverse and len(table) > 1 and table[1, 0] < table[0, 0]:
            table, lines = table[::-1], lines[::-1]
        problems += _order(table[:, 0], lines, columns[0])
    refuse(path, problems)
    table = table * np.array([column.factor for column in columns])
    sign = -1.0 if ate else 1.0
    other = sign * table[:, 2] if len(columns) > 2 else None
    return ScanFile(table[:, 0], sign * table[:, 1], other, max(lines))


def check_signs(delimiter: str, decimal: str) -> None:
    """Refuse a delimiter and a decimal sign that cannot go together (ValueError)."""
    plain = isinstance(delimiter, str) and len(delimiter) == 1 and delimiter not in '+-0123456789eE"\n\r'
    if not plain or decimal not in (".", ",") or delimiter == decimal:
        raise ValueError(
            f"the delimiter (--delimiter) is {delimiter!r} and the decimal sign (--decimal) {decimal!r}; take one of "
            ", ; tab and space, and a point or a comma that is not the delimiter"
        )


def read_rows(text: str, delimiter: str, problems: list[Problem]) -> Iterator[tuple[int, list[str]]]:
    """Rows of a table that are neither empty nor a remark, each with its line."""
    reader = csv.reader(io.StringIO(text), delimiter=delimiter, strict=True, skipinitialspace=True)
    try:
        for row in reader:
            if any(cell.strip() for cell in row) and not row[0].startswith("#"):
                yield reader.line_num, [cell.strip() for cell in row]
    except csv.Error as error:
        problems.append(Problem(reader.line_num, 1, "file", f"is not CSV ({error}); check the quotes"))


def _columns(
    line: int, header: list[str], wanted: dict[str, str | None], delimiter: str, problems: list[Problem]
) -> tuple[list[Column], bool]:
    """Columns of angle, error and, if there is one, the way back; and whether the error is the vendors' by its name."""
    names = [name_and_unit(cell)[0] for cell in header]
    vendors = wanted[OURS] is None and OURS not in names and VENDORS in names
    asked = dict(wanted) | {OURS: wanted[OURS] or (VENDORS if vendors else OURS)}
    if asked[BACKWARD] is None and BACKWARD in names:
        asked[BACKWARD] = BACKWARD
    given = {field: (text, "rad") for field, text in asked.items() if text is not None}
    return find_columns(line, header, given, delimiter, problems, HINT, ", or give --{}"), vendors


def find_columns(
    line: int, header: list[str], wanted: dict[str, tuple[str, str]], delimiter: str, problems: list[Problem],
    hint: str, option: str = "",
) -> list[Column]:  # fmt: skip
    """Columns of some fields, each with its name in the file and its kind of unit, with their factors to SI."""
    parts = [name_and_unit(cell) for cell in header]
    names = [name for name, _ in parts]
    other = next((d for d in ";,\t" if d != delimiter and d in header[0]), None)
    if len(header) == 1 and other is not None:
        problems.append(Problem(line, 1, "file", f"has one column; if {other!r} parts them, say so with --delimiter"))
        return []
    found = []
    for field, (text, kind) in wanted.items():
        name, unit = name_and_unit(text)
        if names.count(name) != 1:
            fact = "is there twice" if name in names else f"is missing; the file has {_list(names)}"
            said = f"column {shown(name)} {fact}; {hint}{option.format(field)}"
            problems.append(Problem(line, 1, field, said))
            continue
        place = names.index(name)
        given = parts[place][1]
        try:
            if unit and given and unit != given:
                raise ValueError(f"column {shown(name)} is in {given} and was requested in {unit}")
            if not (unit or given):
                raise ValueError(f"column {shown(name)} has no unit; {hint}")
            found.append(Column(name, place, float(convert(1.0, unit or given, kind))))
        except ValueError as wrong:
            problems.append(Problem(line, place + 1, field, str(wrong)))
    return found


def from_header(rows: list[tuple[int, list[str]]], angle: str) -> list[tuple[int, list[str]]]:
    """The rows from the one on that names the column of angles; all of them where none of the first does."""
    wanted = name_and_unit(angle)[0]
    at = (i for i, (_, row) in enumerate(rows[:MOST_ABOVE]) if wanted in [name_and_unit(cell)[0] for cell in row])
    return rows[next(at, 0) :]


def _list(names: list[str]) -> str:
    text = ", ".join(shown(name) for name in names[:8])
    return text + (", ..." if len(names) > 8 else "")


def name_and_unit(cell: str) -> tuple[str, str]:
    """Name and unit of a column: "angle [deg]", or "angle (deg)" where that is a unit of angle or time."""
    text = cell.strip()
    if (round_ := re.fullmatch(r"(.*?)\s*\(([^()]*)\)", text)) is not None and _is_unit(round_.group(2).strip()):
        return round_.group(1), round_.group(2).strip()
    match = re.fullmatch(r"([^\[\]]*?)\s*(?:\[(.*)\])?", text)
    return (match.group(1), (match.group(2) or "").strip()) if match else (cell, "")


def _is_unit(unit: str) -> bool:
    for kind in ("rad", "s"):
        with suppress(ValueError):
            convert(1.0, unit, kind)
            return True
    return False


def read_numbers(
    rows: list[tuple[int, list[str]]], columns: list[Column], decimal: str, problems: list[Problem]
) -> Floats:
    """Table (samples, columns) in the file's units."""
    (first, header), *body = rows
    table = np.zeros((len(body), len(columns)))
    for i, (line, row) in enumerate(body):
        if len(problems) > MOST_SHOWN:
            break
        if len(row) != len(header):
            said = f"has {len(row)} cells where line {first} names {len(header)} columns; is --delimiter right?"
            problems.append(Problem(line, 1, "file", said))
            continue
        for j, column in enumerate(columns):
            try:
                table[i, j] = _number(row[column.place], decimal)
            except ValueError as error:
                problems.append(Problem(line, column.place + 1, column.name, str(error)))
    return table


def _number(text: str, decimal: str) -> float:
    other = "," if decimal == "." else "."
    if other in text:
        raise ValueError(
            f"{shown(text)} has {other!r} where the decimal sign is {decimal!r}; say which it is with --decimal"
        )
    plain = text.replace(decimal, ".")
    value = float(plain) if NUMBER.fullmatch(plain) else np.nan
    if not np.isfinite(value):
        raise ValueError(f"{shown(text)} is no finite number; remove the line or correct it")
    return value


def _order(angles: Floats, lines: list[int], column: Column) -> list[Problem]:
    """Angles that repeat or descend, up to the limit of what is shown."""
    problems = []
    for i in np.flatnonzero(np.diff(angles) <= 0.0)[: MOST_SHOWN + 1]:
        before, after = float(angles[i]), float(angles[i + 1])
        fact = "repeats that of" if before == after else f"stands after {before:.9g} of"
        remedy = (
            "average repeated angles"
            if before == after
            else "angles must ascend, the way back is a file of its own (--back)"
        )
        said = f"{after:.9g} {fact} line {lines[i]}; {remedy}"
        problems.append(Problem(lines[i + 1], column.place + 1, column.name, said))
    return problems


COLUMNS = {"time": ("time", "s"), "angle": ("angle", "rad")}
FORM = "name the columns with their units: time [s], angle [deg]"


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
    text = text_of(path, "profile", LARGEST)
    problems: list[Problem] = []
    rows = from_header(list(read_rows(text, delimiter, problems)), "time")
    if not problems and len(rows) < 3:
        problems.append(Problem(1, 1, "file", f"has fewer than two points; {FORM}, and give one line per point"))
    columns = [] if problems else find_columns(*rows[0], COLUMNS, delimiter, problems, FORM)
    refuse(path, problems)
    table = read_numbers(rows, columns, decimal, problems)
    refuse(path, problems)
    times, angles = (table * [column.factor for column in columns]).T.tolist()
    back = next((i for i in range(len(times) - 1) if not times[i] < times[i + 1]), None)
    if back is not None:
        said = (
            f"{table[back + 1, 0]:.9g} stands after {table[back, 0]:.9g}; a profile goes forward in time: correct or "
        )
        place = Problem(rows[back + 2][0], columns[0].place + 1, "time", said + "remove the line")
        refuse(path, [place])
    profile: AngleProfile = checked(AngleProfile(tuple(times), tuple(angles)))
    return profile


class ProfileFile(NamedTuple):
    """A part of a profile that is in a CSV file beside the project file."""

    file: str
