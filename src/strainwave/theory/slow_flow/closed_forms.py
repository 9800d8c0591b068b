"""Closed forms of the slow flow for the cubic law under one forcing line, without mean torque.

The article's four cases with its errata corrected (E2-E6): alpha stands in every cubic term, C is taken at the actual
omega, and mu, the detuning and the forcing are the physical ones. In complex form, with kappa = alpha omega_0,

    z' = -(mu/2 + i (Omega - omega_0)) z + i kappa (3/8 |z|^2 + 3/4 C^2) z + i (kappa D - f/(2 omega_0))

with D = C^3/8 in the superharmonic, D = 3/8 C conj(z)^2 in the subharmonic case, f the soft line of the primary case
(Nayfeh & Mook 1979, eqs. 4.1.10, 4.1.55 and 4.1.71 after 2 mu -> mu, alpha -> alpha omega_0^2, 2 Lambda -> C).

The second order is written out for a law with a square and a cube about the operating point, resonance by resonance.

The law is T(u0 + w)/J = T(u0)/J + omega_0^2 w + c2 w^2 + c3 w^3, the first-order motion w = Re(z E) + Re(c L), E the
rotation of the fast angle and L that of the forcing line. A test derives what stands here by SymPy and
compares the two. Each form has the `numbers` of its small harmonics, as multiples of w and of v, and takes

    c2, c3   [1/(rad s^2)], [1/(rad^2 s^2)]   the law's square and cube over J
    k        [1/s^2]                          omega_0^2
    mu       [1/s]                            B/J
    w, v     [rad/s]                          speed of the base angle (of E without resonance), of L where it is free
    z, c     [rad]                            complex amplitudes on E and on L

and returns three things: the amplitudes [rad] of the small harmonics, in the order of its numbers; the
amplitude [rad/s^2] of c2 w^2 + c3 w^3 on E, the first order; and what the small harmonics add to it, the second.
They serve numbers and arrays.
"""

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np

from ...base.law import polynomial_of
from ...base.results import Floats
from ...compile.jit import kernel
from ...numerics.operating_point import positive_roots
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
        s, c = self.setting, abs(self.forced)
        if self.kind == "primary":
            f = abs(s.soft)
            if s.mu <= UNDAMPED * s.omega_0:
                return "the primary response exists at every speed; without damping (mu = 0) its peak is unbounded"
            peak = f / (s.mu * s.omega_0)
            return (
                f"the primary response exists at every speed; its peak is f/(mu omega_0) = {peak:.6g} rad at "
                f"Omega - omega_0 = 3/8 alpha omega_0 a^2 = {0.375 * self.kappa * peak**2:.6g} rad/s"
            )
        if self.kind == "superharmonic":
            bound = abs(self.kappa) * c**3 / (4.0 * s.mu) if s.mu > UNDAMPED * s.omega_0 else math.inf
            largest = f"at most |alpha| omega_0 |C|^3/(4 mu) = {bound:.6g} rad" if bound < math.inf else "unbounded"
            return (
                f"the superharmonic component exists at every speed; with C = {c:.6g} rad at this one its amplitude is "
                f"{largest}"
            )
        if self.kind == "subharmonic":
            # k = 9/8 alpha omega_0, Lambda = sigma - 2 k C^2: the discriminant of E6 asks k C^2 (4 Lambda + k C^2) >= 9
            # mu^2
            k, shifted = 1.125 * self.kappa, 3.0 * self.detuning
            left, right = k * c * c * (4.0 * shifted + k * c * c), 9.0 * s.mu**2
            verdict = "exists" if left >= right and 2.0 * k * shifted + (k * c) ** 2 > 0.0 else "does not exist"
            sigma, least = shifted + 2.0 * k * c * c, math.sqrt(15.75) * s.mu
            bounds = np.roots([7.0, -4.0 * sigma, right]) / (k * c * c)  # of k C^2, over that of this excitation
            if abs(sigma) >= least and max(bounds.real) > 0.0:
                limits = f"it takes {self._amounts(np.sort(np.sqrt(bounds.real)))}"
            else:
                edge = self.at((3.0 * s.omega_0 + math.copysign(least, k)) / s.orders[0])
                times = math.sqrt(2.0 / 7.0 * least / abs(k)) / abs(edge.forced)
                limits = f"no excitation gives it, which takes sigma {'>= ' if k > 0.0 else '<= -'}{least:.6g} rad/s"
                limits += f", and there {edge._amounts([times])}" if times else ""
            turning = "omega" if s.orders[0] == 1 else f"{s.orders[0]} omega"
            return (
                f"the subharmonic motion {verdict}: with k = 9/8 alpha omega_0 and sigma = {turning} - "
                f"3 omega_0 it needs k C^2 (4 sigma - 7 k C^2) >= 9 mu^2, here {left:.6g} against {right:.6g} 1/s^2; "
                f"at this speed {limits}"
            )
        return free_decay(s)

    def _amounts(self, times: Any) -> str:
        """Multiples of this excitation, and of a torque line what they are."""
        torque, factors = abs(self.setting.torque_lines[0]), " to ".join(f"{factor:.6g}" for factor in times)
        amounts = " to ".join(f"{factor * torque:.6g}" for factor in times)
        equal = f", an amplitude of {amounts} N*m in the error equation"
        return f"{factors} times this excitation{'' if np.any(self.setting.error_lines) else equal}"


