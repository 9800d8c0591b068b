"""A text table of numbers: CSV in any dialect, with or without names above the columns."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from importlib import import_module
from io import StringIO
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...base.number_text import counted
from ...base.quantities import joined
from ...base.results import Floats
from ..yaml_text import FileError, Problem, complaint, shown, text_of
from .dates import WrongDate, in_seconds
from .dialect import MISSING, Dialect, Unclear, find, header_cells, is_number, number, split
from .guide_log import GUIDE, guide_table
from .names import converted, named, unit_row

FILE_BYTES = 1024 * 1024 * 1024  # of a text file [bytes]
LINE_LETTERS = 1_000_000  # line of a table [characters]
COMMENTS = ("#", "%", "//")


@dataclass(frozen=True)
class Column:
    """One column of a file: its name, "" without one; its unit as written, "" without one; its values.

    `time` are the times [s] of the values, where the file has them for this column alone. A column of text has no
    values; `text` is what it says first.
    """

    name: str
    unit: str
    values: Floats
    time: Floats | None = None
    text: str = ""


class Lines(NamedTuple):
    """Lines of a text with content, and their numbers in the file; comments apart."""

    text: list[str]
    numbers: list[int]
    comments: list[tuple[int, str]]


Roles = dict[str, Column]  # columns by the channels that they are


def refuse(path: Path, sentence: str, line: int = 1, column: int = 1, what: str = "file") -> FileError:
    """Complaint about a file in one sentence."""
    return FileError(complaint(path, [Problem(line, column, what, sentence)]))


def read_table(
    path: Path, delimiter: str | None, decimal: str | None, count: int | None = None, kind: str = "log"
) -> tuple[list[Column], list[str], list[int]]:
    """Read a text table.

    Parameters
    ----------
    path : Path
        UTF-8, UTF-16 with its mark, or else Windows-1252, gzipped too; lines that begin with #, % or // are comments.
    delimiter, decimal : str or None
        Column separator and decimal sign, or None to find them.
    count : int or None
        Number of columns, if the user names all of them.
    kind : str
        Kind of the file, in words; of a log alone a last line may be cut off.

    Returns
    -------
    tuple of list of Column, list of str and list of int
        The columns, notes about guesses, and the line numbers of the rows.

    Raises
    ------
    FileError
        If the text is no table, or can be read in two ways.
    """
    notes: list[str] = []
    text = text_of(path, kind, FILE_BYTES, notes=notes)
    if text.startswith(GUIDE):
        table = guide_table(text)
        if not table:
            raise refuse(path, "is a guide log without a guided stretch; give one with lines of frames")
        return [Column(*column) for column in table[0]], *table[1:]
    lines = _lines(text)
    if not lines.text:
        raise refuse(path, f"is empty; give a {kind} with a line for each sample")
    for line_number, line in zip(lines.numbers, lines.text, strict=True):
        if len(line) > LINE_LETTERS:
            fault = f"has {len(line)} characters in one line; give a {kind} with a line for each sample"
            raise refuse(path, fault, line_number)
    try:
        dated = in_seconds(lines.text)
        dialect, start = find(dated.lines, delimiter, decimal, count)
        if any(dated.offsets[:start]):  # a date above the table is not where its time begins
            dated = in_seconds(lines.text, start)
    except Unclear as unclear:
        raise refuse(path, str(unclear)) from None
    except WrongDate as wrong:
        raise refuse(path, str(wrong), lines.numbers[wrong.line]) from None
    lines = lines._replace(text=dated.lines)
    if delimiter is None or decimal is None:
        notes.append(f"the file was read as {dialect}")
    width = len(split(lines.text[start], dialect.delimiter))
    header = [header_cells(line, dialect.delimiter) for line in lines.text[:start]]
    scope = _scope(header, width)
    names, units = scope or _header(path, lines, start, dialect, width, header)
    values, texts = _numbers(path, lines, start, dialect, notes, complete=kind != "log")
    for offset in dated.offsets[start] if dated.first else []:
        # what stands before a date, and one sign for the date itself
        units[len(split(lines.text[start][:offset] + "0", dialect.delimiter)) - 1] = "s"
    if dated.first:
        notes.append(f"dates were read as seconds since {dated.first}")
    columns = [Column(*row) for row in zip(names, units, values.T, [None] * width, texts, strict=True)]
    if scope:
        columns = [replace(c, time=1e-3 * t.values) for t, c in zip(columns[::2], columns[1::2], strict=True)]
    # a separator at the end of each line
    if len(columns) > 1 and not names[-1] and np.all(np.isnan(values[:, -1])):
        columns.pop()
    return columns, notes, lines.numbers[start : start + len(values)]


def unit_of(column: Column) -> str:
    """Unit that a file gives a column, "" without one."""
    return column.unit or named(column.name).unit


def index_of(path: Path, file: list[Column], channel: str, column: str | int, hint: str = "") -> int:
    """Index of the column of a channel, by its name or its index, which may be written as "0" (FileError)."""
    for names in ([c.name for c in file], [named(c.name).name for c in file]):
        if isinstance(column, str) and names.count(column) == 1:
            return names.index(column)
    if not isinstance(column, bool) and str(column).lstrip("-").isdecimal():
        if 0 <= int(column) < len(file):
            return int(column)
        fault = f"has {counted(len(file), 'column')}, so none at the place {column} for {channel}; 0 is the first"
        raise refuse(path, fault)
    available = ", ".join(c.name for c in file if c.name) or f"{counted(len(file), 'column')} without names, from 0 on"
    raise refuse(path, f"has no single column {shown(column)} for {channel}; it has {available}{hint}")


def rising_columns(
    path: Path, file: list[Column], lines: list[int], fields: Mapping[str, tuple[str, str]], hint: str, remedy: str,
    reverse: bool = False,
) -> list[Floats]:  # fmt: skip
    """Columns of a table in SI, all numbers finite and those of the first column ascending.

    Parameters
    ----------
    path : Path
        The file.
    file, lines
        As of `read_table`.
    fields : dict of str to (str, str)
        By field the name of its column, with its unit where the file does not give it, and the SI unit.
    hint, remedy : str
        Remedies for a missing column or unit, and for a first column that does not ascend.
    reverse : bool
        True for a first column that may descend throughout: all are then turned.
    """
    columns, indices = columns_in_si(path, file, lines, fields, hint)
    first, name = file[indices[0]].values, next(iter(fields))
    if reverse and len(first) > 1 and first[1] < first[0]:
        first, lines, columns = first[::-1], lines[::-1], [values[::-1] for values in columns]
    back = np.flatnonzero(np.diff(first) <= 0.0)
    if len(back):
        i = int(back[0])
        sentence = f"{first[i + 1]:.9g} stands after {first[i]:.9g} of line {lines[i]}; {remedy}"
        raise refuse(path, sentence, lines[i + 1], indices[0] + 1, name)
    return columns


def columns_in_si(
    path: Path, file: list[Column], lines: list[int], fields: Mapping[str, tuple[str, str]], hint: str
) -> tuple[list[Floats], list[int]]:  # fmt: skip
    """Columns of a table in SI, all numbers finite, and their indices; arguments as of `rising_columns`."""
    columns, indices = [], []
    for field, (text, kind) in fields.items():
        name, unit = named(text)
        index = index_of(path, file, field, name, f"; {hint}")
        file_unit, values = unit_of(file[index]), file[index].values
        if not (unit or file_unit):
            raise refuse(path, f"column {shown(name)} has no unit; {hint}", 1, index + 1, field)
        if unit and file_unit and unit != file_unit:
            fault = f"column {shown(name)} is in {file_unit} and was requested in {joined([unit])}; remove one unit"
            raise refuse(path, fault, 1, index + 1, field)
        if not np.all(np.isfinite(values)):
            i = int(np.flatnonzero(~np.isfinite(values))[0])
            raise refuse(path, "is not a finite number; correct it or remove the line", lines[i], index + 1, field)
        try:
            columns.append(np.asarray(converted(values, unit or file_unit, kind)))
        except ValueError as error:
            raise refuse(path, str(error), 1, index + 1, field) from None
        indices.append(index)
    return columns, indices


def _lines(text: str) -> Lines:
    rows: list[str] = []
    numbers: list[int] = []
    comments: list[tuple[int, str]] = []
    for line_number, line in enumerate(text.splitlines(), 1):
        bare = line.strip()
        if bare.startswith(COMMENTS):
            comments.append((line_number, bare.lstrip("#%/").strip()))
        elif bare:
            rows.append(line.strip("\r\n "))
            numbers.append(line_number)
    return Lines(rows, numbers, comments)


def _scope(header: list[list[str]], width: int) -> tuple[list[str], list[str]] | None:
    """Names and units of a TwinCAT Scope export, a pair of columns a channel: its times [ms], its values."""
    rows = {row[0]: row[1::2] for row in header if len(row) == width and set(row[::2]) == {row[0]}}
    if "Name" not in rows:
        return None
    units = [unit.split(" (")[0] for unit in rows.get("Unit", [""] * len(rows["Name"]))]
    usable = [unit if unit_row([unit]) else "" for unit in units]
    return [cell for name in rows["Name"] for cell in ("", name)], [cell for unit in usable for cell in ("ms", unit)]


def _header(
    path: Path, lines: Lines, start: int, dialect: Dialect, width: int, header: list[list[str]]
) -> tuple[list[str], list[str]]:  # fmt: skip
    """Names and units above the numbers, "" where there are none."""
    if not header:
        last = [c for n, c in lines.comments if n < lines.numbers[start]][-1:]
        cells = header_cells(last[0], dialect.delimiter) if last else []
        return (cells if len(cells) == width else [""] * width), [""] * width
    rows = [row for row in header if len(row) == width]
    if not rows:
        fact = f"names {len(header[-1])} columns and the lines below have {width} numbers"
        remedy = "give delimiter and decimal as the file is written"
        raise refuse(path, f"{fact}; {remedy}", lines.numbers[start - 1])
    units = next((row for row in rows[1:] if unit_row(row)), [""] * width)
    names = [row for row in rows if row is not units]
    last, above = names[-1], names[-2] if len(names) > 1 else [""] * width
    if len(set(last)) < len(last):  # a group of channels stands above its channels
        last = [f"{group} {name}".strip() for group, name in zip(above, last, strict=True)]
    return last, [unit.strip("[]() ") for unit in units]


def _numbers(
    path: Path, lines: Lines, start: int, dialect: Dialect, notes: list[str], *, complete: bool
) -> tuple[Floats, list[str]]:  # fmt: skip
    """Values (lines, columns), NaN where there is none, and what columns of text say first, "" of others."""
    body, d = lines.text[start:], dialect.delimiter
    widths = [len(split(line, d)) if d == " " or '"' in line else line.count(d) + 1 for line in body]
    width, cut = widths[0], not complete and len(body) > 1 and widths[-1] < widths[-2]
    body, widths = (body[:-1], widths[:-1]) if cut else (body, widths)
    odd = next((i for i, many in enumerate(widths) if many != width), len(body))
    if odd < len(body) and (complete or max(widths[odd:]) >= width):  # else channels end before others do
        text = f"has {widths[odd]} cells where the first line of numbers has {width}; correct the line"
        raise refuse(path, text, lines.numbers[start + odd])
    frame = import_module("pandas").read_csv(
        StringIO("\n".join(body)), sep=r"\s+" if d == " " else d, header=None, names=range(width), low_memory=False,
        decimal=dialect.decimal, keep_default_na=False, na_values=list(MISSING), skipinitialspace=True,
        quoting=3 if d == " " else 0,
    )  # fmt: skip
    if len(frame) != len(body):
        raise refuse(path, "has a quotation mark that is not closed; close it", lines.numbers[start])
    values, texts = np.full((len(body), width), np.nan), [""] * width
    for i in range(width):
        if frame[i].dtype.kind in "iuf":
            values[:, i] = frame[i]
            continue
        cells = ["" if cell != cell else str(cell).strip() for cell in frame[i]]
        wrong = [j for j, cell in enumerate(cells) if not is_number(cell, dialect.decimal)]
        if 2 * len(wrong) > sum(map(bool, cells)):
            texts[i] = next(filter(None, cells))
            continue
        if wrong == [len(body) - 1] and not complete:
            cut, wrong, cells[-1] = True, [], ""
        if wrong:
            text = f"has {shown(cells[wrong[0]])}, which is no number with {dialect}; correct it, or give delimiter and"
            raise refuse(path, f"{text} decimal", lines.numbers[start + wrong[0]], i + 1)
        values[:, i] = [number(cell, dialect) for cell in cells]
    if cut:
        notes.append(f"the last line ({lines.numbers[-1]}) is incomplete and was omitted")
    return values, texts
