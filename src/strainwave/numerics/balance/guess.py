"""Where the solvers start: the linear response about the operating point of the mean torque."""

from typing import Any

import numpy as np

from ...results import Floats
from ...tree import with_leaf
from ..operating_point import operating_point
from .fourier import orders

WAVE = np.cos(np.pi * (np.arange(16) + 0.5) / 16)  # half a vibration


def carried(law: Any, mean: float) -> float:
    """Operating point [rad] to start a solver from: 0 where no torsion carries the mean torque [N*m]."""
    try:
        return operating_point(law, mean)
    except ValueError:
        return 0.0


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
    z[0] = carried(system.law, float(tau[0]))
    stiffness = float(system.law.stiffness(z[0]))
    w = orders(h, problem.stride) * system.omega / problem.turns
    bottom = stiffness - system.J * w * w + 1j * system.B * w
    least = 1e-9 * (abs(stiffness) + system.J * w * w)  # exactly at a resonance without damping there is no response
    response = drive(system, w, tau, error) / np.where(np.abs(bottom) < least, least, bottom)
    z[1 : h + 1], z[h + 1 : n] = response.real, -response.imag
    return z


def drive(system: Any, w: Floats, tau: Floats, error: Floats) -> Any:
    """Complex amplitudes [N*m] of what drives the torsion at the frequencies w [rad/s]: tau - J e''."""
    h, inertia = w.shape[-1], system.J * w * w
    return tau[1 : h + 1] + inertia * error[1 : h + 1] - 1j * (tau[h + 1 :] + inertia * error[h + 1 :])


def one_harmonic(law: Any, torque: float, sizes: Floats) -> tuple[Floats, Floats]:
    """Mean torsion [rad] and equivalent stiffness [N*m/rad] of vibrations of one harmonic with these amplitudes [rad].

    The mean carries the mean torque [N*m] (where the law lets it), the stiffness is the describing function.
    Gelb & Vander Velde 1968, Multiple-Input Describing Functions, sec. 6.1 (a harmonic and a bias).
    """
    wave = sizes[:, None] * WAVE
    mean = np.full(len(sizes), carried(law, torque))
    for _ in range(30):
        u = mean[:, None] + wave
        pull = law.torque(u) + 0.0 * u
        short = torque - pull.mean(axis=1)
        if np.all(np.abs(short) <= 1e-9 * np.abs(pull).max(axis=1)):
            break
        slope = (law.stiffness(u) + 0.0 * u).mean(axis=1)
        mean += np.divide(short, slope, out=np.zeros(len(sizes)), where=slope > 0.0)
    return mean, 2.0 / len(WAVE) * (pull @ WAVE) / sizes


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
