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
    """Problem of the odd harmonics alone, of a law with samples; or None where the symmetry is not seen."""
    if not isinstance(getattr(problem, "nonlinear", None), Sampling) or not is_half_wave(problem):
        return None
    return second_order(problem.system, problem.leaf, problem.omega_leaf, len(problem.tau) // 2, 1, 2)


def is_half_wave(problem: SecondOrder) -> bool:
    """Whether a problem has the symmetry.

    The law is asked at torsions of all sizes; whether it is odd on the orbits found is for `is_odd_on` to say.
    """
    h, law = len(problem.tau) // 2, problem.system.law
    with np.errstate(all="ignore"):
        odd = problem.turns == 1 and _odd(law.torque(TWISTS), law.torque(-TWISTS))
    return odd and all(_is_odd_series(series, h) for series in (problem.tau, problem.error))


def mirrored(point: Floats) -> Floats:
    """The motion -u(phase - pi) of a point (all coefficients in blocks, parameter last): its even harmonics turn."""
    h = len(point) // 2 - 1
    sign = np.where(np.arange(h + 1) % 2 == 1, 1.0, -1.0)
    return np.asarray(point * np.concatenate([sign, sign[1:], [1.0]]))


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
