"""The certificate: what a first-order steady state is worth, from a harmonic correction in the full equation.

The first-order motion u0 + Re(z E) + F is put into J u'' + B u' + T(u) = tau - J omega^2 e'', and Newton's method on a
few harmonics of the common period (Krack & Gross 2019, Harmonic Balance for Nonlinear Vibration Problems, ch. 2) moves
it to the true motion. Where forcing or its superharmonic meets omega_0 (q = 1) the phase of the component near omega_0
is kept and omega set free: the phase runs monotonically along a resonance curve, so the correction exists at peaks and
jumps too, where one at equal speed does not. Otherwise the speed is kept.
"""

import math
from dataclasses import dataclass

import numpy as np

from ...results import Floats
from .averaging import AveragedFlow
from .fixed_points import Flow, is_stable
from .results import Certificate
from .setting import Complexes, Setting

MULTIPLES = 7  # harmonics up to this multiple of the fastest component of the first-order motion
ACCEPTED = 0.10


@dataclass(frozen=True, eq=False)
class Balance:
    """Harmonic balance of the torsion u over the common period, complex coefficients 0..H of the angle chi = omega_b t.

    Attributes
    ----------
    base : float
        omega_b/omega: the common period is 2 pi/(omega_b).
    fast : int
        Harmonic of the component near omega_0.
    """

    setting: Setting
    base: float
    fast: int
    harmonics: int

    @property
    def places(self) -> list[int]:
        """Harmonics of the forcing lines."""
        return [round(k / self.base) for k in self.setting.orders]

    def waves(self) -> Complexes:
        """exp(i n chi) for n = 0..H at 8H + 8 points: shape (H+1, points)."""
        points = 8 * self.harmonics + 8
        return np.asarray(np.exp(2j * np.pi * np.outer(np.arange(self.harmonics + 1), np.arange(points)) / points))

    def first_order(self, z: complex) -> Complexes:
        """Coefficients of u0 + Re(z E) + F."""
        c = np.zeros(self.harmonics + 1, complex)
        c[0] = self.setting.u0
        for place, line in zip(self.places, self.setting.hard, strict=True):
            c[place] += line
        c[self.fast] += z
        return c

    def residual(self, c: Complexes, omega: float, waves: Complexes) -> tuple[Complexes, Floats]:
        """Residual [N*m] of every harmonic, and the stiffness [N*m/rad] at the sample points."""
        s, n = self.setting, np.arange(self.harmonics + 1)
        u = (c @ waves).real
        torque = (waves.conj() @ s.system.law.torque(u)) * (2.0 / u.size)
        torque[0] *= 0.5
        speed = n * self.base * omega
        r = (-s.system.J * speed**2 + 1j * s.system.B * speed) * c + torque
        r[0] -= s.system.law.torque(s.u0)
        for place, k, tau, e in zip(self.places, s.orders, s.torque_lines, s.error_lines, strict=True):
            r[place] -= tau + s.system.J * (k * omega) ** 2 * e
        return r, s.system.law.stiffness(u) + 0.0 * u

    def newton(self, c: Complexes, omega: float, turn: complex | None) -> tuple[Complexes, float]:
        """One Newton step; with `turn` (the direction of the fast component) its phase is kept and omega is free."""
        waves = self.waves()
        r, stiffness = self.residual(c, omega, waves)
        s, h = self.setting, self.harmonics
        speed = np.arange(h + 1) * self.base * omega
        # real unknowns (Re c_0..c_H, Im c_1..c_H), synthesis u = synthesis @ unknowns
        synthesis = np.vstack([waves.real, -waves.imag[1:]])
        weight = np.full(2 * h + 1, 2.0 / waves.shape[1])
        weight[0] *= 0.5
        matrix = (weight[:, None] * synthesis * stiffness) @ synthesis.T
        i, j = np.arange(h + 1), np.arange(h + 1, 2 * h + 1)
        matrix[i, i] -= s.system.J * speed**2
        matrix[j, j] -= s.system.J * speed[1:] ** 2
        matrix[i[1:], j] -= s.system.B * speed[1:]
        matrix[j, i[1:]] += s.system.B * speed[1:]
        d = 1e-6 * omega
        slope = (self.residual(c, omega + d, waves)[0] - self.residual(c, omega - d, waves)[0]) / (2.0 * d)
        right = -np.concatenate([r.real, r.imag[1:]])
        if turn is None:
            step = np.append(np.linalg.solve(matrix, right), 0.0)
        else:
            keep = np.zeros(2 * h + 2)
            keep[self.fast], keep[h + self.fast] = -turn.imag, turn.real
            column = np.concatenate([slope.real, slope.imag[1:]])[:, None]
            step = np.linalg.solve(np.vstack([np.hstack([matrix, column]), keep]), np.append(right, 0.0))
        return c + np.append(step[0], step[1 : h + 1] + 1j * step[h + 1 : -1]), omega + float(step[-1])


