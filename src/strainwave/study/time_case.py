"""One speed in time: from rest to the steady motion, the torque through the gear, and the energy of a cycle."""

import math
from dataclasses import dataclass

import numpy as np

from ..model.oscillator import Oscillator
from ..numerics.integrate import simulate
from ..results import Floats, SolveError, Status, Trajectory
from ..theory.resonance import Resonance
from .regimes import OperatingPoint
from .runup import UNDAMPED_PERIODS, settling_time
from .steady import SteadyMotion, settle
from .validate import Comparison, compare

PER_CYCLE = 24  # samples per fastest cycle of a transient
MOST = 60_000  # samples of a transient


@dataclass(frozen=True, eq=False)
class Cycle:
    """One span of the steady motion with what follows from it.

    Attributes
    ----------
    t, x, v, u, torque : (n,) arrays
        Time [s], dynamic error [rad], its rate [rad/s], torsion [rad] and transmitted torque T(u) + B u' [N*m, output side].
    peak_torque, mean_torque : float
        Largest absolute and mean transmitted torque [N*m].
    dissipated, work : float
        Energy [J] that the damping takes and the excitation gives per turn of the base angle; equal in a steady motion.
    power : float
        Mean power lost in the damping [W].
    peak, peak_to_peak : float
        Largest |x| and largest minus smallest x [rad].
    """

    t: Floats
    x: Floats
    v: Floats
    u: Floats
    torque: Floats
    peak_torque: float
    mean_torque: float
    dissipated: float
    work: float
    power: float
    peak: float
    peak_to_peak: float


@dataclass(frozen=True, eq=False)
class TimeCase:
    """The drive at one speed.

    Attributes
    ----------
    name : str
        "primary, order 2", "no resonance", ...
    omega : float
        Speed of the base angle [rad/s].
    resonance : Resonance
        The regime that multiple scales is asked for.
    transient : Trajectory
        Simulation from the static equilibrium at rest.
    peak_from_rest : float
        Largest |x| [rad] of the transient.
    steady : SteadyMotion
        What it settles on.
    cycle : Cycle or None
        Torque and energy of the steady motion; None where the simulation did not finish.
    comparison : Comparison or None
        Multiple scales against integration from the same start.
    amplitudes : (float or None, float or None)
        Steady 0-to-peak amplitude [rad] of the component at (p/q) omega by multiple scales and by integration.
    reason : str
        Why there is no comparison, empty where there is one.
    """

    name: str
    omega: float
    resonance: Resonance
    transient: Trajectory
    peak_from_rest: float
    steady: SteadyMotion
    cycle: Cycle | None
    comparison: Comparison | None
    amplitudes: tuple[float | None, float | None]
    reason: str


def time_case(name: str, system: Oscillator, resonance: Resonance, point: OperatingPoint) -> TimeCase:
    """Simulate one speed from rest and compare with multiple scales.

    Parameters
    ----------
    name : str
        Name for the report.
    system : Oscillator
        The error equation at the speed in question.
    resonance : Resonance
        Regime of the comparison.
    point : OperatingPoint
        The start: the static equilibrium, at rest.
    """
    start = (point.x, 0.0)
    transient = simulate(system, start, _times(system, point))
    steady = settle(system, start, time=3.0 * settling_time(system), period=resonance.q or 1)
    cycle = cycle_of(system, steady) if steady.status else None
    comparison, reason = None, ""
    if not transient.status:
        reason = f"the simulation from rest {transient.message}"
    else:
        try:
            comparison = compare(system, resonance, start)
        except (ValueError, SolveError, ArithmeticError, NotImplementedError) as error:
            reason = str(error) or f"multiple scales stopped with {type(error).__name__}"
    amplitudes = _amplitudes(resonance, steady, comparison)
    peak = transient.peak()
    return TimeCase(name, system.omega, resonance, transient, peak, steady, cycle, comparison, amplitudes, reason)


def _times(system: Oscillator, point: OperatingPoint) -> Floats:
    """Times of the transient: five decay times exp(-5/2), or some periods where nothing decays."""
    mu = system.B / system.J
    length = 10.0 / mu if mu > 0.0 else UNDAMPED_PERIODS * 2.0 * math.pi / system.omega
    fastest = max(point.omega_0, system.omega * max((1, *system.orders())))
    return np.linspace(0.0, length, min(MOST, PER_CYCLE * math.ceil(length * fastest / (2.0 * math.pi)) + 1))


def _amplitudes(
    resonance: Resonance, steady: SteadyMotion, comparison: Comparison | None
) -> tuple[float | None, float | None]:
    ratio = resonance.ratio
    if ratio is None or comparison is None or not steady.status:
        return None, None
    theory = float(comparison.theory.amplitude[-1])
    return theory, steady.amplitude(float(ratio))


def cycle_of(system: Oscillator, steady: SteadyMotion) -> Cycle:
    """Torque and energy of a steady motion.

    The damping takes the integral of B u'^2; the excitation gives that of tau x' - (T(u) + B u') e', the second term being the
    work of the motor through the kinematic error.

    Parameters
    ----------
    system : Oscillator
        The system that the motion belongs to.
    steady : SteadyMotion
        Its samples, equidistant over whole periods.
    """
    phase = system.omega * steady.t
    u = steady.x - system.error.value(phase)
    e_rate = system.omega * system.error.slope(phase)
    du = steady.v - e_rate
    torque = system.law.torque(u) + system.B * du
    tau = np.broadcast_to(system.excitation.torque(phase), phase.shape)
    span = float(steady.t[-1])
    turns = steady.period
    dissipated = float(np.mean((system.B * du * du)[:-1])) * span / turns
    work = float(np.mean((tau * steady.v - torque * e_rate)[:-1])) * span / turns
    return Cycle(
        steady.t, steady.x, steady.v, u, torque,
        float(np.max(np.abs(torque))), float(np.mean(torque[:-1])), dissipated, work, dissipated * turns / span,
        steady.peak, float(np.ptp(steady.x)),
    )  # fmt: skip


def diverged(case: TimeCase) -> bool:
    """Whether the simulation of a case left every bound."""
    return Status.DIVERGED in (case.transient.status, case.steady.status)
