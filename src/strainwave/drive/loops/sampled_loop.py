"""A motor's loop as its controller samples it, linear about an operating point and exact between the samples.

A torque acts from its delay after the sample on and is held for a period. Plant, current lag and torque filters go on
between the samples as states; so does the part of a delay that is no whole period. At a sample the controller has the
angles and the speed of that time; its own integrals go by backward Euler (Franklin, Powell & Workman, Digital Control
of Dynamic Systems, 3rd ed. 1998, sec. 4.3, plants with delay, and 6.1, numerical integration).
"""

from math import pi
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...base.results import Complexes, Floats
from ...model.controllers.closed_loop import Sampling
from ...model.train.commanded import COMMANDED
from ...model.train.controls import Lagged
from ...model.train.filters import Filtered, apart, around
from .linear_control import LinearControl, around_poles, control_parts

ZERO_POLE = 1e-7  # of half the rate: a pole that stands for 0
SLOWER_SPAN = 30.0  # how far the frequencies go below the slowest pole
DELAY_ROUNDING = 1e-9  # of a period: rounding of a delay
ON_CIRCLE = 1e-9  # distance from 1 of a pole that does not move


class SampledPlant:
    """Plant, lag and filters behind a controller's samples, linear about an operating point.

    Parameters
    ----------
    loop : MotorLoop
        The loop without samples, about an operating point.
    outside : Control
        Lag and filters around a torque from outside, as of `without_outside`.
    sampling : Sampling
        Period and delay of the controller.
    """

    def __init__(self, loop: Any, outside: Any, sampling: Sampling) -> None:
        self.period, self.memory = sampling.period, loop.plant.memory + loop.closed.drifts
        A, B, seen = _continuous(loop, control_parts(outside))
        self.A, self.B = held(A, B, sampling.period, sampling.delay)
        self.seen = np.pad(seen, ((0, 0), (0, len(self.A) - len(A))))
        of_load = loop.plant.B[:, loop.plant.inputs.index("load torque")]
        self.of_load = held(A, np.pad(of_load, (0, len(A) - len(of_load))), sampling.period, 0.0)[1]
        self.loop, self.poles = loop, np.linalg.eigvals(A)

    def answer(self, omega: Floats) -> Complexes:
        """Angle as seen and speed (2, n) at the samples over the torque of the controller, at frequencies [rad/s]."""
        z = np.exp(1j * self.period * omega)[:, None, None]
        states = np.linalg.solve(z * np.eye(len(self.A)) - self.A, self.B[:, None] + 0j)
        return np.asarray((self.seen @ states)[:, :, 0].T)


class SampledLoop:
    """The open loop L(exp(j omega T)) of a train's motor under a controller with the period T.

    Parameters
    ----------
    plant : SampledPlant
        What its torque moves.
    parts : LinearControl
        `control_parts` of what the controller computes.
    """

    def __init__(self, plant: SampledPlant, parts: LinearControl) -> None:
        self.plant, self.parts, self.period = plant, parts, plant.period
        self.poles = np.linalg.eigvals(self.closed())

    @property
    def growing(self) -> Complexes:
        """Poles [1/s] of the closed loop, log z/T, but for those at 0 of states that stay where they are."""
        still = np.argsort(np.abs(self.poles - 1.0))[: self.plant.memory]
        moving = np.delete(self.poles, still[np.abs(self.poles[still] - 1.0) < ON_CIRCLE])
        return np.asarray(np.log(np.where(moving == 0.0, 1e-300, moving)) / self.period)

    @property
    def stable(self) -> bool:
        """True if every motion decays from sample to sample."""
        return bool(np.all(self.growing.real < 0.0))

    def __call__(self, omega: ArrayLike, answer: Complexes | None = None) -> Complexes:
        """Open loop (n,) at frequencies [rad/s] up to pi/T; 1 + L = 0 is the closed loop's characteristic equation."""
        grid = np.atleast_1d(np.asarray(omega, float))
        A, B, C, D = self.law
        z = np.exp(1j * self.period * grid)[:, None, None]
        torque = (C @ np.linalg.solve(z * np.eye(len(A)) - A, B + 0j) + D)[:, 0]
        return np.asarray(np.sum(torque.T * (self.plant.answer(grid) if answer is None else answer), axis=0))

    @property
    def law(self) -> tuple[Floats, Floats, Floats, Floats]:
        """Matrices of the controller from sample to sample: from angle and speed to the torque against them."""
        by_angle, by_speed, inertia, A, B, C = self.parts
        T, n = self.period, len(A)
        kept = np.linalg.inv(np.eye(n) - T * A)  # backward Euler: z = kept (z before + T B w)
        put = T * kept @ B
        old = np.zeros((n + 1, n + 1))
        old[:n, :n] = kept
        put = np.vstack([put, [0.0, 1.0]])  # the last state is the speed of the sample before
        out = np.append(C[0] @ kept, -inertia / T)[None, :]
        through = np.array([[by_angle, by_speed + inertia / T]]) + C @ put[:n]
        return old, put, out, through

    def closed(self) -> Floats:
        """Matrix of the closed loop from sample to sample."""
        A, B, C, D = self.law
        moved, torque, seen = self.plant.A, self.plant.B, self.plant.seen
        top = np.hstack([moved - np.outer(torque, D @ seen), -np.outer(torque, C)])
        return np.vstack([top, np.hstack([B @ seen, A])])

    def frequencies(self, points: int, about: Floats) -> Floats:
        """Frequencies [rad/s], ascending to pi/T, close around resonances and antiresonances."""
        every = np.concatenate([self.plant.loop.corners, self.plant.poles, self.growing])
        sizes, top = np.abs(every), pi / self.period
        least = np.min(sizes[sizes > ZERO_POLE * top], initial=top)
        around = around_poles(every, about)
        return np.unique(np.concatenate([np.geomspace(least / SLOWER_SPAN, top, points), around[around < top]]))


