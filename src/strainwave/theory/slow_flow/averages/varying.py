"""A stiffness and a damping that vary with the base angle, in the slow flow of first order.

With the mean damping B, mu = B/J, and N of the constant stiffness, the equation

    J u'' + b(theta, u') u' + kappa(theta) T(u) = tau - J omega^2 e''

has kappa (T(u) - T(u0)) + (b - B) u' beyond the linear part: what is averaged. kappa T(u0) is a line of the forcing. A
line k cos(n theta + phi) of kappa adds i omega_0 (k/4) exp(i phi) conj(z) to z' at n omega = 2 Omega: the principal
tongue (Nayfeh & Mook 1979, Nonlinear Oscillations, sec. 5.2).
"""

import math
from typing import Any

import numpy as np

from ....base.protocols import lacking, orders_of
from ....base.results import Floats

POINTS = 64  # of a turn, beside eight per period of the highest order


def varies(system: Any) -> bool:
    """True for a system with a stiffness and a damping of its own objects, as a `VaryingOscillator`."""
    return bool(lacking(system, "B")) and not lacking(system, "damping", "variation")


def parts_of(system: Any) -> tuple[str, ...]:
    """Fields and methods that the slow flow asks of a system."""
    damping = ("damping", "variation") if varies(system) else ("B",)
    return "J", *damping, "law", "excitation", "omega", "error"


def mean_damping(system: Any) -> float:
    """Damping [N*m*s/rad] at rest, its mean over a turn of the base angle."""
    if not varies(system):
        return float(system.B)
    theta = _turn(varied_orders(system))
    return float(np.mean(system.damping.slope(theta, 0.0) + 0.0 * theta))


def varied_orders(system: Any) -> tuple[int, ...]:
    """Orders of what varies on the base angle; the first for a part that does not say."""
    if not varies(system):
        return ()
    parts = system.variation, system.damping
    return tuple(int(k) for part in parts for k in ((1,) if lacking(part, "orders") else orders_of(part)))


def pulling_lines(system: Any, orders: tuple[int, ...], torque: float) -> Any:
    """Complex amplitudes [N*m] at orders of the torque T(u0) [N*m] times a stiffness that varies."""
    theta = _turn(orders)
    lines = 2.0 * torque * np.fft.rfft(system.variation.value(theta) + 0.0 * theta)[list(orders)] / len(theta)
    return np.where(np.isin(orders, orders_of(system.variation)), lines, 0.0)


def _turn(orders: tuple[int, ...]) -> Floats:
    n = 1 << math.ceil(math.log2(8 * max((1, *orders)) + POINTS))
    return 2.0 * np.pi * np.arange(n) / n


def torques(s: Any, theta: Floats, u: Floats, v: Floats) -> Floats:
    """Torque [N*m] of spring and damping at angles, torsions and rates, but for B v and what counts as a line."""
    system, offset = s.system, s.system.law.torque(s.u0)
    pull = system.variation.value(theta) * (system.law.torque(u) - offset)
    return np.asarray(offset + pull + (system.damping.value(theta, v) - s.B) * v)


def stiffnesses(s: Any, theta: Floats, u: Floats, _: Floats) -> Floats:
    """Derivative [N*m/rad] of `torques` to the torsion."""
    return np.asarray(s.system.variation.value(theta) * s.system.law.stiffness(u) + 0.0 * u)


def dampings(s: Any, theta: Floats, _: Floats, v: Floats) -> Floats:
    """Derivative [N*m*s/rad] of `torques` to the rate of the torsion."""
    return np.asarray(s.system.damping.slope(theta, v) - s.B + 0.0 * v)
