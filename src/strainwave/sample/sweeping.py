"""`sweep`: any function of a system over a grid or a sample, kept chunk by chunk and resumed where it stopped."""

import contextlib
import logging
import math
import os
import re
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any
from uuid import uuid4

import xarray as xr

from ..base.above import above
from ..base.archive import version
from ..base.quantities import checked, positive_count, shown, whole
from ..base.results import Floats, Interrupted
from ..base.terminal import Progress, silent
from ..compile.lanes import LANES
from ..drive.project import Project
from .chunks import Layout, check_size, chunk_size, layout_of
from .ensemble_measure import EnsembleMeasure
from .identity import digest, installed, readable
from .measuring import SWEEP_NAMES, ChunkResult, Job, Variable, lost_chunk
from .sampling import Grid, GridPoints, Points, check_names, points_of
from .store import SweepStore
from .workers import Workers

log = logging.getLogger(__name__)

MOST_WORKERS = 1024
FILES = {".csv", ".txt", ".json", ".yaml", ".nc", ".npz", ".mat", ".xlsx", ".svg", ".png", ".html"}  # never a folder's
ALONE = "the worker process ended each time it computed them; use less memory, or check the worker's log"


def sweep(
    measure: Callable[..., Any],
    system: Any,
    grid: Grid,
    *,
    store: str | os.PathLike[str] | None = None,
    client: Any = None,
    workers: int | None = None,
    processes: bool = False,
    chunk: int | None = None,
    seed: int = 0,
    units: Mapping[str, str] | None = None,
    retune: bool = False,
    progress: Progress = silent,
) -> xr.Dataset:
    """Measure a system, or a project, at every point of a grid or a sample.

    Results do not depend on where or in which order the points are computed, nor on interruptions: those of a system
    bit for bit, those of a project to rounding.

    Parameters
    ----------
    measure : callable
        `measure(system)`, a number or a dict of numbers at one point. With a parameter `rng` it is given a NumPy
        generator that depends on `seed` and the point alone. With an attribute `whole_chunks = True`, as
        `EnsembleMeasure` has, it is `measure(system, values)`: arrays (n, ...) by name, or a dataset over "lane",
        from arrays (n,) by path, and `rng` is that of the chunk's first point.
    system : NamedTuple or Project
        What the points are variants of. The measure of a project may be `sample.largest`.
    grid : dict of str to (n,) array_like, LatinHypercube or Sobol
        Paths of parameters and their values (SI units): all combinations; or a sample of distributions. A tuple of
        paths in place of one has factors for values, which scale these parameters together: the dimension's name is
        then that of the paths with " & " between them. Of a project: texts by names in its file, with their units, as
        `replaced` takes them: {"loop.bandwidth": ["20 Hz", "30 Hz"], "gear": ["CSG-40-50", "SHG-40-50"]}.
    store : path, optional
        Folder (zarr v3) that keeps the results; running the same sweep again goes on where the last run stopped.
        Default: in memory.
    client : distributed.Client, optional
        Compute on the workers of this cluster (extra `cluster`).
    workers : int, optional
        Threads, or with `processes` processes, on this machine. Default: the processors this process may use.
    processes : bool
        Compute in processes: for measures that are not compiled code.
    chunk : int, optional
        Most points that are computed and written at a time: results of fewer are lost when a run is stopped. Default:
        a 4096th of the points, at least 32; for whole-chunk measures a 64th, rounded up to fill blocks of 256 lanes,
        at least what `EnsembleMeasure.least_chunk` says; never more than 131072. Of a project: a 512th, at least 1.
    seed : int
        Seed of the random numbers of a measure that takes `rng`.
    units : dict of str to str, optional
        Units of the variables of `measure`, for the result.
    retune : bool
        Of a project: whether gains given as a bandwidth and damping given as a ratio are computed anew at every point.
        Default: the drive is built once and keeps them; `tuning` of the attributes says which.
    progress : callable
        Told what is being computed and which share of what was missing is finished, after every chunk.

    Returns
    -------
    xarray.Dataset
        Over the grid's dimensions (named by the paths) or over "point"; values are read from the store when they are
        used. Variables of the measure ("value" where it returns a number), NaN where it failed, and `point_status` (0
        ok, 1 the system is impossible or the measure raised, 2 it returned something else than elsewhere, 3 its worker
        died). Attributes: `failed_points`, `errors` (the first messages, one a line), `spec` (hash), `strainwave`
        (version), `installed` (versions of Python and of packages that the measure depends on), `measure`.

    Raises
    ------
    TypeError, ValueError
        If an argument is wrong, a name or a value is not one of the file's, or the store is that of another sweep.
    RuntimeError
        If the store is in use or cannot be written, or the cluster is gone; what was finished is kept.
    KeyboardInterrupt
        On Ctrl-C, with a sentence; what was finished is kept, chunks under way are given up within about a second.
        Without a store it is `Interrupted`, with what was finished.
    """
    if isinstance(system, Project):
        more = {"client": client, "workers": workers, "processes": processes, "seed": seed, "progress": progress}
        more |= {"store": store, "chunk": chunk, "units": units, "retune": retune}
        data: xr.Dataset = above("sweep_project")(system, grid, measure, **more)
        return data
    system, points = checked(system), points_of(grid)
    chunk = None if chunk is None else positive_count("chunk", chunk, 2**62)
    workers = positive_count("workers", _processors() if workers is None else workers, MOST_WORKERS)
    folder = None if store is None else _folder(store)
    seed = whole("seed", seed)
    parameter_units = _parameter_units(system, points)
    if isinstance(measure, EnsembleMeasure):
        measure.check(system)
    job = Job(measure, system, seed)
    layout = layout_of(points.shape, chunk or chunk_size(points.shape, _least_chunk(job)))
    check_size(layout, folder is not None)
    spec, used = _recognised(job, grid, points, layout, store is not None)
    attributes = {
        "spec": spec, "strainwave": version(), "measure": readable(measure), "system": str(system)[:1000],
        "parameters": list(points.paths), "seed": seed, "installed": used,
    }  # fmt: skip
    axes = points.axes if isinstance(points, GridPoints) else {}
    stored = SweepStore(folder, layout, points.dims, axes, attributes, parameter_units, job.whole_chunks)
    try:
        if not stored.done.all():
            run = _Run(job, layout, points, stored, dict(units or {}), progress)
            _fill(run, partial(Workers, job, client, workers, processes))
        stored.finish()
        return stored.dataset()
    finally:
        stored.close()


