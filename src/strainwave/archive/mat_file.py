"""MAT-files of MATLAB: every array of a dataset as a struct with its value, its unit and the names of its dimensions.

A name that MATLAB does not have ("error, axis 1", "frequency'") is written with `_`; the struct keeps the own one too.
"""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

LONGEST = 60  # characters of a name in MATLAB, which takes 63


def write_mat(data: Any, path: str, parts: tuple[str, str]) -> None:
    """Write an xarray dataset; two real arrays whose names end in `parts` become a complex one."""
    from scipy.io import savemat

    found: dict[str, Any] = {}
    for name, value in data.attrs.items():  # first: `load` looks for them by their names
        found[_named(str(name), found)] = value
    for name, variable in data.variables.items():
        own, value = str(name), variable.values
        if own.endswith(parts[1]):
            continue
        if own.endswith(parts[0]):
            own = own.removesuffix(parts[0])
            value = np.empty(variable.shape, complex)
            value.real, value.imag = (data.variables[own + part].values for part in parts)
        unit, dimensions = variable.attrs.get("units", ""), ", ".join(map(str, variable.dims))
        found[_named(own, found)] = {"value": value, "unit": unit, "dimensions": dimensions, "name": own}
    with open(path, "wb") as stream:
        savemat(stream, found, oned_as="column", long_field_names=True)


def read_mat(path: Path, parts: tuple[str, str]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Arrays of a file that `write_mat` wrote, complex ones in two, and its single texts."""
    from scipy.io import loadmat

    with open(path, "rb") as stream:
        stored = loadmat(stream, struct_as_record=False)
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


def _named(name: str, taken: Mapping[str, Any]) -> str:
    """Name in MATLAB that is not taken."""
    plain = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_")[:LONGEST]
    plain = plain if plain[:1].isalpha() else f"x_{plain}"
    numbered = (plain if i == 0 else f"{plain}_{i}" for i in range(len(taken) + 1))
    return next(candidate for candidate in numbered if candidate not in taken)
