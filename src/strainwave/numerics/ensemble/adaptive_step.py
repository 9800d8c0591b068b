"""The adaptive kernel of ensembles: every lane of a block takes its own steps, period by period.

For laws with kinks, where methods of fixed step fall back to second order. All lanes attempt a step at a time; those
that are rejected, or have finished the period, keep their state. Lanes wait for each other at the end of a period.

Rows of a block: the numbers of the systems, 1/omega, the states, their rates, the sums of the measures, and the phase,
the step [rad], the logarithm of the last error and the attempts left.

Hairer, Norsett & Wanner I, sec. II.4 (error norm); Hairer & Wanner II, sec. IV.2 (PI control).
"""

import math
from typing import Any

from ...choices import larger, select, smaller
from ...compile.jit import borrowed, chosen, kernel, kernel_as
from ...compile.lanes import lane, load, store
from ...tree import count
from .fixed_step import every_lane, strobe
from .pieces import Piece, Whole, about_log2, about_one_over, about_two_to, extreme_between, updated

TURN = 2.0 * math.pi
FIRST = TURN / 64.0  # step tried first
MOST = TURN / 16.0  # largest step: of what begins after a rest, no part of 1/32 turn lies between the stages
LEAST = 1e-12  # smallest step [rad]: a lane that needs a smaller one goes no further
SAFETY = math.log2(0.9)


@chosen
def kept(accept: Any, new: Any, old: Any) -> Any:
    """Numbers of the tuple `new` (of numbers, or of tuples of numbers) where a step is accepted, else of `old`."""
    return _kept_items if len(new) else _kept_nothing


def _kept_items(accept: Any, new: Any, old: Any) -> Any:
    return (kept_item(accept, new[0], old[0]), *kept(accept, new[1:], old[1:]))


def _kept_nothing(accept: Any, new: Any, old: Any) -> Any:
    return ()


@chosen
def kept_item(accept: Any, new: Any, old: Any) -> Any:
    """`kept` of a tuple, or of a number."""
    return _kept_tuple if hasattr(new, "__len__") and not hasattr(new, "dtype") else _kept_number


def _kept_tuple(accept: Any, new: Any, old: Any) -> Any:
    return kept(accept, new, old)


def _kept_number(accept: Any, new: Any, old: Any) -> Any:
    return select(accept, new, old)


def _total_loops(flags: Any) -> int:
    number = 0
    for j in range(flags.shape[0]):
        number += flags[j]
    return number


@kernel_as(_total_loops)
def total(flags: Any) -> int:
    """Number of lanes still on their way."""
    return int(flags.sum())


@kernel
def begin(
    system: Any, y0: Any, measures: Any, sums: Any, rows: Any, most: int, period: int, settle: int, j: Any
) -> None:  # fmt: skip
    """Put lane j at the start of a period; before the first with the rates and a step to try. A lost lane has ended.

    The measures see the state with which they begin.
    """
    at, n = count(system), count(y0)
    place = at + 1 + 2 * n + count(sums)
    y = lane(y0, rows, at + 1, j)
    store(select(y[0] == y[0], 0.0, TURN), rows, place, j)
    if period == 0:
        store(lane(system, rows, 0, j).rhs(0.0, y), rows, at + 1 + n, j)
        store(FIRST + 0.0 * load(rows, at, j), rows, place + 1, j)
        store(-13.0 + 0.0 * load(rows, at, j), rows, place + 2, j)
        store(most + 0.0 * load(rows, at, j), rows, place + 3, j)
    if period == settle:
        first = Piece(Whole(), 0.0, y[0], 0.0, 0.0, y[0], 0.0, 0.0, 1.0, y[0])
        store(updated(measures, lane(sums, rows, at + 1 + 2 * n, j), first), rows, at + 1 + 2 * n, j)


