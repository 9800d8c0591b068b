"""Run-up and coast-down: simulated speed steps through the range, each starting where the last one ended.

Where the two disagree the drive has two stable motions at one speed (hysteresis), and jumps between them.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..model.oscillator import Oscillator
from ..numerics.integrate import Dopri5
from ..results import Floats
from .regimes import OperatingPoint, Regime
from .steady import SteadyMotion, settle

EVEN, CLUSTER, FEW = (
    14,
    14,
    7,
)  # speeds over the whole range, near each primary resonance, and near each other one with a curve
SETTLE = 8.0  # in units of 1/mu: the transient falls to exp(-4) before the orbit is closed
TOLERANCE = Dopri5(rtol=1e-8, atol=1e-13)
UNDAMPED_PERIODS = 50
STEP, MOST_STEPS = 0.004, 8  # relative change of speed in one step of following a motion, and steps between two speeds


@dataclass(frozen=True, eq=False)
class RunUp:
    """Steady motions through the speed range, up and then down.

    Attributes
    ----------
    omega : (n,) array
        Speeds of the base angle [rad/s], ascending.
    up, down : tuple of SteadyMotion
        The motion at each of them, reached from below and from above.
    """

    omega: Floats
    up: tuple[SteadyMotion, ...]
    down: tuple[SteadyMotion, ...]

    def worst(self) -> SteadyMotion:
        """The motion with the largest |x|."""
        return max((*self.up, *self.down), key=lambda motion: motion.peak)

    def hysteresis(self) -> tuple[float, ...]:
        """Speeds [rad/s] at which the two directions end on motions whose peaks differ by more than 2 %."""
        pairs = zip(self.omega, self.up, self.down, strict=True)
        both = ((w, a.peak, b.peak) for w, a, b in pairs if a.status and b.status)
        return tuple(float(w) for w, a, b in both if abs(a - b) > 0.02 * max(a, b))


def settling_time(system: Oscillator) -> float:
    """Time [s] to wait for the transient; without damping it never goes, so a number of periods serves."""
    mu = system.B / system.J
    return SETTLE / mu if mu > 0.0 else UNDAMPED_PERIODS * 2.0 * math.pi / system.omega


def speed_grid(speeds: tuple[float, float], found: tuple[Regime, ...]) -> Floats:
    """Speeds [rad/s] for a run-up: even over the range, and close together around the resonances."""
    grid = [np.linspace(*speeds, EVEN)]
    for regime in found:
        primary = regime.name == "primary"
        if regime.inside and (primary or (regime.response is not None and regime.response.branches)):
            low, high = narrow_band(regime)
            grid.append(np.linspace(max(low, speeds[0]), min(high, speeds[1]), CLUSTER if primary else FEW))
    return np.unique(np.concatenate(grid))


def narrow_band(regime: Regime) -> tuple[float, float]:
    """Speeds [rad/s] between which the response curve stands above a fifth of its peak."""
    if regime.response is None or not regime.response.branches:
        return 0.95 * regime.omega, 1.05 * regime.omega
    branches = regime.response.branches
    omega = np.concatenate([branch.omega for branch in branches])
    amplitude = np.concatenate([branch.amplitude for branch in branches])
    high = omega[amplitude > 0.2 * np.max(amplitude)]
    margin = 0.1 * float(np.ptp(high)) + 1e-4 * regime.omega
    return float(np.min(high)) - margin, float(np.max(high)) + margin


def run_up(system: Oscillator, grid: Floats, point: OperatingPoint) -> Iterator[RunUp | float]:
    """Simulate up and down; yields the finished share after each speed, and the `RunUp` at the end.

    Between two speeds of the grid the motion is followed in smaller steps, so that it leaves its branch where
    the branch ends
    and not because a step was too large; there, and at the start, the drive is simulated until it settles.

    Parameters
    ----------
    system : Oscillator
        The error equation; its omega is replaced.
    grid : (n,) array
        Ascending speeds [rad/s].
    point : OperatingPoint
        Where the first simulation starts.
    """
    done: list[SteadyMotion] = []
    rest = (point.x, 0.0)
    for i, omega in enumerate(np.concatenate([grid, grid[::-1]])):
        if system.B <= 0.0 or not done or not done[-1].status:
            motion = _settled(system._replace(omega=float(omega)), rest)
        else:
            motion = _followed(system, done[-1], float(omega))
            if not motion.status:
                motion = _settled(system._replace(omega=float(omega)), rest)
        done.append(motion)
        yield (i + 1) / (2 * len(grid))
    yield RunUp(grid, tuple(done[: len(grid)]), tuple(reversed(done[len(grid) :])))


def _followed(system: Oscillator, motion: SteadyMotion, omega: float) -> SteadyMotion:
    """Motion at another speed, from that of the last one in steps of at most `STEP`."""
    steps = min(MOST_STEPS, math.ceil(abs(omega / motion.omega - 1.0) / STEP)) or 1
    for between in np.linspace(motion.omega, omega, steps + 1)[1:]:
        here = system._replace(omega=float(between))
        near = settle(here, motion.end, time=0.0, period=motion.period, method=TOLERANCE)
        motion = near if near.closed and near.stable else _settled(here, motion.end)
        if not motion.status:
            break
    return motion if motion.omega == omega else _settled(system._replace(omega=omega), motion.end)


def _settled(system: Oscillator, state: tuple[float, float]) -> SteadyMotion:
    """Motion that a simulation from `state` ends on: of period 1, or 2 or 3 where that does not close."""
    damped = system.B > 0.0
    motion = settle(system, state, time=settling_time(system), close=damped, method=TOLERANCE)
    for period in (2, 3):
        if motion.closed or not motion.status or not damped:
            break
        longer = settle(system, motion.end, time=0.0, period=period, method=TOLERANCE)
        if longer.closed:
            return longer
    return motion
