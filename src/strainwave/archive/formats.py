"""Formats of files: how the arrays of a dataset are written to each and read back.

Complex arrays are split into `_real` and `_imag`; truth values and whole numbers are stored as small integers, which
NetCDF 3 knows, and words along a dimension as an attribute.
"""

import re
from pathlib import Path
from typing import Any

import numpy as np

from .mat_file import read_mat, write_mat

MARK = "strainwave"
ENDINGS = (".nc", ".zarr", ".npz", ".mat")
STORED: dict[str, tuple[type, ...]] = {
    "b": (np.int8,), "i": (np.int32, np.float64), "u": (np.int32, np.float64), "f": (np.float64,)
}  # fmt: skip
PARTS = ("_real", "_imag")
TAKEN = (MARK, *PARTS, "file", "args", "kwds", "allow_pickle", ".", "..", "zarr.json")  # by a format or its writer
LARGEST = 2**31 - 1  # whole number of an attribute in NetCDF 3

Arrays = dict[str, Any]


def stored_name(name: str) -> str:
    """Name of an array in a file: what a format would take for something else is written as %XX, or marked by a %."""
    safe = re.sub(r"[\x00-\x1f/\\]|%(?=[0-9A-F]{2}|$)", lambda sign: f"%{ord(sign[0]):02X}", name)
    return f"{safe}%" if not safe or safe in TAKEN or safe.endswith(PARTS) else safe


def plain(data: Any) -> Any:
    """Dataset with the kinds of arrays alone that every format knows, and without the empty ones."""
    whole = {name: value for name, value in data.attrs.items() if isinstance(value, int) and abs(value) > LARGEST}
    data = data.rename({name: stored_name(str(name)) for name in data.variables})
    data = data.assign_attrs({name: str(value) for name, value in whole.items()})
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
            for kind in STORED[variable.dtype.kind]:
                stored = variable.astype(kind)
                if np.array_equal(stored.astype(variable.dtype), variable, equal_nan=variable.dtype.kind == "f"):
                    break
            else:
                raise ValueError(
                    f"{name} has whole numbers that no float tells apart, beyond 2^53, which a file cannot give back; "
                    "take away what they have in common, or save them as floats"
                )
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
        np.savez(stream, allow_pickle=False, **attributes | arrays)


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
