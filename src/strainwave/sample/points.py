"""Points of a sweep: how they are cut into chunks, what a measure says of each, and what it fails at.

A chunk is a block of the result's arrays and a run of points. `compute` needs nothing but its arguments and runs
anywhere: in this process, in another, on another machine.
"""

import contextlib
import inspect
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from enum import IntEnum
from numbers import Complex, Real
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..base.quantities import checked, replace
from ..base.results import Floats
from ..compile.jit import load
from ..compile.lanes import LANES
from ..numerics.ensemble.request import LaneError, check_lanes
from .sampling import by_path

Array: TypeAlias = NDArray[Any]

MOST_CALLS = 64  # of a measure that fails on a whole chunk, to find the points where it does
LONGEST_MESSAGE = 400
ESTIMATE = "error_estimate"  # attribute of a variable of a chunk: the sweep keeps the largest
SWEEP_NAMES = ("done", "message", "point_status", "chunk", "letter", "variable", ESTIMATE)


class PointStatus(IntEnum):
    """Outcome at a point: the variable `point_status` of a sweep."""

    OK = 0
    RAISED = 1
    ANOTHER_SHAPE = 2
    LOST = 3
    NOT_COMPUTED = 255


class Variable(NamedTuple):
    """One variable of a sweep: its name, type, the dimensions it has besides those of the points, and its unit."""

    name: str
    dtype: str
    dims: tuple[str, ...]
    shape: tuple[int, ...]
    attributes: dict[str, Any]

    def empty(self, count: int) -> Array:
        """Array for `count` points, filled with what stands where there is no result."""
        return np.full((count, *self.shape), self.fill, self.dtype)

    @property
    def fill(self) -> Any:
        """Value without a result: NaN, or -1 in whole numbers."""
        return -1 if self.dtype.startswith("int") else np.nan


class Part(NamedTuple):
    """Results at the points of a chunk; `message` tells of the first that failed."""

    variables: tuple[Variable, ...]
    arrays: dict[str, Array]
    status: NDArray[np.uint8]
    message: str
    estimates: dict[str, float]


@dataclass(frozen=True)
class Job:
    """Work of a sweep at every point.

    Attributes
    ----------
    measure, system
        As in `sweep`.
    seed : int
        Seed of the points' random numbers; point i has `SeedSequence(seed).spawn(...)[i]`.
    variables : tuple of Variable or None
        What the measure returns, None until that is known.
    """

    measure: Callable[..., Any]
    system: Any
    seed: int
    variables: tuple[Variable, ...] | None = None

    @property
    def whole_chunks(self) -> bool:
        """True if the measure takes a whole chunk at a time."""
        return bool(getattr(self.measure, "whole_chunks", False))


class _AnotherShape(ValueError):
    """A measure returned something else than at the points before."""


def compute(job: Job, first: int, values: Mapping[str, Floats]) -> Part:
    """Measure a stretch of points.

    Parameters
    ----------
    job : Job
        What to do.
    first : int
        Number of the first point in the sweep.
    values : dict of str to (n,) array
        Values of the parameters at the points.
    """
    load()  # no last bit depends on what this process did before
    count = len(next(iter(values.values())))
    apart = by_path(job.system, values)
    pieces = _by_halves(job, first, apart) if job.whole_chunks else _one_by_one(job, first, apart)
    variables, message = job.variables or (), ""
    status = np.zeros(count, np.uint8)
    arrays = {variable.name: variable.empty(count) for variable in variables}
    estimates: dict[str, float] = {}
    for places, result in pieces:
        try:
            if isinstance(result, BaseException):
                raise result
            dataset = _as_arrays(result, len(places), job.whole_chunks)
            if not variables:
                variables = tuple(_variable(name, *item) for name, item in dataset.items())
                arrays = {variable.name: variable.empty(count) for variable in variables}
            _check_names(variables, dataset)
            for variable in variables:
                array, _, attributes = dataset[variable.name]
                arrays[variable.name][places] = _fitting(variable, array)
                if ESTIMATE in attributes:
                    estimates[variable.name] = max(estimates.get(variable.name, 0.0), attributes[ESTIMATE])
        except (Exception, SystemExit) as error:
            shape = isinstance(error, _AnotherShape)
            status[places] = PointStatus.ANOTHER_SHAPE if shape else PointStatus.RAISED
            message = message or _sentence(first + places[0], described(values, places[0]), error)
    return Part(variables, arrays, status, message, estimates)


