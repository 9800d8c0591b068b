"""`parameter_response`: periodic orbits along any continuous parameter, at a fixed base frequency.

Amplitude sweeps, the response against load, a law's coefficient: the parameter is named by its path and the curve is
followed around its folds, as `frequency_response` does in omega.
"""

from dataclasses import replace as with_changes
from typing import Any

import numpy as np

from ...base.branch_labels import END, UNBOUNDED
from ...base.protocols import Balance, System, with_parts
from ...base.quantities import interval, replace, shown
from ...base.results import Branch, Floats, Orbit, SolveError
from ...compile.tree import leaf_of
from ..balance.choice import balance_of
from ..balance.harmonics import grown, most_harmonics, starting_harmonics
from ..balance.rates import periodic
from ..balance.truncation import CURVE, Tail, tail_along
from ..continuation.starts import GROWTH, damped_start, linear_start
from ..continuation.trace import Trace, describe
from .branch_to_birth import apart_from_shorter, both_ways

INSIDE = 0.01  # of the range: where a sweep starts that has no response at its lower end


def parameter_response(
    system: Any,
    path: str,
    span: tuple[float, float],
    *,
    harmonics: int | None = None,
    period: int = 1,
    start: Orbit | None = None,
    points: int = 200,
    throw: bool = False,
) -> Branch:
    """Follow the response of a forced system through a range of one parameter, at its own omega.

    Parameters
    ----------
    system : Oscillator, or any NamedTuple with `rhs(phase, y)` and a field `omega`
        The system; its own value of the parameter matters only as that of `start`.
    path : str
        Path of the parameter: "excitation.amplitude", "excitation.mean", "law.alpha", "B", "omega", ...
    span : (float, float)
        Range of the parameter (SI), low < high.
    harmonics : int, optional
        Highest harmonic H of omega/period. Default: grown until the last two and those left out are negligible
        (1e-6 of every state), at most 127, or 31 with friction or memory (and never below the highest order). With too
        few for 1e-3 of the response, found or given, the status is `Status.TRUNCATED`.
    period : int
        Turns of the base angle per orbit.
    start : Orbit, optional
        Orbit of `system` (at the parameter's own value, which must lie in the range) on the branch to follow, both
        ways. Its harmonics beyond those that the curve takes are left out, and it is solved again. Default: the linear
        response at the low end.
    points : int
        About how many points to place; more where the curve bends.
    throw : bool
        Raise instead of returning a branch that ends inside the range.

    Returns
    -------
    Branch
        `values` (n,) of the parameter in its SI unit and `peak` (n,), largest |x| [rad], in arc order, with `stable`
        and multipliers; each fold is an Orbit with its `value`. The branch ends where it first leaves the range.

    Raises
    ------
    ValueError
        If the path names no continuous parameter, the range is not low < high (0 < low for omega and J), the start
        is no orbit or lies outside it, or `harmonics`, `period` or `points` is no count.
    TypeError
        If the system is no `Oscillator` or the like.
    SolveError
        If `throw` is true and the branch ends inside the range.

    References
    ----------
    Krack & Gross 2019, Harmonic Balance for Nonlinear Vibration Problems, secs. 2-4.
    """
    period = start.period if isinstance(start, Orbit) else period
    system = periodic("parameter_response", with_parts("parameter_response", system, "rhs", "omega"), period)
    leaf, omega_leaf = leaf_of(system, path), leaf_of(system, "omega")
    lo, hi = interval(f"the range of {path}", span, positive=path in ("omega", "J"))
    if path != "omega" and start is None and not system.omega > 0.0:
        raise ValueError(f"omega is {system.omega:g} rad/s; a periodic response needs a positive base frequency")
    if start is not None:
        if not (isinstance(start, Orbit) and start.status.found):
            raise ValueError(f"the start is {shown(start)}; it must be an Orbit whose status is OK or TRUNCATED")
        system = replace(system, {"omega": start.omega})
    h, largest = starting_harmonics(system, harmonics, period, points), most_harmonics(system)
    if harmonics is None and start is not None:
        h = max(h, min(harmonics_of(start.coefficients), largest))

    def followed(h: int, aim: float) -> tuple[tuple[Any, Trace, Tail, str], float]:
        problem = balance_of(system, leaf, omega_leaf, h, period, folded=False)
        guess, origin = _beginning(problem, system, path, lo, hi, start)
        apart = apart_from_shorter(problem, guess)
        curve = both_ways(problem, guess, lo, hi, 4.0 / points, growth=GROWTH, apart=apart)
        tail = tail_along(problem, curve.points, aim)
        return (problem, curve, tail, origin), tail.worst

    problem, curve, tail, origin = grown(followed, h, largest if harmonics is None else h, CURVE)
    message, none = _ending(curve, path, lo, hi, system.omega), not len(curve.points)
    curve = with_changes(curve, message=message, span=(lo, hi) if none else None)
    branch = describe(problem, path, curve, tail, origin)
    if throw and not branch.status.found:
        raise SolveError(branch.message)
    return branch


