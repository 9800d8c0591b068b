"""Period maps of y' = (A + B R(t) C) y: a constant matrix and a few feedbacks that vary, in long panels.

In a panel of length h the feedbacks f = R C y are polynomials through their values at m places c_i h, and what they do
to y is integrated exactly: y(t) = exp(A t) y(0) + int_0^t exp(A (t - s)) B f(s) ds. At the places that is a linear
system with as many unknowns as feedbacks, not states, and no step has to resolve by itself what A does. The tables
are power series in h, which the length of a panel keeps short. With Gauss's places the order is 2 m.

Hochbruck & Ostermann 2010, Exponential integrators, Acta Numerica 19, sec. 2.2 (exponential collocation).
"""

import math
from functools import lru_cache
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from ...base.results import Floats
from ...compile.jit import borrowed, kernel_as, routine, run
from ..balance.fourier import Samples, parted
from ..balance.linear_algebra import reduce
from ..balance.piecewise import is_piecewise_linear

PLACES = 8
FEW_RUNS = 8  # runs in NumPy, which take a tenth of a second, before they are compiled
PHASE = 3.5  # of the fastest disturbance in a panel [rad]
TERMS = 34  # of the series in it
WAVES = 4.5  # of the highest harmonic of an orbit in a panel [rad]
SMALL_SHARE = 1e-11  # share of an orbit's harmonics that no panel has to resolve
MOST_PANELS = 2048  # panels a period
TOGETHER, MANY = 64, 1600  # orbits, and harmonics of them, at a time: their waves stay in the cache
C = 0.5 + 0.5 * np.polynomial.legendre.leggauss(PLACES)[0]

_PLACES, _WEIGHTS = np.polynomial.legendre.leggauss(4)
GAUSS_C, GAUSS_B = 0.5 + 0.5 * _PLACES, 0.5 * _WEIGHTS
_POWERS = np.arange(1, 5)  # collocation: the rows integrate powers of the place exactly
GAUSS_A = GAUSS_C[:, None] ** _POWERS / _POWERS @ np.linalg.inv(GAUSS_C[:, None] ** (_POWERS - 1))
A, B = tuple(map(tuple, GAUSS_A.tolist())), tuple(GAUSS_B.tolist())


@routine
def eliminated(m: Floats) -> None:
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


@routine
def step_by(a: Floats, h: float, hill: bool, m: Floats, step: Floats, flow: Floats) -> Any:
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
            decay += h * B[i] * mean
        for k in range(n):
            for q in range(4 * n, 5 * n):
                m[i * n + k, q] = a[i, k, q - 4 * n]
            m[i * n + k, 4 * n + k] -= mean
            for j in range(4):
                factor = -h * A[i][j]
                for q in range(n):
                    m[i * n + k, j * n + q] = factor * m[i * n + k, 4 * n + q]
            m[i * n + k, i * n + k] += 1.0
    eliminated(m)
    for k in range(n):
        for q in range(n):
            step[0, k, q] = 1.0 if k == q else 0.0
            for i in range(4):
                step[0, k, q] += h * B[i] * m[i * n + k, 4 * n + q]
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


def walked(a: Floats, h: Floats, hill: bool, flow: Floats) -> tuple[float, float]:
    """Carry a flow (n, n) over steps of the lengths h (steps,) [s] with matrices a (steps, 4, n, n), as `step_by`."""
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


class Tables(NamedTuple):
    """Effect of A and B in panels of some lengths, for states n, feedbacks r and what they see, q, at places m.

    `seen` (lengths, m, q, n) of the state at the start and `answers` (lengths, m, q, m r) of the feedbacks; the state
    at the end: `flow` (lengths, n, n) and `gains` (lengths, n, m r).
    """

    seen: Floats
    answers: Floats
    flow: Floats
    gains: Floats


@lru_cache(1)
def _weights() -> tuple[Floats, Floats]:
    """Powers c^p/p! (m + 1, terms) and integrals (m + 1, m, terms) of (c - s)^p/p! times Lagrange's polynomials.

    c are the places and, last, 1; the integrals run from 0 to c.
    """
    ends, p = np.append(C, 1.0), np.arange(TERMS)
    factorial = np.cumprod(np.maximum(p, 1).astype(float))
    x, w = np.polynomial.legendre.leggauss(TERMS)
    s = np.outer(ends, 0.5 + 0.5 * x)
    lagrange = np.stack([np.prod([(s - d) / (c - d) for d in C if d != c], axis=0) for c in C], axis=1)
    powers = (ends[:, None] - s)[..., None] ** p / factorial
    return ends[:, None] ** p / factorial, np.einsum("ie,ije,iep->ijp", 0.5 * ends[:, None] * w, lagrange, powers)


