"""The motion of a load behind a gear whose motor turns as it was measured: fourth-order steps, friction that sticks.

J ql'' = T(g) + B g' + Kb z - pull - (Fc + mu |T|) sign(ql') - Fv ql' - Fq ql' |ql'|, g = u - ql, u the angle of the
rigid gear. z is Bouc and Wen's memory. At rest the load stays until it is pushed beyond the friction. Where the load's
measured angle y is given, the motion is drawn to it with two gains: a rough model then follows a long log.
"""

from typing import Any

import numpy as np

from ....base.results import Floats
from ....compile.jit import borrowed, kernel

# places of the numbers p of the kernel
J, K1, K2, K3, T1, T2, B, KB, YIELD, FC, FV, MU, GAP, UNEVEN, DRAG = range(15)
EVENTS = 8  # starts and stops that one step may hold


@kernel
def between(a: float, b: float, c: float, s: float) -> float:
    """Value of the parabola through three values, at the begin, in the middle and at the end of a step, at s."""
    return a * (1.0 - s) * (1.0 - 2.0 * s) + 4.0 * b * s * (1.0 - s) + c * s * (2.0 * s - 1.0)


@kernel
def spring_torque(g: float, p: Floats) -> float:
    """Torque of three slopes, perhaps with a gap, and with other slopes to either side."""
    a = abs(g) - p[GAP]
    if a < 0.0 < p[GAP]:
        return 0.0
    x1 = p[T1] / p[K1]
    x2 = x1 + (p[T2] - p[T1]) / p[K2]
    t = p[K1] * a
    if a > x2:
        t = p[T2] + p[K3] * (a - x2)
    elif a > x1:
        t = p[T1] + p[K2] * (a - x1)
    return float(t * (1.0 + p[UNEVEN]) if g >= 0.0 else -t * (1.0 - p[UNEVEN]))


@kernel
def pushed(q: float, v: float, z: float, i: int, s: float, p: Floats, drive: Floats) -> Any:
    """Torque on the load without dry friction, its friction, and the rate of z, at the part s of the step i."""
    u = between(drive[0, i], drive[0, i + 1], drive[0, i + 2], s)
    du = between(drive[1, i], drive[1, i + 1], drive[1, i + 2], s)
    pull = between(drive[2, i], drive[2, i + 1], drive[2, i + 2], s)
    rate = du - v
    torque = spring_torque(u - q, p) + p[B] * rate + p[KB] * z
    zed = z / p[YIELD]
    memory = rate - 0.5 * (abs(zed) * rate + zed * abs(rate))
    return torque - pull - p[FV] * v - p[DRAG] * v * abs(v), p[FC] + p[MU] * abs(torque), memory


@kernel
def rates(
    q: float, v: float, z: float, sign: float, i: int, s: float, p: Floats, drive: Floats, gains: Floats
) -> Any:  # fmt: skip
    """Rates of angle, speed and memory."""
    torque, friction, memory = pushed(q, v, z, i, s, p, drive)
    if gains[0] == 0.0:
        return v, (torque - sign * friction) / p[J], memory
    ahead = between(drive[3, i], drive[3, i + 1], drive[3, i + 2], s) - q
    return v + gains[0] * ahead, (torque - sign * friction) / p[J] + gains[1] * ahead, memory


@kernel
def step(
    q: float, v: float, z: float, sign: float, i: int, s: float, part: float, h: float, p: Floats, drive: Floats,
    gains: Floats,
) -> Any:  # fmt: skip
    """One fourth-order step over a part of a step that begins at s; a load at rest (sign 0) stays."""
    t, m, e = part * h, s + 0.5 * part, s + part
    if sign == 0.0:
        c1 = pushed(q, 0.0, z, i, s, p, drive)[2]
        c2 = pushed(q, 0.0, z + 0.5 * t * c1, i, m, p, drive)[2]
        c3 = pushed(q, 0.0, z + 0.5 * t * c2, i, m, p, drive)[2]
        c4 = pushed(q, 0.0, z + t * c3, i, e, p, drive)[2]
        return q, 0.0, z + t / 6.0 * (c1 + 2.0 * (c2 + c3) + c4)
    a1, b1, c1 = rates(q, v, z, sign, i, s, p, drive, gains)
    a2, b2, c2 = rates(q + 0.5 * t * a1, v + 0.5 * t * b1, z + 0.5 * t * c1, sign, i, m, p, drive, gains)
    a3, b3, c3 = rates(q + 0.5 * t * a2, v + 0.5 * t * b2, z + 0.5 * t * c2, sign, i, m, p, drive, gains)
    a4, b4, c4 = rates(q + t * a3, v + t * b3, z + t * c3, sign, i, e, p, drive, gains)
    return (
        q + t / 6.0 * (a1 + 2.0 * (a2 + a3) + a4), v + t / 6.0 * (b1 + 2.0 * (b2 + b3) + b4),
        z + t / 6.0 * (c1 + 2.0 * (c2 + c3) + c4),
    )  # fmt: skip


