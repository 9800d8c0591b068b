"""Trade of the cubic coefficient alpha: peak, its speed, error at the speeds of duty, superharmonic, jump.

The resonance curve bends with alpha; at first order its peak f/(mu omega_0) stays (Nayfeh & Mook 1979, Nonlinear
Oscillations, sec. 4.1.1), and the superharmonic of order 3 grows in proportion to alpha (sec. 4.1.3). Here every number
is that of harmonic balance.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import minimize_scalar

from ...base.law import polynomial_of
from ...base.protocols import with_parts
from ...base.quantities import checked, interval, numbers, replace, samples_of, shown
from ...base.records import Along, Labelled, Result
from ...base.results import Branch, Floats, SolveError
from ...base.sentences import Sentence, Speed
from ...base.series import oscillation
from ...base.terminal import on_screen
from ...drive.jumps import jumps
from ...model.laws.springs import Cubic
from ...numerics.balance.fourier import with_velocity
from ...numerics.balanced_orbit import find_orbit
from ...numerics.curves.response import response_family
from ...theory.slow_flow.setting import active_orders

POINTS = 200  # of a curve, at least
WINDOW = 0.25, 0.5  # of omega_0 over the order of excitation: where the third harmonic's resonance is looked for
CREST_TOLERANCE = 1e-9  # of omega: the crest is flat, its size is found to rounding
RANGE_END = 1.2  # of that frequency: at least so far the range must go


@dataclass(frozen=True, eq=False)
class Hardening(Result):
    """One drive with several cubic coefficients alpha.

    Attributes
    ----------
    alpha : (n,) array
        Cubic coefficients [1/rad^2]; negative ones soften.
    peak, peak_speed : (n,) array
        Largest oscillation of x [rad] on stable motions of the curve, and its speed [rad/s]: the primary resonance.
    superharmonic, superharmonic_speed : (n,) array
        Largest component of x [rad] at three times the order of excitation, near a third of the primary resonance.
    jump_low, jump_high : (n,) array
        Speeds [rad/s] where the widest jump down and up bound the band with two motions; equal without jumps.
    inside : (n,) boolean array
        Whether the curve reaches both ends of the range and its peak lies between them; only these compare.
    speeds : (speeds,) array
        The speeds of duty [rad/s].
    at_speeds : (n, speeds) array
        Largest oscillation of x [rad] of the stable motions at them.
    """

    alpha: Floats
    peak: Floats
    peak_speed: Floats
    superharmonic: Floats
    superharmonic_speed: Floats
    jump_low: Floats
    jump_high: Floats
    inside: NDArray[np.bool_]
    speeds: Floats
    at_speeds: Floats

    rows: ClassVar[str] = "alpha"
    arrays: ClassVar[Along] = {
        "alpha": {
            "peak": "rad", "peak_speed": "rad/s", "superharmonic_speed": "rad/s", "superharmonic": "rad",
            "jump_low": "rad/s", "jump_high": "rad/s", "inside": "",
        },
        ("alpha", "speed"): {"at_speeds": "rad"},
    }  # fmt: skip

    @property
    def jump_width(self) -> Floats:
        """Width [rad/s] of the band with two motions."""
        return self.jump_high - self.jump_low

    def best(self, weights: ArrayLike | None = None) -> float:
        """Return the alpha [1/rad^2] with the smallest rms, over the duty, of the largest oscillation at each speed.

        Parameters
        ----------
        weights : (speeds,) array_like, optional
            Time that the duty spends at each speed, in any unit. Default: equal times.

        Raises
        ------
        ValueError
            If there are no speeds of duty, or the weights do not fit.
        """
        n = len(self.speeds)
        if not n:
            raise ValueError("best needs the speeds of the duty; give hardening(..., speeds=[...])")
        share = np.ones(n) if weights is None else numbers("weights", weights, count=n)
        if np.any(share < 0.0) or not np.any(share > 0.0):
            raise ValueError(f"weights are {shown(weights)}; they must be times, zero or more and not all zero")
        return float(self.alpha[np.argmin(self.at_speeds**2 @ share)])

    def coordinates(self) -> Labelled:
        """The coefficients and the speeds of duty."""
        return {"alpha": ("alpha", self.alpha, "1/rad**2"), "speed": ("speed", self.speeds, "rad/s")}

    def __str__(self) -> str:
        lines = [f"Hardening: {len(self.alpha)} coefficients, {np.sum(~self.inside)} with a peak outside the range"]
        lines += [
            f"  alpha {a:.4g} 1/rad^2: peak {p:.5g} rad at {w:.5g} rad/s, superharmonic {s:.3g} rad, jump over {j:.4g} "
            "rad/s"
            for a, p, w, s, j in zip(
                self.alpha, self.peak, self.peak_speed, self.superharmonic, self.jump_width, strict=True
            )
        ]
        return on_screen("\n".join(lines))


def hardening(
    system: Any, alpha: ArrayLike, span: tuple[float, float], *, speeds: ArrayLike = (), harmonics: int | None = None
) -> Hardening:  # fmt: skip
    """Compare a drive with several cubic coefficients.

    Parameters
    ----------
    system : Oscillator
        The error equation with a law that is linear or cubic and one order of excitation; its own alpha is ignored.
    alpha : (n,) array_like
        Cubic coefficients [1/rad^2], of either sign. Those of the catalogue's gears are `gear.cubic.alpha`.
    span : (float, float)
        Range of omega [rad/s], from below the superharmonic to above the primary resonance.
    speeds : (speeds,) array_like, optional
        Speeds of the duty [rad/s], inside the range.
    harmonics : int, optional
        As in `frequency_response`.

    Returns
    -------
    Hardening
        For each `alpha` [1/rad^2] the largest oscillation `peak` [rad] and its `peak_speed` [rad/s], the
        superharmonic, and the band of two motions `jump_low` to `jump_high` [rad/s].

    Raises
    ------
    ValueError
        If the law is not cubic, the excitation has another number of orders than one, a speed is outside the range, or
        the range does not hold both resonances.
    SolveError
        If a curve, or a speed of the duty, has no stable motion.
    """
    system, order, omega_0 = _cubic(system)
    coefficients, (lo, hi) = numbers("alpha [1/rad^2]", alpha), interval("span [rad/s]", span, positive=True)
    duty = numbers("speeds [rad/s]", speeds) if samples_of("speeds [rad/s]", speeds).size else np.empty(0)
    lowest, highest = WINDOW[0] * omega_0 / order, RANGE_END * omega_0 / order
    if lo > lowest or hi < highest:
        raise ValueError(
            f"the range is {lo:.9g} to {hi:.9g} rad/s; it must hold both resonances: take {0.9999 * lowest:.5g} to "
            f"{1.0001 * highest:.5g} rad/s, or more"
        )
    if np.any((duty < lo) | (duty > hi)):
        raise ValueError(f"speeds are {shown(speeds)}; they must lie inside the range, {lo:g} to {hi:g} rad/s")
    curves = response_family(system, (lo, hi), {"law.alpha": coefficients}, harmonics=harmonics, points=POINTS)
    members = [replace(system, {"law.alpha": float(a)}) for a in coefficients]
    pairs = list(zip(members, curves, strict=True))
    columns = CurveFigures(*map(np.array, zip(*(_figures(*pair, order, omega_0) for pair in pairs), strict=True)))
    at_duty = [[_oscillation_at(member._replace(omega=float(w)), curve) for w in duty] for member, curve in pairs]
    sizes = np.array(at_duty).reshape(len(coefficients), len(duty))
    return Hardening(coefficients, *columns, speeds=duty, at_speeds=sizes)


def _cubic(system: Any) -> tuple[Any, int, float]:
    """The system, its one order of excitation and its natural frequency [rad/s] without the cubic term."""
    system = checked(with_parts("hardening", system, "law", "excitation", "error"))
    coefficients = (*(polynomial_of(system.law) or ()), 0.0, 0.0, 0.0, 0.0)
    if not coefficients[1] > 0.0 or coefficients[0] or coefficients[2] or any(coefficients[4:]):
        raise ValueError(f"hardening requires a Cubic law, not {shown(system.law)}; gear.cubic gives that of a gear")
    system = system._replace(law=Cubic(coefficients[1], coefficients[3] / coefficients[1]))
    orders = active_orders(system)
    if len(orders) != 1:
        raise ValueError(
            f"hardening requires one order of excitation, but the system has {len(orders)}: {shown(list(orders))}"
        )
    return system, int(orders[0]), float(np.sqrt(system.law.K / system.J))


class CurveFigures(NamedTuple):
    """Numbers of one curve, or an array of them of several: the fields of `Hardening`."""

    peak: Any
    peak_speed: Any
    superharmonic: Any
    superharmonic_speed: Any
    jump_low: Any
    jump_high: Any
    inside: Any


def _figures(system: Any, curve: Branch, order: int, omega_0: float) -> CurveFigures:
    """Numbers of the response curve with one coefficient."""
    if not curve.stable.any():
        raise SolveError(f"the response has no stable motion: {curve.message}; give the drive damping")
    sweep, sizes = jumps(curve), np.where(curve.stable & curve.inside, curve.oscillation, 0.0)
    top = int(np.argmax(sizes))
    widest = max(sweep.bands, key=lambda band: band.high - band.low, default=None)
    low, high = (curve.omega[top],) * 2 if widest is None else (widest.low, widest.high)
    inside = bool(curve.status.found and curve.omega[top] not in curve.span)
    third = _superharmonic(system, curve, order, omega_0)
    return CurveFigures(sizes[top], curve.omega[top], *third, low, high, inside)


def _superharmonic(system: Any, curve: Branch, order: int, omega_0: float) -> tuple[float, float]:
    """Largest stable component [rad] at three times the order near its resonance, and its speed [rad/s].

    That resonance may be narrower than the distance of two points: its crest is sought between their neighbours.
    """
    window = curve.stable & (curve.omega * order > WINDOW[0] * omega_0) & (curve.omega * order < WINDOW[1] * omega_0)
    sizes = np.where(window, curve.amplitude(3 * order), 0.0)
    top = int(np.argmax(sizes))
    size, speed = float(sizes[top]), float(curve.omega[top])
    neighbours = curve.omega[max(top - 1, 0) : top + 2]
    if len(neighbours) < 3 or not (np.all(np.diff(neighbours) > 0.0) or np.all(np.diff(neighbours) < 0.0)):
        return size, speed

    def less(omega: float) -> float:
        orbit = find_orbit(system._replace(omega=omega), guess=with_velocity(curve.coefficients[top], omega))
        return -orbit.amplitude(3 * order) if orbit.status.found and orbit.stable else 0.0

    ends = float(neighbours.min()), float(neighbours.max())
    best = minimize_scalar(less, bounds=ends, method="bounded", options={"xatol": CREST_TOLERANCE * speed})
    return max((size, speed), (-float(best.fun), float(best.x)))


def _oscillation_at(system: Any, curve: Branch) -> float:
    """Largest oscillation [rad] of the stable motions of a curve at the system's speed."""
    sizes = []
    for i, j in pairwise(range(len(curve.omega))):
        first, second = curve.omega[i] - system.omega, curve.omega[j] - system.omega
        if first * second > 0.0 or first == second or not (curve.stable[i] or curve.stable[j]):
            continue
        share = first / (first - second)
        x = (1.0 - share) * curve.coefficients[i] + share * curve.coefficients[j]
        orbit = find_orbit(system, guess=with_velocity(x, system.omega))
        if orbit.status.found and orbit.stable:
            sizes.append(float(oscillation(orbit.coefficients[None, :, 0])[0]))
    if not sizes:
        raise SolveError(Sentence("no stable motion is found at {} with {}", Speed(system.omega), str(system.law)))
    return max(sizes)
