"""Small dense linear algebra for the solvers: one line of NumPy as Python, loops as machine code.

The loops beat LAPACK below about 60 unknowns, where the time of a call dominates. As Python, a matrix of up to LARGE
rows is inverted by NumPy, and a larger one, where that takes three times as long or more, factored by SciPy.
"""

from typing import Any

import numpy as np

from ...base.results import Floats
from ...compile.array_functions import elementwise, summed
from ...compile.jit import kernel, kernel_as, routine

LARGE = 60  # below it, loading SciPy (0.1 s) costs more than a whole curve gains


@elementwise
def copy(source: Any, out: Any) -> Any:
    """Write the entries of source to out."""
    return source


@elementwise
def fill(value: float, out: Any) -> Any:
    """Set every entry of out."""
    return value


@elementwise
def add(factor: float, v: Any, out: Any) -> Any:
    """Add factor times v to out."""
    return out + factor * v


@elementwise
def divide(by: float, out: Any) -> Any:
    """Divide every entry of out."""
    return out / by


@elementwise
def weigh(v: Any, scale: Any, out: Any) -> Any:
    """Write v times the square of scale to out."""
    return v * scale * scale


@summed(np.dot)
def dot(a: Any, b: Any) -> Any:
    """Scalar product of two vectors of equal length."""
    return a * b


@summed(lambda v, weights: (scaled := v * weights) @ scaled)
def weighted_square(v: Any, weights: Any) -> Any:
    """Square of the Euclidean norm of v times weights, entry by entry."""
    return (v * weights) ** 2


@kernel
def weighted_norm(v: Floats, weights: Floats) -> float:
    """Euclidean norm of v times weights, entry by entry."""
    return float(weighted_square(v, weights) ** 0.5)


def _extremes_loops(v: Floats) -> Any:
    low, high = 0, 0
    for i in range(1, len(v)):
        if v[i] < v[low]:
            low = i
        if v[i] > v[high]:
            high = i
    return low, high


@kernel_as(_extremes_loops)
def extremes(v: Floats) -> Any:
    """Places of the smallest and the largest entry."""
    return np.argmin(v), np.argmax(v)


def _row_times_loops(row: Floats, table: Floats, product: Floats) -> None:
    # Eight columns at a time in registers: the compiler's own vector loop suits long rows and leaves short ones scalar.
    n, columns = product.shape[0], table.shape[1]
    full = columns - columns % 8
    for j in range(0, min(full, n), 8):
        c0, c1, c2, c3, c4, c5, c6, c7 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for i in range(table.shape[0]):
            f = row[i]
            c0 += f * table[i, j]
            c1 += f * table[i, j + 1]
            c2 += f * table[i, j + 2]
            c3 += f * table[i, j + 3]
            c4 += f * table[i, j + 4]
            c5 += f * table[i, j + 5]
            c6 += f * table[i, j + 6]
            c7 += f * table[i, j + 7]
        if j + 8 <= n:
            product[j], product[j + 1], product[j + 2], product[j + 3] = c0, c1, c2, c3
            product[j + 4], product[j + 5], product[j + 6], product[j + 7] = c4, c5, c6, c7
        else:
            block = (c0, c1, c2, c3, c4, c5, c6, c7)
            for k in range(n - j):
                product[j + k] = block[k]
    for j in range(full, n):
        total = 0.0
        for i in range(table.shape[0]):
            total += row[i] * table[i, j]
        product[j] = total


@kernel_as(_row_times_loops)
def row_times(row: Floats, table: Floats, product: Floats) -> None:
    """Write row @ table to out. The row may be longer than the table has rows; `padded` tables are faster."""
    np.dot(row[: len(table)], table[:, : len(product)], out=product)


def padded(table: Floats) -> Floats:
    """Table with columns of zeros added up to a multiple of eight."""
    rows, columns = table.shape
    out = np.zeros((rows, columns + -columns % 8))
    out[:, :columns] = table
    return out


def _factor_loops(a: Floats, pivots: Any) -> float:
    return reduce(a, pivots, a.shape[0])


