"""Output of commands: progress on stderr, tables and JSON on stdout, numbers as text; and files.

Files are written in a hidden folder inside the target and moved up when all are complete. An interrupted or failed run
therefore leaves no half-written report, and a folder that exists keeps its other files.
"""

import atexit
import csv
import errno
import io
import json
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
from ast import literal_eval
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from shlex import quote
from textwrap import wrap
from threading import Event, Thread
from time import monotonic
from typing import Any, TypeVar

import click
import numpy as np
from numpy.typing import ArrayLike

from ..base.archive import refuse_inputs
from ..base.facts import Fact, aligned, data, lines
from ..base.number_text import number as number
from ..base.number_text import percent as percent
from ..base.results import Interrupted
from ..compile import jit
from ..compile.cache import cache_writable, compiling, is_empty

T = TypeVar("T")

FIRST_LINE_S, NEXT_LINE_S = 1.0, 60.0  # progress where stderr is no terminal: seconds to its first line, and between
BAR_FROM, BAR_LETTERS = 80, 29  # columns of a terminal from which on a bar is drawn, and letters of it with the time
TICK = 0.25  # seconds between looks at what is compiled
SHORT = 1.0  # seconds of a run whose time left is not shown
# What the errors are, wherever a command or the report shows one.
WHAT_X_IS = (
    "pointing error = reference angle of the motor/N − angle of the load; error between motor and load: "
    "x = θ_m/N − θ_l; with an ideally held motor both are equal"
)


class Progress:
    """Progress of one run on stderr: a bar on a terminal, elsewhere a line after a second and one a minute.

    The time left follows from the share that is finished; what is compiled on the way is announced, and not counted.
    """

    def __init__(self, title: str) -> None:
        self.title = title
        self.stage, self.share, self.total = "", 0.0, 0.0  # total: seconds of the whole run, 0 while unknown
        self.started = monotonic()
        self.compiled = 0.0  # seconds
        self.over = Event()
        self.bar: Any = None
        self.task: Any = None

    def __enter__(self) -> "Progress":
        if sys.stderr.isatty():
            from rich.console import Console
            from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
            from rich.progress import Progress as Bar

            text, left = [TextColumn(f"{{task.{field}}}", markup=False) for field in ("description", "fields[left]")]
            console = Console(stderr=True)
            middle = (BarColumn(20), TimeElapsedColumn()) if console.width >= BAR_FROM else ()
            self.room = console.width - 1 - BAR_LETTERS * bool(middle)
            self.bar = Bar(text, *middle, left, console=console, transient=True)
            self.task = self.bar.add_task(self.title, total=1.0, left="")
            self.bar.start()
        Thread(target=self._watch, daemon=True).start()
        compile_beside()
        return self

    def __exit__(self, *_: object) -> None:
        self.over.set()
        if self.bar is not None:
            self.bar.stop()

    def show(self, stage: str, share: float) -> None:
        """Show the stage of the run and the share that is finished."""
        now = monotonic()
        if share > self.share:
            self.share, self.total = share, (now - self.started - self.compiled) / share
        self.stage = stage

    def _watch(self) -> None:
        """Show what is done or compiled and how long the run still takes, until it is over."""
        due, before = self.started + FIRST_LINE_S, monotonic()
        while not self.over.wait(min(TICK, FIRST_LINE_S)):
            time, item = monotonic(), next(map(str, compiling()), "")
            if item:
                self.compiled += time - before
            before, stage, left = time, item or self.stage, self.time_left(time)
            if self.bar is not None:
                text = fitted(self.title, stage, self.room - len(left))
                self.bar.update(self.task, completed=self.share, description=text, left=left.removeprefix(", "))
            elif time >= due and stage:
                due = time + NEXT_LINE_S
                print(f"{self.title}: {stage}, {time - self.started:.0f} s so far{left}", file=sys.stderr, flush=True)

    def time_left(self, now: float) -> str:
        """Say how long the run goes on after `now`; "" while that is unknown."""
        left = self.total - (now - self.started - self.compiled)
        return "" if self.total < SHORT or left <= 0.0 else f", about {duration(left)} left"


def fitted(title: str, stage: str, room: int) -> str:
    """A title and a stage in so many letters; the title is cut first."""
    short = title if len(title) + 2 + len(stage) <= room else title[: max(room - len(stage) - 3, 0)] + "…"
    return (f"{short}: {stage}" if len(short) > 1 else stage)[:room]


