"""Stability margins of the motor's loop: the loop is cut where the control gives its torque."""

from dataclasses import dataclass
from functools import cached_property
from math import inf, pi
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...base.protocols import with_parts
from ...base.quantities import checked
from ...base.records import Result
from ...base.results import Complexes, Floats
from ...base.terminal import on_screen
from ...model.controllers.closed_loop import Sampling
from ...model.train.controls import FREE, Held
from ...model.train.drive_train import DriveTrain
from ...numerics.roots import bracketed_root
from ..state_space import StateSpace, state_space
from .linear_control import LinearControl, around_poles, control_response, linear_control
from .sampled_loop import SampledLoop, sampled_loop

POINTS, POLE_SPAN = 4000, 1e3  # frequencies, and how far below and above the slowest and fastest pole
HALF_WIDTHS = np.tan(np.linspace(-1.5, 1.5, 201))  # places around a resonance, in half widths
ZOOM_POINTS, ZOOM_ROUNDS = 33, 3  # places between the neighbours of the largest sensitivity, and rounds
NOISE = 1e-7  # of the largest: a pole that stands for 0, and an imaginary part that does not count


class MotorLoop:
    """The open loop L(j omega) of a train's motor: torque that the control takes back per torque that it gives.

    Parameters
    ----------
    train, at, speed
        As of `state_space`: a motor with a loop, and the operating point.
    """

    def __init__(self, train: DriveTrain, state: ArrayLike | None, speed: float) -> None:
        self.train, self.closed = train, state_space(train, at=state, speed=speed)
        self._of_control = np.array([name.startswith("control z") for name in self.closed.states])
        self.still = self.closed.at[~self._of_control]

    @cached_property
    def plant(self) -> StateSpace:
        """The train without the control."""
        return state_space(self.train.with_motor(control=FREE), at=self.still, speed=self.closed.speed)

    @cached_property
    def control(self) -> LinearControl:
        """The linear control."""
        return linear_control(self.train.motor.control, self.closed.at, self._of_control)

    @cached_property
    def outputs(self) -> Floats:
        """Rows (3, states) of the motor's angle as the loop sees it, of its angle, and of its speed."""
        names = ("motor deviation", "motor speed", "error")
        angle, rate, error = self.plant.C[list(map(self.plant.outputs.index, names))]
        at_load = hasattr(self.train.motor.control, "at_load")
        return np.array([angle - self.train.N * error if at_load else angle, angle, rate])

    @cached_property
    def corners(self) -> Complexes:
        """Its resonances, those of the closed loop, and its antiresonances: the modes with the motor locked."""
        held = self.train.with_motor(control=Held())
        locked = state_space(held, at=np.delete(self.still, [2, 3]), speed=self.closed.speed)
        return np.concatenate([self.plant.poles, self.closed.poles, locked.poles])

    @property
    def stable(self) -> bool:
        """True if the closed loop is stable."""
        return bool(np.all(self.growing.real < 0.0))

    @property
    def growing(self) -> Complexes:
        """Poles [1/s] of the closed loop, but for those at 0 of states that stay where they are."""
        return self.closed.moving[int(self.closed.drifts) :]

    def __call__(self, omega: ArrayLike) -> Complexes:
        """Open loop (n,) at frequencies [rad/s]; 1 + L = 0 is the closed loop's characteristic equation."""
        frequencies = np.atleast_1d(np.asarray(omega, float))
        return np.asarray(np.sum(control_response(self.control, frequencies) * self.answer(frequencies), axis=1))

    def answer(self, omega: Floats) -> Complexes:
        """Deviations (n, 2), as the loop sees it and of the motor, over a torque on the motor, without its loop."""
        s = 1j * omega[:, None, None] * np.eye(len(self.plant.A)) - self.plant.A
        response = np.linalg.solve(s, self.plant.B[:, :1].astype(complex))[:, :, 0]
        return np.asarray(response @ self.outputs[:2].T)

    def frequencies(self, points: int, about: Floats, beyond: float = POLE_SPAN) -> Floats:
        """Frequencies [rad/s], ascending, close around resonances and antiresonances."""
        sizes = np.abs(self.corners)
        sizes = sizes[sizes > NOISE * np.max(sizes, initial=1e-300)]
        low, high = (float(np.min(sizes)), float(np.max(sizes))) if len(sizes) else (1.0, 1.0)
        return np.unique([*np.geomspace(low / beyond, high * beyond, points), *around_poles(self.corners, about)])


