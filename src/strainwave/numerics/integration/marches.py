"""The kernels of `simulate`: adaptive and fixed steps through a stretch of time in which the system is smooth.

Guards of long steps: the longest step where nothing happens, and a look inside such a step. Location of
switches: where the torsion of a running integration crosses a breakpoint of the law.
"""

import math
from typing import Any

from ...base.protocols import System
from ...base.results import Floats
from ...compile.jit import kernel, routine
from ..addressed import guards, rates, torsion
from .attempts import (
    BEFORE,
    BOUND,
    CHANGE,
    DENSE,
    INSIDE,
    K1,
    RATE,
    SHIFTED,
    Y1,
    K,
    Y,
    attempt,
    length,
    look,
    move,
    put,
    row,
    rows,
    shift,
    step,
    store,
    torsion_inside,
    turned,
    widen,
)
from .steps import LEAST_FACTOR, LEAST_SQUARE, LOST_FACTOR, SAFETY, error_square, growth, slope_weights, weighted

DONE, DIVERGED, PAUSED, STOPPED = 0, 1, 2, 3
LEAST_ERROR = math.log(1e-4)  # the step control remembers no smaller error than this
FAR_STEPS = 32.0  # beyond so many times the last step the calm one is found anew

ROUNDS = 6  # of the power iteration, which needs an order of magnitude
DIFFERENCE_SIZE = 1e-7  # size of the differences, next to states of size 1
IDLE_STEPS = 25.0  # steps of a span in which nothing restores the system
LOOK_SPACING = 0.125  # at most from a look or a stage to the next
STAGE_SPACING = 0.25  # of a calm step: the stages alone of a step up to there are no farther apart
MISSED_TOLERANCES = 100.0  # by how many tolerances the system may differ there from the interpolant

SCAN_PLACES = 4  # places inside a step where the torsion is compared with the breakpoints, and the guards with 0


@routine
def set_sides(system: System, omega: float, t: float, w: Floats, kinks: Floats, kink: int) -> None:
    """Record on which side of each breakpoint the torsion is; on breakpoint `kink`, where the flow carries it."""
    u, breakpoints, sides = torsion(system, omega * t, row(w, Y)), row(kinks, 0), row(kinks, 1)
    for j in range(length(kinks)):
        away = u - breakpoints[j]
        if j == kink or away == 0.0:
            away = torsion_rate(system, omega, t, w, Y)
        sides[j] = 1.0 if away >= 0.0 else -1.0


@routine
def torsion_rate(system: System, omega: float, t: float, w: Floats, state_row: int) -> float:
    """Rate of the torsion along the flow, by a central difference (only its sign and about six digits matter)."""
    d = 1e-5 / (1.0 + abs(omega))
    shift(w, state_row, d)
    after = torsion(system, omega * (t + d), row(w, SHIFTED))
    shift(w, state_row, -d)
    return float((after - torsion(system, omega * (t - d), row(w, SHIFTED))) / (2.0 * d))


@routine
def first_switch(pair: Any, omega: float, t: float, h: float, w: Floats, kinks: Floats) -> Any:
    """First fraction of the step at which the torsion changes side of a breakpoint, and that breakpoint (-1: none)."""
    breakpoints, sides = row(kinks, 0), row(kinks, 1)
    low, lower, upper = 0.0, -math.inf, math.inf  # the torsion is between two breakpoints
    for j in range(length(kinks)):
        if sides[j] > 0.0:
            lower = max(lower, breakpoints[j])
        else:
            upper = min(upper, breakpoints[j])
    for i in range(1, SCAN_PLACES + 1):
        high, best, index = i / SCAN_PLACES, 2.0, -1
        u = torsion_inside(pair, omega * (t + high * h), high, h, w)
        if u < lower or u > upper:
            for j in range(length(kinks)):
                if (u - breakpoints[j]) * sides[j] < 0.0:
                    a, b = low, high
                    for _ in range(40):
                        s = 0.5 * (a + b)
                        inside = torsion_inside(pair, omega * (t + s * h), s, h, w)
                        if (inside - breakpoints[j]) * sides[j] < 0.0:
                            b = s
                        else:
                            a = s
                    if b < best:
                        best, index = b, j
            return best, index
        low = high
    return 2.0, -1


