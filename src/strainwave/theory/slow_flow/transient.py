"""Transients of the slow flow: from a physical start to x(t)."""

import math
from typing import Any, NamedTuple

import numpy as np

from ...base.quantities import numbers, shown
from ...base.results import Floats, SolveError
from ...base.sentences import Angle, Sentence, Speed
from ...numerics.integration.addressed_steps import try_step
from ...numerics.integration.step_control import first_step
from ...numerics.integration.steps import dense_weights, weighted
from ...numerics.integration.workspace import DENSE, K1, Y1, K, Y, turned, workspace
from .averages.memory import remembers
from .averages.varying import varies
from .averaging import AveragedFlow, Sampled
from .closed_forms import CubicFlow
from .fixed_points import Flow
from .results import Evolution
from .second_order import SecondOrderFlow

RTOL, MOST_STEPS = 1e-9, 200_000
ROUNDS = 8  # of the start of a motion with small harmonics
SLOWEST = 0.5  # of omega_0: below it what z'' makes of the rates is no correction any more
DECAY = 256  # pieces in time of a free decay
DIFFERENCE_STEP = 1e-4  # over omega_0: of the time between which rates are compared
ACCEPTED, JUDGED = 0.10, 257  # largest estimated error of a valid transient, and times at which it is estimated
SAMPLES, MOST_SAMPLES = 32, 1e7  # per period of the fastest component, and in all, where the caller names only the end


def evolve(flow: Flow, y0: tuple[float, float], t: Floats) -> Evolution:
    """Integrate the slow flow from the state that y0 = (x, x') at t[0] means, and put x(t) together again.

    With u = u0 + Re(z E) + F the start asks Re(z E) = x - e - u0 - F and Re((i Omega z + z') E) = x' - omega (e' + F'),
    so x and its derivative leave from y0 exactly (z' is of first order: without it the start would be off by
    mu/omega_0).
    """
    s = flow.setting
    if isinstance(flow, SecondOrderFlow) and s.fast < SLOWEST * s.omega_0:
        raise SolveError(
            Sentence(
                f"at omega = {{}} the speed of the fast angle is {s.fast / s.omega_0:.3g} omega_0, too far from "
                "resonance for a transient of second order; use NONRESONANT, or integrate",
                Speed(s.omega),
            )
        )
    with np.errstate(all="ignore"):  # what is not finite is refused in a sentence
        evolution = _evolved(flow, y0, t)
        if not (np.all(np.isfinite(evolution.x)) and np.all(np.isfinite(evolution.rate))):
            raise _lost(y0)
        return evolution


def _lost(y0: tuple[float, float]) -> SolveError:
    return SolveError(
        Sentence(
            f"the slow flow does not reach from x = {{}}, x' = {y0[1]:.6g} rad/s to the end of these times with finite "
            "amplitudes; start closer to equilibrium, check the signs of damping and stiffness, or integrate",
            Angle(y0[0]),
        )
    )


def _evolved(flow: Flow, y0: tuple[float, float], t: Floats) -> Evolution:
    s = flow.setting
    e, start = s.system.error, float(t[0])
    theta, turn = s.omega * start, complex(np.exp(1j * s.fast * start))
    x = y0[0] - float(e.value(theta)) - s.u0 - float(s.forced(theta))
    v = y0[1] - s.omega * (float(e.slope(theta)) + float(s.forced_slope(theta)))
    z0 = _start(flow, x, v, turn)
    for _ in range(ROUNDS if flow.small(z0) else 0):  # the small harmonics belong to the start too, and follow z
        off, rate = small_motion(flow, z0, start)
        z0 = _start(flow, x - float(off), v - float(rate), turn)
    if not np.isfinite(z0):
        raise _lost(y0)
    fast, angles = np.exp(1j * s.fast * t), s.omega * t
    if len(t) == 1:
        z = np.array([z0])
        rate = flow.rates(z)
    else:
        free = s.resonance.ratio is None and isinstance(flow, AveragedFlow | CubicFlow)
        free = free and not (remembers(s.system.law) or varies(s.system))  # a loop, or damping, takes energy too
        z, rate = _decay(flow, z0, t) if free else _integrate(flow, z0, t)
    x_of_t = motion(flow, z, t)
    v_of_t = ((rate + 1j * s.fast * z) * fast).real + s.omega * (s.forced_slope(angles) + e.slope(angles))
    v_of_t = v_of_t + small_motion(flow, z, t)[1]
    error, valid, message = _verdict(flow, z, rate)
    return Evolution(t, np.abs(z), -np.unwrap(np.angle(z)), x_of_t, v_of_t, error, valid, message)


