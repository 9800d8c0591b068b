"""Fourier series of periodic states: order of coefficients, sampling tables, conversions, and samples between kinks.

Results list coefficients as mean, cos 1, sin 1, cos 2, sin 2, ... of the base phase. Inside the solvers they stand in
blocks, mean, cos 1..H, sin 1..H, because rows of the Jacobian are then contiguous Toeplitz and Hankel rows.

A torque with corners, sampled at equal steps, leaves in the balance equations a kink wherever a sample passes a
corner: false folds, and steps of a continuation as short as these kinks are near. Here the period is cut where the
motion crosses breakpoints, or turns where a law has memory, and every piece is integrated by Gauss's rule: the samples
move with the motion, and the equations are as smooth as the integrals are.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ...base.law import breakpoints_of, torsion
from ...base.protocols import System, lacking
from ...base.results import Floats
from ...base.series import remembered
from ...compile.jit import kernel_as, routine

PLACES, WEIGHTS = np.polynomial.legendre.leggauss(16)
PHASE = 6.0  # of the highest harmonic along a panel [rad]: products of four harmonics are integrated to 1e-10
LOOKED = 12  # places a harmonic at which crossings are looked for
TRIES, CLOSE = 20, 1e-11  # steps towards a crossing, and how near [rad]; the integrals err by the square of it


@remembered
def synthesis(harmonics: int, samples: int, stride: int = 1) -> Floats:
    """Table (2H+1, samples): row k times coefficient k (block order) sums to the samples of the series.

    With stride 2 the harmonics are the first H odd ones and the samples lie on half a turn.
    """
    angle = 2.0 * np.pi / stride * np.arange(samples) / samples
    k = orders(harmonics, stride)[:, None]
    return np.vstack([np.ones((1, samples)), np.cos(k * angle), np.sin(k * angle)])


@remembered
def analysis(harmonics: int, samples: int, stride: int = 1) -> Floats:
    """Table (samples, 2H+1) that turns samples into coefficients (block order); with stride 2 the mean is zero."""
    table = synthesis(harmonics, samples, stride) * (2.0 / samples)
    table[0] *= 0.5 if stride == 1 else 0.0
    return np.ascontiguousarray(table.T)


@lru_cache(maxsize=64)
def orders(harmonics: int, stride: int = 1) -> Any:
    """Array 1, 2, ..., H, or with stride 2 the first H odd numbers."""
    return 1 + stride * np.arange(harmonics)


def to_blocks(coefficients: Floats) -> Floats:
    """Reorder mean, cos 1, sin 1, ... (first axis) to mean, cos 1..H, sin 1..H."""
    return np.concatenate([coefficients[:1], coefficients[1::2], coefficients[2::2]])


def from_blocks(blocks: Floats) -> Floats:
    """Reorder mean, cos 1..H, sin 1..H (first axis) to mean, cos 1, sin 1, ..."""
    out = np.empty_like(blocks)
    h = len(blocks) // 2
    out[0], out[1::2], out[2::2] = blocks[0], blocks[1 : h + 1], blocks[h + 1 :]
    return out


def stretched(table: Floats, times: int) -> Floats:
    """Coefficients (2nH+1, states) over n periods of a motion that has these (2H+1, states) over one."""
    out = np.zeros((times * (len(table) - 1) + 1, table.shape[1]))
    out[0], out[2 * times - 1 :: 2 * times], out[2 * times :: 2 * times] = table[0], table[1::2], table[2::2]
    return out


def all_orders(series: Floats, stride: int) -> Floats:
    """Coefficients (points, in blocks) of a stride with those of the orders it leaves out."""
    if stride == 1:
        return series
    h = series.shape[1] // 2
    out = np.zeros((len(series), 4 * h - 1))
    out[:, 1 : 2 * h : 2], out[:, 2 * h :: 2] = series[:, 1 : h + 1], series[:, h + 1 :]
    return out


def spread(series: Floats, step: int) -> Floats:
    """Series (..., 2h+1) in blocks with harmonics `step`, 2 `step`, ..., as one with all (..., 2 step h + 1)."""
    if step == 1:
        return series
    h = series.shape[-1] // 2
    full = np.zeros((*series.shape[:-1], 2 * step * h + 1))
    full[..., 0] = series[..., 0]
    full[..., step : step * h + 1 : step] = series[..., 1 : h + 1]
    full[..., step * h + step :: step] = series[..., h + 1 :]
    return full


def gathered(series: Floats, step: int, h: int) -> Floats:
    """The first h of the harmonics `step`, 2 `step`, ... of series (..., 2H+1) in blocks, cut or filled up."""
    top = series.shape[-1] // 2
    result, n = np.zeros((*series.shape[:-1], 2 * h + 1)), min(h, top // step)
    result[..., 0] = series[..., 0]
    result[..., 1 : n + 1] = series[..., step : step * n + 1 : step]
    result[..., h + 1 : h + n + 1] = series[..., top + step : top + step * n + 1 : step]
    return result


def derivative(series: Floats) -> Floats:
    """Coefficients (..., 2H+1) of the derivatives of series in blocks."""
    h = series.shape[-1] // 2
    k = np.arange(1, h + 1)
    out = np.zeros_like(series)
    out[..., 1 : h + 1], out[..., h + 1 :] = k * series[..., h + 1 :], -k * series[..., 1 : h + 1]
    return out


def with_velocity(x: Floats, w: float) -> Floats:
    """Coefficients (2H+1, 2) of x and x' from those of x, with fundamental frequency w [rad/s]."""
    kw = w * orders(len(x) // 2)
    out = np.zeros((len(x), 2))
    out[:, 0] = x
    out[1::2, 1], out[2::2, 1] = kw * x[2::2], -kw * x[1::2]
    return out


def _multiply_rows_loops(gc: Floats, gs: Floats, h: int, stride: int, matrix: Floats) -> None:
    # gc[2H + j], gs[2H + j]: cosine and sine coefficients of the factor, extended evenly and oddly to negative j.
    o = 2 * h
    matrix[0, 0] = 0.5 * gc[o]
    with_mean = 1.0 if stride == 1 else 0.0
    for m in range(1, h + 1):
        matrix[0, m] = 0.5 * with_mean * gc[o + m]
        matrix[0, h + m] = 0.5 * with_mean * gs[o + m]
        matrix[m, 0] = with_mean * gc[o + m]
        matrix[h + m, 0] = with_mean * gs[o + m]
    for k in range(1, h + 1):
        t = o + k + 1 - stride
        for m in range(1, h + 1):
            matrix[k, m] = 0.5 * (gc[o + m - k] + gc[t + m])
            matrix[k, h + m] = 0.5 * (gs[t + m] + gs[o + m - k])
            matrix[h + k, m] = 0.5 * (gs[t + m] - gs[o + m - k])
            matrix[h + k, h + m] = 0.5 * (gc[o + m - k] - gc[t + m])


@kernel_as(_multiply_rows_loops)
def multiply_rows(gc: Floats, gs: Floats, h: int, stride: int, matrix: Floats) -> None:
    """Matrix that multiplies a series by the factor with extended coefficients gc, gs: Toeplitz plus Hankel blocks.

    With stride 2 the series has odd harmonics, the factor even ones, counted 0, 1, ... As Python also for many factors
    at once, along the last axis.
    """
    k = np.arange(1, h + 1)
    o = 2 * h
    difference, total = o + k[None, :] - k[:, None], o + k[None, :] + k[:, None] + 1 - stride
    n = 2 * h + 1
    mean = 1.0 if stride == 1 else 0.0
    matrix[..., 0, 0] = 0.5 * gc[..., o]
    matrix[..., 0, 1 : h + 1], matrix[..., 0, h + 1 : n] = 0.5 * mean * gc[..., o + k], 0.5 * mean * gs[..., o + k]
    matrix[..., 1 : h + 1, 0] = mean * gc[..., o + k]
    matrix[..., h + 1 : n, 0] = mean * gs[..., o + k]
    matrix[..., 1 : h + 1, 1 : h + 1] = 0.5 * (gc[..., difference] + gc[..., total])
    matrix[..., 1 : h + 1, h + 1 : n] = 0.5 * (gs[..., total] + gs[..., difference])
    matrix[..., h + 1 : n, 1 : h + 1] = 0.5 * (gs[..., total] - gs[..., difference])
    matrix[..., h + 1 : n, h + 1 : n] = 0.5 * (gc[..., difference] - gc[..., total])


def _extend_loops(even: Floats, odd: Floats, o: int, gc: Floats, gs: Floats) -> None:
    for j in range(o + 1):
        gc[o + j] = even[j]
        gc[o - j] = even[j]
        gs[o + j] = odd[j]
        gs[o - j] = -odd[j]


@kernel_as(_extend_loops)
def extend(even: Floats, odd: Floats, o: int, gc: Floats, gs: Floats) -> None:
    """Extend coefficients 0..o evenly and oddly to negative indices."""
    gc[o:], gc[:o] = even[: o + 1], even[o:0:-1]
    gs[o:], gs[:o] = odd[: o + 1], -odd[o:0:-1]


def extended(g: Floats, h: int) -> tuple[Floats, Floats]:
    """Coefficients (..., 4H+1) in blocks, 2H harmonics, extended evenly and oddly; the mean counts twice."""
    o = 2 * h
    gc, gs = np.empty((2, *g.shape))
    gc[..., o:], gc[..., :o] = g[..., : o + 1], g[..., o:0:-1]
    gs[..., o + 1 :], gs[..., :o] = g[..., o + 1 :], -g[..., :o:-1]
    gc[..., o], gs[..., o] = 2.0 * g[..., 0], 0.0
    return gc, gs


@routine
def extend_series(g: Floats, h: int, gc: Floats, gs: Floats) -> None:
    """Extend the coefficients g (blocks, 2H harmonics) to negative indices; the mean counts twice."""
    o = 2 * h
    extend(g, g[o:], o, gc, gs)
    gc[o] = 2.0 * g[0]
    gs[o] = 0.0


class Samples(NamedTuple):
    """Places psi (n,) [rad] of a period with their weights (n,), which add up to 1."""

    psi: Floats
    weights: Floats

    def basis(self, harmonics: int) -> Floats:
        """Table (2H+1, n): mean, cosines and sines at the samples."""
        turning = np.broadcast_to(np.exp(1j * self.psi), (harmonics, len(self.psi)))
        waves = np.cumprod(turning, axis=0)
        return np.concatenate([np.ones((1, len(self.psi))), waves.real, waves.imag])

    def analysis(self, basis: Floats) -> Floats:
        """Table (n, 2H+1) that turns samples into coefficients in blocks."""
        table = 2.0 * self.weights * basis
        table[0] *= 0.5
        return np.asarray(table.T)


def distances(system: Any, angles: Floats, y: Floats) -> Floats:
    """Distances (kinks, ...) from all corners of the laws in the states y (states, ...) at base angles [rad].

    A system tells them by `kinks(phase, y)`: what vanishes at a corner, the torsion less a breakpoint or, of a law with
    memory, a rate or an internal state. Else it has `breakpoints` of its torsion; one without kinks has none.
    """
    if not lacking(system, "kinks"):
        values = system.kinks(angles, tuple(y))
    else:
        u = torsion(system, angles, tuple(y))
        values = [u - b for b in breakpoints_of(system)]
    return np.array([np.broadcast_to(d, y.shape[1:]) for d in values], float)


def samples_between(system: System, y: Floats, turns: float) -> Samples:
    """Samples of a period of a motion, states with coefficients y (states, 2H+1), cut at its kinks."""
    first, width = pieces(system, y, turns, PHASE / (y.shape[1] // 2))
    psi = first[:, None] + 0.5 * width[:, None] * (1.0 + PLACES)
    return Samples(psi.ravel(), (width[:, None] * WEIGHTS / (4.0 * np.pi)).ravel())


def pieces(system: System, y: Floats, turns: float, longest: float) -> tuple[Floats, Floats]:
    """Starts and lengths (n,) [rad] of pieces of a period of a motion, none above `longest`, cut at its kinks."""
    return cut(crossings(system, float(turns), y), longest)


def cut(cuts: Floats, longest: float) -> tuple[Floats, Floats]:
    """Starts and lengths (n,) [rad] of pieces of a period, none above `longest`, between `cuts` in order."""
    ends = np.concatenate([cuts, [cuts[0] + 2.0 * np.pi]]) if len(cuts) else np.array([0.0, 2.0 * np.pi])
    return parted(ends[:-1], np.diff(ends), longest)[:2]


def parted(starts: Floats, lengths: Floats, longest: Any) -> tuple[Floats, Floats, Any]:
    """Starts and lengths (n,) of equal parts, none above `longest`, of every piece; and how many these are."""
    parts = np.maximum(1, np.ceil(lengths / longest)).astype(int)
    width = np.repeat(lengths / parts, parts)
    number = np.arange(len(width)) - np.repeat(np.cumsum(parts) - parts, parts)  # of a part in its piece
    return np.repeat(starts, parts) + width * number, width, parts


def panels(system: System, y: Floats, turns: float, wide: int) -> tuple[Floats, Floats, Floats]:
    """As `FirstOrder.places` for states with coefficients y (states, 2H+1), cut at the kinks of the motion."""
    h = y.shape[1] // 2
    samples = samples_between(system, y, turns)
    basis = samples.basis(wide * h)
    waves = np.concatenate([basis[: h + 1], basis[wide * h + 1 : (wide + 1) * h + 1]])
    return turns * samples.psi, waves, samples.analysis(basis)


def crossings(system: System, turns: float, y: Floats) -> Floats:
    """Places (n,) [rad], in order, where distances from corners change sign along a motion."""
    h = y.shape[1] // 2
    places = LOOKED * (h + 1)
    grid = 2.0 * np.pi * np.arange(places + 1) / places
    values = distances(system, turns * grid[:-1], y @ synthesis(h, places))
    values = np.concatenate([values, values[:, :1]], axis=1)
    kink, i = np.nonzero((values[:, 1:] < 0.0) != (values[:, :-1] < 0.0))
    rows = np.arange(len(i))

    def f(psi: Floats) -> Floats:
        return np.asarray(distances(system, turns * psi, y @ Samples(psi, psi).basis(h))[kink, rows])

    return np.sort(false_position(f, grid[i], grid[i + 1], values[kink, i], values[kink, i + 1]))


def false_position(function: Callable[[Floats], Floats], low: Floats, high: Floats, first: Floats, last: Any) -> Floats:
    """Places (n,) [rad] in [0, 2 pi) between `low` and `high` where functions change sign (Illinois).

    `function` gives all of them at such places; `first` and `last` are their values at the ends.
    """
    side, psi = np.zeros(len(low)), low
    for _ in range(TRIES):
        before, psi = psi, (low * last - high * first) / (last - first)
        value = function(psi)
        same = value * first > 0.0
        last = np.where(same & (side > 0.0), 0.5 * last, last)
        first = np.where(~same & (side < 0.0), 0.5 * first, first)
        low, first = np.where(same, psi, low), np.where(same, value, first)
        high, last = np.where(same, high, psi), np.where(same, last, value)
        side = np.where(same, 1.0, -1.0)
        if np.all(np.abs(psi - before) < CLOSE) or not np.all(last != first):
            break
    return np.asarray(psi % (2.0 * np.pi))
