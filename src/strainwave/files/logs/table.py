"""A text table of numbers: CSV in any dialect, with or without names above the columns."""

from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...results import Floats
from ..yaml_text import FileError, Problem, complaint, read_text, shown
from .dates import WrongDate, in_seconds
from .dialect import Dialect, Unclear, find, is_number, number, split
from .names import header_cells, unit_row

LARGEST = 1024 * 1024 * 1024  # of a text file [bytes]
COMMENTS = ("#", "%", "//")


@dataclass(frozen=True)
class Column:
    """One column of a file: its name, "" without one; its unit as written, "" without one; its values.

    `time` are the times [s] of the values, where the file has them for this column alone.
    """

    name: str
    unit: str
    values: Floats
    time: Floats | None = None


class Lines(NamedTuple):
    """Lines of a text with content, and where each stands in the file; comments apart."""

    text: list[str]
    numbers: list[int]
    comments: list[tuple[int, str]]


def refuse(path: Path, sentence: str, line: int = 1, column: int = 1, what: str = "file") -> FileError:
    """Complaint about a file in one sentence."""
    return FileError(complaint(path, [Problem(line, column, what, sentence)]))


def read_table(
    path: Path, delimiter: str | None, decimal: str | None, count: int | None
) -> tuple[list[Column], list[str]]:
    """Read a text table.

    Parameters
    ----------
    path : Path
        UTF-8, UTF-16 with its mark, or else Windows-1252; lines that begin with #, % or // are comments.
    delimiter, decimal : str or None
        Column separator and decimal sign, or None to find them.
    count : int or None
        Number of columns, if the user names all of them.

    Returns
    -------
    tuple of list of Column and list of str
        The columns, and notes about what was guessed.

    Raises
    ------
    FileError
        If the text is no table, or can be read in two ways.
    """
    notes: list[str] = []
    text = read_text(path, "log", LARGEST, notes)
    if isinstance(text, Problem):
        raise FileError(complaint(path, [text]))
    lines = _lines(text)
    if not lines.text:
        raise refuse(path, "is empty; give a log with a line for each sample")
    try:
        dated = in_seconds(lines.text)
        dialect, start = find(dated.lines, delimiter, decimal, count)
        if any(dated.places[:start]):  # a date above the table is not where its time begins
            dated = in_seconds(lines.text, start)
    except Unclear as unclear:
        raise refuse(path, str(unclear)) from None
    except WrongDate as wrong:
        raise refuse(path, str(wrong), lines.numbers[wrong.line]) from None
    lines = lines._replace(text=dated.lines)
    if delimiter is None or decimal is None:
        notes.append(f"the file was read as {dialect}")
    width = len(split(lines.text[start], dialect.delimiter))
    names, units = _header(path, lines, start, dialect, width)
    values = _numbers(path, lines, start, dialect, notes)
    for place in dated.places[start] if dated.first else []:
        # what stands before a date, and one sign for the date itself
        units[len(split(lines.text[start][:place] + "0", dialect.delimiter)) - 1] = "s"
    if dated.first:
        notes.append(f"dates were read as seconds since {dated.first}")
    columns = [Column(n, u, values[:, i]) for i, (n, u) in enumerate(zip(names, units, strict=True))]
    # a separator at the end of each line
    if len(columns) > 1 and not names[-1] and np.all(np.isnan(values[:, -1])):
        columns.pop()
    return columns, notes


def _lines(text: str) -> Lines:
    kept: list[str] = []
    numbers: list[int] = []
    comments: list[tuple[int, str]] = []
    for place, line in enumerate(text.splitlines(), 1):
        bare = line.strip()
        if bare.startswith(COMMENTS):
            comments.append((place, bare.lstrip("#%/").strip()))
        elif bare:
            kept.append(line.strip("\r\n "))
            numbers.append(place)
    return Lines(kept, numbers, comments)


def _header(path: Path, lines: Lines, start: int, dialect: Dialect, width: int) -> tuple[list[str], list[str]]:
    """Names and units above the numbers, "" where there are none."""
    above = [header_cells(line, dialect.delimiter) for line in lines.text[:start]]
    units = [""] * width
    if not above:
        last = [c for n, c in lines.comments if n < lines.numbers[start]][-1:]
        cells = header_cells(last[0], dialect.delimiter) if last else []
        return (cells if len(cells) == width else [""] * width), units
    if len(above) > 1 and len(above[-1]) == len(above[-2]) == width and unit_row(above[-1]):
        units = [cell.strip("[]() ") for cell in above.pop()]
    if len(above[-1]) != width:
        line = lines.numbers[start - 1]
        raise refuse(
            path,
            f"names {len(above[-1])} columns and the lines below have {width} numbers; give delimiter and decimal as "
            "the file is written",
            line,
        )
    return above[-1], units


def _numbers(path: Path, lines: Lines, start: int, dialect: Dialect, notes: list[str]) -> Floats:
    """Values (lines, columns); NaN where there is none."""
    body, d = lines.text[start:], dialect.delimiter
    width = len(split(body[0], d))
    if len(body) > 1 and _wrong_cell(body[-1], dialect, width):
        notes.append(f"the last line ({lines.numbers[-1]}) is cut off and was left out")
        body = body[:-1]
    if not dialect.thousands and (dialect.decimal == "." or not any("." in line for line in body)):
        text = body if dialect.decimal == "." else [line.replace(",", ".") for line in body]
        with suppress(ValueError):  # a value is missing, or a line is wrong
            return np.loadtxt(text, delimiter=None if d == " " else d, comments=None, quotechar='"', ndmin=2)
    return np.array([_row(path, lines, start + i, dialect, width) for i in range(len(body))])


def _row(path: Path, lines: Lines, place: int, dialect: Dialect, width: int) -> list[float]:
    """Numbers of one line, NaN where there is none."""
    line = lines.text[place]
    wrong = _wrong_cell(line, dialect, width)
    if wrong is not None:
        raise refuse(path, wrong[1], lines.numbers[place], wrong[0])
    return [number(cell, dialect) for cell in split(line, dialect.delimiter)]


def _wrong_cell(line: str, dialect: Dialect, width: int) -> tuple[int, str] | None:
    """Place and complaint of the first cell that is wrong."""
    cells = split(line, dialect.delimiter)
    if len(cells) != width:
        return 1, f"has {len(cells)} cells where the first line of numbers has {width}; correct the line"
    for i, cell in enumerate(cells):
        if not is_number(cell, dialect.decimal):
            said = f"has {shown(cell)}, which is no number with {dialect}; correct it, or give delimiter and decimal"
            return i + 1, said
    return None
