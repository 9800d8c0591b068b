"""Periodic orbits by shooting: Newton's method on the period map.

Its derivative comes from the variational equations, integrated alongside, for a system of two states with a `jacobian`,
and from differences of the period map for any other. Independent of harmonic balance and exact for laws with
breakpoints, because the integration ends its steps on them.
(A continuous law needs no jump in the variational equations there.)

Seydel 2010, Practical Bifurcation and Stability Analysis, sec. 7.3-7.4 (shooting, monodromy matrix).

`find_orbit`: one periodic orbit of a forced system, by harmonic balance; shooting refines it for laws with kinks.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..base.law import breakpoints_of, is_spring, torsion
from ..base.protocols import DECAYS, END, Balance, System, has_jacobian, omega_of, with_parts
from ..base.quantities import Reals, States, number, numbers, positive_count, reals, shown
from ..base.results import Floats, Orbit, SolveError, Status, Trajectory
from ..compile.jit import load
from ..compile.tree import leaf_of
from .balance.choice import balance_of
from .balance.harmonics import grown, most_harmonics, starting_harmonics
from .balance.rates import periodic
from .balance.truncation import ORBIT, Tail, tail_along
from .continuation.starts import linear_start, settled_start
from .continuation.trace import Trace, describe, solve
from .integration.methods import Dopri5
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


def period_map(system: System, y0: Floats, duration: float, rtol: float) -> tuple[Floats, Floats, Floats] | None:
    """State after one period, the monodromy matrix (2, 2), sizes of the states; None if the solution stops before."""
    start = [*y0, 1.0, 0.0, 0.0, 1.0]
    end = _span(Variational(system), start, duration, _method(y0, duration, rtol))
    if not end.status:
        return None
    size = _size(end.y[:2, -1], duration)
    return end.y[:2, -1], end.y[2:, -1].reshape(2, 2).T, size * np.array([1.0, 2.0 * np.pi / duration])


def differenced_map(system: System, y0: Floats, duration: float, rtol: float) -> tuple[Floats, Floats, Floats] | None:
    """State after one period, the monodromy matrix by central differences, and the sizes of the states; None as above.

    Of laws with memory, which need not be smooth: the matrix is good to about six digits.
    """
    method = _method(y0, duration, rtol)

    def end(start: Floats) -> Floats | None:
        run = _span(system, start, duration, method)
        return run.y[:, -1] if run.status else None

    run = _span(system, y0, duration, method)
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


def _span(system: System, y: Any, duration: float, method: Dopri5) -> Trajectory:
    """Motion over a time [s]; an interrupt (Ctrl-C) stops the search for an orbit too."""
    run = simulate(system, y, (0.0, duration), method=method)
    if run.status is Status.INTERRUPTED:
        raise KeyboardInterrupt
    return run


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
    return raised(_sampled(system, omega, period, rtol, *closed_state(system, numbers("y0", y0), period, rtol)), throw)


def closed_state(system: System, y: Floats, period: int, rtol: float) -> tuple[Floats, Floats, Status]:
    """State near y that repeats after so many turns, the monodromy matrix, and whether Newton's method found it."""
    n = len(y)
    smooth = n == 2 and has_jacobian(system)
    duration = 2.0 * np.pi * period / omega_of(system)
    matrix = np.full((n, n), 1e300)
    status, last = Status.NO_CONVERGENCE, np.inf

    def mapped(y: Floats) -> tuple[Floats, Floats, Floats] | None:
        return (period_map if smooth else differenced_map)(system, y, duration, rtol)

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
            y, turns = _gone_on(system, y, turns * duration, rtol), min(2 * turns, MOST_TURNS)
            nearer = y, mapped(y)
        y, after = nearer
    return y, matrix, status


def _gone_on(system: System, y: Floats, time: float, rtol: float) -> Floats:
    """State after a time [s]; the state itself where the motion ends before."""
    run = _span(system, y, time, _method(y, time, rtol))
    return run.y[:, -1] if run.status else y


def _nearer(mapped: Any, y: Floats, now: tuple[Floats, Floats, Floats], step: Floats) -> tuple[Floats, Any] | None:
    """State after a step of Newton's method, and its map; None if the whole step and its halves open the orbit."""
    end, _, sizes = now
    sizes = sizes * max(1.0, float(np.max(np.abs([y, end]) / sizes)))  # a motion may begin and end at x = 0
    gap, moved = np.max(np.abs(end - y) / sizes), np.max(np.abs(step) / sizes)
    share = min(1.0, LARGEST_STEP / moved)
    for _ in range(HALVINGS):
        trial = y - share * step
        after = mapped(trial)
        if after is not None:
            left = np.max(np.abs(after[0] - trial) / sizes)
            if moved <= WHOLE_STEP or left <= (1.0 - 0.1 * share) * gap:
                return trial, after
        share *= 0.5
    return None


def _sampled(system: Any, omega: float, period: int, rtol: float, y: Floats, matrix: Floats, status: Status) -> Orbit:
    duration = 2.0 * np.pi * period / omega
    times = np.linspace(0.0, duration, SAMPLES + 1)
    run = simulate(system, y, times, method=_method(y, duration, rtol))
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
    stable = bool(status) and bool(np.abs(multipliers[0]) < DECAYS)
    return Orbit(omega, period, series, run.peak(), multipliers, stable, tail, status, message, value=omega)


