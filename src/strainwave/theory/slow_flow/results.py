"""Results of the slow flow: steady states, transients, response curves and the certificate, all frozen."""

import cmath
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ...base.records import Along, Labelled, Result
from ...base.results import Booleans, Floats
from ...base.terminal import on_screen


@dataclass(frozen=True)
class SteadyState:
    """A fixed point of the slow flow.

    Attributes
    ----------
    amplitude : float
        a [rad], 0-to-peak, of the component a cos((p/q) theta - phase) near omega_0 (the article's a).
    phase : float
        Lag [rad] of that component, in (-pi, pi]; 0 where the amplitude is 0.
    stable : bool
        True if it attracts its neighbours (both eigenvalues of the slow flow's Jacobian have negative real parts), so
        never without damping.
    """

    amplitude: float
    phase: float
    stable: bool

    @property
    def z(self) -> complex:
        """Amplitude and phase as one number: a exp(-i phase) [rad]."""
        return cmath.rect(self.amplitude, -self.phase)


@dataclass(frozen=True, eq=False)
class StatesAtSpeeds(Result):
    """The steady states of a slow flow at many speeds: one entry a state, in the order of the speeds.

    At one speed they are listed by descending amplitude, as `steady_states` lists them; a = 0 where it is one of them.

    Attributes
    ----------
    omega : (n,) array
        Speed of the base angle [rad/s] of each state.
    amplitude, phase : (n,) arrays
        a [rad, 0-to-peak] and its lag [rad, in (-pi, pi]].
    stable : (n,) array of bool
        True if it attracts its neighbours.
    """

    omega: Floats
    amplitude: Floats
    phase: Floats
    stable: Booleans

    rows: ClassVar[str] = "state"
    places: ClassVar[Along] = {"state": {"omega": "rad/s"}}
    arrays: ClassVar[Along] = {"state": {"amplitude": "rad", "phase": "rad", "stable": ""}}

    def __str__(self) -> str:
        count = len(np.unique(self.omega))
        return (
            f"Steady states of the slow flow: {len(self.omega)} states at {count} speeds, "
            f"{int(np.sum(self.stable))} of them stable"
        )


@dataclass(frozen=True, eq=False)
class Evolution:
    """A transient of the slow flow.

    Attributes
    ----------
    t : (n,) array
        Times [s].
    amplitude, phase : (n,) arrays
        Slow amplitude a [rad, 0-to-peak] and phase lag [rad, continuous] of the component near omega_0.
    x, rate : (n,) arrays
        Dynamic error x [rad] and x' [rad/s] put together from all components.
    error : float
        Estimated relative error of the instantaneous frequency and decay, at its largest: of x that times the number
        of radians passed. It is what the slow flow's rates miss in the equation averaged over the fast angle.
    valid : bool
        True if `error` is at most 10 % and the small harmonics stay smaller than the motion.
    message : str
        The verdict in one sentence.
    """

    t: Floats
    amplitude: Floats
    phase: Floats
    x: Floats
    rate: Floats
    error: float
    valid: bool
    message: str = field(repr=False)

    def __str__(self) -> str:
        return (
            f"Evolution of the slow flow: {len(self.t)} times, {self.t[0]:.6g} .. {self.t[-1]:.6g} s\n"
            f"  amplitude {self.amplitude[0]:.6g} rad at the start, {self.amplitude[-1]:.6g} rad at the end\n"
            f"  largest |x| {np.max(np.abs(self.x)):.6g} rad\n  {self.message}"
        )

    __repr__ = __str__


@dataclass(frozen=True, eq=False)
class SlowBranch:
    """One connected piece of a response curve, ordered along its arc.

    Attributes
    ----------
    omega : (n,) array
        Speed of the base angle [rad/s].
    amplitude, phase : (n,) arrays
        Steady a [rad, 0-to-peak] and its lag [rad, in (-pi, pi]].
    peak : (n,) array
        Largest |x| [rad] of the whole first-order motion, forced part and kinematic error included.
    stable : (n,) array of bool
        Stability of each state.
    closed : bool
        True if the arc is a closed loop (the last point equals the first). Otherwise it ends where it leaves the range,
        or at a = 0 where that is a steady state too.
    """

    omega: Floats
    amplitude: Floats
    phase: Floats
    peak: Floats
    stable: Booleans
    closed: bool

    def __str__(self) -> str:
        top = int(np.argmax(self.amplitude))
        return (
            f"Branch of the slow flow: {len(self.omega)} points{', closed' if self.closed else ''}, "
            f"{int(np.sum(self.stable))} of them stable\n"
            f"  omega {np.min(self.omega):.6g} .. {np.max(self.omega):.6g} rad/s, largest amplitude "
            f"{self.amplitude[top]:.6g} rad at {self.omega[top]:.6g} rad/s"
        )

    __repr__ = __str__


def _joined(parts: list[NDArray[Any]]) -> NDArray[Any]:
    return np.concatenate(parts) if parts else np.empty(0)


