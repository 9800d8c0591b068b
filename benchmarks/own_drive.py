"""Pointing error of a drive by its own equations of motion, with nothing of the package: two inertias and a loop.

With the motor's deviation p = theta_m - Omega t and the pointing error y = Omega t/N - theta_l the torsion is
u = p/N + y - e(theta_m), and T = K(u) + B u' in

    J_l y'' = -(T + T_l),    J_m p'' = T_m - (1/N - e'(theta_m)) T.

A cascade gives T_m = K_p (w + q/T_n), w = -p' - K_v p, q' = w; a position loop T_m = -K_p p - K_d p'; a motor that is
held has p = 0. Fixed steps of Runge and Kutta; every speed starts from the end of the one before, up and down.
"""

import math

import numpy as np
from numba import njit

HELD, CASCADE, POSITION = 0, 1, 2
SETTLE, TURNS, STEP = 7.0, 2, 0.06  # time constants, turns looked at, and steps relative to the fastest mode


@njit(cache=True)
def slopes(t, y, omega, J_m, J_l, N, B, law, orders, sizes, torque, kind, loop):
    """Rates of (p, p', y, y', q)."""
    K1, K2, K3, T1, T2 = law
    p, dp, x, dx, q = y[0], y[1], y[2], y[3], y[4]
    angle, e, de = omega * t + p, 0.0, 0.0
    for k, size in zip(orders, sizes):  # noqa: B905, as Numba has no strict
        e += size * math.cos(k * angle)
        de -= k * size * math.sin(k * angle)
    u, du = p / N + x - e, dp / N + dx - de * (omega + dp)
    first, second = T1 / K1, T1 / K1 + (T2 - T1) / K2
    a = abs(u)
    spring = K1 * min(a, first) + K2 * max(min(a, second) - first, 0.0) + K3 * max(a - second, 0.0)
    T = math.copysign(spring, u) + B * du
    if kind == 0:
        return 0.0, 0.0, dx, -(T + torque) / J_l, 0.0
    w = -dp - loop[0] * p
    T_m = loop[1] * (w + q / loop[2]) if kind == 1 else -loop[0] * p - loop[1] * dp
    return dp, (T_m - (1.0 / N - de) * T) / J_m, dx, -(T + torque) / J_l, w


@njit(cache=True)
def swept(speeds, time, dt, start, J_m, J_l, N, B, law, orders, sizes, torque, kind, loop):
    """Largest |y - mean| at each speed [rad], one after the other."""
    found, y, t = np.zeros(len(speeds)), start.copy(), 0.0
    args = (J_m, J_l, N, B, law, orders, sizes, torque, kind, loop)
    for i, omega in enumerate(speeds):
        turn = 2.0 * math.pi / omega
        steps = math.ceil(turn / dt)
        h = turn / steps
        before = math.ceil(time / turn) * steps
        low, high, total = np.inf, -np.inf, 0.0
        for n in range(before + TURNS * steps):
            a = np.array(slopes(t, y, omega, *args))
            b = np.array(slopes(t + 0.5 * h, y + 0.5 * h * a, omega, *args))
            c = np.array(slopes(t + 0.5 * h, y + 0.5 * h * b, omega, *args))
            d = np.array(slopes(t + h, y + h * c, omega, *args))
            y = y + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)
            t += h
            if n >= before:
                low, high, total = min(low, y[2]), max(high, y[2]), total + y[2]
        mean = total / (TURNS * steps)
        found[i], t = max(high - mean, mean - low), 0.0
    return found


def largest(J_m, J_l, N, B, law, lines, torque, speeds, kind, loop, points=70):
    """Largest oscillation [rad] over a range of motor speeds [rad/s] under a torque on the load [N*m]."""
    K1, K2, K3, T1, T2 = law
    w_l = math.sqrt(max(law[:3]) / J_l)
    fastest = math.sqrt(w_l**2 + max(law[:3]) / (N * N * J_m)) + (loop[1] / J_m if kind else 0.0)
    soft = math.sqrt(K1 / J_l)
    slow = max(speeds[0], 0.04 * soft)  # below it the error is that of slow rotation
    if slow >= speeds[1]:
        slow = 0.5 * speeds[1]
    w = np.geomspace(max(slow, speeds[0]), speeds[1], points)
    size = abs(torque)
    twist = min(size, T1) / K1 + max(min(size, T2) - T1, 0.0) / K2 + max(size - T2, 0.0) / K3
    start = np.array([0.0, 0.0, -math.copysign(twist, torque), 0.0, 0.0])
    if kind == CASCADE:
        start[4] = -torque / N * loop[2] / loop[1]
    elif kind == POSITION:
        start[0] = torque / N / loop[0]
        start[2] -= start[0] / N
    rate = 0.5 * B / J_l
    time, dt = SETTLE / rate, STEP / fastest * math.pi
    orders, sizes = np.array([k for k, _ in lines], float), np.array([a for _, a in lines], float)
    args = (start, J_m, J_l, float(N), B, tuple(map(float, law)), orders, sizes, float(torque), kind, tuple(loop))
    best = 0.0
    for way in (w, w[::-1]):
        found = swept(np.ascontiguousarray(way), time, dt, *args)
        top = way[int(np.argmax(found))]
        near = np.clip(top * np.linspace(0.97, 1.03, 25), speeds[0], speeds[1])
        best = max(best, found.max(), swept(near if way is w else near[::-1].copy(), time, dt, *args).max())
    return float(best)
