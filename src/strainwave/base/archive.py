"""Results as NetCDF files that read back equal to the bit.

A file holds the arrays of `to_xarray` under their names, so that xarray alone reads it too, and in the attribute
`strainwave` everything that the result consists of, as JSON that refers to arrays by name. NetCDF 3 knows few kinds of
numbers: complex arrays are split into `_real` and `_imag`, truth values and whole numbers are stored as small integers,
and words along a dimension as an attribute.
"""

import hashlib
import json
import os
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import fields, is_dataclass
from enum import Enum
from importlib import import_module
from pathlib import Path
from typing import Any
from uuid import uuid4

import numpy as np

from ..compile.tree import is_model, shown

MARK = "strainwave"
INPUTS: list[Path] = []  # what the command of this process reads
STORED: dict[str, tuple[type, ...]] = {
    "b": (np.int8,), "i": (np.int32, np.float64), "u": (np.int32, np.float64), "f": (np.float64,)
}  # fmt: skip
PARTS = ("_real", "_imag")
LARGEST_INT = 2**31 - 1  # whole number of an attribute in NetCDF 3

Arrays = dict[str, Any]


def version() -> str:
    """Version of this package, which stands above: it is looked up by name."""
    return str(vars(import_module(MARK))["__version__"])


def refuse_inputs(*outputs: Path) -> None:
    """Refuse a file to write that the command reads (ValueError)."""
    for output in outputs:
        if output.is_file() and any(one.is_file() and output.samefile(one) for one in INPUTS):
            raise ValueError(f"{output} is an input of this command and would be replaced; write elsewhere")


@contextmanager
def atomic(path: Path) -> Iterator[str]:
    """Name of a temporary sibling of `path`, which replaces it on success and vanishes on any error."""
    if not path.name or path.is_dir():
        raise ValueError(f"the file is {shown(str(path))}, a folder; give the name of a file")
    if not path.parent.is_dir():
        raise FileNotFoundError(f"there is no folder {path.parent}; make it, or save elsewhere")
    # Not tempfile: its files are readable by their owner alone, and so would be the result.
    part = path.with_name(f".{path.name}.{uuid4().hex}")
    try:
        yield str(part)
        os.replace(part, path)
    except OSError as error:
        # The user knows the other name; an error while writing has none.
        if error.errno is not None and error.filename in (None, str(part), part):
            error.filename, error.filename2 = str(path), None
        raise
    finally:
        with suppress(OSError):  # where nothing can be written, nothing is there
            part.unlink()


def write(result: object, labelled: Any, path: Path) -> None:
    """Write a result as NetCDF; nothing appears at the path before it is complete.

    Parameters
    ----------
    result : object
        Frozen dataclass of this package.
    labelled : xarray.Dataset
        Its arrays with dimensions and units.
    path : Path
        File.

    Raises
    ------
    ValueError
        If the result holds something that no file can give back, or a folder has the name of the file.
    """
    arrays: Arrays = {}
    content = json.dumps(_packed(result, "", arrays))
    taken = set(labelled.variables) | set(labelled.dims)
    labels = {name: f"{name} itself" if name in taken else name for name in arrays}
    names = _names_in_file(labelled, arrays, labels)
    about = {
        "version": version(), "content": json.loads(content),
        "arrays": {
            name: [_stored_name(names[name]), array.dtype.str, list(array.shape)] for name, array in arrays.items()
        },
        "sha256": _digest(content, arrays),
    }  # fmt: skip
    data = labelled.copy()
    for name, array in arrays.items():
        if names[name] == labels[name] and array.size:
            data[labels[name]] = (_dimensions(name, array.shape), array)
    data = _plain(data.assign_attrs({MARK: json.dumps(about)}))
    with atomic(path) as part:
        filled = [str(name) for name, value in data.variables.items() if value.dtype.kind in STORED]
        data.to_netcdf(part, engine="scipy", encoding={name: {"_FillValue": None} for name in filled})
        stored, _ = _read(Path(part))
        if _arrays_of(about, stored) is None:
            raise ValueError(
                f"a .nc file does not give back what this {type(result).__name__} holds; pickle it, or save its parts"
            )


def _names_in_file(labelled: Any, arrays: Arrays, labels: Mapping[str, str]) -> dict[str, str]:
    """Name in a file of each array: that of an equal labelled one, which is stored once, or else its label."""
    prints = {str(name): _print(value.values) for name, value in labelled.variables.items()}
    equal = {value: name for name, value in prints.items()}
    keys = {name: _print(array) for name, array in arrays.items()}
    return {n: n if prints.get(n) == key else equal.get(key, labels[n]) for n, key in keys.items()}


