"""Periodic orbits by shooting: Newton's method on the period map.

Its derivative comes from the variational equations, integrated alongside, for a system of two states with a `jacobian`,
and from differences of the period map for any other. Independent of harmonic balance and exact for laws with
breakpoints, because the integration ends its steps on them.
(A continuous law needs no jump in the variational equations there.)

Seydel 2010, Practical Bifurcation and Stability Analysis, sec. 7.3-7.4 (shooting, monodromy matrix).
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..base.branch_labels import DECAYS
from ..base.law import breakpoints_of, torsion
from ..base.protocols import System, has_jacobian, omega_of, with_parts
from ..base.quantities import Reals, States, number, numbers, positive_count
from ..base.results import Floats, Orbit, SolveError, Status
from .balance.rates import periodic
from .integration.methods import Dopri5
from .integration.record import uninterrupted
from .integration.simulate import simulate

SAMPLES = 4096  # of the orbit, from which peak and Fourier coefficients are taken
STEPS = 60  # of Newton's method, begun anew wherever the motion goes on in time
HALVINGS = 5  # of a step of Newton's method that leads away from the orbit
LARGEST_STEP = 3.0  # largest step of it, in sizes of the motion
MOST_TURNS = 64  # periods that a motion goes on at a time
WHOLE_STEP = 1e-6  # of a state's size: steps below it are taken whole
DIFFERENCE = 1e-5  # of a state's size


class Variational(NamedTuple):
    """A system of two states together with the four entries of its fundamental matrix (columns one after the other)."""

    system: Any

    @property
    def omega(self) -> float:
        """Base speed [rad/s] of the system."""
        return float(omega_of(self.system))

    def breakpoints(self) -> tuple[float, ...]:
        """Torsions where the law is not smooth."""
        return tuple(breakpoints_of(self.system))

    def torsion(self, phase: Reals, y: States) -> Any:
        """Torsion of the system."""
        return torsion(self.system, phase, (y[0], y[1]))

    def rhs(self, phase: Reals, y: States) -> Any:
        """Rates of the states and of the fundamental matrix."""
        x, v, a, b, c, d = y
        first, second = self.system.rhs(phase, (x, v))
        (j00, j01), (j10, j11) = self.system.jacobian(phase, (x, v))
        return first, second, j00 * a + j01 * b, j10 * a + j11 * b, j00 * c + j01 * d, j10 * c + j11 * d


class PeriodMap(NamedTuple):
    """State (n,) after a period, its derivative (n, n) by the state before, the monodromy matrix, and sizes (n,)."""

    end: Floats
    matrix: Floats
    sizes: Floats


def variational_map(system: System, y0: Floats, duration: float, rtol: float) -> PeriodMap | None:
    """Period map of two states by their variational equations; None if the solution stops before."""
    start = [*y0, 1.0, 0.0, 0.0, 1.0]
    run = uninterrupted(simulate(Variational(system), start, (0.0, duration), method=_method(y0, duration, rtol)))
    if not run.status:
        return None
    y, matrix = run.y[:2, -1], run.y[2:, -1].reshape(2, 2).T
    return PeriodMap(y, matrix, _size(y, duration) * np.array([1.0, 2.0 * np.pi / duration]))


def differenced_map(system: System, y0: Floats, duration: float, rtol: float) -> PeriodMap | None:
    """Period map by central differences, right to about six digits; None if a solution stops before.

    It serves laws with memory, which need not be smooth.
    """
    method = _method(y0, duration, rtol)

    def end(start: Floats) -> Floats | None:
        run = uninterrupted(simulate(system, start, (0.0, duration), method=method))
        return run.y[:, -1] if run.status else None

    run = uninterrupted(simulate(system, y0, (0.0, duration), method=method))
    if not run.status:
        return None
    sizes = np.max(np.abs(run.y), axis=1)
    sizes = np.where(sizes > 0.0, sizes, 1.0)
    columns = []
    for step in np.diag(DIFFERENCE * sizes):
        after, before = end(y0 + step), end(y0 - step)
        if after is None or before is None:
            return None
        columns.append((after - before) / (2.0 * np.max(step)))
    return PeriodMap(run.y[:, -1], np.array(columns).T, sizes)


def _size(y: Floats, duration: float) -> float:
    """Size of a motion whose state of two numbers or more repeats after a time [s]; of one number that of this."""
    return max(abs(float(y[0])), *(abs(float(v)) * duration / (2.0 * np.pi) for v in y[1:2]), 1e-9)


def _method(y: Floats, duration: float, rtol: float) -> Dopri5:
    return Dopri5(rtol=rtol, atol=1e-3 * rtol * _size(y, duration))


def shoot(system: System, y0: ArrayLike, *, period: int = 1, rtol: float = 1e-11, throw: bool = False) -> Orbit:
    """Find the periodic orbit near a state by Newton's method on the period map.

    Parameters
    ----------
    system : NamedTuple
        A system with `rhs` and `omega`.
    y0 : (states,) array_like
        State near the orbit at base phase 0; for an `Oscillator` x [rad], x' [rad/s] and what its law remembers.
    period : int
        Turns of the base angle that the orbit takes.
    rtol : float
        Tolerance of the integration; the orbit closes to about ten times that. Of a law with memory, whose corners
        scatter an integration, to where the steps of Newton's method shrink no more, at most a thousand times that.
    throw : bool
        Raise instead of returning an orbit with a status.

    Returns
    -------
    Orbit
        `peak`, the largest |x| [rad], `coefficients` of the states (x [rad], x' [rad/s]) and `multipliers` from the
        monodromy matrix; `status` is `Status.NO_CONVERGENCE` where Newton's method fails.

    Raises
    ------
    ValueError
        If y0 is not as many finite numbers as the system has states, omega is not positive, or `period` or `rtol` is
        out of range.
    SolveError
        If Newton's method fails and `throw` is true.
    """
    system = periodic("shoot", with_parts("shoot", system, "rhs"), period)
    positive_count("period", period)
    Dopri5(rtol=rtol)
    omega = number("omega", omega_of(system), positive=True)
    return raised(_orbit(system, omega, period, rtol, *closed_state(system, numbers("y0", y0), period, rtol)), throw)


def closed_state(system: System, y: Floats, period: int, rtol: float) -> tuple[Floats, Floats, Status]:
    """State near y that repeats after so many turns, the monodromy matrix, and whether Newton's method found it."""
    n = len(y)
    smooth = n == 2 and has_jacobian(system)
    duration = 2.0 * np.pi * period / omega_of(system)
    matrix = np.full((n, n), 1e300)
    status, last = Status.NO_CONVERGENCE, np.inf

    def mapped(y: Floats) -> PeriodMap | None:
        return (variational_map if smooth else differenced_map)(system, y, duration, rtol)

    after, turns = mapped(y), 1
    for _ in range(STEPS):
        if after is None:
            status = Status.DIVERGED
            break
        end, matrix, sizes = after
        try:
            step = np.asarray(np.linalg.solve(matrix - np.eye(n), end - y), float)
        except np.linalg.LinAlgError:
            break
        if not np.all(np.isfinite(step)):
            break
        moved = float(np.max(np.abs(step) / sizes))
        if moved <= 10.0 * rtol or (not smooth and 0.5 * last < moved <= 1e3 * rtol):
            y, status = y - step, Status.OK
            break
        last = moved
        nearer = _nearer(mapped, y, after, step)
        if nearer is None:  # as beside a fold, where an orbit has just vanished: the motion leads away from there
            y, turns = _later(system, y, turns * duration, rtol), min(2 * turns, MOST_TURNS)
            nearer = y, mapped(y)
        y, after = nearer
    return y, matrix, status


def coefficients_of(samples: Floats, harmonics: int) -> Floats:
    """Coefficients (2H+1, states), mean, cos 1, sin 1, ..., of samples (states, n) of a period; H harmonics at most."""
    spectrum = np.fft.rfft(samples, axis=1).T * (2.0 / samples.shape[1])
    waves = spectrum[1 : harmonics + 1]
    series = np.empty((2 * len(waves) + 1, len(samples)))
    series[0], series[1::2], series[2::2] = spectrum[0].real / 2.0, waves.real, -waves.imag
    return series


def _later(system: System, y: Floats, time: float, rtol: float) -> Floats:
    """State after a time [s]; the state itself where the motion ends before."""
    run = uninterrupted(simulate(system, y, (0.0, time), method=_method(y, time, rtol)))
    return run.y[:, -1] if run.status else y


def _nearer(mapped: Any, y: Floats, now: PeriodMap, step: Floats) -> tuple[Floats, Any] | None:
    """State after a step of Newton's method, and its map; None if the whole step and its halves open the orbit."""
    end, _, sizes = now
    sizes = sizes * max(1.0, float(np.max(np.abs([y, end]) / sizes)))  # a motion may begin and end at x = 0
    gap, moved = np.max(np.abs(end - y) / sizes), np.max(np.abs(step) / sizes)
    share = min(1.0, LARGEST_STEP / moved)
    for _ in range(HALVINGS):
        trial = y - share * step
        after = mapped(trial)
        if after is not None:
            left = np.max(np.abs(after.end - trial) / sizes)
            if moved <= WHOLE_STEP or left <= (1.0 - 0.1 * share) * gap:
                return trial, after
        share *= 0.5
    return None


def _orbit(system: Any, omega: float, period: int, rtol: float, y: Floats, matrix: Floats, status: Status) -> Orbit:
    """Orbit through a state y, from samples of its motion and the monodromy matrix."""
    duration = 2.0 * np.pi * period / omega
    times = np.linspace(0.0, duration, SAMPLES + 1)
    run = simulate(system, y, times, method=_method(y, duration, rtol))
    if not run.status:
        run, status = simulate(system, np.zeros(len(y)), times[:3]), Status.DIVERGED
    series = coefficients_of(run.y[:, :SAMPLES], 1023)
    values = np.linalg.eigvals(matrix)
    multipliers = np.asarray(values[np.argsort(-np.abs(values))], complex)
    size = max(float(np.linalg.norm(series[:, 0])), 1e-300)
    tail = float(np.linalg.norm(series[-4:, 0])) / size
    message = "finished"
    if not status:
        reasons = {
            Status.NO_CONVERGENCE: "Newton's method did not converge; start closer to the orbit, or give damping"
        }
        message = f"shooting stopped at omega = {omega:.6g} rad/s: {reasons.get(status, status.value)}"
    stable = bool(status) and bool(np.abs(multipliers[0]) < DECAYS)
    return Orbit(omega, period, series, run.peak(), multipliers, stable, tail, status, message, value=omega)


def raised(orbit: Orbit, throw: bool) -> Orbit:
    """Return the orbit, or raise its message if it is none and `throw` is true."""
    if throw and not orbit.status.found:
        raise SolveError(orbit.message)
    return orbit
