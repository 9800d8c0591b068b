"""Loops of torque over torsion from equations of our own: SciPy integrates Bouc-Wen along a path in time."""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.signal import lfilter

SLOPES = (31000.0, 50000.0, 57000.0, 14.0, 48.0)  # K1, K2, K3 [N*m/rad], T1, T2 [N*m] of SHG-25-100
ELEMENT = (45000.0, 8e-5)  # K [N*m/rad], yield twist [rad]
REACH = 2.2e-3  # rad


def spring(x, slopes=SLOPES, gap=0.0):
    """Torque of three straight lines behind a gap."""
    K1, K2, K3, T1, T2 = slopes
    way = np.maximum(np.abs(x) - gap, 0.0)
    x1 = T1 / K1
    x2 = x1 + (T2 - T1) / K2
    first, second, third = np.minimum(way, x1), np.clip(way - x1, 0.0, x2 - x1), np.maximum(way - x2, 0.0)
    return np.sign(x) * (K1 * first + K2 * second + K3 * third)


def loop(
    samples=600, cycles=(1.0, 1.0, 0.5), reach=REACH, slopes=SLOPES, gap=0.0, element=ELEMENT, beta=0.5, gamma=0.5,
    n=1, start=0.0,
):  # fmt: skip
    """Torsion and torque of sine cycles of the given shares; z' = v - |z/y|^n (beta |v| sign z + gamma v)."""
    t = np.linspace(0.0, len(cycles), samples)
    share = np.asarray(cycles)[np.minimum(t.astype(int), len(cycles) - 1)]
    x = share * reach * np.sin(2.0 * np.pi * t)
    K, y = element

    def rate(time, z):
        v = cycles[min(int(time), len(cycles) - 1)] * reach * 2.0 * np.pi * np.cos(2.0 * np.pi * time)
        return v - np.abs(z / y) ** n * (beta * np.abs(v) * np.sign(z) + gamma * v)

    run = solve_ivp(rate, (0.0, t[-1]), [start], t_eval=t, rtol=1e-9, atol=1e-15, max_step=0.01)
    return x, spring(x, slopes, gap) + K * run.y[0]


def coloured(rng, samples, deviation, phi):
    """First-order autoregression in its steady state."""
    fresh = deviation * np.sqrt(1.0 - phi**2) * rng.normal(size=samples)
    return lfilter([1.0], [1.0, -phi], fresh, zi=[phi * deviation * rng.normal()])[0]
