"""The kernels of ensembles: a block of lanes marches through its periods with fixed steps on one phase grid.

A block is a table with a column for each lane; its rows begin with the numbers of the (prepared) systems, and
`FirstRows` says where its other parts do. All lanes share the phase, so that the cosines of a step belong to no lane
and are computed once; a lane with twice the base frequency has half the time step.
"""

import math
from typing import Any, NamedTuple

from ...base.protocols import Scheme, System
from ...base.quantities import States
from ...base.results import Floats
from ...compile.elementwise import larger
from ...compile.jit import borrowed, kernel, kernel_as
from ...compile.lanes import VECTOR_LANES, lane, load, store
from ...compile.tree import count
from .pieces import Ends, Even, Piece, extreme_between, updated, vertex

BOUND = 1e100  # a state beyond it has left for infinity
KEPT_STATES = 9  # stroboscopic states kept: enough to see motions of up to eight periods close


class FirstRows(NamedTuple):
    """Numbers of the first row of each part of a block.

    `step` is the time step, `state` and `other` the states after every other pair of steps, `sums` those of the
    measures, `start` the states with which these began, `reach` the largest |x| of the whole run.
    """

    step: int
    state: int
    other: int
    sums: int
    start: int
    reach: int


@kernel
def first_rows(system: Any, y0: Any, sums: Any) -> FirstRows:
    """First rows of a block of such systems, states and sums."""
    state, states = count(system) + 1, count(y0)
    start = state + 2 * states + count(sums)
    return FirstRows(state - 1, state, state + states, state + 2 * states, start, start + states)