@dataclass(frozen=True, eq=False)
class Margins(Result):
    """Margins of the motor's loop; they count where the closed loop is `stable`.

    Attributes
    ----------
    gain_crossings : (n,) array
        Frequencies [rad/s] where |L| = 1, ascending.
    phase_margins : (n,) array
        Phase [rad] of -L there, in (-pi, pi]: what the loop may still lag (or, where negative, lead).
    phase_crossings : (m,) array
        Frequencies [rad/s] where L is real and negative.
    gain_margins : (m,) array
        Factors 1/|L| there by which the gain reaches instability: above 1 a rise, below 1 a fall.
    stable : bool
        Whether the closed loop is stable.
    peak_sensitivity : float
        Largest |1/(1 + L)| over the frequencies; infinite of an unstable loop.
    slowest : complex
        Pole [1/s] of the closed loop that decays slowest, or grows fastest; of a sampled loop log z over the period.
    period : float
        Time [s] between the samples; 0 of a loop without.
    """

    gain_crossings: Floats
    phase_margins: Floats
    phase_crossings: Floats
    gain_margins: Floats
    stable: bool
    peak_sensitivity: float
    slowest: complex
    period: float = 0.0

    @property
    def phase_margin(self) -> float:
        """Smallest phase margin [rad] by its size; infinite where |L| is nowhere 1."""
        return float(min(self.phase_margins, key=abs, default=inf))

    @property
    def gain_margin(self) -> float:
        """Smallest factor above 1 of the gain that reaches instability; infinite where there is none."""
        return float(min((g for g in self.gain_margins if g > 1.0), default=inf))

    @property
    def gain_reduction(self) -> float:
        """Largest factor below 1 of the gain that reaches instability; 0 where there is none."""
        return float(max((g for g in self.gain_margins if g < 1.0), default=0.0))

    @property
    def delay_margin(self) -> float:
        """Smallest delay [s] in the loop that reaches instability; infinite where |L| is nowhere 1."""
        return float(min(np.mod(self.phase_margins, 2.0 * pi) / self.gain_crossings, default=inf))

    def __str__(self) -> str:
        crossings = ", ".join(
            f"{p * 180.0 / pi:.4g}° at {w:.6g}" for p, w in zip(self.phase_margins, self.gain_crossings, strict=True)
        )
        sampled = f", sampled every {1e6 * self.period:.4g} us" * bool(self.period)
        gains = ", ".join(f"{g:.4g} at {w:.6g}" for g, w in zip(self.gain_margins, self.phase_crossings, strict=True))
        return on_screen(
            f"Margins of the motor's loop{sampled}: closed loop {'stable' if self.stable else 'unstable'}\n"
            f"  phase margins (rad/s): {crossings or 'none, |L| is nowhere 1'}\n"
            f"  gain margins, factors (rad/s): {gains or 'none, L is nowhere real and negative'}\n"
            f"  delay margin {self.delay_margin:.4g} s, peak sensitivity {self.peak_sensitivity:.4g}"
        )


