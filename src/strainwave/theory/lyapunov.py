"""Lyapunov's direct method for the dynamic error: from which starts the motion decays.

For J x'' + B x' + T(x) = tau_0 the energy V = J v^2/2 + U(x) - tau_0 x, measured from the rest x_e, falls along every
motion: V' = -B v^2. Where V has a minimum at x_e, LaSalle's invariance principle gives convergence: a motion that stays
in a bounded set ends in the largest invariant set with v = 0, and there T(x) = tau_0. The periodic part of the torque
and the kinematic error are set aside; a constant torque moves the rest. For damping and stiffness that change
with angle, speed and temperature see `stability_proof`.

Source: Khalil, Nonlinear Systems, 3rd ed., theorem 4.4 and corollary 4.2; erratum E7 of the article.
"""

import math
from typing import Any

import numpy as np

from ..base.law import of_the_package, repeating, springs_only
from ..base.protocols import lacking
from ..base.quantities import checked, number, shown
from ..base.results import Floats
from ..base.sentences import Angle, Sentence
from ..model.excitation import Harmonic, NoError, mean_torque
from ..model.laws.springs import energy_in, turning_points_of
from ..model.oscillator import Oscillator, VaryingOscillator
from .equilibria import SAMPLES, Landscape, landscape
from .stability_proof import Obstacle, Region, Reserve, Scope, StabilityProof, reserve, rest_text

TRIED = 0.01  # rad to both sides, on which the methods of a user's law are compared at least


def lyapunov(
    system: Oscillator | VaryingOscillator, *, span: float | None = None, near: float | None = None
) -> StabilityProof:
    """Prove by Lyapunov's direct method that the dynamic error decays, say from where, or say why not.

    Parameters
    ----------
    system : Oscillator or VaryingOscillator
        The error equation. Its mean torque counts; the periodic torque and the kinematic error are set aside. Damping
        that changes with angle, speed and temperature must be bounded, 0 < b1 <= b <= b2; a falling stiffness asks for
        b1 > -J kappa'/(2 kappa) (see `theory.stability_proof` for the proof).
    span : float, optional
        Largest torsion [rad] to examine of a law that says neither its `turning_points()` nor its `polynomial()`: such
        a law is sampled on |x| <= span, and the claim is local and checked, not proved.
    near : float, optional
        A torsion [rad] in the well that is asked about, where the law has several. Default: the only one.

    Returns
    -------
    StabilityProof
        `claim` and `reason` as sentences, `scope`, the `rest` [rad] that motions decay to; `holds` is false,
        with the reason and a remedy, where the argument does not apply.

    Raises
    ------
    TypeError
        If `system` is neither.
    ValueError
        If a parameter is not finite or outside its range, or `span` or `near` is not a usable number.

    References
    ----------
    Khalil, Nonlinear Systems, 3rd ed., theorem 4.4 and corollary 4.2. For a softening cubic: |x| < 1/sqrt|alpha| and
    V < K/(4 |alpha|) (erratum E7 of the article).
    """
    if not isinstance(system, Oscillator | VaryingOscillator):
        raise TypeError(
            f"lyapunov takes an Oscillator, not {shown(system)}; a Drive gives one by drive.error_equation()"
        )
    system = repeating("lyapunov", checked(system))
    springs_only("lyapunov", system)
    if span is not None:
        span = number("span (the largest torsion to examine, in rad)", span, positive=True)
    if near is not None:
        near = number("near (a torsion in rad)", near)
    tau_0 = mean_torque(system.excitation)
    system = system._replace(excitation=Harmonic(0.0, mean=tau_0), error=NoError())
    damping = reserve(system, tau_0) if isinstance(system, VaryingOscillator) else Reserve(system.B, system.B, 0.0)
    obstacle = damping.obstacle or _obstacle(system, damping.low, span)
    if obstacle:
        return StabilityProof.refused(system, tau_0, obstacle)
    balance = landscape(system.law, tau_0, span)
    wells = balance.wells()
    if near is not None:
        wells = tuple(i for i in wells if balance.borders(i)[0] < near < balance.borders(i)[1])
    if len(wells) != 1:
        return StabilityProof.refused(
            system, tau_0, _no_single_well(system, tau_0, balance, near), _all_points(balance)
        )  # fmt: skip
    return _proof(system, tau_0, balance, wells[0], damping)


