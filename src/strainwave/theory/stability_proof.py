"""Claim of Lyapunov's direct method about the dynamic error: the function V, its rate, the region, and the damping.

`reserve` says how much damping the argument has left where damping and stiffness change: J x'' + b x' + kappa T(x) = 0.
"""

import math
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np

from ..base.protocols import lacking
from ..base.quantities import Reals, array_of
from ..base.records import Result
from ..base.sentences import Angle, Sentence
from ..base.terminal import on_screen
from ..model.laws.springs import energy_in
from ..model.oscillator import NoVariation, Oscillator, Variation, VaryingOscillator

SAMPLES = 4096  # per turn and order

Scope = Literal["global", "local", "set", "none"]


class Obstacle(NamedTuple):
    """Obstacle in the way of a claim, and what follows from it or helps, as sentences."""

    fact: str
    remedy: str


@dataclass(frozen=True)
class Region:
    """Region of a claim: x_low < x < x_high [rad] and V(x, v) < energy_limit [J]; infinite where nothing limits."""

    x_low: float = -math.inf
    x_high: float = math.inf
    energy_limit: float = math.inf

    def __str__(self) -> str:
        ends = [x for x in (self.x_low, self.x_high) if math.isfinite(x)]
        if not ends:
            return "all x and v"
        text = "{}" if len(ends) == 2 else "{} < x" if math.isfinite(self.x_low) else "x < {}"
        return Sentence(f"{text} and V < {self.energy_limit:.6g} J", Angle(*ends, between=" < x < "))


