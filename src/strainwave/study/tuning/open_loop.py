"""`OpenLoop`: margins and disturbance response of a motor's loop about an operating point, for any gains.

The train without its loop does not depend on the gains. It is made linear once; every set of gains is then algebra.
"""

from collections.abc import Sequence
from math import inf, pi
from typing import Any, NamedTuple

import numpy as np

from ...base.results import Complexes, Floats
from ...drive.loops.linear_control import LinearControl, around_poles, control_parts, control_response
from ...drive.loops.margins import MotorLoop, peak_sensitivity
from ...drive.loops.sampled_loop import SampledLoop, SampledPlant, without_outside
from ...drive.operating_point import mean_state
from ...model.controllers.closed_loop import Sampling
from ...model.train.drive_train import DriveTrain

FREQUENCIES, BEYOND = 500, 30.0  # number, and the factor by which they go beyond the slowest and fastest pole
LOG_STEP = 0.05  # of frequencies below these, where a loop with other gains is slower
HALF_WIDTHS = np.tan(np.linspace(-1.45, 1.45, 30))  # of a resonance: distances of the frequencies around it
ZERO_POLE = 1e-9  # of the largest pole: a smaller one stands for 0
SETTLED_SHARE, TIMES = 0.02, 4000  # share of the largest deviation, and number of times


class LoopFigures(NamedTuple):
    """Figures of the linear loop with some gains.

    Attributes
    ----------
    peak_sensitivity : float
        Largest |1/(1 + L)| over the frequencies; infinite of an unstable loop.
    gain_margin, phase_margin : float
        Least factor above 1 of the gain, and least phase [rad], that reaches instability; 0 of an unstable loop.
    compliance : float
        Largest deviation of the load's angle over a torque on the load [rad/(N*m)], over the frequencies.
    settling : float
        Time [s] after a step of torque on the load from which on its angle stays within 2 % of the largest deviation.
    """

    peak_sensitivity: float = inf
    gain_margin: float = 0.0
    phase_margin: float = 0.0
    compliance: float = inf
    settling: float = inf


UNSTABLE = LoopFigures()


class OpenLoop:
    """A train cut at its motor's torque, linear about the state of its mean torques at its speed.

    Parameters
    ----------
    train : DriveTrain
        With a loop of the motor.
    delay : float
        Delay [s] of the loop that the train does not have.
    sampling : Sampling, optional
        Period and delay of a controller: stability and margins are then those of the loop that it samples.
    """

    def __init__(self, train: DriveTrain, delay: float = 0.0, sampling: Sampling | None = None) -> None:
        loop = MotorLoop(train, mean_state(train), train.omega)
        self.plant, self.delay, self.loop, self.sampling = loop.plant, delay, loop, sampling
        self.sampled: tuple[Any, SampledPlant] | None = None  # by lag and filters, which may be others
        self.seen, _, self.rate = loop.outputs
        self.load_speed = self.plant.C[self.plant.outputs.index("load speed")]
        self.motor_torque = self.plant.B[:, 0]
        self.load_torque = self.plant.B[:, self.plant.inputs.index("load torque")]
        self.grid = loop.frequencies(FREQUENCIES, HALF_WIDTHS, BEYOND)
        self.answer = self.loop.answer(self.grid)

    @property
    def resonance(self) -> float:
        """Frequency [rad/s] of the least damped vibration with the motor free; 0 where none vibrates."""
        waves = self.plant.poles[self.plant.poles.imag > 0.0]
        return float(np.abs(waves)[np.argmax(waves.real / np.abs(waves))]) if len(waves) else 0.0

    def figures(self, parts: LinearControl, control: Any = None) -> LoopFigures:
        """Margins and disturbance response with the `control_parts` of a control; a sampled loop needs it itself."""
        count = len(parts.A)
        closed = self._closed(parts)
        poles, vectors = np.linalg.eig(closed)
        moving = np.abs(poles) > ZERO_POLE * np.max(np.abs(poles))
        drifts = not np.any(closed[:, self.plant.states.index("motor deviation")])
        if np.sum(~moving) > self.plant.memory + drifts or np.any(poles[moving].real >= 0.0):
            return UNSTABLE
        into = np.linalg.solve(vectors, np.pad(self.load_torque, (0, count)))
        angle = (np.pad(self.load_speed, (0, count)) @ vectors * into)[moving] / poles[moving]
        lower = np.arange(LOG_STEP, np.log(BEYOND * self.grid[0] / np.min(np.abs(poles[moving]))), LOG_STEP)
        extra = np.append(around_poles(poles, HALF_WIDTHS), self.grid[0] * np.exp(-lower))
        margins = self._sampled(control, self.sampling) if self.sampling else self._delayed(parts, extra)
        if margins is None:
            return UNSTABLE
        disturbance = _compliance_and_settling(poles[moving], angle, np.concatenate([self.grid, extra]))
        return LoopFigures(*map(float, (*margins, *disturbance)))

    def _delayed(self, parts: LinearControl, extra: Floats) -> tuple[float, float, float] | None:
        """Peak sensitivity, gain and phase margin behind the delay, at `extra` frequencies too; None if unstable."""

        def without_delay(omega: Floats, answer: Complexes) -> Any:
            return np.sum(control_response(parts, omega) * answer, axis=1)

        def loop(omega: Floats) -> Any:
            return without_delay(omega, self.loop.answer(omega) * np.exp(-1j * self.delay * omega)[:, None])

        grid = np.concatenate([self.grid, extra])
        order = np.argsort(grid)
        grid, answer = grid[order], np.concatenate([self.answer, self.loop.answer(extra)])[order]
        L = without_delay(grid, answer)
        gains, _ = crossings(grid, L)
        if np.any(np.mod(gains[:, 1], 2.0 * pi) < self.delay * gains[:, 0]):
            return None
        return _margins(loop, grid, L * np.exp(-1j * self.delay * grid))

    def _sampled(self, control: Any, sampling: Sampling) -> tuple[float, float, float] | None:
        """Peak sensitivity, gain and phase margin of the sampled loop; None of an unstable one."""
        inner, outside = without_outside(control)
        if self.sampled is None or self.sampled[0] != outside:
            self.sampled = outside, SampledPlant(self.loop, outside, sampling)
        loop = SampledLoop(self.sampled[1], control_parts(inner))
        if not loop.stable:
            return None
        grid = loop.frequencies(FREQUENCIES, HALF_WIDTHS)
        L = loop(grid)
        return _margins(loop, grid, L, [-1.0 / L[-1].real])  # half the rate, where L is real

    def _closed(self, parts: LinearControl) -> Floats:
        """Matrix of the closed loop, the states of the control last."""
        by_angle, by_speed, inertia, A, B, C = parts
        heavy = 1.0 + inertia * float(self.rate @ self.motor_torque)
        against = (by_angle * self.seen + by_speed * self.rate + inertia * self.rate @ self.plant.A) / heavy
        motor = self.motor_torque
        plant = np.hstack([self.plant.A - np.outer(motor, against), -np.outer(motor, C[0] / heavy)])
        return np.vstack([plant, np.hstack([B @ np.vstack([self.seen, self.rate]), A])])