def _ending(curve: Trace, path: str, lo: float, hi: float, omega: float) -> str:
    """Sentence on how the branch ends; empty where `describe` has one."""
    speed = "" if path == "omega" else f", omega = {omega:.6g} rad/s"
    if not len(curve.points):
        return (
            f"no periodic response was found at {path} = {lo:.6g} or {hi:.6g}{speed}; a resonance without damping and "
            "a torque that the law cannot bear have none: give damping, less torque, or another range"
        )
    if curve.outcome == UNBOUNDED:
        return (
            f"the response grows without bound at {path} = {curve.points[-1, -1]:.6g}{speed}; give more damping or end "
            "the range before it"
        )
    if curve.outcome == END and (born := [v for v in (curve.points[0, -1], curve.points[-1, -1]) if lo < v < hi]):
        places = " and ".join(f"{v:.6g}" for v in born)
        return f"is born at {path} = {places}{speed} from rest, or from a motion that repeats after fewer turns"
    if curve.outcome == END:
        return f"leaves the range at {path} = {curve.points[0, -1]:.6g} and {curve.points[-1, -1]:.6g}"
    return ""


def harmonics_of(table: Floats) -> int:
    """Number of harmonics of coefficients (2H+1, states) beyond which next to nothing of any state is left."""
    squares = np.square(table)
    beyond = np.sqrt(np.cumsum(squares[::-1], axis=0)[::-1] / np.maximum(squares.sum(axis=0), 1e-300))
    return int(np.flatnonzero(np.any(beyond > CURVE, axis=1))[-1] + 1) // 2


def value_at(system: Any, path: str) -> float:
    """Value of the parameter at a path."""
    thing = system
    for key in path.split("."):
        thing = thing[int(key)] if key.isdigit() else getattr(thing, key)
    return float(thing)


def _beginning(
    problem: Balance, system: System, path: str, lo: float, hi: float, start: Orbit | None
) -> tuple[Floats, str]:
    """Start of the branch (coefficients, parameter), and a sentence on it."""
    if start is not None:
        value = start.omega if path == "omega" else value_at(system, path)
        if not lo <= value <= hi:
            raise ValueError(
                f"the start has {path} = {value:g}, outside the range {lo:g} .. {hi:g}; widen the range, or give the "
                "system the value that the start was found at"
            )
        return problem.point(start.coefficients, value), f"from the orbit given at {path} = {value:g}"
    first, last = problem.linear_response(lo), problem.linear_response(hi)
    low = lo
    if np.linalg.norm(first[:-1]) < 1e-3 * np.linalg.norm(last[:-1]):
        low = lo + INSIDE * (hi - lo)
    for begin, from_where in ((linear_start, "the linear response"), (damped_start, "strong damping")):
        for value in (low, hi):
            point = begin(problem, value)
            if point is not None:
                return point, f"from {from_where} at {path} = {value:g}"
    return problem.linear_response(low), f"from the linear response at {path} = {low:g}"
