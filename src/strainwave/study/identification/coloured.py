"""Coloured residuals: the autoregression r_i = a_1 r_(i-1) + a_2 r_(i-2) + ... + e_i that whitens them.

Burg's method, which no short record and no sharp resonance mislead as the autocovariances do; records share one filter.
Burg 1975, Maximum Entropy Spectral Analysis, ch. II; Schwarz 1978, Ann. Stat. 6 (the order).
"""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.linalg import solve_toeplitz
from scipy.signal import lfilter

from ...quantities import shown
from ...results import Floats

HIGHEST = 32  # order of the autoregression
ROWS = 12  # of the longest record for each order
LENGTH = 1 << 14  # of the impulse response, in samples


def slices(records: Any, rows: int) -> list[slice]:
    """Rows of each record, from their counts or their slices; without records all rows are one."""
    if records is None:
        return [slice(0, rows)]
    items = list(records)
    if all(isinstance(item, slice) for item in items):
        found = [slice(*item.indices(rows)[:2]) for item in items]
    else:
        ends = np.cumsum([0, *items])
        found = [slice(int(a), int(b)) for a, b in pairwise(ends)]
    if sum(part.stop - part.start for part in found) != rows or any(part.stop <= part.start for part in found):
        raise ValueError(f"records are {shown(records)}; they must share out all {rows} rows, at least one to each")
    return found


def whitener(residual: Floats, parts: Sequence[slice]) -> Floats:
    """Coefficients (order,) of the residual's autoregression; none where it is white."""
    longest = max(part.stop - part.start for part in parts)
    forward = [residual[part] for part in parts]
    backward, a, n = forward, np.empty(0), len(residual)
    power = float(residual @ residual) / n
    best, least = a, n * math.log(power) if power > 0.0 else -math.inf
    for order in range(1, min(HIGHEST, longest // ROWS) + 1):
        forward, backward = [f[1:] for f in forward], [b[:-1] for b in backward]
        both = sum(float(f @ f + b @ b) for f, b in zip(forward, backward, strict=True))
        if not both > 0.0:
            break
        k = 2.0 * sum(float(f @ b) for f, b in zip(forward, backward, strict=True)) / both
        pairs = list(zip(forward, backward, strict=True))
        forward, backward = [f - k * b for f, b in pairs], [b - k * f for f, b in pairs]
        a = np.append(a - k * a[::-1], k)
        power *= 1.0 - k * k
        if not power > 0.0:
            break
        criterion = n * math.log(power) + order * math.log(n)
        if criterion < least:
            best, least = a, criterion
    return best


def whitened(residual: Floats, a: Floats, parts: Sequence[slice]) -> Floats:
    """Innovations e (n,) of the residual (n,), each record from rest."""
    return np.concatenate([lfilter(np.append(1.0, -a), [1.0], residual[part]) for part in parts])


def backwards(columns: Floats, a: Floats, parts: Sequence[slice]) -> Floats:
    """Columns (n, p) through the filter against time, so that columns' residual = backwards(columns)' e."""
    if not len(a):
        return columns
    filtered = [lfilter([1.0], np.append(1.0, -a), columns[part][::-1], axis=0)[::-1] for part in parts]
    return np.concatenate(filtered)


def relative_variance(columns: Floats, a: Floats, parts: Sequence[slice], rows: int) -> Floats:
    """Relative variance (p,) of the estimated variance of columns'e, from that of the coefficients a.

    Parameters
    ----------
    columns : (n, p) array
        As `backwards` returns them: d log(sum of their squares)/d a_k is 2 sum(column (column/A)_(i+k))/sum(column^2).
    a : (order,) array
        With the covariance R^-1/rows, R the autocovariances of the residual over the variance of e.
    parts : sequence of slice
        Rows of each record.
    rows : int
        Rows behind the estimate of a.
    """
    if not len(a):
        return np.zeros(columns.shape[1])
    again, order = backwards(columns, a, parts), len(a)
    slope = np.zeros((order, columns.shape[1]))
    for part in parts:
        for k in range(1, min(order + 1, part.stop - part.start)):
            slope[k - 1] += np.einsum("ij,ij->j", columns[part][:-k], again[part][k:])
    slope *= 2.0 / np.einsum("ij,ij->j", columns, columns)
    impulse = np.zeros(LENGTH)
    impulse[0] = 1.0
    response = lfilter([1.0], np.append(1.0, -a), impulse)
    covariances = np.array([response[: LENGTH - k] @ response[k:] for k in range(order)])
    return np.asarray(np.einsum("kj,kj->j", slope, solve_toeplitz(covariances, slope)) / rows)
