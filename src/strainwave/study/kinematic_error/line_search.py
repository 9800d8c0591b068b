"""Which orders a scan has: the strongest line first, and in the end only those that the noise does not explain."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .line_fit import Direction, Fit, fit_lines, squared_amplitude
from .line_noise import FEWEST, Floor, noise_floor, power, probability

ROUNDED = 1.5  # a residual of at most so many times the variance of rounding has no lines
CANDIDATES = 8  # orders that are fitted beside the lines found: those that stand highest above the noise
PATIENCE = 3  # lines in a row that noise may explain as long as others leak into it


def false_alarms(fits: Sequence[Fit], orders: Sequence[int], floor: Floor, trials: int) -> list[float]:
    """Probabilities that noise alone makes the fitted lines of these orders, at one of so many orders looked at."""
    samples = sum(len(fit.residual) for fit in fits)
    squares = (squared_amplitude([fit.line(i) for fit in fits], samples) for i in range(len(orders)))
    estimates = zip(squares, *floor.estimates(orders), strict=True)
    return [probability(square / float(mean), float(freedom), trials) for square, mean, freedom in estimates]


def found_orders(runs: Sequence[Direction], drift: bool, highest: int, false_alarm: float, least: float) -> list[int]:
    """Orders whose lines noise alone would reach with a probability below `false_alarm`, over all orders.

    A line that is not fitted yet leaks into others and into what passes for noise, by the drift and over part of a
    turn. So lines come one at a time, `PATIENCE` of them on trial, and in the end those go that are noise beside the
    others.

    Parameters
    ----------
    runs : sequence of Direction
        The scan, one or two directions.
    drift : bool
        Whether a drift is fitted.
    highest : int
        Highest order looked at.
    least : float
        Variance of rounding.
    """
    chosen: list[int] = []
    idle = 0
    while idle < PATIENCE and len(chosen) < highest:
        fits = [fit_lines(run, chosen, drift) for run in runs]
        following = _next(_left(runs, fits), fits, chosen, highest, false_alarm, least)
        if following is None:
            break
        idle = 0 if following.sure else idle + 1
        chosen = sorted([*chosen, following.order])
    while chosen:
        fits = [fit_lines(run, chosen, drift) for run in runs]
        alarms = false_alarms(fits, chosen, noise_floor(_left(runs, fits), highest, chosen, least), highest)
        worst = int(np.argmax(alarms))
        if alarms[worst] < false_alarm:
            break
        del chosen[worst]
    return chosen


def _left(runs: Sequence[Direction], fits: Sequence[Fit]) -> list[Direction]:
    return [Direction(run.angle, fit.residual) for run, fit in zip(runs, fits, strict=True)]


class _Next(NamedTuple):
    order: int
    sure: bool


def _next(
    left: Sequence[Direction], fits: Sequence[Fit], chosen: list[int], highest: int, false_alarm: float, least: float
) -> _Next | None:
    """Strongest line beside those chosen that noise does not explain, or else the one that it explains least."""
    samples = sum(len(run.angle) for run in left)
    unknowns = sum(len(fit.values) + 2 for fit in fits)
    if sum(float(r @ r) for _, r in left) <= ROUNDED * least * samples or samples <= unknowns + FEWEST:
        return None
    floor = noise_floor(left, highest, chosen, least)
    means, freedoms = floor.estimates(np.arange(1, highest + 1))
    ratios = power(left, 1.0, highest) / means
    ratios[np.array(chosen, int) - 1] = 0.0
    found = []
    for order in (1 + np.argsort(ratios)[::-1][:CANDIDATES]).tolist():
        parts = [fit.one_more(run.angle, order) for run, fit in zip(left, fits, strict=True)]
        whole = [part for part in parts if part is not None]
        if order not in chosen and len(whole) == len(parts):
            square = squared_amplitude(whole, samples)
            alarm = probability(square / float(means[order - 1]), float(freedoms[order - 1]), highest)
            found.append((alarm < false_alarm, square if alarm < false_alarm else -alarm, order))
    if not found:
        return None
    sure, _, order = max(found)
    return _Next(order, sure)
