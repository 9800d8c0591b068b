"""Dialect of a text table, the unit in a column's name, and the canonical channel that a name stands for.

All pairs of column separator and decimal sign are tried on the lines, with a sign between thousands. A file that two
pairs read as different tables is refused: a German table must not become a wrong one.
"""

import csv
import math
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from math import pi
from typing import NamedTuple

import numpy as np

from ...base.quantities import shown
from ...base.results import Floats
from ...base.units import NUMBER, convert, parse
from ...study.identification.run import CANONICAL

DELIMITERS = (";", "\t", ",", " ")
NAMES = {";": "semicolons", "\t": "tabs", ",": "commas", " ": "blanks"}
SIGNS = {".": "a point", ",": "a comma"}
MISSING = frozenset((
    "", "nan", "NaN", "NAN", "-nan", "inf", "-inf", "+inf", "Inf", "-Inf", "+Inf", "INF", "-INF", "infinity",
    "Infinity", "-Infinity", "NA", "N/A", "null", "NULL", "None", "#N/A", "1.#INF", "-1.#INF", "1.#QNAN", "-1.#IND",
    "1,#INF", "-1,#INF", "1,#QNAN", "-1,#IND",
))  # fmt: skip
NO_TEXT: frozenset[int] = frozenset()
Signs = tuple[str, str]  # delimiter and decimal sign
Reading = tuple[str, str, int]  # both, and the first line of numbers
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


def is_row(cells: list[str], decimal: str) -> bool:
    """True for a line whose cells are all numbers, one at least with a digit."""
    return all(is_number(c, decimal) for c in cells) and any(c not in MISSING for c in cells)


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
    single = delimiter is None or (len(delimiter) == 1 and delimiter != '"')
    sign = decimal is None or decimal in SIGNS
    if not (single and sign) or (decimal is not None and delimiter == decimal):
        raise Unclear(
            f"cannot be read with the delimiter {shown(delimiter)} and the decimal sign {shown(decimal)}; the "
            "delimiter is one sign, the decimal sign a point or a comma, and they differ"
        )
    delimiters, signs = DELIMITERS if delimiter is None else (delimiter,), SIGNS if decimal is None else (decimal,)
    pairs = [(d, s) for d in delimiters for s in signs if d != s]
    fits, sample, earliest = _fitting(lines, dict.fromkeys(pairs, NO_TEXT))
    texts = dict.fromkeys(pairs, NO_TEXT)
    if not fits:
        columns = {pair: text for pair in pairs if (text := _text_columns(lines, *pair)) is not None}
        texts |= columns
        fits, sample, earliest = _fitting(lines, columns)
        width = max((_columns(sample[0], d) - len(texts[d, s]) for d, s, _ in fits), default=0)
        fits = [(d, s, i) for d, s, i in fits if _columns(sample[0], d) - len(texts[d, s]) == width]
    if not fits:
        raise Unclear(
            "has no table of numbers whose lines have equally many cells; give delimiter and decimal as it is written, "
            "write dates as 2026-11-23T13:37:38, and remove lines of text between the numbers"
        )
    tables: dict[tuple[tuple[str, ...], ...], Reading] = {}
    for reading in sorted(fits, key=lambda reading: _columns(lines[earliest], reading[0]) == 1):
        tables.setdefault(_read(sample, *reading[:2], texts[reading[:2]]), reading)
    if len(tables) > 1:
        tables = {cells: one for cells, one in tables.items() if _agrees(cells, lines, one, count)} or tables
    if len(tables) > 1:
        first, second = [Dialect(d, s) for d, s, _ in tables.values()][:2]
        raise Unclear(
            f"can be read in two ways, with {first}, or with {second} (line {lines[earliest].strip()[:60]!r}); give "
            "delimiter and decimal"
        )
    d, s, start = next(iter(tables.values()))
    other = "," if s == "." else "."
    apart = [line for line in lines[start:] if (other in line if other != d else '"' in line)]
    grouped = any(_is_grouped(cell, s) for line in apart for cell in split(line, d))
    return Dialect(d, s, other if grouped else ""), start


def _agrees(table: tuple[tuple[str, ...], ...], lines: Sequence[str], reading: Reading, count: int | None) -> bool:
    """True for a table with as many columns as the user names, or with several and as many names above it."""
    width = len(table[0])
    if count is not None:
        return width == count
    delimiter, _, start = reading
    return width > 1 and start > 0 and _columns(lines[start - 1], delimiter) == width


