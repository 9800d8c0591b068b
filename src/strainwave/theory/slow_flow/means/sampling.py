"""The torque of a law at samples along many motions, and its harmonics, block by block so that all fits the cache."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ....compile.jit import run
from ....numerics.addressed import law_by_address
from ....results import Floats
from ..setting import Complexes

BLOCK = 1 << 15  # samples at once: a quarter of a megabyte
SEVERAL = 1000  # blocks in NumPy, a second of them, before they are compiled


def harmonics(
    values: Callable[..., None], law: Any, c: Complexes, waves: Complexes, onto: Complexes,
    origin: tuple[float, float] = (0.0, 0.0),
) -> Complexes:  # fmt: skip
    """Means of what a law gives along motions, times the conjugates of waves.

    Parameters
    ----------
    values : function
        `torques` or `stiffnesses`.
    c : (motions, k) complex array
        Amplitudes [rad] of the motions u = Re(sum of c times waves).
    waves, onto : (k, n) and (m, n) complex arrays
        Waves at the n sample points.
    origin : (float, float)
        Torsion [rad] from which u counts, and value that is taken off.

    Returns
    -------
    (motions, m) complex array
        Means [N*m or N*m/rad].
    """
    found = np.empty((len(c), len(onto)), complex)
    # products of real matrices: half of a complex product would be thrown away
    cosine, sine, even, odd = waves.real.copy(), -waves.imag, onto.real.T.copy(), -onto.imag.T
    torsion, value = origin
    block = max(1, BLOCK // waves.shape[1])
    for some in (slice(i, i + block) for i in range(0, len(c), block)):
        u = c.real[some] @ cosine + c.imag[some] @ sine
        along = values_along(values, law, torsion + u) - value
        found.real[some], found.imag[some] = along @ even, along @ odd
    found /= waves.shape[1]
    return found


def values_along(values: Callable[..., None], law: Any, u: Floats) -> Floats:
    """What `torques` or `stiffnesses` gives at torsions [rad] of any shape."""
    out = np.empty_like(u)
    run(values, law_by_address(law), u.ravel(), out.ravel(), after=SEVERAL)
    return out
