"""Orders of a drive that the angles of a scan do not tell apart."""

from collections.abc import Sequence

import numpy as np

from ....base.results import Floats
from ..intervals import without
from ..run import Run
from .beats import Clocks
from .order_fit import waves_of

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
