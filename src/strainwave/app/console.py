"""Terminal output of the commands: progress on stderr, tables and JSON on stdout, numbers as text."""

import json
import math
import sys
from collections.abc import Callable, Iterable, Sequence
from threading import Event, Thread
from time import monotonic
from types import TracebackType
from typing import Any, TypeVar

from ..base.facts import Fact, data, lines
from ..base.results import Interrupted
from ..base.sentences import number as number
from ..compile.cache import compiling

T = TypeVar("T")

EVERY = 10.0  # seconds after which a stage that goes on is shown again
TICK = 0.25  # seconds between looks at what is compiled
SHORT = 1.0  # seconds of a run whose time left is not shown
# What the errors are, wherever a command or the report shows one.
WHAT_X_IS = (
    "the pointing error is the reference angle of the load, that of the motor over N, minus the angle of the load; "
    "x = θ_m/N − θ_l is the error between motor and load, the same where the motor is ideally held"
)


class Progress:
    """Progress of one run on stderr: a bar on a terminal, one plain line per stage and every 10 s of it elsewhere.

    The time left follows from the share that is finished; what is compiled on the way is announced, and not counted.
    """

    def __init__(self, title: str) -> None:
        self.title = title
        self.stage, self.share, self.total = "", 0.0, 0.0  # total: seconds of the whole run, 0 while unknown
        self.started = self.begun = monotonic()
        self.compiled = 0.0  # seconds
        self.over = Event()
        self.bar: Any = None
        self.task: Any = None

    def __enter__(self) -> "Progress":
        if sys.stderr.isatty():
            from rich.console import Console
            from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
            from rich.progress import Progress as Bar

            text = TextColumn("{task.description}", markup=False)
            left = TextColumn("{task.fields[left]}", markup=False)
            columns = (text, BarColumn(20), TimeElapsedColumn(), left)
            self.bar = Bar(*columns, console=Console(stderr=True), transient=True)
            self.task = self.bar.add_task(self.title, total=1.0, left="")
            self.bar.start()
        Thread(target=self._watch, daemon=True).start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.over.set()
        if self.bar is not None:
            self.bar.stop()

    def show(self, stage: str, share: float) -> None:
        """Show the stage of the run and the share that is finished."""
        now = monotonic()
        if share > self.share:
            self.share, self.total = share, (now - self.started - self.compiled) / share
        if stage != self.stage:
            self.stage, self.begun = stage, now
            self._tell(stage)

    def _watch(self) -> None:
        """Show what is compiled and how long the run still takes, until it is over; repeat a stage every 10 s."""
        last_line, before, previous, announced = monotonic(), monotonic(), "", ""
        while not self.over.wait(min(TICK, EVERY)):
            time, item = monotonic(), next(map(str, compiling()), "")
            if item:
                self.compiled += time - before
            if item != previous:
                self._tell(item or self.stage, again=item in ("", announced))
            before, previous, announced = time, item, item or announced
            if self.bar is not None:
                self.bar.update(self.task, completed=self.share, left=self.rest(time).removeprefix(", "))
            elif self.stage and time - max(self.begun, last_line) >= EVERY:
                last_line = time
                self._tell(f"{self.stage}, {time - self.begun:.0f} s so far{self.rest(time)}")

    def _tell(self, what: str, again: bool = False) -> None:
        if self.bar is not None:
            self.bar.update(self.task, completed=self.share, description=f"{self.title}: {what}")
        elif not again:
            print(f"{self.title}: {what}", file=sys.stderr, flush=True)

    def rest(self, now: float) -> str:
        """Say how long the run goes on after `now`; "" while that is unknown."""
        left = self.total - (now - self.started - self.compiled)
        return "" if self.total < SHORT or left <= 0.0 else f", about {duration(left)} left"


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


def percent(share: float, digits: int = 4) -> str:
    """Write a share in percent, with its unit."""
    return f"{number(100.0 * share, digits)} %"


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
    rows = [*lines(facts), *more]
    return "\n".join([*rows[:fails], title, *(f"  {line}" for line in rows[fails:])])


def print_table(title: str, columns: Sequence[str], rows: Iterable[Sequence[Any]], caption: str = "") -> None:
    """Print a table on stdout; NO_COLOR and pipes are respected."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    table = Table(
        title=title, caption=caption or None, box=box.SIMPLE_HEAD, title_justify="left", caption_justify="left"
    )
    body = [[number(cell) for cell in row] for row in rows]
    for i, column in enumerate(columns):
        numeric = bool(body) and all(row[i][:1].strip("−–0123456789") == "" for row in body)
        table.add_column(column, justify="right" if numeric else "left")
    for row in body:
        table.add_row(*row)
    console = Console(highlight=False, markup=False)
    if not console.is_terminal:
        console = Console(highlight=False, markup=False, width=max(110, console.width))
    console.print(table)
