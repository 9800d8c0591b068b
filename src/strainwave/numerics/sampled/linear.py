"""A sampled loop about a steady motion as a linear map from sample to sample: its poles and frequency responses.

The map is taken from the loop itself by central differences: the plant's integration, the delay, the controller. It is
that of small motions, of encoders without steps and noise, and of a torque below its limit.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...quantities import numbers, positive_count
from ...records import Labelled, Result
from ...results import Floats
from ...sentences import on_screen
from ...tree import leaves, mapped
from .loops import steps_of
from .march import between

COUNTS = 3  # the last fields of a loop's memory: age of a measurement, samples limited and lost
Complexes = NDArray[np.complex128]

FEWEST = 4  # steps between two samples
STILL = 1e-8  # of a pole from 1: what decays slower than in hours does not decay
STEP = 1e-6  # of the states, the memory and the inputs: a torque of 0.1 N*m in the stiffest gear


@dataclass(frozen=True, eq=False)
class LoopResponse(Result):
    """Frequency responses of a sampled loop, and its poles.

    Attributes
    ----------
    omega : (n,) array
        Frequencies [rad/s].
    error_of_torque : (n,) complex array
        Error [rad] that a torque of 1 N*m gives which is added to the controller's.
    error_of_angle : (n,) complex array
        Error [rad] that an angle of 1 rad gives which is added to what the motor is to follow.
    poles : (m,) complex array
        Eigenvalues of the map from sample to sample.
    period : float
        Time from one sample to the next [s].
    """

    rows: ClassVar[str] = "omega"

    omega: Floats
    error_of_torque: Complexes
    error_of_angle: Complexes
    poles: Complexes
    period: float

    @property
    def stable(self) -> bool:
        """Whether every motion decays from sample to sample."""
        return bool(np.all(np.abs(self.poles) < 1.0 - STILL))

    @property
    def slowest(self) -> float:
        """Time constant [s] of the slowest motion; infinite where it does not decay."""
        size = float(np.max(np.abs(self.poles), initial=0.0))
        return float("inf") if size >= 1.0 - STILL else (0.0 if size == 0.0 else -self.period / float(np.log(size)))

    def coordinates(self) -> Labelled:
        """Frequencies."""
        return {"omega": ("omega", self.omega, "rad/s")}

    def variables(self) -> Labelled:
        """Both responses as sizes and phases."""
        return {
            "error_of_torque": ("omega", np.abs(self.error_of_torque), "rad/(N*m)"),
            "phase_of_torque": ("omega", np.angle(self.error_of_torque), "rad"),
            "error_of_angle": ("omega", np.abs(self.error_of_angle), ""),
            "phase_of_angle": ("omega", np.angle(self.error_of_angle), "rad"),
        }

    def __str__(self) -> str:
        how = f"stable, slowest time constant {self.slowest:.3g} s" if self.stable else "unstable"
        return on_screen(f"LoopResponse: {len(self.omega)} frequencies, {len(self.poles)} poles, {how}")

    __repr__ = __str__


def loop_response(
    loop: Any,
    omega: ArrayLike,
    *,
    at: ArrayLike | None = None,
    steps: int | None = None,
    output: Callable[[Any], Any] | None = None,
) -> LoopResponse:
    """Linearise a sampled loop about a steady motion.

    Parameters
    ----------
    loop : Probed
        A loop with inputs: `loop.with_inputs(torque, angle)` is the loop with a torque [N*m] added to its controller's
        and an angle [rad] to its reference, and `loop.quiet()` the loop without noise, steps of encoders and limit.
    omega : (n,) array_like
        Frequencies [rad/s], below pi over the period.
    at : (states,) array_like, optional
        State of the plant about which it is linear. Default: zeros.
    steps : int, optional
        Steps of each part between two samples. Default: enough for the fastest motion of the plant, at least 4.
    output : callable, optional
        What is taken for the error, a function of the plant's state. Default: what the loop watches first.

    Returns
    -------
    LoopResponse

    Raises
    ------
    ValueError
        If a frequency is beyond what the samples carry, or the samples are too slow for the plant (`steps`).
    """
    grid = numbers("omega [rad/s]", omega)
    quiet = loop.quiet()
    if np.any(np.abs(grid) >= np.pi / quiet.period()):
        worst = float(np.max(np.abs(grid)))
        raise ValueError(
            f"omega goes to {worst:.4g} rad/s; samples every {quiet.period():g} s carry none above "
            f"{np.pi / quiet.period():.4g} rad/s: sample faster"
        )
    start, y0 = quiet.start(), np.zeros(len(quiet.plant().state_names())) if at is None else numbers("at", at)
    steps = max(FEWEST, steps_of(quiet, y0)) if steps is None else positive_count("steps", steps)
    # A first sample, from which on the controller's differences count
    y, memory = after(quiet, tuple(y0.tolist()), start, 0.0, 0.0, steps)
    moving, counts = memory[:-COUNTS], memory[-COUNTS:]
    base = np.array([*y, *leaves(moving)], float)
    states = len(y0)

    def following(z: Floats, torque: float, angle: float) -> Floats:
        values = iter(z[states:].tolist())
        held = type(memory)(*mapped(lambda _: next(values), moving), *counts)
        new = after(quiet, tuple(z[:states].tolist()), held, torque, angle, steps)
        return np.array([*new[0], *leaves(new[1][:-COUNTS])], float)

    def error(z: Floats) -> float:
        state = tuple(z[:states].tolist())
        return float(output(state) if output else quiet.watched(0.0, state)[0])

    def slope(function: Any, column: int, size: int) -> Any:
        d = STEP * np.eye(size)[column]
        return (function(d) - function(-d)) / (2.0 * STEP)

    n = len(base)
    A = np.stack([slope(lambda d: following(base + d, 0.0, 0.0), i, n) for i in range(n)], axis=1)
    B = np.stack([slope(lambda d: following(base, *d), i, 2) for i in range(2)], axis=1)
    C = np.array([slope(lambda d: error(base + d), i, n) for i in range(n)])
    z = np.exp(1j * grid * quiet.period())
    inside = np.linalg.solve(z[:, None, None] * np.eye(n) - A + 0.0j, np.broadcast_to(B + 0.0j, (len(z), n, 2)))
    found = np.einsum("i,kij->kj", C, inside)
    return LoopResponse(grid, found[:, 0], found[:, 1], np.linalg.eigvals(A).astype(complex), quiet.period())


def after(loop: Any, y: Any, memory: Any, torque: float, angle: float, steps: int) -> Any:
    """State and memory one sample on, with inputs; at time 0 of the motion."""
    driven = loop.with_inputs(torque, angle)
    memory = driven.update(0.0, y, memory, 0, 0)
    return between(driven, 0.0, y, memory, steps), memory
