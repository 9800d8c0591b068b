"""Folders in which a command has written results, which it says where it is interrupted."""

from pathlib import Path

import click

KEY = "strainwave.written"  # of what the contexts of a command share


def note_written(folder: Path) -> None:
    """Note that the present command, if there is one, has written results in a folder."""
    context = click.get_current_context(silent=True)
    if context is not None:
        context.meta.setdefault(KEY, []).append(folder)


def written(context: click.Context) -> list[Path]:
    """Folders in which the command of a context has written results."""
    return list(context.meta.get(KEY, ()))
