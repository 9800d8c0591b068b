"""The kernels of sampled loops: between two samples a system is integrated by equal steps, at a sample the loop acts.

A loop is a NamedTuple with `plant()`, the system; `start()`, its memory; `period()` and `waits()`, the time [s] from
one sample to the next and that until the torque changes; `update(t, y, memory, lane, sample)`, its memory after a
sample; `commanded(y, memory, later)`, the state with the torque in force; and `watched(phase, y)`, a pair that is
measured.
"""

import math
from typing import Any

from ...choices import larger
from ...compile.jit import borrowed, kernel
from ...compile.lanes import lane
from ...tree import count
from ..integration.steps import rk4_step

SUMS = 14  # of a lane, before those of the orders: see `add`


@kernel
def part(loop: Any, t: float, y: Any, span: float, steps: int) -> Any:
    """State after a part of a sample, in so many equal steps."""
    plant = loop.plant()
    h = span / steps
    for i in range(steps):
        y = rk4_step(plant, plant.omega * (t + i * h), plant.omega * h, y, h)
    return y


@kernel
def between(loop: Any, t: float, y: Any, memory: Any, steps: int) -> Any:
    """State at the next sample."""
    waits = loop.waits()
    if waits > 0.0:
        y = part(loop, t, loop.commanded(y, memory, 0), waits, steps)
    return part(loop, t + waits, loop.commanded(y, memory, 1), loop.period() - waits, steps)


@kernel
def add(
    loop: Any, t: float, y: Any, memory: Any, late: float, aside: float, orders: Any, out: Any, j: int
) -> None:  # fmt: skip
    """Add a sample to the sums of lane j.

    These are the number of samples, the sum of the error, of its square, its largest size, the sum of the torque's
    square, its largest size, the largest torque watched; after two that are filled at the end, the sum of the error's
    square in the second half and its samples, its largest size in the whole run, its sum in the second half, and the
    sum of the error times the samples `aside` from the middle; then, for each order, of error times cosine and sine.
    """
    phase = loop.plant().omega * t
    error, torque = loop.watched(phase, y)
    given = memory.torques[0]
    out[0, j] += 1.0
    out[1, j] += error
    out[2, j] += error * error
    out[3, j] = larger(abs(error), out[3, j])
    out[4, j] += given * given
    out[5, j] = larger(abs(given), out[5, j])
    out[6, j] = larger(abs(torque), out[6, j])
    out[9, j] += late * error * error
    out[10, j] += late
    out[12, j] += late * error
    out[13, j] += aside * error
    angle = loop.plant().reference.value(phase)
    for i in range(len(orders)):
        out[SUMS + 2 * i, j] += error * math.cos(orders[i] * angle)
        out[SUMS + 2 * i + 1, j] += error * math.sin(orders[i] * angle)


@kernel
def march_loops(
    model: Any, start: Any, rows: Any, first: int, lanes: int, samples: int, settle: int, steps: int, orders: Any,
    out: Any,
) -> None:  # fmt: skip
    """Run lanes of a block of loops, whose numbers and first states are rows, and sum what is measured.

    Measured are the samples from `settle` on; samples that were limited and lost are counted from the start.
    """
    rows, out = borrowed((rows, out))
    for j in range(lanes):
        loop, y = lane(model, rows, 0, j), lane(start, rows, count(model), j)
        memory = loop.start()
        for k in range(samples):
            t = k * loop.period()
            memory = loop.update(t, y, memory, first + j, k)
            if k >= settle:
                add(
                    loop,
                    t,
                    y,
                    memory,
                    1.0 * (2 * k >= samples + settle),
                    k - 0.5 * (settle + samples - 1),
                    orders,
                    out,
                    j,
                )
            out[11, j] = larger(abs(loop.watched(loop.plant().omega * t, y)[0]), out[11, j])
            y = between(loop, t, y, memory, steps)
        out[7, j], out[8, j] = memory.limited, memory.lost


@kernel
def march_one(
    loop: Any, y: Any, memory: Any, number: int, first: int, samples: int, every: int, steps: int, states: Any, out: Any
) -> Any:
    """Run one loop, keeping every so many samples its state, torque and what is watched; return state and memory."""
    states, out = borrowed((states, out))
    for k in range(samples):
        t = (first + k) * loop.period()
        memory = loop.update(t, y, memory, number, first + k)
        if k % every == 0:
            at, phase = k // every, loop.plant().omega * t
            for i in range(len(y)):
                states[i, at] = y[i]
            error, torque = loop.watched(phase, y)
            out[0, at], out[1, at], out[2, at], out[3, at] = t, memory.torques[0], error, torque
        y = between(loop, t, y, memory, steps)
    return y, memory