def margins(
    train: DriveTrain, *, at: ArrayLike | None = None, speed: float = 0.0, sampling: Sampling | None = None
) -> Margins:  # fmt: skip
    """Find gain, phase and delay margins of the motor's loop, linear about an operating point.

    Parameters
    ----------
    train : DriveTrain
        A train whose motor has a loop; its excitations and kinematic error are left out.
    at : (states,) array_like, optional
        State about which it is linear (`operating_state`). Default: zeros.
    speed : float
        Speed of the motor [rad/s] there. Default: standstill.
    sampling : Sampling, optional
        Period and delay of a controller that samples: its torque is held between the samples while plant, lag and
        torque filters go on, its integrals go by backward Euler. Default: the loop without samples.

    Returns
    -------
    Margins
        `gain_crossings` (n,) [rad/s] with `phase_margins` (n,) [rad], `phase_crossings` (m,) [rad/s] with
        `gain_margins` (m,), factors: every crossing of |L| = 1 and of the negative real axis between a thousandth of
        the slowest pole and a thousand times the fastest, of a sampled loop up to half its rate. `delay_margin` [s].

    Raises
    ------
    ValueError
        If the motor is free or held, and so has no loop.

    References
    ----------
    Franklin, Powell & Emami-Naeini 2015, Feedback Control of Dynamic Systems, sec. 6.4 (margins from Bode plots).
    """
    train = with_parts("margins", train, "power_names")
    if train.motor.free or train.motor.held:
        kind = "free" if train.motor.free else "held ideally"
        raise ValueError(f"the motor is {kind} and has no loop; give it a SpeedLoop or a PositionLoop")
    loop = loop_of(train, at, speed, None if sampling is None else checked(sampling))
    grid = loop.frequencies(POINTS, HALF_WIDTHS)
    values = loop(grid)
    size = np.log(np.maximum(np.abs(values), 1e-300))
    across = [i for i in _changes(values.imag) if np.any(np.abs(values.imag[i : i + 2]) > NOISE * np.abs(values[i]))]
    gains = np.array([_root(loop, grid, i, lambda z: float(np.log(abs(z)))) for i in _changes(size)])
    phases = np.array([_root(loop, grid, i, lambda z: float(z.imag)) for i in across])
    if sampling is not None:  # half the rate, where a sampled loop is real
        phases = np.append(phases[phases < grid[-1] * (1.0 - NOISE)], grid[-1])
    if len(phases):
        phases = phases[loop(phases).real < 0.0]
    phase_margins = np.angle(-loop(gains)) if len(gains) else gains
    factors = 1.0 / np.abs(loop(phases)) if len(phases) else phases
    poles = loop.growing
    slowest = complex(poles[int(np.argmax(poles.real))])
    peak = peak_sensitivity(loop, grid, values) if loop.stable else inf
    return Margins(
        gains, phase_margins, phases, factors, stable=loop.stable, peak_sensitivity=peak, slowest=slowest,
        period=getattr(loop, "period", 0.0),
    )  # fmt: skip


def loop_of(
    train: DriveTrain, state: ArrayLike | None, speed: float, sampling: Sampling | None
) -> MotorLoop | SampledLoop:  # fmt: skip
    """The open loop of a train's motor, as its controller samples it or without samples."""
    plain = MotorLoop(train, state, speed)
    return plain if sampling is None else sampled_loop(plain, sampling)


def peak_sensitivity(loop: MotorLoop | SampledLoop, grid: Floats, values: Complexes) -> float:
    """Largest |1/(1 + L)|, between the frequencies of the grid too."""
    least = np.abs(1.0 + values)
    for _ in range(ZOOM_ROUNDS):
        top = int(np.argmin(least))
        grid = np.linspace(grid[max(top - 1, 0)], grid[min(top + 1, len(grid) - 1)], ZOOM_POINTS)
        least = np.abs(1.0 + loop(grid))
    return float(1.0 / np.min(least))


def _changes(values: Floats) -> Any:
    """Places after which values change their sign."""
    return np.flatnonzero(np.sign(values[1:]) * np.sign(values[:-1]) < 0.0)


def _root(loop: MotorLoop | SampledLoop, grid: Floats, i: int, part: Any) -> float:
    return bracketed_root(lambda w: part(loop(w)[0]), float(grid[i]), float(grid[i + 1]), xtol=0.0, rtol=1e-13)