def tables(a: Floats, b: Floats, c: Floats, lengths: Floats) -> Tables:
    """Tables of the constant matrix a (n, n), the inputs b (n, r) and the outputs c (q, n) for lengths (k,) [s]."""
    n, r, q, k, m = len(a), b.shape[1], len(c), len(lengths), PLACES
    longest = np.max(lengths, initial=1e-300)
    powers = np.empty((TERMS, n, n))
    powers[0] = np.eye(n)
    for i in range(1, TERMS):
        powers[i] = powers[i - 1] @ (longest * a)
    share = (lengths / longest)[:, None] ** np.arange(TERMS)
    weights, answer = _weights()
    inputs = powers @ b
    after = _series(share, weights, powers)
    behind = lengths[:, None, None, None, None] * _series(share, answer.reshape(-1, TERMS), inputs).reshape(
        k, m + 1, m, n, r
    )
    seen = c @ after[:, :m]
    answers = np.moveaxis(c @ behind[:, :m], 2, 3)
    gains = np.moveaxis(behind[:, m], 1, 2)
    shapes = (k, m, q, n), (k, m, q, m * r), (k, n, n), (k, n, m * r)
    values = (seen, answers, after[:, m], gains)
    return Tables(*(np.ascontiguousarray(x).reshape(s) for x, s in zip(values, shapes, strict=True)))


def _series(share: Floats, weights: Floats, powers: Floats) -> Floats:
    """Sums (lengths, rows, n, ...) of powers (terms, n, ...) with the weights (rows, terms) for shares of a length."""
    terms = share[:, None, :] * weights
    return np.asarray((terms @ powers.reshape(TERMS, -1)).reshape(*terms.shape[:2], *powers.shape[1:]))


def _panels_loops(table: Any, kinds: Any, feedback: Floats, first: Any, flow: Floats) -> None:
    observed, answers, end, gains = borrowed(table[0]), borrowed(table[1]), borrowed(table[2]), borrowed(table[3])
    kinds, feedback, first, flow = borrowed(kinds), borrowed(feedback), borrowed(first), borrowed(flow)
    _, places, r, q = feedback.shape
    n = end.shape[1]
    rows = places * r
    m, new, pivots = np.empty((rows + n, rows + n)), np.empty((n, n)), np.empty(rows, np.int64)
    for orbit in range(len(first) - 1):
        for k in range(n):
            for j in range(n):
                flow[orbit, k, j] = 1.0 if k == j else 0.0
        for p in range(first[orbit], first[orbit + 1]):
            kind = kinds[p]
            for i in range(places):
                for e in range(r):
                    row = i * r + e
                    for j in range(rows + n):
                        m[row, j] = 0.0
                    for o in range(q):
                        factor = feedback[p, i, e, o]
                        if factor != 0.0:
                            for j in range(rows):
                                m[row, j] -= factor * answers[kind, i, o, j]
                            for j in range(n):
                                m[row, rows + j] += factor * observed[kind, i, o, j]
                    m[row, row] += 1.0
            for k in range(n):
                for j in range(rows):
                    m[rows + k, j] = -gains[kind, k, j]
                for j in range(n):
                    m[rows + k, rows + j] = end[kind, k, j]
            reduce(m, pivots, rows)  # behind the system of the feedbacks the map of the panel is left
            for k in range(n):
                for j in range(n):
                    new[k, j] = 0.0
                for i in range(n):
                    for j in range(n):
                        new[k, j] += m[rows + k, rows + i] * flow[orbit, i, j]
            for k in range(n):
                for j in range(n):
                    flow[orbit, k, j] = new[k, j]


