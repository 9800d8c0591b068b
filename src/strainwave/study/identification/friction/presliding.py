"""Stiffness of LuGre's bristles from a loop below break-away.

Slowly, the bristles follow dz/dx = 1 - sigma_0 z sign(v)/T_s (Dahl's equation), which is Bouc-Wen with beta = 1 and
gamma = 0, yield twist T_s/sigma_0. Canudas de Wit, Olsson, Astrom & Lischinsky 1995, IEEE Trans. Automatic Control
40(3), eqs. (3), (4).
"""

from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import least_squares

from ....quantities import shown
from ....results import Floats
from ..loops.loop_model import states
from ..loops.loop_path import read_loop
from ..loops.restricted import restricted

DAHL = 1.0  # beta - gamma
MOST = 0.98  # of the break-away torque


class Presliding(NamedTuple):
    """Stiffness [N*m/rad] of the bristles, its standard deviation and the degrees of freedom of that."""

    sigma_0: float
    deviation: float
    freedom: float


def presliding_stiffness(measured: Any, breakaway: float) -> Presliding:
    """Fit sigma_0 to a slow loop, a pair of (n,) arrays [rad], [N*m], below a break-away torque [N*m].

    Raises
    ------
    ValueError
        If it is no pair of arrays, the samples are no loop, or it reaches the break-away torque.
    """
    try:
        angle, torque = measured
    except (TypeError, ValueError):
        raise ValueError(
            f"presliding is {shown(measured)}; give a pair, the angles [rad] and the torques [N*m] of a slow loop"
        ) from None
    loop = read_loop(angle, torque, check_units=False)
    reach = 0.5 * float(np.ptp(loop.torque))
    if reach > MOST * breakaway:
        raise ValueError(
            f"the presliding loop reaches {reach:.4g} N*m and the shaft breaks away at {breakaway:.4g} N*m; give a "
            "loop that stays below"
        )

    def value(p: Floats) -> Floats:
        sigma = float(np.exp(p[0]))
        twist = breakaway / sigma
        bristles = states(loop.path, loop.torsion, 1, twist, DAHL, float(np.tanh(p[1])))
        return np.asarray(breakaway * (bristles + p[2]))

    slope = float(np.polyfit(loop.torsion, loop.torque, 1)[0])
    found = least_squares(lambda p: (loop.torque - value(p)) / breakaway, [np.log(1.5 * slope), 0.0, 0.0], method="lm")
    scale = restricted(-found.jac, found.fun)
    sigma = float(np.exp(found.x[0]))
    return Presliding(sigma, sigma * float(scale.covariance[0, 0]) ** 0.5, float(np.min(scale.freedom)))
