"""Closed forms of the slow flow of first order: the cubic law under one forcing line, without mean torque.

The article's four cases with its errata corrected (E2-E6): alpha stands in every cubic term, C is taken at the actual
omega, and mu, the detuning and the forcing are the physical ones. In complex form, with kappa = alpha omega_0,

    z' = -(mu/2 + i (Omega - omega_0)) z + i kappa (3/8 |z|^2 + 3/4 C^2) z + i (kappa D - f/(2 omega_0))

with D = C^3/8 in the superharmonic, D = 3/8 C conj(z)^2 in the subharmonic case, f the soft line of the primary case
(Nayfeh & Mook 1979, eqs. 4.1.10, 4.1.55 and 4.1.71 after 2 mu -> mu, alpha -> alpha omega_0^2, 2 Lambda -> C).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np

from ...base.law import polynomial_of
from ...base.results import Floats
from ...numerics.roots import positive_roots
from .averaging import FirstOrder
from .setting import Setting, real_matrix

UNDAMPED = 1e-30  # mu/omega_0 that is next to no damping
Kind = Literal["none", "primary", "superharmonic", "subharmonic"]


def kind_of(s: Setting) -> Kind | None:
    """Kind of the closed form that serves; None where only the integrals do."""
    coefficients = polynomial_of(s.system.law)
    if coefficients is None or s.u0 != 0.0 or len(s.orders) != 1:
        return None
    constant, _, square, _, *higher = (*coefficients, 0.0, 0.0, 0.0)
    if constant or square or any(higher):
        return None
    if s.resonance.ratio is None:
        return "none"
    multiples: dict[Any, Kind] = {1: "primary", 3: "superharmonic"}
    relative = s.resonance.ratio / s.orders[0]
    return "subharmonic" if 3 * relative == 1 else multiples.get(relative)


@dataclass(frozen=True, eq=False)
class CubicFlow(FirstOrder):
    """The slow flow of a cubic law in closed form (ERRATA E3-E6)."""

    setting: Setting
    kind: Kind
    error: float = 0.0

    def at(self, omega: Any) -> "CubicFlow":
        """Return the flow at another speed [rad/s] of the base angle, or at many."""
        return CubicFlow(self.setting.at(omega), self.kind)

    @cached_property
    def kappa(self) -> Any:
        """Return alpha omega_0 [1/(rad^2 s)]."""
        coefficients: Any = polynomial_of(self.setting.system.law)
        _, stiffness, _, cube = (*coefficients, 0.0, 0.0)[:4]
        return cube / stiffness * self.setting.omega_0

    @cached_property
    def forced(self) -> Any:
        """Amplitude C exp(i phi) [rad] of the hard line; 0 in the primary case."""
        return self.setting.hard[..., 0]

    @cached_property
    def detuning(self) -> Any:
        """Omega - omega_0 less the shift 3/4 alpha omega_0 C^2 that the forced motion causes [rad/s]."""
        return self.setting.fast - self.setting.omega_0 - 0.75 * self.kappa * abs(self.forced) ** 2

    def _drive(self, z: Any) -> Any:
        if self.kind == "primary":
            return -0.5 * self.setting.soft / self.setting.omega_0
        if self.kind == "superharmonic":
            return self.kappa * self.forced**3 / 8.0
        return 0.375 * self.kappa * self.forced * np.conj(z) ** 2 if self.kind == "subharmonic" else 0.0

    def rates(self, z: Any) -> Any:
        """Rate z' [rad/s] for an array of z [rad]."""
        shift = 0.375 * self.kappa * np.abs(z) ** 2
        return -(0.5 * self.setting.mu + 1j * (self.detuning - shift)) * z + 1j * self._drive(z)

    def balance(self, z: Any) -> tuple[Any, Floats]:
        """The rate z' [rad/s] for an array of z [rad], and its derivative [1/s] (..., 2, 2) to (Re z, Im z)."""
        z = np.asarray(z, complex)
        by_z = -(0.5 * self.setting.mu + 1j * (self.detuning - 0.75 * self.kappa * np.abs(z) ** 2))
        by_conj = 0.375j * self.kappa * z**2
        if self.kind == "subharmonic":
            by_conj = by_conj + 0.75j * self.kappa * self.forced * np.conj(z)
        by_re, by_im = by_z + by_conj, 1j * (by_z - by_conj)
        return self.rates(z), real_matrix(by_re, by_im)

    def phase_matters(self) -> bool:
        """True for a resonance that appears at first order: not for alpha = 0 or without forced motion."""
        return self.kind in ("none", "primary") or self.kappa * abs(self.forced) != 0.0

    def fixed_points(self) -> Any:
        """Nontrivial fixed points z [rad] from E4, E5, E6: shape (3 or 2, ...), not finite where there are fewer."""
        mu, slope, detuning = self.setting.mu, 0.375 * self.kappa, self.detuning
        linear = 0.25 * mu**2 + detuning**2
        if self.kind == "none":
            return np.zeros((0, *np.shape(detuning)), complex)
        if self.kind == "subharmonic":
            # E6 over 9: mu^2/4 + (detuning - slope s)^2 = (slope C)^2 s
            forced = (slope * abs(self.forced)) ** 2
            return self._points(positive_roots(slope**2, -2.0 * detuning * slope - forced, linear))
        square = abs(self._drive(0.0)) ** 2
        return self._points(positive_roots(slope**2, -2.0 * detuning * slope, linear, -square))

    def _points(self, squares: Floats) -> Any:
        """Fixed points with |z|^2 = squares."""
        linear = -(0.5 * self.setting.mu + 1j * (self.detuning - 0.375 * self.kappa * squares))
        with np.errstate(all="ignore"):
            if self.kind != "subharmonic":
                direction = -1j * self._drive(0.0) / linear
                return np.sqrt(squares) * direction / np.abs(direction)  # their size is ill-conditioned in a peak
            # linear z = -i (3/8) kappa C conj(z)^2 fixes three times the phase; the three solutions are one state
            triple = np.angle(linear / (-0.375j * self.kappa * self.forced))
            return np.sqrt(squares) * np.exp(-1j * triple / 3.0)

    def existence(self) -> str:
        """Existence condition of nontrivial steady states, in one sentence with numbers."""
        sentences: dict[Kind, Callable[[], str]] = {
            "primary": self._primary_peak, "superharmonic": self._superharmonic_bound,
            "subharmonic": self._subharmonic_condition, "none": lambda: free_decay(self.setting),
        }  # fmt: skip
        return sentences[self.kind]()

    def _primary_peak(self) -> str:
        s = self.setting
        if s.mu <= UNDAMPED * s.omega_0:
            return "the primary response exists at every speed; without damping (mu = 0) its peak is unbounded"
        peak = abs(s.soft) / (s.mu * s.omega_0)
        return (
            f"the primary response exists at every speed; its peak is f/(mu omega_0) = {peak:.6g} rad at "
            f"Omega - omega_0 = 3/8 alpha omega_0 a^2 = {0.375 * self.kappa * peak**2:.6g} rad/s"
        )

    def _superharmonic_bound(self) -> str:
        s, c = self.setting, abs(self.forced)
        largest = "unbounded"
        if s.mu > UNDAMPED * s.omega_0:
            bound = abs(self.kappa) * c**3 / (4.0 * s.mu)
            largest = f"at most |alpha| omega_0 |C|^3/(4 mu) = {bound:.6g} rad"
        return (
            f"the superharmonic component exists at every speed; with C = {c:.6g} rad at this one its amplitude is "
            f"{largest}"
        )

    def _subharmonic_condition(self) -> str:
        """Sentence on k C^2 (4 Lambda + k C^2) >= 9 mu^2, k = 9/8 alpha omega_0 and Lambda = sigma - 2 k C^2 (E6)."""
        s, c = self.setting, abs(self.forced)
        k, shifted = 1.125 * self.kappa, 3.0 * self.detuning
        left, right = k * c * c * (4.0 * shifted + k * c * c), 9.0 * s.mu**2
        verdict = "exists" if left >= right and 2.0 * k * shifted + (k * c) ** 2 > 0.0 else "does not exist"
        turning = "omega" if s.orders[0] == 1 else f"{s.orders[0]} omega"
        return (
            f"the subharmonic motion {verdict}: with k = 9/8 alpha omega_0 and sigma = {turning} - "
            f"3 omega_0 it needs k C^2 (4 sigma - 7 k C^2) >= 9 mu^2, here {left:.6g} against {right:.6g} 1/s^2; "
            f"at this speed {self._subharmonic_limits(k, shifted + 2.0 * k * c * c)}"
        )

    def _subharmonic_limits(self, k: float, sigma: float) -> str:
        """Amounts of excitation between which the subharmonic motion exists at a detuning sigma [rad/s]."""
        s, c = self.setting, abs(self.forced)
        least = math.sqrt(15.75) * s.mu
        bounds = np.roots([7.0, -4.0 * sigma, 9.0 * s.mu**2]) / (k * c * c)  # of k C^2, over that of this excitation
        if abs(sigma) >= least and max(bounds.real) > 0.0:
            return f"it takes {self._amounts(np.sort(np.sqrt(bounds.real)))}"
        edge = self.at((3.0 * s.omega_0 + math.copysign(least, k)) / s.orders[0])
        times = math.sqrt(2.0 / 7.0 * least / abs(k)) / abs(edge.forced)
        limits = f"no excitation gives it, which takes sigma {'>= ' if k > 0.0 else '<= -'}{least:.6g} rad/s"
        return f"{limits}, and there {edge._amounts([times])}" if times else limits

    def _amounts(self, times: Any) -> str:
        """Multiples of this excitation, and of a torque line what they are."""
        torque, factors = abs(self.setting.torque_lines[0]), " to ".join(f"{factor:.6g}" for factor in times)
        amounts = " to ".join(f"{factor * torque:.6g}" for factor in times)
        equal = f", an amplitude of {amounts} N*m in the error equation"
        return f"{factors} times this excitation{'' if np.any(self.setting.error_lines) else equal}"


def free_decay(s: Setting) -> str:
    """Say what happens to the free part where nothing resonates."""
    return f"without resonance the free part decays as exp(-mu t/2), mu = {s.mu:.6g} 1/s; no steady part of it exists"