@kernel
def attempt(
    scheme: Any, system: Any, y0: Any, kind: Any, measures: Any, sums: Any, rows: Any, rtol: float, atol: float,
    measuring: float, waiting: Any, j: Any,
) -> None:  # fmt: skip
    """Attempt one step of lane j; a lane at the end of its period takes a step of no length."""
    at, n = count(system), count(y0)
    place, order, part = at + 1 + 2 * n + count(sums), scheme.error_order(), 1.0 / scheme.error_order()
    s, per_omega = lane(system, rows, 0, j), load(rows, at, j)
    y, k, before = lane(y0, rows, at + 1, j), lane(y0, rows, at + 1 + n, j), lane(sums, rows, at + 1 + 2 * n, j)
    phase, step, past = load(rows, place, j), load(rows, place + 1, j), load(rows, place + 2, j)
    left = TURN - phase
    q = smaller(step, left)
    h = q * per_omega
    y1, k1, error, _ = scheme.attempt(s, phase, q, y, h, k)
    e = 0.0 * h
    for i in range(n):
        scaled = error[i] * about_one_over(atol + rtol * larger(abs(y[i]), abs(y1[i])))
        e = e + scaled * scaled / n
    good, moving = e <= 1.0, left > 0.0
    now = 0.5 * about_log2(larger(e, 1e-20))
    grown, shrunk = SAFETY + 0.2 / order * past - 0.85 * part * now, select(e > 1.0, SAFETY - part * now, -3.3)
    power = select(good, grown, shrunk)  # shrunk also where the error is no number
    next_step = q * about_two_to(smaller(larger(power, select(e == e, -2.3, -3.3)), 3.3))
    after = smaller(select(good, larger(next_step, select(left > step, 0.0, step)), next_step), MOST)
    end = select(left > step, phase + q, TURN)
    extreme = extreme_between(kind, y, k, y1, k1, h)
    sums1 = updated(measures, before, Piece(Whole(), phase, y[0], k[0], end, y1[0], k1[0], h, 1.0 / per_omega, extreme))
    go = select(good, select(moving, 1.0, 0.0), 0.0)
    tries = load(rows, place + 3, j) - select(moving, 1.0, 0.0)
    lost = select(smaller(after - LEAST, tries + 1.0) > 0.0, 0.0, select(moving, 1.0, 0.0))
    new_phase = select(lost > 0.0, TURN, select(go > 0.0, end, phase))
    store(kept(go > 0.0, y1, y), rows, at + 1, j)
    store(kept(go > 0.0, k1, k), rows, at + 1 + n, j)
    store(kept(go * measuring > 0.0, sums1, before), rows, at + 1 + 2 * n, j)
    store(new_phase, rows, place, j)
    store(select(moving, after, step), rows, place + 1, j)
    store(select(go > 0.0, larger(now, -13.0), past), rows, place + 2, j)
    store(tries, rows, place + 3, j)
    store(select(lost > 0.0, math.nan, load(rows, at + 1, j)), rows, at + 1, j)
    waiting[j] = select(new_phase < TURN, 1, 0)


@kernel
def judge(system: Any, y0: Any, sums: Any, rows: Any, ended: Any, j: Any) -> None:
    """Tell a lane that had too few attempts by a number of periods below zero: -1 less the periods it was bounded."""
    left = load(rows, count(system) + 4 + 2 * count(y0) + count(sums), j)
    ended[j] = select(left < 0.0, -1.0 - ended[j], ended[j])


@kernel
def march_adaptive(
    system: Any, y0: Any, kind: Any, measures: Any, sums: Any, rows: Any, how: Any, waiting: Any, settle: int,
    periods: int, last: Any, points: Any, ended: Any,
) -> int:  # fmt: skip
    """March a block through its periods; `how` is scheme, tolerances and steps at most. Returns the attempts made."""
    scheme, rtol, atol, most = how
    rows, waiting, last, points, ended = borrowed((rows, waiting, last, points, ended))
    at, attempts = count(system) + 1, 0
    for period in range(settle + periods):
        for j in every_lane():
            begin(system, y0, measures, sums, rows, most, period, settle, j)
        measuring, way = (1.0 if period >= settle else 0.0), 1
        while way > 0:
            for j in every_lane():
                attempt(scheme, system, y0, kind, measures, sums, rows, rtol, atol, measuring, waiting, j)
            attempts += 1
            way = total(waiting)
        for j in every_lane():
            strobe(y0, rows, at, period, last, points, ended, j)
    for j in every_lane():
        judge(system, y0, sums, rows, ended, j)
    return attempts