def _verdict(flow: Flow, z: Any, rate: Any) -> tuple[float, bool, str]:
    """Estimated relative error of the frequency along a transient, whether it is valid, and the sentence on it."""
    s, each = flow.setting, np.unique(np.linspace(0, len(z) - 1, JUDGED).astype(int))
    error = _frequency_error(flow, z[each], rate[each])
    sound, lost = bool(np.all(flow.sound(z[each]))), bool(np.any(s.beyond(z[each])))
    valid = error <= ACCEPTED and sound and not lost
    text = f"the estimated error of its frequency is {100.0 * error:.2g} % (limit {100.0 * ACCEPTED:.0f} %)"
    text += "" if sound else ", and its small harmonics are larger than the motion"
    text += f", and it passes a saddle of the law, {s.reach:.6g} rad from rest" if lost else ""
    remedy = "" if valid else "; start closer to equilibrium, or integrate"
    return error, valid, f"the transient is {'valid' if valid else 'not valid'}: {text}{remedy}"


def _frequency_error(flow: Flow, z: Any, rate: Any) -> float:
    """Largest relative error of the frequency at slow states z with their rates, from what their equation misses.

    With R(z) as in `second_order` the component on E obeys z'' + (2 i Omega + mu) z' = R(z). What the rates miss of it,
    z'' from their own change along the way, over 2 |Omega z + z'|, is an error of z'.
    """
    s = flow.setting
    speed = np.hypot(s.fast * np.abs(z), np.abs(rate))
    step = DIFFERENCE_STEP / s.omega_0 * rate
    second = (flow.rates(z + step) - flow.rates(z - step)) * (0.5 / DIFFERENCE_STEP * s.omega_0)
    carrier = 2j * s.fast + s.mu
    if isinstance(flow, SecondOrderFlow):
        pull = carrier * flow.balance(z)[0]
    else:  # first order has omega_0 for Omega, and the detuning and the damping to first order
        pull = 2j * s.omega_0 * (flow.rates(z) + (0.5 * s.mu + 1j * (s.fast - s.omega_0)) * z)
        pull = pull - (s.omega_0**2 - s.fast**2 + 1j * s.mu * s.fast) * z
    missed = np.abs(second + carrier * rate - pull) * np.abs(z)
    return float(np.max(np.divide(missed, 2.0 * speed**2, out=np.zeros(len(z)), where=speed > 0.0)))


def motion(flow: Flow, z: Any, t: Floats) -> Floats:
    """x(t) [rad] of a slow state z [rad], one number or one for each time [s]."""
    s = flow.setting
    angles = s.omega * t
    small, _ = small_motion(flow, z, t)
    return np.asarray(
        s.u0 + (z * np.exp(1j * s.fast * t)).real + small + s.forced(angles) + s.system.error.value(angles)
    )


def small_motion(flow: Flow, z: Any, t: Any) -> tuple[Any, Any]:
    """Small harmonics of a slow state, added up at times [s]: their sum [rad] and its derivative [rad/s]."""
    value, rate = 0.0 * np.real(z), 0.0 * np.real(z)
    for speed, amplitude in flow.small(z):
        turning = amplitude * np.exp(1j * speed * t)
        value, rate = value + turning.real, rate - speed * turning.imag
    return value, rate


def _start(flow: Flow, x: float, v: float, turn: complex) -> complex:
    """Initial z with Re(z E) = x and Re((i Omega z + z') E) = v, by Newton in Im(z E) from its leading value."""
    fast = flow.setting.fast
    leading = part = -v / fast
    for _ in range(20):
        z = complex(x, part) / turn
        miss = (complex(flow.rates(z)) * turn).real - fast * part - v
        direction = 1j / turn
        by_part = flow.jacobian(z) @ np.array([direction.real, direction.imag])
        slope = (complex(by_part[0], by_part[1]) * turn).real - fast
        if not (math.isfinite(miss) and slope < -0.1 * fast):
            return complex(x, leading) / turn  # too far from small amplitudes for the first-order correction
        part -= miss / slope
        if abs(miss) <= 1e-14 * fast * (abs(x) + abs(part)):
            break
    return complex(x, part) / turn


def _decay(flow: Flow, z0: complex, t: Floats) -> tuple[Any, Any]:
    """Without resonance a = a0 exp(-mu t/2) and the phase rate depends on a alone: a quadrature over time."""
    mu, a0 = flow.setting.mu, abs(z0)
    if a0 == 0.0:
        return np.zeros(len(t), complex), np.zeros(len(t), complex)
    nodes = np.linspace(t[0], t[-1], 2 * DECAY + 1)
    a = a0 * np.exp(-0.5 * mu * (nodes - t[0]))
    shift = _batched(flow, a.astype(complex)).imag / a
    widths, half = np.diff(nodes[::2]), shift[1::2]
    angle = np.concatenate([[0.0], np.cumsum(widths * (shift[:-2:2] + 4.0 * half + shift[2::2]) / 6.0)])
    # on each piece the rate is the parabola through three nodes, the angle its integral from the left
    piece = np.minimum(np.searchsorted(nodes[::2], t, side="right") - 1, DECAY - 1)
    s, left, right = (t - nodes[2 * piece]) / widths[piece], shift[2 * piece], shift[2 * piece + 2]
    bend, slope = 2.0 * (left - 2.0 * half[piece] + right), 4.0 * half[piece] - 3.0 * left - right
    turned = angle[piece] + widths[piece] * s * (left + s * (slope / 2.0 + s * bend / 3.0))
    z = z0 * np.exp(-0.5 * mu * (t - t[0]) + 1j * turned)
    return z, (-0.5 * mu + 1j * (left + s * (slope + s * bend))) * z


