"""Errors of multiple scales at the peak of the primary resonance of any drive with a hardening cubic law."""

from dataclasses import replace

import numpy as np

import strainwave as sw
from strainwave.theory.slow_flow.certificate import balance_of
from strainwave.theory.slow_flow.fixed_points import newton_step
from strainwave.theory.slow_flow.setting import real_matrix

ROUNDS, NEAR, STEP = 40, 1e-12, 1e-6  # of Newton's method: steps, last relative change; step of a difference in omega


def errors_at_peak(bends, zeta):
    """Relative errors (amplitude and speed, first and second order, bends) at peaks with these alpha a^2."""
    errors = np.ones((2, 2, len(bends)))
    drive = sw.Oscillator(1.0, 2.0 * zeta, sw.Cubic(1.0, 1.0), sw.Harmonic(1.0), 1.0)
    flows = [sw.slow_flow(drive, sw.PRIMARY, order=order)._flow for order in (1, 2)]
    a = np.sqrt(np.asarray(bends, float))
    omega, torque = _true_peak(balance_of(flows[0].setting), a)
    for i, flow in enumerate(flows):
        own, speed = _peak(flow, torque, a, omega)
        errors[:, i] = np.abs(own / a - 1.0), np.abs(speed / omega - 1.0)
    return np.where(np.isfinite(errors), np.minimum(errors, 1.0), 1.0)


def _true_peak(form, a):
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


def _at(flow, omega, torque):
    """The flow at speeds under a torque of amplitude 1 times factors."""
    lines = np.multiply.outer(torque, flow.setting.torque_lines)
    return replace(flow, setting=replace(flow.setting, torque_lines=lines)).at(omega)


def _peak(flow, torque, a, omega):
    """Amplitude [rad] and speed of a flow's own state with a lag of 90 degrees under a torque, from the true ones."""
    a, omega = a.copy(), omega.copy()
    with np.errstate(all="ignore"):
        for _ in range(ROUNDS):
            z = -1j * a
            rate, by_z = _at(flow, omega, torque).balance(z)
            up = _at(flow, omega + STEP, torque).balance(z)[0]
            down = _at(flow, omega - STEP, torque).balance(z)[0]
            by_a = -(by_z[:, 0, 1] + 1j * by_z[:, 1, 1])
            step = newton_step(real_matrix(by_a, (up - down) / (2.0 * STEP)), rate)
            share = np.minimum(1.0, 0.3 / np.maximum(np.abs(step.real) / a, np.abs(step.imag) / omega))
            a, omega = a + share * step.real, omega + share * step.imag
            size = np.abs(step.real) / a + np.abs(step.imag) / omega
            if not np.any(size > NEAR):
                break
    good = (size < 1e-8) & (a > 0.0) & (omega > 0.0)
    return np.where(good, a, np.nan), np.where(good, omega, np.nan)
