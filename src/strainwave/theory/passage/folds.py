"""Folds of the steady response on the way of a passage, and the delay of the jump at them.

Near a fold the flow has one slow direction v, with the left eigenvector w, w.v = 1: its coordinate obeys
s' = p (omega - omega_f) + q s^2, p = w.f_omega, q = w.f_zz[v, v]/2. At omega' = rate this is Riccati's equation, solved
by Airy's function: the state leaves at 2.33811, the first zero of Ai(-t), times (|p q| rate)^(-1/3) after the fold, so

    delay = 2.33811 (rate^2/|p q|)^(1/3)   [rad/s]

With s = -y'/(q y) it becomes y'' + p q rate (t - t_f) y = 0, whose solution that follows the stable branch is
Ai(-(p q rate)^(1/3) (t - t_f)); s leaves at its first zero (DLMF 9.9 lists 2.33811).
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import ai_zeros

from ..slow_flow.fixed_points import Flow
from ..slow_flow.results import SlowResponse

AIRY = -float(ai_zeros(1)[0][0])
STEP, SPEED_STEP = 1e-3, 1e-5  # of the amplitude and of the speed: differences
BESIDE = 0.02  # of the distance to the next fold: so far beside a fold its states are looked up


@dataclass(frozen=True, eq=False)
class Fold:
    """A fold of the steady response at which the drive may jump.

    Attributes
    ----------
    omega, z : float, complex
        Speed [rad/s] and state [rad].
    before, after : float
        Speeds [rad/s] next to it, on the side of its two states and on the other one.
    lag : float
        Delay of the jump over rate^(2/3) [(rad/s)^(-1/3) s^(1/3)], to leading order.
    """

    omega: float
    z: complex
    before: float
    after: float
    lag: float

    def delay(self, rate: float) -> float:
        """Delay [rad/s] of the jump at a rate [rad/s^2]."""
        return float(self.lag * rate ** (2.0 / 3.0))


def folds_ahead(flow: Flow, response: SlowResponse, first: float, last: float) -> list[Fold]:
    """Folds whose states vanish in the direction from `first` to `last` [rad/s], in the order of the way."""
    ahead = 1.0 if last > first else -1.0
    found = []
    for branch in response.branches:
        for omega in response.folds:
            at = np.flatnonzero(branch.omega == omega)
            inside = at[(at > 0) & (at < len(branch.omega) - 1)]
            if not len(inside) or ahead * (branch.omega[inside[0] - 1] - omega) > 0.0:
                continue
            z = complex(branch.amplitude[inside[0]] * np.exp(-1j * branch.phase[inside[0]]))
            marks = [w for w in (*response.folds, first, last) if w != omega]
            off = ahead * BESIDE * min(abs(w - omega) for w in marks)
            found.append(Fold(omega, z, omega - off, omega + off, _lag(flow, omega, z)))
    return sorted(found, key=lambda fold: ahead * fold.omega)


def _lag(flow: Flow, omega: float, z: complex) -> float:
    """Delay over rate^(2/3), by differences of the rates at the fold."""

    def rates(w: float, x: complex) -> complex:
        return complex(flow.at(w).rates(np.array([x]))[0])

    h, d = STEP * abs(z), SPEED_STEP * omega
    by_re = (rates(omega, z + h) - rates(omega, z - h)) / (2.0 * h)
    by_im = (rates(omega, z + 1j * h) - rates(omega, z - 1j * h)) / (2.0 * h)
    matrix = np.array([[by_re.real, by_im.real], [by_re.imag, by_im.imag]])
    values, right = np.linalg.eig(matrix)
    slow = int(np.argmin(np.abs(values)))
    v = right[:, slow].real
    left = np.linalg.inv(right)[slow].real
    push = (rates(omega + d, z) - rates(omega - d, z)) / (2.0 * d)
    along = h * complex(*v)
    bend = (rates(omega, z + along) + rates(omega, z - along) - 2.0 * rates(omega, z)) / (2.0 * h * h)
    product = abs((left @ [push.real, push.imag]) * (left @ [bend.real, bend.imag]))
    return AIRY * product ** (-1.0 / 3.0) if product > 0.0 else float("inf")
