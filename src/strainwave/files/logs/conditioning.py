"""Logs in binary files: NumPy, MATLAB, Parquet, MDF 4 and MCAP.

What is done to raw channels before they are a log: each step adds a note where it changes anything.
"""

from collections.abc import Callable
from importlib import import_module
from itertools import takewhile
from pathlib import Path
from typing import Any

import numpy as np

from ...base.quantities import numbers
from ...base.results import Floats
from ...base.sentences import counted
from ...study.identification.log import Log, LogSegment
from .bags import read_mcap
from .mat_file import NoReader, mat_variables
from .names import TURN, canonical, epoch_unit, named
from .table import Column, refuse

Read = tuple[list[Column], list[str]]


def read_npz(path: Path) -> Read:
    """Arrays of a NumPy file; dates count from the first."""
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as stored:
            arrays = {name: _in_seconds(stored[name]) for name in stored.files}
    except Exception as error:  # whatever a damaged file makes its reader raise
        raise _unreadable(path, error, ".npz") from None
    return _columns(path, arrays)


def read_mat(path: Path) -> Read:
    """Variables and fields of structs of a MATLAB file."""
    try:
        content = mat_variables(path)
    except NoReader:
        raise
    except NotImplementedError:
        raise refuse(path, "is a MATLAB file of version 7.3; save it with -v7") from None
    except Exception as error:  # as above
        raise _unreadable(path, error, ".mat") from None
    arrays: dict[str, Any] = {}
    for name, value in content.items():
        if not name.startswith("__"):
            _flattened(name, value, arrays)
    return _columns(path, arrays)


def _in_seconds(values: Any) -> Any:
    """Dates as seconds since the first of them, durations as seconds, NaN where there is none; others as they are."""
    if values.dtype.kind not in "mM" or not values.size:
        return values
    flat = values.astype(f"{values.dtype.kind}8[ns]")
    valid = flat[~np.isnat(flat)]
    since = flat if flat.dtype.kind == "m" or not valid.size else flat - valid[0]
    return np.where(np.isnat(since), np.nan, since.astype(np.int64) * 1e-9)


def _flattened(name: str, value: object, arrays: dict[str, Any]) -> None:
    for field in getattr(value, "_fieldnames", ()):
        _flattened(f"{name}.{field}", getattr(value, field), arrays)
    if isinstance(value, np.ndarray) and value.dtype.names is None:
        arrays[name] = value


def _columns(path: Path, arrays: dict[str, Any]) -> Read:
    """Vectors as columns; each goes with the vector of the time that has its length, or its own, `NAME_time`."""
    for name in [name for name, a in arrays.items() if a.dtype.kind == "c"]:
        vector = arrays.pop(name)
        arrays |= {f"{name}_real": vector.real, f"{name}_imaginary": vector.imag}
    plain = {name: np.ravel(a).astype(float) for name, a in arrays.items() if _is_vector(a)}
    if not plain:
        raise refuse(path, "has no vectors of numbers; save one for each channel, and `time`")
    time_names = {name: _time_of(name, plain) for name in plain}
    times = {time for time in time_names.values() if time is not None}
    for name, time in time_names.items():
        if time is not None and len(plain[time]) != len(plain[name]):
            raise refuse(path, f"{name} has {len(plain[name])} values and {time} {len(plain[time])}; give equally many")
    columns = [
        Column(name, "", values, None if time_names[name] is None else _seconds(str(time_names[name]), plain))
        for name, values in plain.items()
        if name not in times
    ]
    left_out = [name for name, a in arrays.items() if name not in plain and a.size > 1]
    return columns, [f"{', '.join(left_out)} are no vectors of real numbers and were left out"] if left_out else []


def _is_vector(values: Any) -> bool:
    return values.dtype.kind in "iufb" and np.ndim(np.squeeze(values)) == 1 and values.size > 1


