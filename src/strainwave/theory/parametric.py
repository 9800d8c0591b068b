"""`parametric_resonances`: at which speeds a varying stiffness meets twice a natural frequency, and whether it grows.

About its operating point the drive is Hill's equation. Its period map over one turn of the base angle has two
multipliers whose product says how fast motions decay on average; their sum D, relative to the root of the product, is
2 cos(2 pi omega_0/omega) for a constant stiffness and leaves -2 .. 2 in the tongues, one about every extremum
omega = 2 omega_0/m. There motions grow unless the damping suffices. Line i of the stiffness opens m = i n, two lines
i and j together open m = i + j and |i - j|.

Nayfeh & Mook 1979, Nonlinear Oscillations, secs. 5.2-5.3; Magnus & Winkler 1966, Hill's Equation, ch. II.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from ..base.law import repeating
from ..base.protocols import lacking, orders_of, with_parts
from ..base.quantities import interval, leaf_of, replace
from ..base.results import Floats
from ..model.excitation import Harmonic, NoError, mean_torque
from ..model.laws.springs import Linear
from ..model.oscillator import Variation
from ..numerics.balance.first_order import first_order
from ..numerics.operating_point import operating_point
from ..numerics.stability.first_order import period_maps

HIGHEST = 4  # multiple n of a line's half order that is looked at
ROUNDING = 1e-11  # of the traces: a tongue that has closed is none
DEAD_RATIO = 0.99  # damping ratio at which a vibration falls to exp(-44) in a cycle
LARGE_LOGARITHM = 700.0  # logarithm of a trace D whose arcosh(D/2) is log D


@dataclass(frozen=True)
class ParametricResonance:
    """One speed at which the stiffness varies 2/n times as fast as the drive vibrates.

    Attributes
    ----------
    omega : float
        Base speed [rad/s] of the centre: 2 omega_0/m, corrected for the depth of the variation.
    m : int
        Half vibrations per turn of the base angle.
    cause : str
        The lines of the stiffness behind it.
    growth : float
        Rate [1/s] at which motions grow at the centre (negative: they decay), exact for the linearised drive.
    unstable : bool
        True if they grow.
    low, high : float
        Edges [rad/s] of the unstable range of the base speed; nan where the damping suffices, and for an edge at which
        the next tongue begins.
    damping_ratio, damping_needed : float
        Damping ratio (mean over a turn), and the one that would suffice at the centre (to second order in it).
    turns : int
        Turns of the base angle after which a motion there repeats: 2 for a period doubling.
    """

    omega: float
    m: int
    cause: str
    growth: float
    unstable: bool
    low: float
    high: float
    damping_ratio: float
    damping_needed: float
    turns: int

    def __str__(self) -> str:
        behaviour = (
            f"unstable from {self.low:.6g} to {self.high:.6g} rad/s, growing by {self.growth:.3g} 1/s"
            if self.unstable
            else f"motions decay by {-self.growth:.3g} 1/s"
        )
        return (
            f"{self.cause} at {self.omega:.5g} rad/s: {behaviour}; damping ratio {self.damping_ratio:.3g}, needed "
            f"{self.damping_needed:.3g}"
        )


def parametric_resonances(system: Any, span: tuple[float, float]) -> list[ParametricResonance]:
    """Find the speeds at which a varying stiffness can make a drive vibrate, and say whether the damping suffices.

    Parameters
    ----------
    system : VaryingOscillator
        The drive; it is linearised about the torsion under its mean torque. Its `omega` is ignored.
    span : (float, float)
        Range of the base speed [rad/s], 0 < low < high.

    Returns
    -------
    list of ParametricResonance
        Each with its centre `omega` and the edges `low` and `high` of its unstable range [rad/s], whether it is
        `unstable`, and the `damping_needed` against the `damping_ratio`. By rising speed; those whose centre or
        unstable range lies in the span, for n up to 4 and pairs of lines. Empty for a stiffness that does not
        vary, and for a mean damping ratio from 0.99 up: nothing vibrates. A forced orbit of large amplitude has
        multipliers of its own: see `frequency_response`, whose `doublings` (odd m) and `branch_points` (even m)
        are the edges of the tongues on it.

    Raises
    ------
    TypeError
        If the system has no `damping` and `variation`.
    ValueError
        If the span is not 0 < low < high, or the drive has no stiffness at its operating point.

    References
    ----------
    Nayfeh & Mook 1979, Nonlinear Oscillations, secs. 5.2-5.3.
    """
    parts = "J", "damping", "law", "variation", "omega"
    system = repeating("parametric_resonances", with_parts("parametric_resonances", system, *parts))
    lo, hi = interval("the range of omega", span, positive=True)
    torque = mean_torque(system.excitation)
    stiffness = float(system.law.stiffness(operating_point(system.law, torque)))
    if not stiffness > 0.0:
        raise ValueError(
            f"the stiffness under the mean torque {torque:g} N*m is {stiffness:g} N*m/rad; it takes a positive one"
        )
    linear = system._replace(law=Linear(stiffness), excitation=Harmonic(0.0), error=NoError(), omega=lo)
    omega_0 = math.sqrt(stiffness / system.J)
    free, causes = _damped_frequency(linear, omega_0), _causes(tuple(map(int, orders_of(system.variation))))
    if free == 0.0 or not causes:
        return []
    fast, g = _on_own_turn(linear)
    brackets = [(m, cause, _bracket(free, m // g)) for m, cause in causes.items()]
    candidates = [(m, cause) for m, cause, (low, high) in brackets if lo * g <= high and hi * g >= low]
    resonances = [_resonance(fast, omega_0, free, m, g, cause) for m, cause in candidates]
    inside = [r for r in resonances if lo <= r.omega <= hi or (r.unstable and r.low <= hi and r.high >= lo)]
    return sorted(inside, key=lambda r: r.omega)


def _causes(orders: tuple[int, ...]) -> dict[int, str]:
    """Half vibrations a turn, and the lines that feed them: single lines first, low n first."""
    causes: dict[int, str] = {}
    for n in range(1, HIGHEST + 1):
        for i in orders:
            causes.setdefault(i * n, f"order {i} of the stiffness meets 2 omega_0{f'/{n}' if n > 1 else ''}")
        if n == 1:
            for i, j in combinations(sorted(set(orders)), 2):
                for m, sign in ((i + j, "+"), (j - i, "-")):
                    causes.setdefault(m, f"orders {j} {sign} {i} of the stiffness meet 2 omega_0")
    return causes


def _on_own_turn(linear: Any) -> tuple[Any, int]:
    """Return the drive on the period of what varies, g times as fast as the base angle, and g.

    On the base angle tongues of high order would lie next to others that are closed, and reach beyond them.
    """
    parts = {
        "variation": linear.variation,
        "damping.variation": None if lacking(linear.damping, "variation") else linear.damping.variation,
    }
    varied = {path: part for path, part in parts.items() if isinstance(part, Variation)}
    orders = (*linear.variation.orders(), *orders_of(linear.damping))
    g = math.gcd(*orders)
    if g < 2 or sorted(orders) != sorted(order for part in varied.values() for order in part.orders()):
        return linear, 1
    slowed = {
        path: Variation(tuple(ripple._replace(order=ripple.order // g) for ripple in part.ripples))
        for path, part in varied.items()
    }
    return replace(linear, slowed), g


def _damped_frequency(linear: Any, omega_0: float) -> float:
    """Frequency [rad/s] of the free vibration under the mean damping; 0 where there is none."""
    angles = np.linspace(0.0, 2.0 * math.pi, 16 * max((1, *linear.orders())), endpoint=False)
    mean = float(np.mean(np.broadcast_to(linear.damping.slope(angles, 0.0), angles.shape)))
    share = mean / (2.0 * linear.J * omega_0)
    return omega_0 * math.sqrt((1.0 - share) * (1.0 + share)) if abs(share) < DEAD_RATIO else 0.0


def _bracket(free: float, m: int) -> tuple[float, float]:
    """Base speeds [rad/s] between which tongue m lies."""
    return 2.0 * free / (m + 0.5), 2.0 * free / (m - 0.5)


def _resonance(linear: Any, omega_0: float, free: float, base: int, g: int, cause: str) -> ParametricResonance:
    m = base // g
    leaf = leaf_of(linear, "omega")
    problem = first_order(linear, leaf, leaf, 2 * max((1, *linear.orders())))

    def hill(omega: Floats) -> tuple[Floats, Floats]:
        """Sizes log(1 + |D|) of the relative traces, positive in tongue m, and logarithms of the determinant's root."""
        points = np.zeros((len(omega), problem.size() + 1))
        points[:, -1] = omega
        flow, (_, size, decay) = period_maps(problem, points, hill=True)
        trace = (-1.0) ** m * np.trace(flow, axis1=1, axis2=2)
        with np.errstate(divide="ignore"):
            return np.sign(trace) * np.logaddexp(0.0, np.log(np.abs(trace)) + size), decay

    def beyond(omega: Floats) -> Floats:
        """Positive where the larger multiplier is outside the unit circle: D above 2 cosh(decay)."""
        trace, decay = hill(omega)
        return trace - np.logaddexp(0.0, np.logaddexp(decay, -decay))

    low, high = _bracket(free, m)
    centre = _summit(lambda omega: hill(omega)[0], low, high)
    traces, decays = hill(np.array([centre]))
    turn = 2.0 * math.pi / centre
    trace = float(traces[0])
    feeding = (trace if trace > LARGE_LOGARITHM else math.acosh(max(1.0, 0.5 * math.expm1(trace)))) / turn
    loss = -float(decays[0]) / turn
    unstable = bool(beyond(np.array([centre]))[0] > ROUNDING)
    edges = [_crossing(beyond, centre, end) / g if unstable else math.nan for end in (low, high)]
    first, last = edges
    return ParametricResonance(
        centre / g, base, cause, feeding - loss, unstable, first, last, loss / omega_0, feeding / omega_0, 1 + base % 2
    )


def _summit(f: Callable[[Floats], Floats], low: float, high: float) -> float:
    """Place of the largest value of a function with one maximum between low and high."""
    for count in (65, 17, 17, 17, 17):
        x = np.linspace(low, high, count)
        best = int(np.argmax(f(x)))
        low, high = float(x[max(0, best - 1)]), float(x[min(count - 1, best + 1)])
    return 0.5 * (low + high)


def _crossing(f: Callable[[Floats], Floats], inside: float, outside: float) -> float:
    """Place between `inside`, where f > 0, and `outside` where f changes sign first; nan where it does not."""
    for count in (65, 17, 17, 17):
        x = np.linspace(inside, outside, count)
        values = f(x)
        below = np.flatnonzero(values <= 0.0)
        if not len(below):
            return math.nan
        i = max(1, int(below[0]))
        inside, outside = float(x[i - 1]), float(x[i])
    return inside + (outside - inside) * float(values[i - 1] / (values[i - 1] - values[i]))