def compile_beside() -> None:
    """On a machine without machine code, start a process that makes it too; it ends with this one."""
    if jit.enabled() and (os.cpu_count() or 1) > 1 and cache_writable() and is_empty():
        none = subprocess.DEVNULL
        command = [sys.executable, "-c", "from strainwave.app.commands.analyze import compile_ahead as run; run()"]
        atexit.register(subprocess.Popen(command, stdin=none, stdout=none, stderr=none).kill)


def finished(verb: Callable[[], T]) -> tuple[T, KeyboardInterrupt | None]:
    """Result of a verb; after Ctrl-C that of the finished part, and the exception to raise when it is written."""
    try:
        return verb(), None
    except Interrupted as stop:
        return stop.found, KeyboardInterrupt(f"{stop}; the same command again computes all")


def duration(seconds: float) -> str:
    """Write a time as a whole number of seconds, minutes or hours, rounded up."""
    for size, unit in ((3600.0, "h"), (60.0, "min")):
        if seconds > 2.0 * size:
            return f"{math.ceil(seconds / size)} {unit}"
    return f"{math.ceil(seconds)} s"


def plain(value: Any) -> Any:
    """Turn a value into types of JSON; numbers that are not finite become None."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, str | bool) or value is None:
        return value
    if hasattr(value, "tolist"):
        finite = value.dtype.kind in "biu" or (value.dtype.kind == "f" and bool((value - value == 0.0).all()))
        return value.tolist() if finite else plain(value.tolist())
    if isinstance(value, int):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Iterable):
        return [plain(item) for item in value]
    return str(value)


def to_json(value: object) -> str:
    """Write a value as JSON without NaN."""
    return json.dumps(plain(value), indent=2, ensure_ascii=False, allow_nan=False)


def reported(title: str, facts: Sequence[Fact], as_json: bool, *more: str) -> str:
    """Facts of a result as JSON, or as text: failures, then a title with the other facts and more lines below it."""
    if as_json:
        return to_json({"title": title} | data(facts))
    fails = len(facts[0].value) if facts[0].key == "failures" else 0
    rows = [in_options(row) for row in (*lines(facts), *more)]
    return "\n".join([*rows[:fails], title, *(f"  {line}" for line in rows[fails:])])


# Calls that sentences of the library name, and what a project file or a command has in their place.
NO_PYTHON = {
    r", drive_run a motion in time, and system\(reduced=True\) the error equation without its other parts": "",
    r"; drive_run has its motion in time": "",
    r" or tail, or a method of less accuracy, such as Dopri5\(rtol=1e-6\)": "",
    r", or (take find_orbit\(SteadyTrain\(train, omega\)\)|integrate with simulate)": "",
    r"\bintegrate it with simulate\b": "leave out the lines of the output's turn",
    r", or give a sampled controller as `loop` of sw\.compensate": "",
    r"\bgive limits=MotorLimits\(torque\) or max_torque": "write 'max_torque: 3 N*m' into the group motor",
    r"\b(simulate from other states shows|isolas with resonance=PRIMARY looks for) them( from random starts)?": (
        "strainwave speed-map looks for them from random starts"
    ),
}
# The same, and the options of the commands.
CALLS = {
    r"\bat_speed\(\.\.\.\)": "--speed",
    r"\bcolumns=\['time', 'load_angle', \.\.\.\]": "--columns time,load_angle,...",
    r"\bNone for one to leave out\b": "- for one to leave out",
    r"\bgive a name or None for each\b": "give a name or - for each",
    r"\bjoint= says of which joint, columns= which\b": "--joint says of which joint, --column which",
    r"\bcolumns=\{'time': \.\.\.\}, or rate\b": "--column time=..., or --rate",
    r"\bunits= says": "--unit says",
    r"\bloosen (peak|gain|phase)_(sensitivity|margin)\b": r"loosen --\1-\2",
    r"(?<![\w./-])trim=0(?![\w.])": "--trim 0",
    r"`load_angles` of sw\.compensate, --load-angle of the command": "--load-angle",
    r"\bgive one, such as Trapezoid\(angle, time\), or a `move` in the project file": (
        "write 'trapezoid, angle: 90 deg, time: 0.6 s' after the project file, or a group move into it"
    ),
}
GIVEN = re.compile(r"(?<![\w./-])(unit|column)s=(\{[^{}]*\})")


def without_calls(sentence: str) -> str:
    """A sentence of the library for somebody without Python: calls that it names give way to what they have."""
    for call, words in NO_PYTHON.items():
        sentence = re.sub(call, words, sentence)
    return sentence


def in_options(sentence: str, command: Any = None) -> str:
    """A sentence of the library with options in place of its calls, where the command has these."""
    typed = sentence = without_calls(sentence)
    for call, option in CALLS.items():
        typed = re.sub(call, option, typed)
    typed = GIVEN.sub(_pairs_as_typed, typed)
    available = None if command is None else {option for one in command.params for option in one.opts}
    named = set(re.findall(r"(?<!\S)--[a-z-]+", typed)) - set(re.findall(r"(?<!\S)--[a-z-]+", sentence))
    return typed if available is None or named <= available else sentence


def _pairs_as_typed(given: re.Match[str]) -> str:
    try:
        typed = [f"--{given[1]} {quote(f'{channel}={value}')}" for channel, value in literal_eval(given[2]).items()]
    except (ValueError, SyntaxError, AttributeError):  # no dictionary: it is no call
        return given[0]
    return " ".join(typed)


def echo(text: str, err: bool = False) -> None:
    """Print the text of a result; on a terminal its prose wraps at the width, and tables and JSON stay."""
    if (sys.stderr if err else sys.stdout).isatty() and text[:1] not in ("{", "["):
        width = shutil.get_terminal_size().columns
        text = "\n".join(part for line in text.split("\n") for part in _wrapped(line, width))
    click.echo(text, err=err)


def _wrapped(line: str, width: int) -> list[str]:
    if len(line) <= width or re.search(r"\S {2,}\S", line):  # a line of a table
        return [line]
    indent = line[: len(line) - len(line.lstrip())]
    return wrap(line, width, subsequent_indent=f"{indent}  ", break_long_words=False, break_on_hyphens=False)


def print_table(title: str, columns: Sequence[str], rows: Iterable[Sequence[Any]], caption: str = "") -> None:
    """Print a table on stdout."""
    cells = [list(columns), *([number(cell) for cell in row] for row in rows)]
    print("\n".join(filter(None, [title, *(f" {line}" for line in aligned(cells)), *wrap(caption, 80)])))


FULL = "free some space or choose another place; what was there before is unchanged"
TAKEN = "a file stands where a folder is to go; choose another place"
REMEDIES = dict.fromkeys((errno.ENOSPC, getattr(errno, "EDQUOT", errno.ENOSPC), errno.EFBIG), FULL) | {
    errno.ENAMETOOLONG: "choose a shorter path",
    errno.EACCES: "change its rights or choose another place",
    errno.EROFS: "choose another place",
    **dict.fromkeys((errno.EEXIST, errno.ENOTDIR), TAKEN),
}
WRITTEN: list[Path] = []  # folders with results of this process


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
        WRITTEN.append(folder)
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
                (part / name).write_text(content.removesuffix("\n") + "\n", encoding="utf-8", newline="\n")
            elif isinstance(content, bytes):
                (part / name).write_bytes(content)
            elif isinstance(content, list):
                write_csv(part / name, content)
            else:
                content.write(part / name)


def write_csv(path: Path, columns: Sequence[tuple[str, ArrayLike]]) -> None:
    """Write columns of equal length; each name carries its unit ("x_rad"); one with a comma is quoted."""
    body = np.column_stack([np.asarray(values, float) for _, values in columns])
    row = ",".join(["%.8g"] * len(columns)) + "\n"
    text = (row * len(body)) % tuple(body.ravel().tolist())
    header = ",".join(f'"{name}"' if "," in name else name for name, _ in columns)
    path.write_text(header + "\n" + text, encoding="utf-8", newline="\n")


def ending(unit: str) -> str:
    """A unit as the end of a column's name."""
    return "_".join(["", *re.findall(r"(?!1$)\w+", unit.replace("1/", "per ").replace("/", " per "))])


def columns(*tables: Mapping[str, tuple[Any, Any, str]]) -> list[tuple[str, ArrayLike]]:
    """Columns of a file from the arrays of a result: each name carries its unit."""
    return [(f"{name}{ending(unit)}", values) for arrays in tables for name, (_, values, unit) in arrays.items()]


def as_csv(header: list[str], rows: Iterable[Iterable[Any]]) -> str:
    """Write a table with words as CSV; a number that is not known is empty."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    for row in rows:
        writer.writerow([f"{cell:.8g}".replace("nan", "") if isinstance(cell, float) else cell for cell in row])
    return text.getvalue()


def slug(text: str) -> str:
    """Turn a label into a file name: "primary, order 2" is "primary-order-2"."""
    return "-".join("".join(c if c.isalnum() else " " for c in text.lower()).split())