@dataclass(frozen=True, eq=False)
class StabilityProof(Result):
    """Claim of Lyapunov's direct method about the unforced dynamic error, or the reason why there is none.

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
        True for a claim.
    scope : {"global", "local", "set", "none"}
        For all starts; for starts in `region`; for all starts, to a set of rests (backlash); no claim.
    asymptotic : bool
        True where motions converge (B > 0), false where they only stay near (B = 0).
    region : Region or None
        Region of starts for which the claim holds.
    claim, reason : str
        The claim, and the sentence that proves it or says what is in the way and what helps.
    obstacle : str
        Obstacle in a few words; empty with a claim.
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
    obstacle: str = ""

    @classmethod
    def refused(
        cls, system: Any, tau_0: float, obstacle: "Obstacle", equilibria: tuple[float, ...] = ()
    ) -> "StabilityProof":
        """No claim about a system under a mean torque [N*m], for a reason; rests [rad] that are known."""
        return cls(
            system, tau_0, equilibria, None, False, "none", False, None, "nothing is claimed",
            Sentence("{}; {}", *obstacle), (), obstacle.fact,
        )  # fmt: skip

    def V(self, x: Reals, v: Reals, phase: Reals = 0.0) -> Any:
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
        x, v, phase = _state(x, v, phase)
        x_e = 0.5 * (self.rest[0] + self.rest[1]) if self.rest else 0.0
        stored: Any = energy_in(self.system.law)
        kappa = self.system.variation.value(phase) if isinstance(self.system, VaryingOscillator) else 1.0
        return 0.5 * self.system.J * v * v / kappa + stored(x) - stored(x_e) - self.tau_0 * (x - x_e)

    def dissipation(self, x: Reals, v: Reals, phase: Reals = 0.0) -> Any:
        """Rate V' [W] along the motion, -B v^2 or -(b + J kappa'/(2 kappa)) v^2/kappa; arguments as of V."""
        x, v, phase = _state(x, v, phase)
        if not isinstance(self.system, VaryingOscillator):
            return -self.system.B * v * v + 0.0 * x
        kappa, rate = self.system.variation.value(phase), self.system.omega * self.system.variation.slope(phase)
        b = self.system.damping.value(phase, v)
        return -(b + 0.5 * self.system.J * rate / kappa) * v * v / kappa + 0.0 * x

    def contains(self, x: float, v: float, phase: float = 0.0) -> bool:
        """True if the claim covers a motion that starts at the error x [rad], the rate v [rad/s] and a base angle."""
        region = self.region
        if region is None or not region.x_low < x < region.x_high:
            return False
        return bool(self.V(x, v, phase) < region.energy_limit)

    def __str__(self) -> str:
        torque = f", mean torque {self.tau_0:.6g} N*m" if self.tau_0 else ""
        origin = f", relative to its value at {rest_text(self.rest)}" if self.rest else ""
        equation, square, loss = "J x'' + B x' + T(x)", "J v^2/2", "-B v^2"
        if isinstance(self.system, VaryingOscillator):
            equation, square = "J x'' + b(t) x' + kappa(t) T(x)", "J v^2/(2 kappa)"
            loss = "-(b + J kappa'/(2 kappa)) v^2/kappa"
        else:
            loss += f", B = {self.system.B:.6g} N*m*s/rad"
        return on_screen(
            "\n".join(
                [
                    f"Stability of {equation} = tau_0 with {self.system.law}{torque}",
                    f"  V  = {square} + U(x) - tau_0 x{origin}",
                    f"  V' = {loss}",
                    *(f"  condition: {condition}" for condition in self.conditions),
                    f"  claim ({self.scope}): {self.claim}",
                    f"  region: {self.region if self.region else 'none'}",
                    f"  reason: {self.reason}",
                    "  set aside: the periodic part of the torque and the kinematic error",
                ]
            )
        )


def _state(x: Reals, v: Reals, phase: Reals) -> tuple[Any, Any, Any]:
    """A state and its base angle, of finite numbers."""
    return array_of("x [rad]", x)[()], array_of("v [rad/s]", v)[()], array_of("phase [rad]", phase)[()]


def rest_text(ends: tuple[float, float] | None) -> str:
    """Write a rest [rad], of which a set is given by its ends."""
    if ends is None:
        return "none"
    if ends[0] == ends[1]:
        return Sentence("x = {}", Angle(ends[0]))
    return Sentence("{}", Angle(*ends, between=" <= x <= "))


@dataclass(frozen=True)
class Reserve:
    """Bounds of the damping, what a falling stiffness asks for, and what is left [all N*m*s/rad]; or an obstacle."""

    low: float
    high: float
    asked: float
    obstacle: Obstacle | None = None

    @property
    def left(self) -> float:
        """Damping beta that makes V fall, at least."""
        return self.low - self.asked

    def conditions(self) -> tuple[str, ...]:
        """Grounds of the claim, in sentences."""
        bounds = f"{self.low:.6g} <= b <= {self.high:.6g} N*m*s/rad at all angles and speeds"
        if not self.asked:
            return (bounds,)
        return bounds, f"b > -J kappa'/(2 kappa), at most {self.asked:.6g} N*m*s/rad, where the stiffness falls"


def reserve(system: VaryingOscillator, tau_0: float) -> Reserve:
    """Damping of a `VaryingOscillator` under the mean torque tau_0 [N*m], against what the argument needs."""
    if lacking(system.damping, "bounds"):
        name = type(system.damping).__name__
        fact = f"{name} has no method bounds(), which gives b1 <= b <= b2"
        return Reserve(0.0, 0.0, 0.0, Obstacle(fact, "define it"))
    low, high = map(float, system.damping.bounds())
    if not isinstance(system.variation, Variation | NoVariation):
        name = type(system.variation).__name__
        fact = f"the extremes of {name} are not known"
        return Reserve(low, high, 0.0, Obstacle(fact, "write the variation as a Variation"))
    if isinstance(system.variation, Variation) and tau_0 != 0.0:
        fact = (
            f"the mean torque {tau_0:.6g} N*m twists a varying stiffness by a varying angle, so there is no equilibrium"
        )
        remedy = "find the forced orbit with find_orbit, whose multipliers tell its stability"
        return Reserve(low, high, 0.0, Obstacle(fact, remedy))
    asked = float(0.5 * system.J * _steepest_fall(system))
    return Reserve(low, high, asked, _obstacle(low, high, asked))


def _obstacle(low: float, high: float, needed: float) -> Obstacle | None:
    if not math.isfinite(high):
        return Obstacle(
            "the damping has no upper bound, and a lower bound alone is not enough",
            "x'' + (2 + exp t) x' + x = 0 has the motion x = 1 + exp(-t), which does not decay: give a damping with "
            "b <= b2",
        )
    if low < 0.0:
        fact = f"the damping falls to {low:.6g} N*m*s/rad, where motions gain energy"
        return Obstacle(fact, "give a damping b1 >= 0")
    if low < needed:
        return Obstacle(
            f"the stiffness falls so fast that the argument needs a damping of {needed:.6g} N*m*s/rad and the smallest "
            f"damping is {low:.6g}",
            "the condition is sufficient, not necessary: give more damping or less variation, or use "
            "parametric_resonances to see whether small motions grow",
        )
    return None


def _steepest_fall(system: VaryingOscillator) -> float:
    """Upper bound of -kappa'/kappa [1/s] over a turn: sampled, plus what may hide between the samples."""
    if isinstance(system.variation, NoVariation):
        return 0.0
    ripples, least = system.variation.ripples, 1.0 - system.variation.depth()
    count = SAMPLES * max(ripple.order for ripple in ripples)
    angles = np.linspace(0.0, 2.0 * math.pi, count, endpoint=False)
    fall = -system.omega * system.variation.slope(angles) / system.variation.value(angles)
    first = sum(abs(r.depth) * r.order for r in ripples) / least
    second = sum(abs(r.depth) * r.order**2 for r in ripples) / least
    return float(np.max(fall) + abs(system.omega) * (second + first * first) * math.pi / count)
