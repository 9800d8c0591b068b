"""Record of a running integration: its samples in tables, and word of its progress in the log."""

import logging
from time import monotonic
from typing import Any

import numpy as np

from ...base.protocols import lacking
from ...base.quantities import States
from ...base.results import Floats, Status, Trajectory
from .workspace import Recording

log = logging.getLogger(__name__)

FIRST_STEPS, GROWTH, MOST_STEPS = (
    8192,
    8,
    1 << 20,
)  # steps that the tables hold: small for short runs, few for long ones


class Record:
    """Samples as columns of tables with the rows t, states, rates, and largest values: of one table for given times.

    Parameters
    ----------
    system : NamedTuple
        System that is integrated.
    times : (n,) array
        Start and end [s], or all times to record.
    spans : list of (float, float)
        Stretches between the corners; a time in the gap between two is recorded at the end of the first.
    y, rate : tuple of float
        State and its time derivative at the start, which are the first sample.
    sampled : bool
        True to record at the times, instead of every step.
    between : bool
        True if steps lie between these times, so that the largest values there are recorded too.
    """

    def __init__(
        self, system: Any, times: Floats, spans: Any, y: States, rate: States, sampled: bool, between: bool
    ) -> None:  # fmt: skip
        self.times, self.states, self.sampled, self.said = times, len(y), sampled, monotonic()
        self.t, self.full, self.filled = float(times[0]), list[Floats](), 1
        self.samples = np.array([times]) if sampled else np.empty((1, 0))
        if sampled and (len(spans) > 1 or spans[-1][1] < times[-1]):
            begins, ends = np.array(spans).T
            self.samples[0] = np.minimum(times, ends[np.maximum(np.searchsorted(begins, times, side="right") - 1, 0)])
        watched = len(system.watched(0.0, y)) if between and not lacking(system, "watched") else 0
        self.most, self.seen = np.zeros(between * (len(y) + watched)), np.empty((4, watched))
        self.table = np.empty((1 + 2 * len(y) + len(self.most), len(times) if sampled else FIRST_STEPS))
        self.table[:, 0] = (times[0], *y, *rate, *self.most)

    def room(self, steps: int) -> int:
        """Return how many of `steps` steps the table can record, after starting a new one where it is full."""
        if self.sampled:
            return steps
        if self.filled == self.table.shape[1]:
            self.full.append(self.table)
            self.table = np.empty((len(self.table), min(MOST_STEPS, GROWTH * self.filled)))
            self.filled = 0
        return min(steps, self.table.shape[1] - self.filled)

    def recording(self) -> Recording:
        """Arrays that a march fills: times, largest values since the last sample, what is watched, and the table."""
        return Recording(self.samples, self.most[None], self.seen, self.table)

    def keep(self, filled: int, t: float) -> None:
        """Take over what the kernel has filled up to the time t."""
        self.filled, self.t = filled, t
        if monotonic() - self.said >= 1.0:
            self.said = monotonic()
            start, end = self.times[[0, -1]]
            log.info("t = %.6g of %.6g s (%.0f %%)", t, end, 100.0 * (t - start) / (end - start))

    def go_on(self, t: float, y: Floats, rate: Floats) -> None:
        """Record the state just after a corner, where every step is recorded."""
        if not self.sampled:
            self.room(1)
            self.table[:, self.filled] = (t, *y, *rate)
            self.filled += 1

    def trajectory(self, status: Status, steps: int, rejected: int = 0, switches: int = 0) -> Trajectory:
        """Assemble the result with one sentence on how it ended."""
        if self.filled < self.table.shape[1] or self.full:
            self.table = np.concatenate([*self.full, self.table[:, : self.filled]], axis=1)
        n = self.states
        times, peaks = self.table[0], self.table[1 + 2 * n :]
        y, rate = self.table[1 : 1 + n], self.table[1 + n : 1 + 2 * n]
        if self.sampled:
            times[:] = self.times[: self.filled]
        message = status.value
        if status:
            times[-1] = self.times[-1]
        else:
            message = f"stopped at t = {self.t:.6g} s with the largest state {np.max(np.abs(y)):.3g}: {status.value}"
        largest = peaks if len(peaks) else None
        return Trajectory(times, y, rate, status, message, steps, rejected, switches, largest)


def uninterrupted(run: Trajectory) -> Trajectory:
    """Return a trajectory as it is, unless the user stopped it: a study of many runs then stops too."""
    if run.status is Status.INTERRUPTED:
        raise KeyboardInterrupt
    return run
