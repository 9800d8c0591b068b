"""Variables of an ensemble over its lanes, with units: what the measures give, and how every lane ended."""

from typing import Any, NamedTuple

import numpy as np

from ...base.protocols import System, lacking
from ...compile.tree import leaves
from ..integration.methods import Method
from .blocks import Batch, Block
from .pieces import Smooth
from .stepping import stepping_of

LANE = ("lane",)
AT_REST = 1e-15  # what is smaller than this share of the initial state has come to rest


class Variable(NamedTuple):
    """Values over the lanes, the last of its dimensions, with unit and remarks: what xarray makes a variable of."""

    dims: tuple[str, ...]
    values: Any
    attrs: dict[str, Any]


def variables_of(
    system: System, batch: Batch, block: Block, measures: Any, method: Method
) -> dict[str, Variable]:  # fmt: skip
    """Variables by name: of the measures, nan in lanes that did not finish, and `status`, `ended` and `period`."""
    finished, short = block.ended == batch.settle + batch.periods, block.ended < 0.0
    bounded = np.where(short, -1.0 - block.ended, block.ended)
    turn = 2.0 * np.pi / batch.omega
    status = np.where(short, 2, np.where(finished, 0, 1)).astype(np.int8)
    meaning = "0 finished, 1 left every bound, 2 stopped: more steps than the method's max_steps (raise it, or rtol)"
    return {
        **_from_sums(system, batch, block, finished),
        **_from_ends(measures, np.where(finished, block.last[-1], np.nan)),
        "status": Variable(LANE, status, {"meaning": meaning}),
        "ended": Variable(LANE, bounded * turn, {"units": "s", "long_name": "bounded until"}),
        "period": Variable(
            LANE, _periods_of(batch, block, finished, method), {"units": "turn", "long_name": "0: not settled"}
        ),
    }


def _from_sums(system: System, batch: Batch, block: Block, finished: Any) -> dict[str, Variable]:
    """Variables of the measures that are accumulated."""
    angle = {} if lacking(system, "torsion") else {"units": "rad"}
    time = batch.periods * (2.0 * np.pi / batch.omega)
    data, row = {}, 0
    for measure in batch.measures:
        rows = slice(row, row + len(leaves(measure.start())))
        row = rows.stop
        with np.errstate(all="ignore"):
            variables = measure.results(block.sums[rows], time)
        for name, values in variables.items():
            data[name] = Variable(LANE, np.where(finished, values, np.nan), _unit(measure, angle))
    return data


def _from_ends(measures: Any, ends: Any) -> dict[str, Variable]:
    """Variables that measures make of the states (states, lanes) at the end."""
    data = {}
    for measure in (one for one in measures if not lacking(one, "of_end")):
        for name, of_lanes in measure.of_end(ends).items():
            values = np.asarray(of_lanes)
            if values.shape[-1:] != ends.shape[-1:]:
                raise ValueError(f"{type(measure).__name__}.of_end gives {name!r} without a value for every lane")
            data[name] = Variable(("state", *LANE)[-values.ndim :], values, _unit(measure, {}))
    return data


def _unit(measure: Any, unit: dict[str, str]) -> dict[str, str]:
    """Unit of the variables of a measure: its own, else the one given."""
    return dict(unit) if lacking(measure, "unit") else {"units": measure.unit()}


def _periods_of(batch: Batch, block: Block, finished: Any, method: Method) -> Any:
    """Turns (lanes,) after which a state comes back, at most 8; 0 of lanes in which it does not.

    A state is back where every number of it differs by a small share of its size, or by less than the tolerance of
    adaptive steps. The size of a rate is at least that of its angle at the base frequency, and the other way round.
    """
    settled, tolerance = stepping_of(method).tolerances()
    last = block.last
    size, start = np.max(np.abs(last), axis=0), np.abs(batch.y0)
    if isinstance(batch.kind, Smooth):
        for sizes in (size, start):
            sizes[0] = np.maximum(sizes[0], sizes[1] / batch.omega)
            sizes[1] = batch.omega * sizes[0]
    largest_gap = settled * size + AT_REST * start + tolerance
    turns = np.zeros(last.shape[2], np.int64)
    for n in range(len(last) - 1, 0, -1):
        with np.errstate(all="ignore"):
            back = np.all(np.abs(last[-1] - last[-1 - n]) <= largest_gap, axis=0)
        turns[back & finished] = n
    return turns
