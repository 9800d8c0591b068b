"""The certificate: what a steady state of a slow flow is worth, from a harmonic correction in the full equation.

The motion u0 + Re(z E) + F, at second order with its small harmonics, is put into
J u'' + B u' + T(u) = tau - J omega^2 e'', and Newton's method on a few harmonics of the common period (Krack & Gross
2019, Harmonic Balance for Nonlinear Vibration Problems, ch. 2) moves it to the true motion. Where forcing or its
superharmonic meets omega_0 (q = 1) the phase of the component near omega_0 is kept and omega set free: the phase runs
monotonically along a resonance curve, so the correction exists at peaks and jumps too, where one at equal speed does
not. Otherwise the speed is kept.
"""

from typing import NamedTuple

import numpy as np

from ....base.results import Floats
from ..fixed_points import Flow, is_stable
from ..means.memory import remembers
from ..results import Certificate
from ..second_order import second_order
from ..setting import Complexes, Setting
from .balance import Balance, balance_of, corrected

ACCEPTED = 0.10
ORDINAL = {1: "first", 2: "second"}


def certify(flow: Flow, z: complex, order: int) -> Certificate:
    """Estimate the error of the steady state z of a slow flow; see `SlowFlow.certificate`."""
    s = flow.setting
    balance = balance_of(s)
    c0 = balance.motion(flow, z)[None]
    speed = np.array([s.omega])
    # without damping the phase does not change along the curve
    turn = (
        np.array([z / abs(z)])
        if z != 0.0 and s.resonance.q == 1 and (s.mu != 0.0 or balance.loops is not None)
        else None
    )
    here = corrected(balance, c0, speed, None)
    along = here if turn is None else corrected(balance, c0, speed, turn)
    at_speed = errors(balance, c0, here.c, z != 0.0)
    at_phase = errors(balance, c0, along.c, z != 0.0)
    found, converged = bool(here.converged[0]), bool(along.converged[0])
    amplitude = float(at_phase.amplitude[0]) if converged else max(float(at_phase.amplitude[0]), 1.0)
    shift = float(s.omega / along.omega[0] - 1.0)
    largest = max(amplitude, abs(shift), float(at_speed.amplitude[0]) if found else 0.0)
    small = Smallness(_nonlinearity(balance, c0[0]), s.mu / s.omega_0, abs(s.fast - s.omega_0) / s.omega_0)
    numbers = Estimate(
        amplitude, float(at_speed.phase[0]) if found else None, shift, float(at_phase.waveform[0]),
        float(at_speed.amplitude[0]) if found else None,
    )  # fmt: skip
    pumped = z == 0.0 and _pumped(s)
    valid = converged and largest <= ACCEPTED and not pumped
    sentence = _sentence(flow, z, (order, valid, converged, turn is not None), numbers, small)
    if pumped:
        sentence += "; the speed lies beside a resonance, which decides on stability: give its Resonance(p, q)"
    return Certificate(str(s.resonance), order, valid, *numbers, *small, flow.error, sentence)


def _pumped(s: Setting) -> bool:
    """Whether the forced motion can feed a small free one where no resonance was asked for.

    The free part then has a harmonic c of its own near -omega_0. With pumping q z* the growth rate is positive where
    q^2 > mu^2/4 + d^2, d the detuning, and |c/z|^2 = q^2/(mu^2/4 + 4 d^2): more than 1/4 wherever it grows.
    """
    if s.resonance.ratio is not None or not s.orders or remembers(s.system.law):
        return False
    force, tiny = second_order(s).force, 1e-6 * max(s.scales())
    with_it, without = force.values(s, tiny + 0j)[0], force.values(s, 0j)[0]
    return any(abs(a - b) > 0.5 * tiny for (_, a), (_, b) in zip(with_it, without, strict=True))


class Smallness(NamedTuple):
    """What multiple scales take for small."""

    nonlinearity: float
    damping: float
    detuning: float


class Estimate(NamedTuple):
    """Estimated errors; see `Certificate`."""

    amplitude: float
    phase: float | None
    speed: float
    waveform: float
    amplitude_at_speed: float | None


def _nonlinearity(balance: Balance, c: Complexes) -> float:
    s = balance.setting
    u = (c @ balance.waves).real - s.u0
    linear = float(s.system.law.stiffness(s.u0)) * u
    if balance.loops is None:
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


def _sentence(flow: Flow, z: complex, facts: tuple[int, bool, bool, bool], error: Estimate, small: Smallness) -> str:
    s, (order, valid, converged, followed) = flow.setting, facts
    verdict = "valid" if valid else "not valid"
    what = f"steady amplitude {abs(z):.6g} rad" if z != 0.0 else "forced motion"
    what += "" if is_stable(flow, z) else " (not asymptotically stable)"
    if not converged:
        estimate = "a harmonic correction of it does not converge, so nothing is known of its error"
    elif followed:
        estimate = (
            f"its estimated error is {_percent(error.amplitude)} in amplitude and {_percent(abs(error.speed))} in "
            "speed at equal phase, "
            + (
                "and at equal speed no true state is near it"
                if error.amplitude_at_speed is None
                else f"{_percent(error.amplitude_at_speed)} at equal speed"
            )
        )
    else:
        estimate = f"its estimated error is {_percent(error.amplitude)} at equal speed"
    remedy = "" if valid else "; use second order, harmonic balance or integration instead"
    remedy = remedy if order == 1 else remedy.replace("second order, ", "")
    return (
        f"{ORDINAL[order]}-order multiple scales ({s.resonance}, omega = {s.omega:.6g} rad/s) is {verdict} for the "
        f"{what}: {estimate} (limit {100.0 * ACCEPTED:.0f} %); nonlinear over linear torque {small.nonlinearity:.2g}, "
        f"mu/omega_0 {small.damping:.2g}, detuning {small.detuning:.2g}{remedy}"
    )


def _percent(share: float) -> str:
    return f"{100.0 * share:.2g} %"
