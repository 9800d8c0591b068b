"""Fourier series of periodic states: order of coefficients, sampling tables, and conversions.

Results list coefficients as mean, cos 1, sin 1, cos 2, sin 2, ... of the base phase. Inside the solvers they stand in
blocks, mean, cos 1..H, sin 1..H, because rows of the Jacobian are then contiguous Toeplitz and Hankel rows.
"""

from functools import lru_cache
from typing import Any

import numpy as np

from ...compile.jit import kernel_as, routine
from ...results import Floats


@lru_cache(maxsize=64)
def synthesis(harmonics: int, samples: int, stride: int = 1) -> Floats:
    """Table (2H+1, samples): row k times coefficient k (block order) sums to the samples of the series.

    With stride 2 the harmonics are the first H odd ones and the samples lie on half a turn.
    """
    angle = 2.0 * np.pi / stride * np.arange(samples) / samples
    k = orders(harmonics, stride)[:, None]
    return np.vstack([np.ones((1, samples)), np.cos(k * angle), np.sin(k * angle)])


@lru_cache(maxsize=64)
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


def derivative(series: Floats) -> Floats:
    """Coefficients (states, 2H+1) of the derivatives of series in blocks."""
    h = series.shape[1] // 2
    k = np.arange(1, h + 1)
    out = np.zeros_like(series)
    out[:, 1 : h + 1], out[:, h + 1 :] = k * series[:, h + 1 :], -k * series[:, 1 : h + 1]
    return out


def with_velocity(x: Floats, w: float) -> Floats:
    """Coefficients (2H+1, 2) of x and x' from those of x, with fundamental frequency w [rad/s]."""
    kw = w * orders(len(x) // 2)
    out = np.zeros((len(x), 2))
    out[:, 0] = x
    out[1::2, 1], out[2::2, 1] = kw * x[2::2], -kw * x[1::2]
    return out


def _multiply_rows_loops(gc: Any, gs: Any, h: int, stride: int, out: Any) -> None:
    # gc[2H + j], gs[2H + j]: cosine and sine coefficients of the factor, extended evenly and oddly to negative j.
    o = 2 * h
    out[0, 0] = 0.5 * gc[o]
    with_mean = 1.0 if stride == 1 else 0.0
    for m in range(1, h + 1):
        out[0, m] = 0.5 * with_mean * gc[o + m]
        out[0, h + m] = 0.5 * with_mean * gs[o + m]
        out[m, 0] = with_mean * gc[o + m]
        out[h + m, 0] = with_mean * gs[o + m]
    for k in range(1, h + 1):
        t = o + k + 1 - stride
        for m in range(1, h + 1):
            out[k, m] = 0.5 * (gc[o + m - k] + gc[t + m])
            out[k, h + m] = 0.5 * (gs[t + m] + gs[o + m - k])
            out[h + k, m] = 0.5 * (gs[t + m] - gs[o + m - k])
            out[h + k, h + m] = 0.5 * (gc[o + m - k] - gc[t + m])


@kernel_as(_multiply_rows_loops)
def multiply_rows(gc: Any, gs: Any, h: int, stride: int, out: Any) -> None:
    """Matrix that multiplies a series by the factor with extended coefficients gc, gs: Toeplitz plus Hankel blocks.

    With stride 2 the series has odd harmonics, the factor even ones, counted 0, 1, ... As Python also for many factors
    at once, along the last axis.
    """
    k = np.arange(1, h + 1)
    o = 2 * h
    difference, total = o + k[None, :] - k[:, None], o + k[None, :] + k[:, None] + 1 - stride
    n = 2 * h + 1
    mean = 1.0 if stride == 1 else 0.0
    out[..., 0, 0] = 0.5 * gc[..., o]
    out[..., 0, 1 : h + 1], out[..., 0, h + 1 : n] = 0.5 * mean * gc[..., o + k], 0.5 * mean * gs[..., o + k]
    out[..., 1 : h + 1, 0], out[..., h + 1 : n, 0] = mean * gc[..., o + k], mean * gs[..., o + k]
    out[..., 1 : h + 1, 1 : h + 1] = 0.5 * (gc[..., difference] + gc[..., total])
    out[..., 1 : h + 1, h + 1 : n] = 0.5 * (gs[..., total] + gs[..., difference])
    out[..., h + 1 : n, 1 : h + 1] = 0.5 * (gs[..., total] - gs[..., difference])
    out[..., h + 1 : n, h + 1 : n] = 0.5 * (gc[..., difference] - gc[..., total])


def _extend_loops(even: Any, odd: Any, o: int, gc: Any, gs: Any) -> None:
    for j in range(o + 1):
        gc[o + j] = even[j]
        gc[o - j] = even[j]
        gs[o + j] = odd[j]
        gs[o - j] = -odd[j]


@kernel_as(_extend_loops)
def extend(even: Any, odd: Any, o: int, gc: Any, gs: Any) -> None:
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
def extend_series(g: Any, h: int, gc: Any, gs: Any) -> None:
    """Extend the coefficients g (blocks, 2H harmonics) to negative indices; the mean counts twice."""
    o = 2 * h
    extend(g, g[o:], o, gc, gs)
    gc[o] = 2.0 * g[0]
    gs[o] = 0.0
