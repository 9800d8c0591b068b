"""Logs from files.

Doubts about a log: channels that contradict each other, saturate, or do not move; with the likely reason. Which column
of a file is which channel, and in which unit.
"""

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import isclose, pi
from pathlib import Path

import numpy as np

from ...base.quantities import joined, number, shown
from ...base.results import Floats
from ...study.identification.log import Log
from ...study.identification.run import saturated
from .binary_files import BINARY, Read
from .choice import ENDING, kept_choice
from .conditioning import aligned, averaged, regular, trimmed, unwrapped
from .joints import joined_stamps, joints_named, of_joint, only_joint
from .names import UNMEASURED, canonical, converted, epoch_unit, expected, named, si_unit, suffixed
from .table import Column, Roles, index_of, read_table, refuse, unit_of

WRONG_GEAR = 0.02  # relative difference of measured and given ratio

SPEED_TOLERANCE = 0.2  # relative: angle and integral of the speed
FACTOR_TOLERANCE = 0.03  # relative: to a factor between units
SLOW, SLOWEST = 3600.0, 0.5  # s, a sample of a log of a drive, surely and where no unit is given
MOTION_RAD = 1e-5  # rad: less is no motion
# What an angle grows relative to the integral of the speed when one of them is in another unit than was read.
FACTORS = (
    (180.0 / pi, "angle", "deg"),
    (pi / 180.0, "speed", "deg/s"),
    (pi / 30.0, "speed", "rpm"),
    (30.0 / pi, "speed", "rad/s"),
    (1.0 / (2.0 * pi), "angle", "rev"),
    (2.0 * pi, "speed", "rev/s"),
    (6.0, "angle", "deg"),  # and the speed in rpm
    (1e-3, "time", "ms"),
    (1e-6, "time", "us"),
    (1e3, "time", "s"),
)

Columns = Mapping[str, str | int] | Sequence[str | None]
Units = Mapping[str, str | float]
EXAMPLE = {"load_angle": "deg"}


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
        notes.append(f"columns of text were left out: {', '.join(filter(None, words))}")
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
                raise ValueError(f"units has {unit!r} for {channel!r}, which is no unit of a channel; leave it out")
            notes.append(f"{channel} is in {unit!r}, which is left as it is")
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


def doubts(log: Log) -> tuple[str, ...]:
    """Sentences on implausible channels."""
    sentences = []
    if log.step > SLOW:
        sentences.append(f"time goes on by {log.step:.4g} s a sample: is it in ms, us or ns? units={{'time': 'ms'}}")
    for shaft in ("motor", "load"):
        angle, speed = log.channels.get(f"{shaft}_angle"), log.channels.get(f"{shaft}_speed")
        if angle is not None and float(np.ptp(angle)) < MOTION_RAD:
            sentences.append(f"{shaft}_angle stays within {np.ptp(angle):.2g} rad: nothing moves")
        elif angle is not None and speed is not None:
            sentences += _growth(log, shaft, angle, speed)
        if angle is not None:
            sentences += _jumps(log, f"{shaft}_angle", angle)
    for name, values in log.channels.items():
        if (unit := log.units[name]) not in ("rad", "rad/s"):
            for level, extreme, share in saturated(values):
                of_all = f"{100.0 * share:.2g} % of the samples"
                sentences.append(f"{name} has its {extreme} value, {level:.6g} {unit}, in {of_all}: saturated?")
    return tuple(sentences)


def _growth(log: Log, shaft: str, angle: Floats, speed: Floats) -> list[str]:
    """Sentence on an angle that does not grow as its speed says."""
    steps = np.diff(log.time)
    integral = np.append(0.0, np.cumsum(0.5 * (speed[1:] + speed[:-1]) * steps))
    far = integral - np.mean(integral)
    if np.dot(far, far) == 0.0:
        return [f"{shaft}_speed is 0 throughout and {shaft}_angle moves; is it the right column?"]
    factor = float(np.dot(far, angle) / np.dot(far, far))
    if abs(factor - 1.0) <= SPEED_TOLERANCE:
        return []
    fact = f"{shaft}_angle grows {factor:.4g} times as fast as {shaft}_speed says"
    for ratio, kind, unit in FACTORS:
        if isclose(abs(factor), ratio, rel_tol=FACTOR_TOLERANCE):
            name = "time" if kind == "time" else f"{shaft}_{kind}"
            return [f"{fact}: {name} is probably in {unit}, units={{{name!r}: {unit!r}}}"]
    if isclose(factor, -1.0, rel_tol=FACTOR_TOLERANCE):
        return [f"{fact}: their directions differ"]
    large = max(abs(factor), 1.0 / abs(factor)) if factor else 0.0
    if 20.0 < large < 400.0 and abs(large - round(large)) < 0.02 * large:
        return [f"{fact}: they may be on the two sides of a gear of ratio {round(large)}"]
    return [f"{fact}: check their units and columns"]


def _jumps(log: Log, name: str, angle: Floats) -> list[str]:
    steps = np.abs(np.diff(angle))
    steps = steps[(np.diff(log.time) < 1.5 * log.step) & (steps > pi)]
    if not len(steps):
        return []
    size = float(np.median(steps))
    if isclose(size, 360.0, rel_tol=0.05):
        return [f"{name} jumps by {size:.4g} rad: it is probably in deg, units={{{name!r}: 'deg'}}"]
    return [f"{name} jumps by more than half a turn {len(steps)} times: check its unit, or sample faster"]


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
) -> Log:
    """Read measured channels from a file.

    `notes` of the log hold every guess and change, and every argument overrides a guess. `doubts` hold what is not
    plausible. Without columns, units, rate and joint, those that a command kept beside the file are taken.

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
    kept = {} if columns or units or rate or joint else kept_choice(path)
    columns, units = kept.get("columns", columns), kept.get("units", units)
    rate, joint = kept.get("rate", rate), kept.get("joint", joint)
    count = None if columns is None or isinstance(columns, Mapping) else len(columns)
    file, notes = columns_of(path, delimiter, decimal, count)
    notes += [f"columns are those chosen in {path.name}{ENDING}"] if kept else []
    joint = only_joint(file) if joint is None and columns is None else joint
    if joint is not None:
        file = of_joint(path, file, joint)
    log = _log(path, file, columns, {} if units is None else units, rate, unwrap, notes)
    if ratio is not None:
        _check_ratio(path, log, number("ratio", ratio, positive=True), notes)
    log = trimmed(log, trim, notes)
    regular(log, notes)
    doubted = doubts(log)
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
    asked = bare and step >= SLOWEST and bool(np.all(time == np.round(time)))
    doubt = f"time goes on by {step:g} a sample and has no unit: is it in ms? units={{'time': 'ms'}}"
    units_si = {name: si[name] for name in channels}
    return Log(time, channels, units_si, doubts=(doubt,) if asked else (), own=separate)


def _check_ratio(path: Path, log: Log, ratio: float, notes: list[str]) -> None:
    log_ratio = log.ratio
    if log_ratio is None:
        notes.append(f"the ratio {ratio:g} cannot be checked: that takes the motion of both shafts")
    elif abs(log_ratio / ratio - 1.0) > WRONG_GEAR:
        fact = f"its motor turns {log_ratio:.5g} times as far as its load, and the ratio is {ratio:g}"
        raise refuse(path, f"is the log of another gear: {fact}; give its own ratio or its own file", what="ratio")
