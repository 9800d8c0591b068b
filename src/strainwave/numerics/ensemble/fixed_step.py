"""Kernels of ensembles with fixed steps: a block of lanes marches through its periods on one phase grid.

A block is a table with a column for each lane; its rows begin with the numbers of the (prepared) systems, and
`FirstRows` says where its other parts do. All lanes share the phase, so that the cosines of a step belong to no lane
and are computed once; a lane with twice the base frequency has half the time step.

In all kernels `rows` is that table (rows, lanes), j a lane (as Python a slice of all lanes), `phase` the base angle
[rad] at the start of a step and `turn` the angle [rad] of a step.
"""

import math
from typing import Any, NamedTuple

from ...base.protocols import Scheme
from ...base.results import Floats
from ...compile.elementwise import larger
from ...compile.jit import borrowed, kernel, kernel_as
from ...compile.lanes import VECTOR_LANES, lane, load, store
from ...compile.tree import count
from .pieces import Ends, Even, Piece, updated, vertex

BOUND = 1e100  # a state beyond it has left for infinity
KEPT_STATES = 9  # stroboscopic states kept: enough to see motions of up to eight periods close


class LaneModel(NamedTuple):
    """Model of a lane: what the floats of its column belong to.

    `kind` is `Smooth` or `General`; `state` and `sums` are tuples of the shape of the states and of the measures' sums.
    """

    system: Any
    state: Any
    kind: Any
    measures: Any
    sums: Any


class FirstRows(NamedTuple):
    """Numbers of the first row of each part of a block.

    `step` is the time step [s] of fixed steps, 1/omega [s] of adaptive ones; `state` the states; `other` the states
    after every other pair of fixed steps, the rates of adaptive ones; `sums` those of the measures. From `start` on
    there are the states with which these began, or the step control of adaptive steps. `reach` is the largest |x| [rad]
    at the ends of fixed steps.
    """

    step: int
    state: int
    other: int
    sums: int
    start: int
    reach: int


@kernel
def first_rows(model: LaneModel) -> FirstRows:
    """First rows of a block of lanes of a model."""
    state, states = count(model.system) + 1, count(model.state)
    start = state + 2 * states + count(model.sums)
    return FirstRows(state - 1, state, state + states, state + 2 * states, start, start + states)


