"""Steps of y' = A(t) y by Gauss's collocation at four places, of order 8, as kernel and in NumPy.

Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I, 2nd ed., sec. II.7 (collocation).
"""

import math
from typing import Any

import numpy as np

from ...base.results import Floats
from ...compile.jit import routine
from ..integration.implicit import solve_in_place

_PLACES, _WEIGHTS = np.polynomial.legendre.leggauss(4)
GAUSS_PLACES, GAUSS_WEIGHTS = 0.5 + 0.5 * _PLACES, 0.5 * _WEIGHTS  # shares of a step
_POWERS = np.arange(1, 5)  # collocation: the rows integrate powers of the place exactly
GAUSS_MATRIX = GAUSS_PLACES[:, None] ** _POWERS / _POWERS @ np.linalg.inv(GAUSS_PLACES[:, None] ** (_POWERS - 1))
MATRIX, WEIGHTS = tuple(map(tuple, GAUSS_MATRIX.tolist())), tuple(GAUSS_WEIGHTS.tolist())  # for compiled code


@routine
def gauss_step(a: Floats, h: float, hill: bool, m: Floats, step: Floats, flow: Floats) -> Any:
    """Carry a flow (n, n) over a step of length h with the matrices a (4, n, n) at its places.

    With `hill` A is taken without its share of the trace, and the flow is scaled. Returns the logarithm of the scale
    and the integral of that share; m (4n, 5n) and step (2, n, n) are buffers.
    """
    n, decay, largest = a.shape[1], 0.0, 0.0
    for i in range(4):
        mean = 0.0
        if hill:
            for k in range(n):
                mean += a[i, k, k] / n
            decay += h * WEIGHTS[i] * mean
        for k in range(n):
            for q in range(4 * n, 5 * n):
                m[i * n + k, q] = a[i, k, q - 4 * n]
            m[i * n + k, 4 * n + k] -= mean
            for j in range(4):
                factor = -h * MATRIX[i][j]
                for q in range(n):
                    m[i * n + k, j * n + q] = factor * m[i * n + k, 4 * n + q]
            m[i * n + k, i * n + k] += 1.0
    solve_in_place(m)
    for k in range(n):
        for q in range(n):
            step[0, k, q] = 1.0 if k == q else 0.0
            for i in range(4):
                step[0, k, q] += h * WEIGHTS[i] * m[i * n + k, 4 * n + q]
    for k in range(n):
        for q in range(n):
            total = 0.0
            for j in range(n):
                total += step[0, k, j] * flow[j, q]
            step[1, k, q] = total
            largest = max(largest, abs(total))
    scale = 1.0 / largest if hill else 1.0
    for k in range(n):
        for q in range(n):
            flow[k, q] = scale * step[1, k, q]
    return (math.log(largest) if hill else 0.0), decay


def gauss_steps(a: Floats, h: Floats, hill: bool, flow: Floats) -> tuple[float, float]:
    """Carry a flow (n, n) over steps of lengths h (steps,) [s] with matrices a (steps, 4, n, n), as `gauss_step`."""
    n, rows, size, decay = len(flow), 4 * len(flow), 0.0, 0.0
    a = a * h[:, None, None, None]
    if hill:
        mean = np.trace(a, axis1=2, axis2=3) / n
        decay = float(np.sum(mean @ GAUSS_WEIGHTS))
        a = a - mean[..., None, None] * np.eye(n)
    coupled = np.einsum("ij,mikl->mikjl", GAUSS_MATRIX, a).reshape(-1, rows, rows)
    rates = np.linalg.solve(np.eye(rows) - coupled, a.reshape(-1, rows, n)).reshape(a.shape)
    for step in np.eye(n) + np.einsum("i,mikl->mkl", GAUSS_WEIGHTS, rates):
        flow[:] = step @ flow
        if hill:
            largest = float(np.max(np.abs(flow)))
            flow /= largest
            size += math.log(largest)
    return size, decay
