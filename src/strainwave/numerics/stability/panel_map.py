"""Period maps of y' = (A + B R(t) C) y: a constant matrix and a few feedbacks that vary, in long panels.

In a panel of length h the feedbacks f = R C y are polynomials through their values at m places c_i h, and what they do
to y is integrated exactly: y(t) = exp(A t) y(0) + int_0^t exp(A (t - s)) B f(s) ds. At the places that is a linear
system with as many unknowns as feedbacks, not states, and no step has to resolve by itself what A does. The tables
are power series in h, which the length of a panel keeps short. With Gauss's places the order is 2 m.

Hochbruck & Ostermann 2010, Exponential integrators, Acta Numerica 19, sec. 2.2 (exponential collocation).
"""

from functools import lru_cache
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from ...base.results import Floats
from ...compile.jit import borrowed, kernel_as, run
from ..balance.fourier import Samples, parted
from ..balance.linear_algebra import reduce
from ..balance.piecewise import is_piecewise_linear

PLACES = 8  # of a panel
PLACE_SHARES = 0.5 + 0.5 * np.polynomial.legendre.leggauss(PLACES)[0]
SERIES_TERMS = 34  # of the power series in the length of a panel
DISTURBANCE_PHASE = 3.5  # of the fastest disturbance in a panel [rad]
HARMONIC_PHASE = 4.5  # of the highest harmonic of an orbit in a panel [rad]
SMALL_SHARE = 1e-11  # share of an orbit's harmonics that no panel has to resolve
MOST_PANELS = 2048  # panels a period
ORBITS_AT_ONCE, WAVES_AT_ONCE = 64, 400_000  # samples times harmonics of a pass, whose table stays in the cache
FEW_RUNS = 8  # runs in NumPy, which take a tenth of a second, before they are compiled


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
    ends, p = np.append(PLACE_SHARES, 1.0), np.arange(SERIES_TERMS)
    factorial = np.cumprod(np.maximum(p, 1).astype(float))
    x, w = np.polynomial.legendre.leggauss(SERIES_TERMS)
    s = np.outer(ends, 0.5 + 0.5 * x)
    lagrange = np.stack(
        [np.prod([(s - d) / (c - d) for d in PLACE_SHARES if d != c], axis=0) for c in PLACE_SHARES], axis=1
    )
    powers = (ends[:, None] - s)[..., None] ** p / factorial
    return ends[:, None] ** p / factorial, np.einsum("ie,ije,iep->ijp", 0.5 * ends[:, None] * w, lagrange, powers)


def tables(a: Floats, b: Floats, c: Floats, lengths: Floats) -> Tables:
    """Tables of the constant matrix a (n, n), the inputs b (n, r) and the outputs c (q, n) for lengths (k,) [s]."""
    n, r, q, k, m = len(a), b.shape[1], len(c), len(lengths), PLACES
    longest = np.max(lengths, initial=1e-300)
    powers = np.empty((SERIES_TERMS, n, n))
    powers[0] = np.eye(n)
    for i in range(1, SERIES_TERMS):
        powers[i] = powers[i - 1] @ (longest * a)
    share = (lengths / longest)[:, None] ** np.arange(SERIES_TERMS)
    weights, answer = _weights()
    inputs = powers @ b
    after = _series(share, weights, powers)
    behind = lengths[:, None, None, None, None] * _series(share, answer.reshape(-1, SERIES_TERMS), inputs).reshape(
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
    return np.asarray((terms @ powers.reshape(SERIES_TERMS, -1)).reshape(*terms.shape[:2], *powers.shape[1:]))


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
    return bool(disturbances.rate * 2.0 * np.pi <= MOST_PANELS * DISTURBANCE_PHASE * np.min(disturbances.speed))


def maps_through_panels(all_orbits: Any) -> Floats:
    """Period maps (orbits, states, states) of `Disturbances` of orbits; panels end at the kinks of an orbit."""
    longest, h = _longest_panels(all_orbits), all_orbits.twists.shape[2] // 2
    shares = np.maximum(PLACES * h * 2.0 * np.pi / longest / WAVES_AT_ONCE, 1.0 / ORBITS_AT_ONCE)  # of a pass
    passes = np.split(np.arange(len(shares)), np.flatnonzero(np.diff(np.cumsum(shares) // 1.0)) + 1)
    return np.concatenate([_maps(all_orbits.of(slice(orbits[0], orbits[-1] + 1))) for orbits in passes])


def _longest_panels(disturbances: Any) -> Floats:
    """Longest panels [rad] (orbits,) that resolve orbits and their disturbances."""
    of_disturbances = DISTURBANCE_PHASE * disturbances.speed / disturbances.rate
    return np.asarray(np.minimum(of_disturbances, longest_in(disturbances)))


def _maps(disturbances: Any) -> Floats:
    longest = _longest_panels(disturbances)
    cuts = [places if len(places) else np.zeros(1) for places in disturbances.crossings()]
    numbers = np.array([len(places) for places in cuts])
    starts, last = np.concatenate(cuts), np.cumsum(numbers) - 1
    begin = last - numbers + 1
    ends = np.append(starts[1:], 0.0)
    ends[last] = starts[begin] + 2.0 * np.pi
    first, width, parts = parted(starts, ends - starts, np.repeat(longest, numbers))
    counts = np.add.reduceat(parts, begin)
    after = np.cumsum(counts)
    psi = (first[:, None] + width[:, None] * PLACE_SHARES).ravel()
    basis = Samples(psi, psi).basis(disturbances.twists.shape[2] // 2)
    r = disturbances.feedbacks(psi, np.split(basis, PLACES * after[:-1], axis=1))
    lengths, kinds = np.unique(width / np.repeat(disturbances.speed, counts), return_inverse=True)
    table = tables(disturbances.a, disturbances.b, disturbances.c, lengths)
    return through_panels(table, kinds, r.reshape(-1, PLACES, *r.shape[1:]), np.append(0, after))


def longest_in(disturbances: Any) -> Floats:
    """Longest panels [rad] (orbits,) that resolve orbits.

    Between the kinks of a piecewise linear law nothing varies where the motor has no deviation.
    """
    series, error = disturbances.twists, disturbances.error
    if error is None and all(map(is_piecewise_linear, disturbances.laws)):
        return np.full(len(series), np.inf)
    series = series if error is None else np.concatenate([series, error.deviation[:, None]], axis=1)
    h = series.shape[2] // 2
    k, sizes = np.arange(1, h + 1), np.abs(series[..., 1 : h + 1]) + np.abs(series[..., h + 1 :])
    beyond = np.cumsum(sizes[..., ::-1], axis=2)[..., ::-1]
    share = np.maximum(beyond / np.maximum(beyond[..., :1], 1e-300), SMALL_SHARE)
    audible = share > SMALL_SHARE
    longest = np.where(audible, 0.5 * HARMONIC_PHASE * share ** (-0.5 / PLACES) / k, HARMONIC_PHASE)
    top = np.max(np.where(audible, k, 1), axis=(1, 2))
    return np.asarray(np.maximum(np.min(longest, axis=(1, 2)), HARMONIC_PHASE / top))