def _time_of(name: str, arrays: dict[str, Floats]) -> str | None:
    plain = named(name).name
    names = f"{plain}_time", f"time_{plain}", f"t_{plain}", f"{plain}_t"
    return next((other for other in arrays if named(other).name in names), None)


def _seconds(name: str, arrays: dict[str, Floats]) -> Floats:
    unit = named(name).unit or epoch_unit(arrays[name])
    return arrays[name] * {"ms": 1e-3, "us": 1e-6, "ns": 1e-9}.get(unit, 1.0)


def read_parquet(path: Path) -> Read:
    """Columns of numbers and dates of a Parquet file."""
    pandas = import_module("pandas")
    try:
        frame = pandas.read_parquet(path)
    except ImportError:
        raise ModuleNotFoundError("Parquet needs the extra `logs`: pip install 'strainwave[logs]'") from None
    except Exception as error:
        raise _unreadable(path, error, ".parquet") from None
    index = frame.index
    if index.name is not None and canonical(named(str(index.name)).name) == "time":
        frame = frame.reset_index()
    frame = _without_lists(pandas, frame)
    numbers = frame.select_dtypes(["number", "datetime", "datetimetz", "timedelta"])
    if numbers.empty:
        raise refuse(path, "has no columns of numbers; save one for each channel, and `time`")
    kinds = [numbers[name].dtype.kind for name in numbers]
    return [
        Column(str(name), "s" if kind in "mM" else "", _parquet_column(numbers[name], kind))
        for name, kind in zip(numbers, kinds, strict=True)
    ], []


def _without_lists(pandas: Any, frame: Any) -> Any:
    """A table with a column of numbers for each item of a column of lists, `name[0]` and so on, as LeRobot has."""
    parts = []
    for name in frame:
        lists = [np.size(value) for value in frame[name]] if frame[name].dtype == object else []
        if lists and min(lists) == max(lists) > 1 and not isinstance(frame[name].iloc[0], str):
            items = np.stack(frame[name].to_numpy())
            parts.append(pandas.DataFrame(items, frame.index, [f"{name}[{i}]" for i in range(lists[0])]))
        else:
            parts.append(frame[[name]])
    return pandas.concat(parts, axis=1) if parts else frame


def _parquet_column(series: Any, kind: str) -> Floats:
    return np.asarray(_in_seconds(series.to_numpy(f"{kind}8[ns]")) if kind in "mM" else series.to_numpy(float))


def read_mdf(path: Path) -> Read:
    """Channels of an MDF file with the times and units that it gives them."""
    try:
        asammdf = import_module("asammdf")
    except ImportError:
        raise ModuleNotFoundError("MDF needs the extra `logs`: pip install 'strainwave[logs]'") from None
    try:
        with asammdf.MDF(str(path)) as file:
            signals = [signal for signal in file.iter_channels() if np.asarray(signal.samples).dtype.kind in "iufb"]
    except Exception as error:  # as above
        raise _unreadable(path, error, "MDF") from None
    columns = [
        Column(str(s.name), str(s.unit or ""), np.asarray(s.samples, float), np.asarray(s.timestamps, float))
        for s in signals
        if np.ndim(s.samples) == 1 and len(s.samples) > 1
    ]
    columns = [column for column in columns if canonical(column.name) != "time"]
    if not columns:
        raise refuse(path, "has no channels of numbers; record one for each quantity")
    return columns, []


def _unreadable(path: Path, error: Exception, kind: str) -> ValueError:
    reason = " ".join(str(error).split())[:120]
    return refuse(path, f"is no whole {kind} file ({reason}); save it again")


BINARY: dict[str, Callable[[Path], Read]] = {
    ".npz": read_npz, ".mat": read_mat, ".parquet": read_parquet, ".mf4": read_mdf, ".mdf": read_mdf,
    ".mcap": read_mcap,
}  # fmt: skip


SPARSE = 0.2  # share of missing values from which a channel has times of its own
TIMES_SHARE = 0.2  # of the samples: fewer are no times of theirs
TRANSIENT = 0.2  # share of a log that may come before the constant speed with which it ends

