"""Harmonic balance of a few harmonics about a steady state of the slow flow: Newton's method to the true motion.

Where forcing or its superharmonic meets omega_0 (q = 1) the phase of the component near omega_0 is kept and omega set
free: the phase runs monotonically along a resonance curve, so the correction exists at peaks and jumps too, where one
at equal speed does not. Otherwise the speed is kept (Krack & Gross 2019, Harmonic Balance for Nonlinear Vibration
Problems, ch. 2).
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from ...base.law import breakpoints_of
from ...base.results import Complexes, Floats
from ...numerics.addressed import stiffnesses, torques
from .averages import varying
from .averages.law_samples import harmonics, means, samples
from .averages.memory import Loops, remembers
from .averages.varying import varies
from .fixed_points import Flow
from .setting import Setting

SMOOTH, KINKED = 8, 64  # sample points per harmonic
MULTIPLES = 7  # harmonics up to this multiple of the fastest component of the first-order motion
MOST_STEPS, FEW_STEPS, CONVERGED = 30, 8, 1e-9  # of Newton's method, and the relative change at which it has converged
LEAST_STEP, MOST_CHANGE = 1e-6, 0.2  # of a motion followed to another speed: of the speed, and of its fast component
CONVERGED_ON_LOOPS, STEP = 1e-7, 1e-5  # the same change along closed loops, and the relative step of differences there


@dataclass(frozen=True, eq=False)
class Balance:
    """Harmonic balance of the torsion u over the common period, complex coefficients 0..H of the angle chi = omega_b t.

    Attributes
    ----------
    base : float
        omega_b/omega: the common period is 2 pi/(omega_b).
    fast : int
        Harmonic of the component near omega_0.
    harmonics, points : int
        H, and samples of the common period.
    """

    setting: Setting
    base: float
    fast: int
    harmonics: int
    points: int

    @cached_property
    def loops(self) -> Loops | None:
        """The closed loops of a law with friction or memory; None of a spring."""
        law = self.setting.system.law
        return Loops(law, self.harmonics, self.points) if remembers(law) else None

    def motion(self, flow: Flow, z: Any) -> Complexes:
        """Coefficients of u0 + Re(z E) + F and, at second order, of the small harmonics: (..., H+1) of many speeds."""
        c = np.zeros((*np.shape(z), self.harmonics + 1), complex)
        c[..., 0] = self.setting.u0
        for i, harmonic in enumerate(self.setting.places):
            c[..., harmonic] += self.setting.hard[..., i]
        c[..., self.fast] += z
        for speed, small in flow.small(z):
            multiple = float(np.ravel(speed / (self.base * self.setting.omega))[0])
            if np.any(z != 0.0) or (0.0 <= multiple < self.harmonics + 0.5 and abs(multiple - round(multiple)) < 1e-9):
                c[..., round(multiple)] += small  # without resonance the free part, of other speeds, is absent
        return c

    def torque(self, c: Complexes, omega: Floats) -> Complexes:
        """Harmonics [N*m] (states, H+1) of the law's torque along motions, and of what varies."""
        if self.loops is not None:
            return self.loops.coefficients(self.loops.torque(c, omega * self.base))
        if varies(self.setting.system):
            torque = 2.0 * self._varied(varying.torques, c, omega, self.harmonics)
        else:
            torque = 2.0 * self._means(torques, c, self.harmonics)
        torque[..., 0] *= 0.5
        return torque

    def along(self, c: Complexes, omega: Floats) -> tuple[Floats, Floats, Floats]:
        """Base angle [rad] (n,), torsion [rad] and its rate [rad/s] (states, n) at the samples of motions."""
        numbers, points = np.arange(self.harmonics + 1), (self.points,)
        turning = 1j * np.multiply.outer(omega, numbers * self.base) * c
        theta = 2.0 * np.pi / self.base * np.arange(self.points) / self.points
        return theta, samples(c, (numbers,), points), samples(turning, (numbers,), points)

    def _varied(self, values: Any, c: Complexes, omega: Floats, top: int) -> Complexes:
        """Harmonics (states, top+1) of a varying torque, stiffness or damping along motions, as means."""
        return means(values(self.setting, *self.along(c, omega)), (np.arange(top + 1),))

    def _means(self, values: Any, c: Complexes, top: int) -> Complexes:
        """Harmonics (states, top+1) of a spring's values along motions, as means."""
        places = (np.arange(self.harmonics + 1),), (np.arange(top + 1),)
        return harmonics(values, self.setting.system.law, c, *places, (self.points,))

    def torque_slopes(self, c: Complexes, omega: Floats) -> tuple[Floats, Any]:
        """Derivatives of `torque`, as real and imaginary parts, to those of c and to omega.

        Those of closed loops are taken by differences.
        """
        h = self.harmonics
        if varies(self.setting.system):
            return self._varied_slopes(c, omega)
        if self.loops is None:
            return self._slopes_of(self._means(stiffnesses, c, 2 * h)), 0.0
        units = np.concatenate([np.eye(h + 1), 1j * np.eye(h + 1)[1:]])
        d = STEP * np.max(np.abs(c), axis=1)[:, None, None] * units
        speeds = np.repeat(omega, len(units))
        ends = [self.torque((c[:, None] + side * d).reshape(-1, h + 1), speeds) for side in (1.0, -1.0)]
        rise = (ends[0] - ends[1]).reshape(len(c), len(units), h + 1) / (2.0 * np.max(np.abs(d), axis=2)[..., None])
        matrix = np.concatenate([rise.real, rise.imag[..., 1:]], axis=2).transpose(0, 2, 1)
        step = STEP * np.asarray(omega)
        faster, slower = self.torque(c, omega + step), self.torque(c, omega - step)
        return matrix, (faster - slower) / (2.0 * step[:, None])

    def residual(self, c: Complexes, omega: Floats) -> Complexes:
        """Residual [N*m] (states, H+1) of every harmonic.

        One state or many: c is (states, H+1), omega (states,).
        """
        s, torque = self.setting, self.torque(c, omega)
        speed = np.multiply.outer(omega, np.arange(self.harmonics + 1) * self.base)
        r = (-s.system.J * speed**2 + 1j * s.B * speed) * c + torque
        r[..., 0] -= s.mean
        for i, (harmonic, k) in enumerate(zip(s.places, s.orders, strict=True)):
            r[..., harmonic] -= s.torque_lines[..., i] + s.system.J * (k * omega) ** 2 * s.error_lines[..., i]
        return np.asarray(r)

    def attracts(self, c: Complexes, omega: Floats) -> Any:
        """True for true motions (states, H+1) that attract: no real Floquet multiplier beyond 1 or -1.

        The determinant of the balance is a positive multiple of (1 - m_1)(1 - m_2) of the multipliers m.
        """
        return (np.linalg.slogdet(self.slopes(c, omega)[0])[0] > 0.0) & ~self.doubles_period(c, omega)

    def doubles_period(self, c: Complexes, omega: Floats) -> Any:
        """True where a disturbance of twice the period grows on true motions (states, H+1) of a spring.

        Hill's determinant at half orders is a positive multiple of (1 + m_1)(1 + m_2).
        Along closed loops it is not looked at.
        """
        if self.loops is not None:
            return np.zeros(len(c), bool)
        s, i = self.setting, np.arange(2 * self.harmonics)
        speed = np.multiply.outer(omega, (i - self.harmonics + 0.5) * self.base)

        def spread(spectrum: Complexes) -> Complexes:
            matrix = spectrum[:, np.abs(i[:, None] - i)]
            return np.where(i[:, None] < i, matrix.conj(), matrix)

        if varies(s.system):
            pull, drag = (
                self._varied(f, c, omega, 2 * self.harmonics) for f in (varying.stiffnesses, varying.dampings)
            )
            matrix = spread(pull) + spread(drag) * (1j * speed)[:, None, :]
        else:
            matrix = spread(self._means(stiffnesses, c, 2 * self.harmonics))
        matrix[:, i, i] += (1j * s.B - s.system.J * speed) * speed
        return np.linalg.slogdet(matrix)[0].real < 0.0

    def slopes(self, c: Complexes, omega: Floats) -> tuple[Floats, Any]:
        """Derivatives of the residual to the real unknowns, and of its torque to omega."""
        matrix, by_omega = self.torque_slopes(c, omega)
        return self._with_inertia(matrix, np.multiply.outer(omega, np.arange(self.harmonics + 1) * self.base)), by_omega

    def _varied_slopes(self, c: Complexes, omega: Floats) -> tuple[Floats, Any]:
        """Derivatives of the harmonics of what varies to the real unknowns and to omega."""
        h, j = self.harmonics, np.arange(1, self.harmonics + 1)
        theta, u, v = self.along(c, omega)
        pull, drag = varying.stiffnesses(self.setting, theta, u, v), varying.dampings(self.setting, theta, u, v)
        by_torsion, by_rate = (self._slopes_of(means(part, (np.arange(2 * h + 1),))) for part in (pull, drag))
        speed = np.multiply.outer(omega, j * self.base)[:, None, :]
        by_torsion[:, :, j] += speed * by_rate[:, :, h + j]  # the rate of harmonic k is i k of it
        by_torsion[:, :, h + j] -= speed * by_rate[:, :, j]
        by_omega = 2.0 * means(drag * v, (np.arange(h + 1),)) / omega[:, None]
        by_omega[:, 0] *= 0.5
        return by_torsion, by_omega

    def _slopes_of(self, spectrum: Complexes) -> Floats:
        """Derivative of harmonics of torque to the real unknowns (Re c_0..c_H, Im c_1..c_H), by that of the slope."""
        h = self.harmonics
        i = np.arange(h + 1)
        # the slope times cos m and -sin m, projected on both: its harmonics at the sums and differences
        total, apart = spectrum[:, i[:, None] + i], spectrum[:, np.abs(i[:, None] - i)]
        sign = np.sign(i[:, None] - i)
        even, odd = apart.real + total.real, sign * apart.imag
        matrix = np.empty((len(spectrum), 2 * h + 1, 2 * h + 1))
        matrix[:, : h + 1, : h + 1] = even
        matrix[:, : h + 1, h + 1 :] = (total.imag - odd)[:, :, 1:]
        matrix[:, h + 1 :, : h + 1] = (total.imag + odd)[:, 1:]
        matrix[:, h + 1 :, h + 1 :] = (apart.real - total.real)[:, 1:, 1:]
        matrix[:, 0] *= 0.5
        return matrix

    def _with_inertia(self, matrix: Floats, speed: Floats) -> Floats:
        """Add what inertia and damping take from the residual to the derivative of the torque."""
        s, h = self.setting, self.harmonics
        i, j = np.arange(h + 1), np.arange(1, h + 1)
        matrix[:, i, i] -= s.system.J * speed**2
        matrix[:, h + j, h + j] -= s.system.J * speed[:, 1:] ** 2
        matrix[:, j, h + j] -= s.B * speed[:, 1:]
        matrix[:, h + j, j] += s.B * speed[:, 1:]
        return matrix

    def newton(self, c: Complexes, omega: Floats, turn: Complexes | None) -> tuple[Complexes, Floats]:
        """One Newton step of every state; with `turn`, the fast part's direction, its phase is kept, not omega."""
        r, (matrix, by_omega) = self.residual(c, omega), self.slopes(c, omega)
        s, h = self.setting, self.harmonics
        multiples = np.arange(h + 1) * self.base
        speed = np.multiply.outer(omega, multiples)
        right = -np.concatenate([r.real, r.imag[:, 1:]], axis=1)
        if turn is None:
            step = np.linalg.solve(matrix, right[..., None])[..., 0]
            step = np.concatenate([step, np.zeros((len(c), 1))], axis=1)
        else:
            slope = (-2.0 * s.system.J * speed + 1j * s.B) * multiples * c + by_omega
            for i_line, (harmonic, k) in enumerate(zip(s.places, s.orders, strict=True)):
                slope[:, harmonic] -= 2.0 * s.system.J * k * k * omega * s.error_lines[..., i_line]
            bordered = np.zeros((len(c), 2 * h + 2, 2 * h + 2))
            bordered[:, :-1, :-1] = matrix
            bordered[:, :-1, -1] = np.concatenate([slope.real, slope.imag[:, 1:]], axis=1)
            bordered[:, -1, self.fast], bordered[:, -1, h + self.fast] = -turn.imag, turn.real
            right = np.concatenate([right, np.zeros((len(c), 1))], axis=1)
            step = np.linalg.solve(bordered, right[..., None])[..., 0]
        change = step[:, : h + 1].astype(complex)
        change[:, 1:] += 1j * step[:, h + 1 : -1]
        return c + change, omega + step[:, -1]


