"""Results of the verbs: a status that is a sentence, and frozen results that print themselves and can be saved."""

import math
import os
from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from .archive import atomic
from .quantities import array_of, index, whole
from .records import Along, Labelled, Result, Waves
from .series import oscillation
from .terminal import on_screen

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Integers = NDArray[np.int64]
Booleans = NDArray[np.bool_]
GROWS = 1.0 + 1e-8  # a Floquet multiplier above it: that of a neutral orbit is 1 but for rounding
NO_MEAN = 1e-12  # of the largest |first state|: a smaller mean is none


class Status(Enum):
    """Outcome of a computation: the value is the sentence for the user, with its remedy. Truthy when all is well."""

    OK = "finished"
    DIVERGED = "the solution left every bound; check the sign of damping and stiffness, or start closer to equilibrium"
    TOO_MANY_STEPS = "the step limit was reached; ask for a shorter time, a larger tolerance or more steps"
    NO_CONVERGENCE = "the iteration did not converge; start closer to a solution or take more harmonics"
    TRUNCATED = "the harmonics left out hold more than 0.1 % of the motion; take more harmonics"
    INTERRUPTED = "interrupted by the user; what was finished is kept"

    def __bool__(self) -> bool:
        return self is Status.OK

    @property
    def found(self) -> bool:
        """True for a whole result, if perhaps a rough one: `OK` or `TRUNCATED`."""
        return self in (Status.OK, Status.TRUNCATED)


class SolveError(RuntimeError):
    """A computation failed and the caller asked for an exception; the message says where, the value, and the remedy."""


class Interrupted(KeyboardInterrupt):
    """Ctrl-C in a verb that had finished a part: `found` is the result of that part, the message says which it is."""

    def __init__(self, sentence: str, found: Any) -> None:
        super().__init__(sentence)
        self.found = found


def largest_between(h: Floats, x: Floats, v: Floats, x1: Floats, v1: Floats) -> float:
    """Largest |x| over stretches (n,) of lengths h [s]: at both ends and, where the rate v changes sign, between them.

    There it is the extreme of the cubic with these values and rates (Hermite).
    """
    best = float(max(np.max(np.abs(x), initial=0.0), np.max(np.abs(x1), initial=0.0)))
    turns = np.sign(v) * np.sign(v1) < 0.0
    if not np.any(turns):
        return best
    x, rise, c, d = x[turns], (x1 - x)[turns], (h * v)[turns], (h * v1)[turns]
    size = np.maximum(np.abs(c), np.abs(d))
    rise, c, d = rise / size, c / size, d / size
    # x(s) on [0, 1]: a s^3 + b s^2 + c s + x
    a, b = c + d - 2.0 * rise, 3.0 * rise - 2.0 * c - d
    q = np.abs(b) + np.sqrt(b * b - 3.0 * a * c)
    s = np.where(b * c > 0.0, q / np.where(b * c > 0.0, 3.0 * np.abs(a), 1.0), np.abs(c) / q)
    return max(best, float(np.max(np.abs(size * ((a * s + b) * s + c) * s + x))))


def state_labels(count: int) -> list[str]:
    """Names of so many states: x and x' of an oscillator, else y0, y1, ..."""
    return ["x", "x'"] if count == 2 else [f"y{i}" for i in range(count)]