def free_decay(s: Setting) -> str:
    """Say what happens to the free part where nothing resonates."""
    return f"without resonance the free part decays as exp(-mu t/2), mu = {s.mu:.6g} 1/s; no steady part of it exists"


Numbers = tuple[tuple[int, int], ...]


@kernel
def answer(force: Any, k: Any, mu: Any, speed: Any) -> Any:
    """Harmonic [rad] that a harmonic of the torque over J [rad/s^2] drives at a speed [rad/s]."""
    return -force / (k - speed * speed + 1j * mu * speed)


@kernel
def _square(z: Any) -> Any:
    return z.real * z.real + z.imag * z.imag


def _of_one_angle(*multiples: int) -> Numbers:
    return tuple((m, 0) for m in multiples)


class Primary(NamedTuple):
    """The line is on E."""

    numbers: Numbers = _of_one_angle(0, 2, 3)

    def values(self, c2: Any, c3: Any, k: Any, mu: Any, w: Any, _v: Any, z: Any, _c: Any) -> Any:
        """Small harmonics, and what is on E [rad/s^2] at first and at second order."""
        zz = _square(z)
        w0 = -0.5 * c2 * zz / k
        w2 = answer(0.5 * c2 * z * z, k, mu, 2.0 * w)
        w3 = answer(0.25 * c3 * z * z * z, k, mu, 3.0 * w)
        y = z.conjugate()
        back = c2 * (2.0 * w0 * z + w2 * y) + 0.75 * c3 * w3 * y * y
        return (w0, w2, w3), 0.75 * c3 * zz * z, back


class Superharmonic(NamedTuple):
    """E = L^3."""

    numbers: Numbers = _of_one_angle(0, 1, 2, 4, 5, 6, 7, 9)

    def values(self, c2: Any, c3: Any, k: Any, mu: Any, w: Any, _v: Any, z: Any, c: Any) -> Any:
        """Small harmonics, and what is on E [rad/s^2] at first and at second order."""
        y, d, zz, cc = z.conjugate(), c.conjugate(), _square(z), _square(c)
        w0 = -0.5 * c2 * (cc + zz) / k
        w1 = answer(0.75 * c3 * (cc * c + 2.0 * zz * c + d * d * z) + 1j * mu * w * c, k, mu, w)
        w2 = answer(c2 * (0.5 * c * c + d * z), k, mu, 2.0 * w)
        w4 = answer(c2 * c * z, k, mu, 4.0 * w)
        w5 = answer(0.75 * c3 * (c * c + d * z) * z, k, mu, 5.0 * w)
        w6 = answer(0.5 * c2 * z * z, k, mu, 6.0 * w)
        w7 = answer(0.75 * c3 * c * z * z, k, mu, 7.0 * w)
        w9 = answer(0.25 * c3 * z * z * z, k, mu, 9.0 * w)
        by_square = c * w2 + d * w4 + 2.0 * w0 * z + w6 * y
        by_cube = (c * c + 2.0 * d * z) * w1 + 2.0 * c * z * w1.conjugate() + (2.0 * c * y + d * d) * w5
        by_cube = by_cube + 2.0 * d * y * w7 + y * y * w9
        on_fast = c3 * (0.25 * c * c * c + 1.5 * cc * z + 0.75 * zz * z)
        return (w0, w1, w2, w4, w5, w6, w7, w9), on_fast, c2 * by_square + 0.75 * c3 * by_cube


