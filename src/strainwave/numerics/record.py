"""The recorded samples of a running integration, and word of its progress.

An integration that takes longer than a second logs once a second how far it is, at level INFO on the logger
`strainwave.numerics.record`; the library prints nothing, the command line shows what is logged on standard error.
"""

import logging
from time import monotonic
from typing import Any

import numpy as np

from ..results import Floats, Status, Trajectory

log = logging.getLogger(__name__)

FIRST, GROWTH, LARGEST = 8192, 8, 1 << 20  # steps that the tables hold: small for short runs, few for long ones


class Record:
    """Samples as columns of tables with the rows t, states, rates: of one table when the sample times are given.

    Parameters
    ----------
    t, t_end : float
        Start and end [s].
    y, rate : tuple of float
        State and its time derivative at the start, which are the first sample.
    samples : int
        Number of sample times, the start among them; 0 records every step.
    """

    def __init__(self, t: float, t_end: float, y: Any, rate: Any, samples: int) -> None:
        self.t, self.t_start, self.t_end, self.said = t, t, t_end, monotonic()
        self.states, self.samples, self.full = len(y), samples, list[Floats]()
        self.table = np.empty((1 + 2 * len(y), samples or FIRST))
        self.table[:, 0] = (t, *y, *rate)
        self.filled = 1

    def room(self, steps: int) -> int:
        """Return how many of `steps` steps the table can record, after starting a new one where it is full."""
        if self.samples:
            return steps
        if self.filled == self.table.shape[1]:
            self.full.append(self.table)
            self.table = np.empty((len(self.table), min(LARGEST, GROWTH * self.filled)))
            self.filled = 0
        return min(steps, self.table.shape[1] - self.filled)

    def buffers(self) -> tuple[Floats, Floats, Floats]:
        """Times, states and rates of the table, for the kernel to fill."""
        return self.table[0], self.table[1 : 1 + self.states], self.table[1 + self.states :]

    def keep(self, filled: int, t: float) -> None:
        """Take over what the kernel has filled up to the time t."""
        self.filled, self.t = filled, t
        if monotonic() - self.said >= 1.0:
            self.said = monotonic()
            percent = 100.0 * (t - self.t_start) / (self.t_end - self.t_start)
            log.info("t = %.6g of %.6g s (%.0f %%)", t, self.t_end, percent)

    def trajectory(self, status: Status, steps: int, rejected: int = 0, switches: int = 0) -> Trajectory:
        """Assemble the result with one sentence on how it ended."""
        if self.filled < self.table.shape[1] or self.full:
            self.table = np.concatenate([*self.full, self.table[:, : self.filled]], axis=1)
        times, y, rate = self.buffers()
        message = status.value
        if not status:
            message = f"stopped at t = {self.t:.6g} s with the largest state {np.max(np.abs(y)):.3g}: {status.value}"
        return Trajectory(times, y, rate, status, message, steps, rejected, switches)
