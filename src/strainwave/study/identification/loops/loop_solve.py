"""Least squares of a loop with noise on both axes: start values, Levenberg-Marquardt, and blocks left out.

The residual of a sample is the distance of the measured torque from the law's at the corrected torsion, weighted by the
noise of both axes through the local slope; the derivatives are taken at the corrected torsion, so that noise of the
torsion does not pull the slopes down (orthogonal distance regression: Boggs, Byrd & Schnabel 1987, SIAM J. Sci. Stat.
Comput. 8(6), 1052-1078).

Scatter of a loop's unknowns: coloured residuals, reversals read with noise, errors that cycles repeat.
"""

import math
from itertools import combinations
from typing import NamedTuple

import numpy as np

from ....base.results import Floats
from ..intervals import Spread, restricted
from .loop_model import FULL_STATE, Shape, torque
from .loop_path import Loop

MOST_STEPS = 60
SMALL_GAIN = 1e-8  # of the cost, from which on a step is the last
BLOCKS = 12
START_SAMPLES = 400  # samples of a start
TWISTS = (0.01, 0.03, 0.1, 0.3)  # of the largest torsion: yield twists tried at a start
CORNERS = (0.08, 0.15, 0.25, 0.35, 0.5, 0.65, 0.8)  # of the largest torsion: x1 and x2 tried at a start
BOUNDS = {"half_gap": (0.0, math.inf), "kappa": (0.0, 20.0)}
WIDEST_FACTOR = 1e6  # times the loop's own slope or reach, or that part of it: stiffnesses and torsions of a law

BINS = 24  # of the torsion's range, over which residuals of two cycles are compared
BEGIN_GAP = 0.02  # of the range: branches that begin as close together do the same
SURE_DEVIATIONS = 2.0  # standard deviations from which on a correlation is one
# first left out of dependent columns, after the states at the starts
WEAKEST_FIRST = ("kappa", "torsion_offset", "half_gap", "yield_twist", "K", "x2", "x1", "K2")
UNTOLD_FACTOR = 1e3  # times its value: standard deviation of an unknown that was left out
RANK = 1e-9
BOUND_FREEDOM = 1e6  # degrees of freedom of what stands at a bound


class Solution(NamedTuple):
    """A candidate: unknowns p (p,), weighted residual (n,) and Jacobian (n, p) at torsions, and corrected torsions.

    The corrected ones, `nearest`, are on the law's curve, nearest to the samples in units of the noise of both axes.
    """

    shape: Shape
    p: Floats
    residual: Floats
    jacobian: Floats
    torsion: Floats
    weight: Floats
    nearest: Floats

    @property
    def cost(self) -> float:
        """Sum of the squared weighted residuals."""
        return float(self.residual @ self.residual)


def linearise(
    loop: Loop, shape: Shape, p: Floats, torsions: Floats | None = None, names: tuple[str, ...] | None = None
) -> Solution:
    """Residual and Jacobian, over all unknowns or those named, at the measured torsions or others."""
    torsions = loop.torsion if torsions is None else torsions
    model = torque(shape, p, loop.path, torsions, names)
    variance = loop.torque_noise**2 + (model.slope * loop.torsion_noise) ** 2
    weight = 1.0 / np.sqrt(np.maximum(variance, 1e-30 * float(np.ptp(loop.torque)) ** 2))
    miss = loop.torque - model.value - model.slope * (loop.torsion - torsions)
    nearest = np.asarray(loop.torsion + model.slope * loop.torsion_noise**2 * weight**2 * miss)
    return Solution(shape, p, weight * miss, weight[:, None] * model.jacobian, torsions, weight, nearest)


