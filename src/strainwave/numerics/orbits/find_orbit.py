"""`find_orbit`: one periodic orbit of a forced system, by harmonic balance; shooting refines it for laws with kinks."""

from typing import Any

import numpy as np

from ...law import breakpoints_of, is_spring
from ...protocols import omega_of, with_parts
from ...quantities import shown
from ...results import Floats, Orbit, SolveError, Status
from ...tree import leaf_of
from ..balance.first_order import is_second_order, periodic
from ..balance.fourier import from_blocks, to_blocks
from ..balance.guess import linear_response
from ..balance.harmonics import MOST, grown, most_harmonics, starting_harmonics
from ..balance.second_order import second_order
from ..balance.truncation import ORBIT, Tail, tail_along
from ..continuation.describe import describe
from ..continuation.trace import Trace, solve, with_velocity
from ..integration.methods import Dopri5
from ..integration.simulate import simulate
from ..labels import END
from .general_orbit import general_orbit
from .shooting import shoot

SETTLING = 200  # periods integrated where Newton's method fails from the linear response


def find_orbit(
    system: Any,
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
        `status` is `Status.OK` or the reason for stopping.

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
    system = periodic("find_orbit", with_parts("find_orbit", system, "rhs"), period)
    h = starting_harmonics(system, harmonics, period)
    if not omega_of(system) > 0.0:
        raise ValueError(f"omega is {system.omega:g} rad/s; a periodic orbit needs a positive base frequency")
    if not is_second_order(system):
        table = None if guess is None else _table(guess)
        orbit = general_orbit(system, harmonics, table, period, ORBIT, most_harmonics(system))
        corners = harmonics is None and orbit.tail > ORBIT and not (is_spring(system) and not breakpoints_of(system))
        return raised(_refined(system, orbit, period) if corners else orbit, throw)
    start = None if guess is None else _table(guess)[:, 0]
    if harmonics is None and start is not None:
        h = max(h, min(len(start) // 2, MOST))
    leaf = leaf_of(system, "omega")

    def balanced(h: int, aim: float) -> tuple[tuple[Any, Any, Any], float]:
        nonlocal start
        problem = second_order(system, leaf, leaf, h, period)
        found = _balanced(problem, system, start)
        if found is None:
            return (problem, None, None), 0.0
        start, tail = from_blocks(found[:-1] + problem.error), tail_along(problem, found[None, :], aim)
        return (problem, found, tail), tail.worst

    problem, found, tail = grown(balanced, h, MOST if harmonics is None else h, ORBIT)
    if found is None:
        return raised(_missing(system, period), throw)
    orbit = _described(problem, found, tail)
    corners = harmonics is None and tail.worst > ORBIT and system.breakpoints()
    return raised(_refined(system, orbit, period) if corners else orbit, throw)


def _refined(system: Any, orbit: Orbit, period: int) -> Orbit:
    exact = shoot(system, orbit.state(0.0), period=period)
    return exact if exact.status else orbit


def raised(orbit: Orbit, throw: bool) -> Orbit:
    """Return the orbit, or raise its message if it is none and `throw` is true."""
    if throw and not orbit.status.found:
        raise SolveError(orbit.message)
    return orbit


def _table(guess: Floats | Orbit) -> Floats:
    """Coefficients (2H+1, states) of a guess."""
    try:
        table = np.asarray(guess.coefficients if isinstance(guess, Orbit) else guess, float)
    except (TypeError, ValueError):
        raise ValueError(f"guess is {shown(guess)}; it must be an Orbit or an array (2H+1, states)") from None
    if table.ndim == 1:
        table = table[:, None]
    if table.ndim != 2 or len(table) % 2 == 0 or not np.all(np.isfinite(table)):
        raise ValueError(f"guess has shape {table.shape}; it must be finite, (2H+1, states): mean, cos 1, sin 1, ...")
    return table


def _balanced(problem: Any, system: Any, start: Floats | None) -> Floats | None:
    """Solution (coefficients in blocks, parameter) from a guess of x, the linear response, or an integration."""
    n = len(problem.tau)
    if start is not None:
        series = np.zeros(n)
        series[: min(n, len(start))] = start[:n]
        return solve(problem, np.append(to_blocks(series) - problem.error, system.omega))
    found = solve(problem, linear_response(problem, system.omega))
    if found is not None:
        return found
    turn = 2.0 * np.pi * problem.turns / system.omega
    samples = len(problem.angles)
    grid = SETTLING * turn + turn * np.arange(samples) / samples
    run = simulate(system, (0.0, 0.0), np.concatenate([[0.0], grid]), method=Dopri5(rtol=1e-7, atol=1e-12))
    if not run.status:
        return None
    return solve(problem, np.append(run.y[0, 1:] @ problem.analysis - problem.error, system.omega))


def _described(problem: Any, found: Floats, tail: Tail) -> Orbit:
    branch = describe(problem, "omega", Trace(found[None, :], np.zeros(1, int), END), tail, "")
    series = with_velocity(branch.coefficients[0], branch.omega[0] / problem.turns)
    omega = float(branch.omega[0])
    return Orbit(
        omega, problem.turns, series, float(branch.peak[0]), branch.multipliers[0], bool(branch.stable[0]),
        tail.share, *tail.verdict(Status.OK, "finished", "omega", omega), value=omega,
    )  # fmt: skip


def _missing(system: Any, period: int) -> Orbit:
    message = (
        f"no periodic orbit found at omega = {system.omega:.6g} rad/s: Newton's method failed from the guess, the "
        "linear response and an integration; give a guess, or more damping where a resonance has none, or continue "
        "from a frequency with a small response"
    )
    nothing = np.zeros((3, 2))
    return Orbit(
        system.omega,
        period,
        nothing,
        0.0,
        np.full(2, 0j),
        False,
        0.0,
        Status.NO_CONVERGENCE,
        message,
        value=system.omega,
    )
