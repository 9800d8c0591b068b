"""Small dense linear algebra for the solvers: one line of NumPy as Python, loops as machine code.

The loops beat LAPACK below about 60 unknowns, where the time of a call dominates.
"""

from typing import Any

import numpy as np

from .._jit import kernel_as


def _copy_loops(source: Any, out: Any) -> None:
    for i in range(out.shape[0]):
        out[i] = source[i]


@kernel_as(_copy_loops)
def copy(source: Any, out: Any) -> None:
    """Write as many entries of source as out has."""
    out[:] = source[: len(out)]


def _fill_loops(value: float, out: Any) -> None:
    for i in range(out.shape[0]):
        out[i] = value


@kernel_as(_fill_loops)
def fill(value: float, out: Any) -> None:
    """Set every entry of out."""
    out[:] = value


def _add_loops(factor: float, v: Any, out: Any) -> None:
    for i in range(out.shape[0]):
        out[i] += factor * v[i]


@kernel_as(_add_loops)
def add(factor: float, v: Any, out: Any) -> None:
    """Add factor times v to out."""
    out += factor * v


def _dot_loops(a: Any, b: Any) -> float:
    total = 0.0
    for i in range(a.shape[0]):
        total += a[i] * b[i]
    return total


@kernel_as(_dot_loops)
def dot(a: Any, b: Any) -> float:
    """Scalar product of two vectors of equal length."""
    return float(a @ b)


def _weighted_norm_loops(v: Any, weights: Any) -> float:
    total = 0.0
    for i in range(v.shape[0]):
        total += (v[i] * weights[i]) ** 2
    return float(total**0.5)


@kernel_as(_weighted_norm_loops)
def weighted_norm(v: Any, weights: Any) -> float:
    """Euclidean norm of v times weights, entry by entry."""
    return float(np.linalg.norm(v * weights))


def _row_times_loops(row: Any, table: Any, out: Any) -> None:
    for j in range(table.shape[1]):
        out[j] = 0.0
    for i in range(table.shape[0]):
        factor = row[i]
        for j in range(table.shape[1]):
            out[j] += factor * table[i, j]


@kernel_as(_row_times_loops)
def row_times(row: Any, table: Any, out: Any) -> None:
    """Write row @ table to out; the row may be longer than the table has rows."""
    np.dot(row[: len(table)], table, out=out)


def _factor_loops(a: Any, pivots: Any) -> None:
    n = a.shape[0]
    for k in range(n):
        p = k
        largest = abs(a[k, k])
        for i in range(k + 1, n):
            if abs(a[i, k]) > largest:
                largest = abs(a[i, k])
                p = i
        pivots[k] = p
        if p != k:
            for j in range(n):
                swap = a[k, j]
                a[k, j] = a[p, j]
                a[p, j] = swap
        inverse = 1.0 / a[k, k]
        a[k, k] = inverse
        for i in range(k + 1, n):
            factor = a[i, k] * inverse
            a[i, k] = factor
            for j in range(k + 1, n):
                a[i, j] -= factor * a[k, j]


@kernel_as(_factor_loops)
def factor(a: Any, pivots: Any) -> None:
    """Factor the matrix a in place for `substitute`; a singular matrix leaves non-finite numbers."""
    try:
        a[:] = np.linalg.inv(a)
    except np.linalg.LinAlgError:
        a[:] = np.nan


def _substitute_loops(a: Any, pivots: Any, b: Any) -> None:
    n = a.shape[0]
    for k in range(n):
        p = pivots[k]
        swap = b[k]
        b[k] = b[p]
        b[p] = swap
    for k in range(n):
        for i in range(k + 1, n):
            b[i] -= a[i, k] * b[k]
    for k in range(n - 1, -1, -1):
        b[k] *= a[k, k]
        for i in range(k):
            b[i] -= a[i, k] * b[k]


@kernel_as(_substitute_loops)
def substitute(a: Any, pivots: Any, b: Any) -> None:
    """Solve in place for the right-hand side b with the matrix that `factor` left in a."""
    b[:] = a @ b
