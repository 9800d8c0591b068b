"""Period map of y' = A(t) y from the matrices A at the places of Gauss's method of order 8, step by step.

Its places lie inside a step: at the ends A may jump. A step of length h maps y to (1 + h sum b_i K_i) y, where the
stages solve K_i = A_i (1 + h sum_j a_ij K_j).

Hairer & Wanner 1996, Solving Ordinary Differential Equations II, sec. IV.5.
"""

import math
from typing import Any

import numpy as np

from ...compile.jit import borrowed, kernel_as, routine, run
from ...results import Floats

_PLACES, _WEIGHTS = np.polynomial.legendre.leggauss(4)
GAUSS_C, GAUSS_B = 0.5 + 0.5 * _PLACES, 0.5 * _WEIGHTS
FEW = 8  # runs in NumPy, which take a tenth of a second, before they are compiled
_POWERS = np.arange(1, 5)  # collocation: the rows integrate powers of the place exactly
GAUSS_A = GAUSS_C[:, None] ** _POWERS / _POWERS @ np.linalg.inv(GAUSS_C[:, None] ** (_POWERS - 1))
A, B = tuple(map(tuple, GAUSS_A.tolist())), tuple(GAUSS_B.tolist())


@routine
def eliminated(m: Any) -> None:
    """Solve in place: the left square of m, a system of equations, leaves in the columns behind it their solutions."""
    rows, columns = m.shape
    for k in range(rows):
        p = k
        for i in range(k + 1, rows):
            if abs(m[i, k]) > abs(m[p, k]):
                p = i
        if p != k:
            for j in range(k, columns):
                m[k, j], m[p, j] = m[p, j], m[k, j]
        inverse = 1.0 / m[k, k]
        for i in range(k + 1, rows):
            factor = m[i, k] * inverse
            if factor != 0.0:
                for j in range(k + 1, columns):
                    m[i, j] -= factor * m[k, j]
    for k in range(rows - 1, -1, -1):
        inverse = 1.0 / m[k, k]
        for j in range(rows, columns):
            m[k, j] *= inverse
        for i in range(k):
            factor = m[i, k]
            if factor != 0.0:
                for j in range(rows, columns):
                    m[i, j] -= factor * m[k, j]


def _walked_loops(a: Any, h: Any, hill: bool, flow: Any) -> Any:
    a, h, flow = borrowed(a), borrowed(h), borrowed(flow)
    n = a.shape[2]
    m, step, new = np.empty((4 * n, 5 * n)), np.empty((n, n)), np.empty((n, n))
    size, decay = 0.0, 0.0
    for s in range(a.shape[0]):
        for i in range(4):
            mean = 0.0
            if hill:
                for k in range(n):
                    mean += a[s, i, k, k] / n
                decay += h[s] * B[i] * mean
            for k in range(n):
                for q in range(4 * n, 5 * n):
                    m[i * n + k, q] = a[s, i, k, q - 4 * n]
                m[i * n + k, 4 * n + k] -= mean
                for j in range(4):
                    factor = -h[s] * A[i][j]
                    for q in range(n):
                        m[i * n + k, j * n + q] = factor * m[i * n + k, 4 * n + q]
                m[i * n + k, i * n + k] += 1.0
        eliminated(m)
        for k in range(n):
            for q in range(n):
                step[k, q] = 1.0 if k == q else 0.0
                for i in range(4):
                    step[k, q] += h[s] * B[i] * m[i * n + k, 4 * n + q]
        largest = 0.0
        for k in range(n):
            for q in range(n):
                total = 0.0
                for j in range(n):
                    total += step[k, j] * flow[j, q]
                new[k, q] = total
                largest = max(largest, abs(total))
        scale = 1.0 / largest if hill else 1.0
        for k in range(n):
            for q in range(n):
                flow[k, q] = scale * new[k, q]
        if hill:
            size += math.log(largest)
    return size, decay


@kernel_as(_walked_loops)
def _walked(a: Floats, h: Floats, hill: bool, flow: Floats) -> tuple[float, float]:
    n, rows, size, decay = len(flow), 4 * len(flow), 0.0, 0.0
    a = a * h[:, None, None, None]
    if hill:
        mean = np.trace(a, axis1=2, axis2=3) / n
        decay = float(np.sum(mean @ GAUSS_B))
        a = a - mean[..., None, None] * np.eye(n)
    coupled = np.einsum("ij,mikl->mikjl", GAUSS_A, a).reshape(-1, rows, rows)
    rates = np.linalg.solve(np.eye(rows) - coupled, a.reshape(-1, rows, n)).reshape(a.shape)
    for step in np.eye(n) + np.einsum("i,mikl->mkl", GAUSS_B, rates):
        flow[:] = step @ flow
        if hill:
            largest = float(np.max(np.abs(flow)))
            flow /= largest
            size += math.log(largest)
    return size, decay


def walked(a: Floats, h: Floats, hill: bool = False) -> tuple[Floats, float, float]:
    """Period map M of steps of the lengths h (steps,) [s] with matrices a (steps, 4, n, n), and two numbers s and d.

    With `hill` A is taken without its share of the trace, whose integral is d, and the map of that is exp(s) M.
    """
    flow = np.eye(a.shape[-1])
    return flow, *run(_walked, a, h, hill, flow, light=True, after=FEW)
