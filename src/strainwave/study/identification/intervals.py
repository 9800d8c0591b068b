"""Intervals that cover: the scatter of least squares whose residuals are coloured.

Least squares give d = (J'J)^-1 J'r, whose covariance is the sandwich (J'J)^-1 S (J'J)^-1 with S that of the sum of the
scores J_i r_i. Residuals of measurements are coloured: neighbours say the same, and S is not s^2 J'J. The residual is
therefore whitened, r = e/A(q), and the filter goes over to the jacobian, J'r = (J/A(1/q))'e. S is the sum of squares of
these whitened scores, so that it allows for residuals that grow with the motion, and what correlation they keep comes
in by Bartlett's kernel with Andrews' bandwidth.

White 1980, Econometrica 48; Andrews 1991, Econometrica 59, eqs. (6.2), (6.4); Andrews & Monahan 1992, Econometrica 60
(whitening first); MacKinnon & White 1985, J. Econometrics 29 (HC3, small samples); Morelli & Klein 1997, J. Aircraft 34
(coloured residuals of measured motion). Degrees of freedom are those of a variance with the same scatter (Satterthwaite
1946, Biometrics Bull. 2).

Coloured residuals: the autoregression r_i = a_1 r_(i-1) + a_2 r_(i-2) + ... + e_i that whitens them.
"""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import solve_toeplitz
from scipy.optimize import minimize_scalar
from scipy.signal import lfilter
from scipy.special import stdtrit

from ...base.quantities import SMALLEST, array_of, number, positive_count, shown, whole
from ...base.results import Floats

RANK = 1e-10  # of the largest singular value of the jacobian with columns of length 1: a smaller one is none
HIGHEST_LEVERAGE = 0.9

HIGHEST_ORDER = 32  # order of the autoregression
ORDER_ROWS = 12  # of the longest record for each order
RESPONSE_SAMPLES = 1 << 14  # of the impulse response, in samples

COLOURS = np.linspace(-0.9, 0.98, 20)  # phi tried
TINY = 1e-300


def slices(records: Any, rows: int) -> list[slice]:
    """Rows of each record, from their counts or their slices; without records all rows are one."""
    if records is None:
        return [slice(0, rows)]
    if all(isinstance(item, slice) for item in records):
        parts = [slice(*item.indices(rows)[:2]) for item in records]
    else:
        parts = [slice(int(a), int(b)) for a, b in pairwise(np.cumsum([0, *records]))]
    if sum(part.stop - part.start for part in parts) != rows or any(part.stop <= part.start for part in parts):
        raise ValueError(f"records are {shown(records)}; they must share out all {rows} rows, at least one to each")
    return parts


