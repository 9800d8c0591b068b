"""Channels of a log, or of a dictionary, as the rows and the records that an identification needs."""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ...base.number_text import counted
from ...base.quantities import joined, numbers, shown
from ...base.results import Floats
from .experiment import Experiment, Record
from .run import refuse_descending

TWIST_SHARE, TWIST_RAD = 0.1, 0.02  # of the load's turn, and rad: what a gear may twist

FEWEST_SAMPLES = 16  # samples of a record
STEP_SCATTER = 0.05  # of a step: what a time may be off by
LEAST_SIGNAL, LARGEST_SIGNAL = 1e-30, 1e30  # of a signal, in any unit


def channels_of(log: Any) -> dict[str, Any]:
    """Time and channels of a log, or of a dictionary of arrays."""
    return dict(log) if isinstance(log, Mapping) else {"time": log.time, **log.channels}


def refuse_missing(where: str, names: Iterable[str], channels: Mapping[str, Any], remedy: str) -> None:
    """Refuse channels without one of the names (ValueError); `where` ends in a verb, as "the log has"."""
    for name in names:
        if name not in channels:
            raise ValueError(f"{where} no channel {name!r}; {remedy}")


def record_of(setup: Experiment, channels: Mapping[str, Any], index: int | None) -> Record:
    """Record of the channels that an experiment needs; `index` is the place of their log among several."""
    label = "log" if index is None else f"log {index}"
    needed = "time", *setup.inputs.values(), *setup.outputs.values()
    refuse_missing(f"{label} has", needed, channels, f"it has {joined(channels)}")
    time = numbers(f"{label}: time", channels["time"])
    if len(time) < FEWEST_SAMPLES:
        raise ValueError(f"{label} has {len(time)} samples; give {FEWEST_SAMPLES} at least")
    step = even_step(label, time)
    rows = {name: input_row(label, name, channels[name]) for name in setup.inputs.values()}
    rows |= {name: row_of(label, name, channels[name]) for name in setup.outputs.values()}
    refuse_lengths(label, rows, len(time))
    for state, name in setup.outputs.items():
        measured = rows[name][np.isfinite(rows[name])]
        if len(measured) < FEWEST_SAMPLES:
            raise ValueError(f"{label}: {name} has {len(measured)} values; give {FEWEST_SAMPLES} at least")
        if not np.ptp(measured) > LEAST_SIGNAL:
            raise ValueError(f"{label}: {name} is {measured[0]:g} throughout: nothing moves; use a record with motion")
        if f"{state}.delay" in setup.free and len(measured) < len(time):
            gaps = counted(len(time) - len(measured), "gap")
            raise ValueError(f"{label}: {name} has {gaps}, and its delay is a free parameter: fill or remove the gaps")
    inputs = np.array([rows[name] for name in setup.inputs.values()]).reshape(len(setup.inputs), len(time))
    outputs = np.array([rows[name] for name in setup.outputs.values()])
    outputs[~np.isfinite(outputs)] = np.nan
    return Record(inputs, outputs, step)


def row_of(label: str, name: str, values: Any) -> Floats:
    """One channel (n,) of real numbers, NaN where nothing was measured (ValueError)."""
    try:
        array = np.asarray(values)
    except ValueError:  # rows of different lengths
        array = np.array([None])
    if array.ndim != 1 or array.dtype.kind not in "iufb":
        raise ValueError(
            f"{label}: {name} has the shape {array.shape} and values such as {shown(values)[:40]}; give one row of "
            "real numbers"
        )
    with np.errstate(over="ignore"):
        row = array.astype(float)
    if np.any(np.abs(row[np.isfinite(row)]) > LARGEST_SIGNAL):
        raise ValueError(f"{label}: {name} has values beyond {LARGEST_SIGNAL:g}; give it in SI")
    return row


def with_torsion(channels: Mapping[str, Any], N: float) -> dict[str, Any]:
    """Channels with the torsion theta_m/N - theta_l [rad]; a load that turns against the motor is counted with it.

    Raises
    ------
    ValueError
        If an angle is missing, or the angles are not those of a gear of this ratio.
    """
    names = "motor_angle", "load_angle"
    refuse_missing("log has", names, channels, f"it has {joined(channels)}: name the column of it")
    motor, load = [row_of("log", name, channels[name]) for name in names]
    if motor.shape != load.shape:
        raise ValueError(f"log: motor_angle has {len(motor)} samples and load_angle {len(load)}; give equally many")
    finite = np.isfinite(motor) & np.isfinite(load)
    if np.count_nonzero(finite) < 2:
        raise ValueError("log: motor_angle and load_angle have no two samples in common; give both at the same times")
    sense = -1.0 if np.cov(motor[finite], load[finite])[0, 1] < 0.0 else 1.0
    torsion = motor / N - sense * load
    turned, twisted = float(np.ptp(load[finite])), float(np.ptp(torsion[finite]))
    if twisted > max(TWIST_SHARE * turned, TWIST_RAD):
        raise ValueError(
            f"log: motor_angle turns {np.ptp(motor[finite]):.4g} rad and load_angle {turned:.4g} rad: the ratio is not "
            f"{N:g}; use the gear of the log, or give both angles on their own shafts"
        )
    return {**channels, "torsion": torsion}


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


def even_step(label: str, time: Floats) -> float:
    """Mean step [s] of two times or more, which must ascend by equal steps (ValueError)."""
    refuse_descending(time, f"{label}: time")
    steps = np.diff(time)
    step = float(time[-1] - time[0]) / (len(time) - 1)
    if np.max(np.abs(time - time[0] - step * np.arange(len(time)))) > STEP_SCATTER * float(np.median(steps)):
        raise ValueError(
            f"{label}: time has steps from {np.min(steps):g} to {np.max(steps):g} s; resample to equal steps"
        )
    return step
