"""A sampled loop about a steady motion as a linear map from sample to sample: its poles and frequency responses.

The map is taken from the loop itself by central differences: the plant's integration, the delay, the controller. It is
that of small motions, of encoders without steps and noise, and of a torque below its limit.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ...base.quantities import States, number_of, numbers
from ...base.records import Along, Labelled, Result
from ...base.results import Complexes, Floats
from ...base.terminal import on_screen
from ...compile.tree import leaves, mapped
from .loop_march import between
from .loops import marched, ready, steps_of

COUNTS = 3  # the last fields of a loop's memory: age of a measurement, samples limited and lost

FEWEST_STEPS = 4  # steps between two samples
LEAST_SAMPLES = 200  # samples of a turn, or of several: it is rounded to whole samples
OTHER_TIME, SAME_SLOPE = 0.37, 1e-9  # of a turn: where the map is looked at again; a difference that is rounding
BEYOND_FLOATS = float(np.finfo(float).max)
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
    places: ClassVar[Along] = {"omega": {"omega": "rad/s"}}

    omega: Floats
    error_of_torque: Complexes
    error_of_angle: Complexes
    poles: Complexes
    period: float

    @property
    def stable(self) -> bool:
        """True if every motion decays from sample to sample."""
        return bool(np.all(np.abs(self.poles) < 1.0 - STILL))

    @property
    def slowest(self) -> float:
        """Time constant [s] of the slowest motion; infinite where it does not decay."""
        size = float(np.max(np.abs(self.poles), initial=0.0))
        return float("inf") if size >= 1.0 - STILL else (0.0 if size == 0.0 else -self.period / float(np.log(size)))

    def variables(self) -> Labelled:
        """Both responses as sizes and phases."""
        return {
            "error_of_torque": ("omega", np.abs(self.error_of_torque), "rad/(N*m)"),
            "phase_of_torque": ("omega", np.angle(self.error_of_torque), "rad"),
            "error_of_angle": ("omega", np.abs(self.error_of_angle), ""),
            "phase_of_angle": ("omega", np.angle(self.error_of_angle), "rad"),
        }

    def __str__(self) -> str:
        verdict = f"stable, slowest time constant {self.slowest:.3g} s" if self.stable else "unstable"
        return on_screen(f"LoopResponse: {len(self.omega)} frequencies, {len(self.poles)} poles, {verdict}")


class _SampleMap:
    """Map of a loop from sample to sample near a state: its states and its memory, but for the counts, as one vector.

    It begins after a first sample, from which on the controller's differences count.
    """

    def __init__(self, loop: Any, y0: States, steps: int) -> None:
        self.loop, self.states, self.steps = loop, len(y0), steps
        y, self.memory = self._after(y0, loop.start())
        self.base = self.joined(y, self.memory)

    def joined(self, y: States, memory: Any) -> Floats:
        """Vector of a state and a memory."""
        return np.array([*y, *leaves(memory[:-COUNTS])], float)

    def parted(self, z: Floats) -> tuple[Any, Any]:
        """State and memory of a vector; its counts are those after the first sample."""
        values = iter(z[self.states :].tolist())
        held = mapped(lambda _: next(values), self.memory[:-COUNTS])
        return tuple(z[: self.states].tolist()), type(self.memory)(*held, *mapped(float, self.memory[-COUNTS:]))

    def following(self, d: Floats | float, torque: float = 0.0, angle: float = 0.0, time: float = 0.0) -> Floats:
        """Vector one sample after the base plus d, with inputs [N*m, rad], from a time [s] of the motion."""
        return self.joined(*self._after(*self.parted(self.base + d), torque, angle, time))

    def _after(self, y: Any, memory: Any, torque: float = 0.0, angle: float = 0.0, time: float = 0.0) -> Any:
        driven = self.loop.with_inputs(torque, angle)
        with np.errstate(all="ignore"):
            memory = driven.update(time, y, memory, 0, 0)
            return between(driven, time, y, memory, self.steps), memory


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
        Error as a function of the plant's state. Default: what the loop watches first.

    Returns
    -------
    LoopResponse
        Error [rad] that a torque of 1 N*m and an angle of 1 rad give at `omega` [rad/s], the `poles` of the map
        from sample to sample, and `stable`.

    Raises
    ------
    ValueError
        If a frequency is beyond what the samples carry, or the samples are too slow for the plant (`steps`).
    """
    grid = numbers("omega [rad/s]", omega)
    loop, first, per_sample = ready(loop, at, steps)
    quiet = loop.quiet()
    if np.any(np.abs(grid) >= np.pi / quiet.period()):
        worst = float(np.max(np.abs(grid)))
        raise ValueError(
            f"omega goes to {worst:.4g} rad/s; samples every {quiet.period():g} s carry none above "
            f"{np.pi / quiet.period():.4g} rad/s: sample faster"
        )
    sampled = _SampleMap(quiet, first, max(FEWEST_STEPS, per_sample) if steps is None else per_sample)

    def error(d: Floats) -> float:
        state, _ = sampled.parted(sampled.base + d)
        return number_of(output or (lambda y: quiet.watched(0.0, y)[0]), state, "a state of the plant")

    n = len(sampled.base)
    A, B = _slopes(sampled.following, n), _slopes(lambda d: sampled.following(0.0, *d), 2)
    C = _slopes(error, n)
    moving = np.any(np.abs(A - np.eye(n)) > SAME_SLOPE, axis=1)  # what nothing moves is no motion of the loop
    A, B, C, n = A[moving][:, moving], B[moving], C[moving], int(np.sum(moving))
    z = np.exp(1j * grid * quiet.period())
    inside = np.linalg.solve(z[:, None, None] * np.eye(n) - A + 0.0j, np.broadcast_to(B + 0.0j, (len(z), n, 2)))
    response = np.einsum("i,kij->kj", C, inside)
    return LoopResponse(grid, response[:, 0], response[:, 1], np.linalg.eigvals(A).astype(complex), quiet.period())


