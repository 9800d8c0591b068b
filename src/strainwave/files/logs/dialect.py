"""Dialect of a text table: column separator, decimal sign and sign between thousands.

All pairs of separator and decimal sign are tried on the lines. A file that two pairs read as different tables is
refused: a German table must not become a wrong one.
"""

import csv
import math
import re
from collections.abc import Sequence
from typing import NamedTuple

from ...base.quantities import shown

DELIMITERS = (";", "\t", ",", " ")
NAMES = {";": "semicolons", "\t": "tabs", ",": "commas", " ": "blanks"}
SIGNS = {".": "a point", ",": "a comma"}
MISSING = frozenset((
    "", "nan", "NaN", "NAN", "-nan", "inf", "-inf", "+inf", "Inf", "-Inf", "+Inf", "INF", "-INF", "infinity",
    "Infinity", "-Infinity", "NA", "N/A", "null", "NULL", "None", "#N/A", "1.#INF", "-1.#INF", "1.#QNAN", "-1.#IND",
    "1,#INF", "-1,#INF", "1,#QNAN", "-1,#IND",
))  # fmt: skip
MOST_TRIED = 4000  # lines on which dialects are tried; of more lines, evenly chosen ones


class Dialect(NamedTuple):
    """Column separator (" " stands for any number of blanks), decimal sign, sign between thousands or ""."""

    delimiter: str
    decimal: str
    thousands: str = ""

    def __str__(self) -> str:
        grouped = f", {SIGNS[self.thousands]} between thousands" if self.thousands else ""
        between = NAMES.get(self.delimiter, repr(self.delimiter))
        return f"columns separated by {between}, {SIGNS[self.decimal]} before decimals{grouped}"


class Unclear(ValueError):
    """Lines can be read in no way, or in several; the message says so with the remedy."""


def split(line: str, delimiter: str) -> list[str]:
    """Cells of a line."""
    if delimiter == " ":
        return line.split()
    if '"' in line:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])]
    return [cell.strip() for cell in line.split(delimiter)]


def header_cells(line: str, delimiter: str) -> list[str]:
    """Cells of a line of names; blanks part them outside of brackets only."""
    if delimiter != " ":
        return split(line, delimiter)
    return re.findall(r"[^\s\[(]+(?:\s*(?:\[[^\]]*\]|\([^)]*\)))?", line)


def _grammar(decimal: str) -> tuple[re.Pattern[str], re.Pattern[str]]:
    """Numbers with this decimal sign, and those with the other sign between thousands."""
    sign, other = re.escape(decimal), re.escape("," if decimal == "." else ".")
    # a comma must have a digit after it: "1, 2" is two cells
    after = r"\d*" if decimal == "." else r"\d+"
    power = r"(?:[eE][+-]?\d{1,3})?"
    plain = rf"[+-]?(?:\d+(?:{sign}{after})?|{sign}\d+){power}"
    grouped = rf"[+-]?[1-9]\d{{0,2}}(?:{other}\d{{3}})+(?:{sign}\d+)?{power}"
    return re.compile(plain), re.compile(grouped)


PLAIN = {decimal: _grammar(decimal)[0] for decimal in SIGNS}
GROUPED = {decimal: _grammar(decimal)[1] for decimal in SIGNS}


def is_number(cell: str, decimal: str) -> bool:
    """True for a cell with a number with this decimal sign, or with a word for a missing one."""
    return cell in MISSING or any(form[decimal].fullmatch(cell) is not None for form in (PLAIN, GROUPED))


def number(cell: str, dialect: Dialect) -> float:
    """Value of a cell that is a number, NaN where it says that there is none."""
    if cell in MISSING:
        return math.nan
    # both signs stand for nothing but themselves in a cell that has passed `is_number`
    plain = cell if PLAIN[dialect.decimal].fullmatch(cell) else cell.replace("," if dialect.decimal == "." else ".", "")
    return float(plain.replace(dialect.decimal, "."))


class Reading(NamedTuple):
    """A way to read the lines of a table.

    `start` is the index of the first line of numbers, and `texts` are the indices of columns of text.
    """

    delimiter: str
    decimal: str
    start: int = 0
    texts: frozenset[int] = frozenset()

    def cells(self, line: str) -> list[str]:
        """Cells of a line, those of text empty."""
        cells = split(line, self.delimiter)
        return ["" if i in self.texts else cell for i, cell in enumerate(cells)] if self.texts else cells

    def width(self, line: str) -> int:
        """Number of cells of a line."""
        return len(split(line, self.delimiter))

    def is_row(self, line: str) -> bool:
        """True for a line of numbers, at least one of which is not missing."""
        cells = self.cells(line)
        numbers = all(is_number(cell, self.decimal) for cell in cells) and any(cell not in MISSING for cell in cells)
        return numbers and len(cells) > max(self.texts, default=0)

    def fits(self, lines: Sequence[str]) -> bool:
        """True where all lines have equally many cells, all numbers or missing ones."""
        count = self.width(lines[0])
        rows = map(self.cells, lines)
        return all(len(row) == count and all(is_number(cell, self.decimal) for cell in row) for row in rows)

    def table(self, lines: Sequence[str]) -> tuple[tuple[str, ...], ...]:
        """Cells of lines as they are read: equal for ways that read the same table."""
        dialect = Dialect(self.delimiter, self.decimal)
        return tuple(tuple(repr(number(cell, dialect)) for cell in self.cells(line)) for line in lines)