def coefficient_labels(count: int) -> list[str]:
    """Names of so many Fourier coefficients: mean, cos 1, sin 1, ..."""
    return ["mean", *(f"{wave} {k}" for k in range(1, count // 2 + 1) for wave in ("cos", "sin"))]


@dataclass(frozen=True, eq=False)
class Trajectory(Result):
    """A solution in time.

    Attributes
    ----------
    t : (n,) array
        Times [s].
    y : (states, n) array
        States; for an `Oscillator` x [rad] and x' [rad/s].
    rate : (states, n) array
        Time derivatives of the states at `t`.
    status : Status
        `Status.OK`, or why the solution ends before the last requested time. All values are finite.
    message : str
        One sentence with the place where it ended.
    steps, rejected, switches : int
        Accepted steps, rejected steps, and crossings of a breakpoint of the law that were located.
    largest : (states or more, n) array or None
        Largest |state| on the way from the sample before, at the steps of the integration and between them; after the
        states what the system has `watched`. None where the samples are the steps themselves.
    """

    t: Floats
    y: Floats
    rate: Floats
    status: Status
    message: str
    steps: int
    rejected: int
    switches: int
    largest: Floats | None = None

    def peak(self, component: int = 0, after: float = -np.inf) -> float:
        """Largest absolute value of a state, between the samples too.

        Of the integration itself, however far the samples are apart: its steps, joined by cubic Hermite interpolation.

        Parameters
        ----------
        component : int
            Index of the state; 0 is the dynamic error x, -1 the last one.
        after : float
            Look at times from the first sample at t >= after [s] on.
        """
        component = index("component", component, len(self.y), "states")
        use = self.t >= after
        t, x, v = self.t[use], self.y[component, use], self.rate[component, use]
        if len(t) == 0:
            raise ValueError(f"no sample at t >= {after} s; the trajectory ends at {self.t[-1]} s")
        if self.largest is None:
            return max(float(abs(x[0])), largest_between(np.diff(t), x[:-1], v[:-1], x[1:], v[1:]))
        return float(max(np.max(np.abs(x)), np.max(self.largest[component, use][1:], initial=0.0)))

    rows: ClassVar[str] = "t"
    arrays: ClassVar[Along] = {("state", "t"): {"y": "", "rate": ""}}

    def coordinates(self) -> Labelled:
        """Times and the names of the states: x and x' of two, else by number."""
        return {"t": ("t", self.t, "s"), "state": ("state", state_labels(len(self.y)), "")}

    def variables(self) -> Labelled:
        """States and their rates over the time; two states count as an angle and its speed."""
        two = {"x": ("t", self.y[0], "rad"), "v": ("t", self.y[1], "rad/s")} if len(self.y) == 2 else {}
        return {**super().variables(), **two}

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write everything as other results do, or t and y as CSV (`.csv`); the file appears when it is complete."""
        path = Path(path)
        if path.suffix != ".csv":
            return super().save(path)
        names = ["x_rad", "v_rad_per_s"] if len(self.y) == 2 else state_labels(len(self.y))
        table, head = np.vstack([self.t, self.y]).T, ",".join(["t_s", *names])
        with atomic(path) as part:
            np.savetxt(part, table, delimiter=",", header=head, comments="", fmt="%.12g")
        return path

    def __str__(self) -> str:
        return on_screen(
            f"Trajectory: {len(self.t)} samples, t = {self.t[0]:.6g} .. {self.t[-1]:.6g} s\n"
            f"  largest |state|: {', '.join(f'{v:.6g}' for v in np.max(np.abs(self.y), axis=1))}\n"
            f"  {self.steps} steps, {self.rejected} rejected, {self.switches} switches\n"
            f"  status: {self.message}"
        )


@dataclass(frozen=True, eq=False)
class Orbit(Result):
    """A periodic orbit.

    Attributes
    ----------
    omega : float
        Base frequency [rad/s].
    period : int
        Turns of the base angle that the orbit takes; harmonic k belongs to k omega/period.
    coefficients : (2H+1, states) array
        Fourier coefficients of the states: mean, cos 1, sin 1, cos 2, sin 2, ...
    peak : float
        Largest absolute value of the first state [rad for an Oscillator].
    multipliers : (states,) complex array
        Floquet multipliers over the orbit's period, largest modulus first.
    stable : bool
        True if every multiplier lies inside the unit circle.
    tail : float
        Share of the first state that the harmonics left out hold, estimated from the torque; no error of the peak.
    status : Status
        `Status.OK`; `Status.TRUNCATED` where `tail` is above 1e-3; or why there is no orbit.
    message : str
        One sentence.
    label : str
        "" or what kind of point this is on its branch: "fold", "period doubling", ...
    value : float
        Value of the parameter that varies on its branch; nan for an orbit that was found on its own.
    """

    omega: float
    period: int
    coefficients: Floats
    peak: float
    multipliers: Complexes
    stable: bool
    tail: float
    status: Status
    message: str
    label: str = ""
    value: float = math.nan

    def amplitude(self, k: int) -> float:
        """Amplitude of harmonic k of the first state, 0-to-peak; k = 0 gives the mean."""
        x, k = self.coefficients[:, 0], whole("k", k)
        if 2 * k >= len(x):
            return 0.0
        return float(np.hypot(x[2 * k - 1], x[2 * k])) if k else float(x[0])

    @property
    def oscillation(self) -> float:
        """Largest |first state - mean| over the period [rad for an Oscillator]."""
        return float(oscillation(self.coefficients[:, 0][None])[0])

    rows: ClassVar[str] = "harmonic"
    arrays: ClassVar[Along] = {("coefficient", "state"): {"coefficients": ""}, "multiplier": {"multipliers": "1"}}

    def coordinates(self) -> Labelled:
        """Harmonics with their frequencies, states, and coefficients by name."""
        k = np.arange(len(self.coefficients) // 2 + 1)
        return {
            "harmonic": ("harmonic", k, ""),
            "frequency": ("harmonic", k * self.omega / self.period, "rad/s"),
            "coefficient": ("coefficient", coefficient_labels(len(self.coefficients)), ""),
            "state": ("state", state_labels(self.coefficients.shape[1]), ""),
        }

    def variables(self) -> Labelled:
        """Amplitudes of the first state by harmonic (0 is the mean), coefficients of all states, multipliers."""
        amplitudes = [self.amplitude(k) for k in range(len(self.coefficients) // 2 + 1)]
        return {"amplitude": ("harmonic", amplitudes, "rad"), **super().variables()}

    def state(self, phase: Floats | float) -> Floats:
        """States (states, ...) at the base phase [rad], for instance the start of a trajectory at phase 0."""
        angle = array_of("phase [rad]", phase) / self.period
        k = np.arange(1, len(self.coefficients) // 2 + 1).reshape(-1, *[1] * angle.ndim)
        basis = np.empty((len(self.coefficients), *angle.shape))
        basis[0], basis[1::2], basis[2::2] = 1.0, np.cos(k * angle), np.sin(k * angle)
        return np.tensordot(self.coefficients.T, basis, 1)

    def __str__(self) -> str:
        kind = f" ({self.label})" if self.label else ""
        modulus = float(np.max(np.abs(self.multipliers)))
        unstable = "unstable" if modulus > GROWS else "neither stable nor unstable"
        return on_screen(
            f"Orbit{kind}: omega = {self.omega:.9g} rad/s, period {self.period} of the base angle\n"
            f"  peak |x| {self.peak:.9g}, amplitude(1) {self.amplitude(1):.9g}, mean {self.amplitude(0):.3g}\n"
            f"  {'stable' if self.stable else unstable}: largest multiplier {modulus:.6g}\n"
            f"  {len(self.coefficients) // 2} harmonics, tail {self.tail:.1e}; {self.message}"
        )


@dataclass(frozen=True, eq=False)
class Branch(Result):
    """A curve of periodic orbits, in the order of its arc length.

    Attributes
    ----------
    parameter : str
        Path of the parameter that varies, for instance "omega" or "law.alpha".
    values, omega : (n,) arrays
        The parameter and the base frequency [rad/s] at every point. Two neighbours at one value, an end of the range,
        are on two arcs.
    coefficients : (n, 2H+1) array
        Fourier coefficients of the first state: mean, cos 1, sin 1, ...
    peak : (n,) array
        Largest absolute value of the first state over the period.
    multipliers : (n, states) complex array
        Floquet multipliers over the orbit's period, largest modulus first.
    stable : (n,) bool array
        True for a stable orbit.
    folds, doublings : list of Orbit
        Turning points of the parameter, and period doublings, in arc order.
    period : int
        Turns of the base angle that an orbit takes; amplitude(k) belongs to k omega/period.
    closed : bool
        True for a closed loop (an isola).
    tail : float
        Largest share of the first state that the harmonics left out hold, estimated from the torque.
    origin : str
        Origin of the branch.
    status : Status
        `Status.OK`; `Status.TRUNCATED` where `tail` is above 1e-3; or why the branch ends inside the range.
    message : str
        One sentence.
    branch_points : list of Orbit
        Points with a multiplier through +1 and no fold: another branch crosses (the symmetry of the orbit breaks).
    tori : list of Orbit
        Neimark-Sacker points, where a complex pair of multipliers leaves the unit circle (general systems only).
    elsewhere : list of Orbit
        Other motions found at the ends of the range of a response curve, stable or not, which do not join it.
    span : (float, float)
        Range of the parameter; the points of a response curve may leave it and come back.
    envelope : (n, 2) array or None
        Of motions that beat: largest and smallest |first state - mean| of a turn of the base angle. The coefficients
        are then those of the part that repeats with every turn.
    beat, waves : float or None, Waves or None
        Turns of the base angle in a beat, and all waves of motions that beat.
    """

    parameter: str
    values: Floats
    omega: Floats
    coefficients: Floats
    peak: Floats
    multipliers: Complexes
    stable: Booleans
    folds: list[Orbit]
    doublings: list[Orbit]
    period: int
    closed: bool
    tail: float
    origin: str
    status: Status
    message: str
    branch_points: list[Orbit] = field(default_factory=list)
    tori: list[Orbit] = field(default_factory=list)
    elsewhere: list[Orbit] = field(default_factory=list)
    span: tuple[float, float] = (math.nan, math.nan)
    envelope: Floats | None = None
    beat: float | None = None
    waves: Waves | None = None

    def amplitude(self, k: int) -> Floats:
        """Amplitude (n,) of harmonic k of the first state, 0-to-peak; k = 0 gives the mean."""
        x, k = self.coefficients, whole("k", k)
        if 2 * k >= x.shape[1]:
            return np.zeros(len(x))
        return np.asarray(np.hypot(x[:, 2 * k - 1], x[:, 2 * k])) if k else x[:, 0].copy()

    @cached_property
    def oscillation(self) -> Floats:
        """Largest |first state - mean| over the period (n,) [rad for an Oscillator]; where it beats, of any turn."""
        if self.envelope is not None:
            return self.envelope[:, 0]
        without_mean = bool(np.all(np.abs(self.coefficients[:, 0]) <= NO_MEAN * self.peak))
        return self.peak if without_mean else oscillation(self.coefficients)

    @property
    def inside(self) -> Booleans:
        """True for each point (n,) in `span`."""
        return np.asarray((self.values >= self.span[0]) & (self.values <= self.span[1]))

    def coordinates(self) -> Labelled:
        """Speed and parameter at every point, harmonics, and coefficients by name."""
        width = self.coefficients.shape[1]
        return {
            "omega": ("point", self.omega, "rad/s"),
            **({} if self.parameter == "omega" else {self.parameter: ("point", self.values, "")}),
            "harmonic": ("harmonic", np.arange(1, width // 2 + 1), ""),
            "coefficient": ("coefficient", coefficient_labels(width), ""),
            **({} if self.waves is None else {"wave": ("wave", ["{} {}".format(*p) for p in self.waves.pairs], "")}),
        }

    def variables(self) -> Labelled:
        """Sizes of the first state, which counts as an angle, at every point; stability; coefficients."""
        harmonics = range(1, self.coefficients.shape[1] // 2 + 1)
        amplitudes = np.array([self.amplitude(k) for k in harmonics]).reshape(len(harmonics), len(self)).T
        return {
            "peak": ("point", self.peak, "rad"),
            "oscillation": ("point", self.oscillation, "rad"),
            **({} if self.envelope is None else {"smallest": ("point", self.envelope[:, 1], "rad")}),
            "mean": ("point", self.amplitude(0), "rad"),
            "stable": ("point", self.stable, ""),
            "amplitude": (("point", "harmonic"), amplitudes, "rad"),
            "coefficients": (("point", "coefficient"), self.coefficients, "rad"),
            "multipliers": (("point", "multiplier"), self.multipliers, "1"),
            **({} if self.waves is None else {"waves": (("point", "wave"), self.waves.amplitudes, "rad")}),
        }

    def __len__(self) -> int:
        return len(self.values)

    def __str__(self) -> str:
        folds = ", ".join(f"{f.value:.9g}" for f in self.folds)
        turns = f"folds at {self.parameter} = {folds}" if folds else "no folds"
        crossings = f"; {len(self.branch_points)} branch points" if self.branch_points else ""
        crossings += f"; {len(self.tori)} Neimark-Sacker points" if self.tori else ""
        top = int(np.argmax(self.peak)) if len(self) else 0
        peak = f"{self.peak[top]:.6g} at omega {self.omega[top]:.6g} rad/s" if len(self) else "none"
        return on_screen(
            f"Branch in {self.parameter}: {len(self)} points{', closed' if self.closed else ''}, {self.origin}\n"
            f"  largest |x| {peak}\n"
            f"  {turns}; {len(self.doublings)} period doublings{crossings}\n"
            f"  {int(np.sum(self.stable))} of {len(self)} points stable\n"
            f"  {self.coefficients.shape[1] // 2} harmonics, tail {self.tail:.1e}; {self.message}"
        )
