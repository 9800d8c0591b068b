"""Records of a motor with a gear in its sampled speed loop, by matrix exponentials and equations of their own."""

import numpy as np
from scipy.linalg import expm

N, H, LATE = 100.0, 5e-4, 1  # ratio, samples [s], whole samples that the torque comes late
TRUE = {"J_m": 4.5e-4, "J_l": 5.0, "K": 6e4, "B": 30.0, "delay": H * LATE}
BANDWIDTH = 2.0 * np.pi * 25.0


def steps(h=H):
    """Matrices of one step: states speed of motor and load and their twist, inputs torque of motor and load."""
    J_m, J_l, K, B, _ = TRUE.values()
    A = np.zeros((5, 5))
    A[0] = -B / N**2 / J_m, B / N / J_m, -K / N / J_m, 1.0 / J_m, 0.0
    A[1] = B / N / J_l, -B / J_l, K / J_l, 0.0, 1.0 / J_l
    A[2] = 1.0 / N, -1.0, 0.0, 0.0, 0.0
    whole = expm(A * h)
    return whole[:3, :3], whole[:3, 3:]


def records(seeds, *, noise=0.6, load=20.0, periods=9, period=1.0, size=3.0):
    """Time (n,), reference (n,), torque and speed (n, seeds) of swept sines from 3 to 300 Hz, one period after another.

    `noise` is that of the measured speed [rad/s], `load` of a torque on the load [N*m], white each, from sample to
    sample; the controller is a PI of the speed.
    """
    n = round(period / H)
    t = H * np.arange(n)
    growth = np.log(100.0) / period
    reference = np.tile(size * np.sin(2.0 * np.pi * 3.0 * np.expm1(growth * t) / growth), periods)
    chance = [np.random.default_rng(seed) for seed in seeds]
    v = noise * np.array([rng.normal(size=n * periods) for rng in chance]).T
    d = load * np.array([rng.normal(size=n * periods) for rng in chance]).T
    A, b = steps()
    K_p = (TRUE["J_m"] + TRUE["J_l"] / N**2) * BANDWIDTH
    x, integral = np.zeros((3, len(chance))), np.zeros(len(chance))
    torque, speed, late = np.empty_like(v), np.empty_like(v), [np.zeros(len(chance))] * LATE
    for k in range(n * periods):
        speed[k] = x[0] + v[k]
        off = reference[k] - speed[k]
        integral = integral + H * BANDWIDTH / 4.0 * off
        torque[k] = K_p * (off + integral)
        late.append(torque[k])
        x = A @ x + np.outer(b[:, 0], late.pop(0)) + np.outer(b[:, 1], d[k])
    return H * np.arange(n * periods), reference, torque, speed


def plant(omega):
    """Motor speed over motor torque (n,) at frequencies [rad/s], with the delay, by impedances; a continuous torque."""
    J_m, J_l, K, B, delay = TRUE.values()
    s = 1j * np.asarray(omega)
    gear = (B + K / s) / N**2
    load = J_l / N**2 * s
    return np.exp(-s * delay) / (J_m * s + gear * load / (gear + load))
