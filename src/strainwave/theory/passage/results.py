"""What a passage answers with: one run-up or run-down, or one at each of several rates."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from ...records import Labelled, Result
from ...results import Floats
from ...sentences import on_screen


@dataclass(frozen=True)
class DelayedJump:
    """A jump on the way.

    Attributes
    ----------
    omega : float
        Speed of the base angle [rad/s] at which the amplitude is half way between those of the two motions.
    fold : float
        Speed [rad/s] of the fold, at which the drive would jump if the speed changed infinitely slowly.
    delay : float
        How far the drive goes beyond the fold [rad/s], positive in the direction of the passage.
    estimate : float
        The same to leading order, 2.33811 times a constant of the fold times rate^(2/3) [rad/s].
    """

    omega: float
    fold: float
    delay: float
    estimate: float


@dataclass(frozen=True, eq=False)
class Passage(Result):
    """A run-up or run-down through a resonance at a constant rate; the speed is then held at its last value.

    Attributes
    ----------
    first, last, rate : float
        Speeds of the base angle [rad/s] and its rate [rad/s^2], positive.
    order : int
        Order of the slow flow.
    closed_form : bool
        Whether the exact formula of a linear drive serves.
    largest, at : float
        Largest amplitude [rad, 0-to-peak] of the component near omega_0, and the speed [rad/s] at which it is.
    peak : float
        Largest |x| [rad] that is possible with these amplitudes, whatever the base angle is at the start.
    jumps : tuple of DelayedJump
        Jumps in the order of the way; empty where the drive passes without one.
    settling : float or None
        Time [s] from the last jump, or without one from the largest amplitude, to where the motion stays within 2 % of
        the steady state at its speed; None where it does not within the time of the history.
    t, omega, amplitude, envelope : (n,) arrays
        History: times [s], speeds [rad/s], amplitude [rad] as `largest`, and the largest |x| [rad] of a forcing period.
    error : float
        Estimated relative error of `largest`.
    valid : bool
        Whether `error` is at most 3 %, and rates 10 % higher and lower change `largest` by less than 15 %.
    message : str
        One sentence.
    """

    first: float
    last: float
    rate: float
    order: int
    closed_form: bool
    largest: float
    at: float
    peak: float
    jumps: tuple[DelayedJump, ...]
    settling: float | None
    t: Floats
    omega: Floats
    amplitude: Floats
    envelope: Floats
    error: float
    valid: bool
    message: str = field(repr=False)

    rows: ClassVar[str] = "t"

    @property
    def jumped(self) -> bool:
        """Whether the drive jumped on the way."""
        return len(self.jumps) > 0

    @property
    def jump(self) -> float | None:
        """Speed [rad/s] of the first jump; None without one."""
        return self.jumps[0].omega if self.jumps else None

    def coordinates(self) -> Labelled:
        """Times of the history."""
        return {"t": ("t", self.t, "s")}

    def variables(self) -> Labelled:
        """Speed, amplitude and largest |x| over time; speeds of the jumps, their folds and estimates."""
        jumps = np.array([(j.omega, j.fold, j.estimate) for j in self.jumps]).reshape(-1, 3)
        return {
            "omega": ("t", self.omega, "rad/s"),
            "amplitude": ("t", self.amplitude, "rad"),
            "envelope": ("t", self.envelope, "rad"),
            "jump": ("jump", jumps[:, 0], "rad/s"),
            "fold": ("jump", jumps[:, 1], "rad/s"),
            "estimate": ("jump", jumps[:, 2], "rad/s"),
        }

    def __str__(self) -> str:
        return on_screen(self.message)

    __repr__ = __str__


@dataclass(frozen=True, eq=False)
class Passages(Result):
    """The same passage at several rates.

    Attributes
    ----------
    passages : tuple of Passage
        One for each rate, in the order in which they were given.
    rate_without_jump : float or None
        Rate [rad/s^2] above which the drive passes without jumping, to 1 %; None where it always jumps or never does.
    """

    passages: tuple[Passage, ...]
    rate_without_jump: float | None

    rows: ClassVar[str] = "rate"

    @property
    def rate(self) -> Floats:
        """Rates (n,) [rad/s^2]."""
        return np.array([p.rate for p in self.passages])

    @property
    def largest(self) -> Floats:
        """Largest amplitudes (n,) [rad]."""
        return np.array([p.largest for p in self.passages])

    @property
    def at(self) -> Floats:
        """Speeds (n,) [rad/s] of the largest amplitudes."""
        return np.array([p.at for p in self.passages])

    @property
    def peak(self) -> Floats:
        """Largest |x| (n,) [rad]."""
        return np.array([p.peak for p in self.passages])

    @property
    def jumped(self) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
        """Whether the drive jumped (n,)."""
        return np.array([p.jumped for p in self.passages], bool)

    @property
    def jump(self) -> Floats:
        """Speeds (n,) [rad/s] of the first jumps; nan where there is none."""
        return np.array([np.nan if p.jump is None else p.jump for p in self.passages])

    @property
    def settling(self) -> Floats:
        """Settling times (n,) [s]; nan where the motion did not settle."""
        return np.array([np.nan if p.settling is None else p.settling for p in self.passages])

    @property
    def valid(self) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
        """Where the answer can be relied on (n,)."""
        return np.array([p.valid for p in self.passages], bool)

    def coordinates(self) -> Labelled:
        """The rates."""
        return {"rate": ("rate", self.rate, "rad/s^2")}

    def variables(self) -> Labelled:
        """Largest amplitude and |x|, their speed, the jump, settling time and validity at every rate."""
        units = {"largest": "rad", "at": "rad/s", "peak": "rad", "jumped": "", "jump": "rad/s", "settling": "s"}
        return {name: ("rate", getattr(self, name), unit) for name, unit in (units | {"valid": ""}).items()}

    def __len__(self) -> int:
        return len(self.passages)

    def __str__(self) -> str:
        limit = "none" if self.rate_without_jump is None else f"{self.rate_without_jump:.6g} rad/s^2"
        return on_screen(
            f"Passages at {len(self)} rates, {np.min(self.rate):.6g} .. {np.max(self.rate):.6g} rad/s^2\n"
            f"  largest amplitude {np.min(self.largest):.6g} .. {np.max(self.largest):.6g} rad, "
            f"{int(np.sum(self.jumped))} with a jump, {int(np.sum(self.valid))} valid\n"
            f"  rate above which it passes without a jump: {limit}"
        )

    __repr__ = __str__
