"""`Lanes`: variants of a system that measured signals drive, marched from sample to sample."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...base.protocols import prepared
from ...base.results import Floats
from ...compile.jit import borrowed, kernel, kernel_as, run
from ...compile.lanes import LANES, lane, load, store
from ...compile.tree import count, leaves, mapped
from ...numerics.integration.steps import rk4_step
from .input_signals import COEFFICIENTS, DEGREE, START, places_of

MOST_LANES = 8  # lanes of the widest vector: a block has a multiple of them


@kernel_as(lambda lanes: range(lanes), inline=True)
def first_lanes(lanes: int) -> Any:
    """Lanes to loop over: one at a time, or as Python all at once."""
    return (slice(0, lanes),)


@kernel
def march_lanes(
    model: Any, start: Any, rows: Floats, lanes: int, pieces: Floats, places: Any, picked: Any, begin: int,
    samples: int, parts: int, step: float, states: Floats,
) -> None:  # fmt: skip
    """March lanes over samples from `begin` on, `parts` fourth-order steps between two, and keep the states `picked`.

    Rows are the leaves of the model and its states; the signals at `places` get their `pieces` one after the other.
    """
    rows, pieces, places, picked, states = borrowed((rows, pieces, places, picked, states))
    offset, h = count(model), step / parts
    for k in range(samples):
        for i in range(len(picked)):
            for j in first_lanes(lanes):
                states[i, k, j] = load(rows, offset + picked[i], j)
        if k + 1 < samples:
            for p in range(k * parts, (k + 1) * parts):
                t = (begin * parts + p) * h
                for q in range(len(places)):
                    for j in first_lanes(lanes):
                        rows[places[q] + START, j] = t
                    for c in range(DEGREE + 1):
                        for j in first_lanes(lanes):
                            rows[places[q] + COEFFICIENTS + c, j] = pieces[q, p, c]
                for j in first_lanes(lanes):
                    model_j, y = lane(model, rows, 0, j), lane(start, rows, offset, j)
                    store(rk4_step(model_j, model_j.omega * t, model_j.omega * h, y, h), rows, offset, j)


@dataclass(frozen=True)
class Lanes:
    """Variants of one system, ready to run: a template, its leaves (leaves, lanes), and where its signals are."""

    model: Any
    table: Floats
    places: Any

    def run(
        self, starts: Floats, pieces: Floats, picked: Any, samples: int, parts: int, step: float, begin: int = 0
    ) -> Floats:
        """States `picked` (picked, samples, lanes) from the states `starts` (states, lanes) at the sample `begin`.

        The samples are `step` [s] apart, and time counts from the first of all.
        """
        lanes = self.table.shape[1]
        wide = -(-lanes // MOST_LANES) * MOST_LANES
        rows = np.empty((len(self.table) + len(starts), LANES))
        rows[:, :lanes] = np.concatenate([self.table, starts])
        rows[:, lanes:wide] = rows[:, :1]
        states = np.empty((len(picked), samples, wide))
        start = (0.0,) * len(starts)
        with np.errstate(all="ignore"):
            run(
                march_lanes, self.model, start, rows, wide, pieces, self.places, picked, begin, samples, parts,
                step, states,
            )  # fmt: skip
        return states[:, :, :lanes]


def lanes_of(systems: list[Any]) -> Lanes:
    """Variants of one system, in its form for many steps."""
    if len(systems) > LANES:
        raise ValueError(f"{len(systems)} variants at once; a block holds {LANES}")
    every = prepared(mapped(lambda *values: np.array(values, float), *systems))
    rows = [np.broadcast_to(np.asarray(leaf, float), len(systems)) for leaf in leaves(every)]
    model = mapped(lambda leaf: float(np.ravel(leaf)[0]), every)
    return Lanes(model, np.array(rows), np.array(places_of(model), int))
