"""Formats of files: how the arrays of a dataset are written to each and read back.

Complex arrays are split into `_real` and `_imag`; truth values and whole numbers are stored as small integers, which
NetCDF 3 knows, and words along a dimension as an attribute.
"""

from pathlib import Path
from typing import Any

import numpy as np

from .mat_file import read_mat, write_mat

MARK = "strainwave"
ENDINGS = (".nc", ".zarr", ".npz", ".mat")
STORED = {"b": np.dtype(np.int8), "i": np.dtype(np.int32), "u": np.dtype(np.int32), "f": np.dtype(np.float64)}
PARTS = ("_real", "_imag")

Arrays = dict[str, Any]


def plain(data: Any) -> Any:
    """Dataset with the kinds of arrays alone that every format knows, and without the empty ones."""
    for name in list(data.variables):
        variable = data[name]
        if not variable.size:
            data = data.drop_vars(name)
        elif variable.dtype.kind in "UO":  # words along a dimension, which not every format has as an array
            data = data.drop_vars(name).assign_attrs({name: ", ".join(map(str, variable.values))})
        elif variable.dtype.kind == "c":
            parts = zip(PARTS, (variable.real, variable.imag), strict=True)
            data = data.drop_vars(name).assign({f"{name}{part}": value for part, value in parts})
        elif variable.dtype.kind in STORED:
            stored = variable.astype(STORED[variable.dtype.kind])
            if not np.array_equal(stored, variable, equal_nan=variable.dtype.kind == "f"):
                raise ValueError(f"{name} has whole numbers beyond 32 bits, which NetCDF does not hold")
            data[name] = stored
    return data


def _write_netcdf(data: Any, path: str) -> None:
    data.to_netcdf(path, engine="scipy", encoding=_unfilled(data))


def _write_zarr(data: Any, path: str) -> None:
    data.to_zarr(path, zarr_format=3, consolidated=False, encoding=_unfilled(data))


def _unfilled(data: Any) -> dict[str, dict[str, None]]:
    return {str(name): {"_FillValue": None} for name, value in data.variables.items() if value.dtype.kind in STORED}


def _write_npz(data: Any, path: str) -> None:
    arrays = {str(name): value.values for name, value in data.variables.items()}
    with open(path, "wb") as stream:
        attributes = {str(name): np.array(value) for name, value in data.attrs.items()}
        np.savez(stream, allow_pickle=False, **arrays, **attributes)


def _read_netcdf(path: Path) -> tuple[Arrays, Arrays]:
    from scipy.io import netcdf_file

    with open(path, "rb") as stream:
        file = netcdf_file(stream, mmap=False)
        stored = {name: np.array(variable[:]) for name, variable in file.variables.items()}
        return stored, {MARK: vars(file)[MARK].decode()} if MARK in vars(file) else {}


def _read_zarr(path: Path) -> tuple[Arrays, Arrays]:
    import xarray as xr  # half a second

    with xr.open_zarr(path, decode_cf=False, consolidated=False) as data:
        return {str(name): value.values for name, value in data.variables.items()}, dict(data.attrs)


def _read_npz(path: Path) -> tuple[Arrays, Arrays]:
    with open(path, "rb") as stream, np.load(stream, allow_pickle=False) as data:
        stored = {name: data[name] for name in data.files}
    return stored, stored


def _write_mat(data: Any, path: str) -> None:
    write_mat(data, path, PARTS)


def _read_mat(path: Path) -> tuple[Arrays, Arrays]:
    return read_mat(path, PARTS)


WRITERS = dict(zip(ENDINGS, (_write_netcdf, _write_zarr, _write_npz, _write_mat), strict=True))
READERS = dict(zip(ENDINGS, (_read_netcdf, _read_zarr, _read_npz, _read_mat), strict=True))