class _Slow(NamedTuple):
    """The slow flow as a system of two states, Re z and Im z, in time."""

    flow: Flow

    def rhs(self, _: float, y: tuple[float, float]) -> tuple[float, float]:
        rate = complex(self.flow.rates(complex(*y)))
        return rate.real, rate.imag


def _integrate(flow: Flow, z0: complex, t: Floats) -> tuple[Any, Any]:
    """Dormand-Prince steps of the slow flow, as Python, with all samples inside a step at once."""
    # a tolerance below the error of the averages would only follow their kinks
    rtol = max(RTOL, 10.0 * flow.error)
    atol = 0.01 * rtol * max(abs(z0), max(flow.setting.scales()) * 1e-3)
    system, time, w, end = _Slow(flow), float(t[0]), workspace((z0.real, z0.imag)), float(t[-1])
    max_steps = 0 if _is_hopeless(flow, z0, end - time, rtol) else MOST_STEPS
    w[K] = system.rhs(0.0, w[Y])
    h = min(first_step(5, system, 1.0, time, w, rtol, atol), end - time)
    z, filled = np.full(len(t), z0, complex), 1
    for _ in range(max_steps):
        e = math.sqrt(abs(try_step(system, time, h, h, rtol, atol, w)))
        if not time + h > time:
            break
        if e <= 1.0:
            after = end if end - (time + h) < 1e-9 * h else time + h
            inside = int(np.searchsorted(t, after, side="right"))
            shares: Any = (t[filled:inside] - time) / h
            x = weighted(dense_weights(shares, h), *w[[Y, K, Y1, K1, DENSE], :, None])
            z[filled:inside], filled = x[0] + 1j * x[1], inside
            time, w = after, turned(w)
            if time >= end:
                # z' is a first-order part of x'
                return z, _batched(flow, z)
        factor = 0.9 * max(e, 1e-10) ** -0.2 if math.isfinite(e) else 0.1
        h = min(h * min(5.0, max(0.2, factor)), end - time)
    raise SolveError(
        Sentence(
            f"the slow flow from a = {{}} could not be followed to t = {t[-1]:.6g} s, only to {time:.6g} s; start "
            "closer to equilibrium, take an earlier end, or check the signs of damping and stiffness",
            Angle(abs(z0)),
        )
    )


def _is_hopeless(flow: Flow, z0: complex, span: float, rtol: float) -> bool:
    """True if a span [s] takes more than `MOST_STEPS`: a step is stable up to 3.3 of h mu/2, and 19 turn by 1 rad.

    That is of the fastest disturbance at the start, which turns as long as the damping lets the start last.
    """
    mu, change = flow.setting.mu, flow.jacobian(z0)
    if not np.all(np.isfinite(change)):
        return True
    turning = float(np.max(np.abs(np.linalg.eigvals(change).imag)))
    turned = turning * (min(span, 1.0 / mu) if mu > 0.0 else span)
    return span * mu > 10.0 * MOST_STEPS or turned * (RTOL / rtol) ** 0.2 > 0.1 * MOST_STEPS


def _batched(flow: Flow, z: Any) -> Any:
    """Rates at many points, in pieces that fit the memory whatever the number of quadrature points."""
    points = flow.means.forced.size if isinstance(flow, AveragedFlow) and isinstance(flow.means, Sampled) else 64
    pieces = math.ceil(len(z) * points / 500_000)
    return np.concatenate([flow.rates(part) for part in np.array_split(z, pieces)])


def times(flow: Flow, t: Any) -> Floats:
    """Check the times; an end time alone becomes samples from 0 that resolve the fastest component.

    Raises
    ------
    ValueError
        If the times are not finite or do not increase.
    """
    grid = numbers("t [s]", t)
    if not np.all(np.diff(grid) > 0.0):
        raise ValueError(f"t is {shown(t)}; it must be an end time or increasing times [s]")
    if grid.size > 1:
        return grid
    if grid[0] <= 0.0:
        raise ValueError(f"the end time is {grid[0]:.6g} s; it must be positive")
    s = flow.setting
    fastest = max(s.fast, s.omega * max(s.orders, default=1))
    samples = 2.0 + SAMPLES * float(grid[0]) * fastest / (2.0 * np.pi)
    if samples > MOST_SAMPLES:
        raise ValueError(f"to t = {grid[0]:.6g} s there are {samples:.3g} samples; name the times, or an earlier end")
    return np.linspace(0.0, float(grid[0]), math.ceil(samples))
