"""The kernels of sampled loops: between two samples a system is integrated by equal steps, at a sample the loop acts.

A loop is a NamedTuple with `plant()`, the system; `start()`, its memory; `period()` and `waits()`, the time [s] from
one sample to the next and that until the torque changes; `update(t, y, memory, lane, sample)`, its memory after a
sample; `commanded(y, memory, later)`, the state with the torque in force; `watched(phase, y)`, a pair that is
measured. It may have `started(y)`, its memory with its plant in a state; `finest()`, below which nothing that is
measured counts as growing; and `called(loops, memories)`, what `march` gets in its place, which calls by address what
it would be compiled for again and again.

The sums of `march` come block by block to `add`, which is compiled once for all.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ...base.protocols import lacking
from ...base.results import Floats
from ...compile.address import ByAddress
from ...compile.calls import at, call
from ...compile.elementwise import larger
from ...compile.jit import borrowed, enabled, entry, kernel, kernel_as
from ...compile.lanes import lane
from ...compile.tree import count, leaves, mapped
from ..integration.steps import rk4_step

TIME, TORQUE, ERROR, WATCHED, ANGLE, ROWS = range(6)  # rows of what is seen of a lane, and how many they are
(  # rows of its sums, of the error where no other is named, and how many are before those of the orders: see `add`
    COUNT, TOTAL, SQUARES, PEAK, TORQUE_SQUARES, TORQUE_PEAK, WATCHED_PEAK, LIMITED, LOST, LATE_SQUARES, LATE_COUNT,
    PEAK_OF_RUN, LATE_TOTAL, MOMENT, SUMS,
) = range(15)  # fmt: skip
BLOCK = 512  # samples of a lane that are summed at once: they stay in the first-level cache


def begun(loop: Any, y: Any) -> Any:
    """Memory of a loop before its first sample, with its plant in a state (states,)."""
    return loop.start() if lacking(loop, "started") else mapped(float, loop.started(y))


def native_of(loop: Any, loops: Sequence[Any], starts: Sequence[Any], memories: Sequence[Any]) -> Any:
    """Arguments of `march` for loops, states and memories: loop, memory, table (floats, lanes); a memory's restorer."""
    native, restored = loop, None
    if enabled() and not lacking(loop, "called"):
        native, loops, memories, restored = loop.called(loops, memories)
    table = np.array([leaves(parts) for parts in zip(loops, starts, memories, strict=True)], float).T
    return native, memories[0], table, restored


def spread(values: Floats) -> float:
    """Root mean square about the mean; infinite where a value is beyond all floats."""
    size = float(np.max(np.abs(values)))
    return size * float(np.std(values / (size or 1.0))) if math.isfinite(size) else math.inf


class Sums(NamedTuple):
    """Sums over the samples from `settle` on, of so many: `out` (SUMS + 2 orders, lanes), see `add`.

    The rows of `seen` are times [s], torques [N*m], the two that are watched, the error first, and reference angles
    [rad].
    """

    settle: int
    samples: int
    orders: Floats
    seen: Floats
    out: Floats


class SumsAt(NamedTuple):
    """Sums by the addresses of their words and of `add`."""

    settle: int
    words: int
    add_at: int


NO_SUMS = SumsAt(0, 0, 0)


def sums_by_address(sums: Sums) -> ByAddress:
    """Sums for `march`."""

    def addressed(words: Callable[[Any], int]) -> SumsAt:
        return SumsAt(sums.settle, words(sums), entry(_added, sums, int, int, int, float, float))

    return ByAddress(sums, addressed)


