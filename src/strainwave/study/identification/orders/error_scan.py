"""A measured kinematic error: its lines with their uncertainty, from one or both directions, and its aliases.

Angles are those of the base turn that the orders refer to. The error is x = theta_m/N - theta_l; vendors' angular
transmission error theta_l - theta_m/N is its negative.

Spectrum and fit are those of `order_scan`, on places that are known: whole orders. So the strongest line comes first,
and in the end only those stay that the noise does not explain.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import minimize_scalar

from ....base.quantities import choice, positive_count, shown
from ....base.results import Floats
from ....model.error_spectrum import extremes
from ....model.excitation import HIGHEST
from ....model.orders import Turn
from ..intervals import without
from ..run import Run, column, refuse_descending
from .beats import Clocks, clocks
from .error_result import ErrorScan, Noise, Reversal, ScanLine, polar
from .order_fit import FEWEST_NEIGHBOURS, RunFit, correlation, fit_run, rounding, waves_of
from .order_search import Coordinate, Spectrum, chance_of

HIGHEST_ORDER = 100
ANGLE_ROUNDING = 1e-6  # of a turn: rounding of the angles
ROUNDING = 1.5  # a residual of at most so many times the variance of rounding has no lines
CANDIDATES = 4  # orders that are tried beside the lines found
PATIENCE = 3  # lines in a row that noise may explain as long as others leak into it
LOWEST_ORDER = 0.9  # order that is looked for


@dataclass(frozen=True, eq=False)
class Direction(Run):
    """One direction of a scan: angles that ascend take the place of the time, a mean that of all slow parts."""

    drift: bool = True

    def __post_init__(self) -> None:
        """Leave as they are columns that are checked already."""

    @property
    def turns(self) -> float:
        """Turns scanned, the last sample's share included."""
        return super().turns * len(self.angle) / (len(self.angle) - 1)

    def slow_columns(self, lowest: float) -> Floats:  # noqa: ARG002
        """Mean and drift (n, 1 or 2)."""
        return super().slow_columns(0.0)[:, : 1 + self.drift]


def _orders(runs: Sequence[Run], highest: int, false_alarm: float) -> list[float]:
    """Places of lines: whole orders, and others apart from these by half of what the turns resolve.

    A line that is not fitted yet leaks into others and into what passes for noise, by the drift and over part of a
    turn. So lines come one at a time, `PATIENCE` of them on trial, and in the end those go that are noise beside the
    others.
    """
    resolution = 1.0 / max(run.turns for run in runs)
    axes = [Coordinate(run.angle - run.angle[0], highest + resolution, rounding(run.value)) for run in runs]
    spectrum = Spectrum(axes, LOWEST_ORDER)
    beside = np.abs(spectrum.places - np.round(spectrum.places))
    is_whole, free = beside <= 0.5 * spectrum.step, beside > 0.5 * resolution
    free |= is_whole
    chosen, idle = list[float](), 0
    while idle < PATIENCE:
        left = _left(runs, chosen)
        explained = all(float(r @ r) <= ROUNDING * axis.least * len(r) for r, axis in zip(left, axes, strict=True))
        sums = np.where(free, np.sum(spectrum.ratios(left), axis=0), 0.0)
        likely = np.flatnonzero(sums * is_whole).tolist()
        if explained or not likely or min(map(len, left)) <= 2 * len(chosen) + 4 + FEWEST_NEIGHBOURS:
            break
        first, other = max(likely, key=sums.item), int(np.argmax(sums * ~is_whole))
        best, sure = first, chance_of(sums.item(first), highest, len(runs), between=False) < false_alarm
        if not sure and chance_of(sums.item(other), spectrum.trials, len(runs)) < false_alarm:
            best, sure = other, True
        elif not sure:
            some = sorted(likely, key=sums.item)[-CANDIDATES:]
            best = min(some, key=lambda i: _size(runs, [*chosen, round(spectrum.places.item(i))]))
        idle = 0 if sure else idle + 1
        order = spectrum.places.item(best)
        chosen.append(round(order) if is_whole[best] else _settled(runs, chosen, order, spectrum.step))
        free &= np.abs(spectrum.places - chosen[-1]) > (0.5 if is_whole[best] else 1.0) * resolution
    while chosen:
        fits = _fits(runs, chosen, highest)
        alarms = [_chance(fits, i, k, highest if k == round(k) else spectrum.trials) for i, k in enumerate(chosen)]
        if max(alarms) < false_alarm:
            break
        del chosen[int(np.argmax(alarms))]
    return sorted(chosen)


def _left(runs: Sequence[Run], orders: Sequence[float]) -> list[Floats]:
    """Residual of mean, drift and lines in each direction."""
    return [without(np.column_stack([run.slow_columns(0.0), *waves_of(run.angle, orders)]), run.value) for run in runs]


def _size(runs: Sequence[Run], orders: Sequence[float]) -> float:
    return sum(float(residual @ residual) for residual in _left(runs, orders))