def lost(job: Job, first: int, values: Mapping[str, Floats], why: str) -> Part:
    """Return the part of a chunk whose worker died each time it was computed."""
    count = len(next(iter(values.values())))
    arrays = {variable.name: variable.empty(count) for variable in job.variables or ()}
    message = f"points {first} to {first + count - 1} (from {described(values, 0)}): {why}"[:LONGEST_MESSAGE]
    return Part(job.variables or (), arrays, np.full(count, PointStatus.LOST, np.uint8), message, {})


Pieces = Iterator[tuple[Any, Any]]  # places in the stretch, and what was found there or went wrong


def _one_by_one(job: Job, first: int, values: Mapping[str, Floats]) -> Pieces:
    random = _takes_random(job.measure)
    columns = {path: array.tolist() for path, array in values.items()}
    for i in range(len(next(iter(columns.values())))):
        try:
            system = checked(replace(job.system, {path: column[i] for path, column in columns.items()}))
            yield [i], job.measure(system, **_random(job, first + i, random))
        except (Exception, SystemExit) as error:
            yield [i], error


def _by_halves(job: Job, first: int, values: Mapping[str, Floats]) -> Pieces:
    """Measure a stretch at once; where that raises, its halves, until the points are found or it costs too much.

    Points that are known to be impossible are left out of it.
    """
    random, calls = _takes_random(job.measure), 0
    waiting = [np.arange(len(next(iter(values.values()))))]
    while waiting:
        places = waiting.pop()
        calls += 1
        try:
            part = {path: array[places] for path, array in values.items()}
            check_lanes(job.system, part)
            result = job.measure(job.system, part, **_random(job, first + int(places[0]), random))
        except LaneError as error:
            yield places[error.lanes], error
            waiting += [places[~error.lanes]] if not error.lanes.all() else []
        except (Exception, SystemExit) as error:
            if len(places) == 1 or calls >= MOST_CALLS:
                yield places, error
            else:
                middle = len(places) // 2
                waiting += [places[middle:], places[:middle]]
        else:
            yield places, result


def _takes_random(measure: Any) -> bool:
    try:
        return "rng" in inspect.signature(measure).parameters
    except (TypeError, ValueError):  # a function written in C
        return False


def _random(job: Job, point: int, wanted: bool) -> dict[str, Any]:
    if not wanted:
        return {}
    return {"rng": np.random.default_rng(np.random.SeedSequence(job.seed, spawn_key=(point,)))}


def _as_arrays(returned: Any, count: int, chunked: bool) -> dict[str, tuple[Array, tuple[str, ...], dict[str, Any]]]:
    """Arrays (count, ...), further dimensions and attributes, by name, of whatever a measure returned."""
    if not chunked:
        if isinstance(returned, Mapping):
            return {str(name): (np.array([_real(name, value)]), (), {}) for name, value in returned.items()}
        return {"value": (np.array([_real("the value", returned)]), (), {})}
    result = {}
    for name, value in (returned.data_vars if hasattr(returned, "data_vars") else dict(returned)).items():
        labelled = hasattr(value, "dims")
        if labelled and "lane" in value.dims:
            value = value.transpose("lane", ...)
        elif labelled and "lane" in returned.dims:
            continue  # a number of the whole chunk, not of its points
        array = np.asarray(value)
        if array.ndim == 0 or len(array) != count or array.dtype.kind not in "fciub":
            raise _AnotherShape(f"{name} is an array {array.shape} of {array.dtype}; it must be ({count}, ...) numbers")
        dims = tuple(value.dims[1:]) if labelled else tuple(f"{name}_{k}" for k in range(1, array.ndim))
        result[str(name)] = (array, dims, _attributes(value, dims) if labelled else {})
    return result


def _attributes(value: Any, dims: tuple[str, ...]) -> dict[str, Any]:
    labels = {dim: value.coords[dim].values.tolist() for dim in dims if dim in value.coords}
    return {**value.attrs, "labels": labels} if labels else dict(value.attrs)


