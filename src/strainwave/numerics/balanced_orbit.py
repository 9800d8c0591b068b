"""`find_orbit`: one periodic orbit of a forced system, by harmonic balance; shooting refines it for laws with kinks."""

from typing import Any

import numpy as np

from ..base.branch_labels import END
from ..base.law import breakpoints_of, is_spring
from ..base.protocols import Balance, System, omega_of, with_parts
from ..base.quantities import reals, shown
from ..base.results import Floats, Orbit, Status
from ..compile.jit import load
from ..compile.tree import leaf_of
from .balance.choice import balance_of
from .balance.harmonics import grown, most_harmonics, starting_harmonics
from .balance.rates import periodic
from .balance.truncation import ORBIT, Tail, tail_along
from .continuation.starts import linear_start, settled_start
from .continuation.trace import Trace, describe, solve
from .shooting import raised, shoot


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
