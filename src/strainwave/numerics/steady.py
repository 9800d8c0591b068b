"""Steady motion found by integration: settle, then close the orbit by shooting.

Used where a number must not depend on how long the transient is waited for: the article's steady harmonics and the
points that the response curves are checked against.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.results import Floats, Status, Trajectory
from .balance.harmonics import highest_order
from .integration.methods import Dopri5
from .integration.record import uninterrupted
from .integration.simulate import simulate
from .shooting import closed_state

TIGHT = Dopri5()
SAMPLES = 256  # per period of the base angle
LONGER = (1, 2, 4, 8, 16, 32)  # settling times more, where a motion does not repeat yet: beside a fold it takes many
CLOSED = 1e-6  # relative gap of a closed orbit
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
    z : (internal states, n) array
        Internal states of a law with memory.
    peak : float
        Largest |x| [rad], 0-to-peak about zero.
    gap : float
        |state at the end - state at the start| relative to the state's size; 0 is a closed orbit.
    closed : bool
        True if the motion repeats after `period` base periods (gap below 1e-6).
    stable : bool or None
        True if all multipliers of the closed orbit lie inside the unit circle; None where it is not closed.
    status : Status
        Reason for the stop of the simulation, if it stopped.
    message : str
        The sentence that belongs to `status`.
    """

    omega: float
    period: int
    t: Floats
    x: Floats
    v: Floats
    u: Floats
    z: Floats
    peak: float
    gap: float
    closed: bool
    stable: bool | None
    status: Status
    message: str

    @property
    def end(self) -> tuple[float, ...]:
        """State (x [rad], x' [rad/s], z ...) at the end of the span, where a sweep goes on."""
        return (float(self.x[-1]), float(self.v[-1]), *self.z[:, -1].tolist())

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
    y0: tuple[float, ...] = (0.0, 0.0),
    *,
    time: float,
    period: int = 1,
    close: bool = True,
    method: Dopri5 = TIGHT,
) -> SteadyMotion:
    """Simulate for about `time`, then find the periodic motion next to where the simulation has come.

    Parameters
    ----------
    system : Oscillator
        A system of one degree of freedom with `omega` [rad/s].
    y0 : tuple
        Start (x [rad], x' [rad/s]), then the internal states of a law with memory.
    time : float
        Settling time [s], rounded up to whole spans of `period` base periods; 0 starts to close the orbit at y0.
    period : int
        Base periods after which the motion is expected to repeat.
    close : bool
        True to close the orbit by Newton's method on the period map (shooting); with False the last simulated
        periods are returned as they are.
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
    turn = 2.0 * math.pi / system.omega * period
    start = tuple(float(y) for y in y0)
    if time > 0.0:
        run = uninterrupted(
            simulate(system, start, np.array([0.0, 0.5, 1.0]) * turn * math.ceil(time / turn), method=method)
        )
        start = tuple(run.y[:, -1].tolist())
        if not run.status:
            return _motion(system, period, run, None)
    if not close:
        return _motion(system, period, _lap(system, start, period, method), None)
    lap = _lap(system, start, period, method)
    state, matrix, status = closed_state(system, np.array(start), period, method.rtol)
    scale, away = _scale(system, lap), state - start
    if not status or np.linalg.norm(away * scale) > FARTHEST * np.linalg.norm(start * scale):
        return _motion(system, period, lap, None)
    return _motion(system, period, _lap(system, tuple(state.tolist()), period, method), matrix)


def settled(
    system: Any, start: tuple[float, ...], *, time: float, period: int = 1, stable: bool = False, method: Dopri5 = TIGHT
) -> SteadyMotion:
    """Motion of a damped system that a simulation ends on: it goes on until the motion repeats (and is `stable`)."""
    motion = settle(system, start, time=time, period=period, method=method)
    for times in LONGER:
        if (motion.stable if stable else motion.closed) or not motion.status:
            break
        motion = settle(system, motion.end, time=times * time, period=period, method=method)
    return motion


def _lap(system: Any, start: tuple[float, ...], period: int, method: Dopri5) -> Trajectory:
    """One span of the motion, in samples fit for its spectrum."""
    length = 2.0 * math.pi / system.omega * period
    grid = np.linspace(0.0, length, SAMPLES * max(period, highest_order(system)) + 1)
    return uninterrupted(simulate(system, start, grid, method=method))


def _scale(system: Any, lap: Trajectory) -> Floats:
    """Factors that make the states of a lap comparable with x."""
    largest = np.max(np.abs(lap.y), axis=1)
    inner = [largest[0] / z if z > 0.0 else 1.0 for z in largest[2:]]
    return np.array([1.0, 1.0 / system.omega, *inner])


def _motion(system: Any, period: int, run: Trajectory, matrix: Floats | None) -> SteadyMotion:
    """Describe one span; `matrix` is the derivative of the period map where the orbit was to be closed."""
    x, v, z = run.y[0], run.y[1], run.y[2:]
    u = x - system.error.value(system.omega * run.t)
    size = max(float(np.max(np.abs(x))), 1e-300)
    gap = float(np.hypot(x[-1] - x[0], (v[-1] - v[0]) / system.omega)) / size
    closed = bool(run.status) and gap < CLOSED
    stable = None if matrix is None or not closed else bool(np.max(np.abs(np.linalg.eigvals(matrix))) < 1.0)
    return SteadyMotion(
        system.omega, period, run.t, x, v, u, z, run.peak(), gap, closed, stable, run.status, run.message
    )
