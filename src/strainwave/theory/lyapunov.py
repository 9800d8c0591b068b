"""Lyapunov's direct method for the dynamic error: from which starts the motion decays.

For J x'' + B x' + T(x) = tau_0 the energy V = J v^2/2 + U(x) - tau_0 x, measured from the rest x_e, falls along every
motion: V' = -B v^2. Where V has a minimum at x_e, LaSalle's invariance principle gives convergence: a motion that stays
in a bounded set ends in the largest invariant set with v = 0, and there T(x) = tau_0. The periodic part of the torque
and the kinematic error are set aside; a constant torque moves the rest. For damping and stiffness that change
with angle, speed and temperature see `time_varying`.

Source: Khalil, Nonlinear Systems, 3rd ed., theorem 4.4 and corollary 4.2; erratum E7 of the article.
"""

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from .._dispatch import springs_only
from ..model.excitation import Harmonic, Harmonics, NoError
from ..model.oscillator import Oscillator
from ..model.varying import VaryingOscillator
from ..quantities import checked, number, shown
from .equilibria import SAMPLES, Landscape, is_known, landscape
from .time_varying import Reserve, reserve

Scope = Literal["global", "local", "set", "none"]


@dataclass(frozen=True)
class Region:
    """Where a claim holds: x_low < x < x_high [rad] and V(x, v) < energy_limit [J]; infinite where nothing limits."""

    x_low: float = -math.inf
    x_high: float = math.inf
    energy_limit: float = math.inf

    def __str__(self) -> str:
        low = f"{self.x_low:.6g} < " if math.isfinite(self.x_low) else ""
        high = f" < {self.x_high:.6g}" if math.isfinite(self.x_high) else ""
        if not (low or high):
            return "all x and v"
        return f"{low}x{high} rad and V < {self.energy_limit:.6g} J"