@dataclass(frozen=True, eq=False)
class Correction:
    """Motion that Newton's method in the full equation leads to.

    Attributes
    ----------
    c : (1, H+1) complex array
        Coefficients [rad]; after one step only where the correction does not converge.
    omega : (1,) array
        Speed of the base angle [rad/s].
    converged : bool
        True if it is a true motion.
    """

    c: Complexes
    omega: Floats
    converged: bool


def correct(
    balance: Balance, c: Complexes, omega: Floats, turn: Complexes | None, steps: int = MOST_STEPS
) -> Correction:
    """Correct an approximate motion by Newton's method; `turn` is that of `Balance.newton`."""
    first, tolerance = (c, omega), CONVERGED if balance.loops is None else CONVERGED_ON_LOOPS
    for round_ in range(steps):
        try:
            new, speed = balance.newton(c, omega, turn)
        except np.linalg.LinAlgError:
            break
        if not (np.all(np.isfinite(new)) and speed[0] > 0.0):
            break
        first = (new, speed) if round_ == 0 else first
        size = np.max(np.abs(new))
        with np.errstate(all="ignore"):
            change = np.max(np.abs(new - c)) + size * np.abs(speed[0] / omega[0] - 1.0)
        if change <= tolerance * np.max(np.abs(c)):
            return Correction(new, speed, True)
        c, omega = new, speed
    return Correction(*first, False)


def follow(balance: Balance, true: Correction, omega: float) -> Correction:
    """Follow a true motion along its curve to a speed [rad/s]; not converged where the curve turns back before."""
    step = omega - true.omega
    while abs(step[0]) > LEAST_STEP * omega:
        moved = correct(balance, true.c, true.omega + step, None, FEW_STEPS)
        change = np.abs((moved.c - true.c)[:, balance.fast]) / np.abs(true.c[:, balance.fast])
        if moved.converged and change[0] <= MOST_CHANGE:
            true, left = moved, omega - moved.omega
            step = np.where(np.abs(2.0 * step) < np.abs(left), 2.0 * step, left)
        else:
            step = 0.5 * step
    return replace(true, converged=bool(abs(omega - true.omega[0]) <= LEAST_STEP * omega))


def balance_of(s: Setting) -> Balance:
    """The harmonic balance of a setting, over the common period of the fast angle and all lines."""
    law, harmonics = s.system.law, MULTIPLES * s.top
    kinked = len(breakpoints_of(law)) > 0 or remembers(law)
    points = s.points((KINKED if kinked else SMOOTH) * (harmonics + 1))
    return Balance(s, s.base / max(s.resonance.q, 1), s.fast_place, harmonics, points)