def find(
    lines: Sequence[str], delimiter: str | None = None, decimal: str | None = None, count: int | None = None
) -> tuple[Dialect, int]:
    """Find the dialect of a table.

    Parameters
    ----------
    lines : sequence of str
        Lines without comments and empty ones: those above the numbers too.
    delimiter, decimal : str or None
        Given by the user, or to be found.
    count : int or None
        Number of columns, if the user names all of them.

    Returns
    -------
    tuple of Dialect and int
        The dialect, and the index of the first line of numbers.

    Raises
    ------
    Unclear
        If no dialect reads the lines, or two read different tables.
    """
    _check_signs(delimiter, decimal)
    delimiters, signs = DELIMITERS if delimiter is None else (delimiter,), SIGNS if decimal is None else (decimal,)
    pairs = [Reading(d, sign) for d in delimiters for sign in signs if d != sign]
    readings, sample = _fitting(lines, pairs)
    if not readings:
        readings, sample = _fitting(lines, [pair for one in pairs if (pair := _with_texts(lines, one)) is not None])
        widths = [reading.width(sample[0]) - len(reading.texts) for reading in readings]
        readings = [one for one, width in zip(readings, widths, strict=True) if width == max(widths)]
    if not readings:
        raise Unclear(
            "has no table of numbers whose lines have equally many cells; give delimiter and decimal as it is written, "
            "write dates as 2026-11-23T13:37:38, and remove lines of text between the numbers"
        )
    first_line = lines[readings[0].start]
    tables: dict[tuple[tuple[str, ...], ...], Reading] = {}
    for reading in sorted(readings, key=lambda reading: reading.width(first_line) == 1):
        tables.setdefault(reading.table(sample), reading)
    if len(tables) > 1:
        tables = {cells: one for cells, one in tables.items() if _agrees(one, lines, len(cells[0]), count)} or tables
    if len(tables) > 1:
        first, second = [Dialect(one.delimiter, one.decimal) for one in tables.values()][:2]
        raise Unclear(
            f"can be read in two ways, with {first}, or with {second} (line {first_line.strip()[:60]!r}); give "
            "delimiter and decimal"
        )
    reading = next(iter(tables.values()))
    return Dialect(reading.delimiter, reading.decimal, _thousands(lines[reading.start :], reading)), reading.start


def _check_signs(delimiter: str | None, decimal: str | None) -> None:
    """Refuse a column separator and a decimal sign with which no table can be written (Unclear)."""
    single = delimiter is None or (len(delimiter) == 1 and delimiter != '"')
    sign = decimal is None or decimal in SIGNS
    if not (single and sign) or (decimal is not None and delimiter == decimal):
        raise Unclear(
            f"cannot be read with the delimiter {shown(delimiter)} and the decimal sign {shown(decimal)}; the "
            "delimiter is one sign, the decimal sign a point or a comma, and they differ"
        )


def _agrees(reading: Reading, lines: Sequence[str], width: int, count: int | None) -> bool:
    """True for a table with as many columns as the user names, or with several and as many names above it."""
    if count is not None:
        return width == count
    return width > 1 and reading.start > 0 and reading.width(lines[reading.start - 1]) == width


def _fitting(lines: Sequence[str], readings: Sequence[Reading]) -> tuple[list[Reading], list[str]]:
    """Ways that read the lines from the first line of numbers on, with its index, and the lines that were tried."""
    rows = [(one, next((i for i, line in enumerate(lines[:200]) if one.is_row(line)), None)) for one in readings]
    started = [one._replace(start=start) for one, start in rows if start is not None]
    # only names stand above the numbers: what reads the more lines is right
    earliest = min((one.start for one in started), default=0)
    body = _sample(lines[earliest:])
    for sample in (body, body[: max(1, min(50, len(body) // 2))]):  # reading will say which of the other lines is wrong
        fits = [one for one in started if one.start == earliest and one.fits(sample)]
        if fits:
            break
    return fits, sample


def _with_texts(lines: Sequence[str], reading: Reading) -> Reading | None:
    """The way with its columns of text, by most cells of the second half; None where no column is of numbers."""
    half = lines[len(lines) // 2 : max(1, len(lines) - 1)]
    rows = [split(line, reading.delimiter) for line in half[:: max(1, len(half) // 200)]]
    width = max(map(len, rows), default=0)
    columns = [[row[i] for row in rows if i < len(row) and row[i] not in MISSING] for i in range(width)]
    texts = [i for i, cells in enumerate(columns) if 2 * sum(is_number(c, reading.decimal) for c in cells) < len(cells)]
    numbers = sum(map(bool, columns)) - len(texts)
    return reading._replace(texts=frozenset(texts)) if numbers else None


def _sample(lines: Sequence[str]) -> list[str]:
    """Lines on which dialects are tried; the last line may be cut off and is not among them, if there are others."""
    complete = lines[:-1] if len(lines) > 1 else lines
    return list(complete[:: max(1, -(-len(complete) // MOST_TRIED))])


def _thousands(lines: Sequence[str], reading: Reading) -> str:
    """The sign between thousands in lines of numbers, "" where there is none."""
    other = "," if reading.decimal == "." else "."
    mark = other if other != reading.delimiter else '"'  # the separator stands between thousands in quotes alone
    cells = (cell for line in lines if mark in line for cell in split(line, reading.delimiter))
    plain, grouped = PLAIN[reading.decimal], GROUPED[reading.decimal]
    return other if any(not plain.fullmatch(cell) and grouped.fullmatch(cell) for cell in cells) else ""