@routine
def step_onto(
    pair: Any, system: System, omega: float, t: float, h: float, rtol: float, atol: float, w: Floats, breakpoint: float,
    t_end: float,
) -> Any:  # fmt: skip
    """Take a step of about h that ends on the breakpoint (Newton on h): whether it does, h, and what `attempt` returns.

    The whole step is repeated, instead of cutting its interpolant, so that its end has the order of the method too.
    """
    away = torsion(system, omega * t, row(w, Y)) - breakpoint
    gap = back = square = 0.0
    for _ in range(4):
        h = min(h - back, t_end - t)
        square = attempt(pair, omega * t, omega * h, h, rtol, atol, w)
        gap = torsion(system, omega * (t + h), row(w, Y1)) - breakpoint
        rate = torsion_rate(system, omega, t + h, w, Y1)
        back = gap / rate if abs(gap) < 0.1 * h * abs(rate) else 0.0
    return abs(gap) <= 1e-3 * abs(away), h, square


@routine
def is_past(system: Any, omega: float, t: float, s: float, h: float, w: Any, guard: Any) -> bool:
    """True if a guard is negative at the fraction s of a step of h from t."""
    look(w, s, h)
    values = row(guard, 0)
    guards(system, omega * (t + s * h), row(w, INSIDE), values)
    least = values[0]
    for j in range(1, length(guard)):
        least = min(least, values[j])
    return bool(least < 0.0)


@routine
def first_stop(system: Any, omega: float, t: float, h: float, w: Any, guard: Any) -> float:
    """First fraction of the step at which a guard is negative; 2 where none is."""
    low = 0.0
    for i in range(1, SCAN_PLACES + 1):
        high = i / SCAN_PLACES
        if is_past(system, omega, t, high, h, w, guard):
            for _ in range(40):
                s = 0.5 * (low + high)
                if is_past(system, omega, t, s, h, w, guard):
                    high = s
                else:
                    low = s
            return high
        low = high
    return 2.0


@routine
def stop_at(
    pair: Any, system: Any, omega: float, t: float, h: float, rtol: float, atol: float, w: Any, guard: Any,
    square: float,
) -> Any:  # fmt: skip
    """True for a step that stops where a guard becomes negative; the share of it that is taken; its squared error."""
    if length(guard) == 0 or square < 0.0:
        return False, 1.0, square
    s = first_stop(system, omega, t, h, w, guard)
    if s < 1.0:
        square = attempt(pair, omega * t, omega * s * h, s * h, rtol, atol, w)
    return s <= 1.0, min(s, 1.0), square


@routine
def largest(n: int, y: Floats) -> float:
    """Largest absolute value of n numbers."""
    size = 0.0
    for i in range(n):
        size = max(size, abs(y[i]))
    return size


@routine
def calm_step(stable: float, system: System, omega: float, t: float, w: Floats, state_row: int, span: float) -> float:
    """Step [s] at which a method, by its interval of stability, becomes unstable at a state.

    Where that is beyond the span [s], because nothing restores the system, it is a share of the span. From the largest
    eigenvalue of the Jacobian by power iteration, two rounds together because those of a vibration are a pair.
    """
    n, y, k, near_y, change = length(w), row(w, state_row), row(w, state_row + 1), row(w, SHIFTED), row(w, CHANGE)
    distance = DIFFERENCE_SIZE * (1.0 + largest(n, y))
    grown, before, size = 0.0, 0.0, 1.0
    for i in range(n):
        change[i] = 1.0
    for _ in range(min(ROUNDS, ROUNDS * n)):  # of a number that it knows the compiler would write out every round
        for i in range(n):
            near_y[i] = y[i] + distance / size * change[i]
        rates(system, omega * t, near_y, change)
        for i in range(n):
            change[i] -= k[i]
        size = largest(n, change)
        if not 0.0 < size < math.inf:
            return span / IDLE_STEPS
        before, grown = grown, size / distance
    rate = math.sqrt(grown * before)
    return stable / rate if rate * span > stable else span / IDLE_STEPS


@routine
def undisturbed(
    looks: Floats, system: Any, omega: float, t: float, h: float, w: Any, rtol: float, atol: float
) -> bool:  # fmt: skip
    """True if the system follows the interpolant of a step between its stages too: at the fractions `looks`."""
    n, dense, missed = length(w), row(w, DENSE), row(w, RATE)
    y, k, y1, k1 = row(w, Y), row(w, K), row(w, Y1), row(w, K1)
    for j in range(length(looks)):
        s = row(looks, 0)[j]
        look(w, s, h)
        rates(system, omega * (t + s * h), row(w, INSIDE), missed)
        a = slope_weights(s, h)
        for i in range(n):
            missed[i] = h * missed[i] - weighted(a, y[i], k[i], y1[i], k1[i], dense[i])
        if not math.sqrt(error_square(n, missed, y, y1, rtol, atol)) <= MISSED_TOLERANCES:
            return False
    return True


