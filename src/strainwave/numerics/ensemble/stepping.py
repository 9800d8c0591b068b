"""Steps of a method in an ensemble: what they resolve, their number, and the kernel that marches.

The adaptive kernel of ensembles: every lane of a block takes its own steps, period by period.

Fixed steps a period of each lane are enough for the fastest time scale that it meets.
"""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ...base.law import is_spring
from ...base.protocols import System, has_jacobian, lacking
from ...base.quantities import States
from ...base.results import Floats
from ...compile.elementwise import larger, select, smaller
from ...compile.jit import borrowed, chosen, kernel, kernel_as
from ...compile.lanes import lane, load, store
from ...compile.tree import count
from ..integration.methods import Dopri5, FixedStep
from ..integration.steps import ERROR_POWER, LEAST_SQUARE, ORDER, PAST_POWER, SAFETY, dopri5_step
from .fixed_step import every_lane, march_pairs, march_steps, strobe
from .pieces import Piece, Whole, about_log2, about_one_over, about_two_to, extreme_between, updated

PER_ORDER = 4  # pieces of a fixed step per turn of the highest order that an amplitude is taken of
HIGHEST_ADAPTIVE = 20  # order, in those of the system, that steps of a relative tolerance of 1e-9 resolve to 1e-4
SETTLED_CHANGE = 1e-6  # largest change of a settled state from one period (or up to eight) to the next, of fixed steps
LOOSE = 1e4  # of adaptive ones, in units of their tolerance

TURN = 2.0 * math.pi
FIRST_STEP = TURN / 64.0  # step tried first
LONGEST_STEP = TURN / 16.0  # largest step: of what begins after a rest, no part of 1/32 turn lies between the stages
LEAST_STEP = 1e-12  # smallest step [rad]: a lane that needs a smaller one goes no further
SAFETY_LOG = math.log2(SAFETY)  # logarithms are to the base 2
LEAST_LOG, LARGEST_LOG, LOST_LOG = -2.3, 3.3, -3.3  # of LEAST_FACTOR, LARGEST_FACTOR and LOST_FACTOR
ERROR_LOG = -13.0  # of the least error that the step control remembers


@chosen
def kept(accept: Any, new: Any, old: Any) -> Any:
    """What is `new`, a number or a tuple of such, where a step is accepted, else what is `old`."""
    if not hasattr(new, "__len__") or hasattr(new, "dtype"):
        return _kept_number
    return _kept_items if len(new) else _kept_nothing


def _kept_items(accept: Any, new: Any, old: Any) -> Any:
    return (kept(accept, new[0], old[0]), *kept(accept, new[1:], old[1:]))


def _kept_nothing(accept: Any, new: Any, old: Any) -> Any:
    return ()


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
    system: System, y0: States, measures: Any, sums: Any, rows: Floats, budget: int, period: int, settle: int, j: slice
) -> None:  # fmt: skip
    """Put lane j at the start of a period; before the first with the rates and a step to try. A lost lane has ended.

    The measures see the state with which they begin.
    """
    base, n = count(system), count(y0)
    control = base + 1 + 2 * n + count(sums)
    y = lane(y0, rows, base + 1, j)
    store(select(y[0] == y[0], 0.0, TURN), rows, control, j)
    if period == 0:
        store(lane(system, rows, 0, j).rhs(0.0, y), rows, base + 1 + n, j)
        store(FIRST_STEP + 0.0 * load(rows, base, j), rows, control + 1, j)
        store(ERROR_LOG + 0.0 * load(rows, base, j), rows, control + 2, j)
        store(budget + 0.0 * load(rows, base, j), rows, control + 3, j)
    if period == settle:
        first = Piece(Whole(), 0.0, y[0], 0.0, 0.0, y[0], 0.0, 0.0, 1.0, y[0])
        store(updated(measures, lane(sums, rows, base + 1 + 2 * n, j), first), rows, base + 1 + 2 * n, j)


