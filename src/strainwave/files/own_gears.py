"""Gears of the user's own: a YAML or CSV file with units, read into the same records as the catalogue's.

YAML holds a list `gears`, each a group of fields; CSV a line of column names and one line per gear, where a unit stands
in every cell or in the column's name, as in `K1 [N*m/rad]`. Every problem names its line.
"""

import csv
import difflib
import io
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from ..base.quantities import example, parse
from ..base.units import NUMBER, RPM
from ..model.gears.gear import NUMBERS, Gear
from .yaml_text import FileError, Problem, as_path, complaint, kind_of, name, read, read_text, shown

TEXTS = ("name", "series", "source")
COUNTS = ("ratio", "size")
SPEEDS = {"max_speed": "max_rpm", "average_speed": "average_rpm"}
UNITS = {field: unit for field, unit in NUMBERS.items() if field not in SPEEDS.values()} | dict.fromkeys(
    SPEEDS, "rad/s"
)
FIELDS = (*TEXTS, *COUNTS, *UNITS)
NEEDED = ("name", "ratio", "K1", "K2", "K3", "T1", "T2")
LONGEST = 60
MOST = 2000


class Cell(NamedTuple):
    """One value of a file: its text and where it stands."""

    text: Any
    line: int
    column: int
    field: str


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
        The records by name, in the order of the file.

    Raises
    ------
    FileError
        If the file cannot be read or a record is wrong, contradicts itself or appears twice; a ValueError with one line
        `file:line:column: field: fact, value, remedy` per problem.
    """
    path = as_path(path)
    text = read_text(path)
    problems: list[Problem] = []
    gears: dict[str, Gear] = {}
    lines: dict[str, int] = {}
    if isinstance(text, Problem):
        raise FileError(complaint(path, [text._replace(sentence=text.sentence.replace("project file", "gear file"))]))
    rows = _csv_rows(text, problems) if path.suffix.lower() == ".csv" else _yaml_rows(text, problems)
    for start, cells in rows:
        gear = _gear(start, cells, problems, path)
        if gear is None:
            continue
        if gear.name in gears:
            cell = cells["name"]
            said = f"{gear.name!r} appears twice, first in line {lines[gear.name]}; remove one or rename it"
            problems.append(Problem(cell.line, cell.column, cell.field, said))
        gears[gear.name], lines[gear.name] = gear, cells["name"].line
    if not gears and not problems:
        problems.append(Problem(1, 1, "file", f"holds no gear; each needs {', '.join(NEEDED)}"))
    if problems:
        raise FileError(complaint(path, problems))
    return gears


def _yaml_rows(text: str, problems: list[Problem]) -> Iterator[tuple[Problem, dict[str, Cell]]]:
    located = read(text)
    problems += located.problems
    content = located.content
    if located.content is None:
        if not problems:
            problems.append(Problem(1, 1, "file", "is empty; begin with a line 'gears:' and a list of gears under it"))
        return
    listed = content.get("gears") if isinstance(content, dict) else None
    if not isinstance(listed, list) or list(content) != ["gears"]:
        problems.append(
            Problem(1, 1, "file", "must hold one list 'gears'; write 'gears:' and '- name: MY-40-50' under it")
        )
        return
    for i, group in enumerate(listed):
        here = ("gears", i)
        start = Problem(*located.place(here), name(here), "")
        if not isinstance(group, dict):
            problems.append(start._replace(sentence=f"is {kind_of(group)}, not a gear; write '- name: MY-40-50'"))
            continue
        yield (
            start,
            {
                key: Cell(
                    value,
                    *(located.place((*here, key)) if key in FIELDS else located.keys[*here, key]),
                    name((*here, key)),
                )
                for key, value in group.items()
            },
        )


def _csv_rows(text: str, problems: list[Problem]) -> Iterator[tuple[Problem, dict[str, Cell]]]:
    reader = csv.reader(io.StringIO(text), strict=True, skipinitialspace=True)
    try:
        rows = [(reader.line_num, row) for row in reader if any(cell.strip() for cell in row)]
    except csv.Error as error:
        problems.append(Problem(reader.line_num, 1, "file", f"is not CSV ({error}); check the quotes"))
        return
    if len(rows) < 2 or len(rows) > MOST:
        problems.append(
            Problem(1, 1, "file", f"has {len(rows)} lines; it needs column names and 1 to {MOST - 1} gears")
        )
        return
    (first, header), *body = rows
    columns = [re.fullmatch(r"\s*([^\[\]]*?)\s*(?:\[(.*)\])?\s*", column) for column in header]
    if len(header) == 1:
        problems.append(Problem(first, 1, "file", "has one column; separate the columns by commas"))
        return
    names = [column.group(1) if column else text for column, text in zip(columns, header, strict=True)]
    units = [(column.group(2) or "").strip() if column else "" for column in columns]
    twice = {field for field in names if names.count(field) > 1}
    if twice:
        problems.append(Problem(first, 1, sorted(twice)[0], "is the name of two columns; remove one"))
        return
    for line, row in body:
        if len(row) != len(header):
            said = f"has {len(row)} cells where line {first} names {len(header)} columns; leave cells empty, not out"
            problems.append(Problem(line, 1, "file", said))
            continue
        twice_said = [
            Problem(
                line,
                i + 1,
                field,
                f"{shown(cell.strip())} has a unit and line {first} gives the column {unit}; write it once",
            )
            for i, (field, unit, cell) in enumerate(zip(names, units, row, strict=True))
            if unit and _has_unit(cell.strip())
        ]
        if twice_said:
            problems += twice_said
            continue
        cells = {
            field: Cell(f"{cell.strip()} {unit}".strip(), line, i + 1, field)
            for i, (field, unit, cell) in enumerate(zip(names, units, row, strict=True))
            if cell.strip()
        }
        yield Problem(line, 1, "gear", ""), cells


def _has_unit(cell: str) -> bool:
    """Whether letters or a sign of an angle follow a number."""
    number = NUMBER.match(cell)
    return bool(number and re.match(r"\s*[^\W\d_]|\s*[°%′″]", cell[number.end() :]))


def _gear(start: Problem, cells: dict[str, Cell], problems: list[Problem], path: Path) -> Gear | None:
    """Build one record, or add what is wrong with it to the problems."""
    values: dict[str, Any] = {}
    count = len(problems)
    for field, cell in cells.items():
        try:
            values[SPEEDS.get(field, field)] = _value(field, cell.text)
        except ValueError as error:
            problems.append(Problem(cell.line, cell.column, cell.field, str(error)))
    missing = [field for field in NEEDED if field not in cells]
    if missing:
        remedy = f"write each, {missing[0]} {_sample(missing[0])}"
        problems.append(start._replace(sentence=f"lacks {', '.join(missing)}; {remedy}"))
    if len(problems) > count:
        return None
    values = {"series": "", "size": None, "source": path.name} | values
    gear = Gear(**values)
    for number, sentence in gear.contradictions():
        field = {rpm: speed for speed, rpm in SPEEDS.items()}.get(number, number)
        for speed, rpm in SPEEDS.items():
            sentence = sentence.replace(rpm, speed)
        problems.append(Problem(cells[field].line, cells[field].column, cells[field].field, sentence))
    return gear if len(problems) == count else None


def _value(field: str, text: Any) -> Any:
    if field not in FIELDS:
        near = difflib.get_close_matches(field, FIELDS, n=1, cutoff=0.5)
        raise ValueError(
            f"unknown field; did you mean {near[0]!r}?" if near else f"unknown field; known are {', '.join(FIELDS)}"
        )
    if not isinstance(text, str):
        raise ValueError(f"is {kind_of(text)}; write {_sample(field)}")
    if field in TEXTS:
        if field != "source" and not (0 < len(text) <= LONGEST and text.isprintable()):
            raise ValueError(f"{shown(text)} is no name of 1 to {LONGEST} printable characters; shorten it")
        return text
    if field in COUNTS:
        if not re.fullmatch(r"[0-9]{1,6}", text) or int(text) < 1:
            raise ValueError(f"{shown(text)} is not a whole number from 1; write {_sample(field)}")
        return int(text)
    value = parse(text, UNITS[field])
    return value / RPM if field in SPEEDS else value


def _sample(field: str) -> str:
    known = {"name": "MY-40-50", "series": "MY", "source": "datasheet 2024", "ratio": "50", "size": "40"}
    return f"for example {known[field]}" if field in known else example(UNITS[field])
