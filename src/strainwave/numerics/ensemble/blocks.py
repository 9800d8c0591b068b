"""A batch of lanes, and its run through the kernel, block by block."""

import logging
from dataclasses import dataclass, replace
from time import monotonic
from typing import Any

import numpy as np

from ...base.results import Floats
from ...compile.jit import run
from ...compile.lanes import LANES, VECTOR_LANES
from ...compile.tree import leaves
from ..integration.methods import Method
from .fixed_step import KEPT_STATES, LaneModel, first_rows
from .stepping import stepping_of
from .threads import results_of

log = logging.getLogger(__name__)

PARTS = ("sums", "last", "ended", "reach")  # of a `Block`, with the lanes last


@dataclass(frozen=True)
class Batch:
    """Systems, states and measures of all lanes of an ensemble.

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
        Kind of the states.
    measures : tuple
        Measures that are accumulated.
    settle, periods : int
        Periods before the measures begin, and of the measures.
    """

    template: Any
    numbers: Floats
    omega: Floats
    y0: Floats
    kind: Any
    measures: tuple[Any, ...]
    settle: int
    periods: int

    def part(self, lanes: Any) -> "Batch":
        """Batch of some of the lanes."""
        return replace(self, numbers=self.numbers[:, lanes], omega=self.omega[lanes], y0=self.y0[:, lanes])


@dataclass(frozen=True)
class Block:
    """Result of some lanes.

    Attributes
    ----------
    sums : (sums, lanes) array
        Sums of the measures.
    last : (up to 9, states, lanes) array
        States at the ends of the last periods, oldest first.
    ended : (lanes,) array
        Periods over which the states stayed bounded.
    reach : (lanes,) array
        Largest |x| at the ends of fixed steps.
    """

    sums: Floats
    last: Floats
    ended: Floats
    reach: Floats

    def put(self, lanes: Any, other: "Block") -> None:
        """Put another result in the place of these lanes."""
        for part in PARTS:
            getattr(self, part)[..., lanes] = getattr(other, part)


def march(batch: Batch, lanes: Any, method: Method, steps: int) -> Block:
    """Run these lanes of a batch (numbers, at most a block of them) through all their periods."""
    n, states = len(lanes), len(batch.y0)
    width = -(-n // VECTOR_LANES) * VECTOR_LANES
    full = np.concatenate([lanes, np.repeat(lanes[-1:], width - n)])
    starts = tuple(measure.start() for measure in batch.measures)
    model = LaneModel(batch.template, (0.0,) * states, batch.kind, batch.measures, starts)
    first, stepping = first_rows(model), stepping_of(method)
    rule, time_steps = stepping.arguments(batch.omega[full], steps)
    rows = np.zeros((first.reach + 3, LANES))
    rows[: first.step, :width] = batch.numbers[:, full]
    rows[first.step, :width] = time_steps
    rows[first.state : first.other, :width] = batch.y0[:, full]
    rows[first.sums : first.start] = np.array(leaves(starts), float)[:, None]
    last, ended, waiting = np.zeros((KEPT_STATES, states, LANES)), np.zeros(width), np.zeros(width, np.int64)
    with np.errstate(all="ignore"):
        run(stepping.kernel, model, rows, rule, waiting, batch.settle, batch.periods, last, ended)
    periods = batch.settle + batch.periods
    newest = (periods - 1 - np.arange(min(KEPT_STATES, periods))[::-1]) % KEPT_STATES
    sums = rows[first.sums : first.start, :n]
    return Block(sums, last[newest, :, :n], ended[:n], rows[first.reach, :n])


def march_all(batch: Batch, steps: Any, method: Method, threads: int) -> Block:
    """Run all lanes of a batch, in blocks of lanes with one number of steps a period."""
    jobs = []
    for number in np.unique(steps):
        lanes = np.flatnonzero(steps == number)
        jobs += [(lanes[i : i + LANES], int(number)) for i in range(0, len(lanes), LANES)]

    def job(item: tuple[Any, int]) -> Block:
        return march(batch, item[0], method, item[1])

    logged, ready, blocks = monotonic(), 0, []
    for (lanes, _), block in zip(jobs, results_of(job, jobs, threads), strict=True):
        blocks.append(block)
        ready += len(lanes)
        if monotonic() - logged >= 1.0:
            logged = monotonic()
            log.info("%d of %d trajectories (%.0f %%)", ready, len(steps), 100.0 * ready / len(steps))
    back = np.argsort(np.concatenate([lanes for lanes, _ in jobs]))
    joined: Any = [np.concatenate([getattr(block, part) for block in blocks], axis=-1)[..., back] for part in PARTS]
    return Block(*joined)
