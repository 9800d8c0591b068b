"""BLAS on one thread while the package computes.

Its matrices are small. A second thread of OpenBLAS makes them no quicker and waits in a loop between two of them, which
takes as much computing time again. OpenBLAS has one number of threads a process: other threads of a program have one
too while a study runs, and all have their own back after it.
"""

import ctypes
import sys
from collections.abc import Callable
from contextlib import ContextDecorator
from pathlib import Path
from threading import RLock

LIBRARIES = {"numpy.linalg._umath_linalg": "numpy", "scipy.linalg._flapack": "scipy"}  # what calls BLAS, and in what
NAMES = [prefix + "openblas_{}_num_threads" + end for prefix in ("scipy_", "") for end in ("64_", "")]
Threads = tuple[Callable[[], int], Callable[[int], None]]


def threads_of(module: str) -> Threads | None:
    """Functions that get and set the number of threads of the OpenBLAS that a loaded module calls.

    None where it is not loaded or calls another BLAS, whose threads are left alone.
    """
    file = getattr(sys.modules.get(module), "__file__", None)
    if file is None:
        return None
    files = [file]  # its symbols are also those of the libraries that it is linked with, but for Windows
    if sys.platform == "win32":
        package = LIBRARIES[module]
        folder = Path(str(sys.modules[package].__file__)).parent.with_name(f"{package}.libs")
        files = [str(path) for path in folder.glob("*openblas*.dll")]
    for path in files:
        library = ctypes.CDLL(path)
        for name in NAMES:
            if hasattr(library, name.format("set")):
                return getattr(library, name.format("get")), getattr(library, name.format("set"))
    return None


class OneThread(ContextDecorator):
    """Hold OpenBLAS to one thread inside, whichever threads of the program are inside; the last to leave lets go."""

    def __init__(self) -> None:
        self.lock, self.inside = RLock(), 0
        self.held: dict[str, tuple[Threads, int] | None] = {}

    def __enter__(self) -> None:
        with self.lock:
            self.inside += 1
            for module in LIBRARIES:
                if module not in self.held and module in sys.modules:
                    threads = threads_of(module)
                    self.held[module] = None if threads is None else (threads, threads[0]())
                    if threads is not None:
                        threads[1](1)

    def __exit__(self, *_: object) -> None:
        with self.lock:
            self.inside -= 1
            if self.inside:
                return
            for held in self.held.values():
                if held is not None and held[0][0]() == 1:  # else somebody has set it meanwhile
                    held[0][1](held[1])
            self.held = {}


one_thread = OneThread()