@kernel
def attempt(
    system: System, y0: States, kind: Any, measures: Any, sums: Any, rows: Any, rtol: float, atol: float,
    measuring: float, waiting: Any, j: slice,
) -> None:  # fmt: skip
    """Attempt one step of lane j; a lane at the end of its period takes a step of no length.

    Parameters
    ----------
    system, y0, kind, measures, sums
        What the numbers of a lane are of, in the order of the rows: system, 1/omega, states, rates, sums of measures.
        `kind` tells which extremes inside a step are looked for.
    rows : (rows, lanes) array
        These numbers, and behind them the step control: phase, next step [rad], logarithm of the last error, attempts
        that are left.
    rtol, atol : float
        Relative and absolute tolerance.
    measuring : float
        1 where the measures see the step, else 0.
    waiting : (lanes,) array
        Becomes 1 for a lane that is not at the end of its period, else 0.
    j : slice
        The lane, or all of them.
    """
    base, n = count(system), count(y0)
    control, part = base + 1 + 2 * n + count(sums), 1.0 / ORDER
    s, per_omega = lane(system, rows, 0, j), load(rows, base, j)
    y, k, before = lane(y0, rows, base + 1, j), lane(y0, rows, base + 1 + n, j), lane(sums, rows, base + 1 + 2 * n, j)
    phase, step, past = load(rows, control, j), load(rows, control + 1, j), load(rows, control + 2, j)
    left = TURN - phase
    q = smaller(step, left)
    h = q * per_omega
    y1, k1, error, _ = dopri5_step(s, phase, q, y, h, k)
    e = 0.0 * h
    for i in range(n):
        scaled = error[i] * about_one_over(atol + rtol * larger(abs(y[i]), abs(y1[i])))
        e = e + scaled * scaled / n
    good, moving = e <= 1.0, left > 0.0
    size = 0.5 * about_log2(larger(e, LEAST_SQUARE))
    grown = SAFETY_LOG + PAST_POWER / ORDER * past - ERROR_POWER * part * size
    shrunk = select(e > 1.0, SAFETY_LOG - part * size, LOST_LOG)
    power = select(good, grown, shrunk)  # shrunk also where the error is no number
    next_step = q * about_two_to(smaller(larger(power, select(e == e, LEAST_LOG, LOST_LOG)), LARGEST_LOG))
    after = smaller(select(good, larger(next_step, select(left > step, 0.0, step)), next_step), LONGEST_STEP)
    end = select(left > step, phase + q, TURN)
    extreme = extreme_between(kind, y, k, y1, k1, h)
    sums1 = updated(measures, before, Piece(Whole(), phase, y[0], k[0], end, y1[0], k1[0], h, 1.0 / per_omega, extreme))
    go = select(good, select(moving, 1.0, 0.0), 0.0)
    tries = load(rows, control + 3, j) - select(moving, 1.0, 0.0)
    lost = select(smaller(after - LEAST_STEP, tries + 1.0) > 0.0, 0.0, select(moving, 1.0, 0.0))
    new_phase = select(lost > 0.0, TURN, select(go > 0.0, end, phase))
    store(kept(go > 0.0, y1, y), rows, base + 1, j)
    store(kept(go > 0.0, k1, k), rows, base + 1 + n, j)
    store(kept(go * measuring > 0.0, sums1, before), rows, base + 1 + 2 * n, j)
    store(new_phase, rows, control, j)
    store(select(moving, after, step), rows, control + 1, j)
    store(select(go > 0.0, larger(size, ERROR_LOG), past), rows, control + 2, j)
    store(tries, rows, control + 3, j)
    store(select(lost > 0.0, math.nan, load(rows, base + 1, j)), rows, base + 1, j)
    waiting[j] = select(new_phase < TURN, 1, 0)


@kernel
def judge(system: System, y0: States, sums: Any, rows: Floats, ended: Floats, j: slice) -> None:
    """Tell a lane that had too few attempts by a number of periods below zero: -1 less the periods it was bounded."""
    left = load(rows, count(system) + 4 + 2 * count(y0) + count(sums), j)
    ended[j] = select(left < 0.0, -1.0 - ended[j], ended[j])


@kernel
def march_adaptive(
    system: System, y0: States, kind: Any, measures: Any, sums: Any, rows: Floats, rule: Any, waiting: Any, settle: int,
    periods: int, last: Floats, ended: Floats,
) -> int:  # fmt: skip
    """March a block through its periods; `rule` is tolerances and steps at most. Returns the attempts made."""
    rtol, atol, budget = rule
    rows, waiting, last, ended = borrowed((rows, waiting, last, ended))
    base, attempts = count(system) + 1, 0
    for period in range(settle + periods):
        for j in every_lane(ended):
            begin(system, y0, measures, sums, rows, budget, period, settle, j)
        measuring, running = (1.0 if period >= settle else 0.0), 1
        while running > 0:
            for j in every_lane(ended):
                attempt(system, y0, kind, measures, sums, rows, rtol, atol, measuring, waiting, j)
            attempts += 1
            running = total(waiting)
        for j in every_lane(ended):
            strobe(y0, rows, base, period, last, ended, j)
    for j in every_lane(ended):
        judge(system, y0, sums, rows, ended, j)
    return attempts


