"""Stability of a motor's loop with its gear, and its margin: poles of the linearised train.

Bode plots of a drive train: speed of motor and load for a torque on either, linear and at a finite amplitude.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass
from math import pi, sqrt
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike

from ..base.protocols import Control, with_parts
from ..base.quantities import SMALLEST, checked, choice, number, numbers
from ..base.records import Along, Result
from ..base.results import Complexes, Floats, Orbit
from ..base.terminal import on_screen
from ..model.excitation import Harmonic
from ..model.train import Filtered, LoadEncoder, MixedEncoders, PositionIntegral, SteadyTrain, controls
from ..model.train.controls import HERTZ
from ..model.train.drive_train import DriveTrain, coupling_twist
from ..numerics.balanced_orbit import find_orbit
from .operating_point import mean_state
from .state_space import driven, state_space, undriven

ROUNDING = 1e-9  # of the largest pole: less growth than this is none
LEAST_SHARE, MARGIN_TOLERANCE = 1e-3, 1e-3  # of the bandwidth: the smallest that is tried; and of the margin


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
        raise ValueError("a held motor answers no torque; take source='load', or a motor that is free or has a loop")
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


def motor_name(control: Any, inertia: float) -> str:
    """Name of a motor's drive: "held", "free", or its loop by bandwidth and damping on an inertia [kg*m^2]."""
    if (tuning := controls.tuning_of(control, inertia)) is not None:
        return str(tuning)
    if isinstance(control, controls.Lagged):
        return f"{motor_name(control.loop, inertia)}, lag {1e3 * control.lag:.4g} ms"
    if isinstance(control, PositionIntegral):
        return f"{motor_name(control.loop, inertia)}, T_p {1e3 * control.T_p:.4g} ms"
    if isinstance(control, LoadEncoder | MixedEncoders):
        mixed = f"both encoders, mixed at {control.frequency / HERTZ:.4g} Hz" if len(control) > 1 else ""
        return f"{motor_name(control.loop, inertia)}, position by {mixed or 'the encoder of the load'}"
    if isinstance(control, Filtered):
        kind = re.sub(r"(?<=[a-z])(?=[A-Z])", "-", type(control.filter).__name__.removesuffix("Filter")).lower()
        hertz = control.filter.frequency / HERTZ
        return f"{motor_name(control.loop, inertia)}, {kind} filter of {hertz:.4g} Hz"
    if isinstance(control, controls.CascadeLoop):
        gains = f"K_v {control.K_v:.4g} 1/s, K_p {control.K_p:.4g} N*m*s/rad"
        return f"cascade of {gains}, T_n {1e3 * control.T_n:.4g} ms"
    return re.sub(r"(?<=[a-z])(?=[A-Z])", " ", type(control).__name__).lower()


def fastest_growth(train: DriveTrain) -> complex:
    """Pole [1/s] of the train about the state of its mean torques that grows fastest; 0 where none grows.

    States of a law with memory have poles at 0, which rounding puts on either side.
    """
    poles = bode(train, [1.0], source="load", at=mean_state(train), speed=train.omega).poles
    fastest = complex(poles[int(np.argmax(poles.real))])
    return fastest if fastest.real > ROUNDING * float(np.max(np.abs(poles))) else 0j


def unstable(train: DriveTrain, inertia: float) -> str:
    """Say that a loop makes a train unstable, and the bandwidth up to which it would not; empty where it does not.

    A position or speed loop without a lag acts where it measures, puts in no energy and is always stable. What drives a
    train with such a loop too, such as friction that falls with the speed, is not the loop's fault.

    Parameters
    ----------
    train : DriveTrain
        At its speed.
    inertia : float
        Inertia [kg*m^2, motor side] that the loop turns, as in `from_bandwidth`.
    """
    control = train.motor.control
    core = controls.core_of(control)
    passive = controls.PositionLoop(core.K_p * core.K_v, core.K_p) if isinstance(core, controls.CascadeLoop) else core
    if passive is control or not _grows(train, control) or _grows(train, passive):
        return ""
    pole = fastest_growth(train)
    sentence = f"is unstable with this gear: a vibration of {abs(pole) / HERTZ:.3g} Hz grows by {pole.real:.3g} 1/s"
    tuning, lagged = controls.tuning_of(control, inertia), " and lag" if isinstance(control, controls.Lagged) else ""
    limit = None if tuning is None else _largest_stable(train, tuning, inertia)
    if tuning is None or limit is None:
        if isinstance(core, controls.CascadeLoop):
            return f"{sentence}; {_stable_cascade(train, control)}"
        if isinstance(control, Filtered) or isinstance(control.loop, Filtered):
            return f"{sentence}; without its filters{lagged} it is stable: move the filters to higher frequencies"
        lag = f"a lag below {1e3 * control.lag:.3g} ms"
        return f"{sentence}; give the loop more damping (K_d by position, K_p by speed) or {lag}"
    return (
        f"{sentence}; with this damping{lagged} it is stable up to a bandwidth of {limit / HERTZ:.3g} Hz and has "
        f"{tuning.bandwidth / HERTZ:.3g} Hz"
    )


def _grows(train: DriveTrain, control: Control) -> bool:
    return fastest_growth(train.with_motor(control=control)) != 0.0


def _stable_cascade(train: DriveTrain, control: Control) -> str:
    """Gain of a cascade that makes its train stable when it is smaller, and the value down to which."""
    core = controls.core_of(control)
    for name, unit in (("K_v", "1/s"), ("K_p", "N*m*s/rad")):
        value = getattr(core, name)

        def grows(gain: float, name: str = name) -> bool:
            return _grows(train, controls.with_core(control, core._replace(**{name: gain})))

        limit = _last_stable(grows, value)
        if limit is not None:
            return f"with {name} up to {limit:.3g} {unit} it is stable, and it has {value:.3g}"
    return "give it a longer T_n or T_p, or another lag or filter"


def _largest_stable(train: DriveTrain, tuning: controls.Tuning, inertia: float) -> float | None:
    """Largest bandwidth [rad/s] below that of a tuning at which the loop is stable; None where there is none."""

    def grows(bandwidth: float) -> bool:
        loop = controls.from_bandwidth(bandwidth, inertia, tuning.damping, kind=tuning.kind, lag=tuning.lag)
        return _grows(train, loop)

    return _last_stable(grows, min(tuning.bandwidth, controls.FASTEST / tuning.lag if tuning.lag else tuning.bandwidth))


def _last_stable(grows: Callable[[float], bool], largest: float) -> float | None:
    """Largest value below one that grows at which nothing grows; None where there is none."""
    high, low = largest, 0.8 * largest
    while grows(low):
        high, low = low, 0.8 * low
        if low < LEAST_SHARE * largest:
            return None
    while high / low > 1.0 + MARGIN_TOLERANCE:
        middle = sqrt(low * high)
        low, high = (low, middle) if grows(middle) else (middle, high)
    return low


def train_of(project: Any, task: str) -> tuple[str, DriveTrain]:
    """The whole train of a project, or a train itself, for a purpose in words; and what drives its motor, in words.

    Where the file names no motor it is in the position loop of `motors`. A project without a train is a ValueError.
    """
    if isinstance(project, DriveTrain):
        return "", checked(project)
    trains: list[tuple[str, DriveTrain]] = list(project.motors().items())
    if not trains:
        raise ValueError(
            "this project has no whole drive train, as its damping or stiffness varies or its speeds are those of a "
            f"forcing; {task} needs one: leave the variation out, and give the speeds of the motor or the load"
        )
    return trains[-1]
