"""Principal parametric resonance of a spring whose stiffness varies: x'' + mu x' + omega_0^2 (1 + k cos Omega t) x = 0.

One harmonic, x = Re A exp(i w t) with w = Omega/2: the product of the varying stiffness with the motion falls back on w
and feeds it, 2 i w A' + (omega_0^2 - w^2 + i mu w) A + k omega_0^2/2 conj(A) = 0. Its solutions grow as exp(s t),
s = -mu/2 + sqrt((k omega_0^2/2)^2 - (omega_0^2 - w^2)^2)/(2 w); s = 0 are the edges of the tongue,
w^2 = omega_0^2 - mu^2/2 +- sqrt((k omega_0^2/2)^2 - mu^2 omega_0^2 + mu^4/4), near Omega = 2 omega_0
+- sqrt((k omega_0/2)^2 - mu^2). It has an inside for k > 2 mu/omega_0 = 4 times the damping ratio.

Nayfeh & Mook 1979, Nonlinear Oscillations, secs. 5.3 and 5.7 (Mathieu's equation, with viscous damping).
"""

import math
from dataclasses import dataclass

from ..base.quantities import number


@dataclass(frozen=True)
class ParametricTongue:
    """Where one line of varying stiffness makes the rest unstable; first order in its depth.

    Attributes
    ----------
    low, high : float
        Edges [rad/s] of the frequency of the stiffness; both nan where the damping suffices.
    threshold : float
        Smallest depth that can make it unstable.
    growth : float
        Rate [1/s] of growth at twice the natural frequency (negative: decay).
    """

    low: float
    high: float
    threshold: float
    growth: float


def parametric_tongue(omega_0: float, mu: float, depth: float) -> ParametricTongue:
    """Give the principal tongue of parametric resonance in closed form.

    Parameters
    ----------
    omega_0 : float
        Natural frequency at the mean stiffness [rad/s].
    mu : float
        Damping B/J [1/s], at least 0: 2 omega_0 times the damping ratio.
    depth : float
        Amplitude of the stiffness' variation relative to its mean, 0 to 1.

    Returns
    -------
    ParametricTongue
        One-harmonic balance: the edges are right to order depth^2 (omega_0 depth^2/32 or so).

    Raises
    ------
    ValueError
        If a number is out of range.
    """
    omega_0, mu, depth = number("omega_0", omega_0, positive=True), number("mu", mu), number("depth", depth)
    if not (mu >= 0.0 and 0.0 <= depth < 1.0):
        raise ValueError(f"mu is {mu:g} 1/s and depth {depth:g}; it takes mu >= 0 and 0 <= depth < 1")
    if not mu < omega_0:
        raise ValueError(f"mu is {mu:g} 1/s, at least omega_0 = {omega_0:g} rad/s; the forms hold for light damping")
    r = mu / omega_0
    square = 0.25 * depth * depth - r * r + 0.25 * r**4
    low = high = math.nan
    if square > 0.0:
        middle, half = 1.0 - 0.5 * r * r, math.sqrt(square)
        low, high = 2.0 * omega_0 * math.sqrt(middle - half), 2.0 * omega_0 * math.sqrt(middle + half)
    threshold = 2.0 * r * math.sqrt(1.0 - 0.25 * r * r)
    return ParametricTongue(low, high, threshold, 0.25 * depth * omega_0 - 0.5 * mu)
