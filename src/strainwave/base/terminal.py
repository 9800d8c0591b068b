"""Output for a person at a terminal: lines that fit the screen, names of files, and progress."""

from collections.abc import Callable
from textwrap import wrap
from typing import Any

WIDTH, HEIGHT = 120, 25  # letters of a line and lines of a screen
Progress = Callable[[str, float], None]  # progress(stage, share): called before each stage


def silent(*_: Any) -> None:
    """Report no progress: the default of an argument `progress`."""


def printable(name: str) -> str:
    """A file's name as text of UTF-8; bytes of it that are none are escaped."""
    return name.encode("utf-8", "backslashreplace").decode()


def on_screen(text: str) -> str:
    """Text as a result prints it: long lines wrapped, and of more lines than a screen has the first ones."""
    lines = [part for line in text.split("\n") for part in _wrapped(line)]
    if len(lines) > HEIGHT:
        lines = [*lines[: HEIGHT - 1], f"  ... and {len(lines) - HEIGHT + 1} lines more"]
    return "\n".join(lines)


def _wrapped(line: str) -> list[str]:
    return [line] if len(line) <= WIDTH else wrap(line, WIDTH, subsequent_indent="  ")
