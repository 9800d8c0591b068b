"""One step of each integration method, on tuple states; used by `integrate` and by the ensembles.

They take the phase at the start and its growth, which all lanes of an ensemble share in steps of fixed size, the state,
and the step in time.
"""

from typing import Any

from ...compile.jit import kernel, routine
from ...compile.tuples import axpy, times
from .tableaus import DOP8_A as A
from .tableaus import DOP8_B as B
from .tableaus import DOP8_C as C


@kernel
def rk4_step(system: Any, phase: Any, turn: Any, y: Any, h: Any) -> Any:
    """Classical fourth-order Runge-Kutta step of h in time, `turn` in phase."""
    middle = phase + 0.5 * turn
    k1 = system.rhs(phase, y)
    k2 = system.rhs(middle, axpy(y, 0.5 * h, k1))
    k3 = system.rhs(middle, axpy(y, 0.5 * h, k2))
    k4 = system.rhs(phase + turn, axpy(y, h, k3))
    return axpy(axpy(axpy(axpy(y, h / 6.0, k1), h / 3.0, k2), h / 3.0, k3), h / 6.0, k4)


@kernel
def dop8_step(system: Any, phase: Any, turn: Any, y: Any, h: Any) -> Any:
    """Eighth-order step with the twelve stages of DOP853 (zero weights left out); rates are multiplied by h once."""
    k0 = times(h, system.rhs(phase, y))
    y1 = axpy(y, A[1][0], k0)
    k1 = times(h, system.rhs(phase + turn * C[1], y1))
    y2 = axpy(axpy(y, A[2][0], k0), A[2][1], k1)
    k2 = times(h, system.rhs(phase + turn * C[2], y2))
    y3 = axpy(axpy(y, A[3][0], k0), A[3][2], k2)
    k3 = times(h, system.rhs(phase + turn * C[3], y3))
    y4 = axpy(axpy(axpy(y, A[4][0], k0), A[4][2], k2), A[4][3], k3)
    k4 = times(h, system.rhs(phase + turn * C[4], y4))
    y5 = axpy(axpy(axpy(y, A[5][0], k0), A[5][3], k3), A[5][4], k4)
    k5 = times(h, system.rhs(phase + turn * C[5], y5))
    y6 = axpy(axpy(axpy(axpy(y, A[6][0], k0), A[6][3], k3), A[6][4], k4), A[6][5], k5)
    k6 = times(h, system.rhs(phase + turn * C[6], y6))
    y7 = axpy(axpy(axpy(axpy(y, A[7][0], k0), A[7][3], k3), A[7][4], k4), A[7][5], k5)
    k7 = times(h, system.rhs(phase + turn * C[7], axpy(y7, A[7][6], k6)))
    y8 = axpy(axpy(axpy(axpy(y, A[8][0], k0), A[8][3], k3), A[8][4], k4), A[8][5], k5)
    k8 = times(h, system.rhs(phase + turn * C[8], axpy(axpy(y8, A[8][6], k6), A[8][7], k7)))
    y9 = axpy(axpy(axpy(axpy(y, A[9][0], k0), A[9][3], k3), A[9][4], k4), A[9][5], k5)
    y9 = axpy(axpy(axpy(y9, A[9][6], k6), A[9][7], k7), A[9][8], k8)
    k9 = times(h, system.rhs(phase + turn * C[9], y9))
    y10 = axpy(axpy(axpy(axpy(y, A[10][0], k0), A[10][3], k3), A[10][4], k4), A[10][5], k5)
    y10 = axpy(axpy(axpy(axpy(y10, A[10][6], k6), A[10][7], k7), A[10][8], k8), A[10][9], k9)
    k10 = times(h, system.rhs(phase + turn * C[10], y10))
    y11 = axpy(axpy(axpy(axpy(y, A[11][0], k0), A[11][3], k3), A[11][4], k4), A[11][5], k5)
    y11 = axpy(axpy(axpy(axpy(y11, A[11][6], k6), A[11][7], k7), A[11][8], k8), A[11][9], k9)
    k11 = times(h, system.rhs(phase + turn, axpy(y11, A[11][10], k10)))
    out = axpy(axpy(axpy(axpy(y, B[0], k0), B[5], k5), B[6], k6), B[7], k7)
    return axpy(axpy(axpy(axpy(out, B[8], k8), B[9], k9), B[10], k10), B[11], k11)


