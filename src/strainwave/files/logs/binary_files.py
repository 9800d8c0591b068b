"""Logs in binary files: NumPy, MATLAB, Parquet, MDF 4 and MCAP."""

import json
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from ...base.results import Floats
from .mat_file import NoReader, mat_variables
from .names import canonical, epoch_unit, named
from .table import Column, refuse

WIDEST = 64  # numbers of an array that become columns: more are an image or a map


def read_mcap(path: Path) -> tuple[list[Column], list[str]]:
    """Every number of every topic, with the times of its stamps; without a stamp those of the recorder."""
    try:
        reader, ros = import_module("mcap.reader"), import_module("mcap_ros2.decoder")
    except ImportError:
        raise ModuleNotFoundError("MCAP needs the extra `logs`: pip install 'strainwave[logs]'") from None
    series: dict[tuple[str, str], list[tuple[int, float]]] = {}
    unread = set[str]()
    try:
        with path.open("rb") as file:
            messages = reader.make_reader(file, decoder_factories=[ros.DecoderFactory(), _Others()])
            for _, channel, message, content in messages.iter_decoded_messages():
                if content is None:
                    unread.add(channel.topic)
                    continue
                time = _stamp(content) or message.log_time
                for name, value in _numbers(content, ""):
                    series.setdefault((channel.topic, name), []).append((time, value))
    except Exception as error:  # whatever a damaged file makes its reader raise
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise refuse(path, f"is not a complete MCAP file ({reason}); `mcap recover` saves the intact part") from None
    series = {key: values for key, values in series.items() if len(values) > 1}
    if not series:
        raise refuse(path, "has no numbers in messages of ROS 2 or JSON; record the topics of the joints")
    topics = {topic for topic, _ in series}
    first = min(values[0][0] for values in series.values())
    columns = []
    for (topic, name), values in series.items():
        times, numbers = np.array([time - first for time, _ in values]), np.array([value for _, value in values], float)
        columns.append(Column(name if len(topics) == 1 else f"{topic}/{name}", "", numbers, 1e-9 * times))
    return columns, [f"topics in other encodings were omitted: {', '.join(sorted(unread))}"] * bool(unread)


class _Others:
    """Decoders of messages that are none of ROS 2: JSON as it is, None of others."""

    def decoder_for(self, encoding: str, _schema: Any) -> Callable[[bytes], Any]:
        """The decoder of an encoding."""
        return json.loads if encoding == "json" else lambda _: None


def _fields(content: Any) -> dict[str, Any]:
    """Fields of a message by name."""
    if isinstance(content, dict):
        return content
    return {name: getattr(content, name) for name in getattr(content, "__slots__", ()) if not name.startswith("_")}


def _stamp(content: Any) -> int:
    """Time [ns] in the header of a message; 0 where it has none."""
    stamp = _fields(_fields(_fields(content).get("header")).get("stamp"))
    return int(stamp.get("sec", 0)) * 1_000_000_000 + int(stamp.get("nanosec", 0))


def _numbers(content: Any, name: str) -> Iterator[tuple[str, float]]:
    """Names and values of the numbers in a message; arrays beside an array `name` have its names, as of joints."""
    fields = _fields(content)
    joints: Any = fields.get("name")
    for field, value in fields.items():
        within = f"{name}.{field}" if name else field
        if isinstance(value, bool | int | float):
            yield within, float(value)
        elif field != "header" and _fields(value):
            yield from _numbers(value, within)
        elif isinstance(value, list | tuple | np.ndarray) and len(value) <= WIDEST:
            labelled = isinstance(joints, list | tuple) and field != "name" and len(joints) == len(value)
            for i, item in enumerate(value):
                label = f"{joints[i]}/{field}" if labelled else f"{within}[{i}]"
                if isinstance(item, bool | int | float | np.number):
                    yield label, float(item)
                elif _fields(item):
                    yield from _numbers(item, label)


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
    seconds = {time: _seconds(time, plain) for time in times}
    channels = {name: values for name, values in plain.items() if name not in times}
    columns = [Column(name, "", values, seconds.get(str(time_names[name]))) for name, values in channels.items()]
    left_out = [name for name, a in arrays.items() if name not in plain and a.size > 1]
    return columns, [f"{', '.join(left_out)} are not vectors of real numbers and were omitted"] if left_out else []


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
    return [_parquet_column(str(name), numbers[name]) for name in numbers], []


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


def _parquet_column(name: str, series: Any) -> Column:
    kind = series.dtype.kind
    if kind in "mM":
        return Column(name, "s", np.asarray(_in_seconds(series.to_numpy(f"{kind}8[ns]"))))
    return Column(name, "", np.asarray(series.to_numpy(float)))


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
    rows = [s for s in signals if np.ndim(s.samples) == 1 and len(s.samples) > 1 and canonical(str(s.name)) != "time"]
    if not rows:
        raise refuse(path, "has no channels of numbers; record one for each quantity")
    return [_mdf_column(signal) for signal in rows], []


def _mdf_column(signal: Any) -> Column:
    values, times = np.asarray(signal.samples, float), np.asarray(signal.timestamps, float)
    return Column(str(signal.name), str(signal.unit or ""), values, times)


def _unreadable(path: Path, error: Exception, kind: str) -> ValueError:
    reason = " ".join(str(error).split())[:120]
    return refuse(path, f"is not a complete {kind} file ({reason}); save it again")


BINARY: dict[str, Callable[[Path], Read]] = {
    ".npz": read_npz, ".mat": read_mat, ".parquet": read_parquet, ".mf4": read_mdf, ".mdf": read_mdf,
    ".mcap": read_mcap,
}  # fmt: skip
