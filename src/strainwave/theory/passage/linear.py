"""Passage of a linear drive at a constant rate, exactly.

Under f E, E = exp(i phi) with phi' = Omega and Omega' constant, the motion is a convolution with the two free
vibrations exp(lambda t) of the drive, an integral of exp(b s + i Omega' s^2/2) over the time s gone by: Fresnel's
integrals, here by the Faddeeva function w, which holds the damping too (Lewis 1932, Vibration during acceleration
through a critical speed, Trans. ASME 54, 253-261; Abramowitz & Stegun 1964, eqs. 7.1.3 and 7.4.2).
"""

import cmath
import math
from typing import Any

import numpy as np
from scipy.special import wofz

from ...results import Floats
from ..slow_flow.setting import Complexes, Setting


def linear_passage(s: Setting, rate: float, t: Floats) -> Complexes:
    """Slow state z [rad] at times t [s] of a run from the steady state at s.omega with a rate [rad/s^2] of omega.

    Parameters
    ----------
    s : Setting
        Linear drive at its first speed, with a soft line.
    rate : float
        Change of the base speed [rad/s^2], of either sign, not 0.
    t : (n,) array
        Times [s] from 0 on.
    """
    ratio = s.fast / s.omega
    root = cmath.sqrt(0.25 * s.mu**2 - s.omega_0**2)
    roots = -0.5 * s.mu + root, -0.5 * s.mu - root
    first, second = (_convolved(lam, s.fast, ratio * rate, t) for lam in roots)
    x = (first - second) / (2.0 * root)
    slope = (roots[0] * first - roots[1] * second) / (2.0 * root)
    on_torque = np.sum(s.torque_lines[s.on_fast]) / s.system.J
    on_error = np.sum(s.error_lines[s.on_fast])
    return np.asarray(on_torque * x - on_error * (1.0 - s.mu * slope - s.omega_0**2 * x))


def _convolved(lam: complex, fast: float, rate: float, t: Floats) -> Any:
    """exp(lam t) convolved with E, over E: from the steady state at time 0."""
    now = lam - 1j * (fast + rate * t)
    then = lam - 1j * fast
    s = math.sqrt(0.5 * abs(rate)) * cmath.exp(-0.25j * math.pi * math.copysign(1.0, rate))
    scale = math.sqrt(math.pi) / (2.0 * s)
    kept = np.exp(lam * t - 1j * (fast * t + 0.5 * rate * t * t))
    return scale * (wofz(-0.5j * now / s) - kept * wofz(-0.5j * then / s)) - kept / then
