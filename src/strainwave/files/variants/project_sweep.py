"""A sweep of a whole drive over a grid of the numbers of its project file: its response, or any measure of it."""

import dataclasses
import os
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from math import prod
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ...base.quantities import shown
from ...base.results import Floats
from ...drive.drive_response import DriveResponse
from ...drive.project import Project
from ...drive.steady import is_beating
from ...drive.train_curve import refuse_free
from ...sample.sampling import Table
from ...sample.store import name_axis
from ...sample.sweeping import sweep
from .names import quantity
from .replaced import replaced, tuning

UNITS = {"peak": "rad", "peak_at": "rad/s", "oscillation": "rad", "oscillation_at": "rad/s", "torque": "N*m",
         "torque_at": "rad/s", "jumps": "1", "truncated": "1"}  # fmt: skip
OF_BEAT = {"smallest": "rad", "smallest_at": "rad/s"}
MOST_POINTS, MOST_CHUNKS = 100_000, 512
NUMBERED = r"\bnumbers\.(\d+) = ([\d.e+]+)"  # a point, as a sweep of a `Choice` says it


class Choice(NamedTuple):
    """A point of the grid: the number of the value along each axis; or of a sample, the factors of its numbers."""

    numbers: tuple[float, ...]


@dataclass(frozen=True)
class Variants:
    """A measure of the project with the texts that a `Choice` stands for."""

    measure: Callable[[Project], Any]
    project: Project
    texts: Callable[[tuple[float, ...]], dict[str, str]]
    retune: bool = False

    def __call__(self, choice: Choice) -> Any:
        """Measure of the project at a point."""
        return self.measure(replaced(self.project, self.texts(choice.numbers), retune=self.retune))


def sampled(
    measure: Callable[[Project], Any], project: Project, texts: Callable[[tuple[float, ...]], dict[str, str]],
    numbers: Sequence[Floats], *, together: bool = False, retune: bool = False, **options: Any,
) -> xr.Dataset:  # fmt: skip
    """Measure variants of a project at all combinations of `numbers`, or of these `together`: a `sweep` of choices."""
    axes = {f"numbers.{i}": np.asarray(values, float) for i, values in enumerate(numbers)}
    # A copy knows nothing that was computed of the project before, which would make it another sweep.
    variants = Variants(measure, dataclasses.replace(project), texts, retune)
    return sweep(variants, Choice((0.0,) * len(axes)), Table(axes) if together else axes, **options)


def _of_axes(axes: tuple[tuple[str, tuple[str, ...]], ...], numbers: tuple[float, ...]) -> dict[str, str]:
    return {name: texts[round(n)] for (name, texts), n in zip(axes, numbers, strict=True)}


def largest(project: Project) -> dict[str, float]:
    """Largest error, oscillation and torque of a drive over its speeds: a measure of a project for `sweep`.

    Returns
    -------
    dict of str to float
        `peak` (largest |pointing error| [rad]), `oscillation` (its largest distance from the mean [rad]), `torque`
        (largest in the gear [N*m]), `peak_at`, `oscillation_at`, `torque_at` (speed of the base angle [rad/s]) over the
        stable motions of the curve; `jumps` (their number in both), `truncated` (1 where harmonics
        are missing). Where the motions of the project beat a sweep has `smallest` too.
    """
    return _largest(project.response())


def with_smallest(project: Project) -> dict[str, float]:
    """As `largest`, with the oscillation of the `smallest` turn [rad] where that of the largest is largest."""
    response = project.response()
    sizes, envelope = _largest(response), response.curve.envelope
    smallest = sizes["oscillation"] if envelope is None else float(envelope[response.top, 1])
    return sizes | {"smallest": smallest, "smallest_at": sizes["oscillation_at"]}


def _largest(response: DriveResponse) -> dict[str, float]:
    sweeps = response.sweep
    result: dict[str, float] = {}
    for name, values in (("peak", response.peak), ("oscillation", response.oscillation), ("torque", response.torque)):
        top = response.top_of(values)
        result |= {name: float(values[top]), f"{name}_at": float(response.omega[top])}
    jumps = 0 if sweeps is None else len(sweeps.on_run_up) + len(sweeps.on_run_down)
    return result | {"jumps": float(jumps), "truncated": float(not response.status)}


def sweep_project(
    project: Project,
    grid: Mapping[str, Sequence[str]],
    measure: Callable[[Project], Any] = largest,
    *,
    store: str | os.PathLike[str] | None = None,
    chunk: int | None = None,
    units: Mapping[str, str] | None = None,
    retune: bool = False,
    **options: Any,
) -> xr.Dataset:
    """Measure a drive at every point of a grid of the numbers of its project file: `sweep` of a project."""
    axes = {name: list(map(str, texts)) for name, texts in grid.items()}
    check(project, axes)
    texts = partial(_of_axes, tuple((name, tuple(values)) for name, values in axes.items()))
    indices = [np.arange(len(values), dtype=float) for values in axes.values()]
    chunk = chunk or max(1, prod(map(len, axes.values())) // MOST_CHUNKS)
    if measure is largest:
        measure, units = (with_smallest, UNITS | OF_BEAT) if is_beating(project.subject.error) else (largest, UNITS)
    data = sampled(measure, project, texts, indices, retune=retune, store=store, chunk=chunk, units=units, **options)
    named = {f"numbers.{i}": name for i, name in enumerate(axes)}
    if store is not None:
        for axis, name in named.items():
            _, values, unit = coordinate(name, axes[name])
            name_axis(Path(store), axis, name, axes[name], values if unit else None, unit.get("units", ""))
    data = data.drop_vars([name for name in named if name in data.coords]).rename_dims(named)
    data.attrs["tuning"] = tuning(project, axes, retune)
    data.attrs["errors"] = re.sub(NUMBERED, partial(_as_written, list(axes.items())), data.attrs["errors"])
    return data.assign_coords({name: coordinate(name, texts) for name, texts in axes.items()})


def _as_written(axes: list[tuple[str, list[str]]], point: re.Match[str]) -> str:
    """A point of an axis, written as its name and its value were given."""
    name, texts = axes[int(point[1])]
    return f"{name} = {texts[round(float(point[2]))]}"


def check(project: Project, axes: Mapping[str, list[str]]) -> None:
    """Refuse a grid with a name or a value that the file may not have, in one sentence (ValueError)."""
    if project.train is not None:
        refuse_free(project.train)
    if not axes or not all(axes.values()):
        raise ValueError(f"the grid is {shown(dict(axes))}; give names of the file with their values")
    if prod(map(len, axes.values())) > MOST_POINTS:
        raise ValueError(f"the grid has more than {MOST_POINTS} points, each a response curve; take fewer values")
    for name, texts in axes.items():
        for text in texts if len(texts) <= 16 else (texts[0], texts[-1]):
            try:
                replaced(project, {name: text})
            except ValueError as error:
                raise ValueError(f"{name} = {text}: {error}") from None


def coordinate(name: str, texts: list[str]) -> tuple[str, Any, dict[str, str]]:
    """Values along a dimension: numbers in the unit that they share, or words."""
    parts = [quantity(text) for text in texts]
    units = {unit for _, unit in parts}
    if len(units) > 1 or any(value is None for value, _ in parts):
        return name, texts, {}
    return name, np.array([value for value, _ in parts], float), {"units": units.pop()}