def _margins(loop: Any, grid: Floats, L: Complexes, more: Sequence[float] = ()) -> tuple[float, float, float]:
    """Peak sensitivity, gain and phase margin; `more` factors of the gain beside those of the crossings."""
    gains, phases = crossings(grid, L)
    factors = np.append(phases[:, 1], more)
    margins = np.min(factors[factors > 1.0], initial=inf), np.min(np.abs(gains[:, 1]), initial=inf)
    return peak_sensitivity(loop, grid, L), *margins


def crossings(grid: Floats, L: Complexes) -> tuple[Floats, Floats]:
    """Rows (frequency, phase of -L) where |L| is 1, and (frequency, 1/|L|) where L is real and negative."""
    size, phase = np.log(np.maximum(np.abs(L), 1e-300)), np.angle(-L)
    turn = (np.diff(phase) + pi) % (2.0 * pi) - pi
    rows = []
    for values, steps, level, slopes in ((size, np.diff(size), phase, turn), (phase, turn, -size, -np.diff(size))):
        k = np.flatnonzero((values[:-1] * (values[:-1] + steps) < 0.0) & (np.abs(steps) < 0.5 * pi))
        share = -values[k] / steps[k]
        rows.append(np.column_stack([grid[k] + share * np.diff(grid)[k], level[k] + share * slopes[k]]))
    return rows[0], np.column_stack([rows[1][:, 0], np.exp(rows[1][:, 1])])


def _compliance_and_settling(poles: Complexes, angle: Complexes, grid: Floats) -> tuple[float, float]:
    """Compliance [rad/(N*m)] at frequencies and settling [s] of the load's angle, of residues at poles [1/s]."""
    t = np.linspace(0.0, 10.0 / float(np.min(np.abs(poles.real))), TIMES)
    off = np.abs(np.exp(np.multiply.outer(t, poles)) @ (angle / poles)).real
    largest = np.max(np.abs((angle / (1j * grid[:, None] - poles)).sum(axis=1)))
    return max(float(largest), off[0]), t[np.flatnonzero(off > SETTLED_SHARE * np.max(off))[-1]]