class Subharmonic(NamedTuple):
    """L = E^3."""

    numbers: Numbers = _of_one_angle(0, 2, 3, 4, 5, 6, 7, 9)

    def values(self, c2: Any, c3: Any, k: Any, mu: Any, w: Any, _v: Any, z: Any, c: Any) -> Any:
        """Small harmonics, and what is on E [rad/s^2] at first and at second order."""
        y, d, zz, cc = z.conjugate(), c.conjugate(), _square(z), _square(c)
        w0 = -0.5 * c2 * (cc + zz) / k
        w2 = answer(c2 * (c * y + 0.5 * z * z), k, mu, 2.0 * w)
        w3 = answer(c3 * (0.75 * cc * c + 1.5 * zz * c + 0.25 * z * z * z) + 3j * mu * w * c, k, mu, 3.0 * w)
        w4 = answer(c2 * c * z, k, mu, 4.0 * w)
        w5 = answer(0.75 * c3 * (c * y + z * z) * c, k, mu, 5.0 * w)
        w6 = answer(0.5 * c2 * c * c, k, mu, 6.0 * w)
        w7 = answer(0.75 * c3 * c * c * z, k, mu, 7.0 * w)
        w9 = answer(0.25 * c3 * c * c * c, k, mu, 9.0 * w)
        by_square = c * w2.conjugate() + d * w4 + 2.0 * w0 * z + w2 * y
        by_cube = 2.0 * c * z * w3.conjugate() + (2.0 * d * z + y * y) * w3
        by_cube = by_cube + c * c * w5.conjugate() + 2.0 * d * y * w5 + d * d * w7
        on_fast = c3 * (1.5 * cc * z + 0.75 * c * y * y + 0.75 * zz * z)
        return (w0, w2, w3, w4, w5, w6, w7, w9), on_fast, c2 * by_square + 0.75 * c3 * by_cube


class Twofold(NamedTuple):
    """E = L^2, the superharmonic of a square."""

    numbers: Numbers = _of_one_angle(0, 1, 3, 4, 5, 6)

    def values(self, c2: Any, c3: Any, k: Any, mu: Any, w: Any, _v: Any, z: Any, c: Any) -> Any:
        """Small harmonics, and what is on E [rad/s^2] at first and at second order."""
        y, d, zz, cc = z.conjugate(), c.conjugate(), _square(z), _square(c)
        w0 = -(0.5 * c2 * (cc + zz) + 0.75 * c3 * (c * c * y).real) / k
        w1 = answer(c2 * d * z + c3 * (0.75 * cc + 1.5 * zz) * c + 1j * mu * w * c, k, mu, w)
        w3 = answer(c2 * c * z + c3 * (0.25 * c * c * c + 0.75 * d * z * z), k, mu, 3.0 * w)
        w4 = answer((0.75 * c3 * c * c + 0.5 * c2 * z) * z, k, mu, 4.0 * w)
        w5 = answer(0.75 * c3 * c * z * z, k, mu, 5.0 * w)
        w6 = answer(0.25 * c3 * z * z * z, k, mu, 6.0 * w)
        by_square = c * w1 + d * w3 + 2.0 * w0 * z + w4 * y
        by_cube = 2.0 * c * z * w1.conjugate() + 2.0 * d * z * w1 + 2.0 * c * c * w0 + 2.0 * c * y * w3
        by_cube = by_cube + d * d * w4 + 2.0 * d * y * w5 + y * y * w6
        on_fast = 0.5 * c2 * c * c + c3 * (1.5 * cc * z + 0.75 * zz * z)
        return (w0, w1, w3, w4, w5, w6), on_fast, c2 * by_square + 0.75 * c3 * by_cube


