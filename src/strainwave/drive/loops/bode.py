"""Bode plots of a drive train: speed of motor and load for a torque on either, linear and at a finite amplitude."""

from dataclasses import dataclass
from math import pi
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike

from ...base.protocols import with_parts
from ...base.quantities import SMALLEST, choice, number, numbers
from ...base.records import Along, Result
from ...base.results import Complexes, Floats, Orbit
from ...base.terminal import on_screen
from ...model.excitation import Harmonic
from ...model.train.drive_train import DriveTrain, coupling_twist
from ...model.train.train_forms import SteadyTrain
from ...numerics.balanced_orbit import find_orbit
from ..state_space import driven, state_space, undriven


@dataclass(frozen=True, eq=False)
class Bode(Result):
    """Frequency response of the speeds to a torque, about standstill or another operating point.

    Attributes
    ----------
    omega : (n,) array
        Frequencies [rad/s].
    motor, load : (n,) complex arrays
        Speed of the motor and of the load over the torque [rad/(N*m*s)], first harmonic; nan where no motion was found.
    source : str
        The shaft that the torque acts on: "motor" or "load".
    amplitude : float
        Amplitude [N*m] of the torque, 0-to-peak; 0 for the linear response.
    poles : (states,) complex array
        Eigenvalues [1/s] of the linearised train.
    messages : tuple of str
        Sentences about frequencies where no motion was found.
    """

    omega: Floats
    motor: Complexes
    load: Complexes
    source: str
    amplitude: float
    poles: Complexes
    messages: tuple[str, ...]

    rows: ClassVar[str] = "omega"
    arrays: ClassVar[Along] = {"omega": {"motor": "rad/(N*m*s)", "load": "rad/(N*m*s)"}, "pole": {"poles": "1/s"}}
    places: ClassVar[Along] = {"omega": {"omega": "rad/s"}}

    def decibels(self, shaft: Literal["motor", "load"] = "motor") -> Floats:
        """Magnitude (n,) in dB of the speed of a shaft over the torque, relative to 1 rad/(N*m*s); -inf of one held."""
        size = np.abs(self._of(shaft))
        return 20.0 * np.log10(size, out=np.full(size.shape, -np.inf), where=size != 0.0)

    def degrees(self, shaft: Literal["motor", "load"] = "motor") -> Floats:
        """Phase (n,) in degrees of the speed of a shaft, continuous along the frequencies."""
        return np.asarray(np.unwrap(np.angle(self._of(shaft))) * 180.0 / pi)

    def __str__(self) -> str:
        how = f"amplitude {self.amplitude:g} N*m" if self.amplitude else "linear"
        lines = [
            f"Bode: {len(self.omega)} frequencies, {self.omega[0]:.6g} .. {self.omega[-1]:.6g} rad/s, torque on the "
            f"{self.source}, {how}"
        ]
        for shaft, size in (("motor", self.decibels("motor")), ("load", self.decibels("load"))):
            if np.any(np.isfinite(size)):
                top = int(np.nanargmax(size))
                lines.append(f"  {shaft}: at most {size[top]:.4g} dB, at {self.omega[top]:.6g} rad/s")
            else:
                lines.append(f"  {shaft}: held")
        waves = sorted({(abs(p), -p.real / abs(p)) for p in self.poles.tolist() if p.imag > 0.0})
        modes = ", ".join(f"{w:.6g} rad/s (damping ratio {zeta:.3g})" for w, zeta in waves)
        fastest = np.max(self.poles.real, initial=-np.inf)
        lines.append(f"  modes: {modes or 'none that oscillates'}; fastest growth {fastest:.4g} 1/s")
        return on_screen("\n".join([*lines, *(f"  {message}" for message in self.messages[:1])]))

    def _of(self, shaft: str) -> Complexes:
        choice("shaft", shaft, "motor", "load")
        return self.motor if shaft == "motor" else self.load


