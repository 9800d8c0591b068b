"""Kernels of ensembles with adaptive steps: every lane of a block takes its own steps, period by period.

The rows of a block are those of `fixed_step.FirstRows`, with 1/omega for `step`, the rates of the states for `other`
and the step control from `start` on: phase in the period [rad], next step [rad], logarithm of the last error, attempts
that are left. Logarithms are to the base 2.
"""

import math
from typing import Any

from ...base.results import Floats
from ...compile.elementwise import larger, select, smaller
from ...compile.jit import borrowed, chosen, kernel, kernel_as
from ...compile.lanes import lane, load, store
from ..integration.steps import ERROR_POWER, LEAST_SQUARE, ORDER, PAST_POWER, SAFETY, dopri5_step
from .fixed_step import LaneModel, add_piece, end_period, every_lane, first_rows
from .pieces import Piece, Whole, about_log2, about_one_over, about_two_to, updated

TURN = 2.0 * math.pi
FIRST_STEP = TURN / 64.0  # step tried first [rad]
LONGEST_STEP = TURN / 16.0  # [rad]: of what begins after a rest, no part of 1/32 turn lies between the stages
LEAST_STEP = 1e-12  # [rad]: a lane that needs a smaller one goes no further
SAFETY_LOG = math.log2(SAFETY)
LEAST_LOG, LARGEST_LOG, LOST_LOG = -2.3, 3.3, -3.3  # of LEAST_FACTOR, LARGEST_FACTOR and LOST_FACTOR
ERROR_LOG = -13.0  # of the least error that the step control remembers


@chosen
def chosen_numbers(accept: Any, new: Any, old: Any) -> Any:
    """Return `new`, a number or a tuple of such, where a step is accepted, else `old`."""
    if not hasattr(new, "__len__") or hasattr(new, "dtype"):
        return _chosen_one
    return _chosen_items if len(new) else _chosen_nothing


def _chosen_items(accept: Any, new: Any, old: Any) -> Any:
    return (chosen_numbers(accept, new[0], old[0]), *chosen_numbers(accept, new[1:], old[1:]))


def _chosen_nothing(accept: Any, new: Any, old: Any) -> Any:
    return ()


def _chosen_one(accept: Any, new: Any, old: Any) -> Any:
    return select(accept, new, old)


def _total_loops(flags: Any) -> int:
    number = 0
    for j in range(flags.shape[0]):
        number += flags[j]
    return number


@kernel_as(_total_loops)
def total(flags: Any) -> int:
    """Number of flags that are set."""
    return int(flags.sum())


@kernel
def begin_period(model: LaneModel, rows: Floats, budget: int, period: int, settle: int, j: slice) -> None:
    """Put lane j at the start of a period; before the first with the rates and a step to try. A lost lane has ended.

    The measures see the state with which they begin.
    """
    first = first_rows(model)
    y = lane(model.state, rows, first.state, j)
    store(select(y[0] == y[0], 0.0, TURN), rows, first.start, j)
    if period == 0:
        none = 0.0 * load(rows, first.step, j)
        store(lane(model.system, rows, 0, j).rhs(0.0, y), rows, first.other, j)
        store((FIRST_STEP + none, ERROR_LOG + none, budget + none), rows, first.start + 1, j)
    if period == settle:
        add_piece(model, rows, Piece(Whole(), 0.0, y[0], 0.0, 0.0, y[0], 0.0, 0.0, 1.0, y[0]), j)


@kernel
def mean_square(error: Any, y: Any, y1: Any, rtol: float, atol: float) -> Any:
    """Mean square of the error of a step from y to y1 in units of the tolerance."""
    square = 0.0
    for i in range(len(y)):
        scaled = error[i] * about_one_over(atol + rtol * larger(abs(y[i]), abs(y1[i])))
        square = square + scaled * scaled / len(y)
    return square


@kernel
def growth_log(square: Any, size: Any, past: Any) -> Any:
    """Logarithm of the factor of the next step.

    `square` is the mean square of the error in tolerances, not finite of a lost step, `size` its logarithm over 2 and
    `past` that of the last accepted step.
    """
    grown = SAFETY_LOG + PAST_POWER / ORDER * past - ERROR_POWER * (1.0 / ORDER) * size
    shrunk = select(square > 1.0, SAFETY_LOG - 1.0 / ORDER * size, LOST_LOG)
    power = select(square <= 1.0, grown, shrunk)  # shrunk also where the error is no number
    return smaller(larger(power, select(square == square, LEAST_LOG, LOST_LOG)), LARGEST_LOG)


