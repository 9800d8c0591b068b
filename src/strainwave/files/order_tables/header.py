"""Remarks at the head of a file: what the numbers below them mean, and what the file leaves of the table.

A line is `key = value` after the mark of a comment. Readers take from them what the format itself does not hold.
"""

import json
import re
from collections.abc import Iterable
from typing import Any

from ...units import NUMBER, shown
from ..yaml_text import Problem
from .content import CHOICES, OrderContent

MARK = "strainwave order table"
KEYS = ("unit", "turn", "ratio", "zero", "sign", "direction", "delay", "speeds", "load", "source")
LINE = re.compile(r"\s*(?:#|//|;|\(\*)\s*(\w+(?: \w+)?) = (.{0,30000})")


class Unfit(ValueError):
    """A file is no table of its format; the first argument is the `Problem`."""

    def __init__(self, line: int, field: str, sentence: str) -> None:
        super().__init__(Problem(line, 1, field, sentence))


def remarks(name: str, table: OrderContent, said: Iterable[str], options: dict[str, Any]) -> list[str]:
    """Head of a file as lines without the comment's mark, in plain ASCII."""
    known = {key: getattr(table, key) for key in KEYS}
    rows = [f"{MARK}: {name}"]
    for key, value in known.items():
        if value is not None and value != "":
            rows.append(f"{key} = {_written(value)}")
    rows += [f"option {key} = {_written(value)}" for key, value in options.items()]
    return [*rows, *said]


def _written(value: Any) -> str:
    if isinstance(value, tuple):
        return " ".join(map(repr, value))
    if isinstance(value, str) and value not in [word for words in CHOICES.values() for word in words]:
        return json.dumps(value).replace("*", "\\u002a").replace("/", "\\u002f")
    return value if isinstance(value, str) else repr(value)


def said_by(text: str) -> tuple[dict[str, Any], dict[str, str]]:
    """Fields of the table and options of the format that the remarks of a file give.

    Raises
    ------
    Unfit
        If a remark has a value that is none.
    """
    fields: dict[str, Any] = {}
    options: dict[str, str] = {}
    for number, line in enumerate(text.splitlines(), start=1):
        match = LINE.match(line)
        if match is None:
            continue
        key, value = match.group(1), match.group(2).rstrip().removesuffix("*)").rstrip()
        if key.startswith("option "):
            options[key.removeprefix("option ")] = _text(number, key, value) if value.startswith('"') else value
        elif key in KEYS:
            fields[key] = _field(number, key, value)
    return fields, options


def _field(line: int, key: str, value: str) -> Any:
    if key in CHOICES:
        if value not in CHOICES[key]:
            raise Unfit(line, key, f"{shown(value)} is not known; write one of {', '.join(CHOICES[key])}")
        return value
    if key == "source":
        return _text(line, key, value)
    if key == "speeds":
        return tuple(float_in(line, key, part) for part in value.split())
    return float_in(line, key, value)


def _text(line: int, key: str, value: str) -> str:
    try:
        found = json.loads(value)
    except ValueError:
        found = None
    if not isinstance(found, str):
        raise Unfit(line, key, f"{shown(value)} is no text in double quotes; write it so")
    return found


def float_in(line: int, field: str, text: str) -> float:
    """Finite number in a file (Unfit)."""
    plain = text.strip()
    value = float(plain) if len(plain) <= 60 and NUMBER.fullmatch(plain) else float("nan")
    if not abs(value) <= 1e60:
        raise Unfit(line, field, f"{shown(plain)} is no finite number; correct it")
    return value


def whole_in(line: int, field: str, text: str, low: int, high: int) -> int:
    """Whole number between two bounds in a file (Unfit)."""
    plain = text.strip()
    value = int(plain) if re.fullmatch(r"[+-]?[0-9]{1,9}", plain) else None
    if value is None or not low <= value <= high:
        raise Unfit(line, field, f"{shown(plain)} is no whole number from {low} to {high}; correct it")
    return value
