"""What the commands share: progress on stderr, tables and JSON on stdout, numbers as text."""

import json
import math
import sys
from collections.abc import Iterable, Sequence
from threading import Event, Thread
from time import monotonic
from types import TracebackType
from typing import Any

EVERY = 10.0  # seconds after which a stage that goes on is told again
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
# What the errors are, wherever a command or the report shows one.
WHAT_X_IS = (
    "the pointing error is the reference angle of the load, that of the motor over N, minus the angle of the load; "
    "x = θ_m/N − θ_l is the error between motor and load, the same where the motor is ideally held"
)


class Progress:
    """Progress of one run on stderr: a bar on a terminal, one plain line per stage and every 10 s of it elsewhere."""

    def __init__(self, title: str) -> None:
        self.title = title
        self.stage, self.begun = "", monotonic()
        self.over = Event()
        self.bar: Any = None
        self.task: Any = None

    def __enter__(self) -> "Progress":
        if sys.stderr.isatty():
            from rich.console import Console
            from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
            from rich.progress import Progress as Bar

            columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
            self.bar = Bar(*columns, console=Console(stderr=True), transient=True)
            self.task = self.bar.add_task(self.title, total=1.0)
            self.bar.start()
        else:
            Thread(target=self._repeat, daemon=True).start()
        return self

    def _repeat(self) -> None:
        while not self.over.wait(EVERY):
            took = monotonic() - self.begun
            if self.stage and took >= EVERY:
                print(f"{self.title}: {self.stage}, {took:.0f} s so far", file=sys.stderr, flush=True)

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.over.set()
        if self.bar is not None:
            self.bar.stop()

    def show(self, stage: str, share: float) -> None:
        """Say what is being done and which share of the run is finished."""
        if self.bar is not None:
            self.bar.update(self.task, completed=share, description=f"{self.title}: {stage}")
        elif stage != self.stage:
            print(f"{self.title}: {stage}", file=sys.stderr, flush=True)
        if stage != self.stage:
            self.stage, self.begun = stage, monotonic()


def number(value: float | str | bool | None, digits: int = 4) -> str:
    """Write a number with at least so many significant digits, from 10 million on by powers of ten; None is a dash."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, str):
        return value
    if not math.isfinite(value):
        return "–"
    rounded = float(f"{value:.{digits}g}") + 0.0  # 99.99 may become 100, and -0.0 is 0.0
    text = f"{value:.0f}" if 10.0**digits <= abs(rounded) < 1e7 else f"{rounded:.{digits}g}"
    mantissa, mark, exponent = text.partition("e")
    if not mark:
        return text.replace("-", "−")
    return mantissa.replace("-", "−") + "×10" + str(int(exponent)).translate(RAISED)


def percent(share: float, digits: int = 4) -> str:
    """Write a share in percent, with its unit."""
    return f"{number(100.0 * share, digits)} %"


def plain(value: Any) -> Any:
    """Turn a value into what JSON knows; numbers that are not finite become None."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, str | bool) or value is None:
        return value
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, int):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Iterable):
        return [plain(item) for item in value]
    return str(value)


def to_json(value: Any) -> str:
    """Write a value as JSON without NaN."""
    return json.dumps(plain(value), indent=2, ensure_ascii=False, allow_nan=False)


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