def solve(loop: Loop, shape: Shape, p: Floats) -> Solution:
    """Fit a candidate from start values (p,)."""
    solution = linearise(loop, shape, _inside(loop, shape, p))
    damping = 1e-3
    for _ in range(MOST_STEPS):
        scale = np.sqrt(np.sum(solution.jacobian**2, axis=0)) + 1e-300
        J = solution.jacobian / scale
        gradient = J.T @ solution.residual
        held = np.isin(shape.names(), ["half_gap", "kappa"]) & (solution.p == 0.0)  # at a bound that it would leave
        J = J * ~(held & (gradient < 0.0))
        gram, gradient = J.T @ J, J.T @ solution.residual
        for _ in range(12):
            step = np.linalg.solve(gram + damping * np.eye(len(p)), gradient) / scale
            tried = linearise(loop, shape, _inside(loop, shape, solution.p + step), solution.torsion, ())
            if tried.cost <= solution.cost:
                break
            damping = max(damping * 8.0, 1e-12)
        else:
            break
        gain = solution.cost - tried.cost
        damping = max(0.1 * damping, 1e-13)  # the least that rounding leaves of it beside 1
        solution = linearise(loop, shape, tried.p, tried.nearest)
        if gain <= SMALL_GAIN * solution.cost:
            break
    return solution


def _inside(loop: Loop, shape: Shape, p: Floats) -> Floats:
    """Unknowns moved to where the law is one."""
    names, wide = shape.names(), float(np.ptp(loop.torsion))
    scales = dict.fromkeys(("x1", "x2", "yield_twist"), wide)
    scales |= dict.fromkeys(("K1", "K2", "K3", "K"), float(np.ptp(loop.torque)) / wide)
    bounds = BOUNDS | dict.fromkeys(shape.starts(), (-FULL_STATE, FULL_STATE))
    bounds |= {name: (scale / WIDEST_FACTOR, scale * WIDEST_FACTOR) for name, scale in scales.items()}
    p = np.clip(p, *np.array([bounds.get(name, (-math.inf, math.inf)) for name in names]).T)
    if "x2" in names:
        p[names.index("x2")] = max(p[names.index("x2")], 1.001 * p[names.index("x1")])
    return p


def start_values(loop: Loop, shape: Shape) -> Floats:
    """Start values (p,): the best of a grid of corners, yield twists and offsets, slopes by linear least squares."""
    take = np.unique(np.linspace(0, len(loop.torsion) - 1, START_SAMPLES).astype(int))
    x, t = loop.torsion[take], loop.torque[take]
    path = loop.path._replace(branch=loop.path.branch[take])
    names = shape.names()
    linear = [i for i, name in enumerate(names) if name in ("K1", "K2", "K3", "K", "torque_offset")]
    solved = tuple(names[i] for i in linear)
    middle = 0.5 * float(np.max(x) + np.min(x))
    reach = 0.5 * float(np.ptp(x))
    corners: list[tuple[float, ...]] = list(combinations(CORNERS, shape.slopes - 1))
    best, least = np.zeros(len(names)), math.inf
    for offset in dict.fromkeys((0.0, middle)):
        for corner in corners:
            for twist in TWISTS if shape.n else (0.1,):
                tried = {f"x{i}": share * reach for i, share in enumerate(corner, 1)}
                tried |= {"half_gap": 0.02 * reach, "yield_twist": twist * reach, "kappa": 0.1}
                tried |= {"torsion_offset": offset} | dict.fromkeys(shape.starts(), 0.0)
                p = np.array([tried.get(name, 1.0) for name in names])
                columns = torque(shape, p, path, x, solved).jacobian
                values, *_ = np.linalg.lstsq(columns, t, rcond=None)
                p[linear] = values
                miss = t - columns @ values
                cost = float(miss @ miss)
                if cost < least and np.all(values[:-1] > 0.0):
                    best, least = p, cost
    if not math.isfinite(least):
        slope = float(np.polyfit(x, t, 1)[0])
        best = p
        best[linear] = slope
        best[names.index("torque_offset")] = float(np.mean(t - slope * x))
        if shape.n:
            best[names.index("K")] = 0.1 * slope
    return best


def left_out(loop: Loop, solution: Solution) -> Floats:
    """Mean squared weighted error (blocks,) of the samples of each block under the fit to the others.

    The fit to the others is one step of Gauss and Newton from the fit to all, exact where the law is linear.
    """
    # a start is told by the first samples alone: it is no part of what is predicted
    keep = ~np.isin(solution.shape.names(), solution.shape.starts())
    J, r = solution.jacobian * keep, solution.residual
    scale = np.sqrt(np.sum(J**2, axis=0)) + 1e-300
    J = J / scale
    gram = J.T @ J
    errors = []
    for block in np.array_split(np.arange(len(r)), BLOCKS):
        rows = J[block]
        others = gram - rows.T @ rows + 1e-12 * np.eye(gram.shape[0])
        p = _inside(loop, solution.shape, solution.p - np.linalg.solve(others, rows.T @ r[block]) / scale)
        miss = linearise(loop, solution.shape, p, solution.torsion, ()).residual[block]
        errors.append(float(np.mean(miss**2)))
    return np.array(errors)


