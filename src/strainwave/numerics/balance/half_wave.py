"""Half-wave symmetry: a smooth odd law under odd orders lets the second half of a turn be minus the first.

The orbits then have odd harmonics alone, and a curve of them is followed with half the unknowns and samples.
"""

from typing import Any

import numpy as np

from ...results import Floats
from ...tree import with_leaf

TWISTS = np.geomspace(1e-9, 1e6, 46)  # [rad]


def seems_odd(law: Any, *series: Floats) -> bool:
    """Whether a law is odd at torsions of all sizes, and series (in blocks) have odd harmonics alone.

    Whether the law is odd on the orbits found is for `is_odd_on` to say.
    """
    with np.errstate(all="ignore"):
        odd = _odd(law.torque(TWISTS), law.torque(-TWISTS))
    return odd and all(map(_is_odd_series, series))


def mirrored(point: Floats) -> Floats:
    """The motion -u(phase - pi) of a point (all coefficients in blocks, parameter last): its even harmonics turn."""
    h = len(point) // 2 - 1
    sign = np.where(np.arange(h + 1) % 2 == 1, 1.0, -1.0)
    return np.asarray(point * np.concatenate([sign, sign[1:], [1.0]]))


def is_odd_on(problem: Any, points: Floats) -> bool:
    """Whether the law is odd at the torsions of the orbits found (coefficients in blocks, parameter last)."""
    some = points[::3]  # neighbours have next to the same torsions
    u = some[:, :-1] @ problem.synthesis
    law = with_leaf(problem.system, problem.leaf, some[:, -1:]).law
    return _odd(law.torque(u), law.torque(-u))


def _is_odd_series(series: Floats) -> bool:
    """Whether the mean and the even harmonics are rounding."""
    h, sizes = len(series) // 2, [abs(value) for value in series.tolist()]
    return bool(max(sizes[:1] + sizes[2 : h + 1 : 2] + sizes[h + 2 :: 2]) <= 1e-14 * max(sizes))


def _odd(there: Any, back: Any) -> bool:
    return not np.any(np.abs(there + back) > 1e-12 * np.abs(there))
