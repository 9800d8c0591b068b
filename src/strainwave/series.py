"""The largest value over a period, between all samples: of a Fourier series, and of any values.

Coefficients are listed as results have them: mean, cos 1, sin 1, cos 2, sin 2, ...
"""

import numpy as np
from numpy.typing import NDArray

PER_HARMONIC, STEPS = 32, 3  # samples in a period of the highest harmonic; steps of Newton's method from the largest


def largest_size(coefficients: NDArray[np.float64]) -> NDArray[np.float64]:
    """Largest absolute values (n,) over the period of series (n, 2H+1), the sizes at their extremes."""
    count, width = coefficients.shape
    harmonics = width // 2
    if not harmonics or not count:
        return np.asarray(np.abs(coefficients[:, 0]))
    spectrum = np.zeros((count, PER_HARMONIC * harmonics // 2 + 1), complex)
    spectrum[:, 0] = coefficients[:, 0]
    waves = coefficients[:, 1::2] - 1j * coefficients[:, 2::2]
    spectrum[:, 1 : harmonics + 1] = 0.5 * waves
    samples = np.fft.irfft(spectrum, PER_HARMONIC * harmonics, norm="forward")
    best = np.argmax(np.abs(samples), axis=1)
    sampled = np.abs(samples[np.arange(count), best])
    # Between the samples: Newton's method for a zero of the slope, a step never further than to the next sample.
    k, step = np.arange(1, harmonics + 1), 2.0 * np.pi / (PER_HARMONIC * harmonics)
    angle = step * best
    for _ in range(STEPS):
        here = waves * _turned(angle, harmonics)
        slope, bend = np.sum(-k * here.imag, axis=1), np.sum(-k * k * here.real, axis=1)
        angle -= np.clip(np.divide(slope, bend, out=np.zeros(count), where=bend != 0.0), -step, step)
    between = np.abs(coefficients[:, 0] + np.sum((waves * _turned(angle, harmonics)).real, axis=1))
    return np.asarray(np.maximum(sampled, between))


def _turned(angle: NDArray[np.float64], harmonics: int) -> NDArray[np.complex128]:
    """Powers exp(i k angle) (n, harmonics) of k = 1, 2, ..."""
    powers = np.empty((len(angle), harmonics), complex)
    powers[:, 0] = turn = np.exp(1j * angle)
    for k in range(1, harmonics):
        np.multiply(powers[:, k - 1], turn, out=powers[:, k])
    return powers


def oscillation(coefficients: NDArray[np.float64]) -> NDArray[np.float64]:
    """Largest distances (n,) from the mean over the period of series (n, 2H+1)."""
    waves = coefficients.copy()
    waves[:, 0] = 0.0
    return largest_size(waves)


def largest_of_samples(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Largest absolute values (n,) over a period of what has these samples (n, places), equally spaced.

    That is the vertex of the parabola through the largest sample and those beside it, or that sample where the bends
    there and next to it differ by more than a factor of 2, as beside a jump or a corner.
    """
    sizes = np.abs(values)
    places = np.argmax(sizes, axis=1)[:, None] + np.arange(-2, 3)
    near = np.take_along_axis(sizes, places % sizes.shape[1], axis=1)
    bends = 2.0 * near[:, 1:4] - near[:, :3] - near[:, 2:]
    low, high = np.min(bends, axis=1), np.max(bends, axis=1)
    smooth = (low > 0.0) & (high <= 2.0 * low)
    rise = (near[:, 3] - near[:, 1]) ** 2 / (8.0 * np.where(smooth, bends[:, 1], 1.0))
    return np.asarray(near[:, 2] + np.where(smooth, rise, 0.0))