def _settled(runs: Sequence[Run], others: Sequence[float], order: float, step: float) -> float:
    """The place of a line, so near to one beside others, that leaves least."""
    bounds = (order - step, order + step)
    return float(minimize_scalar(lambda k: _size(runs, [*others, k]), bounds=bounds, method="bounded").x)


def _fits(runs: Sequence[Run], places: Sequence[float], highest: float) -> list[RunFit]:
    loose = [i for i, k in enumerate(places) if k != round(k)]
    return [fit_run(run, places, 0.0, highest, loose=loose) for run in runs]


def _chance(fits: Sequence[RunFit], i: int, order: float, trials: float) -> float:
    """Probability that noise alone makes this line in the mean of the directions, at one of so many orders."""
    estimates = [fit.floor.estimates(order) for fit in fits]
    variances = [
        max(0.25 * len(fit.residual) * mean.item(), fit.least) for fit, (mean, _) in zip(fits, estimates, strict=True)
    ]
    c, covariance = _mean(fits, i, variances)
    values, freedom = np.array([c.real, c.imag]), min(freedom.item() for _, freedom in estimates)
    ratio = 0.5 * float(values @ np.linalg.solve(covariance, values))
    return chance_of(freedom * math.log1p(ratio / freedom), trials, 1, between=False)


def _mean(fits: Sequence[RunFit], i: int, variances: Sequence[float]) -> tuple[complex, Floats]:
    """Line i as the mean over the directions, and the covariance of its parts with these variances of a sample."""
    spreads = [fit.block(i) * v for fit, v in zip(fits, variances, strict=True)]
    return complex(np.mean([fit.values[i] for fit in fits])), np.sum(spreads, axis=0) / len(fits) ** 2


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
    choice("noise", noise, "auto", *get_args(Noise))
    sign = -1.0 if ate else 1.0
    runs = [_direction("", angle, error, sign, drift)]
    if backward is not None:
        runs.append(_direction("backward ", *backward, sign, drift))
    limit = min(0.5 * len(run.angle) / run.turns for run in runs)
    looked_at = _sought(highest, limit)
    places = _orders(runs, looked_at, false_alarm) if orders is None else _given(orders, limit)
    trials = looked_at if orders is None else len(places)
    scan = _scan(runs, places, trials, false_alarm, noise)
    chosen = [line.order for line in scan.lines]
    return replace(scan, limit=limit, aliases=twins(runs, chosen, limit, clocks(ratio, turn if ratio else "motor")))


def _direction(prefix: str, angle: Any, error: Any, sign: float, drift: bool) -> Direction:
    theta, e = column(f"{prefix}angle", angle), column(f"{prefix}error", error)
    if theta.ndim != 1 or theta.shape != e.shape or len(theta) < 4:
        raise ValueError(
            f"{prefix}angle and error have the shapes {theta.shape} and {e.shape}; give one length of 4 at least"
        )
    back = "average repeated angles; give the backward run as `backward`, with ascending angles"
    refuse_descending(theta, f"{prefix}angle", "rad", f"angles must ascend: {back}")
    direction = Direction(theta, theta, sign * e, drift=drift)
    if direction.turns < 1.0 - ANGLE_ROUNDING:
        raise ValueError(
            f"the {prefix}angles reach over {direction.turns:.4g} turns of the base angle; scan at least one "
            "whole turn, or take a base angle that turns faster (the motor's)"
        )
    return direction


def _sought(highest: int | None, limit: float) -> int:
    if limit <= 1.0:
        raise ValueError(
            f"the angles stand {0.5 / limit:.3g} turns apart, too far to resolve any order; scan at more than two "
            "per turn, or count orders on the slower shaft's turn"
        )
    if highest is None:
        return max(1, min(HIGHEST_ORDER, int(0.9 * limit)))
    wanted = positive_count("highest", highest, HIGHEST)
    if not wanted < limit:
        raise ValueError(
            f"highest is {wanted}; with these samples orders below {limit:.4g} can be resolved (two samples per period)"
        )
    return wanted


def _given(orders: Sequence[int], limit: float) -> list[float]:
    chosen = sorted(positive_count("order", order, HIGHEST) for order in orders)
    if not chosen or len(set(chosen)) < len(chosen):
        raise ValueError(f"orders are {shown(orders)}; give at least one, and none twice")
    if not chosen[-1] < limit:
        raise ValueError(f"order {chosen[-1]} is too high for these samples, which resolve orders below {limit:.4g}")
    return [*chosen]


