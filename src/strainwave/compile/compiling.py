"""What is being compiled now: for whoever shows progress; nothing is printed here.

Code that is on disk is loaded within a fraction of a second and is not listed.
"""

from collections.abc import Callable
from functools import wraps
from itertools import count
from time import monotonic
from typing import Any, NamedTuple

from .cache import cache_writable


class Compilation(NamedTuple):
    """A kernel that is being compiled, and since when (`time.monotonic`).

    `kept` says whether the code is kept on disk, so that no later process compiles it again.
    """

    kernel: str
    since: float
    kept: bool

    def __str__(self) -> str:
        often = "once per machine" if self.kept else "again at every start, as the cache cannot be written"
        return f"preparing machine code, {often}"


_under_way: dict[int, Compilation] = {}
_numbers = count()


def compiling() -> tuple[Compilation, ...]:
    """Kernels that the threads of this process compile now, the first begun first; usually none."""
    return tuple(_under_way.values())


def watched(compile_: Callable[..., Any], kernel: str) -> Callable[..., Any]:
    """Numba's `compile` of a kernel, listed in `compiling` while it runs."""

    @wraps(compile_)
    def listed(*arguments: Any) -> Any:
        number = next(_numbers)
        _under_way[number] = Compilation(kernel, monotonic(), cache_writable())
        try:
            return compile_(*arguments)
        finally:
            del _under_way[number]

    return listed
