"""The largest value of a Fourier series over its period, between all samples.

Coefficients are listed as results have them: mean, cos 1, sin 1, cos 2, sin 2, ...
"""

import numpy as np
from numpy.typing import NDArray

PER_HARMONIC, STEPS = 32, 4  # samples in a period of the highest harmonic; steps of Newton's method from the largest


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
        here = waves * np.exp(1j * k * angle[:, None])
        slope, bend = np.sum(-k * here.imag, axis=1), np.sum(-k * k * here.real, axis=1)
        angle -= np.clip(np.divide(slope, bend, out=np.zeros(count), where=bend != 0.0), -step, step)
    between = np.abs(coefficients[:, 0] + np.sum((waves * np.exp(1j * k * angle[:, None])).real, axis=1))
    return np.asarray(np.maximum(sampled, between))


def oscillation(coefficients: NDArray[np.float64]) -> NDArray[np.float64]:
    """Largest distances (n,) from the mean over the period of series (n, 2H+1)."""
    waves = coefficients.copy()
    waves[:, 0] = 0.0
    return largest_size(waves)
