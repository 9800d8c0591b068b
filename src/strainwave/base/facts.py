"""Facts of a result: each number is told once, with its key in JSON, its value in SI and its words.

The text of a result, the JSON of a command and the page are made of its `facts()`.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby
from typing import Any, NamedTuple

import numpy as np

from .number_text import number
from .quantities import LARGEST, shown
from .units import ARCSEC, RPM, angle_unit

UNITS = {  # what keys end in: the unit as it is printed, and its size in SI
    "_rad_per_N_m": ("rad/(N·m)", 1.0), "_N_m": ("N·m", 1.0), "_rad_per_s": ("rad/s", 1.0), "_rad": ("rad", 1.0),
    "_rad_per_s2": ("rad/s²", 1.0),
    "_arcsec": ("arcsec", ARCSEC),
    "_rpm_per_s": ("rpm/s", RPM), "_rpm": ("rpm", RPM), "_s": ("s", 1.0), "_h": ("h", 1.0), "_J": ("J", 1.0),
    "_kg_m2": ("kg·m²", 1.0), "_A": ("A", 1.0),
}  # fmt: skip

NUMBERS = re.compile(r"[−–\d.,×⁻⁰¹²³⁴-⁹ %]*")  # a cell of a table that holds numbers alone


class Fact(NamedTuple):
    """A number or a sentence of a result.

    Attributes
    ----------
    key : str
        In JSON, groups parted by dots, with the unit of UNITS at the end of the key or of its group; without one it is
        text alone.
    value : Any
        In SI; None where it is not known, several of a tuple, a tuple of facts of each row of a table.
    words : str
        Its place in the text, "{}" being the value with its unit; in a row of a table the head of its column. Without
        words it is in JSON alone. Facts of one group that follow each other share a line.
    """

    key: str
    value: Any
    words: str = ""


def data(facts: Iterable[Fact]) -> dict[str, Any]:
    """Facts as plain data, by their keys and in the units of these."""
    tree: dict[str, Any] = {}
    for fact in facts:
        if fact.key:
            *groups, name = fact.key.split(".")
            branch = tree
            for group in groups:
                branch = branch.setdefault(group, {})
            branch[name] = _in_unit(fact.value, _unit_of(fact.key)[1])
    return tree


def lines(facts: Iterable[Fact]) -> Iterator[str]:
    """Lines of the text of facts: one for each group that is told, and for each sentence of several."""
    for group, some in groupby((fact for fact in facts if fact.words), lambda fact: fact.key.rpartition(".")[0]):
        parts = [part for fact in some for part in _printed(fact)]
        if group:
            name = group.removesuffix(_ending_of(group)).replace("_", " ")
            yield f"{name}: {', '.join(parts)}"
        else:
            yield from parts


def table(rows: Sequence[Sequence[Fact]]) -> list[list[str]]:
    """Cells of rows of facts as texts, their heads with the units first; facts without words are left out."""
    printed = [[fact for fact in row if fact.words] for row in rows]
    columns = [(fact.words, *_unit_of(fact.key)) for fact in printed[0]]
    heads = [f"{words} [{unit}]" if unit else words for words, unit, _ in columns]
    sizes = [size for *_, size in columns]
    return [heads, *([number(_in_unit(f.value, size)) for f, size in zip(row, sizes, strict=True)] for row in printed)]


def aligned(cells: Sequence[Sequence[str]]) -> Iterator[str]:
    """Lines of a table of texts, its heads first; columns of numbers stand to the right."""
    columns = list(zip(*cells, strict=True))
    pads = [str.rjust if all(map(NUMBERS.fullmatch, column[1:])) else str.ljust for column in columns]
    widths = [max(map(len, column)) for column in columns]
    for row in cells:
        yield "  ".join(pad(cell, width) for pad, cell, width in zip(pads, row, widths, strict=True)).rstrip()


def _printed(fact: Fact) -> Iterator[str]:
    several = fact.value if isinstance(fact.value, tuple) else (fact.value,)
    if _is_table(fact.value):
        yield from aligned(table(fact.value))
    elif all(isinstance(value, str) for value in several):
        yield from map(fact.words.format, several)
    else:
        yield fact.words.format(", ".join(_shown(value, *_unit_of(fact.key)) for value in several))


def _shown(value: Any, unit: str, size: float) -> str:
    if unit == "rad" and value is not None:
        unit, size = angle_unit(abs(value))
    value = shown(value) if isinstance(value, int) and abs(value) > LARGEST else value  # a seed
    return number(value) if value is None or isinstance(value, str) else f"{number(value / size)} {unit}".rstrip()


def _ending_of(key: str) -> str:
    return next((ending for ending in UNITS if key.endswith(ending)), "")


def _unit_of(key: str) -> tuple[str, float]:
    """Unit of a key, or of the innermost of its groups that says one."""
    return next((UNITS[end] for part in reversed(key.split(".")) if (end := _ending_of(part))), ("", 1.0))


def _in_unit(value: object, size: float) -> Any:
    if isinstance(value, tuple) and not hasattr(value, "_fields"):
        return [data(item) if _is_table(value) else _in_unit(item, size) for item in value]
    return value / size if size != 1.0 and isinstance(value, float | np.ndarray) else value


def _is_table(value: object) -> bool:
    rows = value if isinstance(value, tuple) else ()
    return bool(rows) and all(isinstance(row, tuple) and bool(row) and isinstance(row[0], Fact) for row in rows)