def scatter(loop: Loop, fit: Solution) -> Spread:
    """Scatter of the unknowns of a fit; 0 for those that stand at a bound."""
    free = np.sum(fit.jacobian**2, axis=0) > 0.0
    free &= ~np.isin(fit.shape.names(), ["half_gap", "kappa"]) | (fit.p > 0.0)
    bound, names = ~free, np.array(fit.shape.names())
    for name in (*fit.shape.starts(), *WEAKEST_FIRST):  # left out as long as the samples do not tell the others apart
        J = fit.jacobian[:, free]
        sizes = np.linalg.svd(J / np.linalg.norm(J, axis=0), compute_uv=False)
        if not sizes[-1] > RANK * sizes[0]:
            free &= names != name
    J = fit.jacobian[:, free]
    spread = restricted(J, fit.residual)
    moved = np.linalg.solve(J.T @ J, shifts_of_begins(loop, fit, J))
    covariance = spread.covariance * repetition(loop, fit.residual) + moved @ moved.T
    full, freedom = np.zeros((len(free), len(free))), BOUND_FREEDOM * np.ones(len(free))
    full[np.diag_indices(len(free))] = np.where(bound, 0.0, (UNTOLD_FACTOR * fit.p) ** 2)
    full[np.ix_(free, free)], freedom[free] = covariance, spread.freedom
    return Spread(full, freedom, spread.whitener)


def shifts_of_begins(loop: Loop, fit: Solution, J: Floats) -> Floats:
    """Products (p, branches) of columns (n, p) with what a standard deviation of each reversal changes."""
    if not fit.shape.n or loop.torsion_noise == 0.0:
        return np.zeros((J.shape[1], 1))
    p = fit.p.copy()
    spring = fit.shape._replace(n=0, free_beta=False)
    kept = [fit.shape.names().index(name) for name in spring.names()]
    slope = torque(fit.shape, p, loop.path, fit.torsion).slope
    shift = fit.weight * (slope - torque(spring, p[kept], loop.path, fit.torsion).slope)
    pulls = np.array(
        [J[mine].T @ shift[mine] for mine in (loop.path.branch == j for j in range(1, len(loop.path.begin)))]
    )
    read = ~np.isin(np.arange(1, len(loop.path.begin)), loop.path.first)
    return np.asarray(pulls.T * loop.begin_noise[1:] * read)


def repetition(loop: Loop, residual: Floats) -> float:
    """Factor (at least 1) by which the variance grows because cycles of one amplitude repeat their residuals."""
    path, low, wide = loop.path, float(np.min(loop.torsion)), float(np.ptp(loop.torsion))
    bins = np.minimum((BINS * (loop.torsion - low) / wide).astype(int), BINS - 1)
    means = np.full((len(path.begin), BINS), np.nan)
    later = [j for j in range(len(means)) if j not in path.first]
    for j in later:
        mine = path.branch == j
        count = np.bincount(bins[mine], minlength=BINS)
        sums = np.bincount(bins[mine], residual[mine], minlength=BINS)
        means[j, count > 0] = sums[count > 0] / count[count > 0]
    products, squares, pairs, alike = 0.0, 0.0, 0, np.ones(len(means))
    for j in later:
        for k in later[later.index(j) + 1 :]:
            close = abs(path.begin[j] - path.begin[k]) < BEGIN_GAP * wide
            both = np.isfinite(means[j]) & np.isfinite(means[k])
            if path.direction[j] == path.direction[k] and close and np.any(both):
                a, b = means[j, both], means[k, both]
                products, squares = products + float(a @ b), squares + 0.5 * float(a @ a + b @ b)
                pairs += int(np.count_nonzero(both))
                alike[j] += 1.0
                alike[k] += 1.0
    if squares == 0.0:
        return 1.0
    same = products / squares
    return 1.0 + same * float(np.mean(alike[later]) - 1.0) if same > SURE_DEVIATIONS / math.sqrt(pairs) else 1.0
