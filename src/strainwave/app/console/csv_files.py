"""CSV files: tables of numbers with units, and tables with words."""

import csv
import io
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike


def write_text(path: Path, text: str) -> None:
    """Write a text as UTF-8, with the same ends of lines on every system."""
    path.write_text(text, encoding="utf-8", newline="\n")


def write_csv(path: Path, columns: Sequence[tuple[str, ArrayLike]]) -> None:
    """Write columns of equal length; each name carries its unit ("x_rad"); one with a comma is quoted."""
    body = np.column_stack([np.asarray(values, float) for _, values in columns])
    row = ",".join(["%.8g"] * len(columns)) + "\n"  # in one go: `csv` takes many times as long for numbers
    write_text(path, _lines([[name for name, _ in columns]]) + (row * len(body)) % tuple(body.ravel().tolist()))


def as_csv(header: list[str], rows: Iterable[Iterable[Any]]) -> str:
    """Write a table with words as CSV; a number that is not known is empty."""
    cells = ([f"{x:.8g}".replace("nan", "") if isinstance(x, float) else x for x in row] for row in rows)
    return _lines([header, *cells])


def _lines(rows: Iterable[Iterable[Any]]) -> str:
    """Rows of cells as lines of CSV, quoted where they have to be."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


def columns(*tables: Mapping[str, tuple[Any, Any, str]]) -> list[tuple[str, ArrayLike]]:
    """Columns of a file from the arrays of a result: each name carries its unit."""
    return [(f"{name}{ending(unit)}", values) for arrays in tables for name, (_, values, unit) in arrays.items()]


def ending(unit: str) -> str:
    """A unit as the end of a column's name."""
    return "_".join(["", *re.findall(r"(?!1$)\w+", unit.replace("1/", "per ").replace("/", " per "))])