@kernel_as(_panels_loops)
def _panels(table: Any, kinds: Any, feedback: Floats, first: Any, flow: Floats) -> None:
    panels, m, r, _ = feedback.shape
    observed, answers, end, gains = [x[kinds] for x in table]
    n, rows = end.shape[1], m * r
    coupled = (feedback @ answers).reshape(panels, rows, rows)
    forced = (feedback @ observed).reshape(panels, rows, n)
    maps = end + gains @ np.linalg.solve(np.eye(rows) - coupled, forced)
    for orbit, (low, high) in enumerate(pairwise(first)):
        flow[orbit] = np.eye(n)
        for step in maps[low:high]:
            flow[orbit] = step @ flow[orbit]


def through_panels(table: Tables, kinds: Any, feedback: Floats, first: Any) -> Floats:
    """Period maps (orbits, n, n) of orbits whose panels follow each other.

    `kinds` (panels,) tells the length of each in the tables, `feedback` (panels, m, r, q) is R at its places, and
    orbit i has the panels from first[i] to first[i + 1].
    """
    n = table.flow.shape[1]
    flow = np.empty((len(first) - 1, n, n))
    run(_panels, tuple(table), kinds, feedback, first, flow, light=True, after=FEW_RUNS)
    return flow


def resolved(disturbances: Any) -> bool:
    """True if no more than MOST_PANELS a period resolve the disturbances of all orbits."""
    return bool(disturbances.rate * 2.0 * np.pi <= MOST_PANELS * PHASE * np.min(disturbances.speed))


def maps_through_panels(all_orbits: Any) -> Floats:
    """Period maps (orbits, states, states) of `Disturbances` of orbits; panels end at the kinks of an orbit."""
    maps, count = [], min(TOGETHER, max(1, MANY // (all_orbits.twists.shape[2] // 2)))
    for i in range(0, len(all_orbits.twists), count):
        chunk = slice(i, i + count)
        deviation = None if all_orbits.deviation is None else all_orbits.deviation[chunk]
        part = all_orbits._replace(twists=all_orbits.twists[chunk], deviation=deviation, speed=all_orbits.speed[chunk])
        maps.append(_maps(part))
    return np.concatenate(maps)


def _maps(disturbances: Any) -> Floats:
    longest = np.minimum(PHASE * disturbances.speed / disturbances.rate, longest_in(disturbances))
    cuts = [places if len(places) else np.zeros(1) for places in disturbances.crossings()]
    numbers = np.array([len(places) for places in cuts])
    starts, last = np.concatenate(cuts), np.cumsum(numbers) - 1
    begin = last - numbers + 1
    ends = np.append(starts[1:], 0.0)
    ends[last] = starts[begin] + 2.0 * np.pi
    first, width, parts = parted(starts, ends - starts, np.repeat(longest, numbers))
    counts = np.add.reduceat(parts, begin)
    after = np.cumsum(counts)
    psi = (first[:, None] + width[:, None] * C).ravel()
    basis = Samples(psi, psi).basis(disturbances.twists.shape[2] // 2)
    r = disturbances.feedbacks(psi, np.split(basis, PLACES * after[:-1], axis=1))
    lengths, kinds = np.unique(width / np.repeat(disturbances.speed, counts), return_inverse=True)
    table = tables(disturbances.a, disturbances.b, disturbances.c, lengths)
    return through_panels(table, kinds, r.reshape(-1, PLACES, *r.shape[1:]), np.append(0, after))


def longest_in(disturbances: Any) -> Floats:
    """Longest panels [rad] (orbits,) that resolve orbits.

    Between the kinks of a piecewise linear law nothing varies where the motor has no deviation.
    """
    series, deviation = disturbances.twists, disturbances.deviation
    if deviation is None and all(map(is_piecewise_linear, disturbances.problem.part.laws)):
        return np.full(len(series), np.inf)
    series = series if deviation is None else np.concatenate([series, deviation[:, None]], axis=1)
    h = series.shape[2] // 2
    k, sizes = np.arange(1, h + 1), np.abs(series[..., 1 : h + 1]) + np.abs(series[..., h + 1 :])
    beyond = np.cumsum(sizes[..., ::-1], axis=2)[..., ::-1]
    share = np.maximum(beyond / np.maximum(beyond[..., :1], 1e-300), SMALL_SHARE)
    audible = share > SMALL_SHARE
    longest = np.where(audible, 0.5 * WAVES * share ** (-0.5 / PLACES) / k, WAVES)
    top = np.max(np.where(audible, k, 1), axis=(1, 2))
    return np.asarray(np.maximum(np.min(longest, axis=(1, 2)), WAVES / top))