def _slopes(function: Callable[..., Any], size: int) -> Any:
    """Slopes (..., size) of a function of so many differences, at 0 (ValueError where they are infinite)."""
    each = STEP * np.eye(size)
    with np.errstate(all="ignore"):
        slopes = np.stack([(function(d) - function(-d)) / (2.0 * STEP) for d in each], axis=-1)
    if not np.all(np.isfinite(slopes)):
        raise ValueError(
            "the loop grows beyond all floats between two samples; check its torques, inertias and gains, and where it "
            "is linearised"
        )
    return slopes


def multipliers(loop: Any, turn: float, *, at: ArrayLike) -> tuple[Complexes, float]:
    """Multipliers of the small motions of a sampled loop over a time, and that time [s].

    What a memory keeps of the angle, as that of a turn, changes the map from sample to sample along the turn: the map
    is then that of one turn, or of as many as have `LEAST_SAMPLES`. A number of the memory that nothing moves is left
    out.

    Parameters
    ----------
    loop : Probed
        As of `loop_response`.
    turn : float
        Time [s] after which the map is the same again.
    at : (states,) array_like
        State of the plant in its steady motion.
    """
    quiet, y0 = loop.quiet(), numbers("at", at)
    sampled = _SampleMap(quiet, tuple(y0.tolist()), max(FEWEST_STEPS, steps_of(quiet, y0)))

    def whole_turn(d: Floats) -> Floats:
        start, buffers = sampled.parted(sampled.base + d), (np.empty((len(y0), 1)), np.empty((4, 1)))
        return sampled.joined(*marched(quiet, *start, samples, sampled.steps, *buffers, stride=samples))

    period, samples, n = quiet.period(), 1, len(sampled.base)
    slopes = _slopes(sampled.following, n)
    later = _slopes(lambda d: sampled.following(d, time=OTHER_TIME * turn), n)
    if np.max(np.abs(slopes - later)) > SAME_SLOPE * np.max(np.abs(slopes)):
        samples = round(np.ceil(LEAST_SAMPLES * period / turn) * turn / period)
        try:
            slopes = _slopes(whole_turn, n)
        except ValueError:
            return np.array([BEYOND_FLOATS], complex), samples * period
    moving = np.any(np.abs(slopes - np.eye(n)) > SAME_SLOPE, axis=1)
    return np.linalg.eigvals(slopes[moving][:, moving]).astype(complex), samples * period
