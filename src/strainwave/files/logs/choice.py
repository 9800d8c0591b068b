"""Which column of a file is which channel, and in which unit."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...units import shown
from .names import canonical, converted, expected, named, si_unit
from .table import Column, refuse

Columns = Mapping[str, str | int] | Sequence[str | None]
Units = Mapping[str, str | float]


def chosen(path: Path, file: list[Column], columns: Columns | None, notes: list[str]) -> dict[str, Column]:
    """Columns by channel; "time" is among them where the file has it.

    Raises
    ------
    FileError
        If the user names a column that is not there, or the file has no names and neither does the user.
    """
    if columns is not None and not isinstance(columns, Mapping):
        return _in_order(path, file, columns)
    given = {} if columns is None else dict(columns)
    places = {channel: _place(path, file, channel, column) for channel, column in given.items()}
    if not given and not any(column.name for column in file):
        raise refuse(
            path,
            f"has {len(file)} columns without names; give columns=['time', 'load_angle', ...], a name for each in its "
            "order, None for one to leave out",
        )
    rest = [i for i, column in enumerate(file) if i not in places.values() and column.name]
    plain = {i: named(file[i].name).name for i in rest}
    guesses = {i: canonical(plain[i]) for i in rest}
    taken = [guess for guess in guesses.values() if guess is not None]
    told = []
    for i in rest:
        guess, name = guesses[i], plain[i]
        free = guess is not None and guess not in places and taken.count(guess) == 1 and _measures(file[i], guess)
        channel = str(guess) if free else name
        if channel in places:
            channel = file[i].name
        if channel in places:
            said = f"columns={{{channel!r}: {places[channel]}, {channel + ' 2'!r}: {i}}}"
            raise refuse(path, f"has two columns {shown(channel)}; name them by place, {said}")
        places[channel] = i
        if channel != name:
            told.append(f"{channel} is {file[i].name!r}")
    if told:
        notes.append(f"channels were recognised by their names: {', '.join(told)}")
    return {channel: file[i] for channel, i in places.items()}


def _in_order(path: Path, file: list[Column], columns: Sequence[str | None]) -> dict[str, Column]:
    if isinstance(columns, str) or not all(name is None or isinstance(name, str) for name in columns):
        raise TypeError(f"columns is {shown(columns)}; give names in their order, or {{'load_angle': 'position'}}")
    if len(columns) != len(file):
        raise refuse(path, f"has {len(file)} columns, and columns names {len(columns)}; give a name or None for each")
    names = [name for name in columns if name]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise ValueError(f"columns has {twice!r} twice; give each channel once")
    return {name: column for name, column in zip(columns, file, strict=True) if name}


def _place(path: Path, file: list[Column], channel: str, wanted: str | int) -> int:
    if isinstance(wanted, int) and not isinstance(wanted, bool):
        if 0 <= wanted < len(file):
            return wanted
        raise refuse(path, f"has {len(file)} columns, so none at the place {wanted} for {channel}; 0 is the first")
    for names in ([c.name for c in file], [named(c.name).name for c in file]):
        if names.count(str(wanted)) == 1:
            return names.index(str(wanted))
    there = ", ".join(c.name for c in file if c.name) or f"{len(file)} columns without names, from 0 on"
    raise refuse(path, f"has no single column {shown(wanted)} for {channel}; it has {there}")


def _unit(column: Column) -> str:
    return column.unit or named(column.name).unit


def _measures(column: Column, channel: str) -> bool:
    """Whether a column's unit, if it has one, can be that of a channel."""
    unit, kind = _unit(column), expected(channel)
    return not unit or not kind or si_unit(unit) == kind


def in_si(
    path: Path, columns: dict[str, Column], units: Units, notes: list[str]
) -> tuple[dict[str, Column], dict[str, str]]:
    """Columns in SI, and their units.

    Raises
    ------
    FileError
        If a unit does not fit the channel.
    ValueError
        If a unit is given for a channel that is not there.
    """
    unknown = [name for name in units if name not in columns]
    if unknown:
        raise ValueError(
            f"units has {unknown[0]!r}, and the channels are {', '.join(columns)}; name one of these, or "
            f"the column that is {unknown[0]!r}, too"
        )
    found: dict[str, Column] = {}
    si: dict[str, str] = {}
    assumed = []
    for channel, column in columns.items():
        unit, kind = units.get(channel, _unit(column)), expected(channel)
        if unit == "":
            if kind:
                assumed.append(f"{channel} in {kind}")
            found[channel], si[channel] = column, kind
            continue
        if not kind and isinstance(unit, str):
            kind = si_unit(unit) or ""
            if not kind and channel in units:
                raise ValueError(f"units has {unit!r} for {channel!r}, which is no unit of a channel; leave it out")
            if not kind:
                notes.append(f"{channel} is in {unit!r}, which is left as it is")
                found[channel], si[channel] = column, unit
                continue
        try:
            values = converted(column.values, unit, kind)
        except ValueError as error:
            raise refuse(
                path, f"{error}; give units={{{channel!r}: {kind!r}}} if the file is wrong", what=channel
            ) from None
        found[channel], si[channel] = replace(column, values=np.asarray(values, float)), kind
    if assumed:
        notes.append(f"no unit is given for {', '.join(assumed)}: units= says what else they are")
    return found, si
