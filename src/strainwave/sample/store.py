"""The store of a sweep: a zarr v3 group with one file per variable and chunk, written by one process.

A chunk's data come first, its entry in the array `done` last, each as a file that appears when it is complete; a
checksum follows the data. Whatever moment a process dies at, the next one finds chunks that are whole or not done.
"""

import contextlib
import errno
import logging
import math
import os
import shutil
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
import zarr
from zarr.codecs import Crc32cCodec
from zarr.storage import LocalStore, MemoryStore

from ..base.results import Floats
from ..compile.tree import shown
from .chunks import Layout
from .identity import check_spec, check_versions
from .measuring import ESTIMATE, LONGEST_MESSAGE, Array, ChunkResult, PointStatus, Variable
from .store_lock import StoreLock

log = logging.getLogger(__name__)

FORMAT = 1
STATUS, DONE, MESSAGE = "point_status", "done", "message"
SHOWN = 5  # messages that the attributes repeat
LETTERS = 2 * LONGEST_MESSAGE  # bytes of a message
STATUS_ATTRIBUTES = {
    "long_name": "what became of the point",
    "flag_values": [int(status) for status in PointStatus],
    "flag_meanings": " ".join(status.name.lower() for status in PointStatus),
}


class SweepStore:
    """Results of a sweep, in a folder or in memory.

    Parameters
    ----------
    path : Path or None
        Folder of the store; None keeps the results in memory.
    layout : Layout
        Shape and chunks of the arrays over the points.
    dims : tuple of str
        Names of the dimensions of the points.
    axes : dict of str to (n,) array
        Values along the dimensions, for a grid.
    attributes : dict
        What the group says of itself: `spec` is the hash that a store must have to be resumed.
    units : dict of str to str
        Units of the parameters by path.
    estimated : bool
        Whether chunks may come with an estimate of their error.

    Raises
    ------
    ValueError
        If `path` is something else than a store, or the store of another sweep.
    RuntimeError
        If another process works on the store, or it cannot be read or written.
    """

    def __init__(
        self,
        path: Path | None,
        layout: Layout,
        dims: tuple[str, ...],
        axes: Mapping[str, Floats],
        attributes: dict[str, Any],
        units: Mapping[str, str],
        estimated: bool = False,
    ) -> None:
        self.path, self.layout, self.dims, self.units = path, layout, dims, units
        self.estimated = estimated
        self.variables: tuple[Variable, ...] | None = None
        self.resumed = False
        self.lock: StoreLock | None = None
        self.memory = MemoryStore()
        self.arrays: dict[str, Any] = {}
        self.failed: dict[int, int] = {}
        with self.one_error("opened"):
            if path is not None:
                self._open_locked(path, axes, attributes)
                return
            self._create(self.memory, axes, attributes)
            self.group = zarr.open_group(self.memory, mode="r+", zarr_format=3)
            self.done = np.zeros(layout.chunks, bool)

    def _open_locked(self, path: Path, axes: Mapping[str, Floats], attributes: dict[str, Any]) -> None:
        """Open a folder with the right to write it; without that right one whose sweep is complete."""
        try:
            self.lock = StoreLock(path)
        except OSError as error:
            if error.errno not in (errno.EROFS, errno.EACCES) or not path.is_dir():
                raise
            self._open(path, axes, attributes)
            if not self.done.all():
                raise
            return
        try:
            self._open(path, axes, attributes)
        except BaseException:
            self.lock.release()
            raise

    def _open(self, path: Path, axes: Mapping[str, Floats], attributes: dict[str, Any]) -> None:
        part = path.with_name(path.name + ".partial")
        writable = self.lock is not None
        if writable:
            shutil.rmtree(part, ignore_errors=True)
        self.resumed = path.exists() and not (path.is_dir() and not any(path.iterdir()))
        if not self.resumed:
            self._create(LocalStore(part), axes, attributes)
            if path.exists():
                path.rmdir()
            os.replace(part, path)
        else:
            check_spec(path, attributes)
            for left_over in path.rglob("*.partial") if writable else ():
                left_over.unlink(missing_ok=True)
        self.group = zarr.open_group(LocalStore(path), mode="r+" if writable else "r", zarr_format=3)
        described = self.group.attrs.get("variables")
        if isinstance(described, list):
            self.variables = tuple(_variable(item) for item in described)
        if not self.resumed:
            self.done = np.zeros(self.layout.chunks, bool)
            return
        self._check_arrays()
        self._restore(axes)
        self.done = self._finished()
        if not self.done.all():
            check_versions(path, self.group.attrs.asdict(), attributes)

    def _create(self, store: Any, axes: Mapping[str, Floats], attributes: dict[str, Any]) -> None:
        """Make the group with the parameters, the status of the points, and messages and completeness of the chunks."""
        self.group = zarr.open_group(store, mode="w", zarr_format=3, attributes=attributes | {"format": FORMAT})
        for path, values in axes.items():
            form = {"shape": values.shape, "chunks": values.shape, "dtype": "float64", "fill_value": np.nan}
            self._array(path, (path,), {"units": self.units[path]}, **form)
            self._array_of(path)[:] = values
        for path in () if axes else self.units:  # of a sample: every point has its own
            self._over_points(path, (), (), "float64", np.nan, {"units": self.units[path]})
        self._over_points(STATUS, (), (), "uint8", int(PointStatus.NOT_COMPUTED), STATUS_ATTRIBUTES)
        n = self.layout.chunks
        byte, complete = {"dtype": "uint8", "fill_value": 0}, {"long_name": "1 where a chunk is complete"}
        self._array(MESSAGE, ("chunk", "letter"), {}, shape=(n, LETTERS), chunks=(1, LETTERS), **byte)
        self._array(DONE, ("chunk",), complete, shape=(n,), chunks=(1,), **byte)

    def _over_points(
        self, name: str, dims: tuple[str, ...], shape: tuple[int, ...], dtype: str, fill: Any, attributes: Any
    ) -> None:
        """Make an array over the points, with further dimensions."""
        full, block = (*self.layout.shape, *shape), (*self.layout.block, *shape)
        form = {"shape": full, "chunks": block, "dtype": dtype, "fill_value": fill}
        self._array(name, (*self.dims, *dims), attributes, **form)

    def _array(self, name: str, dims: tuple[str, ...], attributes: dict[str, Any], **form: Any) -> None:
        """Make an array of a form: shape, chunks, dtype, fill_value."""
        form |= {"dimension_names": dims, "attributes": attributes}
        self.group.create_array(name, compressors=[Crc32cCodec()], overwrite=True, **form)

    def declare(self, variables: tuple[Variable, ...]) -> None:
        """Make the arrays of the variables, once it is known what the measure returns."""
        self._check_room(variables)
        with self.one_error("written"):
            for v in variables:
                self._over_points(v.name, v.dims, v.shape, v.dtype, v.fill, v.attributes)
            if self.estimated:
                form = {"shape": (self.layout.chunks, len(variables)), "chunks": (1, len(variables))}
                self._array(ESTIMATE, ("chunk", "variable"), {}, dtype="float64", fill_value=np.nan, **form)
            described: Any = [[v.name, v.dtype, list(v.dims), list(v.shape), v.attributes] for v in variables]
            self.group.attrs["variables"] = described
        self.variables = variables

    def _check_room(self, variables: tuple[Variable, ...]) -> None:
        """Refuse results that are larger than the disk's free space, or this machine's memory (ValueError)."""
        each = 1 + sum(np.dtype(v.dtype).itemsize * math.prod(v.shape) for v in variables)
        needed, room = self.layout.points * each, _room(self.path)
        if needed > room:
            where = f"the disk of {self.path} has free" if self.path else "this machine has memory"
            remedy = "" if self.path else ", or give the sweep a store"
            raise ValueError(
                f"the results of {self.layout.points:.4g} points take {needed / 1e9:.4g} GB, more than the "
                f"{room / 1e9:.4g} GB that {where}; store fewer numbers for fewer points{remedy}"
            )

    def write(self, chunk: int, part: ChunkResult, values: Mapping[str, Floats]) -> None:
        """Write what was found in a chunk; points whose worker was lost are tried again by the next run."""
        region = self.layout.stretch(chunk).region
        shape = tuple(s.stop - s.start for s in region)
        with self.one_error("written"):
            if self.dims == ("point",):
                for path, numbers in values.items():
                    self._array_of(path)[region] = numbers
            for name, array in part.arrays.items():
                self._array_of(name)[region] = array.reshape(*shape, *array.shape[1:])
            if part.estimates:
                self._array_of(ESTIMATE)[chunk] = [part.estimates.get(v.name, np.nan) for v in self.variables or ()]
            if part.message:
                letters = part.message.encode()[:LETTERS]
                self._array_of(MESSAGE)[chunk] = np.frombuffer(letters.ljust(LETTERS, b"\0"), np.uint8)
            self._array_of(STATUS)[region] = part.status.reshape(shape)
            self.failed[chunk] = int(np.count_nonzero(part.status))
            if not np.any(part.status == PointStatus.LOST):
                self._array_of(DONE)[chunk : chunk + 1] = [1]
                self.done[chunk] = True

    def _array_of(self, name: str) -> Any:
        """Array of the store, opened once."""
        if name not in self.arrays:
            # A chunk of NaN, the fill value, is a file too: else it would look like one that is missing.
            with zarr.config.set({"array.write_empty_chunks": True}):
                self.arrays[name] = self.group[name]
        return self.arrays[name]

    def _restore(self, axes: Mapping[str, Floats]) -> None:
        """Write the values along the axes again where they are missing or damaged."""
        for path, values in axes.items():
            intact = False
            with contextlib.suppress(Exception):
                intact = bool(np.array_equal(self._array_of(path)[:], values))
            if not intact:
                log.warning("the values of %s in %s are damaged; they are rewritten", path, self.path)
                self._array_of(path)[:] = values

    def _check_arrays(self) -> None:
        """Raise a ValueError if the description of an array cannot be read."""
        for name in [STATUS, MESSAGE, DONE, *self.units, *(v.name for v in self.variables or ())]:
            try:
                self._array_of(name)
            except Exception as error:
                raise ValueError(
                    f"{self.path}/{name}/zarr.json is damaged ({type(error).__name__}); restore it, or delete "
                    "the store and run the sweep again"
                ) from error

    def _finished(self) -> Array:
        """Chunks that are done: those that say so and whose files are whole."""
        finished = np.zeros(self.layout.chunks, bool)
        for chunk in range(len(finished)):
            with contextlib.suppress(Exception):
                finished[chunk] = self._array_of(DONE)[chunk] == 1
            if finished[chunk] and (wrong := self._damage(chunk)):
                log.warning("chunk %d of %s is damaged (%s); it is computed again", chunk, self.path, wrong)
                finished[chunk] = False
        return finished

    def _damage(self, chunk: int) -> str:
        """Return what is wrong with the files of a chunk, "" if nothing is."""
        region = self.layout.stretch(chunk).region
        file = "c/" + "/".join(map(str, self.layout.indices(chunk)))
        try:
            status = self._array_of(STATUS)[region]
            self.failed[chunk] = int(np.count_nonzero(status))
            if np.any(status == PointStatus.NOT_COMPUTED):
                return f"{STATUS} is missing"
            names = [v.name for v in self.variables or ()] if np.any(status == PointStatus.OK) else []
            names += self.units if self.dims == ("point",) else ()
            for name in names:
                behind = "/0" * (len(self._array_of(name).shape) - len(region))
                if not (Path(str(self.path)) / name / (file + behind)).exists():
                    return f"{name} is missing"
                self._array_of(name)[region]
            for name in (MESSAGE, *([ESTIMATE] if ESTIMATE in self.group else [])):
                self._array_of(name)[chunk]
        except Exception as error:
            return " ".join(str(error).split())[:100] or type(error).__name__
        return ""

    @contextlib.contextmanager
    def one_error(self, verb: str) -> Iterator[None]:
        """Turn what a file system says into one sentence."""
        try:
            yield
        except OSError as error:
            why = (error.strerror or str(error)).lower()
            kept = f"{int(np.sum(self.done))} of {self.layout.chunks} chunks are kept" if hasattr(self, "done") else ""
            remedy = "free some space" if error.errno in (errno.ENOSPC, errno.EDQUOT) else "fix this"
            raise RuntimeError(
                f"the store {shown(str(self.path))} cannot be {verb} ({why}); {kept + '; ' if kept else ''}{remedy} "
                "and run the same sweep again"
            ) from error

    def finish(self) -> None:
        """Note in the attributes how many points failed, and the first messages."""
        if self.path is not None and self.lock is None:  # it is read only: they are there already
            return
        wrong = [chunk for chunk, points in sorted(self.failed.items()) if points]
        with self.one_error("written"):
            letters = [np.asarray(self._array_of(MESSAGE)[chunk]).tobytes() for chunk in wrong[:SHOWN]]
            errors = [text.rstrip(b"\0").decode(errors="replace") for text in letters]
            self.group.attrs.update({"failed_points": sum(self.failed.values()), "errors": errors})

    def dataset(self) -> xr.Dataset:
        """Open the results; values are read when they are used."""
        store: Any = self.memory if self.path is None else LocalStore(self.path, read_only=True)
        return open_dataset(store)

    def close(self) -> None:
        """Give the store free for other processes."""
        if self.lock is not None:
            self.lock.release()


