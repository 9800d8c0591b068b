"""The certificate: what a steady state of a slow flow is worth, from a harmonic correction in the full equation.

The motion u0 + Re(z E) + F, at second order with its small harmonics, is put into
J u'' + B u' + T(u) = tau - J omega^2 e'', and Newton's method on a few harmonics of the common period moves it to the
true motion: see `balance`.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...base.results import Complexes, Floats
from .averages import varying
from .averages.law_samples import samples
from .averages.memory import remembers
from .averages.varying import varies
from .balance import Balance, balance_of, correct, follow
from .fixed_points import Flow, is_stable
from .results import Certificate
from .second_order import second_order
from .setting import Setting

ACCEPTED = 0.10
PUMPED = "; the speed lies beside a resonance, which decides on stability: give its Resonance(p, q)"
UNSTABLE = "; the true motion is not stable"
DOUBLED = f"{UNSTABLE}, its period doubles"
ORDINAL = {1: "first", 2: "second"}


def certify(flow: Flow, z: complex, order: int, *, curve: bool = False) -> Certificate:
    """Estimate the error of the steady state z of a slow flow, or of its curve; see `SlowFlow.certificate`."""
    s = flow.setting
    balance = balance_of(s)
    motion = balance.motion(flow, z)[None]
    speed = np.array([s.omega])
    # without damping, and where stiffness varies, the phase need not change along the curve
    turning = s.resonance.q == 1 and not varies(s.system) and (s.mu != 0.0 or balance.loops is not None)
    turn = np.array([z / abs(z)]) if z != 0.0 and turning else None
    at_phase = at_speed = correct(balance, motion, speed, None)
    if turn is not None:
        at_phase = correct(balance, motion, speed, turn)
    if at_phase.converged and not at_speed.converged:
        at_speed = follow(balance, at_phase, s.omega)
    solved, converged = at_speed.converged, at_phase.converged
    speed_errors = errors(balance, motion, at_speed.c, z != 0.0)
    phase_errors = errors(balance, motion, at_phase.c, z != 0.0)
    amplitude = float(phase_errors.amplitude[0]) if converged else max(float(phase_errors.amplitude[0]), 1.0)
    amplitude_at_speed = float(speed_errors.amplitude[0]) if solved else None
    shift = float(s.omega / at_phase.omega[0] - 1.0)
    largest = max(amplitude, abs(shift), amplitude_at_speed or 0.0)
    true = (at_speed.c, speed) if solved else (at_phase.c, at_phase.omega)
    remark = _instability(flow, z, balance, *true) if converged else ""
    remark = PUMPED + remark if z == 0.0 and _pumped(s) else remark
    certificate = Certificate(
        regime=str(s.resonance),
        order=order,
        valid=converged and (solved or curve) and largest <= ACCEPTED and not (remark or s.beyond(z)),
        amplitude=amplitude,
        phase=float(speed_errors.phase[0]) if solved else None,
        speed=shift,
        waveform=float(phase_errors.waveform[0]),
        amplitude_at_speed=amplitude_at_speed,
        nonlinearity=_nonlinearity(balance, motion[0]),
        damping=s.mu / s.omega_0,
        detuning=abs(s.fast - s.omega_0) / s.omega_0,
        quadrature_error=flow.error,
        sentence="",
    )
    return replace(certificate, sentence=_sentence(flow, z, certificate, converged, turn is not None) + remark)


def _instability(flow: Flow, z: complex, balance: Balance, c: Complexes, omega: Floats) -> str:
    """Remark on a stable state z whose true motion c at omega does not attract; empty where it does."""
    if not is_stable(flow, z) or balance.attracts(c, omega)[0]:
        return ""
    return DOUBLED if balance.doubles_period(c, omega)[0] else UNSTABLE


def _pumped(s: Setting) -> bool:
    """True if the forced motion can feed a small free one where no resonance was asked for.

    The free part then has a harmonic c of its own near -omega_0. With pumping q z* the growth rate is positive where
    q^2 > mu^2/4 + d^2, d the detuning, and |c/z|^2 = q^2/(mu^2/4 + 4 d^2): more than 1/4 wherever it grows.
    """
    if s.resonance.ratio is not None or not s.orders or remembers(s.system.law) or varies(s.system):
        return False
    force, tiny = second_order(s).force, 1e-6 * max(s.scales())
    with_it, without = force.values(s, tiny + 0j)[0], force.values(s, 0j)[0]
    return any(abs(a - b) > 0.5 * tiny for (_, a), (_, b) in zip(with_it, without, strict=True))


def _nonlinearity(balance: Balance, c: Complexes) -> float:
    """Largest torque beyond the linear one over the largest linear one, along a motion (H+1,)."""
    s = balance.setting
    u = samples(c[None], (np.arange(len(c)),), (balance.points,))[0] - s.u0
    linear = s.system.J * s.omega_0**2 * u
    if varies(s.system):
        torque = varying.torques(s, *balance.along(c[None], np.array([s.omega])))[0]
    elif balance.loops is None:
        torque = s.system.law.torque(s.u0 + u)
    else:
        torque = balance.loops.torque(c[None], s.omega * balance.base)[0]
    beyond = torque - s.mean - linear
    return float(np.max(np.abs(beyond))) / float(np.max(np.abs(linear))) if np.any(linear) else 0.0


class Errors(NamedTuple):
    """Differences of two sets of motions, each (states,): amplitude and waveform relative, phase [rad]."""

    amplitude: Floats
    phase: Floats
    waveform: Floats


def errors(balance: Balance, motion: Complexes, true: Complexes, has_fast: bool) -> Errors:
    """Compare motions (states, H+1) with true ones: the fast component, or where it is absent the whole motion."""
    size = np.linalg.norm(true[:, 1:], axis=1)
    off = np.linalg.norm(motion - true, axis=1)
    waveform = np.divide(off, size, out=np.zeros_like(size), where=size > 0.0)
    if not has_fast:
        return Errors(waveform, np.zeros_like(size), waveform)
    mine, its = motion[:, balance.fast], true[:, balance.fast]
    least = np.maximum(np.abs(its), 1e-3 * np.abs(mine))
    phase = np.abs(np.angle(mine * its.conj()))
    return Errors(np.abs(np.abs(mine) - least) / least, phase, waveform)


def _sentence(flow: Flow, z: complex, error: Certificate, converged: bool, at_phase: bool) -> str:
    """Verdict with its numbers; `at_phase` where the estimate is made at equal phase."""
    s, verdict = flow.setting, "valid" if error.valid else "not valid"
    motion = f"steady amplitude {abs(z):.6g} rad" if z != 0.0 else "forced motion"
    motion += "" if is_stable(flow, z) else " (not asymptotically stable)"
    lost = bool(s.inside(z) or s.beyond(z))
    if s.inside(z):
        estimate = f"it stays inside the gap of {s.gap:.6g} rad to both sides, where nothing holds its mean"
    elif lost:
        estimate = f"it passes a saddle of the law, {s.reach:.6g} rad from rest, from where motions do not come back"
    elif not converged:
        estimate = "a harmonic correction of it does not converge, so nothing is known of its error"
    elif not at_phase:
        estimate = f"its estimated error is {_percent(error.amplitude)} at equal speed"
    else:
        at_speed = error.amplitude_at_speed
        estimate = (
            f"its estimated error is {_percent(error.amplitude)} in amplitude and {_percent(abs(error.speed))} in "
            "speed at equal phase, "
        )
        estimate += (
            "and no exact state is near at equal speed" if at_speed is None else f"{_percent(at_speed)} at equal speed"
        )
    other = "second order, harmonic balance" if error.order == 1 and not lost else "harmonic balance"
    remedy = "" if error.valid else f"; use {other} or integration instead"
    name = f"{ORDINAL[error.order]}-order multiple scales ({s.resonance}, omega = {s.omega:.6g} rad/s)"
    return (
        f"{name} is {verdict} for the {motion}: {estimate} (limit {100.0 * ACCEPTED:.0f} %); nonlinear over linear "
        f"torque {error.nonlinearity:.2g}, mu/omega_0 {error.damping:.2g}, detuning {error.detuning:.2g}{remedy}"
    )


def _percent(share: float) -> str:
    return f"{100.0 * share:.2g} %"
