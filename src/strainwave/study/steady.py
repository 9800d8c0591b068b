"""Steady motion found by integration: settle, then close the orbit by shooting.

Used where a number must not depend on how long the transient is waited for: the article's steady harmonics and the points
that the response curves are checked against.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..numerics.integrate import Dopri5, simulate
from ..results import Floats, Status, Trajectory

SAMPLES = 256  # per period of the base angle
FARTHEST = 0.2  # a closing step larger than this share of the state may lead to another orbit


@dataclass(frozen=True, eq=False)
class SteadyMotion:
    """The motion that a simulation settles on.

    Attributes
    ----------
    omega : float
        Speed of the base angle [rad/s].
    period : int
        Number of base periods that the samples span.
    t, x, v, u : (n,) arrays
        Times [s] from the start of the span, dynamic error [rad], its rate [rad/s], and torsion [rad].
    peak : float
        Largest |x| [rad], 0-to-peak about zero.
    gap : float
        |state at the end - state at the start| relative to the state's size; 0 is a closed orbit.
    closed : bool
        Whether the motion repeats after `period` base periods (gap below 1e-6).
    stable : bool or None
        Whether all multipliers of the closed orbit lie inside the unit circle; None where it is not closed.
    status : Status
        Why the simulation stopped, if it did.
    message : str
        The sentence that belongs to `status`.
    """

    omega: float
    period: int
    t: Floats
    x: Floats
    v: Floats
    u: Floats
    peak: float
    gap: float
    closed: bool
    stable: bool | None
    status: Status
    message: str

    @property
    def end(self) -> tuple[float, float]:
        """State (x [rad], x' [rad/s]) at the end of the span, where a sweep goes on."""
        return float(self.x[-1]), float(self.v[-1])

    def amplitude(self, k: float) -> float:
        """0-to-peak amplitude [rad] of the component of x at k omega; k times `period` must be a whole number."""
        return self._component(self.x, k)

    def torsion_amplitude(self, k: float) -> float:
        """0-to-peak amplitude [rad] of the component of the torsion u at k omega."""
        return self._component(self.u, k)

    def _component(self, values: Floats, k: float) -> float:
        index = round(k * self.period)
        if abs(index - k * self.period) > 1e-9:
            raise ValueError(f"a motion over {self.period} periods has no component at {k} omega; take a longer period")
        spectrum = np.fft.rfft(values[:-1]) / (len(values) - 1)
        return float(abs(spectrum[index])) * (1.0 if index == 0 else 2.0)


def settle(
    system: Any,
    y0: tuple[float, float] = (0.0, 0.0),
    *,
    time: float,
    period: int = 1,
    close: bool = True,
    method: Dopri5 = Dopri5(),
) -> SteadyMotion:
    """Simulate for about `time`, then find the periodic motion next to where the simulation has come.

    Parameters
    ----------
    system : Oscillator
        A system of one degree of freedom with `omega` [rad/s].
    y0 : (2,) tuple
        Start (x [rad], x' [rad/s]).
    time : float
        Settling time [s], rounded up to whole base periods.
    period : int
        Base periods after which the motion is expected to repeat.
    close : bool
        Whether to close the orbit by Newton's method on the period map (shooting); with False the last simulated periods are
        returned as they are.
    method : Dopri5
        Tolerances of the integration.

    Returns
    -------
    SteadyMotion
        With `closed` False where the motion does not repeat (no damping, chaos, a longer period).

    References
    ----------
    Nayfeh & Balachandran 1995, Applied Nonlinear Dynamics, sec. 6.5 (shooting).
    """
    base = 2.0 * math.pi / system.omega
    turns = max(1, math.ceil(time / base)) * period
    run = finished_or_interrupted(simulate(system, y0, np.array([0.0, 0.5, 1.0]) * turns * base, method=method))
    start = (float(run.y[0, -1]), float(run.y[1, -1]))
    if not run.status:
        return _span(system, start, period, run.status, run.message, method)
    if close:
        start = _closed(system, start, period, method)
    return _span(system, start, period, Status.OK, run.message, method)


def finished_or_interrupted(run: Trajectory) -> Trajectory:
    """Return a trajectory as it is, unless the user stopped it: a study of many runs then stops too."""
    if run.status is Status.INTERRUPTED:
        raise KeyboardInterrupt
    return run


def _grid(system: Any, period: int) -> Floats:
    length = 2.0 * math.pi / system.omega * period
    order = max((1, *system.orders()))
    return np.linspace(0.0, length, SAMPLES * max(period, order) + 1)


def _mapped(system: Any, start: tuple[float, float], period: int, method: Dopri5) -> Floats | None:
    grid = _grid(system, period)
    run = finished_or_interrupted(simulate(system, start, grid[[0, len(grid) // 2, -1]], method=method))
    return run.y[:, -1] if run.status else None


def _matrix(system: Any, start: tuple[float, float], end: Floats, period: int, method: Dopri5) -> Floats | None:
    """Derivative of the period map, by forward differences of states that are `1e-5` apart."""
    size = max(abs(start[0]), abs(start[1]) / system.omega, 1e-9)
    steps = (1e-5 * size, 1e-5 * size * system.omega)
    columns = []
    for i, step in enumerate(steps):
        moved = (start[0] + step * (i == 0), start[1] + step * (i == 1))
        image = _mapped(system, moved, period, method)
        if image is None:
            return None
        columns.append((image - end) / step)
    return np.array(columns).T


def _closed(system: Any, start: tuple[float, float], period: int, method: Dopri5) -> tuple[float, float]:
    """Newton's method on the period map; the simulated state is kept where it does not help."""
    best, best_gap = start, math.inf
    for _ in range(6):
        end = _mapped(system, start, period, method)
        if end is None:
            return best
        miss = end - np.array(start)
        scale = np.array([1.0, 1.0 / system.omega])
        gap = float(np.linalg.norm(miss * scale))
        size = float(np.linalg.norm(np.array(start) * scale)) + 1e-300
        if gap < best_gap:
            best, best_gap = start, gap
        if gap < 1e-10 * size or gap > best_gap:
            return best
        matrix = _matrix(system, start, end, period, method)
        if matrix is None or abs(np.linalg.det(matrix - np.eye(2))) < 1e-9:
            return best
        step = np.linalg.solve(matrix - np.eye(2), -miss)
        if float(np.linalg.norm(step * scale)) > FARTHEST * size:
            return best
        start = (start[0] + float(step[0]), start[1] + float(step[1]))
    return best


def _span(
    system: Any, start: tuple[float, float], period: int, status: Status, message: str, method: Dopri5
) -> SteadyMotion:
    run = finished_or_interrupted(simulate(system, start, _grid(system, period), method=method))
    if status and not run.status:
        status, message = run.status, run.message
    x, v = run.y
    u = x - system.error.value(system.omega * run.t)
    scale = max(float(np.max(np.abs(x))), 1e-300)
    gap = float(np.hypot(x[-1] - x[0], (v[-1] - v[0]) / system.omega)) / scale
    closed = bool(status) and gap < 1e-6
    stable = None
    if closed:
        matrix = _matrix(system, start, run.y[:, -1], period, method)
        stable = None if matrix is None else bool(np.max(np.abs(np.linalg.eigvals(matrix))) < 1.0)
    return SteadyMotion(
        system.omega, period, run.t, x, v, u, run.peak(), gap, closed, stable, status, message
    )
