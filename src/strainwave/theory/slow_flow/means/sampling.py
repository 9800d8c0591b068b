"""The torque of a law at samples along many motions, and its harmonics, block by block so that all fits the cache."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ....base.results import Floats
from ....compile.jit import run
from ....numerics.addressed import law_by_address
from ..setting import Complexes

Matrices = tuple[Floats, Floats]
BLOCK = 1 << 15  # samples at once: a quarter of a megabyte
SEVERAL = 1000  # blocks in NumPy, a second of them, before they are compiled


def along(waves: Complexes) -> Matrices:
    """Real matrices (k, n) that amplitudes of waves (k, n) are multiplied with: half of a complex product is lost."""
    return waves.real.copy(), -waves.imag


def onto(waves: Complexes) -> Matrices:
    """Real matrices (n, m) that give the means of samples times the conjugates of waves (m, n)."""
    return waves.real.T.copy(), -waves.imag.T


def harmonics(
    values: Callable[..., None], law: Any, c: Complexes, waves: Matrices, conjugates: Matrices,
    origin: tuple[float, float] = (0.0, 0.0),
) -> Complexes:  # fmt: skip
    """Means of what a law gives along motions, times the conjugates of waves.

    Parameters
    ----------
    values : function
        `torques` or `stiffnesses`.
    c : (motions, k) complex array
        Amplitudes [rad] of the motions u = Re(sum of c times waves).
    waves, conjugates : pairs of (k, n) and of (n, m) arrays
        Waves at the n sample points by `along`, and those of the means by `onto`.
    origin : (float, float)
        Torsion [rad] from which u counts, and value that is taken off.

    Returns
    -------
    (motions, m) complex array
        Means [N*m or N*m/rad].
    """
    (cosine, sine), (even, odd) = waves, conjugates
    found = np.empty((len(c), even.shape[1]), complex)
    torsion, value = origin
    block = max(1, BLOCK // len(even))
    for some in (slice(i, i + block) for i in range(0, len(c), block)):
        u = c.real[some] @ cosine + c.imag[some] @ sine
        given = values_along(values, law, torsion + u) - value
        found.real[some], found.imag[some] = given @ even, given @ odd
    found /= len(even)
    return found


def values_along(values: Callable[..., None], law: Any, u: Floats) -> Floats:
    """What `torques` or `stiffnesses` gives at torsions [rad] of any shape."""
    out = np.empty_like(u)
    run(values, law_by_address(law), u.ravel(), out.ravel(), after=SEVERAL)
    return out
