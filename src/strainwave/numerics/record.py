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


class Record:
    """Samples in pieces of a step budget, or in one array when the sample times are given.

    Parameters
    ----------
    t, t_end : float
        Start and end [s].
    y, rate : tuple of float
        State and its time derivative at the start.
    samples : int
        Number of sample times after the start; 0 records every step.
    """

    def __init__(self, t: float, t_end: float, y: Any, rate: Any, samples: int) -> None:
        self.first = (np.array([t]), np.array([y]).T, np.array([rate]).T)
        self.pieces: list[tuple[Floats, ...]] = [self.first]
        self.samples, self.states, self.filled = samples, len(y), 0
        self.t, self.t_end = t, t_end
        self.out: tuple[Floats, ...] = ()
        self.said = monotonic()

    def buffers(self, budget: int) -> tuple[Floats, ...]:
        """Arrays (times, states, rates) for the kernel: one for all samples, or one for each piece of steps."""
        if not self.out:
            n = self.samples or budget
            self.out = (np.empty(n), np.empty((self.states, n)), np.empty((self.states, n)))
        return self.out

    def keep(self, filled: int, t: float) -> None:
        """Take over what the kernel has filled up to the time t."""
        self.t = t
        if self.samples:
            self.filled = filled
        else:
            self.pieces.append(tuple(a[..., :filled] for a in self.out))
            self.out = ()
        if monotonic() - self.said >= 1.0:
            self.said = monotonic()
            start = float(self.first[0][0])
            log.info("t = %.6g of %.6g s (%.0f %%)", t, self.t_end, 100.0 * (t - start) / (self.t_end - start))

    def trajectory(self, status: Status, steps: int, rejected: int = 0, switches: int = 0) -> Trajectory:
        """Assemble the result with one sentence on how it ended."""
        if self.samples:
            self.pieces = [self.first, tuple(a[..., : self.filled] for a in self.out)] if self.out else [self.first]
        times, y, rate = (np.concatenate(parts, axis=-1) for parts in zip(*self.pieces, strict=True))
        message = status.value
        if not status:
            message = f"stopped at t = {self.t:.6g} s with the largest state {np.max(np.abs(y)):.3g}: {status.value}"
        return Trajectory(times, y, rate, status, message, steps, rejected, switches)
