"""Lanes of an ensemble marched on until each repeats itself, leaves every bound, or has had its longest time."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...base.protocols import omega_of
from ...base.quantities import replace
from ...base.results import Floats
from ..ensemble.ensemble import ensemble, lanes_run
from ..ensemble.measures import Extremes, Final
from ..integration.methods import Dop8, Dopri5, Method

SEEN = 8  # periods that are measured: the longest period that an ensemble recognises
APART = 1e-6  # of a state's size: two trajectories that start so close tell whether a motion is chaotic
STRETCHES = 100  # turns over which that is looked at
UNCOUNTED = 10  # turns before, until the neighbour lies where motions drift apart


@dataclass(frozen=True, eq=False)
class Settled:
    """What became of every lane.

    Attributes
    ----------
    state : (states, lanes) array
        State at base phase 0 at the end; nan where it diverged.
    period : (lanes,) int array
        Turns after which the motion repeats; 0 where it does not.
    diverged : (lanes,) bool array
        Whether it left every bound.
    lowest, highest : (lanes,) arrays
        Extremes of the first state over the last 8 turns.
    """

    state: Floats
    period: NDArray[np.int64]
    diverged: NDArray[np.bool_]
    lowest: Floats
    highest: Floats


def settled(
    system: Any,
    parameters: dict[str, Any],
    y0: Floats,
    *,
    settle: int,
    longest: int,
    method: Method | None = None,
    threads: int | None = None,
    known: Callable[[Settled], NDArray[np.bool_]] | None = None,
) -> Settled:
    """March every lane from its state (states, lanes) for `settle` turns, and those not settled on to `longest`.

    With `known`, which tells the lanes that are on known motions, those that are not go on, settled or not.
    """
    lanes = y0.shape[1]
    lowest, highest = np.full((2, lanes), np.nan)
    result = Settled(np.full(y0.shape, np.nan), np.zeros(lanes, np.int64), np.zeros(lanes, bool), lowest, highest)
    places, start, turns, skipped = np.arange(lanes), y0, 0, settle
    while True:
        varied: dict[str, Any] = {path: np.broadcast_to(v, (lanes,))[places] for path, v in parameters.items()}
        run, _ = lanes_run(
            system, varied, tuple(start), periods=SEEN, settle=skipped, measures=(Extremes(), Final()), method=method,
            threads=threads,
        )  # fmt: skip
        turns += skipped + SEEN
        result.state[:, places] = run["final"].values
        result.period[places] = run["period"].values
        result.diverged[places] = run["status"].values != 0
        result.lowest[places], result.highest[places] = run["lowest"].values, run["highest"].values
        ended = result.diverged | (result.period > 0 if known is None else known(result))
        active = ~ended[places]
        if not active.any() or turns >= longest:
            return result
        start, places = run["final"].values[:, active], places[active]
        skipped = min(turns, longest - turns)


def stretching(
    system: Any, parameters: dict[str, Any], state: Floats, stretches: int = STRETCHES
) -> tuple[Floats, Floats]:
    """Rates [1/s] (stretches, lanes) at which a neighbour of every lane moves away, turn after turn; the last states.

    Its distance is measured after every turn and brought back to its length before (Benettin, Galgani, Giorgilli &
    Strelcyn 1980, Meccanica 15, 9). Both trajectories take the same steps: with others their errors, too, grow apart.
    """
    lanes = state.shape[1]
    omega = np.broadcast_to(omega_of(replace(system, parameters)), (lanes,))
    size = np.maximum(np.max(np.abs(state), axis=0), 1e-300)
    unit = size * np.stack([np.ones(lanes), *[omega] * (len(state) - 1)])
    away = unit / np.sqrt(len(state)) * APART
    both: dict[str, Any] = {path: np.tile(np.broadcast_to(v, (lanes,)), 2) for path, v in parameters.items()}
    method, rates = None, []
    for _ in range(stretches + UNCOUNTED):
        start = np.concatenate([state, state + away], axis=1)
        found = ensemble(system, both, tuple(start), periods=1, measures=(Final(),), method=method)
        if method is None:
            fixed = "steps" in found
            method = Dop8(steps_per_period=int(2 * found["steps"].max())) if fixed else Dopri5(rtol=1e-11, atol=1e-14)
        final = found["final"].values
        state, gap = final[:, :lanes], final[:, lanes:] - final[:, :lanes]
        grown = np.sqrt(np.sum((gap / unit) ** 2, axis=0)) / APART
        with np.errstate(divide="ignore"):
            rates.append(np.log(grown) * omega / (2.0 * np.pi))
        away = gap / np.maximum(grown, 1e-300)
    return np.array(rates[UNCOUNTED:]), state