def _dimensions(name: str, shape: tuple[int, ...]) -> list[str]:
    """Names of the dimensions of an array that has none of its own, each another one."""
    plain = [f"{size} of {name}" if size > 1 else "1" for size in shape]
    return [one if plain.index(one) == i else f"{one}, axis {i}" for i, one in enumerate(plain)]


def load(path: str | os.PathLike[str]) -> Any:
    """Read a result back from the file that its `save` wrote.

    Parameters
    ----------
    path : str or path
        NetCDF (`.nc`).

    Returns
    -------
    Trajectory, Orbit, Branch, ...
        Equal to what was saved, every number to the bit.

    Raises
    ------
    ValueError
        If the file is no NetCDF, damaged, or made by another version.
    FileNotFoundError
        If there is none.
    """
    path = Path(path)
    if path.suffix != ".nc":
        raise ValueError(f"cannot load {shown(path.name)}; results are saved with names that end in .nc")
    if not path.exists():
        raise FileNotFoundError(f"there is no {path}; check the name and the folder")
    try:
        stored, text = _read(path)
    except Exception as error:  # whatever a damaged file makes its reader raise
        reason = " ".join(str(error).split())[:200]
        raise ValueError(f"{path} is no whole .nc file of strainwave ({reason}); save the result again") from None
    if text is None:
        raise ValueError(f"{path} holds no result of strainwave; `save` of a result writes one")
    damaged = ValueError(f"{path} is damaged: its content is not what was saved; save the result again")
    try:
        about = json.loads(text)
        written = about["version"]
    except (ValueError, KeyError, TypeError):
        raise damaged from None
    if written != version():
        raise ValueError(f"{path} was made by strainwave {written}; compute it again")
    arrays = _arrays_of(about, stored)
    if arrays is None:
        raise damaged
    return _unpacked(about["content"], arrays, path)


def _arrays_of(about: Any, stored: Mapping[str, Any]) -> Arrays | None:
    """Arrays of a file; None where they are not those that were to be saved."""
    try:
        arrays = {name: _restored(stored, *description) for name, description in about["arrays"].items()}
        return arrays if _digest(json.dumps(about["content"]), arrays) == about["sha256"] else None
    except (ValueError, KeyError, TypeError):
        return None


def _read(path: Path) -> tuple[Arrays, str | None]:
    """Arrays of a NetCDF file, and what it says of the result in it; None where it says nothing."""
    from scipy.io import netcdf_file

    with open(path, "rb") as stream:
        file = netcdf_file(stream, mmap=False)
        stored = {name: np.array(variable[:]) for name, variable in file.variables.items()}
        return stored, vars(file)[MARK].decode() if MARK in vars(file) else None


def _stored_name(name: str) -> str:
    """Name of an array in a file: what NetCDF does not take is written as %XX, and what is no part is told by a %."""
    bad = r"[^\x20-\xff]|/|%(?=[0-9A-F]{2}|$)"  # SciPy writes names in Latin-1
    safe = re.sub(bad, lambda sign: "".join(f"%{byte:02X}" for byte in sign[0].encode()), name)
    return f"{safe}%" if not safe or safe.endswith(PARTS) else safe


def _plain(data: Any) -> Any:
    """Dataset with the kinds of arrays alone that NetCDF 3 knows, and without the empty ones."""
    numbers = {name: value for name, value in data.attrs.items() if isinstance(value, int) and abs(value) > LARGEST_INT}
    data = data.rename({name: _stored_name(str(name)) for name in data.variables})
    data = data.assign_attrs({name: str(value) for name, value in numbers.items()})
    for name in list(data.variables):
        variable = data[name]
        if not variable.size:
            data = data.drop_vars(name)
        elif variable.dtype.kind in "UO":  # words
            data = data.drop_vars(name).assign_attrs({name: ", ".join(map(str, variable.values))})
        elif variable.dtype.kind == "c":
            parts = zip(PARTS, (variable.real, variable.imag), strict=True)
            data = data.drop_vars(name).assign({f"{name}{part}": value for part, value in parts})
        elif variable.dtype.kind in STORED:
            data[name] = _stored(variable)
    return data


def _stored(variable: Any) -> Any:
    """Variable in the smallest kind of NetCDF 3 that holds its numbers."""
    for kind in STORED[variable.dtype.kind]:
        stored = variable.astype(kind)
        if np.array_equal(stored.astype(variable.dtype), variable, equal_nan=variable.dtype.kind == "f"):
            return stored
    raise ValueError(
        f"{variable.name} has whole numbers that no float tells apart, beyond 2^53, which a file cannot give back; "
        "take away what they have in common, or save them as floats"
    )


