"""Single speeds in time: which, from rest to the steady motion, torque through the gear, energy of a cycle."""

import cmath
import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ....base.results import Floats, SolveError, Trajectory, largest_between
from ....base.series import largest_of_samples
from ....drive.demands.usage import Usage, largest_usage
from ....drive.drive_response import DriveResponse
from ....drive.equation.gear_torque import (
    damping_of,
    gear_torque,
    heat,
    loses_energy,
    no_multiple_scales,
    settling_time,
)
from ....model.gears.limits import cubic_mean
from ....numerics.integration.record import uninterrupted
from ....numerics.integration.simulate import simulate
from ....numerics.steady import SteadyMotion, settle, settled
from ....theory.resonance import Resonance
from ....theory.slow_flow.flow import slow_flow
from ...speed_map.error_equation import OperatingPoint
from ..regimes import Regime
from .comparison import Comparison, compare_with_integration
from .run_up_check import RunUp

WINDOW = 5.0  # in units of 1/mu
PER_CYCLE = 24  # samples per fastest cycle of a transient
MOST_SAMPLES = 60_000  # samples of a transient
MOST_CASES = 4  # resonances shown in time, besides a speed away from all of them
AWAY_NAME, MIDDLE_NAME = "farthest from the resonances in the range", "middle of the range"
PRIORITY = ("primary", "superharmonic 3:1", "superharmonic 2:1", "subharmonic 1:3", "subharmonic 1:2")


