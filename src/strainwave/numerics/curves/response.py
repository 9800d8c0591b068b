"""`frequency_response`: a whole curve of periodic orbits, from one end of a frequency range to the other.

The curve starts from the linear response, or from strong damping, at one end and is followed to the other; where it
leaves the range with folds still ahead, it is followed outside until it comes back. The number of harmonics grows
until the last two are negligible.
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace as with_changes
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...base.branch_labels import END
from ...base.protocols import Balance, System
from ...base.quantities import checked, interval, numbers, positive_count, replace
from ...base.results import Branch, SolveError
from ...compile.tree import leaf_of, with_leaf
from ..balance.choice import balance_of
from ..balance.harmonics import grown, is_odd_on, most_harmonics, starting_harmonics
from ..balance.rates import periodic
from ..balance.truncation import CURVE, Tail, tail_along
from ..continuation.coexisting import Coexisting
from ..continuation.passage import across
from ..continuation.trace import Trace, describe
from .separate_motions import with_all_said, with_left_over


def frequency_response(
    system: System,
    span: tuple[float, float],
    *,
    harmonics: int | None = None,
    period: int = 1,
    points: int = 200,
    throw: bool = False,
) -> Branch:
    """Follow the response of a forced system through a range of base frequency.

    Parameters
    ----------
    system : Oscillator, DriveTrain, or any NamedTuple with `rhs(phase, y)` and a field `omega`
        The system; its own `omega` does not matter. A train whose laws are torques of their own twists is condensed
        onto these. The general form may have a method `jacobian(phase, y)`; its methods must take arrays, and it runs
        in NumPy.
    span : (float, float)
        Range of omega [rad/s], 0 < low < high.
    harmonics : int, optional
        Highest harmonic H of omega/period. Default: grown until the last two and those left out are negligible
        (1e-6 of every state), at most 127, or 31 with friction or memory (and never below the highest order). With too
        few for 1e-3 of the response, found or given, the status is `Status.TRUNCATED`.
    period : int
        Turns of the base angle per orbit.
    points : int
        About how many points to place; more where the curve bends.
    throw : bool
        Raise instead of returning a branch that ends inside the range.

    Returns
    -------
    Branch
        `omega` [rad/s], `peak`, largest |x| [rad], and `stable`, (n,) arrays, Fourier `coefficients` (n, 2H+1) of x
        [rad], and `folds` and `doublings`, in arc order from one end of the range to the other. Where the curve
        leaves the range and comes back, the points outside are in it too: a range that begins or ends inside a
        bistable band shows all motions that join the curve, and the arc of one that does not where it comes back to
        that end, as below the saddles of a softening law. Others at the ends are looked for by curves along the
        strength of the excitation, a constant torque and omega; `elsewhere` has those found that do not join the
        curve, and `message` tells of the stable ones and of a search that was cut short. Motions that no such curve
        connects are not found: `isolas` looks for them from random starts.

    Raises
    ------
    ValueError
        If the range is not 0 < low < high, or `harmonics`, `period` or `points` is not positive.
    SolveError
        If `throw` is true and the branch does not reach both ends.

    References
    ----------
    Krack & Gross 2019, Harmonic Balance for Nonlinear Vibration Problems, secs. 2-4.
    """
    system = periodic("frequency_response", checked(system), period)
    lo, hi = frequencies(span)
    (branch,) = response_curves([system], lo, hi, harmonics, period, points)
    if throw and not branch.status.found:
        raise SolveError(branch.message)
    return branch


def frequencies(span: Any) -> tuple[float, float]:
    """Return the range of omega [rad/s], or say in one sentence what is wrong with it."""
    lo, hi = interval("the frequency range", span)
    if not lo > 0.0:
        raise ValueError(
            f"the frequency range is {lo:g} .. {hi:g} rad/s; it must be 0 < low < high (at rest there is no response)"
        )
    return lo, hi


def response_curves(
    systems: list[Any], lo: float, hi: float, harmonics: int | None, period: int, points: int,
    apply: Callable[..., Any] = map,
) -> list[Branch]:  # fmt: skip
    """Response curves of checked systems of one class; `apply`, which is like map, goes through all but the first."""
    leaf = leaf_of(systems[0], "omega")

    def followed(system: System) -> Branch:
        system = with_leaf(system, leaf, (lo * hi) ** 0.5)
        h, largest = starting_harmonics(system, harmonics, period, points), most_harmonics(system)

        def problem_with(h: int) -> Balance:
            return balance_of(system, leaf, leaf, h, period)

        if harmonics is None:
            found = traced(problem_with, lo, hi, (h, largest), CURVE, points, True, lambda tail: tail.worst)
        else:  # the tail is found with the description of the curve
            found = traced(problem_with, lo, hi, (h, h), CURVE, points, True)
        problem, trace, tail, origin = found
        return with_all_said(problem, describe(problem, "omega", trace, tail, origin), trace)

    # The first compiles, where that is still to do, before threads start.
    return [followed(systems[0]), *apply(followed, systems[1:])]


def traced(
    problem_with: Callable[[int], Balance], lo: float, hi: float, harmonics: tuple[int, int], aim: float, points: int,
    coexisting: bool, share: Callable[[Tail], float] | None = None,
) -> tuple[Any, Trace, Tail | None, str]:  # fmt: skip
    """The balance problem of a curve, its points, its tail, and how it was found.

    Parameters
    ----------
    problem_with : callable
        The problem with a number of harmonics.
    lo, hi : float
        Range of omega [rad/s].
    harmonics : (int, int)
        Harmonics to begin with, and at most.
    aim : float
        Largest share left out that is negligible.
    points : int
        About how many points to place.
    coexisting : bool
        True if other motions at the ends of the range are looked for.
    share : callable, optional
        That share, from the tail. Without it the tail is not looked at: None.
    """
    pool = Coexisting()

    def followed(h: int, aim: float) -> tuple[tuple[Any, Trace, Tail | None, str], float]:
        problem, curve, origin = symmetric_across(problem_with(h), lo, hi, 4.0 / points, pool)
        tail = None if share is None else tail_along(problem, curve.points, aim)
        worst = np.inf if curve.outcome != END or tail is None or share is None else share(tail)
        worst = 0.0 if curve.is_cut else worst  # more harmonics do not bring it to its end
        if coexisting and (worst <= aim or curve.outcome != END) and pool.begin(problem, curve):
            return followed(h, aim)  # again, through what coexists
        return (problem, curve, tail, origin), worst

    problem, curve, tail, origin = grown(followed, *harmonics, aim)
    return problem, with_changes(with_left_over(problem, curve, pool), span=(lo, hi)), tail, origin


def symmetric_across(
    problem: Balance, lo: float, hi: float, step: float, coexisting: Coexisting
) -> tuple[Any, Trace, str]:  # fmt: skip
    """`across` by odd harmonics alone where that is possible; and the problem that was solved."""
    odd = problem.odd()
    if odd is not None:
        curve, origin = across(odd, lo, hi, step, coexisting)
        if curve.outcome == END and is_odd_on(odd, curve.points):
            return odd, curve, origin
    return problem, *across(problem, lo, hi, step, coexisting)


def response_family(
    system: System,
    span: tuple[float, float],
    parameters: dict[str, ArrayLike],
    *,
    harmonics: int | None = None,
    points: int = 200,
    threads: int = 2,
) -> list[Branch]:
    """Follow the response curve of every member of a family.

    Parameters
    ----------
    system : Oscillator
        The system that all members are variants of.
    span : (float, float)
        Range of omega [rad/s].
    parameters : dict of str to (members,) array_like
        Path of a parameter to its values, one per member (SI units), as in ``{"law.alpha": alphas, "B": dampings}``.
    harmonics, points
        As in `frequency_response`.
    threads : int
        Number of curves to follow at a time.

    Returns
    -------
    list of Branch
        `omega` [rad/s] and `peak`, largest |x| [rad], of each, in the order of the members; a curve that fails has
        its own status.

    Raises
    ------
    ValueError
        If the arrays have different lengths, there are none, or a path does not exist.
    """
    if not parameters:
        raise ValueError("parameters are empty; give a path with its values of every member")
    values = {path: numbers(path, v) for path, v in parameters.items()}
    lengths = {len(v) for v in values.values()}
    if len(lengths) != 1:
        raise ValueError(f"the values of a family must be arrays of one length, not of lengths {sorted(lengths)}")
    positive_count("threads", threads)
    lo, hi = frequencies(span)
    columns = {path: v.tolist() for path, v in values.items()}
    system = periodic("response_family", checked(system))
    members = [checked(replace(system, {p: c[i] for p, c in columns.items()})) for i in range(lengths.pop())]
    if threads == 1:
        return response_curves(members, lo, hi, harmonics, 1, points)
    with ThreadPoolExecutor(threads) as pool:
        return response_curves(members, lo, hi, harmonics, 1, points, pool.map)