@kernel_as(lambda ended: range(len(ended) // VECTOR_LANES * VECTOR_LANES), inline=True)
def every_lane(ended: Floats) -> Any:
    """Lanes to loop over, as many as `ended` has: one at a time, or as Python all at once."""
    return (slice(len(ended)),)


@kernel
def pair(
    scheme: Any, system: Any, y0: Any, sums: Any, rows: Any, source: int, target: int, phase: float, turn: float, j: Any
) -> None:
    """Two steps of lane j from the states in rows `source` to those in rows `target`."""
    first = first_rows(system, y0, sums)
    s, h, y = lane(system, rows, 0, j), load(rows, first.step, j), lane(y0, rows, source, j)
    y = scheme.step(s, phase + turn, turn, scheme.step(s, phase, turn, y, h), h)
    store(y, rows, target, j)
    store(larger(abs(y[0]), load(rows, first.reach, j)), rows, first.reach, j)


@kernel
def one_step(scheme: Scheme, system: Any, y0: Any, sums: Any, rows: Any, phase: float, turn: float, j: slice) -> None:
    """One step of lane j."""
    first = first_rows(system, y0, sums)
    s, h, y = lane(system, rows, 0, j), load(rows, first.step, j), lane(y0, rows, first.state, j)
    y = scheme.step(s, phase, turn, y, h)
    store(y, rows, first.state, j)
    store(larger(abs(y[0]), load(rows, first.reach, j)), rows, first.reach, j)


@kernel
def measure(
    system: System, y0: Any, measures: Any, sums: Any, rows: Any, source: int, target: int, phase: float, turn: float,
    j: slice,
) -> None:  # fmt: skip
    """Update the measures of lane j by the pair of steps from the states in rows `source` to those in rows `target`."""
    first = first_rows(system, y0, sums)
    s, h = lane(system, rows, 0, j), load(rows, first.step, j)
    y, y1, end = lane(y0, rows, source, j), lane(y0, rows, target, j), phase + 2.0 * turn
    v, v1 = s.rhs(phase, y)[0], s.rhs(end, y1)[0]
    extreme = vertex(y[0], v, y1[0], v1, 2.0 * h)
    piece = Piece(Even(), phase, y[0], v, end, y1[0], v1, 2.0 * h, turn / h, extreme)
    store(updated(measures, lane(sums, rows, first.sums, j), piece), rows, first.sums, j)


@kernel
def measured_step(
    scheme: Any, system: Any, y0: Any, kind: Any, measures: Any, sums: Any, rows: Any, phase: float, turn: float, j: Any
) -> None:
    """One step and its measures, of lane j."""
    first, end = first_rows(system, y0, sums), phase + turn
    s, h, y = lane(system, rows, 0, j), load(rows, first.step, j), lane(y0, rows, first.state, j)
    y1 = scheme.step(s, phase, turn, y, h)
    store(y1, rows, first.state, j)
    before, after = s.rhs(phase, y), s.rhs(end, y1)
    extreme = extreme_between(kind, y, before, y1, after, h)
    piece = Piece(Even(), phase, y[0], before[0], end, y1[0], after[0], h, turn / h, extreme)
    store(larger(abs(y1[0]), load(rows, first.reach, j)), rows, first.reach, j)
    store(updated(measures, lane(sums, rows, first.sums, j), piece), rows, first.sums, j)


@kernel
def remember(system: System, y0: States, sums: Any, rows: Floats, j: slice) -> None:
    """Keep the state of lane j with which the measures begin."""
    first = first_rows(system, y0, sums)
    store(lane(y0, rows, first.state, j), rows, first.start, j)


@kernel
def close(system: System, y0: States, measures: Any, sums: Any, rows: Any, turn: float, steps: float, j: slice) -> None:
    """Add to the measures of lane j what the even pieces, `steps` each, lack: the first state, and sums' ends."""
    first = first_rows(system, y0, sums)
    s, h = lane(system, rows, 0, j), load(rows, first.step, j)
    begin, last = lane(y0, rows, first.start, j), lane(y0, rows, first.state, j)
    v0, v1 = s.rhs(0.0, begin)[0], s.rhs(0.0, last)[0]
    ends = Piece(Ends(), 0.0, begin[0], v0, 0.0, last[0], v1, steps * h, turn / h, begin[0])
    store(updated(measures, lane(sums, rows, first.sums, j), ends), rows, first.sums, j)


@kernel
def strobe(y0: States, rows: Floats, state_row: int, period: int, last: Floats, ended: Any, j: slice) -> None:
    """Keep the state at the end of a period, and count the periods over which all states stay bounded."""
    y = lane(y0, rows, state_row, j)
    store(y, last[period % KEPT_STATES], 0, j)
    size = abs(y[0])
    for i in range(1, len(y)):
        size = size + abs(y[i])
    ended[j] = ended[j] + (size < BOUND) * (ended[j] == period)


@kernel
def march_pairs(
    system: System, y0: States, kind: Any, measures: Any, sums: Any, rows: Floats, rule: Any, waiting: Any, settle: int,
    periods: int, last: Floats, ended: Floats,
) -> None:  # fmt: skip
    """March a block by pairs of steps; `rule` is the scheme and the steps a period (fours). Measure pairs of steps."""
    scheme, steps = rule
    rows, last, ended = borrowed((rows, last, ended))
    turn, first = 2.0 * math.pi / steps, first_rows(system, y0, sums)
    for period in range(settle + periods):
        if period == settle:
            for j in every_lane(ended):
                remember(system, y0, sums, rows, j)
        for i in range(0, steps, 4):
            phase, later = i * turn, (i + 2) * turn
            for j in every_lane(ended):
                pair(scheme, system, y0, sums, rows, first.state, first.other, phase, turn, j)
            if period >= settle:
                for j in every_lane(ended):
                    measure(system, y0, measures, sums, rows, first.state, first.other, phase, turn, j)
            for j in every_lane(ended):
                pair(scheme, system, y0, sums, rows, first.other, first.state, later, turn, j)
            if period >= settle:
                for j in every_lane(ended):
                    measure(system, y0, measures, sums, rows, first.other, first.state, later, turn, j)
        for j in every_lane(ended):
            strobe(y0, rows, first.state, period, last, ended, j)
    for j in every_lane(ended):
        close(system, y0, measures, sums, rows, turn, 2.0, j)


@kernel
def march_steps(
    system: System, y0: States, kind: Any, measures: Any, sums: Any, rows: Floats, rule: Any, waiting: Any, settle: int,
    periods: int, last: Floats, ended: Floats,
) -> None:  # fmt: skip
    """March a block step by step; `rule` is the scheme and the steps a period. Measure after the first periods."""
    scheme, steps = rule
    rows, last, ended = borrowed((rows, last, ended))
    turn, first = 2.0 * math.pi / steps, first_rows(system, y0, sums)
    for period in range(settle + periods):
        if period == settle:
            for j in every_lane(ended):
                remember(system, y0, sums, rows, j)
        for i in range(steps):
            if period < settle:
                for j in every_lane(ended):
                    one_step(scheme, system, y0, sums, rows, i * turn, turn, j)
            else:
                for j in every_lane(ended):
                    measured_step(scheme, system, y0, kind, measures, sums, rows, i * turn, turn, j)
        for j in every_lane(ended):
            strobe(y0, rows, first.state, period, last, ended, j)
    for j in every_lane(ended):
        close(system, y0, measures, sums, rows, turn, 1.0, j)