def _obstacle(system: Oscillator | VaryingOscillator, damping: float, span: float | None) -> Obstacle | None:
    """Obstacle that keeps V from being an energy that falls; None if nothing does."""
    law, name = system.law, type(system.law).__name__
    turns = turning_points_of(law)
    if damping < 0.0:
        fact = f"B is {damping:.6g} N*m*s/rad, so V' = -B v^2 >= 0 and motions gain energy"
        return Obstacle(fact, "give a damping B >= 0")
    if of_the_package(law) and turns is not None:
        return None
    stored = energy_in(law)
    if stored is None:
        fact = f"{name} has no method energy(x), the integral of its torque, which V needs, and no polynomial()"
        return Obstacle(fact, "define one of them")
    if turns is None and span is None:
        fact = f"{name} does not say where its torque turns and is only sampled"
        remedy = "give its class turning_points() or polynomial()"
        return Obstacle(fact, f"{remedy}, or the largest torsion in rad: lyapunov(system, span=0.01)")
    span = span or 2.0 * max(TRIED, *map(abs, turns or ()), 0.0)
    # U must be the integral of T, or V' is not -B v^2: Simpson's rule on each of 400 pieces
    grid = np.linspace(-span, span, 801)
    torque, energy = [np.array([float(method(float(x))) for x in grid]) for method in (law.torque, stored)]
    work = (torque[:-2:2] + 4.0 * torque[1::2] + torque[2::2]) * (grid[1] - grid[0]) / 3.0
    wrong = np.abs(np.diff(energy[::2]) - work) > 0.01 * np.max(np.abs(work))
    if np.any(wrong):
        x = float(grid[1::2][wrong][0])
        fact = Sentence("the energy of {} is not the integral of its torque at x = {}", name, Angle(x))
        return Obstacle(fact, "correct energy(x)")
    if turns is not None and _turns_between(turns, grid, torque):
        fact = f"the torque of {name} turns at another torsion than its turning_points() or polynomial() say"
        return Obstacle(fact, "correct them")
    return None


def _turns_between(turns: tuple[float, ...], grid: Floats, torque: Floats) -> bool:
    """True for samples of a torque that both rise and fall between two of its turning points [rad]."""
    pieces, noise = np.searchsorted(turns, grid), 1e-12 * float(np.max(np.abs(torque)))
    rises = [np.diff(torque[pieces == piece]) for piece in range(len(turns) + 1)]
    return any(np.any(rise > noise) and np.any(rise < -noise) for rise in rises)


def _no_single_well(
    system: Oscillator | VaryingOscillator, tau_0: float, balance: Landscape, torsion: float | None
) -> Obstacle:
    torque = f" under the mean torque {tau_0:.6g} N*m" if tau_0 else ""
    rests = Sentence(", ").join(rest_text(ends) for ends in balance.rests)
    if not balance.rests:
        span = Sentence(" on |x| <= {}", Angle(balance.high)) if math.isfinite(balance.high) else ""
        fact = Sentence("there is no equilibrium{}{}", torque, span)
        return Obstacle(fact, "T(x) never balances the mean torque: lower it or stiffen the law")
    if any(math.isinf(low) and math.isinf(high) for low, high in balance.rests):
        return Obstacle("the law has no restoring torque", "every x is an equilibrium: give it a positive stiffness")
    stable = [rest_text(balance.rests[i]) for i in balance.wells()]
    wells = Sentence(", ").join(stable)
    if torsion is not None and stable:
        fact = Sentence("near = {} lies in no well", Angle(torsion))
        return Obstacle(fact, Sentence("the stable equilibria{} are at {}", torque, wells))
    if stable:
        text = "there are {} wells, at {} (all equilibria{}: {}), and a motion may end in any of them"
        return Obstacle(Sentence(text, len(stable), wells, torque, rests), "choose one, with near= a torsion in it")
    back = "it takes a torque that pushes back from both sides"
    if len(balance.rests) == 1 and balance.rests[0][0] == balance.rests[0][1] and not lacking(system.law, "stiffness"):
        size = f"{float(system.law.stiffness(balance.rests[0][0])):.6g} N*m/rad"
        text = "the stiffness at the equilibrium {}{} is {}, so V has no minimum there"
        return Obstacle(Sentence(text, rests, torque, size), back)
    return Obstacle(Sentence("V has no minimum at any equilibrium{} ({})", torque, rests), back)


