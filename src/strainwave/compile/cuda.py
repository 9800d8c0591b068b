"""Kernels on graphics processors of NVIDIA, through numba-cuda (extra `cuda`): all that the package knows of it.

The Python bodies that `jit` compiles for the processor are compiled here for the device. A thread takes a few lanes,
whose numbers, states and sums are a small array of its own: once all calls are inlined and the loops over its lanes
unrolled, every index into it is a constant, and the compiler keeps it in registers.

With NUMBA_ENABLE_CUDASIM=1 the same kernels run as Python, in Numba's simulator of a device.
"""

import os
from collections.abc import Callable
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from types import FunctionType
from typing import Any

from . import jit, lanes, maths_kernels, tree
from .tree import classes

THREADS = 64  # of a block, at most
INNER: dict[str, Any] = {"device": True, "forceinline": True}

cuda: Any = None  # numba.cuda, once loaded: the simulator looks for it among the names of a kernel's module


def simulated() -> bool:
    """Whether kernels run in Numba's simulator of a device."""
    return os.environ.get("NUMBA_ENABLE_CUDASIM", "0") == "1"


@cache
def missing() -> str:
    """Say what keeps kernels from a graphics processor; empty where nothing does."""
    if simulated():
        return ""
    if not jit.enabled():
        return "compilation is off (STRAINWAVE_JIT=0)"
    if not find_spec("numba_cuda"):
        return "numba-cuda is not installed (pip install 'strainwave[cuda]')"
    return "" if load().is_available() else "no NVIDIA device with its driver was found"


@cache
def load() -> Any:
    """Import numba.cuda and teach it the kernels of `jit`, the maths functions and the methods of models."""
    global cuda
    cuda = import_module("numba.cuda")
    if simulated():
        return cuda
    types, extending = import_module("numba.cuda.types"), import_module("numba.cuda.extending")
    config: Any = import_module("numba.cuda.core.config")
    config.CUDA_LOW_OCCUPANCY_WARNINGS = 0  # a small ensemble is no mistake
    types.NamedTuple.__bool__ = lambda self: True  # see _jit
    _expose(jit.borrowed, lambda thing: thing)
    strided = lanes.bodies(types, extending, lanes.strided_address)
    for bodies in (strided, tree.bodies(types, extending), maths_kernels.bodies(types, extending)):
        for function, body in bodies.items():
            _expose(function, body)
    return cuda


@cache
def _expose(function: Callable[..., Any], body: Callable[..., Any], inline: bool | None = True) -> None:
    """Let device code call `function`, with `body` as its implementation (or what chooses it: inline is None)."""
    cuda.extending.overload(function, jit_options=INNER)(body if inline is None else jit._typed(body))


def expose_methods(things: tuple[Any, ...]) -> None:
    """Let device code call the methods of the models among things, at any depth."""
    for cls in () if simulated() else classes(things):
        _expose_methods(cls)


@cache
def _expose_methods(cls: type) -> None:
    types, templates = import_module("numba.cuda.types"), import_module("numba.cuda.typing.templates")
    jit.expose_methods(cls, types, templates, lambda typed: cuda.extending.overload(typed, jit_options=INNER)(typed))


def launch(parts: Any, rows: int, lanes: int, grid: tuple[int, int], arguments: tuple[Any, ...]) -> None:
    """Run the kernel made of `parts` (see `kernel`) on a grid of (blocks, threads of a block).

    If a user's class uses something that compiled code does not know, the sentence of the TypeError says what.
    """
    errors = import_module("numba.core.errors")
    try:
        kernel(*parts, rows, lanes, classes(arguments))[grid](*arguments)
    except (errors.NumbaError, errors.UnsupportedBytecodeError) as error:
        raise TypeError(jit._explain(error, jit.foreign_names(arguments))) from error


@cache
def kernel(
    begin: Any, march: Any, call: Any, finish: Any, rows: int, lanes: int, classes: tuple[type, ...] = ()
) -> Any:
    """Kernel of which every thread runs `begin`, `call(march)` and `finish` on its own lanes, in so many rows.

    The thread's lanes are those that `every_lane` gives in the three functions. Its arguments are a system, its states,
    what is known of them, measures and their first sums (all as templates, see `lanes`), the method's own arguments,
    counts of periods, and arrays whose last axis is the lanes of all threads. It is for models of these classes.
    """
    load()
    begin, finish = _own(begin, lanes), _own(finish, lanes)
    march = _own(call(_own(march, lanes)), lanes)

    def thread(
        system: Any, y0: Any, kind: Any, measures: Any, sums: Any, rule: Any, settle: int, periods: int, inputs: Any,
        outputs: Any, last: Any, points: Any,
    ) -> None:  # fmt: skip
        i, threads = cuda.grid(1), cuda.gridsize(1)
        block, last, points = cuda.local.array((rows, lanes), "f8"), last[:, :, i::threads], points[:, :, i::threads]
        begin(system, y0, sums, inputs[:, i::threads], block)
        march(system, y0, kind, measures, sums, block, rule, settle, periods, last, points)
        finish(system, y0, sums, block, outputs[:, i::threads])

    # Without optimisation at link time, so that what runs is the PTX that the tests read.
    return cuda.jit(thread) if simulated() else cuda.jit(thread, launch_bounds=THREADS, lto=False)


def _own(function: Any, lanes: int) -> Any:
    """Device code of a function in which `every_lane` gives a thread's own lanes."""
    if simulated():
        return function
    for marked in (*jit._exposed, *jit._kernels):
        _expose(*marked)

    def own_lanes() -> Any:
        return range(lanes)

    names = function.__globals__ | {"every_lane": cuda.jit(**INNER)(own_lanes)}
    return cuda.jit(**INNER)(FunctionType(function.__code__, names, function.__name__, None, function.__closure__))