@dataclass(frozen=True, eq=False)
class StabilityProof:
    """What Lyapunov's direct method says about the unforced dynamic error, or why it says nothing.

    Attributes
    ----------
    system : Oscillator or VaryingOscillator
        The system of the claim: the one given, with its mean torque alone and without kinematic error.
    tau_0 : float
        Mean torque [N*m].
    equilibria : tuple of float
        All known rests [rad], stable or not; of a whole interval of rests both ends.
    rest : (float, float) or None
        Ends of the set of x [rad] that the claim is about, equal for a point; None without a claim.
    holds : bool
        Whether there is a claim.
    scope : {"global", "local", "set", "none"}
        For all starts; for starts in `region`; for all starts, to a set of rests (backlash); no claim.
    asymptotic : bool
        Whether motions converge (B > 0) or only stay near (B = 0).
    region : Region or None
        From where the claim holds.
    claim, reason : str
        The claim, and the sentence that proves it or says what is in the way and what helps.
    conditions : tuple of str
        Of a `VaryingOscillator`: the bounds on which the claim rests.
    """

    system: Oscillator | VaryingOscillator
    tau_0: float
    equilibria: tuple[float, ...]
    rest: tuple[float, float] | None
    holds: bool
    scope: Scope
    asymptotic: bool
    region: Region | None
    claim: str
    reason: str
    conditions: tuple[str, ...] = ()

    def V(self, x: Any, v: Any, phase: Any = 0.0) -> Any:
        """Lyapunov function J v^2/(2 kappa) + U(x) - tau_0 x [J], zero at rest (without a claim: at x = 0).

        Parameters
        ----------
        x : float or array
            Dynamic error [rad].
        v : float or array
            Its rate x' [rad/s], of the same shape.
        phase : float or array
            Base angle [rad], on which the stiffness factor kappa depends; kappa = 1 of an `Oscillator`.
        """
        x_e = 0.5 * (self.rest[0] + self.rest[1]) if self.rest else 0.0
        law = self.system.law
        kappa = self.system.variation.value(phase) if isinstance(self.system, VaryingOscillator) else 1.0
        return 0.5 * self.system.J * v * v / kappa + law.energy(x) - law.energy(x_e) - self.tau_0 * (x - x_e)

    def dissipation(self, x: Any, v: Any, phase: Any = 0.0) -> Any:
        """Rate V' [W] along the motion, -B v^2 or -(b + J kappa'/(2 kappa)) v^2/kappa; arguments as of V."""
        if not isinstance(self.system, VaryingOscillator):
            return -self.system.B * v * v + 0.0 * x
        kappa, rate = self.system.variation.value(phase), self.system.omega * self.system.variation.slope(phase)
        b = self.system.damping.value(phase, v)
        return -(b + 0.5 * self.system.J * rate / kappa) * v * v / kappa + 0.0 * x

    def contains(self, x: float, v: float, phase: float = 0.0) -> bool:
        """Whether the claim covers a motion that starts at the error x [rad], the rate v [rad/s] and a base angle."""
        region = self.region
        if region is None or not region.x_low < x < region.x_high:
            return False
        return bool(self.V(x, v, phase) < region.energy_limit)

    def __str__(self) -> str:
        torque = f", mean torque {self.tau_0:.6g} N*m" if self.tau_0 else ""
        where = f", relative to its value at {_point(self.rest)}" if self.rest else ""
        equation, square, loss = "J x'' + B x' + T(x)", "J v^2/2", "-B v^2"
        if isinstance(self.system, VaryingOscillator):
            equation, square = "J x'' + b(t) x' + kappa(t) T(x)", "J v^2/(2 kappa)"
            loss = "-(b + J kappa'/(2 kappa)) v^2/kappa"
        else:
            loss += f", B = {self.system.B:.6g} N*m*s/rad"
        return "\n".join(
            [
                f"Stability of {equation} = tau_0 with {self.system.law}{torque}",
                f"  V  = {square} + U(x) - tau_0 x{where}",
                f"  V' = {loss}",
                *(f"  condition: {condition}" for condition in self.conditions),
                f"  claim ({self.scope}): {self.claim}",
                f"  region: {self.region if self.region else 'none'}",
                f"  reason: {self.reason}",
                "  set aside: the periodic part of the torque and the kinematic error",
            ]
        )