def _proof(
    system: Oscillator | VaryingOscillator, tau_0: float, balance: Landscape, well: int, damping: Reserve
) -> StabilityProof:
    ends = balance.rests[well]
    x_low, x_high = balance.borders(well)
    x_e = 0.5 * (ends[0] + ends[1])

    stored: Any = energy_in(system.law)

    def climb(x: float) -> float:
        return math.inf if math.isinf(x) else float(stored(x) - stored(x_e)) - tau_0 * (x - x_e)

    region = Region(x_low, x_high, min(climb(x_low), climb(x_high)))
    everywhere = math.isinf(x_low) and math.isinf(x_high)
    point = ends[0] == ends[1]
    scope: Scope = "local" if not everywhere else ("global" if point else "set")
    asymptotic = damping.left > 0.0
    varying = isinstance(system, VaryingOscillator)
    return StabilityProof(
        system=system,
        tau_0=tau_0,
        equilibria=_all_points(balance),
        rest=ends,
        holds=True,
        scope=scope,
        asymptotic=asymptotic,
        region=region,
        claim=_claim(ends, everywhere, asymptotic, varying),
        reason=_reason(balance, region, everywhere, point, asymptotic, varying),
        conditions=damping.conditions() if varying else (),
    )


def _claim(ends: tuple[float, float], everywhere: bool, asymptotic: bool, varying: bool) -> str:
    subject = "every motion" if everywhere else "every motion that starts in the region stays in it and"
    goal = Sentence("{} {}", "at" if ends[0] == ends[1] else "inside", rest_text(ends))
    if not asymptotic:
        verb = "never gains energy V" if varying else "keeps its energy V"
        return Sentence("{} {}: rest {} is stable, but not asymptotically", subject, verb, goal)
    kind = "globally asymptotically stable" if everywhere else "asymptotically stable"
    return Sentence("{} decays to rest {}{}", subject, goal, f" ({kind})" if ends[0] == ends[1] else "")


def _reason(balance: Landscape, region: Region, everywhere: bool, point: bool, asymptotic: bool, varying: bool) -> str:
    """Sentence of the proof: V is positive definite, its level curves close, V decreases, and x converges to a set."""
    goal = "the equilibrium" if point else "the set of rests inside the gap"
    if everywhere:
        shape = Sentence("and radially unbounded")
    elif math.isfinite(balance.low):
        shape = Sentence("and its level curves below energy_limit are closed inside |x| <= {}", Angle(balance.high))
    else:
        saddles = Angle(*(x for x in (region.x_low, region.x_high) if math.isfinite(x)))
        shape = Sentence(
            "below the level of the lower saddle (next rests: x = {}), not radially unbounded", saddles
        )  # fmt: skip
    decay = (
        f"V' = -B v^2 <= 0, and the largest invariant set in v = 0 is {goal} (LaSalle)"
        if asymptotic
        else "V' = 0 as B = 0"
    )
    if varying:
        decay = "V' <= 0, as the conditions guarantee no damping"
        if asymptotic:
            decay = (
                f"V' <= -beta v^2 with beta > 0; b <= b2 bounds the acceleration, so v and the remaining torque "
                f"tend to 0: x tends to {goal} (Barbalat)"
            )
    checked = f"; checked on {SAMPLES + 1} samples, not proved" if math.isfinite(balance.low) else ""
    return Sentence("V is positive definite with respect to {} {}, {}{}", goal, shape, decay, checked)


def _all_points(balance: Landscape) -> tuple[float, ...]:
    return tuple(sorted({x for ends in balance.rests for x in ends if math.isfinite(x)}))