@kernel
def try_step(
    model: Any, rows: Any, rtol: float, atol: float, measuring: float, waiting: Any, j: slice
) -> None:  # fmt: skip
    """Try one step of lane j and keep it where its error is small; a lane at the end of its period stands still.

    Parameters
    ----------
    model : LaneModel
        Model of the lane.
    rows : (rows, lanes) array
        The block.
    rtol, atol : float
        Relative and absolute tolerance.
    measuring : float
        1 where the measures see the step, else 0.
    waiting : (lanes,) array
        Becomes 1 for a lane that is not at the end of its period, else 0.
    j : slice
        The lane, or all of them.
    """
    first = first_rows(model)
    system, per_omega = lane(model.system, rows, 0, j), load(rows, first.step, j)
    y, k = lane(model.state, rows, first.state, j), lane(model.state, rows, first.other, j)
    phase, step, past, left = lane((0.0, 0.0, 0.0, 0.0), rows, first.start, j)
    to_end = TURN - phase
    moving = select(to_end > 0.0, 1.0, 0.0)
    q = smaller(step, to_end)
    h = q * per_omega
    y1, k1, error, _ = dopri5_step(system, phase, q, y, h, k)
    square = mean_square(error, y, y1, rtol, atol)
    good = square <= 1.0
    size = 0.5 * about_log2(larger(square, LEAST_SQUARE))
    next_step = q * about_two_to(growth_log(square, size, past))
    uncut = select(to_end > step, 0.0, step)  # a step that the end of the period has cut does not shorten the next
    after = smaller(select(good, larger(next_step, uncut), next_step), LONGEST_STEP)
    end = select(to_end > step, phase + q, TURN)
    extreme = model.kind.extreme(y, k, y1, k1, h)
    piece = Piece(Whole(), phase, y[0], k[0], end, y1[0], k1[0], h, 1.0 / per_omega, extreme)
    sums = lane(model.sums, rows, first.sums, j)
    new_sums = updated(model.measures, sums, piece)
    go = select(good, moving, 0.0)
    tries = left - moving
    lost = select(smaller(after - LEAST_STEP, tries + 1.0) > 0.0, 0.0, moving)
    new_phase = select(lost > 0.0, TURN, select(go > 0.0, end, phase))
    store(chosen_numbers(go > 0.0, y1, y), rows, first.state, j)
    store(chosen_numbers(go > 0.0, k1, k), rows, first.other, j)
    store(chosen_numbers(go * measuring > 0.0, new_sums, sums), rows, first.sums, j)
    store(new_phase, rows, first.start, j)
    store(select(moving > 0.0, after, step), rows, first.start + 1, j)
    store(select(go > 0.0, larger(size, ERROR_LOG), past), rows, first.start + 2, j)
    store(tries, rows, first.start + 3, j)
    store(select(lost > 0.0, math.nan, load(rows, first.state, j)), rows, first.state, j)
    waiting[j] = select(new_phase < TURN, 1, 0)


@kernel
def mark_short(model: LaneModel, rows: Floats, ended: Floats, j: slice) -> None:
    """Mark a lane that had too few attempts by a number of periods below zero: -1 less the periods it was bounded."""
    left = load(rows, first_rows(model).start + 3, j)
    ended[j] = select(left < 0.0, -1.0 - ended[j], ended[j])


@kernel
def march_adaptive(
    model: LaneModel, rows: Floats, rule: Any, waiting: Any, settle: int, periods: int, last: Floats, ended: Floats
) -> None:
    """March a block through its periods; `rule` is tolerances and steps at most."""
    rtol, atol, budget = rule
    rows, waiting, last, ended = borrowed((rows, waiting, last, ended))
    for period in range(settle + periods):
        for j in every_lane(ended):
            begin_period(model, rows, budget, period, settle, j)
        measuring, running = (1.0 if period >= settle else 0.0), 1
        while running > 0:
            for j in every_lane(ended):
                try_step(model, rows, rtol, atol, measuring, waiting, j)
            running = total(waiting)
        for j in every_lane(ended):
            end_period(model, rows, period, last, ended, j)
    for j in every_lane(ended):
        mark_short(model, rows, ended, j)
