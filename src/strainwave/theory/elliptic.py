"""Jacobi's elliptic function cn with any parameter m < 1, the modulus squared, and its Fourier series.

A negative m is brought to 0 .. 1 by cn(z | m) = cd(z sqrt(1 - m) | -m/(1 - m)) (DLMF 22.17.6).
"""

import math

import numpy as np
from scipy.special import ellipj, ellipk, ellipkm1

from ..results import Floats


def cn_and_fall(z: Floats, m: float) -> tuple[Floats, Floats]:
    """cn(z | m) and -d cn/dz."""
    if m > 0.0:
        sn, cn, dn, _ = ellipj(z, m)
        return cn, sn * dn
    stretch = math.sqrt(1.0 - m)
    sn, cn, dn, _ = ellipj(z * stretch, -m / (1.0 - m))
    return cn / dn, sn / (stretch * dn * dn)


def nome(m: float) -> float:
    """Nome q = exp(-pi K(1 - m)/K(m)), negative where m is: q(m) = -q(-m/(1 - m)) (DLMF 22.2.1, 20.7.26)."""
    if m < 0.0:
        return -nome(-m / (1.0 - m))
    return math.exp(-math.pi * float(ellipkm1(m) / ellipk(m)))


def cn_lines(m: float, count: int) -> Floats:
    """Amplitudes (count,) of cos x, cos 3x, cos 5x ... in cn(2 K x/pi | m) (DLMF 22.11.2; 22.11.4 for m < 0)."""
    if m == 0.0:
        return np.asarray(np.eye(1, count)[0])
    q, n = nome(m), np.arange(count)
    return np.asarray(2.0 * math.pi / ellipk(m) * math.sqrt(q / m) * q**n / (1.0 + q ** (2 * n + 1)))
