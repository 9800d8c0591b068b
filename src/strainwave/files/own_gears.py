"""Gears of the user's own: a YAML or CSV file with units, read into the same records as the catalogue's.

YAML holds a list `gears`, each a group of fields; CSV a line of column names and one line per gear, where a unit stands
in every cell or in the column's name, as in `K1 [N*m/rad]`. Every problem names its line.
"""

import csv
import io
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from ..base.units import NUMBER, RPM
from ..model.gears.gear import NUMBERS, Gear
from .fields.kinds import Items, Quantity, Row, Text, Whole, Wrong
from .fields.rows import Fields, Group, field, needed, read_file
from .logs.names import named
from .yaml_text import Keys, Located, Problem, name, read, refuse, shown, text_of

SPEEDS = {"max_rpm": "max_speed", "average_rpm": "average_speed"}
NEEDED = ("K1", "K2", "K3", "T1", "T2")
NAME_LETTERS = 60
RECORDS = 2000
COUNT = Whole(1, 999_999, "write for example 50", "is not a whole number from 1; write for example 50")


def _name(text: str) -> str:
    if not (0 < len(text) <= NAME_LETTERS and text.isprintable()):
        raise ValueError(f"{shown(text)} is not a name of 1 to {NAME_LETTERS} printable characters; shorten it")
    return text


class OwnGear(Group):
    """A gear of one's own: the fields of `Gear`, with speeds in place of its rpm."""

    name: str = needed(Text(_name), "MY-40-50", "Name of the gear.")
    series: str | None = field(Text(_name), "MY", "Series of the gear.")
    source: str | None = field(Text(), "datasheet 2024", "Where the numbers come from.")
    ratio: int = needed(COUNT, "50", "Motor turns per output turn.")
    size: int | None = field(COUNT, "40", "Size of the gear.")

    def record(self, source: str) -> Gear:
        """The gear, whose numbers come from this source where it names none."""
        numbers = {key: getattr(self, SPEEDS.get(key, key)) for key in NUMBERS}
        rpm = {key: numbers[key] / RPM for key in SPEEDS if numbers[key] is not None}
        gear = Gear(
            name=self.name, series=self.series or "", size=self.size, ratio=self.ratio, source=self.source or source,
            **numbers | rpm,
        )  # fmt: skip
        doubts = () if any(gear.contradictions()) else tuple(gear.slips())
        return replace(gear, doubts=doubts, notes=tuple(sentence for _, sentence in doubts))

    def check(self) -> Iterator[Wrong]:
        """Refuse numbers that contradict each other."""
        for number, sentence in self.record("").contradictions():
            for rpm, speed in SPEEDS.items():
                sentence = sentence.replace(rpm, speed)
            yield Wrong((SPEEDS.get(number, number),), sentence)


for _key, _unit in NUMBERS.items():
    _row = Row(Quantity("rad/s" if _key in SPEEDS else _unit), needed=_key in NEEDED)
    setattr(OwnGear, SPEEDS.get(_key, _key), _row)


class GearsSpec(Group):
    """The whole file."""

    gears: tuple[OwnGear, ...] = needed(Items(Fields(OwnGear), 1, RECORDS), "[{name: MY-40-50, ratio: 50}]", "Gears.")


def read_gears(path: str | Path) -> dict[str, Gear]:
    """Read one's own gears.

    Parameters
    ----------
    path : str or Path
        `.csv`, or YAML with any other ending, of at most 256 KiB. Fields are those of `Gear`, each number with its
        unit ("10e4 N*m/rad"); input speeds are called `max_speed` and `average_speed`. Needed are name, ratio, K1, K2,
        K3, T1 and T2.

    Returns
    -------
    dict of str to Gear
        The records by name, in the order of the file, in SI: `K1`, `K2`, `K3` [N*m/rad], `T1`, `T2` and the limits of
        torque [N*m]; `max_speed`, `average_speed` [rad/s]; `accuracy`, `lost_motion` [rad]; `ratio`.

    Raises
    ------
    FileError
        If the file cannot be read or a record is wrong, contradicts itself or appears twice; a ValueError with one line
        `file:line:column: field: fact, value, remedy` per problem.
    """
    path = Path(path)
    text, table = text_of(path, "gear file"), path.suffix.lower() == ".csv"
    located = _of_table(text) if table else read(text)
    spec, problems = read_file(located.content, GearsSpec, located)
    if not problems:
        problems += _twice(spec.gears, located)
    if table:  # where columns have names, and lines none
        problems = [problem._replace(field=problem.field.rpartition(".")[2]) for problem in problems]
    refuse(path, problems)
    return {gear.name: gear.record(path.name) for gear in spec.gears}


def _twice(gears: tuple[OwnGear, ...], located: Located) -> Iterator[Problem]:
    first: dict[str, int] = {}
    for i, gear in enumerate(gears):
        keys: Keys = "gears", i, "name"
        line, column = located.position(keys)
        if gear.name in first:
            sentence = f"{gear.name!r} appears twice, first in line {first[gear.name]}; remove one or rename it"
            yield Problem(line, column, name(keys), sentence)
        first.setdefault(gear.name, line)


def _of_table(text: str) -> Located:
    """Content of a CSV file, as YAML would have it; faults of its lines are among the problems."""
    tree = Located()
    rows = list(_rows(text, tree.problems))
    if tree.problems:
        return tree
    if not 2 <= len(rows) <= RECORDS:
        fact = f"has {len(rows)} lines; it needs column names and 1 to {RECORDS - 1} gears"
        tree.problems.append(Problem(1, 1, "file", fact))
        return tree
    (first, header), *body = rows
    names, units = zip(*map(named, header), strict=True)
    twice = sorted(key for key in names if names.count(key) > 1)
    if len(header) == 1:
        tree.problems.append(Problem(first, 1, "file", "has one column; separate the columns by commas"))
    if twice:
        tree.problems.append(Problem(first, 1, twice[0], "is the name of two columns; remove one"))
    if tree.problems:
        return tree
    tree.content = {"gears": []}
    for line, row in body:
        if len(row) != len(header):
            fact = f"has {len(row)} cells where line {first} names {len(header)} columns; keep empty cells"
            tree.problems.append(Problem(line, 1, "file", fact))
            continue
        group, keys = dict[str, str](), ("gears", len(tree.content["gears"]))
        tree.values[keys] = line, 1
        for column, (key, unit, cell) in enumerate(zip(names, units, row, strict=True), 1):
            tree.values[(*keys, key)] = tree.keys[(*keys, key)] = line, column
            if cell and unit and _has_unit(cell):
                fact = f"{shown(cell)} has a unit, and line {first} gives the unit {unit} for the column; write it once"
                tree.problems.append(Problem(line, column, key, fact))
            elif cell:
                group[key] = f"{cell} {unit}".strip()
        tree.content["gears"].append(group)
    return tree


def _rows(text: str, problems: list[Problem]) -> Iterator[tuple[int, list[str]]]:
    """Rows that are neither empty nor a remark, each with its line."""
    reader = csv.reader(io.StringIO(text), strict=True, skipinitialspace=True)
    try:
        for row in reader:
            if any(cell.strip() for cell in row) and not row[0].startswith("#"):
                yield reader.line_num, [cell.strip() for cell in row]
    except csv.Error as error:
        problems.append(Problem(reader.line_num, 1, "file", f"is not CSV ({error}); check the quotes"))


def _has_unit(cell: str) -> bool:
    """True where letters or a sign of an angle follow a number."""
    number = NUMBER.match(cell)
    return bool(number and re.match(r"\s*[^\W\d_]|\s*[°%′″]", cell[number.end() :]))
