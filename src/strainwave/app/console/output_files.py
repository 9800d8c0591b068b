"""Files with results, all of them or none.

They are written in a hidden folder inside the target and moved up when all are complete. An interrupted or failed run
therefore leaves no half-written report, and a folder that exists keeps its other files.
"""

import csv
import errno
import io
import os
import re
import shutil
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import click
import numpy as np
from numpy.typing import ArrayLike

from ...base.archive import refuse_inputs

KEY = "strainwave.written"  # of what the contexts of a command share


def note_written(folder: Path) -> None:
    """Note that the present command, if there is one, has written results in a folder."""
    context = click.get_current_context(silent=True)
    if context is not None:
        context.meta.setdefault(KEY, []).append(folder)


def written(context: click.Context) -> list[Path]:
    """Folders in which the command of a context has written results."""
    return list(context.meta.get(KEY, ()))


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


FULL = "free some space or choose another place; what was there before is unchanged"
TAKEN = "a file stands where a folder is to go; choose another place"
REMEDIES = dict.fromkeys((errno.ENOSPC, getattr(errno, "EDQUOT", errno.ENOSPC), errno.EFBIG), FULL) | {
    errno.ENAMETOOLONG: "choose a shorter path",
    errno.EACCES: "change its rights or choose another place",
    errno.EROFS: "choose another place",
    **dict.fromkeys((errno.EEXIST, errno.ENOTDIR), TAKEN),
}


@contextmanager
def staged(folder: Path, name: str = "") -> Iterator[Path]:
    """Give a temporary folder whose files replace those of the same name in `folder` when the block ends well.

    Where all that is written is one file, an error says its `name`.

    Raises
    ------
    OSError
        If the folder cannot be made or written; nothing is left behind.
    """
    folder = folder.resolve()
    new_folders = [p for p in (folder, *folder.parents) if not p.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        part = Path(tempfile.mkdtemp(prefix=".strainwave.", dir=folder))
    except OSError as error:
        error.filename = str(folder / name)
        _remove(new_folders)
        raise
    try:
        yield part
        files = sorted(part.iterdir(), key=lambda f: (f.name == "report.html", f.name))  # last: its files are there
        refuse_inputs(*(folder / file.name for file in files))
        for path in filter(Path.is_dir, (folder / file.name for file in files)):
            raise IsADirectoryError(errno.EISDIR, "a folder stands where a result is to go", str(path))
        for file in files:
            os.replace(file, folder / file.name)
        note_written(folder)
    except BaseException as error:
        shutil.rmtree(part, ignore_errors=True)
        _remove(new_folders)
        if isinstance(error, OSError) and (error.filename is None or part.name in str(error.filename)):
            error.filename = str(folder / name)
        raise
    shutil.rmtree(part, ignore_errors=True)


def check_writable(folder: Path, name: str = "") -> None:
    """Refuse a place that cannot be written (OSError); nothing is left there."""
    with suppress(InterruptedError), staged(folder, name):
        raise InterruptedError


def sentence(error: OSError) -> str:
    """Sentence on an error of the operating system: the place, the error and its remedy."""
    text = f"{error.filename or 'a file that was being written'}: {(error.strerror or type(error).__name__).lower()}"
    return "; ".join(filter(None, (text, REMEDIES.get(error.errno or 0))))


def _remove(folders: list[Path]) -> None:
    """Remove new folders of this run, the innermost first, as far as they are empty."""
    with suppress(OSError):
        for folder in folders:
            folder.rmdir()


def write_all(folder: Path, contents: Mapping[str, Any]) -> None:
    """Write all files at once, by name: texts, bytes, columns as of `write_csv`, and objects with `write`."""
    with staged(folder) as part:
        for name, content in contents.items():
            if isinstance(content, str):
                write_text(part / name, content.removesuffix("\n") + "\n")
            elif isinstance(content, bytes):
                (part / name).write_bytes(content)
            elif isinstance(content, list):
                write_csv(part / name, content)
            else:
                content.write(part / name)


def slug(text: str) -> str:
    """Turn a label into a file name: "primary, order 2" is "primary-order-2"."""
    return "-".join("".join(c if c.isalnum() else " " for c in text.lower()).split())
