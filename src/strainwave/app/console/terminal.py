"""Results on the terminal: as JSON, as lines of text that wrap, and as tables."""

import json
import math
import re
import shutil
import sys
from collections.abc import Iterable, Sequence
from textwrap import wrap
from typing import Any

import click

from ...base.facts import Fact, aligned, data, lines
from ...base.number_text import number
from .library_words import in_options


def plain(value: Any) -> Any:
    """Turn a value into types of JSON; numbers that are not finite become None."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, str | bool) or value is None:
        return value
    if hasattr(value, "tolist"):
        finite = value.dtype.kind in "biu" or (value.dtype.kind == "f" and bool((value - value == 0.0).all()))
        return value.tolist() if finite else plain(value.tolist())
    if isinstance(value, int):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Iterable):
        return [plain(item) for item in value]
    return str(value)


def to_json(value: object) -> str:
    """Write a value as JSON without NaN."""
    return json.dumps(plain(value), indent=2, ensure_ascii=False, allow_nan=False)


def reported(title: str, facts: Sequence[Fact], as_json: bool, *more: str) -> str:
    """Facts of a result as JSON, or as text: failures, then a title with the other facts and more lines below it."""
    if as_json:
        return to_json({"title": title} | data(facts))
    fails = len(facts[0].value) if facts[0].key == "failures" else 0
    rows = [in_options(row) for row in (*lines(facts), *more)]
    return "\n".join([*rows[:fails], title, *(f"  {line}" for line in rows[fails:])])


def echo(text: str, err: bool = False) -> None:
    """Print the text of a result; on a terminal its prose wraps at the width, and tables and JSON stay."""
    if (sys.stderr if err else sys.stdout).isatty() and text[:1] not in ("{", "["):
        width = shutil.get_terminal_size().columns
        text = "\n".join(part for line in text.split("\n") for part in _wrapped(line, width))
    click.echo(text, err=err)


def _wrapped(line: str, width: int) -> list[str]:
    if len(line) <= width or re.search(r"\S {2,}\S", line):  # a line of a table
        return [line]
    indent = line[: len(line) - len(line.lstrip())]
    return wrap(line, width, subsequent_indent=f"{indent}  ", break_long_words=False, break_on_hyphens=False)


def print_table(title: str, columns: Sequence[str], rows: Iterable[Sequence[Any]], caption: str = "") -> None:
    """Print a table on stdout."""
    cells = [list(columns), *([number(cell) for cell in row] for row in rows)]
    print("\n".join(filter(None, [title, *(f" {line}" for line in aligned(cells)), *wrap(caption, 80)])))