def find_orbit(
    system: System,
    *,
    harmonics: int | None = None,
    guess: Floats | Orbit | None = None,
    period: int = 1,
    throw: bool = False,
) -> Orbit:
    """Find a periodic orbit by harmonic balance.

    Parameters
    ----------
    system : Oscillator, or any NamedTuple with `rhs(phase, y)`
        The forced system, at its own `omega` (1 where it has none).
    harmonics : int, optional
        Highest harmonic of omega/period. Default: grown until the last two and those left out hold less than 1e-10 of
        the whole, at most 127 or 31 with friction or memory; an orbit whose spectrum decays slowly, because it crosses
        breakpoints of the law or the law has friction or memory, is then refined by shooting. With too few for 1e-3 of
        the orbit, the status is `Status.TRUNCATED`.
    guess : (2H+1, states) array or Orbit, optional
        Coefficients (mean, cos 1, sin 1, ...) near the orbit. Default: the linear response, then integration.
    period : int
        Turns of the base angle that the orbit takes (2 or more: subharmonic).
    throw : bool
        Raise instead of returning an orbit with a status.

    Returns
    -------
    Orbit
        `coefficients` (2H+1, states) of the states, x [rad] and x' [rad/s] of an oscillator: mean, cos 1, sin 1, ...;
        `peak`, the largest |x| [rad]; Floquet `multipliers`, without unit; `stable`; `status` is `Status.OK` or the
        reason for stopping.

    Raises
    ------
    ValueError
        If the guess has the wrong shape or `harmonics` or `period` is not positive.
    SolveError
        If no orbit is found and `throw` is true.

    References
    ----------
    Krack & Gross 2019, Harmonic Balance for Nonlinear Vibration Problems, secs. 2.2-2.4.
    """
    load()
    system = periodic("find_orbit", with_parts("find_orbit", system, "rhs"), period)
    h, largest = starting_harmonics(system, harmonics, period), most_harmonics(system)
    omega = float(omega_of(system))
    if not omega > 0.0:
        raise ValueError(f"omega is {omega:g} rad/s; a periodic orbit needs a positive base frequency")
    start = None if guess is None else _table(guess)
    if harmonics is None and start is not None:
        h = max(h, min(len(start) // 2, largest))
    leaf = leaf_of(system, "omega") if "omega" in getattr(system, "_fields", ()) else -1

    def balanced(h: int, aim: float) -> tuple[tuple[Any, Any, Any], float]:
        nonlocal start
        problem = balance_of(system, leaf, leaf, h, period, start is None)
        point = _balanced(problem, omega, start)
        if point is None:
            return (problem, None, None), 0.0
        start, tail = problem.state_table(problem.table(point)), tail_along(problem, point[None, :], aim)
        return (problem, point, tail), tail.worst

    problem, point, tail = grown(balanced, h, largest if harmonics is None else h, ORBIT)
    if point is None:
        return raised(_missing(problem, omega), throw)
    orbit = _described(problem, point, tail)
    smooth = is_spring(system) and not breakpoints_of(system)
    corners = harmonics is None and tail.worst > ORBIT and not smooth
    return raised(_refined(system, orbit, period) if corners else orbit, throw)


def _refined(system: System, orbit: Orbit, period: int) -> Orbit:
    """The orbit by shooting, where that converges.

    Corners of a law with memory are not located: they can scatter a fine integration by more than its tolerance, on
    which Newton's method then waits in vain, and a coarser one not.
    """
    for rtol in (1e-11, 1e-9):
        exact = shoot(system, orbit.state(0.0), period=period, rtol=rtol)
        if exact.status:
            return exact
    return orbit


def raised(orbit: Orbit, throw: bool) -> Orbit:
    """Return the orbit, or raise its message if it is none and `throw` is true."""
    if throw and not orbit.status.found:
        raise SolveError(orbit.message)
    return orbit


def _table(guess: Floats | Orbit) -> Floats:
    """Coefficients (2H+1, states) of a guess."""
    table = reals(guess.coefficients if isinstance(guess, Orbit) else guess)
    if table.size == 0:
        raise ValueError(f"guess is {shown(guess)}; it must be an Orbit or an array (2H+1, states)")
    if table.ndim == 1:
        table = table[:, None]
    if table.ndim != 2 or len(table) % 2 == 0 or not np.all(np.isfinite(table)):
        raise ValueError(f"guess has shape {table.shape}; it must be finite, (2H+1, states): mean, cos 1, sin 1, ...")
    return table


def _balanced(problem: Balance, omega: float, start: Floats | None) -> Floats | None:
    """Solution (coefficients in blocks, parameter) from a guess, the linear response, or an integration."""
    if start is None:
        point = linear_start(problem, omega)
        return settled_start(problem, omega) if point is None else point
    states = problem.state_count()
    if start.shape[1] != states and not problem.hill():  # an oscillator's first state tells the other
        raise ValueError(f"guess has {start.shape[1]} states; {type(problem.system).__name__} has {states}")
    return solve(problem, problem.point(start, omega))


def _described(problem: Balance, point: Floats, tail: Tail) -> Orbit:
    branch = describe(problem, "omega", Trace(point[None, :], np.zeros(1, int), END), tail, "", locate=False)
    return Orbit(
        float(branch.omega[0]), branch.period, problem.motion(point, branch.coefficients[0]), float(branch.peak[0]),
        branch.multipliers[0], bool(branch.stable[0]), tail.share, *tail.verdict(Status.OK, "finished", "omega", 0.0),
        value=float(branch.omega[0]),
    )  # fmt: skip


def _missing(problem: Balance, omega: float) -> Orbit:
    message = (
        f"no periodic orbit found at omega = {omega:.6g} rad/s: Newton's method failed from the guess, the linear "
        "response and an integration; give a guess, or more damping where a resonance has none, or continue from a "
        "frequency with a small response"
    )
    states, failed = problem.state_count(), Status.NO_CONVERGENCE
    nothing, unknown = np.zeros((3, states)), np.full(states, 0j)
    return Orbit(omega, int(problem.turns), nothing, 0.0, unknown, False, 0.0, failed, message, value=omega)
