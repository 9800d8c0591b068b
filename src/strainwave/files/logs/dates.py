"""Dates of ISO 8601 in a text table: they become seconds since the first of them."""

import re
from datetime import UTC, datetime
from typing import NamedTuple

# A comma stands before a fraction only where it cannot part columns.
DATE = re.compile(
    r"(?<![\w.:+-])(\d{4})-(\d\d)-(\d\d)[T ](\d\d):(\d\d)(?::(\d\d)(?:(?:\.|,(?=\d{1,9}\s*[\";\t]))(\d{1,9}))?)?"
    r"\s?(Z|UTC|[+-]\d\d(?::?\d\d)?)?(?![\w.:+-])"
)
NANO = 1_000_000_000
EPOCH = datetime(1970, 1, 1, tzinfo=UTC)


class Dated(NamedTuple):
    """Lines with seconds in place of dates.

    `first` is the date that counts as 0, "" without dates; `places` has for each line where in it dates stood.
    """

    lines: list[str]
    first: str
    places: list[list[int]]


class WrongDate(ValueError):
    """A date that is none; `line` is its place among the lines."""

    def __init__(self, line: int, said: str) -> None:
        super().__init__(said)
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
    made: list[str] = lines[:start]
    places: list[list[int]] = [[] for _ in made]
    first, origin, zoned = "", 0, False
    for i, line in enumerate(lines[start:], start):
        text, at, end = "", [], 0
        for match in DATE.finditer(line):
            now = _nanoseconds(i, match)
            if not first:
                first, origin, zoned = match.group(), now, match.group(8) is not None
            if zoned != (match.group(8) is not None):
                raise WrongDate(i, f"has the date {match.group()}, and not all dates have a time zone; give it to all")
            text += line[end : match.start()]
            at.append(len(text))
            text += f"{now - origin}e-9"
            end = match.end()
        made.append(text + line[end:])
        places.append(at)
    return Dated(made, first, places)


def _nanoseconds(line: int, match: re.Match[str]) -> int:
    """Nanoseconds since 1970, in UTC where there is a time zone."""
    year, month, day, hour, minute = (int(match.group(i)) for i in range(1, 6))
    try:
        date = datetime(year, month, day, hour, minute, int(match.group(6) or 0), tzinfo=UTC)
    except ValueError:
        raise WrongDate(line, f"has {match.group()}, which is no date of the calendar; correct it") from None
    passed = date - EPOCH
    zone = (match.group(8) or "").replace(":", "")
    ahead = 0
    if zone[:1] in ("+", "-"):
        ahead = (int(zone[1:3]) * 3600 + int(zone[3:] or 0) * 60) * (1 if zone[0] == "+" else -1)
    seconds = passed.days * 86_400 + passed.seconds - ahead
    return seconds * NANO + int((match.group(7) or "").ljust(9, "0"))
