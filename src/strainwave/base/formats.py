"""Formats of files: how the arrays of a dataset are written to each and read back.

Complex arrays are split into `_real` and `_imag`; truth values and whole numbers are stored as small integers, which
NetCDF 3 knows, and words along a dimension as an attribute.

MAT-files of MATLAB: every array of a dataset as a struct with its value, its unit and the names of its dimensions.
"""

import os
import pickle
import re
import subprocess
import sys
from collections.abc import Mapping
from hashlib import blake2s
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

MARK = "strainwave"
ENDINGS = (".nc", ".zarr", ".npz", ".mat")
STORED: dict[str, tuple[type, ...]] = {
    "b": (np.int8,), "i": (np.int32, np.float64), "u": (np.int32, np.float64), "f": (np.float64,)
}  # fmt: skip
PARTS = ("_real", "_imag")
TAKEN = (MARK, *PARTS, "file", "args", "kwds", "allow_pickle", ".", "..", "zarr.json")  # by a format or its writer
LARGEST = 2**31 - 1  # whole number of an attribute in NetCDF 3

Arrays = dict[str, Any]

HEAD, SEAL = 116, "strainwave"  # bytes of text at the begin of a MAT-file, and what is before its seal there
STOPPED = (-9, -15)  # codes of a process that the system or a user ended: the signals SIGKILL and SIGTERM
LONGEST = 60  # characters of a name in MATLAB, which takes 63
CHILD = """
import pickle, sys
from scipy.io import loadmat
try:
    answer = loadmat(sys.argv[1], appendmat=False, squeeze_me=sys.argv[2] == "True", struct_as_record=False)
except NotImplementedError:  # as SciPy says of MATLAB 7.3, which another reader takes
    answer = NotImplementedError()
except Exception as error:  # whatever a damaged file makes SciPy raise
    answer = ValueError(str(error))
pickle.dump(answer, sys.stdout.buffer)
"""


class NoReader(RuntimeError):
    """No process can read a MAT-file: it does not start, or is ended from outside."""


def write_mat(data: Any, path: str, parts: tuple[str, str]) -> None:
    """Write an xarray dataset; two real arrays whose names end in `parts` become a complex one."""
    from scipy.io import savemat

    variables: dict[str, Any] = {}
    for name, value in data.attrs.items():  # first: `load` looks for them by their names
        variables[_named(str(name), variables)] = value
    for name, variable in data.variables.items():
        key, value = str(name), variable.values
        if key.endswith(parts[1]):
            continue
        if key.endswith(parts[0]):
            key = key.removesuffix(parts[0])
            value = np.empty(variable.shape, complex)
            value.real, value.imag = [data.variables[key + part].values for part in parts]
        unit, dimensions = variable.attrs.get("units", ""), ", ".join(map(str, variable.dims))
        variables[_named(key, variables)] = {"value": value, "unit": unit, "dimensions": dimensions, "name": key}
    stream = BytesIO()
    savemat(stream, variables, oned_as="column", long_field_names=True)
    content = stream.getvalue()
    head = f"MATLAB 5.0 MAT-file, {_sealed(content)}".ljust(HEAD).encode()
    Path(path).write_bytes(head + content[HEAD:])


def read_mat(path: Path, parts: tuple[str, str]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Arrays of a file that `write_mat` wrote, complex ones in two, and its single texts."""
    from scipy.io import loadmat

    content = path.read_bytes()
    head = content[:HEAD].decode("latin-1")
    if SEAL in head and _sealed(content) not in head:
        raise ValueError("its content is not what was saved")
    stored = mat_variables(path) if SEAL not in head else loadmat(BytesIO(content), struct_as_record=False)
    arrays, texts = dict[str, Any](), dict[str, Any]()
    for name, thing in stored.items():
        if not isinstance(thing, np.ndarray) or not thing.size:
            continue
        first = thing.flat[0]
        if isinstance(first, str):
            texts[name] = first
        elif hasattr(first, "value"):
            own, value = str(first.name[0]), first.value
            whole = value.dtype.kind == "c"
            arrays |= (
                dict(zip((own + p for p in parts), (value.real, value.imag), strict=True)) if whole else {own: value}
            )
    return arrays, texts


def mat_variables(path: Path, *, squeezed: bool = False) -> dict[str, Any]:
    """Variables of a MAT-file by name, from a child process: a damaged file can end that of SciPy's reader.

    Raises
    ------
    NotImplementedError
        If the file is of version 7.3.
    ValueError
        If it is damaged.
    RuntimeError
        If that process cannot be started, cannot import SciPy, or is ended from outside.
    """
    # -P: no module of the working folder stands in for one of these
    command = [sys.executable or "python", "-P", "-c", CHILD, os.fspath(path), str(squeezed)]
    try:
        child = subprocess.run(command, capture_output=True, check=False)
        cause = child.stderr.decode(errors="replace").strip() if child.returncode == 1 else ""
    except OSError as error:
        cause = str(error)
    if cause:
        raise NoReader(
            f"{path} is read by a process of its own, {command[0]}, which does not run ({cause.splitlines()[-1]}); let "
            "this program start processes, or save the data as .npz"
        )
    if child.returncode in STOPPED:
        raise NoReader(
            f"{path} is read by a process of its own, which was ended from outside (signal {-child.returncode}), as a "
            "system does that has no memory left; read it with more memory, or save the data as .npz"
        )
    if child.returncode:
        raise ValueError(f"SciPy's reader ended with the code {child.returncode}")
    answer = pickle.loads(child.stdout)
    if isinstance(answer, Exception):
        raise answer
    return dict(answer)


def _sealed(content: bytes) -> str:
    """What the head of a MAT-file says of the content behind it."""
    return f"{SEAL} {blake2s(content[HEAD:], digest_size=16).hexdigest()}"


def _named(name: str, taken: Mapping[str, Any]) -> str:
    """Name in MATLAB that is not taken."""
    plain = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_")[:LONGEST]
    plain = plain if plain[:1].isalpha() else f"x_{plain}"
    numbered = (plain if i == 0 else f"{plain}_{i}" for i in range(len(taken) + 1))
    return next(candidate for candidate in numbered if candidate not in taken)


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


def _write_mat(data: object, path: str) -> None:
    write_mat(data, path, PARTS)


def _read_mat(path: Path) -> tuple[Arrays, Arrays]:
    return read_mat(path, PARTS)


WRITERS = dict(zip(ENDINGS, (_write_netcdf, _write_zarr, _write_npz, _write_mat), strict=True))
READERS = dict(zip(ENDINGS, (_read_netcdf, _read_zarr, _read_npz, _read_mat), strict=True))
