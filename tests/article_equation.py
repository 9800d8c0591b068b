"""The article's error equation, integrated here: its motion on the branch that the linear motion leads to."""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

J_M, J_L, N, B, K, ALPHA, T_M = 5.26e-4, 0.05, 50.0, 0.017, 7160.0, 0.1, 10.0
TORQUE = J_L * N / (N**2 * J_M + J_L) * T_M  # on the equation [N*m]


def shot(omega, load=1.0, stiffness=1.0):
    """Largest |x| [rad] at omega [rad/s] by shooting, with the load's inertia and the stiffness so many times."""
    J_l, K_1, turn = load * J_L, stiffness * K, 2.0 * np.pi / omega
    J = N**2 * J_M * J_l / (N**2 * J_M + J_l)

    def rates(t, y):
        return y[1], T_M / (N * J_M) * np.cos(omega * t) - (B * y[1] + K_1 * (y[0] + ALPHA * y[0] ** 3)) / J

    def run(y):
        return solve_ivp(rates, (0.0, turn), y, "DOP853", rtol=1e-10, atol=1e-12, dense_output=True)

    z = T_M / (N * J_M) / (K_1 / J - omega**2 + 1j * omega * B / J)
    start = fsolve(lambda y: run(y).y[:, -1] - y, (z.real, -omega * z.imag), xtol=1e-10)
    return np.max(np.abs(run(start).sol(np.linspace(0.0, turn, 2001))[0]))