@kernel
def loose(q: float, z: float, i: int, s: float, p: Floats, drive: Floats) -> float:
    """Direction in which a load at rest is pushed off: 0 where it sticks."""
    torque, friction, _ = pushed(q, 0.0, z, i, s, p, drive)
    return 0.0 if abs(torque) <= friction else float(np.sign(torque))


@kernel
def through(
    q: float, v: float, z: float, sign: float, i: int, h: float, p: Floats, drive: Floats, gains: Floats
) -> Any:  # fmt: skip
    """Angle, speed, memory and direction after a whole step, with its stops and starts."""
    s = 0.0
    for _ in range(EVENTS):
        q1, v1, z1 = step(q, v, z, sign, i, s, 1.0 - s, h, p, drive, gains)
        if sign == 0.0:
            after = loose(q1, z1, i, 1.0, p, drive)
            if after == 0.0:
                return q1, v1, z1, sign
            push, friction, _ = pushed(q, 0.0, z, i, s, p, drive)
            push1, friction1, _ = pushed(q1, 0.0, z1, i, 1.0, p, drive)
            before, beyond = after * push - friction, after * push1 - friction1
            part = (1.0 - s) * min(max(before / (before - beyond), 0.0), 1.0) if before < 0.0 else 0.0
            q, v, z = step(q, v, z, sign, i, s, part, h, p, drive, gains)
            sign, s = after, s + part
        elif v1 * sign >= 0.0 or v * sign < 0.0:
            return q1, v1, z1, (sign if v1 * sign >= 0.0 else -sign)
        else:
            part = (1.0 - s) * min(max(v / (v - v1), 0.0), 1.0)
            q, v, z = step(q, v, z, sign, i, s, part, h, p, drive, gains)
            v, s = 0.0, s + part
            sign = loose(q, z, i, min(s, 1.0), p, drive)
        if s >= 1.0 - 1e-9:
            return q, v, z, sign
    q1, v1, z1 = step(q, v, z, sign, i, s, 1.0 - s, h, p, drive, gains)
    return q1, v1, z1, np.sign(v1)


@kernel
def march(
    p: Floats, drive: Floats, h: float, start: Floats, gains: Floats, places: Floats, states: Floats, read: Floats
) -> None:  # fmt: skip
    """March over a grid of steps h [s]; `drive` (4, 2 n + 1) has u, u', pull and y at its half steps.

    `start` is (angle, speed, memory); `states` (n + 1, 3) gets angle, speed and the gear's torque, `read` the angle at
    `places` [steps].
    """
    p, drive, start, gains, places, states, read = borrowed((p, drive, start, gains, places, states, read))
    n = states.shape[0] - 1
    q, v, z, sign = start[0], start[1], start[2], np.sign(start[1])
    if sign == 0.0:
        sign = loose(q, z, 0, 0.0, p, drive)
    for k in range(n + 1):
        twist, rate = drive[0, 2 * k] - q, drive[1, 2 * k] - v
        states[k, 0], states[k, 1], states[k, 2] = q, v, spring_torque(twist, p) + p[B] * rate + p[KB] * z
        if k < n:
            q, v, z, sign = through(q, v, z, sign, 2 * k, h, p, drive, gains)
    for j in range(places.shape[0]):
        k = min(max(int(places[j]), 0), n - 1)
        s = places[j] - k
        a, b, c, d = states[k, 0], h * states[k, 1], states[k + 1, 0], h * states[k + 1, 1]
        rise = c - a
        read[j] = a + s * (b + s * (3.0 * rise - 2.0 * b - d + s * (b + d - 2.0 * rise)))
