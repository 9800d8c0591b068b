"""Stability of the orbits of a second-order balance problem.

A disturbance y of u obeys J y'' + B y' + T'(u(t)) y = 0. With y = exp(-B t/(2J)) z this is Hill's equation z'' + q z
= 0, which Numerov's fourth-order rule turns into w_{n+1} = t_n w_n - w_{n-1}. The period map of that recurrence has
determinant 1, so Liouville's formula (the product of the multipliers is exp(-B period/J)) holds exactly and the trace
tells everything.

Nayfeh & Mook 1979, sec. 5.2 (Hill's equation, Floquet theory); Hairer, Norsett & Wanner I, sec. III.10 (Numerov).

Period doublings and branch points of a curve of periodic orbits, located between its points.
"""

import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np

from ...base.law import breakpoints_of
from ...base.protocols import BRANCH_POINT, DOUBLING, FOLD, Balance
from ...base.results import Booleans, Complexes, Floats, Integers, SolveError
from ...compile.address import ByAddress
from ...compile.jit import borrowed, kernel_as, run
from ...compile.tree import with_leaf
from ..addressed import varied
from ..balance.condensed.disturbances import Disturbances
from ..balance.first_order import linearised, newton
from ..balance.fourier import all_orders, synthesis
from ..balance.linear_algebra import row_times
from ..balance.rates import base_speed
from ..balance.second_order import SecondOrder
from ..balance.springs import of_law
from ..operating_point import bracketed_root
from .panel_map import FEW_RUNS, maps_through_panels, resolved

PER_VIBRATION, MOST_STEPS = 16, 200_000  # Numerov steps a free vibration, and of an orbit
FROZEN, LARGEST_LOG = 4096, 700.0  # instants of a very slow orbit, and the logarithm of the largest multiplier told

FINER, MOST_FINER = 4, 2048  # Numerov steps: four times those along a branch (256 times less error), or enough
NOISE = 1e-7  # of the products: below this a multiplier sits at 1 for good (as inside a gap)
ONE_PLACE = 1e-9  # relative distance of the parameter at a fold and at a branch point that are one


def _stability_loops(problem: Any, table: Floats, points: Floats, traces: Floats) -> None:
    problem, table, points = borrowed(problem), borrowed(table), borrowed(points)
    n, steps = table.shape
    u, q = np.empty(steps), np.empty(steps)
    for p in range(points.shape[0]):
        system = varied(problem.system, problem.leaf, points[p, n])
        row_times(points[p], table, u)
        traces[p] = of_law(problem.springs, system.law).hill(
            system.J, system.B, system.omega / problem.turns, points[p], u, q
        )


@kernel_as(_stability_loops)
def stability(problem: Any, table: Floats, points: Floats, traces: Floats) -> None:
    """Write the trace of Hill's period map of every point (coefficients in blocks, parameter last).

    `table` is the synthesis table of the Numerov grid.
    """
    n = len(table)
    if not problem.springs.is_sampled():
        for p, point in enumerate(points):
            system = with_leaf(problem.system, problem.leaf, float(point[n]))
            u, w = point[:n] @ table, system.omega / problem.turns
            traces[p] = of_law(problem.springs, system.law).hill(system.J, system.B, w, point, u, np.empty(0))
    else:
        traces[:] = _numerov(problem, points, table)


def _numerov(problem: Any, points: Floats, table: Floats) -> Floats:
    """`Sampling.hill_trace` for all points at once."""
    n, steps = table.shape
    spacing = 2.0 * math.pi / (problem.stride * steps)
    system = with_leaf(problem.system, problem.leaf, points[:, n, None])
    q = system.law.stiffness(points[:, :n] @ table) + np.zeros((len(points), steps))
    mu = system.B / system.J
    q = 12.0 / (1.0 + (spacing * problem.turns / system.omega) ** 2 / 12.0 * (q / system.J - 0.25 * mu * mu)) - 10.0
    w0, w1, v0, v1 = np.ones(len(points)), np.zeros(len(points)), np.zeros(len(points)), np.ones(len(points))
    for i in range(steps):
        w0, w1 = q[:, i] * w0 - w1, w0
        v0, v1 = q[:, i] * v0 - v1, v0
    trace = w0 + v1
    return trace if problem.stride == 1 else trace * trace - 2.0


