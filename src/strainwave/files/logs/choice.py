"""Columns, units and rate that a user chose for a log, kept in a file beside it."""

import json
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from .table import refuse

ENDING = ".columns.json"
ARGUMENTS: dict[str, Any] = {"columns": (list, dict), "units": dict, "rate": (int, float), "joint": str}  # of read_log


def keep_choice(log: Path, choice: Mapping[str, Any]) -> str:
    """Write a choice beside a log; the name of its file, or "" where the folder cannot be written."""
    path = log.with_name(log.name + ENDING)
    with suppress(OSError):
        path.write_text(json.dumps(choice, indent=1) + "\n", encoding="utf-8")
        return path.name
    return ""


def kept_choice(log: Path) -> dict[str, Any]:
    """Arguments of read_log that are kept beside a log; none without such a file.

    Raises
    ------
    FileError
        If the file holds no choice.
    """
    path = log.with_name(log.name + ENDING)
    if not path.exists():
        return {}
    with suppress(OSError, ValueError):
        choice = json.loads(path.read_text(encoding="utf-8"))
        if isinstance(choice, dict) and all(isinstance(choice[name], ARGUMENTS.get(name, ())) for name in choice):
            return choice
    raise refuse(path, f"is no choice of {', '.join(ARGUMENTS)}; delete it, or give them anew")
