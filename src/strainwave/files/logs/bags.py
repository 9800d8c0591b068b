"""Logs in MCAP files: messages of ROS 2, and those in JSON."""

import json
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

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
        raise refuse(path, f"is no whole MCAP file ({reason}); `mcap recover` saves what is whole") from None
    series = {key: values for key, values in series.items() if len(values) > 1}
    if not series:
        raise refuse(path, "has no numbers in messages of ROS 2 or JSON; record the topics of the joints")
    topics = {topic for topic, _ in series}
    first = min(values[0][0] for values in series.values())
    columns = []
    for (topic, name), values in series.items():
        times, numbers = np.array([time - first for time, _ in values]), np.array([value for _, value in values], float)
        columns.append(Column(name if len(topics) == 1 else f"{topic}/{name}", "", numbers, 1e-9 * times))
    return columns, [f"topics in other encodings were left out: {', '.join(sorted(unread))}"] * bool(unread)


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
