"""Logs from files."""

from pathlib import Path

from ...study.identification.logs.log import Log
from ..yaml_text import as_path
from .binary import BINARY
from .choice import Columns, Units, chosen, in_si
from .conditioning import aligned, averaged, regular, trimmed, unwrapped
from .plausibility import doubts
from .table import Column, read_table, refuse

WRONG_GEAR = 0.02  # relative difference of measured and given ratio


def read_log(
    path: str | Path,
    columns: Columns | None = None,
    units: Units | None = None,
    *,
    rate: float | None = None,
    ratio: float | None = None,
    trim: float | tuple[float, float] | None = None,
    unwrap: bool = True,
    delimiter: str | None = None,
    decimal: str | None = None,
) -> Log:
    """Read measured channels from a file.

    What is guessed or changed stands in `notes` of the log, and every argument overrides a guess. What is not plausible
    stands in `doubts`.

    Parameters
    ----------
    path : str or Path
        Text (CSV in any dialect, UTF-8, UTF-16 with its mark, or else Windows-1252; lines that begin with #, % or //
        are comments; dates of ISO 8601 become seconds since the first), NumPy (`.npz`), MATLAB up to version 7
        (`.mat`), Parquet (`.parquet`, extra `logs`) or MDF 4 (`.mf4`, extra `logs`).
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
    trim : float or (float, float), optional
        Seconds to leave out at the begin, or at both ends. Default: in a log that ends at constant speed what comes
        before it, up to a fifth of the log; 0 keeps all.
    unwrap : bool
        Whether angles that jump by a turn are made continuous.
    delimiter, decimal : str, optional
        Column separator (" " for any number of blanks) and decimal sign of a text. Default: those with which the text
        is a table; where this is so in two ways, the file is refused.

    Returns
    -------
    Log
        In SI and radians, without repeated times and values that are not finite.

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
    path = as_path(path)
    if path.suffix.lower() in BINARY:
        if not path.is_file():
            raise refuse(path, "does not exist, or is no file; check the name and the folder")
        file, notes = BINARY[path.suffix.lower()](path)
    else:
        count = None if columns is None or hasattr(columns, "keys") else len(columns)
        file, notes = read_table(path, delimiter, decimal, count)
    log = _log(path, file, columns, units or {}, rate, unwrap, notes)
    if ratio is not None:
        _check_ratio(path, log, ratio, notes)
    log = trimmed(log, trim, notes)
    regular(log, notes)
    return Log(log.time, log.channels, log.units, tuple(notes), doubts(log))


def _log(
    path: Path, file: list[Column], columns: Columns | None, units: Units, rate: float | None, unwrap: bool,
    notes: list[str],
) -> Log:  # fmt: skip
    picked, si = in_si(path, chosen(path, file, columns, notes), units, notes)
    time, channels = aligned(path, picked, rate, notes)
    if unwrap:
        channels = unwrapped(channels, si, notes)
    time, channels = averaged(time, channels, notes)
    return Log(time, channels, {name: si[name] for name in channels})


def _check_ratio(path: Path, log: Log, ratio: float, notes: list[str]) -> None:
    found = log.ratio
    if found is None:
        notes.append(f"the ratio {ratio:g} cannot be checked: that takes the motion of both shafts")
    elif abs(found / ratio - 1.0) > WRONG_GEAR:
        raise refuse(
            path,
            f"is the log of another gear: its motor turns {found:.5g} times as far as its load, and the ratio is "
            f"{ratio:g}; give its own ratio or its own file",
            what="ratio",
        )