@routine
def first_step(order: int, system: System, omega: float, t: float, w: Floats, rtol: float, atol: float) -> float:
    """Starting step size of a method with errors of this order (Hairer, Norsett & Wanner I, sec. II.4)."""
    n, y, k, change = length(w), row(w, Y), row(w, K), row(w, CHANGE)
    d0, d1 = math.sqrt(error_square(n, y, y, y, rtol, atol)), math.sqrt(error_square(n, k, y, y, rtol, atol))
    h0 = 1e-6 if d0 < 1e-5 or d1 < 1e-5 else 0.01 * d0 / d1
    shift(w, Y, h0)
    rates(system, omega * (t + h0), row(w, SHIFTED), change)
    for i in range(n):
        change[i] -= k[i]
    largest = max(d1, math.sqrt(error_square(n, change, y, y, rtol, atol)) / h0)
    h1 = max(1e-6, h0 * 1e-3) if largest <= 1e-15 else (0.01 / largest) ** (1.0 / order)
    return float(min(100.0 * h0, h1))


@routine
def calmed(
    stable: float, system: System, omega: float, t: float, w: Floats, span: float, h: float, h_next: float, calm: float,
    calm_to: float,
) -> Any:  # fmt: skip
    """Step after one of h, no longer than a calm one where nothing limits it, and what is known of that."""
    if h_next > calm_to:
        calm = calm_step(stable, system, omega, t, w, Y1, span)
        calm_to = max(calm, 2.0 * h_next)
    if h_next > 2.0 * h:
        h_next = max(h, min(h_next, calm))
    return h_next, calm, calm_to


@kernel
def shortened(h: float, e: float, power: float) -> float:
    """Step to try after one of h whose error is e tolerances: at most 1 where the look inside has rejected it."""
    if e <= 1.0:
        return LOOK_SPACING * h
    return float(h * (max(LEAST_FACTOR, SAFETY * e**-power) if e < BOUND else LOST_FACTOR))


@routine
def store_inside(
    system: Any, omega: float, t: float, h: float, t1: float, w: Any, samples: Any, filled: int, peaks: Any, watch: Any,
    table: Floats,
) -> int:  # fmt: skip
    """Write the samples inside a step, each with the largest values since the one before; how many there are then."""
    t0, before = t, Y
    while filled < length(samples) and row(samples, 0)[filled] <= t1:
        time = row(samples, 0)[filled]
        look(w, (time - t) / h, h)
        rates(system, omega * time, row(w, INSIDE), row(w, RATE))
        widen(system, omega, peaks, watch, w, t0, before, time, INSIDE)
        store(table, filled, time, w, INSIDE)
        put(peaks, table, 1 + 2 * length(w), filled)
        move(w, INSIDE, w, BEFORE)
        t0, before = time, BEFORE
        filled += 1
    widen(system, omega, peaks, watch, w, t0, before, t1, Y1)
    return filled


