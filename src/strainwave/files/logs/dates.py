"""Dates of ISO 8601 in a text table: they become seconds since the first of them."""

import re
from datetime import UTC, datetime
from typing import NamedTuple

# A comma stands before a fraction only where it cannot part columns.
DATE = re.compile(
    r"(?<![\w.:+-])(\d{4})-(\d\d)-(\d\d)[T ](\d\d):(\d\d)(?::(\d\d)(?:(?:\.|,(?=\d{1,9}\s*[\";\t]))(\d{1,9}))?)?"
    r"\s?(Z|UTC|[+-]\d\d(?::?\d\d)?)?(?![\w.:+-])"
)
NANOSECONDS = 1_000_000_000  # of a second
EPOCH = datetime(1970, 1, 1, tzinfo=UTC)


class Dated(NamedTuple):
    """Lines with seconds in place of dates.

    `first` is the date that counts as 0, "" without dates; `offsets` has for each line the indices of its dates.
    """

    lines: list[str]
    first: str
    offsets: list[list[int]]


class WrongDate(ValueError):
    """A date that is none; `line` is the index of its line."""

    def __init__(self, line: int, sentence: str) -> None:
        super().__init__(sentence)
        self.line = line


def in_seconds(lines: list[str], start: int = 0) -> Dated:
    """Lines, from `start` on, with seconds since the first date in place of dates, without a decimal sign: 15e-9.

    Raises
    ------
    WrongDate
        If a date is not in the calendar, or some dates have a time zone and others have none.
    """
    if not any(DATE.search(line) for line in (*lines[:200], *lines[-1:])):
        return Dated(lines, "", [])
    rows: list[str] = lines[:start]
    offsets: list[list[int]] = [[] for _ in rows]
    first, origin, zoned = "", 0, False
    for i, line in enumerate(lines[start:], start):
        text, line_offsets, end = "", [], 0
        for match in DATE.finditer(line):
            instant = _nanoseconds(i, match)
            if not first:
                first, origin, zoned = match.group(), instant, match.group(8) is not None
            if zoned != (match.group(8) is not None):
                raise WrongDate(i, f"has the date {match.group()}, and not all dates have a time zone; give it to all")
            text += line[end : match.start()]
            line_offsets.append(len(text))
            text += f"{instant - origin}e-9"
            end = match.end()
        rows.append(text + line[end:])
        offsets.append(line_offsets)
    return Dated(rows, first, offsets)


def _nanoseconds(line: int, match: re.Match[str]) -> int:
    """Nanoseconds since 1970, in UTC where there is a time zone."""
    year, month, day, hour, minute, second, fraction, zone = match.groups(default="")
    zone = zone if zone[:1] in ("+", "-") else "Z"
    try:
        date = datetime.fromisoformat(f"{year}-{month}-{day}T{hour}:{minute}:{second or '00'}{zone}")
    except ValueError:
        raise WrongDate(line, f"has {match.group()}, which is no date of the calendar; correct it") from None
    passed = date - EPOCH
    return (passed.days * 86_400 + passed.seconds) * NANOSECONDS + int(fraction.ljust(9, "0"))