def lyapunov(
    system: Oscillator | VaryingOscillator, *, span: float | None = None, near: float | None = None
) -> StabilityProof:
    """Prove by Lyapunov's direct method that the dynamic error decays, say from where, or say why not.

    Parameters
    ----------
    system : Oscillator or VaryingOscillator
        The error equation. Its mean torque counts; the periodic torque and the kinematic error are set aside. Damping
        that changes with angle, speed and temperature must be bounded, 0 < b1 <= b <= b2; a falling stiffness asks for
        b1 > -J kappa'/(2 kappa) (see `theory.time_varying` for the proof).
    span : float, optional
        Largest torsion [rad] to examine of a law that is not of this package: such a law is sampled on |x| <= span, and
        the claim is local and checked, not proved. The package's laws do not need it.
    near : float, optional
        A torsion [rad] in the well that is asked about, where the law has several. Default: the only one.

    Returns
    -------
    StabilityProof
        `holds` is false, with the reason and a remedy, where the argument does not apply.

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
    system = checked(system)
    springs_only("lyapunov", system)
    if span is not None:
        span = number("span (the largest torsion to examine, in rad)", span, positive=True)
    if near is not None:
        near = number("near (a torsion in rad)", near)
    tau_0 = mean_torque(system.excitation)
    system = system._replace(excitation=Harmonic(0.0, mean=tau_0), error=NoError())
    kept = reserve(system, tau_0) if isinstance(system, VaryingOscillator) else Reserve(system.B, system.B, 0.0)
    obstacle = kept.obstacle or _obstacle(system, kept.low, span)
    if obstacle:
        return _refused(system, tau_0, None, obstacle)
    found = landscape(system.law, tau_0, span)
    wells = found.wells()
    if near is not None:
        wells = tuple(i for i in wells if found.borders(i)[0] < near < found.borders(i)[1])
    if len(wells) != 1:
        return _refused(system, tau_0, found, _no_single_well(system, tau_0, found, near))
    return _proof(system, tau_0, found, wells[0], kept)


def mean_torque(excitation: Any) -> float:
    """Mean over a turn of the base angle [N*m]."""
    match excitation:
        case Harmonic(mean=mean):
            return float(mean)
        case Harmonics(terms=terms):
            return sum(mean_torque(term) for term in terms)
        case _:
            angles = np.linspace(0.0, 2.0 * math.pi, 1024, endpoint=False)
            return float(np.mean([excitation.torque(float(angle)) for angle in angles]))


def _obstacle(system: Oscillator | VaryingOscillator, damping: float, span: float | None) -> str:
    """What keeps V from being an energy that falls, as a sentence; empty if nothing does."""
    law, name = system.law, type(system.law).__name__
    if damping < 0.0:
        return f"B is {damping:.6g} N*m*s/rad, so V' = -B v^2 >= 0 and motions gain energy; give a damping B >= 0"
    if is_known(law):
        return ""
    if not hasattr(law, "energy"):
        return f"{name} has no method energy(x), the integral of its torque, which V needs; define it"
    if span is None:
        return (
            f"{name} is not a law of this package and is only sampled; say how far, in rad: lyapunov(system, span=0.01)"
        )
    # U must be the integral of T, or V' is not -B v^2: Simpson's rule on each of 400 pieces
    grid = np.linspace(-span, span, 801)
    torque, energy = (np.array([float(method(float(x))) for x in grid]) for method in (law.torque, law.energy))
    work = (torque[:-2:2] + 4.0 * torque[1::2] + torque[2::2]) * (grid[1] - grid[0]) / 3.0
    wrong = np.abs(np.diff(energy[::2]) - work) > 0.01 * np.max(np.abs(work))
    if np.any(wrong):
        x = float(grid[1::2][wrong][0])
        return f"the energy of {name} is not the integral of its torque at x = {x:.6g} rad; mend energy(x)"
    return ""


def _no_single_well(system: Oscillator | VaryingOscillator, tau_0: float, found: Landscape, near: float | None) -> str:
    torque = f" under the mean torque {tau_0:.6g} N*m" if tau_0 else ""
    rests = ", ".join(_point(rest) for rest in found.rests)
    if not found.rests:
        where = f" on |x| <= {found.high:.6g} rad" if math.isfinite(found.high) else ""
        return (
            f"there is no equilibrium{torque}{where}: T(x) never balances it; lower the mean torque or stiffen the law"
        )
    if any(math.isinf(low) and math.isinf(high) for low, high in found.rests):
        return "the law has no restoring torque: every x is an equilibrium; give it a positive stiffness"
    stable = [_point(found.rests[i]) for i in found.wells()]
    if near is not None and stable:
        return f"near = {near:.6g} rad lies in no well; the stable equilibria{torque} are at {', '.join(stable)}"
    if stable:
        return (
            f"there are {len(stable)} wells, at {', '.join(stable)} (all equilibria{torque}: {rests}), and a "
            "motion may end in any of them; ask about one, with near= a torsion in it"
        )
    if len(found.rests) == 1 and found.rests[0][0] == found.rests[0][1] and hasattr(system.law, "stiffness"):
        stiffness = float(system.law.stiffness(found.rests[0][0]))
        return (
            f"the stiffness at the equilibrium {rests}{torque} is {stiffness:.6g} N*m/rad, so V has no minimum there; "
            "it takes a torque that pushes back from both sides"
        )
    return f"V has no minimum at any equilibrium{torque} ({rests}); it takes a torque that pushes back from both sides"


def _refused(
    system: Oscillator | VaryingOscillator, tau_0: float, found: Landscape | None, reason: str
) -> StabilityProof:
    rests = _all_points(found) if found else ()
    return StabilityProof(system, tau_0, rests, None, False, "none", False, None, "nothing is claimed", reason)


def _proof(
    system: Oscillator | VaryingOscillator, tau_0: float, found: Landscape, well: int, kept: Reserve
) -> StabilityProof:
    rest = found.rests[well]
    x_low, x_high = found.borders(well)
    x_e = 0.5 * (rest[0] + rest[1])

    def climb(x: float) -> float:
        if math.isinf(x):
            return math.inf
        return float(system.law.energy(x) - system.law.energy(x_e)) - tau_0 * (x - x_e)

    region = Region(x_low, x_high, min(climb(x_low), climb(x_high)))
    everywhere = math.isinf(x_low) and math.isinf(x_high)
    point = rest[0] == rest[1]
    scope: Scope = "local" if not everywhere else ("global" if point else "set")
    asymptotic = kept.left > 0.0
    varying = isinstance(system, VaryingOscillator)
    return StabilityProof(
        system=system,
        tau_0=tau_0,
        equilibria=_all_points(found),
        rest=rest,
        holds=True,
        scope=scope,
        asymptotic=asymptotic,
        region=region,
        claim=_claim(rest, everywhere, asymptotic, varying),
        reason=_reason(found, region, everywhere, point, asymptotic, varying),
        conditions=kept.conditions() if varying else (),
    )


def _claim(rest: tuple[float, float], everywhere: bool, asymptotic: bool, varying: bool) -> str:
    who = "every motion" if everywhere else "every motion that starts in the region stays in it and"
    goal = f"at {_point(rest)}" if rest[0] == rest[1] else f"inside {_point(rest)}"
    if not asymptotic:
        verb = "never gains energy V" if varying else "keeps its energy V"
        return f"{who} {verb}: rest {goal} is stable, but not asymptotically"
    kind = "globally asymptotically stable" if everywhere else "asymptotically stable"
    return f"{who} decays to rest {goal}" + (f" ({kind})" if rest[0] == rest[1] else "")


def _reason(found: Landscape, region: Region, everywhere: bool, point: bool, asymptotic: bool, varying: bool) -> str:
    what = "the equilibrium" if point else "the set of rests inside the gap"
    definite = f"V is positive definite with respect to {what}"
    if everywhere:
        shape = f"{definite} and radially unbounded"
    elif math.isfinite(found.low):
        shape = f"{definite} and its level curves below energy_limit are closed inside |x| <= {found.high:.6g} rad"
    else:
        borders = [f"{x:.6g} rad" for x in (region.x_low, region.x_high) if math.isfinite(x)]
        saddles = " and ".join(borders)
        shape = f"{definite} below the level of the lower saddle (next rests: x = {saddles}), not radially unbounded"
    decay = (
        f"V' = -B v^2 <= 0, and the largest invariant set in v = 0 is {what} (LaSalle)"
        if asymptotic
        else "V' = 0 as B = 0"
    )
    if varying:
        decay = "V' <= 0, as the conditions leave no damping"
        if asymptotic:
            decay = (
                f"V' <= -beta v^2 with beta > 0; b <= b2 bounds the acceleration, so v tends to 0, and with it what is "
                f"left of the torque: x tends to {what} (Barbalat)"
            )
    checked = f"; checked on {SAMPLES + 1} samples, not proved" if math.isfinite(found.low) else ""
    return f"{shape}, {decay}{checked}"


def _all_points(found: Landscape) -> tuple[float, ...]:
    return tuple(sorted({x for rest in found.rests for x in rest if math.isfinite(x)}))


def _point(rest: tuple[float, float] | None) -> str:
    if rest is None:
        return "none"
    return f"x = {rest[0]:.6g} rad" if rest[0] == rest[1] else f"{rest[0]:.6g} <= x <= {rest[1]:.6g} rad"
