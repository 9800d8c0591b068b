"""Channels of a log, or of a dictionary, as the records that an experiment needs."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...quantities import numbers, shown
from ...results import Floats
from .experiment import Experiment, Record

FEWEST = 16  # samples of a record
UNEVEN = 0.05  # of a step: what a time may be off by
LEAST, LARGEST = 1e-30, 1e30  # of a signal, in any unit


def channels_of(log: Any) -> dict[str, Any]:
    """Time and channels of a log, or of a dictionary of arrays."""
    if isinstance(log, Mapping):
        return dict(log)
    if not hasattr(log, "channels"):
        raise TypeError(f"log is {shown(log)}; give a Log (see read_log) or a dictionary of arrays by channel")
    return {"time": log.time, **log.channels}


def record_of(of: Experiment, channels: Mapping[str, Any], number_of: int | None) -> Record:
    """Record of the channels that an experiment needs."""
    where = "log" if number_of is None else f"log {number_of}"
    for name in ("time", *of.inputs.values(), *of.outputs.values()):
        if name not in channels:
            raise ValueError(f"{where} has no channel {name!r}; it has {', '.join(channels)}")
    time = numbers(f"{where}: time", channels["time"])
    if len(time) < FEWEST:
        raise ValueError(f"{where} has {len(time)} samples; give {FEWEST} at least")
    step = even_step(where, time)
    rows = {name: input_row(where, name, channels[name]) for name in of.inputs.values()}
    rows |= {name: row_of(where, name, channels[name]) for name in of.outputs.values()}
    refuse_lengths(where, rows, len(time))
    for state, name in of.outputs.items():
        known = rows[name][np.isfinite(rows[name])]
        if len(known) < FEWEST:
            raise ValueError(f"{where}: {name} has {len(known)} values; give {FEWEST} at least")
        if not np.ptp(known) > LEAST:
            raise ValueError(f"{where}: {name} is {known[0]:g} throughout; nothing moves: give a record with motion")
        if f"{state}.delay" in of.free and len(known) < len(time):
            raise ValueError(
                f"{where}: {name} has {len(time) - len(known)} gaps, and a delay of it is free: fill or cut them"
            )
    inputs = np.array([rows[name] for name in of.inputs.values()]).reshape(len(of.inputs), len(time))
    outputs = np.array([rows[name] for name in of.outputs.values()])
    outputs[~np.isfinite(outputs)] = np.nan
    return Record(inputs, outputs, step)


def row_of(where: str, name: str, values: Any) -> Floats:
    """One channel (n,) of real numbers, NaN where nothing was measured (ValueError)."""
    given = np.asarray(values)
    if given.ndim != 1 or given.dtype.kind not in "iufb":
        raise ValueError(
            f"{where}: {name} has the shape {given.shape} and values such as {shown(values)[:40]}; give one row of "
            "real numbers"
        )
    row = given.astype(float)
    if np.any(np.abs(row[np.isfinite(row)]) > LARGEST):
        raise ValueError(f"{where}: {name} has values beyond {LARGEST:g}; give it in SI")
    return row


def input_row(where: str, name: str, values: Any) -> Floats:
    """One channel (n,) that is known at all samples (ValueError)."""
    row = row_of(where, name, values)
    if not np.all(np.isfinite(row)):
        i = int(np.flatnonzero(~np.isfinite(row))[0])
        raise ValueError(f"{where}: {name} is {row[i]} at sample {i}; an input must be known at all samples")
    return row


def refuse_lengths(where: str, rows: Mapping[str, Floats], samples: int) -> None:
    """Refuse channels that have not as many samples as the time (ValueError)."""
    for name, row in rows.items():
        if len(row) != samples:
            raise ValueError(f"{where}: {name} has {len(row)} samples and time {samples}; give equally many")


def even_step(where: str, time: Floats) -> float:
    """Mean step [s] of two times or more, which must ascend by equal steps (ValueError)."""
    steps = np.diff(time)
    if not np.all(steps > 0.0):
        i = int(np.flatnonzero(steps <= 0.0)[0])
        raise ValueError(f"{where}: time {time[i + 1]:g} s of sample {i + 1} stands after {time[i]:g} s; let it ascend")
    step = float(time[-1] - time[0]) / (len(time) - 1)
    if np.max(np.abs(time - time[0] - step * np.arange(len(time)))) > UNEVEN * float(np.median(steps)):
        raise ValueError(
            f"{where}: time has steps from {np.min(steps):g} to {np.max(steps):g} s; resample to equal steps"
        )
    return step