def steps_for(problem: SecondOrder, points: Floats) -> int:
    """Numerov steps per orbit that resolve every harmonic of the problem, and the free vibration at the slowest point.

    Numerov's rule is unstable beyond sqrt(6) radians of free vibration a step: slow orbits need more steps than their
    harmonics ask for.
    """
    steps = max(128, 8 * problem.stride * problem.size())
    if not (problem.springs.is_sampled() and len(points)):
        return steps
    speeds = orbit_scales(problem, points[:, -1])[0]
    slowest = int(np.argmin(speeds))
    system = with_leaf(problem.system, problem.leaf, float(points[slowest, -1]))
    u = points[slowest, :-1] @ grid_of(problem, 32 * problem.stride)
    rates = np.abs(system.law.stiffness(u) / system.J - 0.25 * (system.B / system.J) ** 2) + 0.0 * u
    rate = np.max(rates, where=np.isfinite(rates), initial=0.0)  # beside the curve a law may have no value
    vibrations = math.sqrt(rate) * problem.turns / float(speeds[slowest])
    return max(steps, problem.stride * math.ceil(min(PER_VIBRATION * vibrations, MOST_STEPS)))


def grid_of(problem: SecondOrder, steps: int) -> Floats:
    """Synthesis table of a grid with so many steps per orbit."""
    return synthesis(problem.harmonics(), steps // problem.stride, problem.stride)


def multipliers(traces: Floats, decay: Floats) -> Complexes:
    """Floquet multipliers (points, 2), largest modulus first, from Hill's traces and exp(-B period/(2J))."""
    half = 0.5 * np.asarray(traces, float)
    root = np.sqrt(np.abs(half - 1.0)) * np.sqrt(np.abs(half + 1.0))  # the square of half may not fit a float
    real = np.abs(half) >= 1.0  # two real multipliers, else a complex pair
    values = np.empty((*half.shape, 2), complex)
    larger = half + np.where(real, np.copysign(root, half), 0.0)
    values.real[..., 0] = larger
    values.real[..., 1] = np.where(real, 1.0 / np.where(real, larger, 1.0), half)
    values.imag[..., 0] = np.where(real, 0.0, root)
    values.imag[..., 1] = -values.imag[..., 0]
    values *= np.asarray(decay)[..., None]
    return values


def hill(problem: Any, points: Floats, table: Floats | None = None) -> Floats:
    """Traces of Hill's period map of points; `table` is the synthesis table of another grid.

    The trace is NaN where it does not fit a float, or no grid resolves the free vibration: see `frozen`.
    """
    if pieces := _between_kinks(problem, points):
        with np.errstate(all="ignore"):
            total = np.trace(np.concatenate([maps_through_panels(some) for some in pieces]), axis1=1, axis2=2)
            return np.asarray(total / orbit_scales(problem, points[:, -1])[1])
    grid = grid_of(problem, steps_for(problem, points)) if table is None else table
    traces = np.empty(len(points))
    with np.errstate(all="ignore"):
        native = ByAddress(problem, problem.native, "words")
        run(stability, native, grid, np.ascontiguousarray(points), traces, light=problem.light(), after=FEW_RUNS)
    coarse = problem.springs.is_sampled() and problem.stride * grid.shape[1] >= MOST_STEPS
    traces[~np.isfinite(traces) | (coarse and unresolved(problem, points, grid))] = np.nan
    return traces


def _between_kinks(problem: Any, points: Floats) -> list[Disturbances]:
    """Disturbances along orbits of a sampled law with breakpoints, for panels that end there; empty for other laws.

    Numerov's steps pass the breakpoints, which leaves errors of a tenth in a multiplier.
    """
    if not (problem.springs.is_sampled() and breakpoints_of(problem.system.law) and len(points)):
        return []
    if problem.leaf != problem.omega_leaf and len(points) > 1:  # each of a drive of its own
        each = [some for point in points for some in _between_kinks(problem, point[None])]
        return each if len(each) == len(points) else []
    system = with_leaf(problem.system, problem.leaf, float(points[0, -1]))
    J, B, law = system.J, system.B, system.law
    stiff = law.stiffness(points[:, :-1] @ problem.synthesis)
    mean, half = float(np.mean(stiff)), 0.5 * B / J
    rates = [abs(half + np.sqrt(half * half - k / J + 0j)) for k in (mean, np.min(stiff), np.max(stiff))]
    a, b, c = np.array([[0.0, 1.0], [-mean / J, -2.0 * half]]), np.array([[0.0], [1.0 / J]]), np.array([[1.0, 0.0]])
    alone, twists = SimpleNamespace(part=SimpleNamespace(laws=(law,))), all_orders(points[:, :-1], problem.stride)
    speed = orbit_scales(problem, points[:, -1])[0] / problem.turns
    disturbances = Disturbances(alone, a, b, c, np.array([mean]), max(rates), twists[:, None], None, speed)
    return [disturbances] if resolved(disturbances) else []


def unresolved(problem: Any, points: Floats, table: Floats) -> Booleans:
    """True (points,) for a free vibration with fewer than a quarter of the Numerov steps that it is to have."""
    rates = frozen_rates(problem, points)[0]
    fastest = np.max(np.abs(rates.imag), axis=1) * problem.turns / orbit_scales(problem, points[:, -1])[0]
    return np.asarray(fastest * PER_VIBRATION > 4 * problem.stride * table.shape[1])


def frozen_rates(problem: Any, points: Floats) -> Any:
    """Rates [1/s] (points, times) -B/(2J) +- sqrt((B/(2J))^2 - T'(u)/J) at which a disturbance grows."""
    system = with_leaf(problem.system, problem.leaf, points[:, -1:])
    half = 0.5 * system.B / system.J
    q = system.law.stiffness(points[:, :-1] @ grid_of(problem, FROZEN)) / system.J
    with np.errstate(all="ignore"):
        root = np.sqrt(half * half - q + 0j)
        return np.where(half > 0.0, -q / (half + root), root - half), -half - root


def frozen(problem: Balance, points: Floats) -> Complexes:
    """Multipliers (points, 2) of orbits so slow that disturbances follow the rates of the moment (WKB).

    With thousands of free vibrations a period what this leaves out is less than the rounding of the integral.
    """
    period = 2.0 * np.pi * problem.turns / orbit_scales(problem, points[:, -1])[0]
    logs = [np.mean(rate, axis=1) * period for rate in frozen_rates(problem, points)]
    return np.stack([np.exp(np.minimum(log.real, LARGEST_LOG) + 1j * log.imag) for log in logs], axis=1)


def orbit_scales(problem: Balance, values: Floats) -> tuple[Floats, Floats]:
    """Base frequency, and exp(-B period/(2J)), for every value of the parameter."""
    omega, system = base_speed(problem, values), with_leaf(problem.system, problem.leaf, values)
    log = -np.pi * problem.turns * system.B / system.J / omega
    return omega, np.exp(np.minimum(log, 0.5 * LARGEST_LOG))  # its square is the product of the multipliers


def products(traces: Floats, decay: Floats) -> tuple[Floats, Floats]:
    """(1 + m1)(1 + m2) and (1 - m1)(1 - m2) from Hill's traces and exp(-B period/(2J))."""
    total, determinant = traces * decay, decay * decay
    return 1.0 + total + determinant, 1.0 - total + determinant


def with_crossings(problem: Any, points: Floats, labels: Any, traces: Floats, decay: Floats) -> tuple[Floats, Any, int]:
    """Insert the period doublings and branch points between the points of a branch; returns how many there are."""
    doubling, crossing = products(traces, decay)
    crossings: list[tuple[int, int, Floats]] = []
    for i in changes(doubling, points):
        crossings += _located(problem, points, i, DOUBLING)
    for i in changes(crossing, points):
        if _passes_one(crossing, labels, i):
            turns = points[labels == FOLD, -1]  # a fold beside a point on it is no branch point
            crossed = _located(problem, points, i, BRANCH_POINT)
            crossings += [c for c in crossed if np.all(np.abs(turns - c[2][-1]) > ONE_PLACE * abs(c[2][-1]))]
    if not crossings:
        return points, labels, 0
    points, labels, _, _ = inserted(points, labels, crossings)
    return points, labels, len(crossings)


def changes(values: Floats, points: Floats) -> list[int]:
    """Places of points after which a value changes its sign, but for the seam of two arcs at one parameter."""
    across = np.sign(values[1:]) * np.sign(values[:-1]) < 0.0
    return np.flatnonzero(across & (np.diff(points[:, -1]) != 0.0)).tolist()


def inserted(
    points: Floats, labels: Integers, additions: list[tuple[int, int, Floats]]
) -> tuple[Floats, Any, list[int], Floats]:  # fmt: skip
    """Points and labels with new ones (number of the point before, label, point); their places, and they in order."""
    additions = sorted(additions, key=lambda item: (item[0], float(np.linalg.norm(item[2] - points[item[0]]))))
    places, new = [i + 1 for i, _, _ in additions], np.array([point for _, _, point in additions])
    labels = np.insert(labels, places, [label for _, label, _ in additions])
    return np.insert(points, places, new, axis=0), labels, places, new


def _passes_one(crossing: Floats, labels: Integers, i: int) -> bool:
    """True if the sign change between points i and i + 1 is no fold and no rounding."""
    if labels[i] == FOLD or labels[i + 1] == FOLD:
        return False
    for j, neighbour in ((i, i - 1), (i + 1, i + 2)):
        near_fold = 0 <= neighbour < len(labels) and labels[neighbour] == FOLD
        if near_fold and abs(crossing[j]) < 1e-5:
            return False
    return bool(max(abs(crossing[i]), abs(crossing[i + 1])) > NOISE)


def _located(problem: Balance, points: Floats, i: int, label: int) -> list[tuple[int, int, Floats]]:
    """Points between i and i + 1 of a branch at which the product of the label vanishes."""
    table = finer_table(problem, points[i : i + 2])
    point = root_on_chord(problem, points[i], points[i + 1], lambda z: _product(problem, z, table, label))
    return [] if point is None else [(i, label, point)]


def finer_table(problem: Any, points: Floats) -> Floats:
    """Synthesis table of the grid on which multipliers at special points are found."""
    steps = steps_for(problem, points)
    return grid_of(problem, max(steps, min(FINER * steps, MOST_FINER)))


def _product(problem: Any, point: Floats, table: Floats, label: int) -> float:
    traces = hill(problem, point[None, :], table)
    both = products(traces, orbit_scales(problem, point[-1:])[1])
    return float(both[0 if label == DOUBLING else 1][0])


def on_chord(
    problem: Balance, first: Floats, last: Floats, s: float, start: Floats | None = None
) -> Floats | None:  # fmt: skip
    """Solution in the plane across the chord from `first` to `last`, at the fraction s of it.

    Newton's method begins on the chord, or at a point `start` in that plane.
    """
    chord = last - first
    scale = np.full(len(first), 1.0 / max(float(np.linalg.norm(first[:-1])), 1e-300))
    scale[-1] = 1.0 / max(abs(float(first[-1])), abs(float(last[-1])), 1e-100)
    guess = first + s * chord
    point = corrected(problem, guess, chord * scale * scale, scale, start)
    if point is None or np.linalg.norm((point - guess) * scale) > np.linalg.norm(chord * scale):
        return None  # on another branch
    return point


def corrected(
    problem: Balance, guess: Floats, row: Floats, scale: Floats, start: Floats | None = None
) -> Floats | None:  # fmt: skip
    """Solution in the plane through a guess whose normal is `row`; None where Newton's method fails.

    It begins at the guess, or at another `start`.

    As Python, not compiled: a handful of solutions does not pay for another entry into compiled code. At a branch point
    the Jacobian is singular across the branch; there least squares leave that direction alone.
    """
    row = row / np.linalg.norm(row)

    def equations(z: Floats) -> tuple[Floats, Floats]:
        r, matrix, column = linearised(problem, z)
        return np.append(r, row @ z - row @ guess), np.vstack([np.column_stack([matrix, column]), row])

    point = newton(equations, guess if start is None else start, 1.0 / scale, 1e-12)
    if point is None:
        point = newton(equations, guess, 1.0 / scale, 1e-12, solve=lambda a, b: np.linalg.lstsq(a, b, rcond=1e-6)[0])
    return point


def root_on_chord(
    problem: Balance, first: Floats, last: Floats, function: Callable[[Floats], float]
) -> Floats | None:  # fmt: skip
    """Point of a curve between two of its points where a function of the point changes sign; None where it does not."""
    points = {0.0: first, 1.0: last}

    def point_at(s: float) -> Floats:
        if s not in points:
            point = on_chord(problem, first, last, s, _between(points, s))
            if point is None:
                raise SolveError("the chord of two points leaves their curve")
            points[s] = point
        return points[s]

    try:  # at a corner of the law the function may jump: there each bit is one solution more
        return point_at(bracketed_root(lambda s: function(point_at(s)), 0.0, 1.0, xtol=1e-9))
    except (SolveError, ValueError, np.linalg.LinAlgError):
        return None


def _between(points: dict[float, Floats], s: float) -> Floats:
    """Point at the fraction s of a chord on the polynomial through the points known nearest to it, at most four."""
    nearest = sorted(points, key=lambda share: abs(share - s))[:4]
    out = np.zeros_like(points[nearest[0]])
    for share in nearest:
        out += points[share] * math.prod((s - other) / (share - other) for other in nearest if other != share)
    return out
