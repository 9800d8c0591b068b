"""Amplitudes of orders in runs at several speeds: each run for itself, then all with one delay.

A line is A cos(k theta(t - delay) + phase), the real part of c exp(i k theta(t - delay)), c = A exp(i phase). In a run
at the speed w a delay that is d longer turns c by exp(-i k w d).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ....base.results import Floats
from ..run import Run
from .line_noise import CLOSE, Floor, noise_floor

SLOW = 12  # waves over the travel, at most, that friction and drift along it may have
LONGEST = 0.02  # s: the largest delay that is looked for
FINE = 0.3  # rad: of the fastest change of phase between two delays that are tried
ROUNDS = 4
SAME_SPEED = 0.02  # relative difference of two speeds that counts as none
WORST = 1e3  # condition of the columns of a run


@dataclass(frozen=True)
class RunFit:
    """Lines of one run.

    Attributes
    ----------
    values : (lines,) complex array
        c of each line.
    spreads : (lines, 2, 2) array
        Covariance of its real and imaginary parts.
    residual : (n,) array
        What is left.
    without_orders : (n,) array
        The value less the lines of the orders alone.
    floor : Floor
        Noise around the orders.
    """

    values: Floats
    spreads: Floats
    residual: Floats
    without_orders: Floats
    floor: Floor


def slow_columns(run: Run, lowest: float) -> Floats:
    """Columns (n, m): mean, drift and slow waves along the travel, all slower than half of the lowest order."""
    s = (run.angle - run.angle[0]) / run.travel
    many = int(np.clip(0.5 * lowest * run.turns, 0, SLOW))
    waves = [np.cos(np.pi * m * s) for m in range(2, many + 1)]
    return np.column_stack([np.ones_like(s), s - 0.5, *waves])


def without(columns: Floats, values: Floats) -> Floats:
    """Values less what the columns say of them."""
    basis = np.linalg.qr(columns)[0]
    return np.asarray(values - basis @ (basis.T @ values))


def fit_run(
    run: Run, orders: Sequence[float], delay: float, highest: float, frequencies: Sequence[float] = (),
    loose: Sequence[int] = (),
) -> RunFit:  # fmt: skip
    """Lines of these orders in one run beside lines of these frequencies [Hz], and the noise around them.

    The `loose` ones have places from the run: their spreads hold what these may be off by.
    """
    theta = run.angle_before(delay)
    waves = [part for k in orders for part in (np.cos(k * theta), -np.sin(k * theta))]
    slow = slow_columns(run, min(orders, default=highest))
    turns = [2.0 * np.pi * f * (run.time - run.time[0]) for f in frequencies]
    nuisances = np.column_stack([slow, *(wave(x) for x in turns for wave in (np.cos, np.sin))])
    columns = np.column_stack([nuisances, *waves])
    u, s, vt = np.linalg.svd(columns / np.linalg.norm(columns, axis=0), full_matrices=False)
    if s[0] > WORST * s[-1]:
        raise ValueError(
            f"a run over {run.turns:.3g} turns does not tell the orders {', '.join(f'{k:g}' for k in orders)} apart; "
            "take longer runs, or orders further apart"
        )
    back = (vt.T / s) / np.linalg.norm(columns, axis=0)[:, None]
    shares = back @ (u.T @ run.value)
    residual = run.value - columns @ shares
    ascending = np.sign(run.travel) * run.angle
    standing = [2.0 * np.pi * f / abs(run.speed) for f in frequencies]
    taken = _taken(run, [*orders, *standing], slow.shape[1], highest)
    floor = noise_floor([(ascending, residual)], int(np.ceil(highest)), taken, 0.0)
    inverse, least, first = back @ back.T, rounding(run.value), nuisances.shape[1]
    if loose:
        inverse = _with_places(columns, shares, theta, [first + 2 * i for i in loose])
    values, spreads = [], []
    for i, k in enumerate(orders):
        place = slice(first + 2 * i, first + 2 * i + 2)
        values.append(complex(*shares[place]))
        spreads.append(max(floor.variance(k), least) * inverse[place, place])
    rest = run.value - columns[:, first:] @ shares[first:]
    return RunFit(np.array(values), np.array(spreads).reshape(len(values), 2, 2), residual, rest, floor)


def _with_places(columns: Floats, shares: Floats, theta: Floats, begin: Sequence[int]) -> Floats:
    """Inverse normal matrix of the columns beside the derivatives by the orders of lines that begin at some."""
    moved = [theta * (shares[i] * columns[:, i + 1] - shares[i + 1] * columns[:, i]) for i in begin]
    every = np.column_stack([columns, *moved])
    sizes, many = np.linalg.norm(every, axis=0), columns.shape[1]
    inverse = np.linalg.pinv((every / sizes).T @ (every / sizes)) / np.outer(sizes, sizes)
    return np.asarray(inverse[:many, :many])


def _taken(run: Run, orders: Sequence[float], slow: int, highest: float) -> list[float]:
    """Independent orders near which fitted lines, or so many slow columns, leave less than the noise."""
    spacing = (1.0 - 1.0 / len(run.time)) / run.turns
    grid = spacing * np.arange(1, int(1.5 * highest / spacing) + int(0.5 * slow + CLOSE) + 2)
    near = np.min([np.abs(grid - k) for k in (*orders, np.inf)], axis=0) <= CLOSE * spacing
    return [*orders, *grid[near | (grid <= (0.5 * slow + CLOSE) * spacing)]]


def rounding(values: Floats) -> float:
    """Variance of rounding to steps, the smallest difference of two values being one."""
    distinct = np.unique(values)
    step = float(np.min(np.diff(distinct), initial=np.inf)) if len(distinct) > 1 else 0.0
    return (step if np.isfinite(step) else 0.0) ** 2 / 12.0


@dataclass(frozen=True)
class Joint:
    """Lines of all runs with one delay.

    Attributes
    ----------
    values : (lines,) complex array
        c of each line.
    covariance : (2 lines + 1, 2 lines + 1) array
        Of real and imaginary parts, line by line, and last the delay [s].
    delay : float
        [s].
    misfit : float
        Sum of the squares of what single runs differ by, in deviations.
    freedom : int
        How many numbers are behind it.
    """

    values: Floats
    covariance: Floats
    delay: float
    misfit: float
    freedom: int


def together(orders: Floats, speeds: Floats, fits: Sequence[RunFit], delay: float, *, delayed: bool) -> Joint:
    """Lines and the delay behind the lines of several runs, which were fitted with a first delay [s].

    Parameters
    ----------
    orders : (lines,) array
        Orders.
    speeds : (runs,) array
        Mean speeds [rad/s].
    fits : sequence of RunFit
        Of the runs.
    delay : float
        With which they were fitted.
    delayed : bool
        Whether more or less delay is looked for.
    """
    values = np.array([fit.values for fit in fits])  # (runs, lines)
    roots = np.array([[_root(spread) for spread in fit.spreads] for fit in fits])  # (runs, lines, 2, 2)
    d = _delay(orders, speeds, values, roots) if delayed else 0.0
    for _ in range(20):
        jacobian, residual, means = _linear(orders, speeds, values, roots, d, delayed)
        change = np.linalg.lstsq(jacobian, residual, rcond=None)[0]
        if delayed:
            d += float(change[-1])
        if not delayed or abs(change[-1]) < 1e-12 + 1e-6 * abs(d):
            break
    jacobian, residual, means = _linear(orders, speeds, values, roots, d, delayed)
    lines = 2 * len(orders)
    covariance = np.full((lines + 1, lines + 1), np.inf)
    covariance[: jacobian.shape[1], : jacobian.shape[1]] = np.linalg.pinv(jacobian.T @ jacobian)
    return Joint(means, covariance, delay + d, float(residual @ residual), len(residual) - jacobian.shape[1])


def _root(spread: Floats) -> Floats:
    """Matrix that turns a deviation with this covariance into one of unit size."""
    return np.asarray(np.linalg.inv(np.linalg.cholesky(spread)))


def _weighted(roots: Floats, c: Any) -> Floats:
    """Real and imaginary parts (runs, lines, 2) of numbers (runs, lines), in deviations."""
    return np.asarray(np.einsum("rijk,rik->rij", roots, np.stack([c.real, c.imag], axis=-1)))


def _linear(
    orders: Floats, speeds: Floats, values: Floats, roots: Floats, d: float, delayed: bool
) -> tuple[Floats, Floats, Floats]:  # fmt: skip
    """Derivatives by (lines, delay) and differences, in deviations, at the nearest lines of a delay."""
    (runs, lines), turn = values.shape, np.exp(-1j * orders * speeds[:, None] * d)
    own = np.stack([_weighted(roots, turn), _weighted(roots, 1j * turn)], axis=-1)
    wanted, jacobian = _weighted(roots, values), np.zeros((runs, lines, 2, 2 * lines + delayed))
    means = np.empty(lines, complex)
    for i in range(lines):
        jacobian[:, i, :, 2 * i : 2 * i + 2] = own[:, i]
        means[i] = complex(*np.linalg.lstsq(own[:, i].reshape(-1, 2), wanted[:, i].ravel(), rcond=None)[0])
    if delayed:
        jacobian[..., -1] = _weighted(roots, -1j * orders * speeds[:, None] * turn * means)
    return jacobian.reshape(2 * runs * lines, -1), _weighted(roots, values - means * turn).ravel(), means


def _delay(orders: Floats, speeds: Floats, values: Floats, roots: Floats) -> float:
    """The longer delay [s] with the smallest differences, among many."""
    weights = np.array([[np.linalg.norm(root) ** 2 / 2.0 for root in row] for row in roots])
    fastest = float(np.max(np.abs(np.subtract.outer(speeds, speeds)))) * float(np.max(orders))
    tried = np.linspace(-LONGEST, LONGEST, 2 * int(min(LONGEST * fastest / FINE, 5000)) + 3)
    turned = values[None] * np.exp(1j * tried[:, None, None] * orders[None, None] * speeds[None, :, None])
    total = np.sum(np.abs(np.sum(weights * turned, axis=1)) ** 2 / np.sum(weights, axis=0), axis=1)
    return float(tried[np.argmax(total)])
