"""A motor with its position loop, a gear of three slopes, and a load: equations by hand, integrated by SciPy."""

import math
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

ARCSEC = math.pi / 648_000.0
SAMPLES = 400  # of a turn of the motor


class TwoInertias(NamedTuple):
    """Inertias [kg*m^2], ratio, slopes [N*m/rad] and their ends [N*m], damping B, lines (order, arcsec), loop [Hz]."""

    J_m: float
    J_l: float
    N: float
    K: tuple[float, float, float]
    T: tuple[float, float]
    B: float
    lines: tuple[tuple[int, float], ...]
    bandwidth: float
    loop_damping: float = 0.7
    tuned: float | None = None  # load that the loop is for, where it is another one

    def oscillation(self, rpm, torque_at, settle, turns):
        """Largest distance [arcsec] of the pointing error from its mean over a turn, after so many turns of the motor.

        `torque_at` gives the torque [N*m] on the load from the angle [rad] that it has turned. The unknowns are the
        deviations from constant speed, d = theta_m - omega t of the motor and q = theta_l - omega t/N of the load.
        """
        omega, J, loop = (
            rpm * math.pi / 30.0,
            self.J_m + (self.tuned or self.J_l) / self.N**2,
            2.0 * math.pi * self.bandwidth,
        )
        K_p, K_d = J * loop**2, 2.0 * self.loop_damping * J * loop
        (K1, K2, K3), (T1, T2) = self.K, self.T
        u1 = T1 / K1
        u2 = u1 + (T2 - T1) / K2

        def spring(u):
            x = abs(u)
            return math.copysign(K1 * x if x < u1 else T1 + K2 * (x - u1) if x < u2 else T2 + K3 * (x - u2), u)

        def rates(t, y):
            d, d_rate, q, q_rate = y
            theta = omega * t + d
            error = sum(a * ARCSEC * math.cos(k * theta) for k, a in self.lines)
            slope = -sum(k * a * ARCSEC * math.sin(k * theta) for k, a in self.lines)
            u_rate = d_rate / self.N - q_rate - slope * (omega + d_rate)
            torque = spring(d / self.N - q - error) + self.B * u_rate
            motor = -K_p * d - K_d * d_rate - (1.0 / self.N - slope) * torque
            return d_rate, motor / self.J_m, q_rate, (torque + torque_at(omega * t / self.N + q)) / self.J_l

        held = -torque_at(0.0)  # starts at rest under that torque, but for the vibration
        twist = math.copysign(np.interp(abs(held), (0.0, T1, T2, T2 + K3), (0.0, u1, u2, u2 + 1.0)), held)
        d = -held / self.N / K_p
        times = 2.0 * math.pi / omega * np.arange(SAMPLES * turns + 1) / SAMPLES
        start = (d, 0.0, d / self.N - twist, 0.0)
        error = -solve_ivp(rates, (0.0, times[-1]), start, "DOP853", times, rtol=1e-9, atol=1e-13).y[2]
        mean = np.convolve(error, np.full(SAMPLES, 1.0 / SAMPLES), "valid")
        middle = error[SAMPLES // 2 :][: len(mean)]
        return float(np.max(np.abs(middle - mean)[settle * SAMPLES :])) / ARCSEC
