"""Progress of a command on stderr, the end of one that is interrupted, and machine code made beside it."""

import atexit
import math
import os
import subprocess
import sys
from collections.abc import Callable
from threading import Event, Thread
from time import monotonic
from typing import Any, TypeVar

from ...base.results import Interrupted
from ...compile import jit
from ...compile.cache import cache_writable, compiling, is_empty

T = TypeVar("T")
FIRST_LINE_S, NEXT_LINE_S = 1.0, 60.0  # progress where stderr is no terminal: seconds to its first line, and between
BAR_FROM, BAR_LETTERS = 80, 29  # columns of a terminal from which on a bar is drawn, and letters of it with the time
CHANGE = 1.5  # of the time of a run, after which another line tells it
TICK = 0.25  # seconds between looks at what is compiled
SHORT = 1.0  # seconds of a run whose time left is not shown


class Progress:
    """Progress of one run on stderr: a bar on a terminal, elsewhere a line after a second, a minute or a new estimate.

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
        due, before, shown = self.started + FIRST_LINE_S, monotonic(), math.inf
        while not self.over.wait(min(TICK, FIRST_LINE_S)):
            time, item = monotonic(), next(map(str, compiling()), "")
            if item:
                self.compiled += time - before
            before, stage, left = time, item or self.stage, self.time_left(time)
            if self.bar is not None:
                text = fitted(self.title, stage, self.room - len(left))
                self.bar.update(self.task, completed=self.share, description=text, left=left.removeprefix(", "))
            elif stage and (time >= due or self._differs_from(shown)):
                due, shown = time + NEXT_LINE_S, self.total
                print(f"{self.title}: {stage}, {time - self.started:.0f} s so far{left}", file=sys.stderr, flush=True)

    def _differs_from(self, shown: float) -> bool:
        """True if the time of the whole run [s] is another than a line has shown; before the first it is infinite."""
        return self.total > max(CHANGE * shown, SHORT) or CHANGE * self.total < shown < math.inf

    def time_left(self, now: float) -> str:
        """Say how long the run goes on after `now`; "" while that is unknown."""
        left = self.total - (now - self.started - self.compiled)
        return "" if self.total < SHORT or left <= 0.0 else f", about {duration(left)} left"


def fitted(title: str, stage: str, room: int) -> str:
    """A title and a stage fitted into a width of letters; the title is cut first."""
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
        return stop.found, KeyboardInterrupt(f"{stop}; the same command computes all again")


def duration(seconds: float) -> str:
    """Write a time as a whole number of seconds, minutes or hours, rounded up."""
    for size, unit in ((3600.0, "h"), (60.0, "min")):
        if seconds > 2.0 * size:
            return f"{math.ceil(seconds / size)} {unit}"
    return f"{math.ceil(seconds)} s"