class _Run:
    """A sweep under way: what is to be done, and word of its progress."""

    def __init__(
        self, job: Job, layout: Layout, points: Points, store: SweepStore, units: dict[str, str],
        progress: Progress,
    ) -> None:  # fmt: skip
        self.job, self.layout, self.points, self.kept, self.units = job, layout, points, store, units
        self.computed, self.left = 0, int((~store.done).sum())
        self.progress = partial(progress, f"{self.left} of {layout.chunks} chunks")
        self.progress(0.0)
        if store.variables is not None:
            self._check_units(store.variables)
            self.job = Job(job.measure, job.system, job.seed, store.variables)

    def values(self, chunk: int) -> tuple[int, dict[str, Floats]]:
        """First point and values of a chunk."""
        stretch = self.layout.stretch(chunk)
        return stretch.first, self.points.values(stretch.first, stretch.points)

    def keep(self, chunk: int, part: ChunkResult, values: Mapping[str, Floats]) -> None:
        """Write what was found in a chunk, and learn from the first one what the measure returns."""
        if self.job.variables is None and part.variables:
            self._check_units(part.variables)
            variables = tuple(v._replace(attributes=self._unit(v.name) | v.attributes) for v in part.variables)
            self.kept.declare(variables)
            self.job = Job(self.job.measure, self.job.system, self.job.seed, variables)
        self.kept.write(chunk, part, values)
        self.computed += 1
        self.progress(self.computed / self.left)

    def _check_units(self, variables: tuple[Variable, ...]) -> None:
        names = [variable.name for variable in variables]
        if unknown := [name for name in self.units if name not in names]:
            fault = f"units has {shown(unknown[0])}, which the measure does not return; it returns {', '.join(names)}"
            raise ValueError(fault)

    def _unit(self, name: str) -> dict[str, Any]:
        """Attribute with the unit of a variable, where the caller gives one."""
        return {"units": self.units[name]} if name in self.units else {}

    def stopped(self, reason: str) -> str:
        """Return the sentence for a run that ends early."""
        if self.kept.path is None:
            return f"{reason}; nothing is stored: with a store the sweep could be resumed"
        done = int(self.kept.done.sum())
        kept = f"{done} of {self.layout.chunks} chunks are kept in {self.kept.path}"
        return f"{reason}; {kept}: run the same sweep again to continue"


def _fill(run: _Run, start: Callable[[], Any]) -> None:
    """Compute what is missing on the workers that `start` gives, and end with one sentence where that fails."""
    pool = None
    try:
        pool = start()
        _compute_all(run, pool)
    except KeyboardInterrupt:
        if run.kept.path is None and run.kept.variables is not None:
            run.kept.finish()
            raise Interrupted(run.stopped("interrupted"), run.kept.dataset()) from None
        raise KeyboardInterrupt(run.stopped("interrupted")) from None
    except MemoryError as error:
        fault = f"a chunk has up to {math.prod(run.layout.block)} points, too many for the memory; give a smaller chunk"
        raise RuntimeError(run.stopped(fault)) from error
    except ConnectionError as error:
        raise RuntimeError(run.stopped(" ".join(str(error).split()))) from error
    finally:
        if pool is not None:
            pool.close()


