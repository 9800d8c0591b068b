"""First-order averaging for any law: the slow flow by quadrature.

The torsion is u = u0 + Re(z E) + F(theta), with E = exp(i (p/q) theta), z = a exp(-i phase) and the hard lines in F.
With N(u) = T(u) - T(u0) - T'(u0)(u - u0) and Omega = p omega/q, elimination of secular terms gives

    z' = -(mu/2 + i (Omega - omega_0)) z + (i/omega_0) <(N/J - S) conj(E)>

with S the soft line, k = p/q, and < > the mean over one common period, or over both angles without resonance
(Nayfeh & Mook 1979, Nonlinear Oscillations, sec. 4.1; Nayfeh 1981, Introduction to Perturbation Techniques, ch. 9).
In polar form: a' = -mu a/2 + <N sin eta>/(J omega_0) - <S sin eta>/omega_0, and the like with cos eta for a phase'.
"""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..results import Floats
from .setting import Complexes, Setting

TARGET, LIMIT, LIMIT_2D = (
    1e-14,
    8192,
    65536,
)  # accuracy of the quadrature, and the most points for laws with breakpoints


@dataclass(frozen=True, eq=False)
class AveragedFlow:
    """The slow flow by quadrature (trapezoid rule on the common period, spectrally accurate for smooth laws).

    Attributes
    ----------
    turn : (n,) complex array
        E at the sample points.
    lines : (lines, n) complex array
        exp(i k theta) at the sample points.
    rest : (n,) array
        u0 + F [rad] there.
    error : float
        Relative error of the averages (difference against half the points).
    """

    setting: Setting
    turn: Complexes
    lines: Complexes
    rest: Floats
    error: float = 0.0

    def at(self, omega: float) -> "AveragedFlow":
        """Return the flow at another speed [rad/s] of the base angle."""
        moved = self.setting.at(omega)
        return replace(self, setting=moved, rest=moved.u0 + (moved.hard @ self.lines).real)

    def mean_force(self, z: Any) -> Any:
        """Average <N/J conj(E)> [rad/s^2] for an array of z [rad]."""
        s = self.setting
        law = s.system.law
        u = self._torsion(z)
        beyond = law.torque(u) - law.torque(s.u0) - law.stiffness(s.u0) * (u - s.u0)
        return self._against_turn(beyond).reshape(np.shape(z)) / s.system.J

    def _torsion(self, z: Any) -> Floats:
        """Torsion [rad] at the sample points for every z: shape (number of z, n)."""
        flat = np.ravel(z)[:, None]
        return np.asarray(self.rest + flat.real * self.turn.real - flat.imag * self.turn.imag)

    def _against_turn(self, values: Floats) -> Complexes:
        """Mean of values times conj(E) over the sample points."""
        mean = np.empty(len(values), complex)
        mean.real = values @ self.turn.real
        mean.imag = -(values @ self.turn.imag)
        mean /= len(self.turn)
        return mean

    def rates(self, z: Any) -> Any:
        """Rate z' [rad/s] for an array of z [rad]."""
        s = self.setting
        return -(0.5 * s.mu + 1j * (s.fast - s.omega_0)) * z + (1j / s.omega_0) * (self.mean_force(z) - 0.5 * s.soft)

    def jacobian(self, z: Any) -> Floats:
        """Derivative [1/s] of (Re z', Im z') to (Re z, Im z): shape (..., 2, 2)."""
        s = self.setting
        law = s.system.law
        u = self._torsion(z)
        change = (law.stiffness(u) - law.stiffness(s.u0)) / s.system.J + 0.0 * u
        linear = -(0.5 * s.mu + 1j * (s.fast - s.omega_0))
        by_re = linear + (1j / s.omega_0) * self._against_turn(change * self.turn.real)
        by_im = 1j * linear - (1j / s.omega_0) * self._against_turn(change * self.turn.imag)
        matrix = np.stack([np.stack([by_re.real, by_im.real], -1), np.stack([by_re.imag, by_im.imag], -1)], -2)
        return matrix.reshape(*np.shape(z), 2, 2)

    def phase_matters(self) -> bool:
        """Whether the flow depends on the phase, that is, whether the resonance appears at first order."""
        if self.setting.soft != 0.0:
            return True
        phases = np.exp(-2j * np.pi * np.arange(16) / 16.3)
        amplitudes = np.unique([s * f for s in self.setting.scales() for f in (0.1, 0.3, 1.0, 3.0, 10.0)])
        with np.errstate(all="ignore"):
            radial = self.mean_force(amplitudes[:, None] * phases) / phases
            spread = np.max(np.abs(radial - radial[:, :1]), axis=1)
            size = np.max(np.abs(radial), axis=1) + 1e-13 * amplitudes * self.setting.omega_0**2
        return bool(np.nanmax(np.where(np.isfinite(spread), spread / size, 0.0)) > max(1e-9, 30.0 * self.error))


def averaged_flow(s: Setting) -> AveragedFlow:
    """Set up the quadrature: points are doubled until the averages stand still or the limit for kinks is reached."""
    phases = np.exp(1j * np.array([0.3, 1.7, 4.1]))
    probes = np.concatenate([amplitude * phases for amplitude in s.scales()])
    level, flow = 0, sampled(s, 0)
    with np.errstate(all="ignore"):
        coarse = flow.mean_force(probes)
        while True:
            level += 1
            flow = sampled(s, level)
            fine = flow.mean_force(probes)
            finite = np.isfinite(coarse) & np.isfinite(fine)
            size = float(np.max(np.abs(fine[finite]), initial=0.0))
            error = float(np.max(np.abs(fine - coarse)[finite], initial=0.0)) / size if size > 0.0 else 0.0
            limit = LIMIT_2D if s.resonance.ratio is None else LIMIT
            # the size counts against rounding: N is a difference of torques
            noise = 1e-15 * s.omega_0**2 * float(np.max(np.abs(probes))) / size if size > 0.0 else 0.0
            if error <= max(TARGET, noise) or 4 * len(flow.turn) > limit:
                return replace(flow, error=error if error > max(TARGET, noise) else 0.0)
            coarse = fine


def sampled(s: Setting, level: int) -> AveragedFlow:
    """The flow on a grid of 64 points per turn of the fastest angle, times 2^level."""
    ratio = s.resonance.ratio
    if ratio is None:
        base = math.gcd(*s.orders) if s.orders else 1
        n = (32 << level, 1 if not s.orders else (32 << level) * max(s.orders) // base)
        eta, theta = np.meshgrid(*(2.0 * np.pi * np.arange(m) / m for m in n), indexing="ij")
        fast, theta = eta.ravel(), theta.ravel() / base
    else:
        p, q = ratio.numerator, ratio.denominator
        base = math.gcd(p, *(q * k for k in s.orders))
        n_points = (64 << level) * max(p, *(q * k for k in s.orders), 1) // base
        # theta runs over 2 pi q/base: the common period of the fast angle and all lines
        theta = (2.0 * np.pi * q / base) * np.arange(n_points) / n_points
        fast = float(ratio) * theta
    lines = np.exp(1j * np.array(s.orders, float)[:, None] * theta)
    return AveragedFlow(s, np.exp(1j * fast), lines, s.u0 + (s.hard @ lines).real)