@routine
def reduce(a: Floats, pivots: Any, number: int) -> float:
    """Factor the first `number` rows and columns of a square matrix; what is behind them becomes their complement.

    The number is that of all or a multiple of 4. Returns the sign of the determinant of the part that is factored.
    """
    # Four columns at a time, so that the rest of the matrix is read and written once for four of them.
    n, sign = a.shape[0], 1.0
    for start in range(0, number, 4):
        end = min(start + 4, n)
        for k in range(start, end):
            p = k
            largest = abs(a[k, k])
            for i in range(k + 1, number):
                if abs(a[i, k]) > largest:
                    largest = abs(a[i, k])
                    p = i
            pivots[k] = p
            if (a[p, k] < 0.0) != (p != k):
                sign = -sign
            if p != k:
                upper, lower = a[k], a[p]
                for j in range(n):
                    upper[j], lower[j] = lower[j], upper[j]
            inverse = 1.0 / a[k, k]
            a[k, k] = inverse
            for i in range(k + 1, n):
                factor = a[i, k] * inverse
                a[i, k] = factor
                for j in range(k + 1, end):
                    a[i, j] -= factor * a[k, j]
        if end == n:
            break
        for k in range(start, end):
            for i in range(k + 1, end):
                add(-a[i, k], a[k, end:], a[i, end:])
        top0, top1, top2, top3 = a[start, end:], a[start + 1, end:], a[start + 2, end:], a[start + 3, end:]
        for i in range(end, n):
            f0, f1, f2, f3 = a[i, start], a[i, start + 1], a[i, start + 2], a[i, start + 3]
            row = a[i, end:]
            for j in range(row.shape[0]):
                row[j] -= f0 * top0[j] + f1 * top1[j] + f2 * top2[j] + f3 * top3[j]
    return sign


@kernel_as(_factor_loops)
def factor(a: Floats, pivots: Any) -> float:
    """Factor the matrix a in place for `substitute` and return the sign of its determinant.

    A singular matrix leaves non-finite numbers.
    """
    if len(a) > LARGE:
        from scipy.linalg.lapack import dgetrf

        transposed, pivots[:], _ = dgetrf(a.T, overwrite_a=True)  # LAPACK has columns where rows are here
        if not np.shares_memory(transposed, a):
            a[:] = transposed.T
        swaps = np.count_nonzero(pivots != np.arange(len(a)))
        return float(np.prod(np.sign(np.diag(a)))) * (-1.0) ** swaps
    sign = float(np.linalg.slogdet(a)[0])
    try:
        a[:] = np.linalg.inv(a)
    except np.linalg.LinAlgError:
        a[:] = np.nan
    return sign


def _substitute_loops(a: Floats, pivots: Any, b: Floats) -> None:
    n = a.shape[0]
    for k in range(n):
        p = pivots[k]
        swap = b[k]
        b[k] = b[p]
        b[p] = swap
    for i in range(1, n):
        b[i] -= _product(a[i, :i], b)
    for i in range(n - 1, -1, -1):
        b[i] = (b[i] - _product(a[i, i + 1 :], b[i + 1 :])) * a[i, i]


@routine
def _product(row: Floats, b: Floats) -> float:
    # Four sums side by side: one alone waits for each of its additions.
    n, s0, s1, s2, s3 = len(row), 0.0, 0.0, 0.0, 0.0
    full = n - n % 4
    for k in range(0, full, 4):
        s0 += row[k] * b[k]
        s1 += row[k + 1] * b[k + 1]
        s2 += row[k + 2] * b[k + 2]
        s3 += row[k + 3] * b[k + 3]
    for k in range(full, n):
        s0 += row[k] * b[k]
    return s0 + s1 + (s2 + s3)


@kernel_as(_substitute_loops)
def substitute(a: Floats, pivots: Any, b: Floats) -> None:
    """Solve in place for the right-hand side b with the matrix that `factor` left in a."""
    if len(a) > LARGE:
        from scipy.linalg.lapack import dgetrs

        b[:] = dgetrs(a.T, pivots, b, trans=1)[0]
    else:
        b[:] = a @ b