def name_axis(path: Path, axis: str, name: str, texts: Sequence[str], numbers: Floats | None, unit: str) -> None:
    """Say in a store what the places along an axis stand for: texts in the axis, their numbers as an array along it.

    A store that cannot be written stays as it is.
    """
    with contextlib.suppress(OSError, KeyError):
        group = zarr.open_group(LocalStore(path), mode="r+", zarr_format=3)
        group[axis].attrs.update({"name": name, "values": list(texts)})
        if numbers is not None and name not in group:
            group.create_array(name, data=numbers, dimension_names=(axis,), attributes={"units": unit})


def open_dataset(store: Any) -> xr.Dataset:
    """Open the store of a sweep as a dataset over its points, without reading the values."""
    data = xr.open_dataset(
        store, engine="zarr", consolidated=False, chunks=None, decode_cf=False, zarr_format=3, cache=False
    )
    if ESTIMATE in data:
        largest = np.fmax.reduce(data[ESTIMATE].values, axis=0)
        for item, value in zip(data.attrs["variables"], largest, strict=True):
            if np.isfinite(value):
                data[item[0]].attrs[ESTIMATE] = float(value)
    names = [item[0] for item in data.attrs.pop("variables", [])]
    for name in names:
        data = data.assign_coords(data[name].attrs.pop("labels", {}))
    parameters = data.attrs["parameters"]
    listed = {"parameters": ", ".join(parameters), "installed": ", ".join(data.attrs.get("installed", ()))}
    lines = {"errors": "\n".join(data.attrs.get("errors", ()))}  # lists of text are more than netCDF files hold
    return data[[*names, STATUS, *parameters]].set_coords(parameters).assign_attrs(listed | lines)


def _room(path: Path | None) -> float:
    """Bytes that results may take; infinite where the system does not say."""
    if path is not None:
        return float(shutil.disk_usage(path).free) or math.inf  # some network file systems say 0
    with contextlib.suppress(AttributeError, ValueError, OSError):
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    return math.inf


def _variable(item: Any) -> Variable:
    name, dtype, dims, shape, attributes = item
    return Variable(name, dtype, tuple(dims), tuple(shape), attributes)
