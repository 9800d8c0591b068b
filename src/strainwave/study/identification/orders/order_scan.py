"""Orders of a measured quantity from runs over any part of a turn, at one speed or several."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from scipy.special import gammaincc

from ....base.quantities import number, numbers, shown
from ....base.results import Floats
from ....model.orders import Turn
from ..run import Run
from .beats import clocks, named, unparted
from .error_result import Polar, polar
from .order_fit import DELAY_S, ROUNDS, SAME_SPEED, Joint, RunFit, fit_run, fit_together
from .order_result import OrderLine, OrderScan
from .order_search import DECISION, FoundLine
from .places import CHANCE, placed_lines
from .responses import Responses, responses, sinc

ORDER_SHARE = 0.4  # of the samples per turn: the highest order that they show
RUN_DIFFERENCE = 5.0  # deviations by which runs may differ before it is said
FEW_RUNS, STRONG_LINE, COHERENT_SHARE = 4, 10.0, 0.6  # runs; deviations; share of size: less is no line
DOUBT_CHANCE = 0.01  # probability that noise alone makes runs differ as much, below which their errors grow


class Fitted(NamedTuple):
    """Lines over the angle, fitted in each run and in all together."""

    lines: list[FoundLine]
    fits: list[RunFit]
    joint: Joint

    @property
    def orders(self) -> Floats:
        """Orders (lines,)."""
        return np.array([line.place for line in self.lines])


class Measured(NamedTuple):
    """Runs, mean speeds [rad/s], the highest order they show, and frequencies [Hz] of lines that stay with the time."""

    runs: list[Run]
    speeds: Floats
    limit: float
    standing: list[float]

    def fitted(self, lines: list[FoundLine], *, delayed: bool) -> Fitted:
        """Lines fitted in all runs; a delay is found again until it stays."""
        orders = np.array([line.place for line in lines])
        loose = [i for i, line in enumerate(lines) if line.joint and line.place != round(line.place)]
        delay, rounds = 0.0, ROUNDS if delayed and lines else 1
        beyond = float(np.max(orders, initial=1.0)) * 1.2 + 20.0 / min(run.turns for run in self.runs)
        top = min(self.limit, beyond)
        for i in range(rounds):
            fits = [fit_run(run, list(orders), delay, top, self.standing, loose) for run in self.runs]
            if not lines:
                return Fitted(lines, fits, Joint(np.zeros(0), np.zeros((1, 1)), 0.0, 0.0, 0))
            joint = fit_together(orders, self.speeds, fits, delay, delayed=delayed)
            if abs(joint.delay - delay) < 1e-7 or i + 1 == rounds:
                break
            delay = joint.delay
        return Fitted(lines, fits, joint)

    def without_chance(self, first: Fitted, false_alarm: float, *, delayed: bool) -> Fitted:
        """Lines that stand out where all are fitted together, fitted again where others are left out."""
        sure = [line for i, line in enumerate(first.lines) if _stands_out(first, i, false_alarm)]
        return first if len(sure) == len(first.lines) else self.fitted(sure, delayed=delayed)

    def before_hold(self, held: Fitted, hold: float) -> Fitted:
        """The same with joint lines before a hold or a mean over a time; those of each run stay as measured."""
        left = [sinc(held.orders, speed, hold) for speed in self.speeds]
        fits = [
            replace(fit, values=fit.values / some, spreads=fit.spreads / some[:, None, None] ** 2)
            for fit, some in zip(held.fits, left, strict=True)
        ]
        return held._replace(joint=fit_together(held.orders, self.speeds, fits, held.joint.delay, delayed=True))


class Agreement(NamedTuple):
    """Probability that values are one but for their deviations, their mean, and the sum of squared differences."""

    probability: float
    mean: float
    excess: float


def order_scan(
    runs: Sequence[Run],
    orders: Sequence[float] | None = None,
    ratio: float | None = None,
    *,
    shaft: Turn = "motor",
    highest: float | None = None,
    false_alarm: float = 0.01,
) -> OrderScan:
    """Find the lines of a quantity that was measured while a shaft turned.

    Each run has its own mean and slow part; amplitude and phase of each line are those of all runs together, and so is
    one delay, by which the value lags behind the angle. Their errors follow from the noise around each line, and are
    larger where runs differ by more. Runs at three speeds or more may show instead that the value is held or averaged
    over a time, and a delay and a growth of each line.

    Parameters
    ----------
    runs : sequence of Run
        Stretches in which the shaft turns one way, over any part of a turn, at one speed or several. Angles of all runs
        count from one zero.
    orders : sequence of float, optional
        Orders to fit. Default: those found. Both end at 0.4 of the distinct angles of a turn, or of the samples.
    ratio : float, optional
        Motor turns per turn of the output, a whole number, negative where the output turns the other way. Lines then
        have the pair of turns that they belong to, where the runs are long enough to tell.
    shaft : {"motor", "output"}
        Whose angle the runs have.
    highest : float, optional
        Highest order looked for. Default: 1000, or less where the samples do not show it.
    false_alarm : float
        Probability that noise alone gives a line.

    Returns
    -------
    OrderScan
        `lines`: order, amplitude (0-to-peak, in the unit of the values) and phase [rad] with their standard
        errors; the `delay` [s] of the value; `residual`, the root mean square of what is left.

    Raises
    ------
    ValueError
        If there is no run, the runs have different units, or they do not tell the orders apart.

    References
    ----------
    Lomb 1976, Astrophys. Space Sci. 39, 447-462; Rife & Boorstyn 1974, IEEE Trans. Inf. Theory 20(5), 591-598; Birge
    1932, Phys. Rev. 40, 207-227 (errors of values that differ by more than theirs).
    """
    runs, turning = _checked(runs), clocks(ratio, shaft)
    false_alarm = number("false_alarm", false_alarm, positive=True)
    if not false_alarm < 1.0:
        raise ValueError(f"false_alarm is {false_alarm:g}; it is a probability between 0 and 1, for example 0.01")
    # angles that repeat, as those of a coarse encoder do, show no more than their distinct places
    limit = min(ORDER_SHARE * len(np.unique(run.angle)) / run.turns for run in runs)
    speeds = np.array([run.speed for run in runs])
    spread = float(np.ptp(np.abs(speeds))) / float(np.max(np.abs(speeds)))
    several = spread > SAME_SPEED or len({bool(s > 0.0) for s in speeds}) > 1
    if orders is None:
        placed, base = placed_lines(runs, limit, highest, false_alarm, turning)
    else:
        given = [FoundLine(k, 0.0, "order", math.inf, 0.0) for k in _given(orders, limit)]
        placed, base = [named(line, turning, runs) for line in given], 0.0
    over_angle = sorted((line for line in placed if line.kind != "frequency"), key=lambda line: line.place)
    over_time = [line for line in placed if line.kind == "frequency"]
    measured = Measured(runs, speeds, limit, [line.place for line in over_time])
    first = measured.fitted(over_angle, delayed=several)
    sure = first if orders is not None else measured.without_chance(first, false_alarm, delayed=several)
    too_long = abs(sure.joint.delay) > DELAY_S
    delayed = several and len(sure.lines) > 0 and not too_long
    as_measured = measured.fitted(sure.lines, delayed=False) if too_long else sure
    forms = responses(sure.orders, speeds, sure.fits, sure.joint.delay) if delayed else None
    fitted = measured.before_hold(as_measured, forms.hold) if forms is not None and forms.hold else as_measured
    fits, joint = fitted.fits, fitted.joint
    steady = [_frequency_line(line, runs, fits) for line in over_time]
    steady = [k for k in steady if len(runs) < FEW_RUNS or k.amplitude >= COHERENT_SHARE * float(np.median(k.by_run))]
    lines = [*_lines(fitted, several), *steady]
    forward, backward = _by_direction(fitted, speeds, several)
    left = np.concatenate([fit.residual for fit in fits])
    scan = OrderScan(
        lines=tuple(sorted(lines, key=lambda line: line.order)), delay=joint.delay if delayed else 0.0,
        delay_error=math.sqrt(max(joint.covariance[-1, -1], 0.0)) * _birge(joint) if delayed else math.inf,
        speeds=speeds, residual=float(np.sqrt(np.mean(left * left))), base=base,
        notes=tuple(_notes(lines, speeds, several, too_long, forms)), unit=runs[0].unit, freedom=_freedom(joint),
        forward=forward, backward=backward, responses=forms,
    )  # fmt: skip
    notes = (*scan.notes, *_differences(scan, joint, spread > SAME_SPEED), *unparted(fitted.lines, turning, runs))
    return replace(scan, notes=notes)


def _differences(scan: OrderScan, joint: Joint, speeds: bool) -> list[str]:
    """Reasons for which runs differ by more than their noise."""
    orders = ", ".join(f"{line.order:g}" for line in scan.varying)
    if orders and speeds:
        return [
            f"amplitudes differ between runs by more than their errors, of the orders {orders}: towards a resonance "
            "they grow with the speed; scan the slowest runs alone, or identify the drive, which has its resonance"
        ]
    if orders:
        return [
            f"amplitudes differ between runs of one speed by more than their errors, of the orders {orders}: give runs "
            "of one shaft under one load, each direction alone"
        ]
    if _birge(joint) > RUN_DIFFERENCE:
        return [
            f"amplitudes agree within 5 % and phases differ, {_birge(joint):.3g} times as much as by noise: give runs "
            "of one shaft, with one zero of angle"
        ]
    return []


def _stands_out(fitted: Fitted, i: int, false_alarm: float) -> bool:
    """True if a line that was found is more than noise where all lines are fitted together, and one in all runs.

    What friction and starts leave in each run is weak, and has a phase of its own in each.
    """
    sizes, errors = np.array([fit.amplitude(i) for fit in fitted.fits]).T
    power = float(np.sum((sizes / errors) ** 2))
    weak = len(sizes) >= FEW_RUNS and power < len(sizes) * STRONG_LINE**2
    if weak and abs(fitted.joint.values[i]) < COHERENT_SHARE * float(np.median(sizes)):
        return False
    return float(gammaincc(len(sizes), 0.5 * power)) < false_alarm


def _by_direction(
    fitted: Fitted, speeds: Floats, several: bool
) -> tuple[tuple[OrderLine, ...], tuple[OrderLine, ...]]:  # fmt: skip
    """Lines of the runs forward and of those backward, with the delay of all; none where there is one direction."""
    if not (np.any(speeds > 0.0) and np.any(speeds < 0.0) and fitted.lines):
        return (), ()
    directions = []
    for direction in (1.0, -1.0):
        some = [i for i, speed in enumerate(speeds) if speed * direction > 0.0]
        fits = [fitted.fits[i] for i in some]
        joint = fit_together(fitted.orders, speeds[some], fits, fitted.joint.delay, delayed=False)
        directions.append(tuple(_lines(Fitted(fitted.lines, fits, joint), several)))
    return directions[0], directions[1]


def _notes(
    lines: Sequence[OrderLine], speeds: Floats, several: bool, beyond: bool, forms: Responses | None
) -> Iterator[str]:  # fmt: skip
    """Notes on what the runs cannot tell, and on an amplitude that grows."""
    if forms is not None and forms.hold:
        yield (
            f"the value is held or averaged over {1e3 * forms.hold:.3g} ms, as all runs show; the amplitudes are "
            "corrected for this"
        )
    grown = [form.order for form in forms.lines if form.gain] if forms is not None else []
    for order in grown:
        yield f"order {order:g} grows with the speed; predictions include this"
    if beyond:
        yield f"no delay up to {1e3 * DELAY_S:g} ms fits the runs; no delay is assumed"
    if not several:
        yield ("at one speed, delay and phase, order and frequency cannot be separated: measure at a second")
    for line in lines:
        over_angle = line.order not in grown and line.kind != "frequency"
        if over_angle and len(line.by_run) > 1 and line.same < CHANCE / len(lines):
            i, middle = int(np.argmax(line.by_run)), float(np.median(line.by_run))
            if line.by_run[i] > 1.5 * middle:
                yield (
                    f"order {line.order:g} has {line.by_run[i]:.4g} at {speeds[i]:.4g} rad/s; the median of "
                    f"all runs is {middle:.4g}: a resonance may lie near "
                    f"{line.order * abs(speeds[i]) / (2.0 * math.pi):.4g} Hz"
                )


def _checked(given: Any) -> list[Run]:
    runs: list[Run] = [given] if isinstance(given, Run) else list(given)
    if not runs:
        raise ValueError("runs is empty; give one run at least")
    units = sorted({run.unit for run in runs})
    if len(units) > 1:
        raise ValueError(f"the runs have values in {' and '.join(map(repr, units))}; give one quantity in one unit")
    return runs


def _given(orders: Any, limit: float) -> list[float]:
    chosen = sorted(float(k) for k in numbers("orders", orders))
    if not chosen or not chosen[0] > 0.0 or len(set(chosen)) < len(chosen):
        raise ValueError(f"orders are {shown(orders)}; give positive ones, none twice")
    if chosen[-1] > limit:
        raise ValueError(f"order {chosen[-1]:g} is too high; these samples show orders below {limit:.4g}")
    return chosen


def _birge(joint: Joint) -> float:
    """Factor of the errors: 1 where the noise may explain how runs differ."""
    return math.sqrt(joint.misfit / joint.freedom) if _differ(joint) else 1.0


def _freedom(joint: Joint) -> float:
    """Degrees of freedom of the errors."""
    return float(joint.freedom) if _differ(joint) else math.inf


def _differ(joint: Joint) -> bool:
    """True if runs differ by more than their noise, with a probability of 1 - `DOUBT_CHANCE`."""
    return joint.freedom > 0 and float(gammaincc(0.5 * joint.freedom, 0.5 * joint.misfit)) < DOUBT_CHANCE


def _lines(fitted: Fitted, several: bool) -> Iterator[OrderLine]:
    """Lines over the angle with the errors of all runs, and those of each run."""
    factor, freedom = _birge(fitted.joint) ** 2, _freedom(fitted.joint)
    for i, (line, c) in enumerate(zip(fitted.lines, fitted.joint.values, strict=True)):
        pair = slice(2 * i, 2 * i + 2)
        mean = polar(complex(c), fitted.joint.covariance[pair, pair] * factor)
        by_run, errors = np.array([fit.amplitude(i) for fit in fitted.fits]).T
        yield OrderLine(
            line.place, line.error, *mean, kind=line.kind, why=_why(line, several=several),
            false_alarm=line.false_alarm, frequency=math.nan, by_run=by_run, by_run_error=errors,
            same=_agreement(by_run, errors).probability, freedom=freedom, pairs=line.pairs,
        )  # fmt: skip


def _agreement(values: Floats, errors: Floats) -> Agreement:
    """Agreement of values with these deviations."""
    mean = float(np.sum(values / errors**2) / np.sum(1.0 / errors**2))
    excess = float(np.sum(((values - mean) / errors) ** 2))
    chance = float(gammaincc(0.5 * (len(values) - 1), 0.5 * excess)) if len(values) > 1 else 1.0
    return Agreement(chance, mean, excess)


def _why(line: FoundLine, *, several: bool) -> str:
    if math.isinf(line.difference):
        return "order given by the user"
    odds = f"e^{abs(line.difference):.0f} to 1"
    if line.kind == "order" and line.difference <= DECISION:
        return "runs at several speeds show the same order"
    if line.kind == "order":
        return f"proportional to angle, {odds}"
    if line.kind == "frequency":
        return f"constant in time, {odds}"
    if not several:
        return "one speed cannot separate an order from a frequency"
    return "the runs cannot separate an order from a frequency"


def _frequency_line(line: FoundLine, runs: Sequence[Run], fits: Sequence[RunFit]) -> OrderLine:
    """A line that stays with the time: its amplitude is the mean of those in the runs."""
    sizes = []
    for run, beside in zip(runs, fits, strict=True):
        over_time = Run(run.time, 2.0 * np.pi * run.time, beside.without_orders)
        sizes.append(fit_run(over_time, [line.place], 0.0, 2.0 * line.place + 20.0 / over_time.turns).amplitude(0))
    a, s = np.array(sizes).T
    agreement = _agreement(a, s)
    error = math.sqrt(max(1.0, agreement.excess / max(len(a) - 1, 1)) / float(np.sum(1.0 / s**2)))
    period = 2.0 * math.pi / abs(runs[0].speed)
    size, why = Polar(agreement.mean, error, 0.0, math.pi), _why(line, several=True)
    return OrderLine(
        line.place * period, line.error * period, *size, kind="frequency", why=why, false_alarm=line.false_alarm,
        frequency=line.place, by_run=a, by_run_error=s, same=agreement.probability, freedom=float(max(len(a) - 1, 1)),
    )  # fmt: skip