@dataclass(frozen=True, eq=False)
class Cycle:
    """Steady motion over whole periods, with its torques and energies.

    Attributes
    ----------
    t, x, v, u, torque : (n,) arrays
        Time [s], dynamic error [rad], its rate [rad/s], torsion [rad] and transmitted torque T + B u' [N*m,
        output side].
    peak_torque, mean_torque : float
        Largest absolute and mean transmitted torque [N*m].
    dissipated, work : float
        Energy [J] that damping and law take and the excitation gives per turn of the base angle; equal when steady.
    power : float
        Mean power lost [W].
    peak, peak_to_peak, oscillation : float
        Largest |x|, largest minus smallest x, and largest |x - mean| [rad].
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
    oscillation: float


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
        The regime of multiple scales.
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
    steady_theory : (n,) array or None
        x [rad] of multiple scales at the times of `cycle`, after the same settling time from rest.
    amplitudes : (float or None, float or None)
        Steady 0-to-peak amplitude [rad] of the torsion's component at (p/q) omega by multiple scales and by
        integration.
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
    steady_theory: Floats | None
    amplitudes: tuple[float | None, float | None]
    reason: str


def time_case(name: str, system: Any, resonance: Resonance, point: OperatingPoint) -> TimeCase:
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
    start = point.start
    steady = _settled(system, start, resonance.q or 1)
    cycle = cycle_of(system, steady) if steady.status else None
    comparison, reason = None, ""
    try:
        if reason := no_multiple_scales(system):
            raise ValueError(reason)
        window = None if damping_of(system) > 0.0 else settling_time(system)
        comparison = compare_with_integration(system, resonance, (point.x, 0.0), window)
        transient = uninterrupted(comparison.integrated)
    except (ValueError, SolveError, ArithmeticError) as error:
        reason = str(error) or f"multiple scales stopped with {type(error).__name__}"
        transient = uninterrupted(simulate(system, start, _times(system, point)))
    theory, amplitude = None, None
    if comparison is not None and cycle is not None:
        theory, amplitude = _steady_theory(comparison, cycle.t)
    ratio = resonance.ratio
    simulated = None if ratio is None or cycle is None else steady.torsion_amplitude(float(ratio))
    return TimeCase(
        name=name, omega=system.omega, resonance=resonance, transient=transient, peak_from_rest=transient.peak(),
        steady=steady, cycle=cycle, comparison=comparison, steady_theory=theory, amplitudes=(amplitude, simulated),
        reason=reason,
    )  # fmt: skip


def _times(system: Any, point: OperatingPoint) -> Floats:
    """Times of the transient: until it has fallen to exp(-2.5), or some periods where nothing decays."""
    mu = damping_of(system) / system.J
    length = WINDOW / mu if mu > 0.0 else settling_time(system)
    fastest = max(point.omega_0, system.omega * max((1, *system.orders())))
    return np.linspace(0.0, length, min(MOST_SAMPLES, PER_CYCLE * math.ceil(length * fastest / (2.0 * math.pi)) + 1))


def _settled(system: Any, start: tuple[float, ...], period: int) -> SteadyMotion:
    """Motion after the transient; more of it is simulated until the orbit that closes is a stable one."""
    if loses_energy(system):
        return settled(system, start, time=settling_time(system), period=period, stable=True)
    return settle(system, start, time=settling_time(system), period=period)


def _steady_theory(comparison: Comparison, t: Floats) -> tuple[Floats, float | None]:
    """Steady motion of multiple scales on which the compared transient ends, and its amplitude near omega_0."""
    system, resonance, run = comparison.system, comparison.resonance, comparison.theory
    flow = slow_flow(system, resonance)
    z = flow.attractor(cmath.rect(float(run.amplitude[-1]), -float(run.phase[-1])))
    if z is None:  # not clear yet, or undamped: go on
        turn = 2.0 * math.pi / system.omega * (resonance.q or 1)
        later = turn * math.ceil(3.0 * settling_time(system) / turn)
        run = flow.evolve((float(run.x[-1]), float(run.rate[-1])), np.concatenate([run.t[-1:], later + t]))
        x, amplitude = run.x[1:], float(run.amplitude[-1])
    else:
        x, amplitude = flow.steady_x(z, t), abs(z)
    return x, None if resonance.ratio is None else amplitude


def cycle_of(system: Any, steady: SteadyMotion) -> Cycle:
    """Torque and energy of a steady motion.

    Damping, friction and memory take the integral of B u'^2 and of the law's losses; the excitation gives that of
    tau x' - (T + B u') e', the second term being the work of the motor through the kinematic error.

    Parameters
    ----------
    system : Oscillator
        The system that the motion belongs to.
    steady : SteadyMotion
        Its samples, equidistant over whole periods.
    """
    phase = system.omega * steady.t
    u = steady.u
    e_rate = system.omega * system.error.slope(phase)
    du = steady.v - e_rate
    z = tuple(steady.z)
    torque = np.asarray(gear_torque(system, phase, u, du, z))
    tau = np.broadcast_to(system.excitation.torque(phase), phase.shape)
    span = float(steady.t[-1])
    turns = steady.period
    dissipated = float(np.mean(heat(system, phase, u, du, z)[:-1])) * span / turns
    work = float(np.mean((tau * steady.v - torque * e_rate)[:-1])) * span / turns
    away, v = steady.x - float(np.mean(steady.x[:-1])), steady.v
    return Cycle(
        t=steady.t, x=steady.x, v=v, u=u, torque=torque, peak_torque=float(np.max(np.abs(torque))),
        mean_torque=float(np.mean(torque[:-1])), dissipated=dissipated, work=work, power=dissipated * turns / span,
        peak=steady.peak, peak_to_peak=float(np.ptp(steady.x)),
        oscillation=largest_between(np.diff(steady.t), away[:-1], v[:-1], away[1:], v[1:]),
    )  # fmt: skip


def speeds_in_time(
    all_regimes: tuple[Regime, ...], sweep: RunUp, limits: tuple[float, float], asked: tuple[float, ...]
) -> list[tuple[str, float, Regime | None]]:
    """Speeds to show in time: those requested, or the main resonances in the range and one place far from them."""
    if asked:
        return [_nearest(omega, all_regimes) for omega in asked]
    inside = [regime for regime in all_regimes if regime.inside]
    inside.sort(key=lambda regime: (PRIORITY.index(regime.name), regime.order))
    away = _away(inside, limits)
    chosen: list[tuple[str, float, Regime | None]] = [(AWAY_NAME if inside else MIDDLE_NAME, away, None)]
    chosen += [(regime.label, regime.place, regime) for regime in inside[:MOST_CASES]]
    if not inside and (worst := sweep.worst()) is not None:
        chosen.append(("largest error of the run-up", worst.omega, None))
    return chosen


def _nearest(omega: float, all_regimes: tuple[Regime, ...]) -> tuple[str, float, Regime | None]:
    """Name a speed that was requested by the resonance it sits on (within 5 %), if any."""
    close = [regime for regime in all_regimes if abs(regime.place / omega - 1.0) < 0.05]
    if not close:
        return "speed of the file", omega, None
    regime = min(close, key=lambda r: abs(r.place / omega - 1.0))
    return f"near {regime.label}", omega, regime


def _away(inside: list[Regime], limits: tuple[float, float]) -> float:
    """Speed [rad/s] in the range that is relatively farthest from every resonance in it."""
    grid = np.linspace(*limits, 201)
    if not inside:
        return float(grid[len(grid) // 2])
    nearest = np.min([np.abs(np.log(grid / regime.place)) for regime in inside], axis=0)
    return float(grid[int(np.argmax(nearest))])


def usage(system: Any, exact: DriveResponse, motions: Iterable[SteadyMotion]) -> Usage:
    """Find the largest torques in the gear over the steady motions that were found.

    Parameters
    ----------
    system : Oscillator
        The error equation; its omega is replaced.
    exact : DriveResponse
        Response curve, of which the stable motions count.
    motions : iterable of SteadyMotion
        Simulated motions, which count too where they finished: some are on no curve.
    """
    every = [exact.usage] if len(exact.counted) else []
    for motion in (motion for motion in motions if motion.status):
        omega = float(motion.omega)
        torque = cycle_of(system._replace(omega=omega), motion).torque
        every.append(Usage(float(largest_of_samples(torque[None])[0]), omega, cubic_mean(torque), omega))
    return largest_usage(*every)