def _added(model: Any, j: int, first: int, samples: int, limited: float, lost: float) -> None:
    settle, end, orders, traces, totals = at(model)
    orders, traces, totals = borrowed((orders, traces, totals))
    largest = totals[PEAK_OF_RUN, j]
    for i in range(samples):
        largest = larger(abs(traces[ERROR, i]), largest)
    totals[LIMITED, j], totals[LOST, j], totals[PEAK_OF_RUN, j] = limited, lost, largest
    begin = min(max(settle - first, 0), samples)
    for i in range(begin, samples):
        k, torque, error = first + i, traces[TORQUE, i], traces[ERROR, i]
        late = 1.0 if 2 * k >= end + settle else 0.0
        totals[COUNT, j] += 1.0
        totals[TOTAL, j] += error
        totals[SQUARES, j] += error * error
        totals[PEAK, j] = larger(abs(error), totals[PEAK, j])
        totals[TORQUE_SQUARES, j] += torque * torque
        totals[TORQUE_PEAK, j] = larger(abs(torque), totals[TORQUE_PEAK, j])
        totals[WATCHED_PEAK, j] = larger(abs(traces[WATCHED, i]), totals[WATCHED_PEAK, j])
        totals[LATE_SQUARES, j] += late * error * error
        totals[LATE_COUNT, j] += late
        totals[LATE_TOTAL, j] += late * error
        totals[MOMENT, j] += (k - 0.5 * (end + settle - 1)) * error
        for row in range(len(orders)):
            angle = orders[row] * traces[ANGLE, i]
            totals[SUMS + 2 * row, j] += error * math.cos(angle)
            totals[SUMS + 2 * row + 1, j] += error * math.sin(angle)


def _add_loops(sums: Any, j: int, first: int, samples: int, limited: float, lost: float) -> None:
    call(sums.add_at, sums.words, (j, first, samples, limited, lost))


@kernel_as(_add_loops, inline=True)
def add(sums: Any, j: int, first: int, samples: int, limited: float, lost: float) -> None:
    """Add so many samples that were seen of lane j, the `first` on, and its counts up to now.

    The sums are the number of samples, the sum of the error, of its square, its largest size, the sum of the torque's
    square, its largest size, the largest torque watched; the samples limited and lost; the sum of the error's square in
    the second half and its samples, its largest size in the whole run, its sum in the second half, and the sum of the
    error times the samples from the middle; then, for each order, of error times cosine and sine.
    """
    _added(sums, j, first, samples, limited, lost)


@kernel
def between(loop: Any, t: float, y: Any, memory: object, steps: int) -> Any:
    """State at the next sample."""
    plant, waits = loop.plant(), loop.waits()
    for later in range(0 if waits > 0.0 else 1, 2):
        begin, span = (t + waits, loop.period() - waits) if later else (t, waits)
        h, y = span / steps, loop.commanded(y, memory, later)
        for i in range(steps):
            y = rk4_step(plant, plant.omega * (begin + i * h), plant.omega * h, y, h)
    return y


@kernel
def march(
    model: Any, start: Any, held: Any, rows: Floats, first: int, lanes: int, samples: int, stride: int, steps: int,
    states: Floats, traces: Floats, sums: Any,
) -> Any:  # fmt: skip
    """Run lanes of a block of loops, whose numbers, first states and memories are rows; return those of the last one.

    Every so many samples what is seen of a lane is written (before `settle` the error alone), and its state; without
    rows of `states` it is summed.
    """
    rows, states, traces = borrowed((rows, states, traces))
    block = stride * traces.shape[1]
    y, memory = start, held
    for j in range(lanes):
        loop, y = lane(model, rows, 0, j), lane(start, rows, count(model), j)
        memory = lane(held, rows, count(model) + count(start), j)
        for begin in range(0, samples, block):
            n, due = 0, begin
            for k in range(begin, min(begin + block, samples)):
                t = k * loop.period()
                memory = loop.update(t, y, memory, first + j, k)
                if k == due:
                    phase = loop.plant().omega * t
                    error, torque = loop.watched(phase, y)
                    traces[ERROR, n] = error
                    if k >= sums.settle:
                        traces[TIME, n], traces[TORQUE, n], traces[WATCHED, n] = t, memory.torques[0], torque
                        if len(states) > 0:
                            for i in range(len(y)):
                                states[i, n] = y[i]
                        else:
                            traces[ANGLE, n] = loop.plant().reference.value(phase)
                    n, due = n + 1, due + stride
                y = between(loop, t, y, memory, steps)
            if len(states) == 0:
                add(sums, j, begin, n, memory.limited, memory.lost)
    return y, memory