def sampled_loop(loop: Any, sampling: Sampling) -> SampledLoop:
    """The loop of a `MotorLoop` as a controller samples it."""
    inner, outside = without_outside(loop.train.motor.control)
    return SampledLoop(SampledPlant(loop, outside, sampling), control_parts(inner))


def without_outside(control: Any) -> tuple[Any, Any]:
    """Computed part of a control, and a torque from outside behind its filters and its lag."""
    core, parts = apart(control)
    outside: Any = COMMANDED
    for item in parts.pop("filters", ()):
        outside = Filtered(outside, item)
    if lag := parts.pop("lag", 0.0):
        outside = Lagged(outside, lag)
    return (around(core, **parts) if parts else core), outside


def _continuous(loop: Any, outside: LinearControl) -> tuple[Floats, Floats, Floats]:
    """Matrices of plant, lag and filters under a torque that is held, and rows of the angle and the speed as seen."""
    plant, A, C = loop.plant, outside.A, outside.C  # the last state is the torque that is held
    augmented = np.block([[plant.A, -np.outer(plant.B[:, 0], C[0])], [np.zeros((len(A), len(plant.A))), A]])
    seen = np.hstack([loop.outputs[[0, 2]], np.zeros((2, len(A) - 1))])
    return augmented[:-1, :-1], augmented[:-1, -1], seen


def held(A: Floats, B: Floats, period: float, delay: float) -> tuple[Floats, Floats]:
    """Matrices from sample to sample of x' = A x + B u, u held over a period and late by the delay.

    The states are x and the torques of the samples before that do not act yet or still act, the latest first.
    """
    from scipy.linalg import expm  # here: a curve of a drive needs none of SciPy

    T, n = period, len(A)
    periods = int(delay / T + DELAY_ROUNDING)
    part = max(delay / T - periods, 0.0)
    part = part if part > DELAY_ROUNDING else 0.0
    before = periods + (part > 0.0)
    matrix = np.zeros((n + 1, n + 1))
    matrix[:n, :n], matrix[:n, n] = A, B
    late, now = expm(part * T * matrix), expm((1.0 - part) * T * matrix)
    F, g = np.zeros((n + before, n + before)), np.zeros(n + before)
    F[:n, :n] = now[:n, :n] @ late[:n, :n]
    if part:
        F[:n, n + periods] = now[:n, :n] @ late[:n, n]
    if periods:
        F[:n, n + periods - 1] += now[:n, n]
    else:
        g[:n] = now[:n, n]
    if before:
        g[n] = 1.0
        F[n + 1 :, n:-1] = np.eye(before - 1)
    return F, g
