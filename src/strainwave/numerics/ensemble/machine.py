"""Blocks of lanes: which systems they hold, and one run of a block through its kernel, on either processor.

On a graphics processor parameters go in, measures come back, all steps are taken there. The kernels are those of the
processor, whose blocks of 256 lanes become a few lanes of one thread, which share the cosines of a phase.
"""

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ...base.quantities import shown
from ...base.results import Floats
from ...compile import cuda
from ...compile.jit import kernel, run
from ...compile.lanes import LANES, lane, load, store
from ...compile.tree import count, leaves
from ..integration.methods import Method
from .fixed_step import KEPT, every_lane
from .stepping import stepping_of


@dataclass(frozen=True)
class Batch:
    """Everything that the lanes of an ensemble are made of.

    Attributes
    ----------
    template : NamedTuple
        The prepared system of one lane.
    numbers : (floats, lanes) array
        The floats of the prepared system in every lane, in the order of its fields.
    omega : (lanes,) array
        Base frequency [rad/s].
    y0 : (states, lanes) array
        States at the start.
    kind : Smooth or General
        What is known of the states.
    measures : tuple
        Measures that are accumulated.
    settle, periods : int
        Periods before the measures begin, and of the measures.
    points : bool
        Whether to keep the states at the end of every period.
    """

    template: Any
    numbers: Floats
    omega: Floats
    y0: Floats
    kind: Any
    measures: tuple[Any, ...]
    settle: int
    periods: int
    points: bool


@dataclass(frozen=True)
class Block:
    """What came of some lanes.

    Attributes
    ----------
    sums : (sums, lanes) array
        Sums of the measures.
    last : (up to 9, states, lanes) array
        States at the ends of the last periods, oldest first.
    points : (periods or 0, states, lanes) array
        States at the ends of all periods, if asked for.
    ended : (lanes,) array
        Periods over which the states stayed bounded.
    reach : (lanes,) array
        Largest |x| at the ends of fixed steps.
    attempts : int
        Adaptive steps that every lane attempted.
    """

    sums: Floats
    last: Floats
    points: Floats
    ended: Floats
    reach: Floats
    attempts: int = 0


def march(batch: Batch, places: Any, method: Method, steps: int) -> Block:
    """Run the lanes at these places (at most a block of them) through all their periods."""
    n, states, floats = len(places), len(batch.y0), len(batch.numbers)
    full = np.concatenate([places, np.repeat(places[-1:], LANES - n)])
    starts = tuple(measure.start() for measure in batch.measures)
    sums = np.array(leaves(starts), float)
    first = floats + 1 + 2 * states
    rows = np.zeros((first + len(sums) + states + 3, LANES))
    rows[:floats], rows[floats + 1 : floats + 1 + states] = batch.numbers[:, full], batch.y0[:, full]
    rows[first : first + len(sums)] = sums[:, None]
    periods = batch.settle + batch.periods
    last, ended = np.zeros((KEPT, states, LANES)), np.zeros(LANES)
    points = np.empty((periods if batch.points else 0, states, LANES))
    common = batch.template, (0.0,) * states, batch.kind, batch.measures, starts, rows
    stepping, waiting = stepping_of(method), np.zeros(LANES, np.int64)
    rule, rows[floats] = stepping.arguments(batch.omega[full], steps)
    with np.errstate(all="ignore"):
        attempts = run(
            stepping.kernel, *common, rule, waiting, batch.settle, batch.periods, last, points, ended
        )  # fmt: skip
    newest = (periods - 1 - np.arange(min(KEPT, periods))[::-1]) % KEPT
    end = first + len(sums)
    return Block(
        rows[first:end, :n], last[newest, :, :n], points[:, :, :n], ended[:n], rows[end + states, :n], attempts or 0
    )


LAUNCHED = 2**20  # lanes of a launch, at most
FEW_ROWS = 22  # of numbers per lane, up to which a thread keeps four lanes in registers


class Machine(NamedTuple):
    """What runs lanes: `march` does up to `lanes` of them in a job, `workers` jobs run side by side."""

    name: str
    march: Callable[[Batch, Any, Any, int], Block]
    lanes: int
    workers: int


def machine_of(device: str, threads: int) -> Machine:
    """The graphics processor if it is asked for and there, else so many threads of the processor."""
    if not isinstance(device, str) or device not in ("cpu", "gpu"):
        raise ValueError(f"device is {shown(device)}; it must be 'cpu' or 'gpu'")
    if device == "gpu":
        if not cuda.missing():
            return Machine("gpu", march_on_gpu, LAUNCHED, 1)
        warnings.warn(f"device='gpu': {cuda.missing()}; the ensemble runs on the processor", stacklevel=3)
    return Machine("cpu", march, LANES, threads)


