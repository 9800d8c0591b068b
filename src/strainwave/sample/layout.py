"""How the points of a sweep are cut into chunks: a chunk is a block of the result's arrays and a run of points."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..compile.lanes import LANES

MOST_CHUNKS = 4096  # that a sweep point by point is cut into: each costs a few files and milliseconds
SMALLEST, LARGEST = 32, 1 << 17
SHARES = 64  # chunks that whole-chunk measures get at least, if these are not too small
MOST_KEPT = 10_000_000  # chunks: a few files each
MOST_HELD = 1 << 28  # points of a chunk: 2 GiB of every parameter
SPARE = 1.1  # times as many lanes as with the best size are taken for smaller chunks


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
        return tuple(-(-n // b) for n, b in zip(self.shape, self.block, strict=True))

    @property
    def chunks(self) -> int:
        """Number of chunks."""
        return math.prod(self.counts)

    def place(self, chunk: int) -> tuple[int, ...]:
        """Place of a chunk along every dimension."""
        return tuple(int(i) for i in np.unravel_index(chunk, self.counts))

    def stretch(self, chunk: int) -> Stretch:
        """Points of a chunk."""
        starts = [i * b for i, b in zip(self.place(chunk), self.block, strict=True)]
        stops = [min(s + b, n) for s, b, n in zip(starts, self.block, self.shape, strict=True)]
        first = int(np.ravel_multi_index(starts, self.shape))
        region = tuple(slice(s, e) for s, e in zip(starts, stops, strict=True))
        return Stretch(first, math.prod(e - s for s, e in zip(starts, stops, strict=True)), region)


def layout_of(shape: tuple[int, ...], target: int) -> Layout:
    """Cut arrays of a shape into even blocks of at most `target` points."""
    block, left = [1] * len(shape), target
    for axis in reversed(range(len(shape))):
        pieces = -(-shape[axis] // left)
        block[axis] = -(-shape[axis] // pieces)
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
        return min(LARGEST, max(SMALLEST, -(-points // MOST_CHUNKS)))
    target = LANES * max(1, -(-max(least, -(-points // SHARES)) // LANES))
    if target >= LARGEST:
        return LARGEST
    # A block of the arrays rarely has as many points as it may: the smallest size that leaves few lanes empty.
    sizes = range(target, min(2 * target, LARGEST) + 1, max(LANES, target // 8 // LANES * LANES))
    lanes = {size: _lanes(layout_of(shape, size)) for size in sizes}
    return next(size for size in sizes if lanes[size] <= SPARE * min(lanes.values()))


def _lanes(layout: Layout) -> int:
    """Lanes that are computed where every chunk fills its last block of lanes up."""
    return layout.chunks * -(-math.prod(layout.block) // LANES)


def check_size(layout: Layout) -> None:
    """Refuse a sweep of more chunks than can be kept, or of chunks too large to be held (ValueError)."""
    points, block = layout.points, math.prod(layout.block)
    if block > MOST_HELD:
        raise ValueError(f"chunk is {block:.4g} points; at most {MOST_HELD} fit into memory at a time")
    if layout.chunks > MOST_KEPT:
        raise ValueError(
            f"the sweep has {points:.4g} points, that is {layout.chunks:.4g} chunks of up to {block} points, and at "
            f"most {MOST_KEPT} can be kept; take fewer values, a Sobol or LatinHypercube sample, or a larger chunk"
        )


def described(values: Mapping[str, Any], i: int) -> str:
    """Parameters of point i of a stretch as text."""
    return ", ".join(f"{path} = {array[i]:.9g}" for path, array in values.items())
