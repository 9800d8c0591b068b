"""What in an oscillator's balance does not depend on its law: inertia, damping, torque and kinematic error.

The virtual leaves are parameters that are no numbers of the system: along them orbits that coexist are connected.
"""

from typing import Any

import numpy as np

from ...compile.jit import kernel_as, routine
from ...results import Floats
from .fourier import orders

# In the place of a leaf, at a fixed frequency: the parameter is the logarithm of a factor of all that alternates, or a
# constant torque [N*m] beside that of the excitation; with LINE - k it is added to the factor 1 of line k alone.
STRENGTH, CONSTANT, LINE = -2, -3, -3


def _add_linear_loops(J: float, B: float, w: float, stride: int, z: Any, torque: Any, error: Any, r: Any) -> None:
    h = len(r) // 2
    r[0] -= torque[0]
    for k in range(1, h + 1):
        kw = (1 + stride * (k - 1)) * w
        inertia = J * kw * kw
        damping = B * kw
        c, s = z[k], z[h + k]
        r[k] += -inertia * (c + error[k]) + damping * s - torque[k]
        r[h + k] += -inertia * (s + error[h + k]) - damping * c - torque[h + k]


@kernel_as(_add_linear_loops)
def add_linear(J: float, B: float, w: float, stride: int, z: Any, torque: Any, error: Any, r: Any) -> None:
    """Add J u'' + B u' - tau + J e'' in Fourier coefficients."""
    h = len(r) // 2
    kw = w * orders(h, stride)
    inertia, damping = J * kw * kw, B * kw
    c, s = z[1 : h + 1], z[h + 1 : 2 * h + 1]
    r -= torque
    r[1 : h + 1] += damping * s - inertia * (c + error[1 : h + 1])
    r[h + 1 :] -= damping * c + inertia * (s + error[h + 1 :])


def _add_linear_jacobian_loops(J: float, B: float, w: float, stride: int, h: int, out: Any) -> None:
    for k in range(1, h + 1):
        kw = (1 + stride * (k - 1)) * w
        out[k, k] -= J * kw * kw
        out[h + k, h + k] -= J * kw * kw
        out[k, h + k] += B * kw
        out[h + k, k] -= B * kw


@kernel_as(_add_linear_jacobian_loops)
def add_linear_jacobian(J: float, B: float, w: float, stride: int, h: int, out: Any) -> None:
    """Add the Jacobian of J u'' + B u'."""
    k = np.arange(1, h + 1)
    kw = w * orders(h, stride)
    inertia, damping = J * kw * kw, B * kw
    out[k, k] -= inertia
    out[h + k, h + k] -= inertia
    out[k, h + k] += damping
    out[h + k, k] -= damping


@routine
def clean_mean(series: Any) -> None:
    """Remove the rounding from the mean of a series without one: in the play of a gear nothing holds against it."""
    top = 0.0
    for i in range(1, len(series)):
        top = max(top, abs(series[i]))
    if abs(series[0]) < 1e-14 * top:
        series[0] = 0.0


def forced(system: Any, angles: Floats, table: Floats) -> tuple[Floats, Floats]:
    """Coefficients (in blocks) of torque and kinematic error, by their analysis `table` at base angles [rad]."""
    nothing = np.zeros(len(angles))
    tau = (system.excitation.torque(angles) + nothing) @ table
    clean_mean(tau)
    return tau, (system.error.value(angles) + nothing) @ table


@routine
def vary(leaf: int, value: float, torque: Any, error: Any, derive: bool) -> None:
    """Change series of torque and error (blocks) as the virtual leaf says, or into derivatives by its parameter."""
    h = len(torque) // 2
    torque[0] = (1.0 if leaf == CONSTANT else 0.0) if derive else torque[0] + (value if leaf == CONSTANT else 0.0)
    for k in range(1, h + 1):
        mine, rest = leaf == LINE - k, 0.0 if derive else 1.0
        factor = np.exp(value) if leaf == STRENGTH else (rest * value + 1.0 if mine else rest)
        torque[k] *= factor
        torque[h + k] *= factor
        error[k] *= factor
        error[h + k] *= factor
