"""What is told of an ensemble: its variables over the lanes, with units."""

import itertools
from typing import Any

import numpy as np
import xarray as xr

from ...protocols import lacking, names_of
from ...quantities import parameters
from ...results import Floats
from ...tree import leaves
from ..integration.methods import Method
from .blocks import Batch, Block
from .pieces import Smooth
from .stepping import stepping_of

REST = 1e-15  # what is smaller than this share of the initial state has come to rest


def dataset_of(
    system: Any, varied: dict[str, Floats], batch: Batch, found: Block, measures: Any, method: Method
) -> xr.Dataset:
    """Variables over the lanes, with units, from what came of them."""
    periods = batch.settle + batch.periods
    good, short = found.ended == periods, found.ended < 0.0
    ended = np.where(short, -1.0 - found.ended, found.ended)
    turn = 2.0 * np.pi / batch.omega
    units = {p.path: p.unit for p in parameters(system)}
    names = names_of(system) or [f"y{i}" for i in range(len(batch.y0))]
    angle = {} if lacking(system, "torsion") else {"units": "rad"}
    data = xr.Dataset(coords={path: ("lane", v, {"units": units[path]}) for path, v in varied.items()})
    at = 0
    for measure in batch.measures:
        n = len(leaves(measure.start()))
        with np.errstate(all="ignore"):
            variables = measure.results(found.sums[at : at + n], batch.periods * turn)
        at += n
        for name, values in variables.items():
            data[name] = ("lane", np.where(good, values, np.nan), _unit(measure, angle))
    inside = np.arange(len(found.points))[:, None, None] < ended
    states = {"of_end": np.where(good, found.last[-1], np.nan), "of_turns": np.where(inside, found.points, np.nan)}
    for part, measure in itertools.product(states, measures):
        if not lacking(measure, part):
            for name, values in getattr(measure, part)(states[part]).items():
                data[name] = (("turn", "state", "lane")[-np.ndim(values) :], values, _unit(measure, {}))
    if "state" in data.dims:
        data = data.assign_coords(state=list(names))
    status = np.where(short, 2, np.where(good, 0, 1)).astype(np.int8)
    meaning = "0 finished, 1 left every bound, 2 stopped: more steps than the method's max_steps (raise it, or rtol)"
    data["status"] = ("lane", status, {"meaning": meaning})
    data["ended"] = ("lane", ended * turn, {"units": "s", "long_name": "bounded until"})
    data["period"] = (
        "lane",
        _periods_of(batch, found, good, method),
        {"units": "turn", "long_name": "0: not settled"},
    )
    return data


def _unit(measure: Any, unit: dict[str, str]) -> dict[str, str]:
    return dict(unit) if lacking(measure, "unit") else {"units": measure.unit()}


def _periods_of(batch: Batch, found: Block, good: Any, method: Method) -> Any:
    """Turns after which a state comes back (lanes,): the smallest number up to 8; 0 where there is none.

    To a share of its size, in which a rate counts as what it is at the base frequency; closer than the tolerance of
    adaptive steps, or than 1e-15 of the start, is back.
    """
    settled, near = stepping_of(method).near()
    last = found.last
    size = np.max(np.abs(last), axis=0)
    start = np.abs(batch.y0)
    if isinstance(batch.kind, Smooth):
        for both in (size, start):
            both[0] = np.maximum(both[0], both[1] / batch.omega)
            both[1] = batch.omega * both[0]
    out = np.zeros(last.shape[2], np.int64)
    for n in range(len(last) - 1, 0, -1):
        with np.errstate(all="ignore"):
            back = np.all(np.abs(last[-1] - last[-1 - n]) <= settled * size + REST * start + near, axis=0)
        out[back & good] = n
    return out
