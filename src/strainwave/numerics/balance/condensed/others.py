"""Whether other orbits may exist beside those of a condensed problem, from what one harmonic allows."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....results import Floats
from ..fourier import orders
from ..one_harmonic import LEAST_LINE, STRONG, others_possible, strength_beyond_folds
from ..rates import base_speed
from .pencil import condense, to_complex


def several_at(problem: Any, points: Floats) -> NDArray[np.bool_]:
    """Whether others may exist beside known orbits, as `one_harmonic.several_at` with the dynamic stiffness of all."""
    law, *more = problem.part.laws
    if more:
        return np.ones(len(points), bool)
    mean, stiff, driven = _around_the_gear(problem, base_speed(problem, points[:, -1]))
    u, k = problem.series(points)[:, 0], orders(problem.harmonics())
    return others_possible(law, float(np.mean(mean)), u, problem.synthesis, -stiff.real, stiff.imag, driven, 2 * k)


def strongest(problem: Any) -> float:
    """Factor of the strength at which every line alone has passed its last fold, by one harmonic."""
    law, *more = problem.part.laws
    mean, stiff, driven = (values[0] for values in _around_the_gear(problem, np.array([problem.omega])))
    lines = np.flatnonzero(driven > LEAST_LINE * np.max(driven))
    if more or not len(lines):
        return STRONG
    return strength_beyond_folds(law, float(mean), -stiff.real[lines], stiff.imag[lines], driven[lines])


def _around_the_gear(problem: Any, omega: Floats) -> tuple[Floats, Any, Floats]:
    """Mean torque (points,) of the gear; dynamic stiffness around it and amplitudes [N*m] driving it (points, h)."""
    pencil, n = problem.pencil._replace(kept=1), len(problem.part.inertia)
    s = np.empty((len(omega), *problem.stiff[0].shape), complex)
    with np.errstate(all="ignore"):
        condense(pencil, omega, 1.0, s, np.empty_like(s))
    k = orders(problem.harmonics())
    stiff = s[:, 1:, 0, 0] + 1j * problem.gear_damping * pencil.rate * omega[:, None] * k
    driven = np.abs(s[:, 1:, 0, n] - s[:, 1:, 0, 0] * to_complex(problem.gear.error)[1:])
    return s[:, 0, 0, n].real, stiff, driven