def whitener(residual: Floats, parts: Sequence[slice]) -> Floats:
    """Coefficients (order,) of the residual's autoregression; none where it is white."""
    longest = max(part.stop - part.start for part in parts)
    forward = [residual[part] for part in parts]
    backward, a, n = forward, np.empty(0), len(residual)
    power = float(residual @ residual) / n
    best, least = a, n * math.log(power) if power > 0.0 else -math.inf
    for order in range(1, min(HIGHEST_ORDER, longest // ORDER_ROWS) + 1):
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
    """Innovations e (n, ...) of a residual, or of columns (n, p), each record from rest."""
    return np.concatenate([lfilter(np.append(1.0, -a), [1.0], residual[part], axis=0) for part in parts])


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
    impulse = np.zeros(RESPONSE_SAMPLES)
    impulse[0] = 1.0
    response = lfilter([1.0], np.append(1.0, -a), impulse)
    covariances = np.array([response[: RESPONSE_SAMPLES - k] @ response[k:] for k in range(order)])
    return np.asarray(np.einsum("kj,kj->j", slope, solve_toeplitz(covariances, slope)) / rows)


class Interval(NamedTuple):
    """Interval of a value, with the probability that was asked for."""

    low: float
    high: float


class Spread(NamedTuple):
    """Scatter of the parameters of a least-squares fit.

    Attributes
    ----------
    covariance : (p, p) array
        Of the parameters.
    freedom : (p,) array
        Degrees of freedom of its diagonal: how few a column's own rows are, and how well the colour is known there.
    whitener : (order,) array
        Coefficients a of the residual's autoregression r_i = a_1 r_(i-1) + a_2 r_(i-2) + ... + e_i.
    """

    covariance: Floats
    freedom: Floats
    whitener: Floats


def interval(value: float, deviation: float, freedom: float = math.inf, level: float = 0.95) -> Interval:
    """Interval of Student's t around a value.

    Parameters
    ----------
    value, deviation : float
        Estimate and its standard deviation.
    freedom : float
        Degrees of freedom of the deviation; infinite: of the normal distribution.
    level : float
        Probability of covering the true value, between 0 and 1.

    Raises
    ------
    ValueError
        If the level is not between 0 and 1.
    """
    level = number("level", level)
    if not 0.0 < level < 1.0:
        raise ValueError(f"level is {level:g}; it is the probability of covering, between 0 and 1, such as 0.95")
    reach = float(stdtrit(min(freedom, 1e9), 0.5 + 0.5 * level)) * deviation
    return Interval(value - reach, value + reach)


def sandwich(jacobian: Floats, residual: Floats, records: Any = None) -> Floats:
    """Covariance (p, p) of least squares with coloured residuals, see `spread`.

    Returns
    -------
    (p, p) array
        Covariance, in products of the units of the parameters; that of `spread(...)`, without its degrees of
        freedom.
    """
    return spread(jacobian, residual, records).covariance


def spread(jacobian: Floats, residual: Floats, records: Any = None) -> Spread:
    """Scatter of the parameters of least squares with coloured residuals.

    Parameters
    ----------
    jacobian : (n, p) array
        Derivatives of the model's values, or of the residual, by the parameters, at the solution.
    residual : (n,) array
        Measured less computed, at the solution.
    records : sequence of int or of slice, optional
        Rows of each record: residuals of different records are independent. Default: all rows are one record.

    Returns
    -------
    Spread
        `covariance` (p, p) in the units of the parameters; `freedom` (p,), degrees of freedom of its diagonal.

    Raises
    ------
    ValueError
        If the arrays do not fit, or the jacobian has columns that depend on each other.
    """
    jacobian, residual = fitting(jacobian, residual)
    parts, rows = slices(records, len(residual)), len(residual)
    basis, back = basis_of(jacobian)
    a = whitener(residual, parts)
    innovation = whitened(residual, a, parts)
    leverage = np.minimum(np.vecdot(basis, basis), HIGHEST_LEVERAGE)
    weights = backwards(basis, a, parts)
    scores = weights * (innovation / (1.0 - leverage))[:, None]
    scores -= np.mean(scores, axis=0)
    middle = long_run(scores, parts) * rows / max(rows - len(a), 1)
    influence = weights @ back.T
    square = influence * influence
    share = np.sum(square * square, axis=0) / np.sum(square, axis=0) ** 2 * rows / max(rows - jacobian.shape[1], 1)
    freedom = 2.0 / (2.0 * share + relative_variance(influence, a, parts, rows))
    return Spread(back @ middle @ back.T, np.maximum(freedom, 1.0), a)


def fitting(jacobian: Any, residual: Any) -> tuple[Floats, Floats]:
    """Jacobian (n, p) and residual (n,), checked."""
    jacobian, residual = array_of("jacobian", jacobian), array_of("residual", residual)
    if jacobian.ndim != 2 or residual.shape != jacobian.shape[:1] or len(residual) <= jacobian.shape[1]:
        raise ValueError(
            f"the jacobian has the shape {jacobian.shape} and the residual {residual.shape}; they must be (n, p) and "
            "(n,) with more rows n than parameters p"
        )
    return jacobian, residual


def basis_of(jacobian: Floats) -> tuple[Floats, Floats]:
    """Orthonormal columns (n, p) of the jacobian, and the matrix (p, p) that takes their coefficients to parameters."""
    sizes = np.linalg.norm(jacobian, axis=0)
    basis, triangle = np.linalg.qr(jacobian / np.where(sizes > SMALLEST, sizes, 1.0))
    singular = np.linalg.svd(triangle, compute_uv=False)
    if not singular[-1] > RANK * max(1.0, singular[0]):
        raise ValueError("columns of the jacobian depend on each other; fix a parameter (see `unidentifiable`)")
    return basis, np.linalg.inv(triangle) / sizes[:, None]


def long_run(scores: Floats, records: Any = None) -> Floats:
    """Covariance (p, p) of the sum of scores (n, p) by Bartlett's kernel, never across records.

    Its bandwidth is Andrews' for first-order autoregressions, with equal weights of the scores divided by their size.
    """
    parts, rows = slices(records, len(scores)), len(scores)
    total = scores.T @ scores
    power = np.diag(total)
    moving = power > 0.0
    if not np.any(moving) or rows < 4:
        return total
    neighbours = sum(np.einsum("ij,ij->j", scores[p][1:], scores[p][:-1]) for p in parts)
    rho = np.clip(neighbours[moving] / power[moving], -0.97, 0.97)
    alpha = np.mean(4.0 * rho**2 / ((1.0 - rho) ** 2 * (1.0 + rho) ** 2))
    bandwidth = 1.1447 * (alpha * rows) ** (1.0 / 3.0)
    for lag in range(1, min(math.ceil(bandwidth), rows // 4)):
        pairs = sum(scores[p][lag:].T @ scores[p][:-lag] for p in parts if p.stop - p.start > lag)
        total = total + (1.0 - lag / bandwidth) * (pairs + np.transpose(pairs))
    return np.asarray(total)


def restricted(jacobian: Floats, residual: Floats) -> Spread:
    """Scatter of least squares with the jacobian (n, p) and the residual (n,): coloured, and perhaps uneven."""
    (n, p), (basis, back) = jacobian.shape, basis_of(jacobian)
    phi = _colour(basis, residual)
    innovation = without(_white(basis, phi), _white(residual, phi))
    # V is the covariance of the residual: basis' V basis by the filter that takes white noise to it
    passed = backwards(basis, np.array([phi]), [slice(0, n)])
    passed[0] /= math.sqrt(1.0 - phi * phi)
    covariance = float(innovation @ innovation) / (n - p) * back @ (passed.T @ passed) @ back.T
    coloured = spread(jacobian, residual)
    wider = np.sqrt(np.maximum(np.diag(coloured.covariance) / np.maximum(np.diag(covariance), TINY), 1.0))
    freedom = max((n - p) * (1.0 - abs(phi)) / (1.0 + abs(phi)), 1.0)
    return Spread(covariance * np.outer(wider, wider), np.full(p, freedom), np.array([phi]))


def _white(values: Floats, phi: float) -> Floats:
    """Take the colour phi out of columns (n, ...); the first row keeps its scatter."""
    white = np.array(values)
    white[1:] -= phi * values[:-1]
    white[0] *= math.sqrt(1.0 - phi * phi)
    return white


def without(columns: Floats, values: Floats) -> Floats:
    """Values less what the columns say of them."""
    return orthogonal(np.linalg.qr(columns)[0], values)


def orthogonal(basis: Floats, values: Floats) -> Floats:
    """Values less what orthonormal columns say of them."""
    return np.asarray(values - basis @ (basis.T @ values))


def _colour(basis: Floats, residual: Floats) -> float:
    """Colour phi of largest restricted likelihood."""
    n, p = basis.shape

    def cost(phi: float) -> float:
        Q, triangle = np.linalg.qr(_white(basis, phi))
        miss = orthogonal(Q, _white(residual, phi))
        size = 2.0 * float(np.sum(np.log(np.abs(np.diag(triangle)) + TINY)))
        power = math.log(float(miss @ miss) + TINY)
        return float((n - p) * power - math.log(1.0 - phi * phi) + size)

    best = int(np.argmin([cost(phi) for phi in COLOURS.tolist()]))
    ends = COLOURS[max(best - 1, 0)], COLOURS[min(best + 1, len(COLOURS) - 1)]
    return float(minimize_scalar(cost, bounds=ends, method="bounded", options={"xatol": 1e-4}).x)


def derived_freedom(rates: Floats, covariance: Floats, freedom: Any) -> Floats:
    """Degrees of freedom (m,) of numbers with the derivatives rates (m, p) by the unknowns: Satterthwaite's rule."""
    shares = rates**2 * np.diag(covariance)
    total = np.maximum(np.sum(shares**2 / freedom, axis=1), TINY)
    return np.asarray(np.maximum(np.sum(shares, axis=1) ** 2 / total, 1.0))


def bootstrap(
    jacobian: Floats, residual: Floats, records: Any = None, *, block: int | None = None, draws: int = 1000,
    seed: int = 0,
) -> Floats:  # fmt: skip
    """Draw changes (draws, p) of the parameters by putting the data together anew, linearised at the solution.

    Each draw takes as many records as there are, with repetition; or blocks of neighbouring rows, which start anywhere
    in a record. It assumes nothing on colour inside what is drawn whole, and is honest from about 20 of them on.

    Parameters
    ----------
    jacobian, residual, records
        As for `spread`.
    block : int, optional
        Rows of a block. Default: whole records are drawn.
    draws, seed : int
        Number of draws, and the seed of the generator.

    Returns
    -------
    (draws, p) array
        Changes, in the units of the parameters.

    References
    ----------
    Efron & Tibshirani 1993, An Introduction to the Bootstrap, sec. 8.6 (moving blocks); Künsch 1989, Ann. Stat. 17.
    """
    jacobian, residual = fitting(jacobian, residual)
    parts, rng = slices(records, len(residual)), np.random.default_rng(whole("seed", seed))
    if block is None and len(parts) < 2:
        raise ValueError("there is one record; a bootstrap of records needs several, or give the rows of a block")
    if block is not None:
        size = positive_count("block", block)
        parts = [slice(i, i + size) for p in parts for i in range(p.start, p.stop - size + 1)]
        if not parts:
            raise ValueError(f"block is {size} rows; the longest record has fewer")
    basis, back = basis_of(jacobian)
    count = len(residual) / np.mean([p.stop - p.start for p in parts])
    grams = np.array([basis[p].T @ basis[p] for p in parts])
    scores = np.array([basis[p].T @ residual[p] for p in parts])
    scores -= scores.mean(axis=0)  # blocks do not take all rows equally often
    times = rng.multinomial(round(count), np.full(len(parts), 1.0 / len(parts)), size=positive_count("draws", draws))
    try:
        changes = np.linalg.solve(np.tensordot(times, grams, 1), (times @ scores)[:, :, None])[:, :, 0]
    except np.linalg.LinAlgError:
        raise ValueError(
            f"a draw of the {len(parts)} parts leaves out the rows that tell a parameter; give larger blocks, or the "
            "jacobian without rows that are much larger than the others"
        ) from None
    return np.asarray(changes @ back.T)
