"""What is told of an ensemble: its variables over the lanes, with units."""

from typing import Any

import numpy as np
import xarray as xr

from ...quantities import parameters
from ...results import Floats
from ...tree import leaves
from ..integration.simulate import Dopri5, Rk4
from .blocks import Batch, Block
from .measures import Final, Poincare
from .pieces import Smooth

SETTLED = 1e-6  # largest change of a settled state from one period (or up to eight) to the next, of fixed steps
LOOSE = 1e4  # of adaptive ones, in units of their tolerance
REST = 1e-15  # what is smaller than this share of the initial state has come to rest


def dataset_of(
    system: Any, varied: dict[str, Floats], batch: Batch, found: Block, measures: Any, method: Rk4 | Dopri5
) -> xr.Dataset:
    """Variables over the lanes, with units, from what came of them."""
    periods = batch.settle + batch.periods
    good, short = found.ended == periods, found.ended < 0.0
    ended = np.where(short, -1.0 - found.ended, found.ended)
    turn = 2.0 * np.pi / batch.omega
    units = {p.path: p.unit for p in parameters(system)}
    names = system.state_names() if hasattr(system, "state_names") else [f"y{i}" for i in range(len(batch.y0))]
    angle = {"units": "rad"} if hasattr(system, "torsion") else {}
    data = xr.Dataset(coords={path: ("lane", v, {"units": units[path]}) for path, v in varied.items()})
    at = 0
    for measure in batch.measures:
        n = len(leaves(measure.start()))
        with np.errstate(all="ignore"):
            variables = measure.results(found.sums[at : at + n], batch.periods * turn)
        at += n
        for name, values in variables.items():
            data[name] = ("lane", np.where(good, values, np.nan), dict(angle))
    if any(isinstance(measure, Final) for measure in measures):
        data["final"] = (("state", "lane"), np.where(good, found.last[-1], np.nan))
    if any(isinstance(measure, Poincare) for measure in measures):
        inside = np.arange(periods)[:, None, None] < ended
        data["points"] = (("turn", "state", "lane"), np.where(inside, found.points, np.nan))
    if "final" in data or "points" in data:
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


def _periods_of(batch: Batch, found: Block, good: Any, method: Rk4 | Dopri5) -> Any:
    """Turns after which a state comes back (lanes,): the smallest number up to 8; 0 where there is none.

    To a share of its size, in which a rate counts as what it is at the base frequency; closer than the tolerance of
    adaptive steps, or than 1e-15 of the start, is back.
    """
    settled, near = SETTLED, 0.0
    if isinstance(method, Dopri5):
        settled, near = max(SETTLED, LOOSE * method.rtol), 10.0 * method.atol
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
