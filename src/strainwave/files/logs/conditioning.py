"""Steps from raw channels to a log; each adds a note where it changes anything."""

from itertools import takewhile
from pathlib import Path

import numpy as np

from ...base.number_text import counted
from ...base.quantities import numbers
from ...base.results import Floats
from ...study.identification.log import Log, LogSegment
from .names import TURN
from .table import Roles, refuse

SPARSE = 0.2  # share of missing values from which a channel has times of its own
TIMES_SHARE = 0.2  # of the samples: fewer are no times of theirs
COARSE, SAME_GRAIN = 0.05, 1e-3  # of a step: stamps rounded so are noise; of the grain: steps are multiples of it
TRANSIENT = 0.2  # share of a log that may come before the constant speed with which it ends

Channels = dict[str, Floats]
Apart = dict[str, tuple[Floats, Floats]]  # channels with times of their own


def aligned(path: Path, columns: Roles, rate: float | None, notes: list[str]) -> tuple[Floats, Channels, Apart]:
    """Time and channels of one length, finite, and those with times of their own as they are, which are interpolated.

    Rows with missing values are dropped.

    Raises
    ------
    FileError
        If there is no time, time runs backwards, or nothing is left.
    """
    columns = dict(columns)
    base = _time(path, columns, rate)
    together, apart = Channels(), Apart()
    for name, column in columns.items():
        finite = np.isfinite(column.values)
        if not np.any(finite):
            notes.append(f"{name} has no finite value and was omitted")
        elif column.time is not None:
            apart[name] = _ordered(path, name, column.time, column.values, notes)
        elif len(base) != len(finite):
            raise refuse(path, f"{name} has {len(finite)} values and the time {len(base)}; give it a time of its own")
        elif np.mean(~finite) > SPARSE:
            apart[name] = _ordered(path, name, base[finite], column.values[finite], notes)
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


def _time(path: Path, columns: Roles, rate: float | None) -> Floats:
    """Times that columns share [s], none where each has its own; the column of the time is taken out."""
    column = columns.pop("time", None)
    if rate is not None:
        if column is not None:
            raise ValueError("the file has a time column and rate is given; remove one of them")
        if not (np.isfinite(rate) and rate > 0.0):
            raise ValueError(f"rate is {rate}; give the samples per second, as 1000.0")
        lengths = [len(c.values) for c in columns.values() if c.time is None]
        return np.arange(max(lengths, default=0)) / rate
    if column is not None:
        return column.values
    if not columns or any(c.time is None for c in columns.values()):
        fault = f"has no column of the time; the channels are {', '.join(columns) or 'none'}"
        raise refuse(path, f"{fault}: give columns={{'time': ...}}, or rate")
    return np.empty(0)


def _finite(time: Floats, channels: Channels, notes: list[str]) -> tuple[Floats, Channels]:
    good = np.all(np.isfinite([time, *channels.values()]), axis=0)
    bad = len(good) - np.count_nonzero(good)
    if bad:
        notes.append(f"{bad} of {len(good)} rows contain inf or NaN and were omitted")
    return time[good], {name: values[good] for name, values in channels.items()}


def _ordered(path: Path, name: str, time: Floats, values: Floats, notes: list[str]) -> tuple[Floats, Floats]:
    """Times and values of one channel that has times of its own: finite, and of equal times the first sample alone."""
    timed, finite = np.isfinite(time), np.isfinite(values)
    if lost := int(np.sum(timed != finite)):  # where neither is finite, the channel has ended
        notes.append(f"{counted(lost, 'sample')} of {name} with inf or NaN omitted")
    time, values = time[timed & finite], values[timed & finite]
    _ascends(path, name, time)
    keep = np.append(True, np.diff(time) > 0.0)
    if again := int(np.sum(~keep)):
        notes.append(f"{counted(again, 'sample')} of {name} at the time of the one before left out")
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
    path: Path, time: Floats, together: Channels, apart: Apart, notes: list[str]
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
        own = f"{', '.join(apart)} had times of their own; runs use those times"
        notes.append(f"{own}; here they are interpolated linearly to the times of the log")
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
        f"the first {main.start - log.time[0]:.3g} s, before the constant speed, are a transient and were removed; "
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
        steps = np.diff(log.time)
        grain = float(np.min(np.diff(np.unique(steps.round(9))), initial=np.inf))
        if grain > COARSE * log.step and np.all(np.abs(steps / grain - np.round(steps / grain)) < SAME_GRAIN):
            notes.append(
                f"stamps are rounded to {1e3 * grain:.4g} ms, {100.0 * grain / log.step:.0f} % of a step, which is "
                "noise to every fit: log finer stamps, or where samples are regular give the rate in place of the time"
            )