def _real(name: Any, value: Any) -> float:
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value.item()
    if not isinstance(value, Real | np.bool_):
        kind = "a complex number" if isinstance(value, Complex) else f"{type(value).__name__}"
        raise _AnotherShape(f"the measure returned {kind} for {name}; return a number or a dict of numbers")
    return float(value)


def _variable(name: str, array: Array, dims: tuple[str, ...], attributes: dict[str, Any]) -> Variable:
    dtype = {"f": "float64", "c": "complex128", "i": array.dtype.name}.get(array.dtype.kind, "int64")
    plain = {key: _plain(value) for key, value in attributes.items() if key != ESTIMATE}
    return Variable(name, dtype, dims, array.shape[1:], plain)


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [_plain(item) for item in value]
    if isinstance(value, np.generic):
        return value.item()
    return value if isinstance(value, int | float | str) else str(value)


def _check_names(variables: tuple[Variable, ...], returned: Mapping[str, Any]) -> None:
    if taken := sorted(set(SWEEP_NAMES) & set(returned)):
        raise _AnotherShape(f"the measure returned a variable {taken[0]!r}, a name that the sweep uses; choose another")
    if strange := [name for name in returned if not name or name[0] == "." or not set(name).isdisjoint("/\\\0")]:
        raise _AnotherShape(f"the measure returned a variable {strange[0]!r}, which names no file; choose another name")
    names = [variable.name for variable in variables]
    if not names or set(names) != set(returned):
        raise _AnotherShape(
            f"the measure returned {', '.join(returned) or 'nothing'}; it must return {', '.join(names) or 'a number'} "
            "at every point"
        )


def _fitting(variable: Variable, array: Array) -> Array:
    if array.shape[1:] != variable.shape or (variable.dtype != "complex128" and array.dtype.kind == "c"):
        raise _AnotherShape(f"{variable.name} is {array.shape[1:]} of {array.dtype} here, elsewhere {variable.shape}")
    return array


def _sentence(point: int, parameters: str, error: BaseException) -> str:
    text = ""
    with contextlib.suppress(Exception):  # of the user's own class, whose text may fail, too
        text = error.reason if isinstance(error, LaneError) else " ".join(str(error).split())
    kind = "" if isinstance(error, _AnotherShape | LaneError) else f"{type(error).__name__}: "
    return f"point {point} ({parameters}): {kind}{text or 'no reason given'}"[:LONGEST_MESSAGE]


MOST_CHUNKS = 4096  # that a sweep point by point is cut into: each costs a few files and milliseconds
SMALLEST, LARGEST = 32, 1 << 17
SHARES = 64  # chunks that whole-chunk measures get at least, if these are not too small
STORE_CHUNKS = 10_000_000  # chunks: a few files each
LOOSE_POINTS = 100_000_000  # points of a sweep without a store: hours
CHUNK_POINTS = 1 << 28  # points of a chunk: 2 GiB of every parameter
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

    def indices(self, chunk: int) -> tuple[int, ...]:
        """Index of a chunk along every dimension."""
        return tuple(int(i) for i in np.unravel_index(chunk, self.counts))

    def stretch(self, chunk: int) -> Stretch:
        """Points of a chunk."""
        starts = [i * b for i, b in zip(self.indices(chunk), self.block, strict=True)]
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


def check_size(layout: Layout, stored: bool) -> None:
    """Refuse a sweep of more chunks than can be kept, or of chunks too large to be held (ValueError)."""
    points, block = layout.points, math.prod(layout.block)
    if block > CHUNK_POINTS:
        raise ValueError(f"chunk is {block:.4g} points; at most {CHUNK_POINTS} fit into memory at a time")
    if layout.chunks > STORE_CHUNKS:
        raise ValueError(
            f"the sweep has {points:.4g} points, that is {layout.chunks:.4g} chunks of up to {block} points, and at "
            f"most {STORE_CHUNKS} can be kept; take fewer values, a Sobol or LatinHypercube sample, or a larger chunk"
        )
    if not stored and points > LOOSE_POINTS:
        raise ValueError(f"{points:,} points are more than {LOOSE_POINTS:,}; give the sweep a store, it keeps its work")


def described(values: Mapping[str, Any], i: int) -> str:
    """Parameters of point i of a stretch as text."""
    return ", ".join(f"{path} = {array[i]:.9g}" for path, array in values.items())
