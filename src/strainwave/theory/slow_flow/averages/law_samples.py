"""Torque of a law at samples along many motions, and its harmonics, block by block so that all fits the cache."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from ....base.results import Complexes, Floats
from ....base.series import remembered
from ....compile.jit import run
from ....numerics.addressed import law_by_address

BLOCK = 1 << 15  # samples at once: a quarter of a megabyte
SEVERAL = 1000  # blocks in NumPy, a second of them, before they are compiled
FEW_WAVES = 24  # waves, which products with tables of them take sooner than Fourier's fast transform
Places = tuple[Any, ...]  # multiples of each angle in some waves; those of the last are not negative


@remembered
def waves_at(n: int, harmonics: tuple[int, ...]) -> Floats:
    """Cosines and sines (2, harmonics, n) of n points of a period."""
    angle = np.outer(harmonics, 2.0 * math.pi * np.arange(n) / n)
    return np.stack([np.cos(angle), np.sin(angle)])


def samples(c: Complexes, places: Places, points: tuple[int, ...]) -> Floats:
    """Samples (motions, *points) of Re(sum of c times waves) over the turns of one or two angles, c (motions, waves).

    No wave comes twice, and in each angle there are more than two samples a period.
    """
    if len(points) == 1 and len(places[0]) <= FEW_WAVES:
        cosine, sine = waves_at(points[0], tuple(places[0].tolist()))
        return np.asarray(c.real @ cosine - c.imag @ sine)
    spectrum = np.zeros((len(c), *points[:-1], points[-1] // 2 + 1), complex)
    spectrum[:, *places] = np.where(places[-1] == 0, 1.0, 0.5) * c
    return np.fft.irfftn(spectrum, points, tuple(range(1, spectrum.ndim)), "forward")


def means(values: Floats, places: Places) -> Complexes:
    """Means (motions, waves) of samples (motions, *points) times the conjugates of waves."""
    if values.ndim == 2 and len(places[0]) <= FEW_WAVES:
        cosine, sine = waves_at(values.shape[1], tuple(places[0].tolist()))
        return np.asarray((values @ cosine.T - 1j * (values @ sine.T)) / values.shape[1])
    spectrum = np.fft.rfftn(values, axes=tuple(range(1, values.ndim)), norm="forward")
    return np.asarray(spectrum[:, *places])


def harmonics(
    values: Callable[..., None], law: Any, c: Complexes, along: Places, onto: Places, points: tuple[int, ...],
    origin: tuple[float, float] = (0.0, 0.0),
) -> Complexes:  # fmt: skip
    """Means of what a law gives along motions, times the conjugates of waves.

    Parameters
    ----------
    values : function
        `torques` or `stiffnesses`.
    c : (motions, k) complex array
        Amplitudes [rad] of the motions u = Re(sum of c times waves).
    along, onto : tuples of int arrays
        Places of the k waves of the motions, and of the m waves of the means.
    points : tuple of int
        Samples over the turn of each angle.
    origin : (float, float)
        Torsion [rad] from which u counts, and value that is taken off.

    Returns
    -------
    (motions, m) complex array
        Means [N*m or N*m/rad].
    """
    result = np.empty((len(c), len(onto[-1])), complex)
    torsion, value = origin
    block = max(1, BLOCK // math.prod(points))
    for rows in (slice(i, i + block) for i in range(0, len(c), block)):
        u = torsion + samples(c[rows], along, points)
        outputs = np.empty(u.shape)
        run(values, law_by_address(law), u.ravel(), outputs.ravel(), after=SEVERAL)
        result[rows] = means(outputs - value, onto)
    return result
