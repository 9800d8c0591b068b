"""Assignment of the columns of a file to channels, as chosen or recognised, and their values in SI."""

import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ...base.quantities import joined, number, shown
from .names import UNMEASURED, canonical, converted, epoch_unit, expected, named, si_unit, suffixed
from .table import Column, Roles, index_of, refuse, unit_of

Columns = Mapping[str, str | int] | Sequence[str | None]
Units = Mapping[str, str | float]
# Arguments of read_log that are kept beside a log, and the names of its columns.
ARGUMENTS: dict[str, Any] = {"columns": (list, dict), "units": dict, "rate": (int, float), "joint": str, "names": list}


def chosen(path: Path, file: list[Column], columns: Columns | None, notes: list[str]) -> Roles:
    """Columns by channel; "time" is among them where the file has it.

    Raises
    ------
    FileError
        If the user names a column that is not there, or the file has no names and neither does the user.
    """
    if columns is not None and not isinstance(columns, Mapping):
        return _in_order(path, file, columns)
    given = {} if columns is None else dict(columns)
    indices = {channel: index_of(path, file, channel, column) for channel, column in given.items()}
    if not given and not any(column.name for column in file):
        remedy = "give columns=['time', 'load_angle', ...], a name for each in its order, None for one to leave out"
        raise refuse(path, f"has {len(file)} columns without names; {remedy}")
    for channel, i in indices.items():
        if file[i].text:
            fault = f"column {shown(given[channel])} of {channel} holds text, {shown(file[i].text)}; name another"
            raise refuse(path, fault)
    for column in file:
        if column.text and "time" not in indices and canonical(named(column.name).name) == "time":
            fault = f"has times as text, {shown(column.text)}; write dates as 2026-11-23T13:37:38, others as seconds"
            raise refuse(path, fault, what=column.name)
    unnamed = [i for i, column in enumerate(file) if i not in indices.values() and column.name and not column.text]
    if words := [column.name for i, column in enumerate(file) if column.text and i not in indices.values()]:
        notes.append(f"columns of text were omitted: {', '.join(filter(None, words))}")
    plain = {i: named(file[i].name).name for i in unnamed}
    guesses = {i: canonical(plain[i]) for i in unnamed}
    longer = {i: suffixed(plain[i]) for i in unnamed if guesses[i] is None}
    guesses |= {i: guess for i, guess in longer.items() if guess not in guesses.values()}
    taken = [guess for guess in guesses.values() if guess is not None]
    recognised, tied = [], dict[str, list[str]]()
    for i in unnamed:
        guess, name = guesses[i], plain[i]
        fits = guess is not None and guess not in indices and _measures(file[i], guess)
        channel = str(guess) if fits and taken.count(str(guess)) == 1 else name
        if fits and taken.count(str(guess)) > 1:
            tied.setdefault(str(guess), []).append(name)
        if channel in indices:
            channel = file[i].name
        if channel in indices:
            example = f"columns={{{channel!r}: {indices[channel]}, {channel + ' 2'!r}: {i}}}"
            raise refuse(path, f"has two columns {shown(channel)}; name them by place, {example}")
        indices[channel] = i
        if channel != name:
            recognised.append(f"{channel} is {file[i].name!r}")
    for guess, names in tied.items():
        notes.append(f"{', '.join(names)} may each be {guess}; joint= says of which joint, columns= which column")
    if recognised:
        notes.append(f"channels were recognised by their names: {', '.join(recognised)}")
    return {channel: file[i] for channel, i in indices.items()}


def _in_order(path: Path, file: list[Column], columns: Sequence[str | None]) -> Roles:
    """Columns by names that are given in the order of the file; None leaves one out (FileError, ValueError)."""
    if len(columns) != len(file):
        raise refuse(path, f"has {len(file)} columns, and columns names {len(columns)}; give a name or None for each")
    names = ["" if name in (None, "-", "None") else str(name) for name in columns]
    twice = next((name for name in names if name and names.count(name) > 1), None)
    if twice is not None:
        raise ValueError(f"columns has {twice!r} twice; give each channel once")
    return {name: column for name, column in zip(names, file, strict=True) if name}