def certify(flow: Flow, z: complex) -> Certificate:
    """Estimate the error of the steady state z of a slow flow; see `SlowFlow.certificate`."""
    s = flow.setting
    balance = _balance(s)
    c0 = balance.first_order(z)
    part = balance.fast if z != 0.0 else None
    # without damping the phase does not change along the curve
    follow = z / abs(z) if z != 0.0 and s.resonance.q == 1 and s.mu != 0.0 else None
    here, _, found = _corrected(balance, c0, s.omega, None)
    at_speed = _error(c0, here, part) if found else None
    c, omega, converged = (here, s.omega, found) if follow is None else _corrected(balance, c0, s.omega, follow)
    error = _error(c0, c, part)
    if not converged:
        error = max(error, 1.0)
    shift = s.omega / omega - 1.0
    waves = balance.waves()
    u = (c0 @ waves).real - s.u0
    linear = float(s.system.law.stiffness(s.u0)) * u
    beyond = s.system.law.torque(s.u0 + u) - s.system.law.torque(s.u0) - linear
    nonlinearity = float(np.max(np.abs(beyond))) / float(np.max(np.abs(linear))) if np.any(linear) else 0.0
    valid = converged and max(error, abs(shift), at_speed or 0.0) <= ACCEPTED
    quadrature = flow.error if isinstance(flow, AveragedFlow) else 0.0
    damping, detuning = s.mu / s.omega_0, abs(s.fast - s.omega_0) / s.omega_0
    return Certificate(
        str(s.resonance), valid, error, shift, at_speed, nonlinearity, damping, detuning, quadrature,
        _sentence(
            flow, z, (valid, converged, follow is not None), (error, shift, at_speed), (nonlinearity, damping, detuning)
        ),
    )  # fmt: skip


def _balance(s: Setting) -> Balance:
    ratio = s.resonance.ratio
    p, q = (0, 1) if ratio is None else (ratio.numerator, ratio.denominator)
    divisor = math.gcd(p, *(q * k for k in s.orders)) or 1
    top = max(p, *(q * k for k in s.orders), divisor) // divisor
    return Balance(s, divisor / q, p // divisor, MULTIPLES * top)


def _corrected(balance: Balance, c: Complexes, omega: float, turn: complex | None) -> tuple[Complexes, float, bool]:
    """Newton to convergence from the first-order motion; the first step alone where it does not converge."""
    start, first = c, None
    for _ in range(30):
        try:
            new, speed = balance.newton(c, omega, turn)
        except np.linalg.LinAlgError:
            break
        if not (np.all(np.isfinite(new)) and speed > 0.0):
            break
        first = first or (new, speed)
        change = float(np.max(np.abs(new - c))) + float(np.max(np.abs(new))) * abs(speed / omega - 1.0)
        c, omega = new, speed
        if change <= 1e-9 * float(np.max(np.abs(c))):
            return c, omega, True
    return (*(first or (start, omega)), False)


def _error(first_order: Complexes, corrected: Complexes, part: int | None) -> float:
    """Relative difference of the fast component's amplitude, or of the whole forced motion where there is none."""
    if part is not None:
        true = max(abs(corrected[part]), 1e-3 * abs(first_order[part]))
        return float(abs(abs(first_order[part]) - true) / true)
    size = float(np.linalg.norm(corrected[1:]))
    return float(np.linalg.norm(first_order - corrected)) / size if size > 0.0 else 0.0


def _sentence(
    flow: Flow,
    z: complex,
    facts: tuple[bool, bool, bool],
    error: tuple[float, float, float | None],
    small: tuple[float, float, float],
) -> str:
    s, (valid, converged, followed) = flow.setting, facts
    verdict = "valid" if valid else "not valid"
    what = f"steady amplitude {abs(z):.6g} rad" if z != 0.0 else "forced motion"
    what += "" if is_stable(flow, z) else " (not asymptotically stable)"
    if not converged:
        estimate = "a harmonic correction of it does not converge, so nothing is known of its error"
    elif followed:
        estimate = (
            f"its estimated error is {100.0 * error[0]:.2g} % in amplitude and {100.0 * error[1]:.2g} % in speed "
            "at equal phase, "
            + (
                "and at equal speed no true state is near it"
                if error[2] is None
                else f"{100.0 * error[2]:.2g} % at equal speed"
            )
        )
    else:
        estimate = f"its estimated error is {100.0 * error[0]:.2g} % at equal speed"
    remedy = "" if valid else "; use integration or harmonic balance instead"
    return (
        f"first-order multiple scales ({s.resonance}, omega = {s.omega:.6g} rad/s) is {verdict} for the {what}: "
        f"{estimate} (limit {100.0 * ACCEPTED:.0f} %); nonlinear over linear torque {small[0]:.2g}, "
        f"mu/omega_0 {small[1]:.2g}, detuning {small[2]:.2g}{remedy}"
    )
