"""A measure at the points of a chunk: its numbers as arrays, and the points at which it fails.

`compute` needs nothing but its arguments and runs anywhere: in this process, in another, on another machine.
"""

import contextlib
import inspect
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
from ..numerics.ensemble.request import LaneError, check_lanes
from .sampling import by_path

Array: TypeAlias = NDArray[Any]

MOST_CALLS = 64  # calls of a measure that fails on a whole chunk, to find the points where it does
LONGEST_MESSAGE = 400  # characters
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


class ChunkResult(NamedTuple):
    """Results at the points (n,) of a chunk.

    `arrays` (n, ...) are by the names of the variables, `status` (n,) has a `PointStatus` for each point, `message`
    tells of the first point that failed, and `estimates` are the largest errors of variables that come with one.
    """

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


def compute(job: Job, first: int, values: Mapping[str, Floats]) -> ChunkResult:
    """Measure the points of a chunk.

    Parameters
    ----------
    job : Job
        What to do.
    first : int
        Number of the first point in the sweep.
    values : dict of str to (n,) array
        Values of the parameters at the points.

    Returns
    -------
    ChunkResult
        A point that fails has the fill values of the variables, and its `status` says in which way it failed.
    """
    load()  # no last bit depends on what this process did before
    count = len(next(iter(values.values())))
    by_parameter = by_path(job.system, values)
    pieces = (_by_halves if job.whole_chunks else _one_by_one)(job, first, by_parameter)
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
            other_shape = isinstance(error, _AnotherShape)
            status[places] = PointStatus.ANOTHER_SHAPE if other_shape else PointStatus.RAISED
            message = message or _sentence(first + places[0], described(values, places[0]), error)
    return ChunkResult(variables, arrays, status, message, estimates)


def lost_chunk(job: Job, first: int, values: Mapping[str, Floats], why: str) -> ChunkResult:
    """Return the part of a chunk whose worker died each time it was computed."""
    count = len(next(iter(values.values())))
    arrays = {variable.name: variable.empty(count) for variable in job.variables or ()}
    message = f"points {first} to {first + count - 1} (from {described(values, 0)}): {why}"[:LONGEST_MESSAGE]
    return ChunkResult(job.variables or (), arrays, np.full(count, PointStatus.LOST, np.uint8), message, {})


Pieces = Iterator[tuple[Any, Any]]  # indices in the stretch, and the result of the measure there, or its exception


def _one_by_one(job: Job, first: int, values: Mapping[str, Floats]) -> Pieces:
    """Measure each point of a stretch."""
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
    """True for a measure with a parameter `rng`."""
    try:
        return "rng" in inspect.signature(measure).parameters
    except (TypeError, ValueError):  # a function written in C
        return False


def _random(job: Job, point: int, wanted: bool) -> dict[str, Any]:
    """The argument `rng` of a measure at a point, if it is wanted."""
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
    """A real number that a measure returned (ValueError)."""
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
    """An attribute as JSON has it."""
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [_plain(item) for item in value]
    if isinstance(value, np.generic):
        return value.item()
    return value if isinstance(value, int | float | str) else str(value)


def _check_names(variables: tuple[Variable, ...], returned: Mapping[str, Any]) -> None:
    """Refuse names that a sweep cannot store, and others than at the points before (ValueError)."""
    if taken := sorted(set(SWEEP_NAMES) & set(returned)):
        raise _AnotherShape(f"the measure returned a variable {taken[0]!r}, a name that the sweep uses; choose another")
    if strange := [name for name in returned if not name or name[0] == "." or not set(name).isdisjoint("/\\\0")]:
        raise _AnotherShape(f"the measure returned a variable {strange[0]!r}, not a file name; choose another")
    names = [variable.name for variable in variables]
    if not names or set(names) != set(returned):
        raise _AnotherShape(
            f"the measure returned {', '.join(returned) or 'nothing'}; it must return {', '.join(names) or 'a number'} "
            "at every point"
        )


def _fitting(variable: Variable, array: Array) -> Array:
    """The array, if it has the shape and the kind of its variable (ValueError)."""
    if array.shape[1:] != variable.shape or (variable.dtype != "complex128" and array.dtype.kind == "c"):
        raise _AnotherShape(f"{variable.name} is {array.shape[1:]} of {array.dtype} here, elsewhere {variable.shape}")
    return array


def _sentence(point: int, parameters: str, error: BaseException) -> str:
    """Message on a point that failed."""
    text = ""
    with contextlib.suppress(Exception):  # of the user's own class, whose text may fail, too
        text = error.reason if isinstance(error, LaneError) else " ".join(str(error).split())
    kind = "" if isinstance(error, _AnotherShape | LaneError) else f"{type(error).__name__}: "
    return f"point {point} ({parameters}): {kind}{text or 'no reason given'}"[:LONGEST_MESSAGE]


def described(values: Mapping[str, Any], i: int) -> str:
    """Parameters of point i of a stretch as text."""
    return ", ".join(f"{path} = {array[i]:.9g}" for path, array in values.items())