def _measures(column: Column, channel: str) -> bool:
    """True for a column whose unit, if it has one, can be that of a channel."""
    unit, kind = unit_of(column), expected(channel)
    return not unit or not kind or si_unit(unit) == kind


def in_si(path: Path, columns: Roles, units: Units, notes: list[str]) -> tuple[Roles, dict[str, str]]:
    """Columns in SI, and their units.

    Raises
    ------
    FileError
        If a unit does not fit the channel.
    ValueError
        If a unit is given for a channel that is not there.
    """
    for name, unit in units.items():
        if not isinstance(unit, str):
            number(f"the unit of {shown(name)}", unit)
    unknown = [name for name in units if name not in columns]
    if unknown:
        raise ValueError(
            f"units has {shown(unknown[0])}, and the channels are {joined(columns)}; name one of these, or "
            f"the column that is {shown(unknown[0])}, too"
        )
    result, si, assumed = dict[str, Column](), dict[str, str](), list[str]()
    for channel, column in columns.items():
        unit, kind = units.get(channel, unit_of(column)), expected(channel)
        if unit == "" and channel == "time" and (unit := epoch_unit(column.values)):
            notes.append(f"time begins with {column.values[0]:.14g}, which was read as {unit} since 1970")
        if unit == "" and kind.startswith("rad") and UNMEASURED.search(column.name):
            fault = f"{shown(column.name)} counts turns or steps of an encoder, and no unit says which; give"
            unit = "rev" if kind == "rad" else "rev/s"
            remedy = f"units={{{channel!r}: {unit!r}}}, or the size of 1 as '0.0879 deg'"
            raise refuse(path, f"{fault} {remedy}", what=channel)
        if unit == "":
            assumed += [f"{channel} in {kind}"] if kind else []
        elif isinstance(unit, str) and not (kind := kind or si_unit(unit) or ""):
            if channel in units:
                raise ValueError(f"units has {unit!r} for {channel!r}, which is not a unit of a channel; remove it")
            notes.append(f"{channel} is in {unit!r}, which is not converted")
            kind = unit
        else:
            try:
                column = replace(column, values=np.asarray(converted(column.values, unit, kind), float))
            except ValueError as error:
                fault = f"{error}; give units={{{channel!r}: {kind!r}}} if the file is wrong"
                raise refuse(path, fault, what=channel) from None
        result[channel], si[channel] = column, kind
    if assumed:
        notes.append(f"no unit is given for {', '.join(assumed)}: units= says what else they are")
    return result, si


def choice_of(log: Path, **given: Any) -> dict[str, Any]:
    """Arguments of read_log as given, completed by those kept beside a log unless columns are among them.

    "names" are the columns of the file that kept ones were chosen for.

    Raises
    ------
    FileError
        If the file beside the log holds no choice.
    """
    given = {name: value for name, value in given.items() if value not in (None, {})}
    kept = {} if "columns" in given else _kept_choice(choice_file(log))
    units = {**kept.get("units", {}), **given.get("units", {})}
    return kept | given | ({"units": units} if units else {})


def choice_file(log: Path) -> Path:
    """File with the choice of columns of a log, beside it."""
    return log.with_name(f"{log.name}.columns.json")


def keep_choice(log: Path, choice: Mapping[str, Any], names: list[str]) -> str:
    """Write the choice for a log with columns of these names beside it; a note on it."""
    path = choice_file(log)
    try:
        path.write_text(json.dumps({**choice, "names": names}, indent=1) + "\n", encoding="utf-8")
    except OSError as error:
        return f"the choice of columns is not saved: {path.name}: {error.strerror}"
    return f"the choice of columns is saved in {path.name}"


def _kept_choice(path: Path) -> dict[str, Any]:
    if not path.exists():
        return {}
    with suppress(OSError, ValueError, RecursionError):
        choice = json.loads(path.read_text(encoding="utf-8"))
        if isinstance(choice, dict) and "names" in choice and all(map(_is_argument, choice, choice.values())):
            return choice
    raise refuse(path, f"is no choice of {', '.join(ARGUMENTS)}; delete it, or give them anew")


def _is_argument(name: str, value: Any) -> bool:
    return isinstance(value, ARGUMENTS.get(name, ())) and not isinstance(value, bool)
