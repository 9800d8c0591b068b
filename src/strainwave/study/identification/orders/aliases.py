"""Orders of a drive that the angles of a scan do not tell apart, and lines between whole orders."""

from collections.abc import Sequence

import numpy as np
from scipy.optimize import minimize_scalar

from ....base.results import Floats
from .beats import Clocks
from .error_result import Direction, fit_lines
from .order_fit import noise_floor, power, probability

TOLD = 0.95  # canonical correlation of two lines above which they are not told apart
MOTOR, OUTPUT = 8, 4  # orders of the motor's turn that a drive has, and of the output's turn beside them
MOST_SAMPLES, WIDEST = 20_000, 400  # beyond which whole orders are not tried: so dense angles tell them
LIKELY, CHUNK = 0.5, 10_000
MOST_BETWEEN = 4


def twins(runs: Sequence[Direction], orders: Sequence[float], limit: float, two: Clocks | None) -> dict[float, Floats]:
    """By order the other orders of the drive that the angles of all runs do not tell from it."""
    many = max(len(run.angle) for run in runs)
    whole = np.arange(1.0, min(limit, WIDEST) if many <= MOST_SAMPLES else 1.0)
    pairs = [(j, k) for j in range(1, MOTOR + 1) for k in range(-OUTPUT, OUTPUT + 1)]
    candidates = np.unique(np.concatenate([whole, [] if two is None else [two.order(pair) for pair in pairs]]))
    likely = np.min([_likely(run, candidates, np.array(orders)) for run in runs], axis=0)
    found = {}
    for order, near in zip(orders, likely.T, strict=True):
        some = [k for k in candidates[near > LIKELY].tolist() if abs(k - order) > 1e-9]
        if alike := [k for k in some if min(_alike(run, order, k) for run in runs) > TOLD]:
            found[order] = np.array(alike)
    return found


def _likely(run: Direction, candidates: Floats, orders: Floats) -> Floats:
    """How alike candidates (m,) and orders (n,) are, as an (m, n) array: 1 for aliases over all samples."""
    sums = np.zeros((len(candidates), 2 * len(orders)), complex)
    for i in range(0, len(run.angle), CHUNK):
        angle = run.angle[i : i + CHUNK]
        sums += np.exp(1j * np.outer(candidates, angle)) @ np.exp(1j * np.outer(angle, [*orders, *-orders]))
    return np.asarray(np.max(np.abs(sums).reshape(len(candidates), 2, -1), axis=1) / len(run.angle))


def _alike(run: Direction, one: float, other: float) -> float:
    """Largest canonical correlation of the cosine-sine pairs of two orders, mean and drift taken out."""
    trend = np.linalg.qr(np.column_stack([np.ones_like(run.angle), run.angle - np.mean(run.angle)]))[0]
    bases = []
    for order in (one, other):
        pair = np.column_stack([np.cos(order * run.angle), np.sin(order * run.angle)])
        u, s, _ = np.linalg.svd(pair - trend @ (trend.T @ pair), full_matrices=False)
        bases.append(u[:, s > 1e-6 * np.sqrt(len(run.angle))])
    return float(np.max(np.linalg.svd(bases[0].T @ bases[1])[1], initial=0.0))


def between(
    runs: Sequence[Direction], drift: bool, chosen: Sequence[int], highest: int, false_alarm: float, least: float
) -> list[float]:  # fmt: skip
    """Orders of lines between whole ones, beside those chosen, that noise has with less than a probability."""
    turns, found = min(run.turns for run in runs), list[float]()
    spacing = 0.25 / turns
    places = spacing * np.arange(1, int(highest / spacing) + 1)
    apart = (np.abs(places - np.round(places)) > 2.0 * spacing) & (places > 1.0)
    while len(found) < MOST_BETWEEN and np.any(apart):
        taken = [*chosen, *found]
        left = [fit_lines(run, taken, drift).left for run in runs]
        powers = np.where(apart, power(left, spacing, len(places)), 0.0)
        place = float(places[np.argmax(powers)])
        mean, freedom = noise_floor(left, highest, taken, least).estimates(place)
        if probability(float(np.max(powers) / mean[0]), float(freedom[0]), len(places)) >= false_alarm:
            break

        def remainder(order: float, taken: Sequence[float] = taken) -> float:
            return sum(float(np.sum(fit_lines(run, [*taken, order], drift).left.error ** 2)) for run in runs)

        found.append(float(minimize_scalar(remainder, bounds=(place - spacing, place + spacing), method="bounded").x))
        apart &= np.abs(places - found[-1]) > 4.0 * spacing
    return found
