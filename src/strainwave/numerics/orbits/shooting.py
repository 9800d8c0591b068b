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

from ...law import breakpoints_of, torsion
from ...protocols import has_jacobian, omega_of, with_parts
from ...quantities import number, numbers, positive_count
from ...results import Floats, Orbit, SolveError, Status
from ..balance.rates import periodic
from ..integration.methods import Dopri5
from ..integration.simulate import simulate

SAMPLES = 4096  # of the orbit, from which peak and Fourier coefficients are taken
STEPS = 30
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

    def torsion(self, phase: Any, y: Any) -> Any:
        """Torsion of the system."""
        return torsion(self.system, phase, (y[0], y[1]))

    def rhs(self, phase: Any, y: Any) -> Any:
        """Rates of the states and of the fundamental matrix."""
        x, v, a, b, c, d = y
        first, second = self.system.rhs(phase, (x, v))
        (j00, j01), (j10, j11) = self.system.jacobian(phase, (x, v))
        return first, second, j00 * a + j01 * b, j10 * a + j11 * b, j00 * c + j01 * d, j10 * c + j11 * d


def period_map(system: Any, y0: Floats, duration: float, rtol: float) -> tuple[Floats, Floats, Floats] | None:
    """State after one period, the monodromy matrix (2, 2), sizes of the states; None if the solution stops before."""
    start = [*y0, 1.0, 0.0, 0.0, 1.0]
    end = simulate(Variational(system), start, (0.0, duration), method=Dopri5(rtol=rtol, atol=1e-3 * rtol * _size(y0)))
    if not end.status:
        return None
    size = _size(end.y[:2, -1])
    return end.y[:2, -1], end.y[2:, -1].reshape(2, 2).T, size * np.array([1.0, 2.0 * np.pi / duration])


def differenced_map(system: Any, y0: Floats, duration: float, rtol: float) -> tuple[Floats, Floats, Floats] | None:
    """State after one period, the monodromy matrix by central differences, and the sizes of the states; None as above.

    Of laws with memory, which need not be smooth: the matrix is good to about six digits.
    """
    method = Dopri5(rtol=rtol, atol=1e-3 * rtol * _size(y0))

    def end(start: Floats) -> Floats | None:
        run = simulate(system, start, (0.0, duration), method=method)
        return run.y[:, -1] if run.status else None

    run = simulate(system, y0, (0.0, duration), method=method)
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
    return run.y[:, -1], np.array(columns).T, sizes


def _size(y0: Floats) -> float:
    return max(abs(float(y0[0])), 1e-9)


def shoot(system: Any, y0: ArrayLike, *, period: int = 1, rtol: float = 1e-11, throw: bool = False) -> Orbit:
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
        With multipliers from the monodromy matrix; `status` is `Status.NO_CONVERGENCE` where Newton's method fails.

    Raises
    ------
    ValueError
        If y0 is not as many finite numbers as the system has states, omega is not positive, or `period` or `rtol` is
        out of range.
    SolveError
        If Newton's method fails and `throw` is true.
    """
    system = periodic("shoot", with_parts("shoot", system, "rhs"), period)
    y = start = numbers("y0", y0)
    n = len(y)
    smooth = n == 2 and has_jacobian(system)
    positive_count("period", period)
    Dopri5(rtol=rtol)
    omega = number("omega", omega_of(system), positive=True)
    duration = 2.0 * np.pi * period / omega
    matrix = np.full((n, n), 1e300)
    status, last = Status.NO_CONVERGENCE, np.inf
    for _ in range(STEPS):
        mapped = (period_map if smooth else differenced_map)(system, y, duration, rtol)
        if mapped is None:
            status = Status.DIVERGED
            break
        end, matrix, sizes = mapped
        try:
            step = np.linalg.solve(matrix - np.eye(n), end - y)
        except np.linalg.LinAlgError:
            break
        y = y - step
        if not np.all(np.isfinite(y)):
            y = start
            break
        moved = float(np.max(np.abs(step) / sizes))
        if moved <= 10.0 * rtol or (not smooth and 0.5 * last < moved <= 1e3 * rtol):
            status = Status.OK
            break
        last = moved
    orbit = _sampled(system, y, omega, period, matrix, rtol, status)
    if throw and not orbit.status:
        raise SolveError(orbit.message)
    return orbit


def _sampled(system: Any, y: Floats, omega: float, period: int, matrix: Floats, rtol: float, status: Status) -> Orbit:
    duration = 2.0 * np.pi * period / omega
    times = np.linspace(0.0, duration, SAMPLES + 1)
    run = simulate(system, y, times, method=Dopri5(rtol=rtol, atol=1e-3 * rtol * _size(y)))
    if not run.status:
        run, status = simulate(system, np.zeros(len(y)), times[:3]), Status.DIVERGED
    spectrum = np.fft.rfft(run.y[:, :SAMPLES], axis=1).T * (2.0 / min(SAMPLES, run.y.shape[1]))
    kept = min(1023, len(spectrum) - 1)
    series = np.empty((2 * kept + 1, len(y)))
    series[0] = spectrum[0].real / 2.0
    series[1::2], series[2::2] = spectrum[1 : kept + 1].real, -spectrum[1 : kept + 1].imag
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
    stable = bool(status) and bool(np.abs(multipliers[0]) < 1.0)
    return Orbit(omega, period, series, run.peak(), multipliers, stable, tail, status, message, value=omega)
