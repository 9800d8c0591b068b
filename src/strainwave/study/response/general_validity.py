"""Where multiple scales hold at the peak of the primary resonance of a cubic law: over alpha a^2 and damping ratio.

x'' + 2 zeta x' + x + alpha x^3 = A cos(omega t) is every drive with a cubic law, in units of its omega_0. It has no
parameter beside alpha a^2 and zeta. The true peak is a harmonic balance with given amplitude and a lag of 90 degrees,
in which speed and torque are unknown; under that torque each order has its own peak.
"""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...model.excitation import Harmonic
from ...model.laws.springs import Cubic
from ...model.oscillator import Oscillator
from ...results import Floats
from ...theory.slow_flow.certificate.balance import Balance, balance_of
from ...theory.slow_flow.fixed_points import newton_step, rates_of
from ...theory.slow_flow.multiple_scales import slow_flow
from ...theory.slow_flow.resonance import PRIMARY
from ...theory.slow_flow.setting import real_matrix
from ...theory.slow_flow.states import at
from .validity import axis
from .validity_results import ORDERS, GeneralValidity

ROUNDS, NEAR, STEP = 40, 1e-12, 1e-6  # of Newton's method: steps, last relative change; step of a difference in omega


def validity_in_general(bends: ArrayLike, damping_ratios: ArrayLike) -> GeneralValidity:
    """Where each order holds at the peak of the primary resonance of any drive with a hardening cubic law.

    Parameters
    ----------
    bends : (n,) array_like
        alpha a^2, positive, in rising order; a is the amplitude [rad, 0-to-peak] at the peak.
    damping_ratios : (m,) array_like
        zeta = B/(2 sqrt(J K)), positive, in rising order.

    Returns
    -------
    GeneralValidity
        Errors of both orders in amplitude and speed of the peak.

    Raises
    ------
    ValueError
        If the axes are not positive and rising.
    """
    bend, ratio = axis("bends", bends), axis("damping_ratios", damping_ratios)
    errors = np.ones((2, len(ORDERS), len(bend), len(ratio)))
    for j, zeta in enumerate(ratio.tolist()):
        drive = Oscillator(1.0, 2.0 * zeta, Cubic(1.0, 1.0), Harmonic(1.0), 1.0)
        flows = [slow_flow(drive, PRIMARY, order=order)._flow for order in ORDERS]
        a = np.sqrt(bend)
        omega, torque = _true_peak(balance_of(flows[0].setting), a)
        for i, flow in enumerate(flows):
            own, speed = _peak(flow, torque, a, omega)
            errors[:, i, :, j] = np.abs(own / a - 1.0), np.abs(speed / omega - 1.0)
    errors = np.where(np.isfinite(errors), np.minimum(errors, 1.0), 1.0)
    return GeneralValidity(bend, ratio, errors[0], errors[1])


def _true_peak(form: Balance, a: Floats) -> tuple[Floats, Floats]:
    """Speed and torque of motions with the first harmonic -i a; not finite where Newton's method does not converge."""
    h, s = form.harmonics, form.setting
    c = np.zeros((len(a), h + 1), complex)
    c[:, 1] = -1j * a
    omega, torque = np.sqrt(1.0 + 0.75 * a**2), 2.0 * a * s.mu
    for _ in range(ROUNDS):
        r, (matrix, _) = form.residual(c, omega), form.slopes(c, omega)
        r[:, 1] += s.torque_lines[0] - torque
        speed = np.multiply.outer(omega, np.arange(h + 1.0))
        slope = (-2.0 * speed + 1j * s.mu) * np.arange(h + 1.0) * c
        # the first harmonic is given: its columns are those of the torque and of the speed
        matrix[:, :, 1], matrix[:, 1, 1] = 0.0, -1.0
        matrix[:, :, h + 1] = np.concatenate([slope.real, slope.imag[:, 1:]], axis=1)
        right = np.concatenate([r.real, r.imag[:, 1:]], axis=1)
        step = -np.linalg.solve(matrix, right[..., None])[..., 0]
        torque, omega = torque + step[:, 1], omega + step[:, h + 1]
        step[:, 1], step[:, h + 1] = 0.0, 0.0
        c[:, 0] += step[:, 0]
        c[:, 1:] += step[:, 1 : h + 1] + 1j * step[:, h + 1 :]
        size = np.max(np.abs(step), axis=1) / a
        if np.max(size) < NEAR:
            break
    good = (size < 1e-8) & (omega > 0.0)
    return np.where(good, omega, np.nan), np.where(good, torque, np.nan)


def _peak(flow: Any, torque: Floats, a: Floats, omega: Floats) -> tuple[Floats, Floats]:
    """Amplitude [rad] and speed of a flow's own state with a lag of 90 degrees under a torque, from the true ones."""
    a, omega = a.copy(), omega.copy()
    with np.errstate(all="ignore"):
        for _ in range(ROUNDS):
            z: Any = -1j * a
            rate, by_z = rates_of(at(flow, omega, torque), z)
            up, down = (rates_of(at(flow, omega + d, torque), z)[0] for d in (STEP, -STEP))
            by_a = -(by_z[:, 0, 1] + 1j * by_z[:, 1, 1])
            step = newton_step(real_matrix(by_a, (up - down) / (2.0 * STEP)), rate)
            share = np.minimum(1.0, 0.3 / np.maximum(np.abs(step.real) / a, np.abs(step.imag) / omega))
            a, omega = a + share * step.real, omega + share * step.imag
            size = np.abs(step.real) / a + np.abs(step.imag) / omega
            if not np.any(size > NEAR):
                break
    good = (size < 1e-8) & (a > 0.0) & (omega > 0.0)
    return np.where(good, a, np.nan), np.where(good, omega, np.nan)
