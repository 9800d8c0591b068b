"""One way through a resonance and the rides along it: many rates at once."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...model.laws.springs import Linear
from ...results import Floats
from ..slow_flow.fixed_points import Flow
from ..slow_flow.results import SlowResponse
from ..slow_flow.setting import Complexes
from .destinations import destinations
from .folds import Fold
from .linear import linear_passage
from .march import March, march
from .moving import moving_rates
from .results import DelayedJump

SAMPLES = 2001  # of a history
FINER = 10  # times as many points for the largest amplitude of the exact formula


@dataclass(frozen=True, eq=False)
class Way:
    """A passage at whatever rate.

    Attributes
    ----------
    flow, quick : Flow
        The slow flow at the first speed; the same with a table in place of samples, for many steps.
    response : SlowResponse
        Steady states between the two speeds.
    folds : tuple of Fold
        Where the drive may jump, in the order of the way.
    first, last : float
        Speeds of the base angle [rad/s].
    start : complex
        Steady state [rad] at the first speed.
    """

    flow: Flow
    quick: Flow
    response: SlowResponse
    folds: tuple[Fold, ...]
    first: float
    last: float
    start: complex

    @property
    def ahead(self) -> float:
        """1 for a run-up, -1 for a run-down."""
        return math.copysign(1.0, self.last - self.first)

    @property
    def size(self) -> float:
        """Amplitude [rad] that matters."""
        return max(self.response.peak[1], abs(self.start)) or max(self.flow.setting.scales())

    @property
    def linear(self) -> bool:
        """Whether the exact formula serves."""
        return isinstance(self.flow.setting.system.law, Linear)

    @cached_property
    def _besides(self) -> tuple[tuple[list[complex], int, float], ...]:
        """For each fold: stable states before it, which of them vanishes, and the amplitude after the jump."""
        found = []
        for fold in self.folds:
            before, _ = destinations(self.quick.at(fold.before), np.zeros(0, complex))
            vanishing = int(np.argmin([_apart(z, fold.z, self.flow.setting.copies) for z in before]))
            after, label = destinations(self.quick.at(fold.after), np.array([fold.z]))
            found.append((before, vanishing, abs(after[int(label[0])])))
        return tuple(found)

    def ride(self, rates: Floats) -> March:
        """Histories at many rates [rad/s^2, positive]: every lane from the first speed to the last."""
        signed, end = self.ahead * rates, abs(self.last - self.first) / rates
        if self.linear:
            return self._exactly(signed, end)

        def along(t: Floats, z: Complexes, lanes: Any) -> Complexes:
            rate = signed[lanes]
            return moving_rates(self.quick, self.first + rate * t, rate, z)

        return march(along, np.full(len(rates), self.start), end, SAMPLES, self.size)

    def _exactly(self, signed: Floats, end: Floats) -> March:
        t = end[:, None] * np.linspace(0.0, 1.0, FINER * (SAMPLES - 1) + 1)
        z = np.array([linear_passage(self.flow.setting, float(r), s) for r, s in zip(signed, t, strict=True)])
        top, lane = np.argmax(np.abs(z), axis=1), np.arange(len(t))
        return March(t[:, ::FINER], z[:, ::FINER], t[lane, top], z[lane, top])

    def jumps(self, rates: Floats, found: March) -> list[tuple[DelayedJump, ...]]:
        """Jumps of every lane: it is on the vanishing motion just before the fold, and half way to the next after."""
        jumps: list[list[DelayedJump]] = [[] for _ in rates]
        speeds = self.first + self.ahead * rates[:, None] * found.t
        for fold, (_, vanishing, remaining) in zip(self.folds, self._besides, strict=True):
            share = (fold.before - self.first) / (self.last - self.first) * (SAMPLES - 1)
            z = found.z[:, round(share)]
            _, label = destinations(self.quick.at(fold.before), z)
            half = 0.5 * (abs(fold.z) + remaining)
            side = math.copysign(1.0, remaining - abs(fold.z))
            for i in np.flatnonzero(label == vanishing).tolist():
                excess = side * (np.abs(found.z[i]) - half)
                at = np.flatnonzero((excess > 0.0) & (self.ahead * (speeds[i] - fold.omega) >= 0.0))
                if len(at):
                    now, then = at[0], max(at[0] - 1, 0)
                    share = min(1.0, excess[now] / max(excess[now] - excess[then], 1e-300))
                    omega = float(speeds[i, now] - share * (speeds[i, now] - speeds[i, then]))
                    delay = self.ahead * (omega - fold.omega)
                    jumps[i].append(DelayedJump(omega, fold.omega, delay, fold.delay(float(rates[i]))))
        return [tuple(some) for some in jumps]

    def jumped(self, rates: Floats) -> NDArray[np.bool_]:
        """Whether the drive jumps at each of many rates [rad/s^2]."""
        if not self.folds:
            return np.zeros(len(rates), bool)
        return np.array([len(some) > 0 for some in self.jumps(rates, self.ride(rates))], bool)


def _apart(z: complex, other: complex, copies: int) -> float:
    """Distance [rad] of two states whose copies by whole forcing periods count as one."""
    return float(np.min(np.abs(z * np.exp(2j * np.pi * np.arange(copies) / copies) - other)))
