"""Whether other orbits may exist beside those of a condensed problem, from what one harmonic allows."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....results import Floats
from ..fourier import orders
from ..one_harmonic import others_possible
from ..rates import base_speed
from .pencil import condense, to_complex


def several_at(problem: Any, points: Floats) -> NDArray[np.bool_]:
    """Whether others may exist beside known orbits, as `one_harmonic.several_at` with the dynamic stiffness of all."""
    part = problem.part
    if len(part.laws) > 1:
        return np.ones(len(points), bool)
    pencil, n = problem.pencil._replace(kept=1), len(part.inertia)
    s = np.empty((len(points), *problem.stiff[0].shape), complex)
    omega = base_speed(problem, points[:, -1])
    condense(pencil, omega, 1.0, s, np.empty_like(s))
    k = orders(problem.harmonics())
    gear = problem.gear_damping * pencil.rate * omega[:, None] * k
    stiff = s[:, 1:, 0, 0] + 1j * gear
    driven = np.abs(s[:, 1:, 0, n] - s[:, 1:, 0, 0] * to_complex(problem.gear.error)[1:])
    mean = float(np.mean(s[:, 0, 0, n].real))
    u = problem.series(points)[:, 0]
    return others_possible(part.laws[0], mean, u, problem.synthesis, -stiff.real, stiff.imag, driven, 2 * k)
