"""Forms of every result beside its own numbers: labelled arrays, a table, a file, a figure."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import fields
from enum import Enum
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..compile.tree import shown
from .above import above
from .archive import atomic, version, write
from .facts import Fact, lines
from .terminal import on_screen

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

Labelled = Mapping[str, tuple[str | tuple[str, ...], Any, str]]  # by name: dimensions, values, unit
Along = Mapping[str | tuple[str, ...], Mapping[str, str]]  # by dimensions: units of fields by name


class Result:
    """A frozen result: `to_xarray`, `to_dataframe`, `save`, `panels`, `plot`.

    A class says in `variables` and `coordinates` what its arrays are, or in `arrays` and `places` which of its fields
    they are, and in `rows` along which of their dimensions its table goes.
    """

    rows: ClassVar[str] = "point"
    arrays: ClassVar[Along] = {}
    places: ClassVar[Along] = {}

    def __init_subclass__(cls) -> None:
        """Let a class that says what it prints, or whose base does, say it in its `__repr__` too."""
        if cls.__str__ is not Result.__str__ or cls.facts is not Result.facts:
            cls.__repr__ = cls.__str__  # type: ignore[method-assign, assignment]

    def facts(self) -> tuple[Fact, ...]:
        """Everything that is said of the result, once; none where its class writes its text itself."""
        return ()

    def __str__(self) -> str:
        facts = self.facts()
        return on_screen("\n".join(lines(facts))) if facts else object.__repr__(self)

    def variables(self) -> Labelled:
        """Arrays of the dataset by name: dimensions, values, unit."""
        return self._columns(self.arrays)

    def coordinates(self) -> Labelled:
        """Coordinates of the dataset by name: dimensions, values, unit."""
        return self._columns(self.places)

    def _columns(self, along: Along) -> Labelled:
        return {n: (dims, getattr(self, n), u) for dims, units in along.items() for n, u in units.items()}

    def to_xarray(self) -> "xr.Dataset":
        """Arrays with named dimensions and coordinates, their units in `attrs["units"]`; single numbers in `attrs`.

        An array that has the name of a coordinate, as a channel of a log may, is there as "NAME itself".
        """
        import xarray as xr  # half a second, which a result alone does not take

        arrays, places = [
            {name: (dims, values, {"units": unit} if unit else {}) for name, (dims, values, unit) in labelled.items()}
            for labelled in (self.variables(), self.coordinates())
        ]
        named = {f"{name} itself" if name in places else name: array for name, array in arrays.items()}
        return xr.Dataset(named, places, _attributes(self))

    def to_dataframe(self) -> "pd.DataFrame":
        """Table of what `to_xarray` has along `rows`, in SI; a second dimension is spread over columns."""
        return self._table()[0]

    def _table(self) -> "tuple[pd.DataFrame, list[str]]":
        """The table, and the units of its index and of its columns."""
        import pandas as pd

        data, columns, units = self.to_xarray(), dict[str, Any](), dict[str, str]()
        for name, value in chain(data.coords.items(), data.data_vars.items()):
            parts: dict[str, Any] = {}
            if value.dims[:1] == (self.rows,) and value.ndim == 1 and name != self.rows:
                parts[str(name)] = value.values
            elif value.ndim == 2 and self.rows in value.dims:
                (across,) = set(value.dims) - {self.rows}
                labels = data[across].values if across in data.coords else range(value.sizes[across])
                table = value.transpose(self.rows, across).values
                parts = {f"{name} {label}": table[:, i] for i, label in enumerate(labels)}
            columns |= parts
            units |= dict.fromkeys(parts, value.attrs.get("units", ""))
        index = data.indexes.get(self.rows, pd.RangeIndex(data.sizes.get(self.rows, 0), name=self.rows))
        unit = data[self.rows].attrs.get("units", "") if self.rows in data.coords else ""
        return pd.DataFrame(columns, index=index), [unit, *units.values()]

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write everything as NetCDF (`.nc`) for `load`, which reads it back to the bit, and for xarray.

        The file appears only when it is complete. CSV (`.csv`) is the table of `to_dataframe` with units in its
        header, which `load` does not read. Other formats are written from `to_xarray`.

        Raises
        ------
        ValueError
            If the ending is another, the result holds a class that is not of this package, or has no table for CSV.
        FileNotFoundError
            If there is no such folder.
        """
        path, name = Path(path), type(self).__name__
        if path.suffix == ".nc":
            write(self, self.to_xarray(), path)
            return path
        if path.suffix != ".csv":
            raise ValueError(f"cannot save a {name} as {shown(path.name)}; use a name that ends in .nc or .csv")
        table, units = self._table()
        if table.empty:
            raise ValueError(f"a {name} has no table that CSV can hold; use a name that ends in .nc")
        table = table.reset_index()
        table.columns = [f"{column} [{unit}]" if unit else column for column, unit in zip(table, units, strict=True)]
        table = table.astype(dict.fromkeys(table.select_dtypes(bool).columns, int))
        with atomic(path) as part:
            table.to_csv(part, index=False, lineterminator="\n")
        return path

    def panels(self) -> Sequence[Any]:
        """Figure of the result as plain data, `strainwave.plot.Panel` from top to bottom; none where it has none."""
        return tuple(above("panels_of")(self))

    def plot(self, axes: Any = None) -> Any:
        """Draw the panels with matplotlib (extra `plot`) on axes, or on those of a new figure; return the axes."""
        return above("draw")(self, axes)

    def _repr_html_(self) -> str:
        """Summary, figure and arrays in a notebook."""
        return str(above("html")(self))


def _attributes(result: Any) -> dict[str, Any]:
    """Class, version, and the single numbers and words of a result."""
    attributes: dict[str, Any] = {"result": type(result).__name__, "version": version()}
    for field in fields(result):
        value = getattr(result, field.name)
        if isinstance(value, Enum):
            attributes[field.name] = value.name
        elif isinstance(value, bool | np.bool_):
            attributes[field.name] = int(value)
        elif isinstance(value, int | float | str) and value != "":
            attributes[field.name] = value
    return attributes


class Waves(NamedTuple):
    """Waves of motions that beat: pairs (P, 2) of repeats per turn of the motor and of the output, the mean first.

    `orders` (P,) are their repeats per turn of the motor, `amplitudes` (n, P) complex: the motion is the real part of
    their sum, each times exp(i order angle).
    """

    pairs: NDArray[np.int64]
    orders: NDArray[np.float64]
    amplitudes: NDArray[np.complex128]

    def amplitude(self, order: float) -> NDArray[np.float64]:
        """Amplitude (n,) of an order, which need not be whole; 0 where there is no such wave."""
        matches = np.isclose(np.abs(self.orders), order, rtol=0.0, atol=1e-9)
        return np.asarray(np.abs(self.amplitudes[:, matches]).sum(axis=1))