class Half(NamedTuple):
    """L = E^2, the subharmonic of a square."""

    numbers: Numbers = _of_one_angle(0, 2, 3, 4, 5, 6)

    def values(self, c2: Any, c3: Any, k: Any, mu: Any, w: Any, _v: Any, z: Any, c: Any) -> Any:
        """Small harmonics, and what is on E [rad/s^2] at first and at second order."""
        y, d, zz, cc = z.conjugate(), c.conjugate(), _square(z), _square(c)
        w0 = -(0.5 * c2 * (cc + zz) + 0.75 * c3 * (d * z * z).real) / k
        w2 = answer(0.5 * c2 * z * z + c3 * (0.75 * cc + 1.5 * zz) * c + 2j * mu * w * c, k, mu, 2.0 * w)
        w3 = answer(c2 * c * z + c3 * (0.75 * c * c * y + 0.25 * z * z * z), k, mu, 3.0 * w)
        w4 = answer((0.5 * c2 * c + 0.75 * c3 * z * z) * c, k, mu, 4.0 * w)
        w5 = answer(0.75 * c3 * c * c * z, k, mu, 5.0 * w)
        w6 = answer(0.25 * c3 * c * c * c, k, mu, 6.0 * w)
        by_square = d * w3 + 2.0 * w0 * z + w2 * y
        by_cube = 2.0 * c * z * w2.conjugate() + 2.0 * d * z * w2 + c * c * w3.conjugate() + y * y * w3
        by_cube = by_cube + 4.0 * c * y * w0 + d * d * w5 + 2.0 * d * y * w4
        on_fast = c2 * c * y + c3 * (1.5 * cc * z + 0.75 * zz * z)
        return (w0, w2, w3, w4, w5, w6), on_fast, c2 * by_square + 0.75 * c3 * by_cube


class Nonresonant(NamedTuple):
    """E and L turn freely."""

    numbers: Numbers = (
        (0, 0), (0, 1), (0, 2), (0, 3), (1, -2), (1, -1), (1, 1), (1, 2), (2, -1), (2, 0), (2, 1), (3, 0),
    )  # fmt: skip

    def values(self, c2: Any, c3: Any, k: Any, mu: Any, w: Any, v: Any, z: Any, c: Any) -> Any:
        """Small harmonics, and what is on E [rad/s^2] at first and at second order."""
        y, d, zz, cc = z.conjugate(), c.conjugate(), _square(z), _square(c)
        w00 = -0.5 * c2 * (cc + zz) / k
        w01 = answer(c3 * (0.75 * cc + 1.5 * zz) * c + 1j * mu * v * c, k, mu, v)
        w02 = answer(0.5 * c2 * c * c, k, mu, 2.0 * v)
        w03 = answer(0.25 * c3 * c * c * c, k, mu, 3.0 * v)
        w1m2 = answer(0.75 * c3 * d * d * z, k, mu, w - 2.0 * v)
        w1m1 = answer(c2 * d * z, k, mu, w - v)
        w11 = answer(c2 * c * z, k, mu, w + v)
        w12 = answer(0.75 * c3 * c * c * z, k, mu, w + 2.0 * v)
        w2m1 = answer(0.75 * c3 * d * z * z, k, mu, 2.0 * w - v)
        w20 = answer(0.5 * c2 * z * z, k, mu, 2.0 * w)
        w21 = answer(0.75 * c3 * c * z * z, k, mu, 2.0 * w + v)
        w30 = answer(0.25 * c3 * z * z * z, k, mu, 3.0 * w)
        by_square = c * w1m1 + d * w11 + 2.0 * w00 * z + w20 * y
        by_cube = 2.0 * c * z * w01.conjugate() + 2.0 * d * z * w01 + c * c * w1m2 + 2.0 * c * y * w2m1
        by_cube = by_cube + d * d * w12 + 2.0 * d * y * w21 + y * y * w30
        small = (w00, w01, w02, w03, w1m2, w1m1, w11, w12, w2m1, w20, w21, w30)
        on_fast = c3 * (1.5 * cc * z + 0.75 * zz * z)
        return small, on_fast, c2 * by_square + 0.75 * c3 * by_cube


FORMS: dict[Fraction | None, Any] = {
    Fraction(1): Primary(),
    Fraction(3): Superharmonic(),
    Fraction(1, 3): Subharmonic(),
    Fraction(2): Twofold(),
    Fraction(1, 2): Half(),
    None: Nonresonant(),
}