Channels = dict[str, Floats]


def aligned(
    path: Path, columns: dict[str, Column], rate: float | None, notes: list[str]
) -> tuple[Floats, Channels, dict[str, tuple[Floats, Floats]]]:
    """Time and channels of one length, finite, and those with times of their own as they are, which are interpolated.

    Rows with missing values are dropped.

    Raises
    ------
    FileError
        If there is no time, time runs backwards, or nothing is left.
    """
    columns = dict(columns)
    base = _time(path, columns, rate)
    together, apart = Channels(), dict[str, tuple[Floats, Floats]]()
    for name, column in columns.items():
        finite = np.isfinite(column.values)
        if not np.any(finite):
            notes.append(f"{name} has no finite value and was left out")
        elif column.time is not None:
            apart[name] = _ordered(path, name, column.time, column.values)
        elif len(base) != len(finite):
            raise refuse(path, f"{name} has {len(finite)} values and the time {len(base)}; give it a time of its own")
        elif np.mean(~finite) > SPARSE:
            apart[name] = _ordered(path, name, base, column.values)
        else:
            together[name] = column.values
    if together:
        time, together = _finite(base, together, notes)
    elif apart:
        time, _ = max(apart.values(), key=lambda channel: len(channel[0]))
    else:
        raise refuse(path, "has no channel with finite values beside the time; is it the right file?")
    _ascends(path, "time", time)
    return *_interpolated(path, time, together, apart, notes), apart


def _time(path: Path, columns: dict[str, Column], rate: float | None) -> Floats:
    """Times that columns share [s], none where each has its own; the column of the time is taken out."""
    column = columns.pop("time", None)
    if rate is not None:
        if column is not None:
            raise ValueError("the file has a time and rate is given; leave out rate, or the column of the time")
        if not (np.isfinite(rate) and rate > 0.0):
            raise ValueError(f"rate is {rate}; give the samples per second, as 1000.0")
        lengths = [len(c.values) for c in columns.values() if c.time is None]
        return np.arange(max(lengths, default=0)) / rate
    if column is not None:
        return column.values
    if not columns or any(c.time is None for c in columns.values()):
        channels = ", ".join(columns) or "none"
        raise refuse(
            path, f"has no column of the time; the channels are {channels}: give columns={{'time': ...}}, or rate"
        )
    return np.empty(0)


def _finite(time: Floats, channels: Channels, notes: list[str]) -> tuple[Floats, Channels]:
    good = np.all(np.isfinite([time, *channels.values()]), axis=0)
    bad = len(good) - np.count_nonzero(good)
    if bad:
        notes.append(f"{bad} of {len(good)} rows hold inf or NaN and were left out")
    return time[good], {name: values[good] for name, values in channels.items()}


