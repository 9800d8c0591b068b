"""Blocks of lanes: what lanes are made of, and one run of a block through its kernel."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...base.results import Floats
from ...compile.jit import run
from ...compile.lanes import LANES, VECTOR_LANES
from ...compile.tree import leaves
from ..integration.methods import Method
from .fixed_step import KEPT_STATES, first_rows
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
    attempts : int
        Adaptive steps that every lane attempted.
    """

    sums: Floats
    last: Floats
    ended: Floats
    reach: Floats
    attempts: int = 0


def march(batch: Batch, places: Any, method: Method, steps: int) -> Block:
    """Run the lanes at these places (at most a block of them) through all their periods."""
    n, y0 = len(places), (0.0,) * len(batch.y0)
    width = -(-n // VECTOR_LANES) * VECTOR_LANES
    full = np.concatenate([places, np.repeat(places[-1:], width - n)])
    starts = tuple(measure.start() for measure in batch.measures)
    first = first_rows(batch.template, y0, starts)
    rows = np.zeros((first.reach + 3, LANES))
    rows[: first.step, :width], rows[first.state : first.other, :width] = batch.numbers[:, full], batch.y0[:, full]
    rows[first.sums : first.start] = np.array(leaves(starts), float)[:, None]
    periods = batch.settle + batch.periods
    last, ended = np.zeros((KEPT_STATES, len(y0), LANES)), np.zeros(width)
    common = batch.template, y0, batch.kind, batch.measures, starts, rows
    stepping, waiting = stepping_of(method), np.zeros(width, np.int64)
    rule, rows[first.step, :width] = stepping.arguments(batch.omega[full], steps)
    with np.errstate(all="ignore"):
        attempts = run(stepping.kernel, *common, rule, waiting, batch.settle, batch.periods, last, ended)
    newest = (periods - 1 - np.arange(min(KEPT_STATES, periods))[::-1]) % KEPT_STATES
    sums = rows[first.sums : first.start, :n]
    return Block(sums, last[newest, :, :n], ended[:n], rows[first.reach, :n], attempts or 0)
