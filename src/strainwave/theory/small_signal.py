"""Law under a mean torque: the operating point, its stiffness, and the even terms that appear about it.

A law that is odd about zero is not odd about x0: small motions u about it see T(x0 + u) = T0 + k1 u + k2 u^2 + k3 u^3.
The quadratic term gives a superharmonic resonance at half the natural frequency and softens the backbone
(Nayfeh & Mook 1979, Nonlinear Oscillations, secs. 2.3 and 4.2).
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.law import KINDS, depends
from ..base.quantities import checked, number
from ..model.laws.springs import taylor
from ..numerics.operating_point import operating_point

POINTS = 801


@dataclass(frozen=True)
class SmallSignal:
    """A law about the torsion at which it carries a mean torque.

    Attributes
    ----------
    mean_torque : float
        The mean torque T0 [N*m].
    x : float
        Torsion x0 [rad] of the equilibrium.
    stiffness : float
        T'(x0) [N*m/rad].
    quadratic, cubic : float or None
        k2 [N*m/rad^2] and k3 [N*m/rad^3]; None where they depend on the amplitude and none was given.
    amplitude : float or None
        Amplitude [rad] for which the terms are least-squares ones; None for Taylor coefficients.
    frequency_ratio : float
        Natural frequency at x0 over that at rest, sqrt(T'(x0)/T'(0)); inf where the law has no stiffness at rest.
    backbone : float or None
        b [1/rad^2] of the frequency omega = omega_0 (1 + b a^2) of free vibrations of amplitude a about x0 (to second
        order in a): 3 k3/(8 k1) - 5 k2^2/(12 k1^2); negative: they soften.
    """

    mean_torque: float
    x: float
    stiffness: float
    quadratic: float | None
    cubic: float | None
    amplitude: float | None
    frequency_ratio: float
    backbone: float | None


def small_signal(law: Any, mean_torque: float, *, amplitude: float | None = None) -> SmallSignal:
    """Expand a law about the point where it carries a mean torque.

    Parameters
    ----------
    law : NamedTuple
        Any law `torque(x)`.
    mean_torque : float
        Mean torque [N*m] in the spring.
    amplitude : float, optional
        Amplitude [rad] of the motion about the operating point. With it the terms are those of the cubic that fits the
        law best (least squares in the torque) over x0 - amplitude .. x0 + amplitude. Without it they are Taylor's,
        for polynomial laws; a law of straight lines has none, and a spline's hold nowhere but at the point itself.

    Returns
    -------
    SmallSignal
        Torsion `x` [rad] of the equilibrium, `stiffness` [N*m/rad], `quadratic` and `cubic` terms [N*m/rad^2,
        N*m/rad^3] and the `backbone` [1/rad^2].

    Raises
    ------
    ValueError
        If no torsion carries the torque, or a number is not finite.
    TypeError
        If `law` is no spring.

    References
    ----------
    Nayfeh & Mook 1979, sec. 2.3 (the backbone of a law with quadratic and cubic terms).
    """
    law = checked(law)
    if depends(law) != 1:
        raise TypeError(f"small_signal takes a spring, torque(x); {type(law).__name__} has {KINDS[depends(law) - 1]}")
    mean_torque = number("mean_torque [N*m]", mean_torque)
    amplitude = None if amplitude is None else number("amplitude [rad]", amplitude, positive=True)
    x = operating_point(law, mean_torque)
    k1, at_rest = float(law.stiffness(x)), float(law.stiffness(0.0))
    if amplitude is None:
        k2, k3 = taylor(law, x)
    else:
        s = np.linspace(-1.0, 1.0, POINTS)
        torque = np.asarray(law.torque(x + amplitude * s), float)
        _, _, second, third = np.linalg.lstsq(s[:, None] ** np.arange(4), torque, rcond=None)[0]
        k2, k3 = float(second) / amplitude**2, float(third) / amplitude**3
    backbone = None
    if k2 is not None and k3 is not None and k1 > 0.0:
        backbone = 3.0 * k3 / (8.0 * k1) - 5.0 * k2 * k2 / (12.0 * k1 * k1)
    ratio = math.sqrt(max(k1, 0.0) / at_rest) if at_rest > 0.0 else math.inf
    return SmallSignal(float(mean_torque), x, k1, k2, k3, amplitude, ratio, backbone)
