"""One way through a resonance and the rides along it: many rates at once.

Passage of a linear drive at a constant rate, exactly. Folds of the steady response on the way of a passage, and the
delay of the jump at them.
"""

import cmath
import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ai_zeros, wofz

from ....base.results import Floats
from ....model.laws.springs import Linear
from ..fixed_points import Flow
from ..results import SlowResponse
from ..setting import Complexes, Setting
from .basins import March, destinations, march, refuse_turned
from .moving import DelayedJump, moving_rates

SAMPLES = 2001  # of a history
FORGOTTEN = 28.0  # of 1/mu, after which the free vibration is 1e-6 of what it was
FINER = 10  # times as many points for the largest amplitude of the exact formula

AIRY = -float(ai_zeros(1)[0][0])
STEP, SPEED_STEP = 1e-3, 1e-5  # of the amplitude and of the speed: differences
BESIDE = 0.02  # of the distance to the next fold: so far beside a fold its states are looked up


@dataclass(frozen=True, eq=False)
class Fold:
    """A fold of the steady response at which the drive may jump.

    Attributes
    ----------
    omega, z : float, complex
        Speed [rad/s] and state [rad].
    before, after : float
        Speeds [rad/s] next to it, on the side of its two states and on the other one.
    lag : float
        Delay of the jump over rate^(2/3) [(rad/s)^(-1/3) s^(1/3)], to leading order.
    """

    omega: float
    z: complex
    before: float
    after: float
    lag: float

    def delay(self, rate: float) -> float:
        """Delay [rad/s] of the jump at a rate [rad/s^2]."""
        return float(self.lag * rate ** (2.0 / 3.0))


def folds_ahead(flow: Flow, response: SlowResponse, first: float, last: float) -> list[Fold]:
    """Folds whose states vanish in the direction from `first` to `last` [rad/s], in the order of the way."""
    ahead = 1.0 if last > first else -1.0
    folds = []
    for branch in response.branches:
        for omega in response.folds:
            places = np.flatnonzero(branch.omega == omega)
            inside = places[(places > 0) & (places < len(branch.omega) - 1)]
            if not len(inside) or ahead * (branch.omega[inside[0] - 1] - omega) > 0.0:
                continue
            z = complex(branch.amplitude[inside[0]] * np.exp(-1j * branch.phase[inside[0]]))
            marks = [w for w in (*response.folds, first, last) if w != omega]
            distance = ahead * BESIDE * min(abs(w - omega) for w in marks)
            folds.append(Fold(omega, z, omega - distance, omega + distance, _lag(flow, omega, z)))
    return sorted(folds, key=lambda fold: ahead * fold.omega)


def _lag(flow: Flow, omega: float, z: complex) -> float:
    """Delay over rate^(2/3), by differences of the rates at the fold."""

    def rates(w: float, x: complex) -> complex:
        return complex(flow.at(w).rates(np.array([x]))[0])

    h, d = STEP * abs(z), SPEED_STEP * omega
    by_re = (rates(omega, z + h) - rates(omega, z - h)) / (2.0 * h)
    by_im = (rates(omega, z + 1j * h) - rates(omega, z - 1j * h)) / (2.0 * h)
    matrix = np.array([[by_re.real, by_im.real], [by_re.imag, by_im.imag]])
    values, right = np.linalg.eig(matrix)
    slow = int(np.argmin(np.abs(values)))
    v = right[:, slow].real
    left = np.linalg.inv(right)[slow].real
    push = (rates(omega + d, z) - rates(omega - d, z)) / (2.0 * d)
    along = h * complex(*v)
    bend = (rates(omega, z + along) + rates(omega, z - along) - 2.0 * rates(omega, z)) / (2.0 * h * h)
    product = abs((left @ [push.real, push.imag]) * (left @ [bend.real, bend.imag]))
    return AIRY * product ** (-1.0 / 3.0) if product > 0.0 else float("inf")


def linear_passage(s: Setting, rate: float, t: Floats) -> Complexes:
    """Slow state z [rad] at times t [s] of a run from the steady state at s.omega with a rate [rad/s^2] of omega.

    Parameters
    ----------
    s : Setting
        Linear drive at its first speed, with a soft line.
    rate : float
        Change of the base speed [rad/s^2], of either sign, not 0.
    t : (n,) array
        Times [s] from 0 on.
    """
    ratio = s.fast / s.omega
    root = cmath.sqrt(0.25 * s.mu**2 - s.omega_0**2)
    roots = -0.5 * s.mu + root, -0.5 * s.mu - root
    first, second = [_convolved(lam, s.fast, ratio * rate, t) for lam in roots]
    x = (first - second) / (2.0 * root)
    slope = (roots[0] * first - roots[1] * second) / (2.0 * root)
    on_torque = np.sum(s.torque_lines[s.on_fast]) / s.system.J
    on_error = np.sum(s.error_lines[s.on_fast])
    return np.asarray(on_torque * x - on_error * (1.0 - s.mu * slope - s.omega_0**2 * x))


