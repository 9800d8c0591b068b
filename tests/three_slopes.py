"""Torque of a gear with three slopes, by hand: for equations of our own that SciPy integrates."""

import math


def three_slopes(x, slopes):
    """Torque [N*m] at a torsion x [rad] on lines of slopes K1, K2, K3 [N*m/rad], which change at T1 and T2 [N*m]."""
    K1, K2, K3, T1, T2 = slopes
    way, x1 = abs(x), T1 / K1
    x2 = x1 + (T2 - T1) / K2
    return math.copysign(K1 * way if way < x1 else T1 + K2 * (way - x1) if way < x2 else T2 + K3 * (way - x2), x)
