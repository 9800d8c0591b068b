"""Half-wave symmetry: a smooth odd law under odd orders lets the second half of a turn be minus the first.

The orbits then have odd harmonics alone, and a curve of them is followed with half the unknowns and samples.
"""

from typing import Any

import numpy as np

from ...results import Floats
from ...tree import with_leaf
from .second_order import Sampling, SecondOrder, second_order

TWISTS = np.geomspace(1e-9, 1e6, 46)  # [rad]


def odd_problem(problem: Any) -> SecondOrder | None:
    """Problem of the odd harmonics alone, or None where the symmetry is not seen.

    The law is asked at torsions of all sizes; whether it is odd on the orbits found is for `is_odd_on` to say.
    """
    if problem.turns != 1 or not isinstance(getattr(problem, "nonlinear", None), Sampling):
        return None
    h, law = len(problem.tau) // 2, problem.system.law
    with np.errstate(all="ignore"):
        odd = _odd(law.torque(TWISTS), law.torque(-TWISTS))
    if not odd or not all(_is_odd_series(series, h) for series in (problem.tau, problem.error)):
        return None
    return second_order(problem.system, problem.leaf, problem.omega_leaf, h, 1, 2)


def is_odd_on(problem: SecondOrder, points: Floats) -> bool:
    """Whether the law is odd at the torsions of the orbits found (coefficients in blocks, parameter last)."""
    some = points[::3]  # neighbours have next to the same torsions
    u = some[:, :-1] @ problem.synthesis
    law = with_leaf(problem.system, problem.leaf, some[:, -1:]).law
    return _odd(law.torque(u), law.torque(-u))


def _is_odd_series(series: Floats, h: int) -> bool:
    """Whether the mean and the even harmonics (in blocks) are rounding."""
    sizes = [abs(value) for value in series.tolist()]
    return bool(max(sizes[:1] + sizes[2 : h + 1 : 2] + sizes[h + 2 :: 2]) <= 1e-14 * max(sizes))


def _odd(there: Any, back: Any) -> bool:
    return not np.any(np.abs(there + back) > 1e-12 * np.abs(there))
