"""Marches of `simulate`: adaptive and equal steps through a stretch of time in which the system is smooth.

`pair` is a system with its stepper by address, `system` the system by address; the state is in a workspace.
"""

import math
from typing import Any

from ...base.protocols import System
from ...base.results import Floats
from ...compile.jit import kernel, routine
from ..addressed import rates
from .addressed_steps import take_step
from .peaks import raise_peaks, store_peaks
from .step_control import StepControl, calm_step, first_step, follows_interpolant, shorter_step
from .steps import LEAST_SQUARE, growth
from .switches import set_sides, step_to_event
from .workspace import (
    BEFORE,
    INSIDE,
    RATE,
    Y1,
    K,
    Recording,
    Y,
    interpolate,
    length,
    move,
    recording_rows,
    row,
    rows,
    store,
    turned,
)  # fmt: skip

DONE, DIVERGED, PAUSED, STOPPED = 0, 1, 2, 3
LEAST_ERROR = math.log(1e-4)  # the step control remembers no smaller error than this
FAR_STEPS = 32.0  # beyond so many times the last step the calm one is computed anew
STAGE_SPACING = 0.25  # of a calm step: the stages alone of a step up to there are no farther apart


@routine
def store_inside(
    system: Any, omega: float, t: float, h: float, t1: float, w: Any, record: Recording, filled: int
) -> int:  # fmt: skip
    """Record the samples inside a step of h from t to t1, each with the largest values since the one before.

    Returns the number of full columns of the table.
    """
    t0, before = t, Y
    while filled < length(record.samples) and row(record.samples, 0)[filled] <= t1:
        time = row(record.samples, 0)[filled]
        interpolate(w, (time - t) / h, h)
        rates(system, omega * time, row(w, INSIDE), row(w, RATE))
        raise_peaks(system, omega, record, w, t0, before, time, INSIDE)
        store(record.table, filled, time, w, INSIDE)
        store_peaks(record, 1 + 2 * length(w), filled)
        move(w, INSIDE, w, BEFORE)
        t0, before = time, BEFORE
        filled += 1
    raise_peaks(system, omega, record, w, t0, before, t1, Y1)
    return filled


@kernel
def march_adaptively(
    pair: Any, system: System, control: StepControl, breakpoints: Floats, guards: Floats, record: Recording,
    omega: float, t: float, t_end: float, h: float, kink: int, workspace: Floats, filled: int, budget: int,
) -> Any:  # fmt: skip
    """Integrate from t towards t_end [s] in at most `budget` attempts, or until a guard becomes negative.

    Parameters
    ----------
    breakpoints : (2, n) array
        Breakpoints of the law, and places for the sides of the torsion.
    guards : (1, m) array
        Places for the guards.
    omega : float
        Base frequency [rad/s].
    h : float
        First step [s]; 0 where it is to be found.
    kink : int
        Number of the breakpoint that the state is on, or -1.
    filled : int
        Full columns of the table of the record.

    Returns
    -------
    tuple
        Time [s], next step [s], kink, full columns, status, and how many steps, rejected ones and switches there were.
    """
    w, looks, into = rows(workspace), rows(control.looks), recording_rows(record)
    kinks, guard = rows(breakpoints), rows(guards)
    rates(system, omega * t, row(w, Y), row(w, K))
    if length(kinks) > 0:
        set_sides(system, omega, t, w, kinks, kink)
    status, steps, rejected, switches, past_error = PAUSED, 0, 0, 0, LEAST_ERROR
    calm = calm_to = calm_step(control.stable, system, omega, t, w, Y, control.span)
    looking = True  # between the stages of this step too
    if h <= 0.0:
        h = min(first_step(control.order, system, omega, t, w, control.rtol, control.atol), calm)
    while status == PAUSED and steps + rejected < budget:
        target = min(h, control.longest)
        last = t + 1.0000001 * target >= t_end
        tried = t_end - t if last else target
        h, square, kink, cut, stops = step_to_event(pair, system, control, omega, t, tried, t_end, w, kinks, guard)
        last = last and not cut
        good = 0.0 <= square <= 1.0
        if good and looking:
            good = follows_interpolant(looks, system, omega, t, h, w, control.rtol, control.atol)
        if not good:
            rejected += 1
            h = shorter_step(h, math.sqrt(-1.0 - square if square < 0.0 else square), 1.0 / control.order)
            if not t + h > t:
                status = DIVERGED
            continue
        error = 0.5 * math.log(max(square, LEAST_SQUARE))
        h_next = h * growth(control.order, error, past_error)
        past_error = max(error, LEAST_ERROR)
        t1 = t_end if last else t + h
        if kink >= 0:
            switches += 1
            h_next = tried
        else:
            if h_next > calm_to:
                calm = calm_step(control.stable, system, omega, t1, w, Y1, control.span)
                calm_to = max(calm, 2.0 * h_next)
            if h_next > 2.0 * h:
                h_next = max(h, min(h_next, calm))
        calm_to, looking = min(calm_to, FAR_STEPS * tried), h_next > STAGE_SPACING * calm
        if last:
            h_next = max(h_next, target)
        if length(into.samples) > 0:
            filled = store_inside(system, omega, t, h, t1, w, into, filled)
        elif t1 > t:
            store(into.table, filled, t1, w, Y1)
            filled += 1
        w, t, h = turned(w), t1, h_next
        steps += 1
        if stops:
            status = STOPPED
        elif t >= t_end:
            status = DONE
        elif length(kinks) > 0:
            set_sides(system, omega, t, w, kinks, kink)
    move(w, Y, rows(workspace), Y)
    return t, h, kink, filled, status, steps, rejected, switches


@kernel
def march_evenly(
    pair: Any, system: System, record: Recording, omega: float, t: float, t_end: float, h: float, workspace: Floats,
    filled: int, budget: int,
) -> Any:  # fmt: skip
    """Integrate from sample to sample until t_end [s], in at most `budget` equal steps no longer than h.

    The largest values between samples are noted where the record has places for them. Returns time [s], full columns,
    status and the number of steps.
    """
    w, into = rows(workspace), recording_rows(record)
    status, steps, sound = PAUSED, 0, 1.0
    rates(system, omega * t, row(w, Y), row(w, K))
    while status == PAUSED and steps < budget:
        goal = min(row(into.samples, 0)[filled], t_end) if filled < length(into.samples) else t_end
        n = max(1, math.ceil((goal - t) / h * (1.0 - 1e-12)))
        size = (goal - t) / n
        count = min(n, budget - steps)
        for i in range(count):
            t0 = t + i * size
            sound = take_step(pair, omega * t0, omega * size, size, w)
            if length(into.peaks) > 0:
                raise_peaks(system, omega, into, w, t0, Y, goal if i + 1 == n else t + (i + 1) * size, Y1)
            w = turned(w)
        steps += count
        t = goal if count == n else t + count * size
        if sound == 0.0:
            status = DIVERGED
        elif count == n:
            if filled < length(into.samples) and goal == row(into.samples, 0)[filled]:
                store(into.table, filled, t, w, Y)
                store_peaks(into, 1 + 2 * length(w), filled)
                filled += 1
            if goal >= t_end:
                status = DONE
    move(w, Y, rows(workspace), Y)
    return t, filled, status, steps
