"""Balance of the energy: work of the excitation, losses by damping, friction and hysteresis, and the stored energy.

Multiplying J x'' + B u' + T = tau by x' = u' + e' gives d/dt (J x'^2/2 + E) = tau x' - (B u' + T) e' - B u'^2 - losses,
with E the energy stored in the law and T u' = dE/dt + losses. The powers on the right are integrated along with the
states; the energies on the left are formulas of the states at both ends, so that the balance closes only if the law's
torque, energy and losses belong together.

The efficiency of a gear at constant speed follows from its load-proportional friction and the drag on its motor.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...base.law import depends, energy_of, parts_of, states_of, torque_of
from ...base.protocols import Law, System, lacking, with_parts
from ...base.quantities import SMALLEST, number, numbers, shown
from ...base.results import Floats, Orbit, SolveError
from ...base.units import RPM
from ...model.oscillator import Powers
from ...numerics.integration.methods import Dopri5
from ...numerics.integration.simulate import simulate

FEWEST_CYCLES, MOST_CYCLES = 1e-6, 1e5  # cycles of the fastest vibration in a stretch
OWN_DAMPING = "damping B"  # name of the loss by the oscillator's own damping
FIRST_TOLERANCE = 1e-6  # tolerance of the first pass, which finds how large the states and works are


@dataclass(frozen=True)
class EnergyBalance:
    """Energies [J] over a stretch of motion: work + error_work = sum of the losses + stored.

    Attributes
    ----------
    duration : float
        Length [s] of the stretch.
    work : float
        Work of the excitation, the integral of tau x'.
    error_work : float
        Work that the kinematic error does on the gear, the integral of -(B u' + T) e'.
    losses : dict of str to float
        Losses to heat, all of them: by the oscillator's own damping, "damping B", and by each part of the law,
        "BoucWen", "LuGre", ..., the second of a kind "BoucWen 2".
    stored : float
        Change of the kinetic energy and the energy stored in the law. Over a settled orbit it is zero.
    """

    duration: float
    work: float
    error_work: float
    losses: dict[str, float]
    stored: float

    @property
    def closure(self) -> float:
        """Gap of the balance, relative to its largest term: the error of the integration."""
        terms = [self.work, self.error_work, -self.stored, *(-loss for loss in self.losses.values())]
        return abs(sum(terms)) / max(max(abs(term) for term in terms), 1e-300)

    def __str__(self) -> str:
        parts = ", ".join(f"{name} {loss:.6g}" for name, loss in self.losses.items())
        return (
            f"EnergyBalance over {self.duration:.6g} s [J]: excitation {self.work:.6g}, kinematic error "
            f"{self.error_work:.6g} = {parts}, stored {self.stored:.6g} "
            f"(closed to {self.closure:.1e})"
        )

    __repr__ = __str__


def energy_balance(
    system: Any, start: Orbit | ArrayLike, duration: float | None = None, *, rtol: float = 1e-12
) -> EnergyBalance:
    """Integrate works and losses over one period of an orbit, or over a stretch of motion from a state.

    Parameters
    ----------
    system : Oscillator
        The system; with an orbit, at the orbit's omega.
    start : Orbit or (states,) array_like
        A settled orbit, or the state at base phase 0.
    duration : float, optional
        Length of the stretch [s]. Default: the period of the orbit.
    rtol : float
        Tolerance of the integration.

    Returns
    -------
    EnergyBalance
        `work`, `error_work`, `losses` by name and `stored` [J] over `duration` [s]; `closure` says how well
        they add up (relative).

    Raises
    ------
    ValueError
        If a state is given without a duration, or either is no usable number; if the duration is below 1e-6 or above
        1e5 cycles.
    TypeError
        If a law with memory does not say what it stores and loses (`energy(x, z)`, `losses(x, v, z)`).
    SolveError
        If the integration does not reach the end.
    """
    system = with_parts("energy_balance", system, "J", "B", "law", "excitation", "omega", "error")
    names = [OWN_DAMPING, *_lossy_parts(system.law)]
    if isinstance(start, Orbit):
        if not start.status:
            raise ValueError(f"no orbit was found: {start.message}")
        system = system._replace(omega=start.omega)
        duration = 2.0 * np.pi * start.period / start.omega if duration is None else duration
        start = start.state(0.0)
    if duration is None:
        raise ValueError("the start is a state; give the duration of the motion too, in s")
    duration = number("duration [s]", duration, positive=True)
    _refuse_duration(system, duration)
    rtol = number("rtol", rtol, positive=True)
    states = 2 + states_of(system.law)
    y0 = numbers("the start", start)
    if y0.shape != (states,):
        raise ValueError(f"the start is {shown(start)}; it must be {', '.join(system.state_names())}")
    begin = (*y0.tolist(), *(0.0,) * (2 + len(names)))
    sizes = np.max(np.abs(_run(system, begin, duration, Dopri5(rtol=FIRST_TOLERANCE))), axis=1)
    smallest = float(np.min(sizes[sizes > 0.0], initial=1.0))
    y = _run(system, begin, duration, Dopri5(rtol=rtol, atol=max(1e-2 * rtol * smallest, 1e-300)))
    work, error_work, *losses = map(float, y[states:, -1])
    omega, end = system.omega, y[:states, -1]
    stored = _stored(system, omega * duration, end) - _stored(system, 0.0, y[:states, 0])
    return EnergyBalance(duration, work, error_work, dict(zip(names, losses, strict=True)), stored)


def _refuse_duration(system: Any, duration: float) -> None:
    """Refuse a stretch [s] in which nothing moves, or that no computer steps through (ValueError)."""
    stiffness = 0.0 if lacking(system.law, "stiffness") else abs(float(system.law.stiffness(0.0)))
    fastest = max(abs(system.omega) * max((1, *system.orders())), math.sqrt(stiffness / system.J))
    period = 2.0 * math.pi / (fastest or 1.0)
    shortest, longest = FEWEST_CYCLES * period, MOST_CYCLES * period
    if not shortest <= duration <= longest:
        raise ValueError(
            f"duration [s] is {duration:g}; give one from {shortest:.3g} to {longest:.3g} s, {FEWEST_CYCLES:g} to "
            f"{MOST_CYCLES:g} cycles of the fastest vibration: below, energies differ by rounding alone"
        )


def _run(system: System, start: tuple[float, ...], duration: float, method: Dopri5) -> Floats:
    """States, works and losses (rows, n) from a start over a time [s]."""
    run = simulate(Powers(system), start, (0.0, duration), method=method)
    if not run.status:
        raise SolveError(f"the integration for the energy balance {run.message}")
    return run.y


def _stored(system: Any, phase: float, y: Floats) -> float:
    """Kinetic energy and energy in the law [J]."""
    state = tuple(float(value) for value in y)
    return float(0.5 * system.J * state[1] ** 2 + energy_of(system.law, system.torsion(phase, state), state[2:]))


def _lossy_parts(law: Law) -> list[str]:
    """Names of the parts of a law that lose energy, in the order of its losses; the second of a kind "BoucWen 2"."""
    names: list[str] = []
    for part in _innermost(law):
        if depends(part) < 2:
            continue
        name = type(part).__name__
        missing = lacking(part, "energy", "losses") if depends(part) == 3 else ()
        if missing:
            raise TypeError(
                f"{name} has no method {' and no method '.join(missing)}; an energy balance needs energy(x, z) and "
                "losses(x, v, z) of a law with memory"
            )
        count = sum(other.partition(" ")[0] == name for other in names)
        names.append(f"{name} {count + 1}" if count else name)
    return names


def _innermost(law: Any) -> Iterator[Any]:
    """Parts of a law that are not made of others."""
    parts = parts_of(law)
    if not parts:
        yield law
    for part in parts:
        yield from _innermost(part)


@dataclass(frozen=True)
class Efficiency:
    """Output over input power of a gear at constant speed.

    Attributes
    ----------
    torque : (loads,) array
        Torque [N*m, output side] that the gear transmits.
    speed : (speeds,) array
        Speed of the motor [rad/s].
    driving : (speeds, loads) array
        The motor drives the load: T v/N over the motor's power.
    back_driving : (speeds, loads) array
        The load drives the motor: power that arrives there over T v/N. Negative where the load alone does not turn it.
    back_driving_torque : (speeds,) array
        Torque [N*m, output side] with which the load alone keeps the motor turning.
    """

    torque: Floats
    speed: Floats
    driving: Floats
    back_driving: Floats
    back_driving_torque: Floats

    def __str__(self) -> str:
        low, high = float(np.min(self.driving)), float(np.max(self.driving))
        rpm = self.speed / RPM
        return (
            f"Efficiency at {self.torque.min():.4g} to {self.torque.max():.4g} N*m and {rpm.min():.4g} to "
            f"{rpm.max():.4g} rpm of the motor: {100 * low:.1f} to {100 * high:.1f} %; back-driving from "
            f"{self.back_driving_torque.min():.3g} N*m"
        )

    __repr__ = __str__


def efficiency(train: Any, torque: ArrayLike, speed: ArrayLike) -> Efficiency:
    """Find the efficiency of a train's gear over load and speed.

    At the constant motor speed v a motor that drives the load torque T gives (T + T_f)/N + T_d, and one that the load
    drives receives (T - T_f)/N - T_d: T_f is the friction of the meshing at T and v, T_d the motor's drag at v.

    Parameters
    ----------
    train : DriveTrain
        The train: its ratio, its `friction` and the drag of its motor count.
    torque : float or (loads,) array_like
        Torques T [N*m, output side] that the gear transmits; positive.
    speed : float or (speeds,) array_like
        Speeds of the motor [rad/s]; positive.

    Returns
    -------
    Efficiency
        Efficiencies `driving` and `back_driving`, (speeds, loads) arrays of shares up to 1; the second is negative
        where the load alone does not turn the motor. `back_driving_torque` (speeds,) [N*m, output side] keeps it
        turning.

    Raises
    ------
    ValueError
        If a torque or a speed is not positive.
    TypeError
        If `train` is not a drive train, or its motor's drag has memory.
    """
    train = with_parts("efficiency", train, "power_names")
    drag = train.motor.drag
    if states_of(drag):
        raise TypeError(
            f"efficiency needs a drag that depends on speed only, but the motor has {shown(drag)}; give Coulomb, "
            "Stribeck or Viscous"
        )
    T, v = _positive("torque [N*m]", torque), _positive("speed [rad/s]", speed)
    N, column = train.N, v[:, None]
    of_drag = np.array([float(torque_of(drag, 0.0, float(speed), ())) for speed in v])
    mesh = train.friction.torque(T, column) + 0.0 * column
    given, left = (T + mesh) / N + of_drag[:, None], (T - mesh) / N - of_drag[:, None]
    share = train.friction.torque(1.0, v) + 0.0 * v
    return Efficiency(T, v, T / N / given, left / (T / N), N * of_drag / (1.0 - share))


def _positive(name: str, values: ArrayLike) -> Floats:
    """Checked positive numbers (n,)."""
    checked_values = numbers(name, values)
    if not np.all(checked_values >= SMALLEST):
        raise ValueError(f"{name} is {shown(values)}; give positive numbers, {SMALLEST:g} at least")
    return checked_values
