"""Lanes of a system that measured signals drive, from sample to sample."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...compile.jit import borrowed, kernel, kernel_as, run
from ...compile.lanes import LANES, lane, load, store
from ...protocols import prepared
from ...results import Floats
from ...tree import count, leaves, mapped
from ..integration.steps import rk4_step
from .signal import COEFFICIENTS, DEGREE, START, places_of

WIDE = 8  # lanes of the widest vector: a block has a multiple of them


@kernel_as(lambda lanes: range(lanes), inline=True)
def first_lanes(lanes: int) -> Any:
    """Lanes to loop over: one at a time, or as Python all at once."""
    return (slice(0, lanes),)


@kernel
def march_driven(
    model: Any, start: Any, rows: Any, lanes: int, pieces: Any, places: Any, seen: Any, begin: int, samples: int,
    parts: int, step: float, out: Any,
) -> None:  # fmt: skip
    """March lanes over samples from `begin` on, `parts` fourth-order steps between two, and keep the states `seen`.

    Rows are the leaves of the model and its states; the signals at `places` get their `pieces` one after the other.
    """
    rows, pieces, places, seen, out = borrowed((rows, pieces, places, seen, out))
    at, h = count(model), step / parts
    for k in range(samples):
        for i in range(len(seen)):
            for j in first_lanes(lanes):
                out[i, k, j] = load(rows, at + seen[i], j)
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
                    one, y = lane(model, rows, 0, j), lane(start, rows, at, j)
                    store(rk4_step(one, one.omega * t, one.omega * h, y, h), rows, at, j)


@dataclass(frozen=True)
class Lanes:
    """Variants of one system, ready to run: a template, its leaves (leaves, lanes), and where its signals are."""

    model: Any
    table: Floats
    places: Any

    def run(
        self, starts: Floats, pieces: Floats, seen: Any, samples: int, parts: int, step: float, begin: int = 0
    ) -> Floats:
        """States `seen` (seen, samples, lanes) from the states `starts` (states, lanes) at the sample `begin`.

        The samples are `step` [s] apart, and time counts from the first of all.
        """
        lanes = self.table.shape[1]
        wide = -(-lanes // WIDE) * WIDE
        rows = np.empty((len(self.table) + len(starts), LANES))
        rows[:, :lanes] = np.concatenate([self.table, starts])
        rows[:, lanes:wide] = rows[:, :1]
        out = np.empty((len(seen), samples, wide))
        start = (0.0,) * len(starts)
        with np.errstate(all="ignore"):
            run(
                march_driven, self.model, start, rows, wide, pieces, self.places, seen, begin, samples, parts, step, out
            )
        return out[:, :, :lanes]


def lanes_of(systems: list[Any]) -> Lanes:
    """Variants of one system, in its form for many steps."""
    if len(systems) > LANES:
        raise ValueError(f"{len(systems)} variants at once; a block holds {LANES}")
    every = prepared(mapped(lambda *values: np.array(values, float), *systems))
    rows = [np.broadcast_to(np.asarray(leaf, float), len(systems)) for leaf in leaves(every)]
    model = mapped(lambda leaf: float(np.ravel(leaf)[0]), every)
    return Lanes(model, np.array(rows), np.array(places_of(model), int))