def _convolved(lam: complex, fast: float, rate: float, t: Floats) -> Any:
    """exp(lam t) convolved with E, over E: from the steady state at time 0."""
    now = lam - 1j * (fast + rate * t)
    then = lam - 1j * fast
    s = math.sqrt(0.5 * abs(rate)) * cmath.exp(-0.25j * math.pi * math.copysign(1.0, rate))
    scale = math.sqrt(math.pi) / (2.0 * s)
    kept = np.exp(lam * t - 1j * (fast * t + 0.5 * rate * t * t))
    return scale * (wofz(-0.5j * now / s) - kept * wofz(-0.5j * then / s)) - kept / then


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
        states = []
        for fold in self.folds:
            before, _ = destinations(self.quick.at(fold.before), np.zeros(0, complex))
            vanishing = int(np.argmin([_apart(z, fold.z, self.flow.setting.copies) for z in before]))
            after, label = destinations(self.quick.at(fold.after), np.array([fold.z]))
            states.append((before, vanishing, abs(after[int(label[0])])))
        return tuple(states)

    def ride(self, rates: Floats) -> March:
        """Histories at many rates [rad/s^2, positive]: every lane from the first speed to the last."""
        signed, end = self.ahead * rates, abs(self.last - self.first) / rates
        if self.linear:
            return self._exactly(signed, end)

        s = self.flow.setting
        long = np.minimum(end, FORGOTTEN / s.mu)
        refuse_turned(float(np.max(0.5 * s.fast / s.omega * rates * long**2)))

        def along(t: Floats, z: Complexes, lanes: NDArray[np.int64]) -> Complexes:
            rate = signed[lanes]
            return moving_rates(self.quick, self.first + rate * t, rate, z)

        return march(along, np.full(len(rates), self.start), end, SAMPLES, self.size)

    def _exactly(self, signed: Floats, end: Floats) -> March:
        t = end[:, None] * np.linspace(0.0, 1.0, FINER * (SAMPLES - 1) + 1)
        z = np.array([linear_passage(self.flow.setting, float(r), s) for r, s in zip(signed, t, strict=True)])
        top, lane = np.argmax(np.abs(z), axis=1), np.arange(len(t))
        return March(t[:, ::FINER], z[:, ::FINER], t[lane, top], z[lane, top])

    def jumps(self, rates: Floats, motions: March) -> list[tuple[DelayedJump, ...]]:
        """Jumps of every lane: it is on the vanishing motion just before the fold, and half way to the next after."""
        jumps: list[list[DelayedJump]] = [[] for _ in rates]
        speeds = self.first + self.ahead * rates[:, None] * motions.t
        for fold, (_, vanishing, remaining) in zip(self.folds, self._besides, strict=True):
            share = (fold.before - self.first) / (self.last - self.first) * (SAMPLES - 1)
            z = motions.z[:, round(share)]
            _, label = destinations(self.quick.at(fold.before), z)
            half = 0.5 * (abs(fold.z) + remaining)
            side = math.copysign(1.0, remaining - abs(fold.z))
            for i in np.flatnonzero(label == vanishing).tolist():
                excess = side * (np.abs(motions.z[i]) - half)
                reached = np.flatnonzero((excess > 0.0) & (self.ahead * (speeds[i] - fold.omega) >= 0.0))
                if len(reached):
                    k, before = reached[0], max(reached[0] - 1, 0)
                    share = min(1.0, excess[k] / max(excess[k] - excess[before], 1e-300))
                    omega = float(speeds[i, k] - share * (speeds[i, k] - speeds[i, before]))
                    delay = self.ahead * (omega - fold.omega)
                    jumps[i].append(DelayedJump(omega, fold.omega, delay, fold.delay(float(rates[i]))))
        return [tuple(lane) for lane in jumps]

    def jumped(self, rates: Floats) -> NDArray[np.bool_]:
        """Whether the drive jumps at each of many rates [rad/s^2]."""
        if not self.folds:
            return np.zeros(len(rates), bool)
        return np.array([len(some) > 0 for some in self.jumps(rates, self.ride(rates))], bool)


def _apart(z: complex, other: complex, copies: int) -> float:
    """Distance [rad] of two states whose copies by whole forcing periods count as one."""
    return float(np.min(np.abs(z * np.exp(2j * np.pi * np.arange(copies) / copies) - other)))
