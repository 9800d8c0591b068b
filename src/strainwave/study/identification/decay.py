"""`fit_decay`: a measured free decay to frequency and damping against amplitude, and to the law behind them.

A free decay computed by averaging: the undamped vibration of every amplitude, and how fast the damping leads down.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np
from scipy.interpolate import CubicHermiteSpline, CubicSpline
from scipy.optimize import least_squares

from ...base.law import depends, energy_of, has, states_of, torque_of
from ...base.protocols import Law, System, with_parts
from ...base.records import Along
from ...base.results import Floats, SolveError
from ...base.sentences import on_screen
from ...compile.tree import leaves as numbers_in
from ...model.laws import Coulomb, Parallel, Polynomial, QuadraticDamping
from .discrepancy import discrepancy
from .fitted import Fitted, derivatives, free_leaves, refuse_unidentifiable, scales, with_values
from .intervals import spread
from .waves import ASIDE, Waves, checked_record, decaying_waves

STEP = 1e-6  # of a parameter, for derivatives
SMALLEST = 0.6  # of the smallest amplitude measured: where the table of vibrations begins
FLOOR = 1e-4  # of the frequency: no window is believed more than that, the law is only near
FAR = 1.0  # of its size: what a parameter may be off its start
NO_START = 0.01  # of its size 1: where a parameter that is 0 begins
TERM = 1e-5  # of the largest torque: a term by which its effect is found
SHARP = 1e-9  # of the largest speed: over which dry friction that is tried changes its sign
NUISANCES = 3  # logarithm of the first extreme, first phase, offset

ANGLES = 96  # of theta in half a vibration
SIZES = 40  # amplitudes of the table
HARMONICS = 9
NODES = 400  # of the decay in time
NEWTON = 30  # steps to the other extreme
SLOWEST = 1e-7  # decay rate and frequency at least, over the undamped frequency


class Vibrations(NamedTuple):
    """Undamped vibrations (n,) by their upper extreme.

    Attributes
    ----------
    extreme : (n,) array
        Upper extreme x+ [rad].
    omega : (n,) array
        Angular frequency [rad/s].
    rate : (n,) array
        -(d x+/dt)/x+ [1/s] by the damping.
    coefficients : (H+1, n) array
        Cosine coefficients of x: mean, first harmonic, ...
    """

    extreme: Floats
    omega: Floats
    rate: Floats
    coefficients: Floats


def vibrations(system: Any, extreme: Floats) -> Vibrations:
    """Undamped vibrations about rest, and what the damping does to them.

    Raises
    ------
    ValueError
        If the law has no potential to vibrate in.
    """
    law, J = system.law, system.J
    top = energy_of(law, extreme, ()) + 0.0 * extreme
    low = _other_extreme(law, extreme, top)
    middle, half = 0.5 * (extreme + low), 0.5 * (extreme - low)
    theta = np.pi * (np.arange(ANGLES) + 0.5)[:, None] / ANGLES
    x = middle + half * np.cos(theta)
    depth = top - energy_of(law, x, ())
    if not np.all(depth > 0.0):
        raise ValueError(f"{type(law).__name__} does not hold a vibration of {np.max(extreme):.4g} rad: it pushes away")
    pace = half * np.sin(theta) / np.sqrt(2.0 * depth / J)  # dt/dtheta
    quarter = np.fft.rfft(np.concatenate([pace, pace[::-1]]), axis=0) / (2 * ANGLES)
    k = np.arange(1, ANGLES)[:, None]
    waves = 2.0 * np.real(quarter[1:ANGLES] * np.exp(-0.5j * np.pi * k / ANGLES))
    slow = np.real(quarter[:1])
    t = slow * theta + np.einsum("ik,kj->ij", np.sin(theta * k.T), waves / k)
    omega = 1.0 / slow[0]
    weights = pace * (omega / ANGLES)  # mean over half a vibration
    order = np.arange(HARMONICS + 1)
    both = np.cos(order[:, None, None] * (omega * t))
    coefficients = np.einsum("kij,ij->kj", both, x * weights) * np.where(order == 0, 1.0, 2.0)[:, None]
    v = half * np.sin(theta) / pace
    friction = torque_of(law, x, v, ()) - torque_of(law, x, -v, ())
    heat = np.sum(weights * v * (system.B * v + 0.5 * friction), axis=0)
    pull = torque_of(law, extreme, 0.0, ())
    return Vibrations(extreme, omega, heat / (pull * extreme), coefficients)


def _other_extreme(law: Law, extreme: Floats, top: Floats) -> Floats:
    """Lower extremes (n,) at which the energy is that of the upper ones."""
    low = -extreme
    for _ in range(NEWTON):
        slope = torque_of(law, low, 0.0, ())
        step = np.divide(energy_of(law, low, ()) - top, slope, out=np.zeros_like(low), where=slope != 0.0)
        low = low - step
        if np.all(np.abs(step) <= 1e-13 * np.abs(low)):
            break
    return low


class Decay(NamedTuple):
    """A decay in time: splines over the logarithm of the extreme, and that logarithm and the phase over time."""

    size: Any
    phase: Any
    shape: Any

    def motion(self, t: Floats) -> Floats:
        """Motion [rad] at times [s] from the start on."""
        turns = np.outer(self.phase(t), np.arange(self.shape.c.shape[2]))
        return np.asarray(np.sum(self.shape(self.size(t)) * np.cos(turns), axis=1))


def decay(system: System, start: float, phase: float, least: float) -> Decay:
    """Free decay from an upper extreme [rad] and a phase [rad] at t = 0.

    Parameters
    ----------
    system : Oscillator
        Its excitation and error are left out.
    start, phase : float
        Extreme and phase of the vibration at t = 0.
    least : float
        Smallest extreme that is reached.
    """
    table = vibrations(system, np.geomspace(min(least, 0.9 * start), start, SIZES))
    log_extreme = np.log(table.extreme)
    rate = np.maximum(table.rate, SLOWEST * table.omega)
    # With z'' + 2 rate z' + omega^2 z = 0 the frequency is sqrt(omega^2 - rate^2 - d rate/dt).
    less = rate * (rate - CubicSpline(log_extreme, rate).derivative()(log_extreme))
    omega = np.sqrt(np.maximum(table.omega**2 - less, (SLOWEST * table.omega) ** 2))
    nodes = np.linspace(log_extreme[-1], log_extreme[0], NODES)
    elapsed = CubicSpline(log_extreme, 1.0 / rate).antiderivative()
    turned = CubicSpline(log_extreme, omega / rate).antiderivative()
    time, swing = elapsed(log_extreme[-1]) - elapsed(nodes), phase + turned(log_extreme[-1]) - turned(nodes)
    size = CubicHermiteSpline(time, nodes, -CubicSpline(log_extreme, rate)(nodes))
    angle = CubicHermiteSpline(time, swing, CubicSpline(log_extreme, omega)(nodes))
    return Decay(size, angle, CubicSpline(log_extreme, table.coefficients.T))


@dataclass(frozen=True, eq=False)
class DecayFit(Fitted):
    """A free decay: backbone and damping against amplitude as measured, and the system that was fitted.

    Attributes
    ----------
    system, names, values, covariance, freedom, discrepancy
        As of `Fitted`; the terms tried are drag |v| v, dry friction sign v and x^3, in N*m.
    time : (m,) array
        Middles of the windows [s].
    amplitude, amplitude_deviation : (m,) arrays
        Amplitude of the first harmonic, 0-to-peak [rad], and its standard deviation.
    omega, omega_deviation : (m,) arrays
        Angular frequency of the vibration [rad/s].
    rate, rate_deviation : (m,) arrays
        Decay rate -(d amplitude/dt)/amplitude [1/s]; over omega it is the damping ratio.
    fitted_omega, fitted_rate : (m,) arrays
        Those of the system at the same amplitudes.
    """

    time: Floats
    amplitude: Floats
    amplitude_deviation: Floats
    omega: Floats
    omega_deviation: Floats
    rate: Floats
    rate_deviation: Floats
    fitted_omega: Floats
    fitted_rate: Floats

    rows: ClassVar[str] = "window"
    arrays: ClassVar[Along] = {
        "window": {
            "time": "s", "amplitude": "rad", "omega": "rad/s", "rate": "1/s", "amplitude_deviation": "rad",
            "omega_deviation": "rad/s", "rate_deviation": "1/s", "fitted_omega": "rad/s", "fitted_rate": "1/s",
        },
    }  # fmt: skip

    def __str__(self) -> str:
        first, last = self.amplitude[0], self.amplitude[-1]
        lines = [
            f"Free decay: amplitude {first:.4g} to {last:.4g} rad in {len(self.time)} windows",
            f"  frequency {self.omega[0]:.6g} to {self.omega[-1]:.6g} rad/s, damping ratio "
            f"{self.rate[0] / self.omega[0]:.4g} to {self.rate[-1] / self.omega[-1]:.4g}",
            *self.lines(),
            f"  {self.discrepancy}",
        ]
        return on_screen("\n".join(lines))


def fit_decay(time: Any, value: Any, system: System, *, free: Sequence[str] = ("B", "law.K")) -> DecayFit:
    """Find the frequency and the damping of a free decay against its amplitude, and the law that has them.

    First windows of three cycles give amplitude, frequency and decay rate without any law. Then the free parameters
    are fitted to them, and with these as a start to all samples: by the vibrations of the undamped system, which the
    damping leads down (averaging). That is right for damping ratios up to some per cent: its frequency is off by about
    the square of the damping ratio, and friction's own harmonics are left out.

    Parameters
    ----------
    time : (n,) array_like
        Rising times [s]; they may be uneven.
    value : (n,) array_like
        Torsion or dynamic error [rad], free of excitation from the first sample on. An offset is allowed for.
    system : Oscillator
        The system with start values within a factor of about 2; springs, and friction in parallel with them, whose
        torque has no memory. Excitation, omega and error are left out. A free vibration tells no torque: J, B and the
        law are known up to a common factor, so fix one of them, usually J.
    free : sequence of str
        Paths of the parameters to find, such as ("B", "law.K", "law.alpha").

    Returns
    -------
    DecayFit
        `system` with the numbers found, in SI; `value(path)` and `interval(path)`; measured in each window, (windows,)
        arrays: frequency `omega` [rad/s], decay `rate` [1/s] and `amplitude` [rad, 0-to-peak].

    Raises
    ------
    ValueError
        If there is no decaying vibration of one frequency in the record, a path does not exist, or the decay does not
        tell a parameter: the sentence says which combination it tells.
    TypeError
        If the law has memory.
    SolveError
        If no values of the parameters vibrate as was measured.
    """
    system = _vibrating(system)
    t, y = checked_record(time, value)
    leaves, sizes = free_leaves(system, free), scales(system, free)
    waves = decaying_waves(t, y)
    origin, t, y = t[0], t[: waves.end] - t[0], y[: waves.end]
    waves = waves._replace(time=waves.time - origin)
    start = _fitted_to_windows(system, leaves, sizes, waves)
    model = _Model(system, leaves, sizes, SMALLEST * float(np.min(waves.amplitude)), t)
    first = _nuisances(model, start, waves)
    solution = least_squares(lambda p: model.motion(p) - y, first, x_scale=model.steps(first), method="lm", xtol=1e-12)
    residual = y - model.motion(solution.x)
    left = float(residual @ residual) / float(np.sum((y - np.mean(y)) ** 2))
    if not left < ASIDE:
        raise SolveError(
            f"the fitted system leaves {100.0 * left:.2g} % of the motion's power: its law is another one, or two "
            "frequencies beat; free more parameters, change the law, or filter one mode out"
        )
    jacobian = model.jacobian(solution.x)
    refuse_unidentifiable(
        jacobian, [*free, "amplitude", "phase", "offset"], np.append(solution.x[:-NUISANCES], [1, 1, 1])
    )
    scatter, p = spread(jacobian, residual), len(leaves)
    units = np.outer(sizes, sizes)
    system = with_values(system, leaves, solution.x[:p] * sizes)
    fitted_omega, fitted_rate = _curves(system, waves.amplitude)
    return DecayFit(
        system, tuple(free), solution.x[:p] * sizes, scatter.covariance[:p, :p] * units, scatter.freedom[:p],
        discrepancy(residual, jacobian, model.terms(solution.x), interval=float(np.mean(np.diff(t)))),
        waves.time + origin, waves.amplitude, waves.amplitude_deviation, waves.omega, waves.omega_deviation, waves.rate,
        waves.rate_deviation, fitted_omega, fitted_rate,
    )  # fmt: skip


def _vibrating(system: Any) -> Any:
    """Checked system whose law has an energy and no memory (TypeError)."""
    system = with_parts("fit_decay", system, "J", "B", "law")
    law = system.law
    if states_of(law) or not (has(law, "energy") and depends(law) in (1, 3)):
        raise TypeError(
            f"fit_decay takes springs with energy(x), alone or in Parallel with friction; {type(law).__name__} "
            f"{'has memory' if states_of(law) else 'stores no energy'}"
        )
    return system


class _Model:
    """Motion at the samples as a function of (parameters over their sizes, log of first extreme, phase, offset)."""

    def __init__(self, system: System, leaves: list[int], sizes: Floats, least: float, t: Floats) -> None:
        self.system, self.leaves, self.sizes, self.least, self.t = system, leaves, sizes, least, t

    def at(self, p: Floats) -> Any:
        """The system with these parameters."""
        return with_values(self.system, self.leaves, p[:-NUISANCES] * self.sizes)

    def motion(self, p: Floats, system: Any = None) -> Floats:
        """Motion (n,) [rad], of another system where one is given."""
        try:
            with np.errstate(all="ignore"):
                system = self.at(p) if system is None else system
                extreme, phase = float(np.exp(p[-3])), float(p[-2])
                x = decay(system, extreme, phase, self.least).motion(self.t) + p[-1]
        except ValueError:
            x = np.full(len(self.t), np.inf)
        return np.asarray(np.where(np.isfinite(x), x, 1e6 * np.exp(p[-3])))

    def terms(self, p: Floats) -> dict[str, Floats]:
        """What terms that the law may lack change in the motion (n,), per unit of their coefficient."""
        system, base, changes = self.at(p), self.motion(p), {}
        size = float(np.exp(p[-3]))
        pull = float(torque_of(system.law, size, 0.0, ()))
        speed = size * float(vibrations(system, np.array([size])).omega[0])
        terms: dict[str, tuple[Callable[[float], Any], float]] = {
            "|v| v": (QuadraticDamping, speed**2), "sign v": (lambda T_c: Coulomb(T_c, SHARP * speed), 1.0),
            "x^3": (lambda c: Polynomial((0.0, 0.0, 0.0, c)), size**3),
        }  # fmt: skip
        for name, (term, unit) in terms.items():
            step = TERM * pull / unit
            other = system._replace(law=Parallel(system.law, term(step)))
            changes[name] = (self.motion(p, other) - base) / step
        return changes

    def steps(self, p: Floats) -> Floats:
        """Sizes of the unknowns for the solver."""
        return np.append(np.maximum(np.abs(p[:-NUISANCES]), 0.1), [1.0, 1.0, np.exp(p[-3])])

    def jacobian(self, p: Floats) -> Floats:
        """Derivatives (n, unknowns) by central differences."""
        return derivatives(self.motion, p, STEP * self.steps(p))


def _curves(system: System, amplitude: Floats) -> tuple[Floats, Floats]:
    """Frequency [rad/s] and decay rate [1/s] of the first harmonic at its amplitudes (m,)."""
    extreme = amplitude
    for _ in range(6):
        found = vibrations(system, extreme)
        extreme = extreme * amplitude / np.abs(found.coefficients[1])
    table = vibrations(system, np.geomspace(0.8 * extreme.min(), 1.2 * extreme.max(), 40))
    at, size = np.log(table.extreme), np.log(np.abs(table.coefficients[1]))
    return found.omega, found.rate * CubicSpline(at, size).derivative()(np.log(extreme))


def _fitted_to_windows(system: System, leaves: list[int], sizes: Floats, waves: Waves) -> Floats:
    """Parameters over their sizes, from frequencies and decay rates; near the start values where these do not tell."""

    def off(p: Floats) -> Floats:
        try:
            with np.errstate(all="ignore"):
                omega, rate = _curves(with_values(system, leaves, p * sizes), waves.amplitude)
            both = np.concatenate([(omega - waves.omega) / omega_error, (rate - waves.rate) / rate_error])
        except ValueError:
            both = np.full(2 * len(waves.time), np.inf)
        return np.append(np.where(np.isfinite(both), both, 1e6), (p - start) / FAR)

    omega_error = np.maximum(waves.omega_deviation, FLOOR * waves.omega)
    rate_error = np.maximum(waves.rate_deviation, FLOOR * waves.omega)
    values = np.array(numbers_in(system))[leaves]
    start = np.where(values == 0.0, NO_START, np.sign(values))
    return np.asarray(least_squares(off, start, x_scale="jac", max_nfev=200).x)


def _nuisances(model: _Model, start: Floats, waves: Waves) -> Floats:
    """All unknowns: the first extreme and phase such that the first window is met."""
    p = np.append(start, [np.log(waves.amplitude[0]), 0.0, waves.offset])
    for _ in range(8):
        motion = decay(model.at(p), float(np.exp(p[-3])), float(p[-2]), model.least)
        first = np.abs(motion.shape(motion.size(waves.time[:1]))[0, 1])
        if not 0.0 < first < np.inf:
            raise SolveError(
                "the system does not vibrate in the first window of the record; give it numbers nearer to those sought"
            )
        p[-3] += np.log(waves.amplitude[0] / first)
        p[-2] += waves.phase[0] - float(motion.phase(waves.time[0]))
    return p
