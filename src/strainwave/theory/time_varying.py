"""When the energy argument for rest survives a damping and a stiffness that change: J x'' + b x' + kappa T(x) = 0.

b = b(t, x') is any damping with 0 < b1 <= b <= b2; kappa(t) = 1 + k > 0 is a smooth periodic factor. Take
V = J v^2/(2 kappa) + U(x). Along a motion V' = -(v^2/kappa) (b + J kappa'/(2 kappa)), so that V falls where
b > -J kappa'/(2 kappa): only a falling stiffness asks for damping. Let beta > 0 be what is left at worst.

V is bounded, hence x and v (in the region); beta times the integral of v^2/kappa is at most V at the start. Since
b <= b2 the acceleration is bounded, v^2 is uniformly continuous, and v -> 0 (Barbalat's lemma). Over any short time the
change of v, -1/J times the integral of b v + kappa T, tends to zero, and the integral of b v too, as b <= b2; kappa
T(x) is uniformly continuous, so T(x) -> 0: x tends to the rests. LaSalle's principle does not apply, as the equation
knows the time.

Both bounds of b are needed. With the lower one alone, x'' + (2 + exp t) x' + x = 0 has the motion x = 1 + exp(-t): the
damper locks before the spring is at rest. A constant torque moves the rest of a varying stiffness: no claim.

Khalil, Nonlinear Systems, 3rd ed., sec. 8.3, lemma 8.2 (Barbalat); the condition on kappa by differentiating V.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..model.varying import NoVariation, Variation
from ..protocols import lacking
from .stability_proof import Obstacle

SAMPLES = 4096  # per turn and order


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
        """What the claim rests on, in sentences."""
        bounds = f"{self.low:.6g} <= b <= {self.high:.6g} N*m*s/rad at all angles and speeds"
        if not self.asked:
            return (bounds,)
        return bounds, f"b > -J kappa'/(2 kappa), at most {self.asked:.6g} N*m*s/rad, where the stiffness falls"


def reserve(system: Any, tau_0: float) -> Reserve:
    """Damping of a `VaryingOscillator` under the mean torque tau_0 [N*m], against what the argument needs."""
    if lacking(system.damping, "bounds"):
        name = type(system.damping).__name__
        fact = f"{name} has no method bounds(), which gives b1 <= b <= b2"
        return Reserve(0.0, 0.0, 0.0, Obstacle(fact, "define it"))
    low, high = (float(b) for b in system.damping.bounds())
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


def _obstacle(low: float, high: float, asked: float) -> Obstacle | None:
    if not math.isfinite(high):
        return Obstacle(
            "the damping has no upper bound, and a lower bound alone is not enough",
            "x'' + (2 + exp t) x' + x = 0 has the motion x = 1 + exp(-t), which does not decay: give a damping with "
            "b <= b2",
        )
    if low < 0.0:
        fact = f"the damping falls to {low:.6g} N*m*s/rad, where motions gain energy"
        return Obstacle(fact, "give a damping b1 >= 0")
    if low < asked:
        return Obstacle(
            f"the stiffness falls so fast that the argument needs a damping of {asked:.6g} N*m*s/rad and the smallest "
            f"damping is {low:.6g}",
            "the condition is sufficient, not necessary: give more damping or less variation, or use "
            "parametric_resonances to see whether small motions grow",
        )
    return None


def _steepest_fall(system: Any) -> float:
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
