"""`switch_branch`: the branch that leaves a curve of periodic orbits at a period doubling or a branch point.

The direction of departure is the null vector of the balance equations in the period of the new orbits; a small step
along it, held fixed, gives the first orbit, and continuation away from the crossing the rest.

Seydel 2010, Practical Bifurcation and Stability Analysis, secs. 5.5-5.6 and 7.4.
"""

from dataclasses import replace as with_changes
from typing import Any

import numpy as np

from ...base.protocols import Balance, with_parts
from ...base.quantities import checked, interval, replace
from ...base.results import Branch, Floats, Orbit, SolveError
from ...compile.tree import leaf_of
from ..balance.choice import balance_of
from ..balance.first_order import linearised
from ..balance.fourier import stretched
from ..balance.harmonics import grown, most_harmonics, starting_harmonics
from ..balance.rates import periodic
from ..balance.truncation import CURVE, Tail, tail_along
from ..continuation.trace import Trace, describe, trace
from ..stability.special_points import corrected
from .branch_to_birth import until_return

DEPARTURES = (0.01, 0.03, 0.1)  # first steps along the null vector, relative to the orbit


def switch_branch(
    system: Any,
    orbit: Orbit,
    span: tuple[float, float] | None = None,
    *,
    parameter: str = "omega",
    harmonics: int | None = None,
    points: int = 200,
) -> Branch:
    """Follow the branch that crosses another at a period doubling or a branch point.

    Parameters
    ----------
    system : Oscillator, or any NamedTuple with `rhs(phase, y)` and a field `omega`
        The system that the orbit belongs to.
    orbit : Orbit
        One of `Branch.doublings` (the new orbits take twice its period) or `Branch.branch_points` (the same period).
    span : (float, float), optional
        Range of the parameter. Default: from half to twice its value at the orbit.
    parameter : str
        Path of the parameter that varies.
    harmonics : int, optional
        Highest harmonic of omega over the new period. Default: grown as in `frequency_response`.
    points : int
        About how many points to place.

    Returns
    -------
    Branch
        `omega` [rad/s] and `peak`, largest |x| [rad], (n,) arrays, from next to the crossing to the end of the range,
        or to where it returns to the branch that it left. The mirrored half (the same orbits, half a new period
        later) is not listed.

    Raises
    ------
    ValueError
        If the orbit is neither a period doubling nor a branch point, is at rest, or lies outside the range.
    SolveError
        If no orbit is found next to the crossing.

    References
    ----------
    Seydel 2010, Practical Bifurcation and Stability Analysis, secs. 5.5-5.6.
    """
    system = periodic("switch_branch", with_parts("switch_branch", system, "rhs", "omega"), orbit.period)
    leaf = leaf_of(system, parameter)
    if not ("doubling" in orbit.label or "branch point" in orbit.label):
        raise ValueError(
            f"the orbit is labelled {orbit.label!r}; branches cross at an orbit from Branch.doublings or "
            "Branch.branch_points"
        )
    if not orbit.peak > 0.0:
        raise ValueError("the orbit is rest itself, which has no size to step by; give the system a small excitation")
    value = orbit.value
    system = checked(replace(system, {"omega": orbit.omega, parameter: value}))
    around = tuple(sorted((0.5 * value, 2.0 * value))) if span is None else span
    lo, hi = interval(f"the range of {parameter}", around, positive=parameter in ("omega", "J"))
    if not lo <= value <= hi:
        raise ValueError(
            f"the orbit has {parameter} = {value:.9g}, outside the range {lo:g} .. {hi:g}; widen the range"
        )
    stretch = 2 if "doubling" in orbit.label else 1
    largest = most_harmonics(system)
    highest = max(7, min(len(orbit.coefficients) // 2, largest // stretch))
    h = starting_harmonics(system, harmonics or stretch * highest, stretch * orbit.period, points)

    def followed(h: int, aim: float) -> tuple[tuple[Any, Trace, Tail, bool], float]:
        problem = balance_of(system, leaf, leaf_of(system, "omega"), h, stretch * orbit.period, folded=False)
        first, departure = _departure(problem, problem.point(stretched(orbit.coefficients, stretch), value), stretch)
        if first is None:
            raise SolveError(
                f"no orbit leaves the {orbit.label} at {parameter} = {value:.9g}; take more harmonics for the branch "
                "that it lies on"
            )
        curve = trace(problem, first, 1.0 if first[-1] > value else -1.0, lo, hi, 4.0 / points)
        curve, returned = until_return(curve, np.abs(departure) > 1e-6 * np.max(np.abs(departure)))
        tail = tail_along(problem, curve.points, aim)
        return (problem, curve, tail, returned), tail.worst

    problem, curve, tail, returned = grown(followed, h, largest if harmonics is None else h, CURVE)
    if returned:
        end = f"returns to the branch that it left at {parameter} = {curve.points[-1, -1]:.6g}"
        curve = with_changes(curve, message=end)
    return describe(problem, parameter, curve, tail, f"from the {orbit.label} at {parameter} = {value:.9g}")


def _departure(problem: Balance, point: Floats, stretch: int) -> tuple[Floats | None, Floats]:
    """First orbit (coefficients, parameter) of the crossing branch, and the direction in which it leaves."""
    n, h = len(point) - 1, problem.harmonics()
    matrix = linearised(problem, point)[1]
    odd = np.arange(1, h + 1, 2)
    odd = np.concatenate([odd, h + odd])
    free = np.concatenate([odd + block for block in range(0, n, 2 * h + 1)]) if stretch == 2 else np.arange(n)
    direction = np.zeros(n + 1)
    direction[free] = np.linalg.svd(matrix[np.ix_(free, free)])[2][-1]
    size = float(np.linalg.norm(point[:n]))
    scale = np.full(n + 1, 1.0 / size)
    scale[n] = 1.0 / max(abs(float(point[n])), 1e-300)
    for share in DEPARTURES:
        first = corrected(problem, point + share * size * direction, direction, scale)
        if first is not None and first[n] != point[n] and np.linalg.norm(first - point) < 10.0 * share * size:
            return first, direction
    return None, direction