def _ordered(path: Path, name: str, time: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Times and values of one channel that has times of its own."""
    good = np.isfinite(time) & np.isfinite(values)
    time, values = time[good], values[good]
    _ascends(path, name, time)
    keep = np.append(True, np.diff(time) > 0.0)
    return time[keep], values[keep]


def _ascends(path: Path, name: str, time: Floats) -> None:
    if len(time) < 2:
        raise refuse(path, f"has {counted(len(time), 'sample')}; a log has two or more", what=name)
    back = np.flatnonzero(np.diff(time) < 0.0)
    if len(back):
        i = int(back[0])
        fault = f"runs backwards, from {time[i]:.9g} to {time[i + 1]:.9g} s after sample {i + 1}"
        raise refuse(path, f"{fault}; sort the lines, or make a file of each run", what="time")
    if time[-1] == time[0]:
        raise refuse(path, f"stands still at {time[0]:.9g} s; is it the right column?", what="time")


def _interpolated(
    path: Path, time: Floats, together: Channels, apart: dict[str, tuple[Floats, Floats]], notes: list[str]
) -> tuple[Floats, Channels]:
    """All channels at the times of `time` that they have in common."""
    low = max([time[0], *(t[0] for t, _ in apart.values())])
    high = min([time[-1], *(t[-1] for t, _ in apart.values())])
    inside = (time >= low) & (time <= high)
    if np.count_nonzero(inside) < 2:
        raise refuse(path, "has channels that have no time in common; read them as logs of their own")
    channels = {name: values[inside] for name, values in together.items()}
    time = time[inside]
    for name, (t, values) in list(apart.items()):
        channels[name] = np.interp(time, t, values)
        if len(t) == len(time) and np.array_equal(t, time):
            del apart[name]
    if apart:
        note = (
            "had times of their own, at which runs take them; here they are interpolated linearly to those of the log"
        )
        notes.append(f"{', '.join(apart)} {note}")
    return time, channels


def unwrapped(channels: Channels, units: dict[str, str], notes: list[str]) -> Channels:
    """Angles without jumps of a whole turn."""
    result = dict(channels)
    for name, values in channels.items():
        steps = np.diff(values)
        jumps = np.abs(steps) > 0.5 * TURN
        if units.get(name) != "rad" or not np.any(jumps):
            continue
        left = np.abs(steps[jumps]) - TURN * np.round(np.abs(steps[jumps]) / TURN)
        if np.max(np.abs(left)) < 1.0 and np.all(np.round(np.abs(steps[jumps]) / TURN) == 1.0):
            result[name] = np.unwrap(values)
            notes.append(f"{name} wraps at a whole turn and was unwrapped, {np.count_nonzero(jumps)} times")
    return result


def averaged(path: Path, time: Floats, channels: Channels, notes: list[str]) -> tuple[Floats, Channels]:
    """Samples at equal times as one, their mean."""
    times, group, count = np.unique(time, return_inverse=True, return_counts=True)
    if len(times) == len(time):
        return time, channels
    if len(times) < TIMES_SHARE * len(time):
        fault = f"has {len(times)} times for {len(time)} samples; name another column, or give rate"
        raise refuse(path, fault, what="time")
    again = counted(len(time) - len(times), "sample")
    notes.append(f"{again} at the time of the one before: averaged with it")
    return times, {name: np.bincount(group, values) / count for name, values in channels.items()}


def trimmed(log: Log, trim: float | tuple[float, float] | None, notes: list[str]) -> Log:
    """The log without the transients at its ends.

    Raises
    ------
    ValueError
        If `trim` is neither one nor two numbers, or leaves nothing.
    """
    if trim is not None:
        head, tail = numbers("trim [s]", trim if isinstance(trim, list | tuple) else (trim, 0.0), count=2)
        return log.cut(log.time[0] + head, log.time[-1] - tail) if head or tail else log
    if not log.moving:
        return log
    parts = log.segments()
    steady = list(takewhile(lambda part: _continues(part, parts[-1]), reversed(parts)))
    main = steady[-1] if steady else parts[0]
    if main is parts[0] or main.start - log.time[0] > TRANSIENT * (log.time[-1] - log.time[0]):
        return log
    notes.append(
        f"the first {main.start - log.time[0]:.3g} s, before the constant speed, are a transient and were left out; "
        "trim=0 keeps them"
    )
    return log.cut(start=main.start)


def _continues(part: LogSegment, last: LogSegment) -> bool:
    """True for a stretch of the same constant speed as the last one."""
    return part.kind == last.kind == "constant speed" and abs(part.speed - last.speed) < 0.1 * abs(last.speed)


def regular(log: Log, notes: list[str]) -> None:
    """Note missing samples, and a variation of the steps of time."""
    gaps = log.gaps
    if gaps:
        longest = max(gap.stop - gap.start for gap in gaps)
        first = gaps[0].start
        notes.append(f"{counted(len(gaps), 'gap')}, the longest of {longest:.4g} s, the first at {first:.6g} s")
    if log.jitter > 0.01 * log.step:
        notes.append(f"steps of the time vary by {100.0 * log.jitter / log.step:.2g} % (one standard deviation)")