@kernel
def dopri5_step(system: Any, phase: Any, turn: Any, y: Any, h: Any, rate: Any) -> Any:
    """Dormand-Prince step from y with rate = rhs(y): the new state, its rate, the error, and the dense-output vector.

    Hairer, Norsett & Wanner I, table II.5.2 and eq. (II.6.17), with the rates multiplied by h once.
    """
    k1 = times(h, rate)
    k2 = times(h, system.rhs(phase + turn * (1 / 5), axpy(y, 1 / 5, k1)))
    k3 = times(h, system.rhs(phase + turn * (3 / 10), axpy(axpy(y, 3 / 40, k1), 9 / 40, k2)))
    y4 = axpy(axpy(axpy(y, 44 / 45, k1), -56 / 15, k2), 32 / 9, k3)
    k4 = times(h, system.rhs(phase + turn * (4 / 5), y4))
    y5 = axpy(axpy(axpy(y, 19372 / 6561, k1), -25360 / 2187, k2), 64448 / 6561, k3)
    k5 = times(h, system.rhs(phase + turn * (8 / 9), axpy(y5, -212 / 729, k4)))
    y6 = axpy(axpy(axpy(y, 9017 / 3168, k1), -355 / 33, k2), 46732 / 5247, k3)
    k6 = times(h, system.rhs(phase + turn, axpy(axpy(y6, 49 / 176, k4), -5103 / 18656, k5)))
    y7 = axpy(axpy(axpy(y, 35 / 384, k1), 500 / 1113, k3), 125 / 192, k4)
    y7 = axpy(axpy(y7, -2187 / 6784, k5), 11 / 84, k6)
    new_rate = system.rhs(phase + turn, y7)
    k7 = times(h, new_rate)
    error = axpy(axpy(times(71 / 57600, k1), -71 / 16695, k3), 71 / 1920, k4)
    error = axpy(axpy(axpy(error, -17253 / 339200, k5), 22 / 525, k6), -1 / 40, k7)
    dense = axpy(times(-12715105075 / 11282082432, k1), 87487479700 / 32700410799, k3)
    dense = axpy(axpy(dense, -10690763975 / 1880347072, k4), 701980252875 / 199316789632, k5)
    dense = axpy(axpy(dense, -1453857185 / 822651844, k6), 69997945 / 29380423, k7)
    return y7, new_rate, error, dense


@kernel
def dense_weights(s: Any, h: float) -> Any:
    """Weights for `weighted` that give the state at the fraction s of a step of h.

    It is of fourth order for the step of Dormand & Prince (Hairer, Norsett & Wanner I, eq. II.6.17).
    """
    r = 1.0 - s
    return r * r * (1.0 + 2.0 * s), h * s * r * r, s * s * (1.0 + 2.0 * r), -h * s * s * r, s * s * r * r


@kernel
def slope_weights(s: float, h: float) -> Any:
    """Derivatives of `dense_weights` by s."""
    r = 1.0 - s
    return -6.0 * s * r, h * r * (1.0 - 3.0 * s), 6.0 * s * r, h * s * (3.0 * s - 2.0), 2.0 * s * r * (r - s)


@kernel
def weighted(a: Any, y: Any, k: Any, y_end: Any, k_end: Any, dense: Any) -> Any:
    """Weighted sum of state and rate at the begin of a step, those at its end, and the vector of the dense output."""
    return a[0] * y + a[1] * k + a[2] * y_end + a[3] * k_end + a[4] * dense


@routine
def error_square(n: int, error: Any, y: Any, y_end: Any, rtol: float, atol: float) -> float:
    """Mean square of n errors in units of the tolerance (Hairer, Norsett & Wanner I, eq. II.4.11).

    Where a step waits for it, the root costs 4 % of the step.
    """
    total = 0.0
    for i in range(n):
        scaled = error[i] / (atol + rtol * max(abs(y[i]), abs(y_end[i])))
        total += scaled * scaled
    return total / n


@kernel
def bounded(y: Any, bound: float) -> bool:
    """Whether every state is below the bound (False for NaN)."""
    good = True
    for i in range(len(y)):
        good = good and abs(y[i]) < bound
    return good