@kernel_as(lambda ended: range(len(ended) // VECTOR_LANES * VECTOR_LANES), inline=True)
def every_lane(ended: Floats) -> Any:
    """Lanes to loop over, as many as `ended` has: one at a time, or as Python all at once."""
    return (slice(len(ended)),)


@kernel
def raise_reach(x: Any, rows: Floats, row: int, j: slice) -> None:
    """Raise the largest |x| of lane j."""
    store(larger(abs(x), load(rows, row, j)), rows, row, j)


@kernel
def take_two_steps(
    scheme: Any, model: Any, rows: Floats, source: int, target: int, phase: float, turn: float, j: slice
) -> None:
    """Take two steps of lane j from the states in rows `source` to those in rows `target`."""
    first = first_rows(model)
    system, h = lane(model.system, rows, 0, j), load(rows, first.step, j)
    middle = scheme.step(system, phase, turn, lane(model.state, rows, source, j), h)
    y = scheme.step(system, phase + turn, turn, middle, h)
    store(y, rows, target, j)
    raise_reach(y[0], rows, first.reach, j)


@kernel
def take_step(scheme: Scheme, model: Any, rows: Floats, phase: float, turn: float, j: slice) -> None:
    """Take one step of lane j."""
    first = first_rows(model)
    system, h = lane(model.system, rows, 0, j), load(rows, first.step, j)
    y = scheme.step(system, phase, turn, lane(model.state, rows, first.state, j), h)
    store(y, rows, first.state, j)
    raise_reach(y[0], rows, first.reach, j)


@kernel
def add_piece(model: Any, rows: Floats, piece: Piece, j: slice) -> None:
    """Update the sums of the measures of lane j by a piece of its trajectory."""
    first = first_rows(model)
    store(updated(model.measures, lane(model.sums, rows, first.sums, j), piece), rows, first.sums, j)


@kernel
def measure_two_steps(
    model: Any, rows: Floats, source: int, target: int, phase: float, turn: float, j: slice
) -> None:  # fmt: skip
    """Update the measures of lane j by the pair of steps from the states in rows `source` to those in rows `target`."""
    system, h = lane(model.system, rows, 0, j), load(rows, first_rows(model).step, j)
    y, y1, end = lane(model.state, rows, source, j), lane(model.state, rows, target, j), phase + 2.0 * turn
    v, v1 = system.rhs(phase, y)[0], system.rhs(end, y1)[0]
    extreme = vertex(y[0], v, y1[0], v1, 2.0 * h)
    add_piece(model, rows, Piece(Even(), phase, y[0], v, end, y1[0], v1, 2.0 * h, turn / h, extreme), j)


@kernel
def take_measured_step(scheme: Any, model: Any, rows: Floats, phase: float, turn: float, j: slice) -> None:
    """Take one step of lane j and update its measures."""
    first, end = first_rows(model), phase + turn
    system, h, y = lane(model.system, rows, 0, j), load(rows, first.step, j), lane(model.state, rows, first.state, j)
    y1 = scheme.step(system, phase, turn, y, h)
    store(y1, rows, first.state, j)
    before, after = system.rhs(phase, y), system.rhs(end, y1)
    extreme = model.kind.extreme(y, before, y1, after, h)
    raise_reach(y1[0], rows, first.reach, j)
    add_piece(model, rows, Piece(Even(), phase, y[0], before[0], end, y1[0], after[0], h, turn / h, extreme), j)


@kernel
def keep_start(model: Any, rows: Floats, j: slice) -> None:
    """Keep the state of lane j with which the measures begin."""
    first = first_rows(model)
    store(lane(model.state, rows, first.state, j), rows, first.start, j)


@kernel
def measure_ends(model: Any, rows: Floats, turn: float, steps: float, j: slice) -> None:
    """Add to the measures of lane j what the even pieces, `steps` each, lack: the first state, and sums' ends."""
    first = first_rows(model)
    system, h = lane(model.system, rows, 0, j), load(rows, first.step, j)
    begin, last = lane(model.state, rows, first.start, j), lane(model.state, rows, first.state, j)
    v0, v1 = system.rhs(0.0, begin)[0], system.rhs(0.0, last)[0]
    add_piece(model, rows, Piece(Ends(), 0.0, begin[0], v0, 0.0, last[0], v1, steps * h, turn / h, begin[0]), j)


@kernel
def end_period(model: Any, rows: Floats, period: int, last: Floats, ended: Any, j: slice) -> None:
    """Keep the state of lane j at the end of a period, and count the periods over which all states stay bounded."""
    y = lane(model.state, rows, first_rows(model).state, j)
    store(y, last[period % KEPT_STATES], 0, j)
    size = abs(y[0])
    for i in range(1, len(y)):
        size = size + abs(y[i])
    ended[j] = ended[j] + (size < BOUND) * (ended[j] == period)


@kernel
def march_pairs(
    model: Any, rows: Floats, rule: Any, waiting: Any, settle: int, periods: int, last: Floats, ended: Floats
) -> None:
    """March a block by pairs of steps, and measure pairs; `rule` is the scheme and the steps a period (fours)."""
    scheme, steps = rule
    rows, last, ended = borrowed((rows, last, ended))
    turn, first = 2.0 * math.pi / steps, first_rows(model)
    for period in range(settle + periods):
        if period == settle:
            for j in every_lane(ended):
                keep_start(model, rows, j)
        for i in range(0, steps, 4):
            phase, later = i * turn, (i + 2) * turn
            for j in every_lane(ended):
                take_two_steps(scheme, model, rows, first.state, first.other, phase, turn, j)
            if period >= settle:
                for j in every_lane(ended):
                    measure_two_steps(model, rows, first.state, first.other, phase, turn, j)
            for j in every_lane(ended):
                take_two_steps(scheme, model, rows, first.other, first.state, later, turn, j)
            if period >= settle:
                for j in every_lane(ended):
                    measure_two_steps(model, rows, first.other, first.state, later, turn, j)
        for j in every_lane(ended):
            end_period(model, rows, period, last, ended, j)
    for j in every_lane(ended):
        measure_ends(model, rows, turn, 2.0, j)


@kernel
def march_steps(
    model: Any, rows: Floats, rule: Any, waiting: Any, settle: int, periods: int, last: Floats, ended: Floats
) -> None:
    """March a block step by step; `rule` is the scheme and the steps a period. Measure after the first periods."""
    scheme, steps = rule
    rows, last, ended = borrowed((rows, last, ended))
    turn = 2.0 * math.pi / steps
    for period in range(settle + periods):
        if period == settle:
            for j in every_lane(ended):
                keep_start(model, rows, j)
        for i in range(steps):
            if period < settle:
                for j in every_lane(ended):
                    take_step(scheme, model, rows, i * turn, turn, j)
            else:
                for j in every_lane(ended):
                    take_measured_step(scheme, model, rows, i * turn, turn, j)
        for j in every_lane(ended):
            end_period(model, rows, period, last, ended, j)
    for j in every_lane(ended):
        measure_ends(model, rows, turn, 1.0, j)