def _scan(
    runs: Sequence[Run], places: Sequence[float], trials: int, false_alarm: float, noise: str
) -> ErrorScan:  # fmt: skip
    """Lines of one or two directions at these places, whole orders and others between them."""
    highest = max(trials, math.ceil(max(places, default=1)))
    fits = _fits(runs, places, highest)
    sizes, left = [len(run.angle) for run in runs], np.concatenate([fit.residual for fit in fits])
    neighbours = float(np.average([correlation(fit.residual) for fit in fits], weights=sizes))
    coloured = noise == "autocorrelated" or (noise == "auto" and abs(neighbours) > 3.0 / math.sqrt(len(left)))
    white = not (coloured and all(fit.floor.enough for fit in fits))

    spread = [float(fit.residual @ fit.residual) / (len(fit.residual) - len(fit.inverse)) for fit in fits]

    def variances(order: float) -> list[float]:
        noises = spread if white else [fit.floor.variance(order) for fit in fits]
        return [max(variance, fit.least) for variance, fit in zip(noises, fits, strict=True)]

    lines = [
        ScanLine(k, *polar(*_mean(fits, i, variances(k))), _chance(fits, i, k, trials)) for i, k in enumerate(places)
    ]
    whole_orders = [i for i, k in enumerate(places) if k == round(k)]
    reversal = None
    if len(fits) == 2:
        difference = (fits[0].values - fits[1].values)[whole_orders]
        low, high = extremes([places[i] for i in whole_orders], difference.real, -difference.imag)
        error = math.sqrt(sum(v * float(fit.inverse[0, 0]) for v, fit in zip(variances(0), fits, strict=True)))
        reversal = Reversal(float(fits[0].slow[0] - fits[1].slow[0]), error, high - low)
    thresholds = [fit.floor.threshold(false_alarm, trials) for fit in fits]
    drifts = [np.sum(fit.slow[1:]) / run.travel for run, fit in zip(runs, fits, strict=True)]
    return ErrorScan(
        lines=tuple(lines[i] for i in whole_orders), mean=float(np.mean([fit.slow[0] for fit in fits])),
        drift=float(np.mean(drifts)), residual=math.sqrt(float(left @ left) / len(left)), autocorrelation=neighbours,
        noise="white" if white else "autocorrelated",
        threshold=math.sqrt(sum(size**2 for size in thresholds)) / len(fits), samples=len(left),
        turns=min(run.turns for run in runs), reversal=reversal,
        between=tuple(line for i, line in enumerate(lines) if i not in whole_orders),
    )  # fmt: skip


ALIKE_CORRELATION = 0.95  # canonical correlation of two lines above which they are not told apart
MOTOR_ORDERS, OUTPUT_ORDERS = 8, 4  # orders of the motor's turn that a drive has, and of the output's turn beside them
MOST_SAMPLES, MOST_ORDER = 20_000, 400  # beyond which whole orders are not tried: so dense angles tell them
LIKELY_CORRELATION, CHUNK = 0.5, 10_000


def twins(runs: Sequence[Run], orders: Sequence[float], limit: float, two: Clocks | None) -> dict[float, Floats]:
    """By order the other orders of the drive that the angles of all runs do not tell from it."""
    many = max(len(run.angle) for run in runs)
    whole_orders = np.arange(1.0, min(limit, MOST_ORDER) if many <= MOST_SAMPLES else 1.0)
    pairs = [(j, k) for j in range(1, MOTOR_ORDERS + 1) for k in range(-OUTPUT_ORDERS, OUTPUT_ORDERS + 1)]
    candidates = np.unique(np.concatenate([whole_orders, [] if two is None else [two.order(pair) for pair in pairs]]))
    likely = np.min([_likely(run, candidates, np.array(orders)) for run in runs], axis=0)
    aliases = {}
    for order, chances in zip(orders, likely.T, strict=True):
        some = [k for k in candidates[chances > LIKELY_CORRELATION].tolist() if abs(k - order) > 1e-9]
        if alike := [k for k in some if min(_alike(run, order, k) for run in runs) > ALIKE_CORRELATION]:
            aliases[order] = np.array(alike)
    return aliases


def _likely(run: Run, candidates: Floats, orders: Floats) -> Floats:
    """Likeness of candidates (m,) and orders (n,), as an (m, n) array: 1 for aliases over all samples."""
    sums = np.zeros((len(candidates), 2 * len(orders)), complex)
    for i in range(0, len(run.angle), CHUNK):
        angle = run.angle[i : i + CHUNK]
        sums += np.exp(1j * np.outer(candidates, angle)) @ np.exp(1j * np.outer(angle, [*orders, *-orders]))
    return np.asarray(np.max(np.abs(sums).reshape(len(candidates), 2, len(orders)), axis=1) / len(run.angle))


def _alike(run: Run, one: float, other: float) -> float:
    """Largest canonical correlation of the cosine-sine pairs of two orders, mean and drift taken out."""
    bases = []
    for order in (one, other):
        pair = without(run.slow_columns(0.0), np.column_stack(waves_of(run.angle, [order])))
        u, s, _ = np.linalg.svd(pair, full_matrices=False)
        bases.append(u[:, s > 1e-6 * np.sqrt(len(run.angle))])
    return float(np.max(np.linalg.svd(bases[0].T @ bases[1])[1], initial=0.0))
