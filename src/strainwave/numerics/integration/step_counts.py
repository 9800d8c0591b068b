"""How many fixed steps a period each lane of an ensemble needs: enough for the fastest time scale that it meets."""

from typing import Any

import numpy as np

from ...base.results import Floats

LADDER = np.unique(4 * np.ceil(16.0 * 2.0 ** (np.arange(60) / 3.0) / 4.0).astype(int))  # 16, 24, 28, 32, 44, ...
PLACES = np.linspace(-1.0, 1.0, 33)  # of the torsion, in units of its largest value


def fastest_rates(system: Any, reach: Floats) -> Floats:
    """Largest modulus (lanes,) [1/s] of the eigenvalues of the Jacobian for torsions up to `reach` (lanes,)."""
    with np.errstate(all="ignore"):
        x = PLACES[:, None] * reach[None, :]
        rows = system.jacobian(0.0, (x, np.zeros_like(x)))
        stiffness, damping = (-np.broadcast_to(np.asarray(entry, float), x.shape) for entry in rows[1])
        half = 0.5 * np.abs(damping)
        fast = np.where(half * half > stiffness, half + np.sqrt(np.abs(half * half - stiffness)), np.sqrt(stiffness))
    return np.asarray(np.max(np.where(np.isfinite(fast), fast, 0.0), axis=0))


def steps_needed(per_scale: int, fastest: Floats, omega: Floats, order: int) -> Any:
    """Steps a period (lanes,) for `per_scale` steps per shortest time scale, from a ladder of few numbers."""
    wanted = per_scale * np.maximum(fastest / omega, order)
    return LADDER[np.minimum(np.searchsorted(LADDER, wanted), len(LADDER) - 1)]
