"""Files with results, all of them or none.

They are written in a hidden folder inside the target and moved up when all are complete. An interrupted or failed run
therefore leaves no half-written report, and a folder that exists keeps its other files.
"""

import errno
import os
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from ...base.archive import refuse_inputs
from .csv_files import write_csv, write_text
from .written import note_written

FULL = "free some space or choose another place; existing files are unchanged"
TAKEN = "a file has the name of the required folder; choose another place"
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
            raise IsADirectoryError(errno.EISDIR, "a folder has the name of the result file", str(path))
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
