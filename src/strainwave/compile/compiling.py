"""What is being compiled now, and how long that takes: for whoever shows progress; nothing is printed here.

Code that is on disk is loaded within a fraction of a second and is not listed.
"""

from collections.abc import Callable
from functools import wraps
from itertools import count
from time import monotonic
from typing import Any, NamedTuple

from .cache import cache_writable

# Seconds on one core of 2.5 GHz with an empty cache, rounded; what is missing takes OTHER.
SECONDS = {"follow": 20.0, "march_steps": 6.0, "adaptive": 6.0, "march_adaptive": 3.5}
OTHER = 2.0


class Compilation(NamedTuple):
    """A kernel that is being compiled: since when (`time.monotonic`), the seconds that it takes, and for which law.

    `kept` says whether the code is kept on disk, so that no later process compiles it again.
    """

    kernel: str
    law: str
    since: float
    expected: float
    kept: bool

    def __str__(self) -> str:
        law = f" with the torsion law {self.law}" if self.law else ""
        often = "once per machine" if self.kept else "again at every start, as the cache cannot be written"
        return f"compiling the equations of this drive{law}, about {self.expected:.0f} s, {often}"


_under_way: dict[int, Compilation] = {}
_numbers = count()


def compiling() -> tuple[Compilation, ...]:
    """Kernels that the threads of this process compile now, the first begun first; usually none."""
    return tuple(_under_way.values())


def watched(compile_: Callable[..., Any], kernel: str) -> Callable[..., Any]:
    """Numba's `compile` of a kernel, listed in `compiling` while it runs."""

    @wraps(compile_)
    def listed(kinds: Any, *rest: Any) -> Any:
        number = next(_numbers)
        law = law_of(kinds)
        _under_way[number] = Compilation(kernel, law, monotonic(), expected(kernel), cache_writable())
        try:
            return compile_(kinds, *rest)
        finally:
            del _under_way[number]

    return listed


def law_of(kinds: Any) -> str:
    """Name of the first torsion law among the compiler's types, at any depth; "" where there is none."""
    for kind in kinds:
        own = getattr(kind, "instance_class", None)
        if own is not None and hasattr(own, "torque") and hasattr(own, "stiffness"):
            return str(own.__name__)
        inner = getattr(kind, "types", kind if isinstance(kind, tuple) else ())
        if found := law_of(inner):
            return found
    return ""


def expected(kernel: str) -> float:
    """Seconds that a kernel takes to compile."""
    return SECONDS.get(kernel, OTHER)
