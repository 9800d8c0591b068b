"""A measured kinematic error: its lines with their uncertainty, from one or both directions of rotation.

Angles are those of the base turn that the orders refer to. The error is x = theta_m/N - theta_l; vendors' angular
transmission error theta_l - theta_m/N is its negative.

Which orders a scan has: the strongest line first, and in the end only those that the noise does not explain.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from ....base.quantities import choice, positive_count, shown
from ....model.error_spectrum import extremes
from ....model.excitation import HIGHEST
from ....model.orders import Turn
from ..run import column, refuse_descending
from . import error_result
from .aliases import between, twins
from .beats import clocks
from .error_result import Direction, ErrorScan, Fit, ScanLine, fit_lines, squared_amplitude
from .order_fit import FEWEST, Floor, correlation, noise_floor, power, probability, rounding

HIGHEST_SOUGHT = 100
NEARLY = 1e-6  # of a turn: rounding of the angles
ROUNDING = 1e-13  # of the largest error: that of the computer, which is no white noise but repeats with the lines

ROUNDED = 1.5  # a residual of at most so many times the variance of rounding has no lines
CANDIDATES = 8  # orders that are fitted beside the lines found: those that stand highest above the noise
PATIENCE = 3  # lines in a row that noise may explain as long as others leak into it


def false_alarms(fits: Sequence[Fit], orders: Sequence[float], floor: Floor, trials: int) -> list[float]:
    """Probabilities that noise alone makes the fitted lines of these orders, at one of so many orders looked at."""
    samples = sum(len(fit.left.angle) for fit in fits)
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
        following = _next(fits, chosen, highest, false_alarm, least)
        if following is None:
            break
        order, sure = following
        idle = 0 if sure else idle + 1
        chosen = sorted([*chosen, order])
    return _beyond_noise(runs, chosen, [], drift, highest, false_alarm, least)


def _beyond_noise(
    runs: Sequence[Direction], chosen: list[int], others: list[float], drift: bool, highest: int, false_alarm: float,
    least: float,
) -> list[int]:  # fmt: skip
    """Orders without those that are noise beside the rest and beside others."""
    while chosen:
        taken = [*chosen, *others]
        fits = [fit_lines(run, taken, drift) for run in runs]
        floor = noise_floor([fit.left for fit in fits], highest, taken, least)
        alarms = false_alarms(fits, taken, floor, highest)[: len(chosen)]
        worst = int(np.argmax(alarms))
        if alarms[worst] < false_alarm:
            break
        del chosen[worst]
    return chosen


def _next(
    fits: Sequence[Fit], chosen: list[int], highest: int, false_alarm: float, least: float
) -> tuple[int, bool] | None:  # fmt: skip
    """Order of the strongest line beyond noise and True; else that which noise explains least, and False."""
    left = [fit.left for fit in fits]
    samples = sum(len(run.angle) for run in left)
    unknowns = sum(len(fit.values) + 2 for fit in fits)
    if sum(float(r @ r) for _, r in left) <= ROUNDED * least * samples or samples <= unknowns + FEWEST:
        return None
    means, freedoms = noise_floor(left, highest, chosen, least).estimates(np.arange(1, highest + 1))
    ratios = power(left, 1.0, highest) / means
    ratios[np.array(chosen, int) - 1] = 0.0
    candidates = []
    for order in (1 + np.argsort(ratios)[::-1][:CANDIDATES]).tolist():
        parts = [fit.one_more(order) for fit in fits]
        whole = [part for part in parts if part is not None]
        if order not in chosen and len(whole) == len(parts):
            square = squared_amplitude(whole, samples)
            alarm = probability(square / float(means[order - 1]), float(freedoms[order - 1]), highest)
            candidates.append((alarm < false_alarm, square if alarm < false_alarm else -alarm, order))
    if not candidates:
        return None
    sure, _, order = max(candidates)
    return order, sure


def error_scan(
    angle: ArrayLike,
    error: ArrayLike,
    *,
    orders: Sequence[int] | None = None,
    backward: tuple[ArrayLike, ArrayLike] | None = None,
    highest: int | None = None,
    false_alarm: float = 0.01,
    drift: bool = True,
    noise: Literal["auto", "white", "autocorrelated"] = "auto",
    ate: bool = False,
    ratio: float | None = None,
    turn: Turn = "motor",
) -> ErrorScan:
    """Read a measured error scan into its lines.

    Least squares of a mean, a drift and cosines and sines of whole orders; the samples need not be equidistant. Orders
    are found one strength after the other: a periodogram of the residual, its local noise (from the 64 independent
    frequencies around each order), and the probability that noise alone reaches as high.

    Parameters
    ----------
    angle : (n,) array
        Base angle [rad], ascending, at least one turn.
    error : (n,) array
        Error theta_m/N - theta_l [rad] there, in the forward direction.
    orders : sequence of int, optional
        Orders to fit. Default: those found up to `highest`.
    backward : pair of arrays, optional
        Angle and error in the backward direction, angles ascending too; lines are then the mean of both directions.
    highest : int, optional
        Highest order sought. Default: 100, or 0.45 times the samples per turn where that is less.
    false_alarm : float
        Probability that pure noise gives any line at all, for the search.
    drift : bool
        Whether to remove a drift that is linear in the angle.
    noise : {"auto", "white", "autocorrelated"}
        What the residual is taken for. "auto": autocorrelated if neighbouring residuals correlate by more than three
        standard deviations of a white sequence.
    ate : bool
        Whether `error` is the vendors' transmission error theta_l - theta_m/N, whose sign is opposite.
    ratio : float, optional
        Of the gear: its orders beyond those that the angles show are then known, and which of them look alike.
    turn : {"motor", "output"}
        The base turn, with a ratio.

    Returns
    -------
    ErrorScan
        `lines`: order, `amplitude` (0-to-peak) [rad] and `phase` [rad], each with its standard error; `residual`
        [rad], root mean square; `.error` is the kinematic error for a drive. `between`: lines between whole orders;
        `aliases`: by order what the angles do not tell from it.

    Raises
    ------
    ValueError
        If the samples are not finite, ascending, more than the unknowns and over a turn, an order is too high for their
        distance, or they do not tell the lines apart.

    References
    ----------
    Lomb 1976, Astrophys. Space Sci. 39, 447-462, and Scargle 1982, Astrophys. J. 263, 835-853 (least-squares spectra of
    unevenly spaced data, false alarms); Bretthorst 1988, Bayesian Spectrum Analysis, ch. 2 (uncertainty of a line).
    """
    if not 1e-100 <= false_alarm < 1.0:
        raise ValueError(f"false_alarm is {shown(false_alarm)}; it is a probability between 0 and 1, such as 0.01")
    choice("noise", noise, "auto", *get_args(error_result.Noise))
    sign = -1.0 if ate else 1.0
    runs = [_direction("", angle, error, sign)]
    if backward is not None:
        runs.append(_direction("backward ", *backward, sign))
    limit = min(0.5 * len(run.angle) / run.turns for run in runs)
    looked_at = _sought(highest, limit)
    least = _resolution(runs)
    if orders is None:
        chosen = found_orders(runs, drift, looked_at, false_alarm, least)
        others = between(runs, drift, chosen, looked_at, false_alarm, least)
        if others:
            chosen = _beyond_noise(runs, chosen, others, drift, looked_at, false_alarm, least)
    else:
        chosen, others = _given(orders, limit), []
    trials = looked_at if orders is None else len(chosen)
    fits = [fit_lines(run, [*chosen, *others], drift) for run in runs]
    scan = _scan(fits, chosen, others, trials, false_alarm, noise, least)
    return replace(scan, limit=limit, aliases=twins(runs, chosen, limit, clocks(ratio, turn if ratio else "motor")))


def _direction(prefix: str, angle: Any, error: Any, sign: float) -> Direction:
    theta, e = column(f"{prefix}angle", angle), column(f"{prefix}error", error)
    if theta.ndim != 1 or theta.shape != e.shape or len(theta) < 4:
        raise ValueError(
            f"{prefix}angle and error have the shapes {theta.shape} and {e.shape}; give one length of 4 at least"
        )
    back = "average repeated ones, give the way back as `backward`, its angles ascending too"
    refuse_descending(theta, f"{prefix}angle", "rad", f"angles must ascend: {back}")
    direction = Direction(theta, sign * e)
    if direction.turns < 1.0 - NEARLY:
        raise ValueError(
            f"the {prefix}angles reach over {direction.turns:.4g} turns of the base angle; scan at least one whole "
            "turn, or take a base angle that turns faster (the motor's)"
        )
    return direction


def _resolution(runs: list[Direction]) -> float:
    """Variance [rad^2] that rounding gives the samples: step^2/12, step being the smallest difference of two values.

    A scan with less noise than its step has steps that repeat with the lines and would pass for more of them.
    """
    values = np.concatenate([run.error for run in runs])
    return max(rounding(values), (ROUNDING * float(np.max(np.abs(values)))) ** 2 / 12.0)


def _sought(highest: int | None, limit: float) -> int:
    if limit <= 1.0:
        raise ValueError(
            f"the angles stand {0.5 / limit:.3g} turns apart, which tells no whole order; scan at more than two a "
            "turn, or count orders on the slower shaft's turn"
        )
    if highest is None:
        return max(1, min(HIGHEST_SOUGHT, int(0.9 * limit)))
    wanted = positive_count("highest", highest, HIGHEST)
    if not wanted < limit:
        raise ValueError(
            f"highest is {wanted}; with these samples orders below {limit:.4g} are told apart (two a period)"
        )
    return wanted


def _given(orders: Sequence[int], limit: float) -> list[int]:
    chosen = [positive_count("order", order, HIGHEST) for order in orders]
    if not chosen or len(set(chosen)) < len(chosen):
        raise ValueError(f"orders are {shown(orders)}; give at least one, and none twice")
    if not max(chosen) < limit:
        raise ValueError(
            f"order {max(chosen)} is too high for these samples, which tell orders below {limit:.4g} apart"
        )
    return sorted(chosen)


def _scan(
    fits: list[Fit], whole: list[int], others: list[float], trials: int, false_alarm: float, noise: str, least: float
) -> ErrorScan:  # fmt: skip
    """Put the fits of one or two directions together: whole orders, and others between them."""
    orders = [*whole, *others]
    left = [fit.left for fit in fits]
    sizes = [len(run.angle) for run in left]
    samples, neighbours = sum(sizes), float(np.average([correlation(run.error) for run in left], weights=sizes))
    coloured = noise == "autocorrelated" or (noise == "auto" and abs(neighbours) > 3.0 / math.sqrt(samples))
    floors = [noise_floor([run], math.ceil(max(orders, default=1)), orders, least) for run in left]
    common_noise = noise_floor(left, max(trials, *whole, 1), orders, least)
    white = not (coloured and all(floor.enough for floor in floors))

    def variances(order: float) -> list[float]:
        if white:
            whole = (float(np.sum(f.left.error**2)) / (len(f.left.error) - len(f.values)) for f in fits)
            return [max(variance, least) for variance in whole]
        return [floor.variance(order) for floor in floors]

    alarms = false_alarms(fits, orders, common_noise, trials)
    lines = tuple(_line(i, k, fits, variances(k), alarms[i]) for i, k in enumerate(orders))
    # mean [rad] at the middle of the scan, drift [rad/rad]
    means, drifts = [fit.values[0] for fit in fits], [fit.values[1] if fit.drift else 0.0 for fit in fits]
    slopes = [2.0 * drift / (run.angle[-1] - run.angle[0]) for drift, run in zip(drifts, left, strict=True)]
    reversal = None
    if len(fits) == 2:
        difference = fits[0].values[1 + fits[0].drift :] - fits[1].values[1 + fits[1].drift :]
        difference = difference[: 2 * len(whole)]
        low, high = extremes(whole, difference[0::2], difference[1::2])
        spread = math.sqrt(sum(v * float(fit.inverse[0, 0]) for v, fit in zip(variances(0), fits, strict=True)))
        reversal = error_result.Reversal(float(means[0] - means[1]), spread, high - low)
    return ErrorScan(
        lines[: len(whole)],
        float(np.mean(means)),
        float(np.mean(slopes)),
        math.sqrt(sum(float(np.sum(run.error**2)) for run in left) / samples),
        neighbours,
        "white" if white else "autocorrelated",
        common_noise.threshold(false_alarm, trials),
        samples,
        min(run.turns for run in left),
        reversal,
        lines[len(whole) :],
    )


def _line(i: int, order: float, fits: list[Fit], variances: list[float], false_alarm: float) -> ScanLine:
    """Line i as the mean over the directions, with errors to first order."""
    found = [fit.line(i) for fit in fits]
    (a, b), covariance = error_result.together(
        [(values, v * inverse) for v, (values, inverse) in zip(variances, found, strict=True)]
    )
    line = error_result.polar(complex(a, b), covariance)
    return ScanLine(order, line.amplitude, line.amplitude_error, -line.phase, line.phase_error, false_alarm)