@kernel
def adaptive(
    pair: Any, order: int, stable: float, looks: Any, system: Any, omega: float, t: float, workspace: Any, t_end: float,
    h: float, longest: float, span: float, rtol: float, atol: float, kinks: Any, kink: int, guard: Any, samples: Any,
    filled: int, budget: int, peaks: Floats, watch: Floats, table: Floats,
) -> Any:  # fmt: skip
    """Integrate from t towards t_end in at most `budget` attempts; record every step, or the samples inside them.

    `pair` is what `attempt` steps, `order` the power of h that its error grows with, `stable` the length of its real
    interval of stability and `looks` the fractions of a step at which the system is compared with it. The state is in
    the workspace, at t of a system with the base frequency omega. h is the first step, 0 where it is to be found,
    `longest` the longest and `span` the length of the whole integration. `kinks` are breakpoints with the sides of the
    torsion, and `kink` the one that the state is on, or -1. It stops where a guard becomes negative; `guard` has places
    for them. Without `samples` it records every step; `filled` columns of the table are full. `peaks` are the largest
    values since the last sample, `watch` places for them.

    Returns time, next step, kink, full columns, status, and how many steps, rejected ones and switches there were.
    """
    w, look_at, kinks_at, samples_at = rows(workspace), rows(looks), rows(kinks), rows(samples)
    peaks_at, seen_at, table_at, guard_at = rows(peaks), rows(watch), rows(table), rows(guard)
    power, recording, kinked = 1.0 / order, length(samples_at) == 0, length(kinks_at) > 0
    rates(system, omega * t, row(w, Y), row(w, K))
    if kinked:
        set_sides(system, omega, t, w, kinks_at, kink)
    status, steps, rejected, switches, old = PAUSED, 0, 0, 0, LEAST_ERROR
    calm = calm_to = calm_step(stable, system, omega, t, w, Y, span)
    between = True  # look between the stages of this step too
    if h <= 0.0:
        h = min(first_step(order, system, omega, t, w, rtol, atol), calm)
    while status == PAUSED and steps + rejected < budget:
        h = target = min(h, longest)
        last = t + 1.0000001 * h >= t_end
        if last:
            h = t_end - t
        square = attempt(pair, omega * t, omega * h, h, rtol, atol, w)
        tried, kink = h, -1
        if kinked and square >= 0.0:
            s, kink = first_switch(pair, omega, t, h, w, kinks_at)
            if kink >= 0:
                met, h, square = step_onto(pair, system, omega, t, s * h, rtol, atol, w, row(kinks_at, 0)[kink], t_end)
                last, kink = False, kink if met else -1
        stops, share, square = stop_at(pair, system, omega, t, h, rtol, atol, w, guard_at, square)
        last, h, kink = last and share == 1.0, share * h, kink if share == 1.0 else -1
        good = 0.0 <= square <= 1.0
        if not good or (between and not undisturbed(look_at, system, omega, t, h, w, rtol, atol)):
            rejected += 1
            h = shortened(h, math.sqrt(-1.0 - square if square < 0.0 else square), power)
            if not t + h > t:
                status = DIVERGED
            continue
        log_e = 0.5 * math.log(max(square, LEAST_SQUARE))
        h_next = h * growth(order, log_e, old)
        old = max(log_e, LEAST_ERROR)
        t1 = t_end if last else t + h
        if kink >= 0:
            switches += 1
            h_next = tried
        elif h_next > calm_to or h_next > 2.0 * h:
            h_next, calm, calm_to = calmed(stable, system, omega, t1, w, span, h, h_next, calm, calm_to)
        calm_to, between = min(calm_to, FAR_STEPS * tried), h_next > STAGE_SPACING * calm
        if last:
            h_next = max(h_next, target)
        if not recording:
            filled = store_inside(system, omega, t, h, t1, w, samples_at, filled, peaks_at, seen_at, table_at)
        elif t1 > t:
            store(table_at, filled, t1, w, Y1)
            filled += 1
        w, t, h = turned(w), t1, h_next
        steps += 1
        if stops:
            status = STOPPED
        elif t >= t_end:
            status = DONE
        elif kinked:
            set_sides(system, omega, t, w, kinks_at, kink)
    move(w, Y, rows(workspace), Y)
    return t, h, kink, filled, status, steps, rejected, switches


@kernel
def fixed(
    pair: Any, system: Any, omega: float, t: float, workspace: Any, t_end: float, h: float, samples: Any, filled: int,
    budget: int, peaks: Floats, watch: Floats, table: Floats,
) -> Any:  # fmt: skip
    """Integrate from sample to sample until t_end, in at most `budget` steps, with equal steps no longer than h.

    The state is in the workspace. The largest values between samples are noted where `peaks` has places for them.
    """
    w, samples_at, peaks_at, seen_at, table_at = rows(workspace), rows(samples), rows(peaks), rows(watch), rows(table)
    status, steps, sound = PAUSED, 0, 1.0
    rates(system, omega * t, row(w, Y), row(w, K))
    while status == PAUSED and steps < budget:
        goal = min(row(samples_at, 0)[filled], t_end) if filled < length(samples_at) else t_end
        n = max(1, math.ceil((goal - t) / h * (1.0 - 1e-12)))
        size = (goal - t) / n
        count = min(n, budget - steps)
        for i in range(count):
            t0 = t + i * size
            sound = step(pair, omega * t0, omega * size, size, w)
            if length(peaks_at) > 0:
                widen(system, omega, peaks_at, seen_at, w, t0, Y, goal if i + 1 == n else t + (i + 1) * size, Y1)
            w = turned(w)
        steps += count
        t = goal if count == n else t + count * size
        if sound == 0.0:
            status = DIVERGED
        elif count == n:
            if filled < length(samples_at) and goal == row(samples_at, 0)[filled]:
                store(table_at, filled, t, w, Y)
                put(peaks_at, table_at, 1 + 2 * length(w), filled)
                filled += 1
            if goal >= t_end:
                status = DONE
    move(w, Y, rows(workspace), Y)
    return t, filled, status, steps