def _compute_all(run: _Run, pool: Any) -> None:
    """Compute what is not done yet, a bounded number of chunks at a time."""
    todo = iter((~run.kept.done).nonzero()[0].tolist())
    suspects: list[int] = []
    # Until the measure has answered once, chunk after chunk: what the first answer is must not depend on a race.
    while run.job.variables is None and (chunk := next(todo, None)) is not None:
        suspects += _finish(run, pool, [chunk], 1)
    suspects += _finish(run, pool, todo, None)
    for chunk in suspects:  # a chunk that kills its worker takes others with it: alone, it shows which one it was
        if _finish(run, pool, [chunk], 1):
            first, values = run.values(chunk)
            part = lost_chunk(run.job, first, values, ALONE)
            log.warning("%s", part.message)
            run.keep(chunk, part, values)


def _finish(run: _Run, pool: Any, chunks: Any, limit: int | None) -> list[int]:
    """Compute chunks and keep their results, also those that Ctrl-C finds complete; return those whose worker died."""
    waiting: dict[Any, tuple[int, dict[str, Floats]]] = {}
    try:
        return _kept_as_finished(run, pool, chunks, limit, waiting)
    except KeyboardInterrupt:
        for future, (chunk, values) in waiting.items():
            if future.done():
                with contextlib.suppress(Exception):
                    run.keep(chunk, future.result(), values)
        raise


def _kept_as_finished(
    run: _Run, pool: Any, chunks: Any, limit: int | None, waiting: dict[Any, tuple[int, dict[str, Floats]]]
) -> list[int]:
    """Submit chunks, at most `limit` at a time, and keep each as it finishes; `waiting` has those under way."""
    finished: SimpleQueue[Any] = SimpleQueue()
    suspects: list[int] = []
    chunks = iter(chunks)
    room = limit or pool.room
    while True:
        while len(waiting) < room and (chunk := next(chunks, None)) is not None:
            first, values = run.values(chunk)
            future = pool.submit(run.job, first, values)
            waiting[future] = chunk, values
            future.add_done_callback(finished.put)
        if not waiting:
            return suspects
        try:
            future = finished.get(timeout=1.0)
        except Empty:
            pool.check()
            room = limit or pool.room
            continue
        chunk, values = waiting[future]
        try:
            part = future.result()
        except Exception as error:
            if not pool.lost(error):
                pool.check()
                raise
            suspects.append(chunk)
            del waiting[future]
            continue
        run.keep(chunk, part, values)
        del waiting[future]


def _parameter_units(system: Any, points: Points) -> dict[str, str]:
    """Refuse what cannot be swept; return the units of the parameters."""
    parameter_units = check_names(system, points.paths)
    if taken := sorted(set(SWEEP_NAMES) & set(points.paths)):
        raise ValueError(f"a parameter named {taken[0]!r} cannot be swept: the store uses that name")
    return parameter_units


def _recognised(job: Job, grid: Grid, points: Points, layout: Layout, stored: bool) -> tuple[str, list[str]]:
    """Hash of everything that the results depend on, and the versions of what is installed among it."""
    what = job.measure, job.system, points.axes if isinstance(points, GridPoints) else grid, layout.block, job.seed
    try:
        return digest(*what), installed(*what)
    except TypeError:
        if stored:
            raise
        return uuid4().hex, []  # nothing is resumed from memory


def _folder(store: str | os.PathLike[str]) -> Path:
    """Return the path of a store, or say that it is none."""
    path = Path(store)
    letters = not re.search("[\0\ud800-\udc7f\udd00-\udfff]", str(path))  # others are bytes of a name, escaped
    if not path.name or not letters:
        raise ValueError(f"store is {shown(str(store))}; it must name a folder, such as 'map.zarr'")
    if path.suffix.lower() in FILES and not path.is_dir():
        raise ValueError(
            f"store is {shown(str(store))}; a sweep is kept in a folder, with which it goes on: name one, such as "
            f"{path.stem + '.zarr'!r}, whose table is xarray.open_zarr({path.stem + '.zarr'!r}).to_dataframe()"
        )
    return path


def _least_chunk(job: Job) -> int | None:
    """Fewest points that are worth a chunk, None for a measure of single points."""
    if isinstance(job.measure, EnsembleMeasure):
        return job.measure.least_chunk(job.system)
    return LANES if job.whole_chunks else None


def _processors() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