@kernel
def begin(system: Any, y0: Any, sums: Any, inputs: Floats, rows: Any) -> None:
    """Fetch the numbers, steps and states of a thread's lanes.

    The rows are those of `lanes` (or `adaptive_lanes`), then the periods ended and what the adaptive steps wait for.
    """
    offset, n = count(system) + 1, count(y0)
    for j in every_lane():
        store(lane(system, inputs, 0, j), rows, 0, j)
        store(load(inputs, offset - 1, j), rows, offset - 1, j)
        store(lane(y0, inputs, offset, j), rows, offset, j)
        store(sums, rows, offset + 2 * n, j)
        store(0.0, rows, offset + 3 * n + count(sums), j)
        store(0.0, rows, offset + 3 * n + count(sums) + 3, j)


@kernel
def finish(system: Any, y0: Any, sums: Any, rows: Any, outputs: Floats) -> None:
    """Hand over the sums of the measures, the largest |x| and the periods ended of a thread's lanes."""
    at, n = count(system) + 1, count(y0)
    for j in every_lane():
        store(lane(sums, rows, at + 2 * n, j), outputs, 0, j)
        store(load(rows, at + 3 * n + count(sums), j), outputs, count(sums), j)
        store(load(rows, at + 3 * n + count(sums) + 3, j), outputs, count(sums) + 1, j)


def placed(march: Callable[..., Any]) -> Any:
    """The march with the periods ended, and what adaptive steps wait for, in rows of the block."""

    def march_block(
        system: Any, y0: Any, kind: Any, measures: Any, sums: Any, rows: Any, how: Any, settle: int, periods: int,
        last: Any, points: Any,
    ) -> None:  # fmt: skip
        at = count(system) + 4 + 3 * count(y0) + count(sums)
        march(system, y0, kind, measures, sums, rows, how, rows[at + 1], settle, periods, last, points, rows[at])

    return march_block


@contextmanager
def memory_told(lanes: int) -> Iterator[None]:
    """Say in one sentence that the device's memory is too small (MemoryError), whichever way the driver puts it."""
    try:
        yield
    except Exception as error:  # of the driver, of the bindings or of NumPy; what is no lack of memory goes on as it is
        if not (isinstance(error, MemoryError) or "OUT_OF_MEMORY" in str(error)):
            raise
        raise MemoryError(
            f"the graphics processor has no memory left for {lanes} trajectories at a time; make several ensembles of "
            "them (in a sweep give a smaller chunk), or leave out Poincare(), which keeps every turn"
        ) from error


def march_on_gpu(batch: Batch, places: Any, method: Method, steps: int) -> Block:
    """Run the lanes at these places through all their periods, on the device."""
    states, floats, periods = len(batch.y0), len(batch.numbers), batch.settle + batch.periods
    starts = tuple(measure.start() for measure in batch.measures)
    sums = len(leaves(starts))
    rows = floats + 1 + 3 * states + sums + 5
    stepping = stepping_of(method)
    per_thread = stepping.of_thread if rows <= FEW_ROWS else 1
    n = len(places)
    threads = min(cuda.THREADS, -(-n // per_thread))
    blocks = -(-n // (per_thread * threads))
    full = np.concatenate([places, np.repeat(places[-1:], blocks * threads * per_thread - n)])
    rule, times = stepping.arguments(batch.omega[full], steps)
    device = cuda.load()
    cuda.expose_methods((batch.template, batch.kind, batch.measures, rule))
    start = np.concatenate([batch.numbers[:, full], times[None], batch.y0[:, full]])
    shapes = (sums + 2, len(full)), (KEPT, states, len(full)), (periods if batch.points else 1, states, len(full))
    with memory_told(n):
        inputs = device.to_device(start)
        outputs, last, points = map(device.device_array, shapes)
        arguments = (
            batch.template, (0.0,) * states, batch.kind, batch.measures, starts, rule, batch.settle, batch.periods,
            inputs, outputs, last, points if batch.points else points[:0],
        )  # fmt: skip
        cuda.launch((begin, stepping.kernel, placed, finish), rows, per_thread, (blocks, threads), arguments)
    newest = (periods - 1 - np.arange(min(KEPT, periods))[::-1]) % KEPT
    values, finals = outputs.copy_to_host()[:, :n], last.copy_to_host()[newest, :, :n]
    strobes = points.copy_to_host()[:, :, :n] if batch.points else np.empty((0, states, n))
    return Block(values[:sums], finals, strobes, values[sums + 1], values[sums])