def _fitting(lines: Sequence[str], texts: Mapping[Signs, frozenset[int]]) -> tuple[list[Reading], list[str], int]:
    """Pairs of signs that read the lines, apart from columns of text; the lines tried; the first line of numbers."""
    readings = [(d, s, start) for (d, s), text in texts.items() if (start := _first(lines, d, s, text)) is not None]
    # only names stand above the numbers: what reads the more lines is right
    earliest = min((start for _, _, start in readings), default=0)
    body = _sample(lines[earliest:])
    for sample in (body, body[: max(1, min(50, len(body) // 2))]):  # reading will say which of the other lines is wrong
        fits = [(d, s, i) for d, s, i in readings if i == earliest and _fits(sample, d, s, texts[d, s])]
        if fits:
            break
    return fits, sample, earliest


def _text_columns(lines: Sequence[str], delimiter: str, decimal: str) -> frozenset[int] | None:
    """Indices of columns of text, by most cells of the second half; None where no column is of numbers."""
    half = lines[len(lines) // 2 : max(1, len(lines) - 1)]
    rows = [split(line, delimiter) for line in half[:: max(1, len(half) // 200)]]
    width = max(map(len, rows), default=0)
    columns = [[row[i] for row in rows if i < len(row) and row[i] not in MISSING] for i in range(width)]
    texts = [i for i, cells in enumerate(columns) if 2 * sum(is_number(c, decimal) for c in cells) < len(cells)]
    numbers = sum(map(bool, columns)) - len(texts)
    return frozenset(texts) if numbers else None


def _cells(line: str, delimiter: str, texts: frozenset[int]) -> list[str]:
    """Cells of a line, those of text empty."""
    cells = split(line, delimiter)
    return ["" if i in texts else cell for i, cell in enumerate(cells)] if texts else cells


def _first(lines: Sequence[str], delimiter: str, decimal: str, texts: frozenset[int]) -> int | None:
    """Index of the first line of numbers among the first 200."""
    rows = (_cells(line, delimiter, texts) for line in lines[:200])
    return next((i for i, row in enumerate(rows) if len(row) > max(texts, default=0) and is_row(row, decimal)), None)


def _sample(lines: Sequence[str]) -> list[str]:
    """Lines on which dialects are tried; the last line may be cut off and is not among them, if there are others."""
    complete = lines[:-1] if len(lines) > 1 else lines
    return list(complete[:: max(1, -(-len(complete) // MOST_TRIED))])


def _columns(line: str, delimiter: str) -> int:
    return len(split(line, delimiter))


def _fits(lines: list[str], delimiter: str, decimal: str, texts: frozenset[int]) -> bool:
    count = _columns(lines[0], delimiter)
    for line in lines:
        cells = _cells(line, delimiter, texts)
        if len(cells) != count or not all(is_number(cell, decimal) for cell in cells):
            return False
    return True


def _is_grouped(cell: str, decimal: str) -> bool:
    return PLAIN[decimal].fullmatch(cell) is None and GROUPED[decimal].fullmatch(cell) is not None


def _read(lines: list[str], delimiter: str, decimal: str, texts: frozenset[int]) -> tuple[tuple[str, ...], ...]:
    """Cells as they are read: equal for dialects that read the same table."""
    dialect = Dialect(delimiter, decimal)
    return tuple(tuple(repr(number(cell, dialect)) for cell in _cells(line, delimiter, texts)) for line in lines)


KINDS = ("rad", "rad/s", "rad/s**2", "N*m", "s", "A", "V", "Hz", "K", "m", "N")  # SI units of channels
QUANTITIES = {
    "angle": ("angle", "position", "pos", "theta", "q", "winkel"),
    "speed": ("speed", "velocity", "vel", "velo", "omega", "dq", "qd", "drehzahl"),
    "torque": ("torque", "tau", "moment", "drehmoment", "effort"),
}
SHAFTS = {"motor": ("motor", "m"), "load": ("load", "l", "output", "joint", "link", "")}
FILLERS = re.compile(r"(?i)(?<![a-z])(act|actual|meas|measured|msr|estimate|encoder)(?![a-z])_?|_(?=estimate)")
UNMEASURED = re.compile(r"(?i)(pos|vel)_estimate|servo_stats|moteus|odrive|(motor|load)inc|counts?|ticks?")  # no angles
_OWN = {
    "time": ("time", "t", "timestamp", "zeit", "zeit_in_sec", "sec", "secs", "datetime", "date_time", "date", "datum"),
    "current": ("current", "motor_current", "strom"),
    "torsion": ("torsion", "twist"),
    "input": ("input",),
    "output": ("output",),
}
# In a name without brackets these endings are units; a single m is the motor.
ENDINGS = {
    "s": "s", "ms": "ms", "us": "us", "ns": "ns", "rad": "rad", "mrad": "mrad", "deg": "deg", "arcmin": "arcmin",
    "arcsec": "arcsec", "rev": "rev", "turns": "rev", "rad_per_s": "rad/s", "rad_s": "rad/s", "rads": "rad/s",
    "deg_per_s": "deg/s", "deg_s": "deg/s", "rpm": "rpm", "rev_per_s": "rev/s", "nm": "N*m", "n_m": "N*m",
    "mnm": "mN*m", "ncm": "N*cm", "a": "A", "ma": "mA", "v": "V", "mv": "mV", "hz": "Hz",
}  # fmt: skip
EPOCH = 978_307_200.0, 4_102_444_800.0  # s from 1970 to 2001 and to 2100
_SPELT = dict.fromkeys(("1/min", "min-1", "min^-1", "u/min"), "rpm")
_SPELT |= {"grad": "deg", "°/s": "deg/s", "rps": "rev/s"}


class Named(NamedTuple):
    """A column's name without its unit, and the unit, "" without one."""

    name: str
    unit: str


def header_cells(line: str, delimiter: str) -> list[str]:
    """Cells of a line of names; blanks part them outside of brackets only."""
    if delimiter != " ":
        return split(line, delimiter)
    return re.findall(r"[^\s\[(]+(?:\s*(?:\[[^\]]*\]|\([^)]*\)))?", line)


def unit_row(cells: list[str]) -> bool:
    """True for a line below the names that holds units: some, and nothing else."""
    bare = [cell.strip("[]() ") for cell in cells]
    return any(bare) and all(not cell or cell in ("-", "dB") or si_unit(cell) is not None for cell in bare)


def named(cell: str) -> Named:
    """Name and unit of "speed [rpm]", "pos (deg)", "Zeit / s", "velocity_rad_per_s"."""
    text = cell.strip().strip('"')
    for pattern in (r"(.+?)\s*\[([^\[\]]*)\]", r"(.+?)\s*\(([^()]*)\)", r"(.+?)\s+/\s+(\S+)", r"(.+?)\s+in\s+(\S+)"):
        match = re.fullmatch(pattern, text)
        if match and match.group(2).isdigit():
            continue  # an index
        if match and (pattern.endswith("]") or si_unit(match.group(2)) is not None):
            return Named(match.group(1).strip(), match.group(2).strip())
    parts = text.split("_")
    for count in (3, 2, 1):
        ending = "_".join(parts[-count:]).lower()
        if len(parts) > count and ending in ENDINGS:
            return Named("_".join(parts[:-count]), ENDINGS[ending])
    return Named(text, "")


def canonical(name: str) -> str | None:
    """Canonical channel, or "time", that a column's name stands for."""
    words = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name.strip())
    plain = re.sub(r"[^a-z0-9]+", "_", words.lower()).strip("_")
    for channel, names in _OWN.items():
        if plain in names:
            return channel
    parts = plain.split("_")
    for quantity, names in QUANTITIES.items():
        if sum(part in names for part in parts) == 1 and len(parts) <= 2:
            prefix = "".join(part for part in parts if part not in names)
            shaft = next((shaft for shaft, called in SHAFTS.items() if prefix in called), None)
            if shaft is None:
                continue
            return "torque" if quantity == "torque" and not prefix else f"{shaft}_{quantity}"
    return None


def suffixed(name: str) -> str | None:
    """Canonical channel that the end of a longer name stands for: "/arm/position", "encoder.pos_estimate", "ActPos"."""
    last = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", re.split(r"[/.]", name.strip("/."))[-1])
    return canonical(re.sub(r"(?i)(motor|load)inc$", r"\1_pos", FILLERS.sub("", last)))


def si_unit(unit: str) -> str | None:
    """SI unit of what a unit measures, or None if it is not known."""
    for kind in KINDS:
        with suppress(ValueError):
            convert(1.0, _spelt(unit), kind)
            return kind
    return None


def converted(values: Floats, unit: str | float, kind: str) -> Floats:
    """Values in SI.

    Parameters
    ----------
    values : (n,) array
        As they stand in the file.
    unit : str or float
        Their unit; or the size of 1, "0.088 deg" or a number in SI.
    kind : str
        The SI unit.

    Raises
    ------
    ValueError
        If the unit is not known or measures something else.
    """
    if isinstance(unit, str):
        text = unit.strip()
        sized = NUMBER.match(text) is not None and _spelt(text) == text and not text.startswith("1/")
        return values * parse(text, kind) if sized else convert(values, _spelt(text), kind)
    return values * float(unit)


def expected(channel: str) -> str:
    """SI unit of a canonical channel or the time, "" of others."""
    return "s" if channel == "time" else CANONICAL.get(channel, "")


def epoch_unit(time: Floats) -> str:
    """Unit in which times without one count from 1970: "ms", "us" or "ns"; "" where they do not.

    Of 2001 to 2100, in steps of less than a minute: times since a computer was started, in ns, may have the size of
    those since 1970 in ms.
    """
    finite = time[np.isfinite(time)]
    for unit, size in (("ms", 1e3), ("us", 1e6), ("ns", 1e9)):
        if len(finite) > 1 and EPOCH[0] <= np.min(finite) / size and np.max(finite) / size <= EPOCH[1]:
            return unit if np.median(np.abs(np.diff(finite))) / size < 60.0 else ""
    return ""


def _spelt(unit: str) -> str:
    return _SPELT.get(unit.strip().lower(), unit.strip())


TURN = 2.0 * pi