def _packed(thing: Any, path: str, arrays: Arrays) -> Any:
    """Parts of a thing as JSON; its arrays, by the path to them, go into `arrays`."""
    cls = type(thing)
    if isinstance(thing, np.ndarray):
        arrays[path] = thing
        return {"array": path}
    if isinstance(thing, np.generic):
        return _packed(thing.item(), path, arrays)
    if isinstance(thing, Enum):
        return {"member": thing.name, "class": _name_of(cls, path)}
    if is_dataclass(thing) or is_model(thing):
        names = thing._fields if is_model(thing) else [field.name for field in fields(thing)]
        parts = {name: _packed(getattr(thing, name), _join(path, name), arrays) for name in names}
        return {"class": _name_of(cls, path), "of": parts}
    if thing is None or isinstance(thing, str | bool | int | float):
        return thing
    if isinstance(thing, complex):
        return {"complex": [thing.real, thing.imag]}
    if isinstance(thing, tuple | list):
        items = [_packed(item, _join(path, str(i)), arrays) for i, item in enumerate(thing)]
        return items if isinstance(thing, list) else {"tuple": items}
    if isinstance(thing, dict):
        pairs = enumerate(thing.items())
        return {"dict": [[_packed(k, "", arrays), _packed(v, _join(path, str(i)), arrays)] for i, (k, v) in pairs]}
    raise ValueError(f"{path} is {shown(thing)}, which no file can give back; pickle it, or save its parts")


def _join(path: str, name: str) -> str:
    """Path of a part."""
    return f"{path}.{name}" if path else name


def _name_of(cls: type, path: str) -> str:
    """Name of a class of this package in a file; another one is refused (ValueError)."""
    if cls.__module__.partition(".")[0] != MARK:
        raise ValueError(
            f"{path} is a {cls.__name__} of your own ({cls.__module__}), and a file can give back classes of "
            "strainwave alone; pickle the result, or save its parts"
        )
    return f"{cls.__module__}:{cls.__qualname__}"


def _unpacked(packed: Any, arrays: Arrays, path: Path) -> Any:
    """Inverse of `_packed`: a thing from its parts and the arrays of a file."""
    if isinstance(packed, list):
        return [_unpacked(item, arrays, path) for item in packed]
    if not isinstance(packed, dict):
        return packed
    if "array" in packed:
        return arrays[packed["array"]]
    if "complex" in packed:
        return complex(*packed["complex"])
    if "tuple" in packed:
        return tuple(_unpacked(item, arrays, path) for item in packed["tuple"])
    if "dict" in packed:
        return {_unpacked(key, arrays, path): _unpacked(value, arrays, path) for key, value in packed["dict"]}
    cls = _class_of(packed["class"], path)
    if "member" in packed:
        return cls[packed["member"]]
    values = {name: _unpacked(value, arrays, path) for name, value in packed["of"].items()}
    try:
        return cls(**values)
    except TypeError:
        raise ValueError(f"{path} holds a {cls.__name__} of other fields than it has here; compute it again") from None


def _class_of(name: str, path: Path) -> Any:
    """Class of this package that a file names; no other code is imported."""
    module, _, attribute = name.partition(":")
    cls = None
    if module.partition(".")[0] == MARK:
        with suppress(ImportError):
            cls = getattr(import_module(module), attribute, None)
    if not isinstance(cls, type) or not (is_dataclass(cls) or hasattr(cls, "_fields") or issubclass(cls, Enum)):
        raise ValueError(f"{path} holds a {name}, which strainwave {version()} does not have; compute it again")
    return cls


def _print(array: object) -> tuple[str, tuple[int, ...], bytes]:
    """Key of an array: equal for two arrays that are equal to the bit."""
    array = np.asarray(array)
    return array.dtype.str, array.shape, array.tobytes()


def _digest(content: str, arrays: Arrays) -> str:
    """Hash of everything that a file holds."""
    digest = hashlib.sha256(content.encode())
    for name in sorted(arrays):
        dtype, shape, data = _print(arrays[name])
        digest.update(f"{name} {dtype} {shape}".encode())
        digest.update(data)
    return digest.hexdigest()


def _restored(stored: Mapping[str, Any], name: str, dtype: str, shape: list[int]) -> Any:
    """Array of a file in its own type and shape."""
    kind = np.dtype(dtype)
    if 0 in shape:
        return np.empty(shape, kind)
    if kind.kind != "c":
        return np.ascontiguousarray(stored[name]).astype(kind).reshape(shape)
    out = np.empty(shape, kind)
    out.real, out.imag = [np.asarray(stored[name + part]).reshape(shape) for part in PARTS]
    return out