def bode(
    train: DriveTrain,
    omega: ArrayLike,
    *,
    source: Literal["motor", "load"] = "motor",
    amplitude: float | None = None,
    at: ArrayLike | None = None,
    speed: float = 0.0,
) -> Bode:
    """Compute how the speeds of motor and load answer a torque, without kinematic error.

    Parameters
    ----------
    train : DriveTrain
        The train with its control loop; its own excitations, kinematic error and reference are left out.
    omega : (n,) array_like
        Frequencies [rad/s].
    source : {"motor", "load"}
        The shaft that the torque acts on.
    amplitude : float, optional
        Amplitude of the torque [N*m, of that shaft]: the first harmonic of the periodic motion of the nonlinear train,
        by harmonic balance, each frequency followed from the one before; a sweep up where they ascend. Default: the
        linearised train.
    at : (states,) array_like, optional
        State about which it is linearised, for instance x under a mean torque (`operating_state`). Default: zeros.
    speed : float
        Speed of the motor [rad/s] about which it is linearised, which friction depends on. Default: standstill, about
        which the response at an `amplitude` always is.

    Returns
    -------
    Bode
        Complex speeds of `motor` and `load` over the torque [rad/(N*m*s)] at `omega` [rad/s], and the `poles`
        [1/s] of the linearised train.

    Raises
    ------
    ValueError
        If a frequency is not positive, the amplitude is not, or a torque is requested on a held motor.

    References
    ----------
    Krack & Gross 2019, Harmonic Balance for Nonlinear Vibration Problems, ch. 2.
    """
    train = with_parts("bode", train, "power_names")
    grid = numbers("omega", omega)
    choice("source", source, "motor", "load")
    if not np.all(grid >= SMALLEST):
        raise ValueError(f"omega has {np.min(grid):g} rad/s; a frequency must be positive, {SMALLEST:g} up")
    if source == "motor" and train.motor.held:
        raise ValueError(
            "a held motor does not respond to torque; use source='load', or a motor that is free or has a loop"
        )
    linear = state_space(train, at=at, speed=speed)
    poles = linear.poles
    if amplitude is None:
        motor, load = linear.response(grid)[:2, linear.inputs.index(f"{source} torque")]
        return Bode(grid, motor, load, source, 0.0, poles, ())
    amplitude = number("amplitude", amplitude, positive=True)
    motor, load, messages = _at_amplitude(undriven(train)._replace(omega=1.0), grid, source, amplitude)
    return Bode(grid, motor, load, source, amplitude, poles, messages)


def _speeds(train: DriveTrain, states: Any) -> tuple[Complexes, Complexes]:
    """Speeds (n,) of motor and load for complex states (states, n)."""
    motor = np.zeros(states.shape[1], complex) if train.motor.held else states[3].astype(complex)
    return motor, motor / train.N - states[1] - coupling_twist(train, states)[1]


def _at_amplitude(
    train: DriveTrain, grid: Floats, source: str, amplitude: float
) -> tuple[Complexes, Complexes, tuple[str, ...]]:
    motor, load = np.full(len(grid), np.nan + 0j), np.full(len(grid), np.nan + 0j)
    messages: list[str] = []
    free = train.motor.free
    orbit: Orbit | None = None
    for i, omega in enumerate(grid):
        system: Any = driven(train, source, Harmonic(amplitude))._replace(omega=float(omega))
        if free:
            system = SteadyTrain(system, float(omega), by_angle=0)
        orbit = find_orbit(system, guess=orbit) if orbit is not None else find_orbit(system)
        if not orbit.status:
            messages.append(orbit.message)
        if not orbit.status.found:
            orbit = None
            continue
        first = orbit.coefficients[1] - 1j * orbit.coefficients[2]
        if free:  # (x, x', w, p, ...) to the states of the train
            first = np.concatenate([first[:2], [0.0, first[2]], first[4:]])
        motor[i], load[i] = np.ravel(_speeds(train, first[:, None])) / amplitude
    return motor, load, tuple(messages)
