"""Fourier series of periodic states: order of coefficients, sampling tables, and conversions.

Results list coefficients as mean, cos 1, sin 1, cos 2, sin 2, ... of the base phase. Inside the solvers they stand in
blocks, mean, cos 1..H, sin 1..H, because rows of the Jacobian are then contiguous Toeplitz and Hankel rows.
"""

import numpy as np

from ..results import Floats


def synthesis(harmonics: int, samples: int) -> Floats:
    """Table (2H+1, samples): row k times coefficient k (block order) sums to the samples of the series."""
    angle = 2.0 * np.pi * np.arange(samples) / samples
    k = np.arange(1, harmonics + 1)[:, None]
    return np.vstack([np.ones((1, samples)), np.cos(k * angle), np.sin(k * angle)])


def analysis(harmonics: int, samples: int) -> Floats:
    """Table (samples, 2H+1) that turns samples into coefficients (block order)."""
    table = synthesis(harmonics, samples) * (2.0 / samples)
    table[0] *= 0.5
    return np.ascontiguousarray(table.T)


def to_blocks(coefficients: Floats) -> Floats:
    """Reorder mean, cos 1, sin 1, ... (first axis) to mean, cos 1..H, sin 1..H."""
    return np.concatenate([coefficients[:1], coefficients[1::2], coefficients[2::2]])


def from_blocks(blocks: Floats) -> Floats:
    """Reorder mean, cos 1..H, sin 1..H (first axis) to mean, cos 1, sin 1, ..."""
    out = np.empty_like(blocks)
    h = len(blocks) // 2
    out[0], out[1::2], out[2::2] = blocks[0], blocks[1 : h + 1], blocks[h + 1 :]
    return out
