"""Where the solvers start: the linear response about the operating point of the mean torque."""

from typing import Any

import numpy as np

from .._jit import with_leaf
from ..results import Floats
from .fourier import orders


def operating_point(law: Any, torque: float) -> float:
    """Torsion [rad] at which the law carries a mean torque [N*m]; 0 where it does not matter."""
    low, high = -1e-6, 1e-6
    if abs(float(law.torque(0.0)) - torque) <= 1e-14 * abs(torque):
        return 0.0
    for _ in range(80):
        if (float(law.torque(low)) - torque) * (float(law.torque(high)) - torque) <= 0.0:
            break
        low, high = 2.0 * low, 2.0 * high
    else:
        return 0.0
    rising = float(law.torque(high)) > torque
    for _ in range(100):
        middle = 0.5 * (low + high)
        if (float(law.torque(middle)) > torque) == rising:
            high = middle
        else:
            low = middle
    return 0.5 * (low + high)


def linear_response(problem: Any, value: float) -> Floats:
    """Guess (coefficients in blocks, parameter): the steady response of the law's tangent at the operating point."""
    if hasattr(problem, "linear_response"):
        with np.errstate(all="ignore"):
            return np.asarray(problem.linear_response(value))
    system = with_leaf(problem.system, problem.leaf, float(value))
    n = len(problem.tau)
    h = n // 2
    tau, error = problem.tau, problem.error
    if problem.leaf != problem.omega_leaf:
        angles = problem.angles
        tau = np.broadcast_to(np.asarray(system.excitation.torque(angles), float), angles.shape) @ problem.analysis
        error = np.broadcast_to(np.asarray(system.error.value(angles), float), angles.shape) @ problem.analysis
    z = np.zeros(n + 1)
    z[n] = value
    z[0] = operating_point(system.law, float(tau[0]))
    stiffness = float(system.law.stiffness(z[0]))
    w = orders(h, problem.stride) * system.omega / problem.turns
    drive = (tau[1 : h + 1] + system.J * w * w * error[1 : h + 1]) - 1j * (
        tau[h + 1 :] + system.J * w * w * error[h + 1 :]
    )
    bottom = stiffness - system.J * w * w + 1j * system.B * w
    least = 1e-9 * (abs(stiffness) + system.J * w * w)  # exactly at a resonance without damping there is no response
    response = drive / np.where(np.abs(bottom) < least, least, bottom)
    z[1 : h + 1], z[h + 1 : n] = response.real, -response.imag
    return z


def error_coefficients(problem: Any, values: Floats) -> Floats:
    """Coefficients (values, 2H+1) in blocks of the kinematic error for each value of the problem's parameter."""
    angles = problem.angles
    return np.array(
        [
            np.broadcast_to(with_leaf(problem.system, problem.leaf, float(v)).error.value(angles), angles.shape)
            @ problem.analysis
            for v in values
        ]
    )
