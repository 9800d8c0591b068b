"""`read_log`: a log from a file in any format, with notes on what was guessed and doubts about what is implausible."""

import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...base.quantities import number
from ...study.identification.log import Log
from .assignment import Columns, Units, choice_file, choice_of, chosen, in_si, keep_choice
from .binary_files import BINARY, Read
from .conditioning import aligned, averaged, regular, trimmed, unwrapped
from .doubts import doubts
from .joints import joined_stamps, joints_named, of_joint, only_joint
from .table import Column, read_table, refuse, unit_of

WRONG_GEAR = 0.02  # relative difference of measured and given ratio
UNITLESS_STEP_S = 0.5  # whole numbers without a unit that go on by more may be in ms


def read_log(
    path: str | os.PathLike[str],
    columns: Columns | None = None,
    units: Units | None = None,
    *,
    rate: float | None = None,
    ratio: float | None = None,
    joint: str | None = None,
    trim: float | tuple[float, float] | None = None,
    unwrap: bool = True,
    delimiter: str | None = None,
    decimal: str | None = None,
    keep: bool = False,
) -> Log:
    """Read measured channels from a file.

    `notes` of the log hold every guess and change, and every argument overrides a guess. `doubts` hold what is not
    plausible.

    Parameters
    ----------
    path : str or Path
        Text (CSV in any dialect, UTF-8, UTF-16 with its mark, or else Windows-1252, gzipped too; lines that begin with
        #, % or // are comments; dates of ISO 8601 become seconds since the first), guide log of PHD2, NumPy (`.npz`),
        MATLAB up to version 7 (`.mat`), or, with the extra `logs`, Parquet (`.parquet`), MDF 4 (`.mf4`), MCAP of ROS 2
        (`.mcap`).
    columns : mapping or sequence, optional
        Channels and their columns, {"load_angle": "position"} or {"load_angle": 1} with places from 0 on; or a name for
        each column in its order, None for one to leave out. "time" is the time. Columns that a mapping does not name
        are recognised by the names in the file.
    units : mapping, optional
        Units by channel, {"load_angle": "deg"}; or what 1 in the file is, "0.088 deg", or a number in SI. Default: what
        the file says, else SI.
    rate : float, optional
        Samples per second [Hz] of a file without a time.
    ratio : float, optional
        Ratio of the gear: a log of motor and load angles of another gear is refused.
    joint : str, optional
        Word of the columns of one joint among those of several: "elbow", "axis0", "1".
    trim : float or (float, float), optional
        Seconds to leave out at the begin, or at both ends. Default: in a log that ends at constant speed what comes
        before it, up to a fifth of the log; 0 keeps all.
    unwrap : bool
        True to make angles continuous that jump by a turn.
    delimiter, decimal : str, optional
        Column separator (" " for any number of blanks) and decimal sign of a text. Default: those with which the text
        is a table; where this is so in two ways, the file is refused.
    keep : bool
        True to keep columns, units, rate and joint beside the file: a later reading takes each that it is not given,
        all where it is given no columns.

    Returns
    -------
    Log
        `channels` by name over `time` [s], in SI and radians as `units` says, without repeated times and values that
        are not finite; `notes` on what reading guessed.

    Raises
    ------
    FileError
        If the file cannot be read or is of another gear; a ValueError with one line `file:line:column: field: fact,
        value, remedy`.
    ValueError
        If an argument is wrong.
    ModuleNotFoundError
        If the library for a format is not installed.
    """
    path = Path(path)
    choice = choice_of(path, columns=columns, units=units, rate=rate, joint=joint)
    chosen_for, given = choice.pop("names", None), any((columns, units, rate, joint))
    columns, units, rate, joint = map(choice.get, ("columns", "units", "rate", "joint"))
    count = None if columns is None or isinstance(columns, Mapping) else len(columns)
    file, notes = columns_of(path, delimiter, decimal, count)
    names = [column.name for column in file]
    if chosen_for is not None and chosen_for != names:
        raise refuse(choice_file(path), f"does not match the columns of {path.name}; delete it, or name the columns")
    notes += [] if chosen_for is None else [f"columns and units were read from {choice_file(path).name}"]
    joint = only_joint(file) if joint is None and columns is None else joint
    if joint is not None:
        file = of_joint(path, file, joint)
    log = _log(path, file, columns, {} if units is None else units, rate, unwrap, notes)
    if ratio is not None:
        _check_ratio(path, log, number("ratio", ratio, positive=True), notes)
    log = trimmed(log, trim, notes)
    regular(log, notes)
    doubted = doubts(log)
    if keep and given:
        notes.append(keep_choice(path, choice, names))
    new = [doubt for doubt in log.doubts if not any("'time'" in other for other in doubted)]
    return replace(log, notes=tuple(notes), doubts=(*doubted, *new))


def columns_of(path: Path, delimiter: str | None, decimal: str | None, count: int | None = None) -> Read:
    """Columns of a file, binary or text, and notes about what was guessed; `count` as of `read_table`."""
    if path.suffix.lower() not in BINARY:
        file, notes, _ = read_table(path, delimiter, decimal, count)
        return joined_stamps(joints_named(file), notes), notes
    if not path.is_file():
        raise refuse(path, "does not exist, or is no file; check the name and the folder")
    return BINARY[path.suffix.lower()](path)


def _log(
    path: Path, file: list[Column], columns: Columns | None, units: Units, rate: float | None, unwrap: bool,
    notes: list[str],
) -> Log:  # fmt: skip
    named_columns = chosen(path, file, columns, notes)
    bare = "time" in named_columns and not units.get("time", unit_of(named_columns["time"]))
    picked, si = in_si(path, named_columns, units, notes)
    time, channels, separate = aligned(path, picked, rate, notes)
    if unwrap:
        channels = unwrapped(channels, si, notes)
        separate = {name: (t, unwrapped({name: v}, si, [])[name]) for name, (t, v) in separate.items()}
    time, channels = averaged(path, time, channels, notes)
    step = float(np.median(np.diff(time)))
    asked = bare and step >= UNITLESS_STEP_S and bool(np.all(time == np.round(time)))
    doubt = f"time goes on by {step:g} a sample and has no unit: is it in ms? units={{'time': 'ms'}}"
    units_si = {name: si[name] for name in channels}
    return Log(time, channels, units_si, doubts=(doubt,) if asked else (), own=separate)


def _check_ratio(path: Path, log: Log, ratio: float, notes: list[str]) -> None:
    log_ratio = log.ratio
    if log_ratio is None:
        notes.append(f"the ratio {ratio:g} cannot be checked: the check needs the motion of both shafts")
    elif abs(log_ratio / ratio - 1.0) > WRONG_GEAR:
        fact = f"its motor turns {log_ratio:.5g} times as far as its load, and the ratio is {ratio:g}"
        raise refuse(path, f"is the log of another gear: {fact}; give its own ratio or its own file", what="ratio")
