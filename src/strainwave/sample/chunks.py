"""Chunks of a sweep: blocks of the arrays over its points, each computed and written by itself."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..compile.lanes import LANES

MOST_CHUNKS = 4096  # that a sweep point by point is cut into: each costs a few files and milliseconds
LEAST_POINTS, MOST_POINTS = 32, 1 << 17  # points of a chunk whose size the user does not give
SHARES = 64  # chunks that whole-chunk measures get at least, if these are not too small
STORE_CHUNKS = 10_000_000  # most chunks of a store: a few files each
LOOSE_POINTS = 100_000_000  # most points of a sweep without a store: hours
MOST_CHUNK_POINTS = 1 << 28  # points of a chunk: 2 GiB of every parameter
SPARE_LANES = 1.1  # times as many lanes as with the best size are taken for smaller chunks


def _ceil(a: int, b: int) -> int:
    """Return a/b, rounded up."""
    return -(-a // b)


class Stretch(NamedTuple):
    """Points of one chunk: the first of them, how many, and where they are in the arrays."""

    first: int
    points: int
    region: tuple[slice, ...]


@dataclass(frozen=True)
class Layout:
    """Shape of the arrays over the points, and of the block that one chunk holds.

    A block is complete in its last dimensions and has length 1 in the first ones, so that its points follow each
    other: point i is the i-th element of the arrays in C order.
    """

    shape: tuple[int, ...]
    block: tuple[int, ...]

    @property
    def points(self) -> int:
        """Number of points."""
        return math.prod(self.shape)

    @property
    def counts(self) -> tuple[int, ...]:
        """Number of chunks along every dimension."""
        return tuple(_ceil(n, b) for n, b in zip(self.shape, self.block, strict=True))

    @property
    def chunks(self) -> int:
        """Number of chunks."""
        return math.prod(self.counts)

    def indices(self, chunk: int) -> tuple[int, ...]:
        """Index of a chunk along every dimension."""
        return tuple(int(i) for i in np.unravel_index(chunk, self.counts))

    def stretch(self, chunk: int) -> Stretch:
        """Points of a chunk, by its number."""
        starts = [i * b for i, b in zip(self.indices(chunk), self.block, strict=True)]
        stops = [min(s + b, n) for s, b, n in zip(starts, self.block, self.shape, strict=True)]
        first = int(np.ravel_multi_index(starts, self.shape))
        region = tuple(slice(s, e) for s, e in zip(starts, stops, strict=True))
        return Stretch(first, math.prod(e - s for s, e in zip(starts, stops, strict=True)), region)


def layout_of(shape: tuple[int, ...], target: int) -> Layout:
    """Cut arrays of a shape into even blocks of at most `target` points."""
    block, left = [1] * len(shape), target
    for axis in reversed(range(len(shape))):
        pieces = _ceil(shape[axis], left)
        block[axis] = _ceil(shape[axis], pieces)
        left //= block[axis]
        if pieces > 1 or left <= 1:
            break
    return Layout(shape, tuple(block))


def chunk_size(shape: tuple[int, ...], least: int | None = None) -> int:
    """Points of a chunk when the user does not say: it depends on nothing but the sweep itself.

    Parameters
    ----------
    shape : tuple of int
        Shape of the arrays over the points.
    least : int, optional
        For a measure of whole chunks: the fewest lanes that are worth a chunk.
    """
    points = math.prod(shape)
    if least is None:
        return min(MOST_POINTS, max(LEAST_POINTS, _ceil(points, MOST_CHUNKS)))
    target = LANES * max(1, _ceil(max(least, _ceil(points, SHARES)), LANES))
    if target >= MOST_POINTS:
        return MOST_POINTS
    # A block of the arrays rarely has as many points as it may: the smallest size that leaves few lanes empty.
    sizes = range(target, min(2 * target, MOST_POINTS) + 1, max(LANES, target // 8 // LANES * LANES))
    lanes = {size: _lanes(layout_of(shape, size)) for size in sizes}
    return next(size for size in sizes if lanes[size] <= SPARE_LANES * min(lanes.values()))


def _lanes(layout: Layout) -> int:
    """Lanes that are computed where every chunk fills its last block of lanes up."""
    return layout.chunks * _ceil(math.prod(layout.block), LANES)


def check_size(layout: Layout, stored: bool) -> None:
    """Refuse a sweep of more chunks than can be kept, or of chunks too large to be held (ValueError)."""
    points, block = layout.points, math.prod(layout.block)
    if block > MOST_CHUNK_POINTS:
        raise ValueError(f"chunk has {block:.4g} points; at most {MOST_CHUNK_POINTS} fit into memory at a time")
    if layout.chunks > STORE_CHUNKS:
        raise ValueError(
            f"the sweep has {points:.4g} points, that is {layout.chunks:.4g} chunks of up to {block} points, and at "
            f"most {STORE_CHUNKS} can be kept; use fewer values, a Sobol or LatinHypercube sample, or a larger chunk"
        )
    if not stored and points > LOOSE_POINTS:
        raise ValueError(f"{points:,} points are more than {LOOSE_POINTS:,}; give the sweep a store for its results")
