"""The kernels of `simulate`: adaptive and fixed steps through a stretch of time in which the system is smooth."""

import math
from typing import Any

from ...compile.jit import kernel, routine
from ...compile.tuples import axpy
from .breakpoints import first_switch, set_sides, step_onto
from .extremes import put, widen
from .rest import APART, STAGES, calm_step, undisturbed
from .steps import bounded, dense_output, error_norm, error_square, rates_of

DONE, DIVERGED, PAUSED = 0, 1, 2
BOUND = 1e30  # of every state: far beyond any physics, and its powers in a law still fit a float
LEAST = math.log(1e-4)  # the step control remembers no smaller error than this
FAR = 32.0  # beyond so many times the last step the calm one is found anew


@kernel
def first_step(
    order: int, system: Any, omega: float, t: float, y: Any, k: Any, rtol: float, atol: float
) -> float:  # fmt: skip
    """Starting step size of a method with errors of this order (Hairer, Norsett & Wanner I, sec. II.4)."""
    zero = axpy(y, -1.0, y)
    d0, d1 = error_norm(y, y, zero, rtol, atol), error_norm(k, y, zero, rtol, atol)
    h0 = 1e-6 if d0 < 1e-5 or d1 < 1e-5 else 0.01 * d0 / d1
    k1 = rates_of(system, omega * (t + h0), axpy(y, h0, k))
    d2 = error_norm(axpy(k1, -1.0, k), y, zero, rtol, atol) / h0
    largest = max(d1, d2)
    h1 = max(1e-6, h0 * 1e-3) if largest <= 1e-15 else (0.01 / largest) ** (1.0 / order)
    return float(min(100.0 * h0, h1))


@kernel
def store(out_t: Any, out_y: Any, out_rate: Any, place: int, t: float, y: Any, k: Any) -> None:
    """Write one sample (time, state, rate) into the output arrays."""
    out_t[place] = t
    for i in range(len(y)):
        out_y[i, place], out_rate[i, place] = y[i], k[i]


@routine
def calmed(
    scheme: Any, system: Any, omega: float, t: float, y: Any, k: Any, span: float, h: float, h_next: float, calm: float,
    known: float,
) -> Any:  # fmt: skip
    """Step after one of h, no longer than a calm one where nothing limits it, and what is known of that."""
    if h_next > known:
        calm = calm_step(scheme.stable(), system, omega, t, y, k, span)
        known = max(calm, 2.0 * h_next)
    if h_next > 2.0 * h:
        h_next = max(h, min(h_next, calm))
    return h_next, calm, known


@kernel
def shortened(h: float, e: float, power: float) -> float:
    """Step to try after one of h whose error is e tolerances: at most 1 where the look inside has rejected it."""
    if e <= 1.0:
        return APART * h
    return float(h * (max(0.2, 0.9 * e**-power) if e < BOUND else 0.1))


@kernel
def store_inside(
    system: Any, omega: float, t: float, h: float, y: Any, k: Any, t1: float, y1: Any, k1: Any, dense: Any,
    samples: Any, filled: int, most: Any, out_t: Any, out_y: Any, out_rate: Any, out_most: Any,
) -> int:  # fmt: skip
    """Write the samples inside a step, each with the largest values since the one before; how many there are then."""
    t0, y0, k0 = t, y, k
    while filled < len(samples) and samples[filled] <= t1:
        there = dense_output((samples[filled] - t) / h, h, y, k, y1, k1, dense)
        rate = rates_of(system, omega * samples[filled], there)
        widen(system, omega, most, t0, y0, k0, samples[filled], there, rate)
        store(out_t, out_y, out_rate, filled, samples[filled], there, rate)
        put(most, out_most, filled)
        t0, y0, k0 = samples[filled], there, rate
        filled += 1
    widen(system, omega, most, t0, y0, k0, t1, y1, k1)
    return filled