@dataclass(frozen=True)
class AdaptiveLanes:
    """Adaptive steps, in every lane."""

    blocks: ClassVar = 1  # that are worth a chunk of a sweep
    kernel: ClassVar = staticmethod(march_adaptive)  # of a block

    method: Dopri5

    def arguments(self, omega: Floats, _: int) -> tuple[Any, Floats]:
        """Arguments of the march, and the times (lanes,) that it counts in."""
        method = self.method
        return (float(method.rtol), float(method.atol), method.max_steps), 1.0 / omega

    def check(self, _: Any) -> None:
        """Refuse what lanes cannot do (ValueError)."""
        if self.method.largest_step is not None:
            raise ValueError(
                f"Dopri5.largest_step is {self.method.largest_step:g} s; steps of an ensemble are at most 1/16 of a "
                "turn: leave it out, or give Rk4(steps_per_period=...)"
            )

    def resolved(self, k: int, orders: tuple[int, ...]) -> tuple[float, str]:
        """Highest order of an amplitude that the steps resolve, and what does with order k.

        The steps follow the motion, whose orders are those of the system, not the cosine that it is multiplied by.
        """
        highest = max(1, int(HIGHEST_ADAPTIVE * (1e-9 / self.method.rtol) ** 0.2 * max((1, *orders))))
        return highest, f"a smaller rtol, or Dop8(steps_per_period={8 * PER_ORDER * -(-k // 8)})"

    def given(self, lanes: int) -> Any:
        """Steps a period (lanes,), all 0: every lane finds its own."""
        return np.zeros(lanes, int)

    def tolerances(self) -> tuple[float, float]:
        """Relative and absolute distance below which a state has come back."""
        return max(SETTLED_CHANGE, LOOSE * self.method.rtol), 10.0 * self.method.atol


@dataclass(frozen=True)
class FixedLanes:
    """Equal steps of a method, on a phase grid that lanes share."""

    blocks: ClassVar = 32  # some run again to estimate the error, and lanes share those of one number of steps only

    method: FixedStep

    @property
    def kernel(self) -> Any:
        """March of a block."""
        return march_pairs if self.method.piece == 2 else march_steps

    def arguments(self, omega: Floats, steps: int) -> tuple[Any, Floats]:
        """Arguments of the march, and the steps (lanes,) [s]."""
        return (self.method.scheme, steps), 2.0 * np.pi / steps / omega

    def check(self, system: System) -> None:
        """Refuse a system for which a step cannot be chosen (TypeError)."""
        if self.method.steps_per_period is None and not steps_known(system):
            name = type(system).__name__
            spring = is_spring(system)
            lacks = f"{name} has no jacobian and orders" if spring else "a law with friction or memory has no rate"
            raise TypeError(f"{lacks} to choose a step from; give steps_per_period or use Dopri5")

    def resolved(self, k: int, _: tuple[int, ...]) -> tuple[float, str]:
        """Highest order of an amplitude that the steps resolve, and what does with order k."""
        if self.method.steps_per_period is None:
            return np.inf, ""
        pieces = self._rounded() // self.method.piece
        return pieces // PER_ORDER, f"steps_per_period={PER_ORDER * self.method.piece * k}"

    def order_for(self, k: int) -> int:
        """Order that the system is to be taken to have, so that the method's own steps resolve an amplitude."""
        return -(-k * PER_ORDER * self.method.piece // self.method.steps)

    def given(self, lanes: int) -> Any:
        """Steps a period (lanes,), fours, where they are given."""
        return None if self.method.steps_per_period is None else np.full(lanes, self._rounded())

    def tolerances(self) -> tuple[float, float]:
        """Relative and absolute distance below which a state has come back."""
        return SETTLED_CHANGE, 0.0

    def _rounded(self) -> int:
        return -(-(self.method.steps_per_period or 0) // 4) * 4


def stepping_of(method: Any) -> Any:
    """Steps of a method in an ensemble: `AdaptiveLanes` or `FixedLanes`."""
    return (AdaptiveLanes if method.adaptive else FixedLanes)(method)


def steps_known(system: System) -> bool:
    """True for a system that states its fastest rates: fixed steps can be chosen for it."""
    return has_jacobian(system) and not lacking(system, "orders")


LADDER = np.unique(4 * np.ceil(16.0 * 2.0 ** (np.arange(60) / 3.0) / 4.0).astype(int))  # 16, 24, 28, 32, 44, ...
PLACES = np.linspace(-1.0, 1.0, 33)  # of the torsion, in units of its largest value


def fastest_rates(system: Any, reach: Floats) -> Floats:
    """Largest modulus (lanes,) [1/s] of the eigenvalues of the Jacobian for torsions up to `reach` (lanes,)."""
    with np.errstate(all="ignore"):
        x = PLACES[:, None] * reach[None, :]
        rows = system.jacobian(0.0, (x, np.zeros_like(x)))
        stiffness, damping = [-np.broadcast_to(np.asarray(entry, float), x.shape) for entry in rows[1]]
        half = 0.5 * np.abs(damping)
        fast = np.where(half * half > stiffness, half + np.sqrt(np.abs(half * half - stiffness)), np.sqrt(stiffness))
    return np.asarray(np.max(np.where(np.isfinite(fast), fast, 0.0), axis=0))


def steps_needed(per_scale: int, fastest: Floats, omega: Floats, order: int) -> Any:
    """Steps a period (lanes,) for `per_scale` steps per shortest time scale, from a ladder of few numbers."""
    wanted = per_scale * np.maximum(fastest / omega, order)
    return LADDER[np.minimum(np.searchsorted(LADDER, wanted), len(LADDER) - 1)]