@dataclass(frozen=True, eq=False)
class SlowResponse(Result):
    """Steady amplitude against speed: every branch of nontrivial states in a range of omega.

    Each branch and each fold is listed once. States are sought at 33 speeds from end to end; a closed loop that lies
    between two of them is not seen.

    Attributes
    ----------
    branches : tuple of SlowBranch
        The one with the largest amplitude first; empty where no nontrivial state exists.
    folds, fold_amplitudes : tuple of float
        Speeds [rad/s] at which two states merge, where the drive jumps, ascending, and the amplitudes [rad] there.
    peak : (float, float)
        Speed [rad/s] and amplitude [rad] of the highest point; where that is an end of a branch, `message` says it.
    trivial : tuple of (float, bool)
        Steady state a = 0: speeds [rad/s] of the seeding grid at which it exists, and true where it is stable.
    message : str
        One sentence on what was found, with the speeds inside the range at which a branch begins at a = 0, and those at
        which one could not be followed further.
    """

    branches: tuple[SlowBranch, ...]
    folds: tuple[float, ...]
    fold_amplitudes: tuple[float, ...]
    peak: tuple[float, float]
    trivial: tuple[tuple[float, bool], ...]
    message: str

    def __str__(self) -> str:
        folds = ", ".join(f"{omega:.9g}" for omega in self.folds)
        return on_screen(f"Slow response: {self.message}\n  {f'folds at omega = {folds}' if folds else 'no folds'}")

    def coordinates(self) -> Labelled:
        """Speed at every point, and the number of its branch; the points of one branch after those of another."""
        numbers = [np.full(len(branch.omega), i) for i, branch in enumerate(self.branches)]
        return {"omega": ("point", self._joined("omega"), "rad/s"), "branch": ("point", _joined(numbers), "")}

    def variables(self) -> Labelled:
        """Amplitude, phase, largest |x| and stability at every point."""
        units = {"amplitude": "rad", "phase": "rad", "peak": "rad", "stable": ""}
        return {name: ("point", self._joined(name), unit) for name, unit in units.items()}

    def _joined(self, name: str) -> NDArray[Any]:
        return _joined([getattr(branch, name) for branch in self.branches])

    @property
    def omega(self) -> Floats:
        """Speeds [rad/s] of the first branch, ordered along its arc."""
        return self.branches[0].omega if self.branches else np.empty(0)

    @property
    def amplitude(self) -> Floats:
        """Amplitudes [rad, 0-to-peak] of the first branch."""
        return self.branches[0].amplitude if self.branches else np.empty(0)

    @property
    def stable(self) -> Booleans:
        """Stability along the first branch."""
        return self.branches[0].stable if self.branches else np.empty(0, bool)


@dataclass(frozen=True)
class Certificate:
    """Estimated errors of a result of first or second order, and the verdict on it.

    At a peak and at a fold the speed of the curve stands still in the phase: `speed` there is the relative error of the
    peak's and of the jump's speed.

    Attributes
    ----------
    regime : str
        The resonance treated.
    order : int
        Order of the expansion.
    valid : bool
        True if every error is at most 10 %: in amplitude, in speed, and in amplitude at equal speed. Where no true
        state is near at equal speed, only a point of a curve can be valid. A stable state is not valid where the true
        motion grows by a real Floquet multiplier, as where a spring doubles its period.
    amplitude : float
        Estimated relative error of the steady amplitude (of the near-omega_0 component, or of the forced motion where
        that component is absent), at equal phase where the response curve can be followed by its phase.
    phase : float or None
        Estimated error [rad] of the phase at equal speed; None where no true state is near.
    speed : float
        Estimated relative error of the speed at which that state is, positive where the state comes at too high a speed
        (0 where the estimate is made at equal speed).
    waveform : float
        Estimated relative error of the whole motion in the mean square, all harmonics, at equal phase as `amplitude`.
    amplitude_at_speed : float or None
        Estimated relative error of the amplitude at equal speed; None where no true state is near, as beyond a jump.
    nonlinearity : float
        Largest |N(u)| over largest linear restoring torque on the orbit.
    damping, detuning : float
        mu/omega_0 and |Omega - omega_0|/omega_0: all three must be small.
    quadrature_error : float
        Relative error of the averages of the torque on the component near omega_0, estimated from half as many samples:
        0 for closed forms, at first order for laws that are linear between breakpoints (but without resonance under a
        forcing), and where the quadrature is right to rounding.
    sentence : str
        The verdict in one sentence with its numbers.
    """

    regime: str
    order: int
    valid: bool
    amplitude: float
    phase: float | None
    speed: float
    waveform: float
    amplitude_at_speed: float | None
    nonlinearity: float
    damping: float
    detuning: float
    quadrature_error: float
    sentence: str = field(repr=False)

    def __str__(self) -> str:
        return self.sentence

    __repr__ = __str__