@kernel
def adaptive(
    scheme: Any, system: Any, omega: float, t: float, y: Any, t_end: float, h: float, longest: float, span: float,
    rtol: float, atol: float, breakpoints: Any, sides: Any, at: int, samples: Any, filled: int, budget: int,
    most: Any, out_t: Any, out_y: Any, out_rate: Any, out_most: Any,
) -> Any:  # fmt: skip
    """Integrate from t towards t_end in at most `budget` attempts; record every step, or the samples inside them.

    No step is longer than `longest`. `span` is the length of the whole integration.
    """
    order, power = scheme.error_order(), 1.0 / scheme.error_order()
    k = rates_of(system, omega * t, y)
    if breakpoints is not None:
        set_sides(system, omega, t, y, k, breakpoints, sides, at)
    every = len(samples) == 0
    status, steps, rejected, switches, old = PAUSED, 0, 0, 0, LEAST
    calm = known = calm_step(scheme.stable(), system, omega, t, y, k, span)
    look = True  # between the stages of this step too
    if h <= 0.0:
        h = min(first_step(order, system, omega, t, y, k, rtol, atol), calm)
    while status == PAUSED and steps + rejected < budget:
        h = wanted = min(h, longest)
        last = t + 1.0000001 * h >= t_end
        if last:
            h = t_end - t
        y1, k1, error, dense = scheme.attempt(system, omega * t, omega * h, y, h, k)
        tried, at = h, -1
        if breakpoints is not None and bounded(y1, BOUND):
            s, at = first_switch(system, omega, t, h, y, k, y1, k1, dense, breakpoints, sides)
            if at >= 0:
                there, h, y1, k1, error, dense = step_onto(
                    scheme, system, omega, t, s * h, y, k, breakpoints[at], t_end
                )
                last, at = False, at if there else -1
        square = error_square(error, y, y1, rtol, atol)
        good = square <= 1.0 and bounded(y1, BOUND)
        if not good or (look and not undisturbed(scheme, system, omega, t, h, y, k, y1, k1, dense, rtol, atol)):
            rejected += 1
            h = shortened(h, math.sqrt(square), power)
            if not t + h > t:
                status = DIVERGED
            continue
        # PI control (Hairer & Wanner II, sec. IV.2): 0.9 h (e_old^0.2/e^0.85)^power, with one logarithm for both.
        log_e = 0.5 * math.log(max(square, 1e-20))
        h_next = h * min(10.0, max(0.2, 0.9 * math.exp(0.2 / order * old - 0.85 * power * log_e)))
        old = max(log_e, LEAST)
        t1 = t_end if last else t + h
        if at >= 0:
            switches += 1
            h_next = tried
        elif h_next > known or h_next > 2.0 * h:
            h_next, calm, known = calmed(scheme, system, omega, t1, y1, k1, span, h, h_next, calm, known)
        known, look = min(known, FAR * tried), h_next > STAGES * calm
        if last:
            h_next = max(h_next, wanted)
        if every:
            if t1 > t:
                store(out_t, out_y, out_rate, filled, t1, y1, k1)
                filled += 1
        else:
            filled = store_inside(
                system, omega, t, h, y, k, t1, y1, k1, dense, samples, filled, most, out_t, out_y, out_rate, out_most
            )
        t, y, k, h = t1, y1, k1, h_next
        steps += 1
        if t >= t_end:
            status = DONE
        elif breakpoints is not None:
            set_sides(system, omega, t, y, k, breakpoints, sides, at)
    return t, y, h, at, filled, status, steps, rejected, switches


@kernel
def fixed(
    scheme: Any, system: Any, omega: float, t: float, y: Any, t_end: float, h: float, samples: Any, filled: int,
    budget: int, most: Any, out_t: Any, out_y: Any, out_rate: Any, out_most: Any,
) -> Any:  # fmt: skip
    """Integrate from sample to sample until t_end, in at most `budget` steps, with equal steps no longer than h.

    The largest values between samples are noted where `most` has places for them.
    """
    status, steps, between = PAUSED, 0, len(most) > 0
    k = rates_of(system, omega * t, y)
    while status == PAUSED and steps < budget:
        goal = min(samples[filled], t_end) if filled < len(samples) else t_end
        n = max(1, math.ceil((goal - t) / h * (1.0 - 1e-12)))
        step = (goal - t) / n
        now = min(n, budget - steps)
        for i in range(now):
            t0, y0, k0, t1 = t + i * step, y, k, goal if i + 1 == n else t + (i + 1) * step
            y = scheme.step(system, omega * t0, omega * step, y, step)
            k = system.rhs(omega * t1, y)
            if between:
                widen(system, omega, most, t0, y0, k0, t1, y, k)
        steps += now
        t = goal if now == n else t + now * step
        if not (bounded(y, BOUND) and bounded(k, math.inf)):
            status = DIVERGED
        elif now == n:
            if filled < len(samples) and goal == samples[filled]:
                store(out_t, out_y, out_rate, filled, t, y, k)
                put(most, out_most, filled)
                filled += 1
            if goal >= t_end:
                status = DONE
    return t, y, filled, status, steps
