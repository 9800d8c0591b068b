"""Stability of the orbits of a second-order balance problem.

A disturbance y of u obeys J y'' + B y' + T'(u(t)) y = 0. With y = exp(-B t/(2J)) z this is Hill's equation z'' + q z
= 0, which Numerov's fourth-order rule turns into w_{n+1} = t_n w_n - w_{n-1}. The period map of that recurrence has
determinant 1, so Liouville's formula (the product of the multipliers is exp(-B period/J)) holds exactly and the trace
tells everything.

Nayfeh & Mook 1979, sec. 5.2 (Hill's equation, Floquet theory); Hairer, Norsett & Wanner I, sec. III.10 (Numerov).
"""

import math
from typing import Any

import numpy as np

from ...base.law import breakpoints_of
from ...base.protocols import Balance
from ...base.results import Booleans, Complexes, Floats
from ...compile.address import ByAddress
from ...compile.jit import borrowed, kernel_as, run
from ...compile.tree import with_leaf
from ..addressed import varied
from ..balance.condensed.disturbances import Disturbances
from ..balance.fourier import all_orders, synthesis
from ..balance.linear_algebra import row_times
from ..balance.rates import base_speed
from ..balance.second_order import SecondOrder
from ..balance.springs import of_law
from .panel_map import FEW_RUNS, maps_through_panels, resolved

PER_VIBRATION, MOST_STEPS = 16, 200_000  # Numerov steps a free vibration, and of an orbit
FROZEN, LARGEST_LOG = 4096, 700.0  # instants of a very slow orbit, and the logarithm of the largest multiplier told


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
    speeds = base_speed(problem, points[:, -1])
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
    has_kinks = len(points) and problem.springs.is_sampled() and breakpoints_of(problem.system.law)
    equations = _between_kinks(problem, points) if has_kinks else []
    if equations and all(map(resolved, equations)):
        with np.errstate(all="ignore"):
            total = np.trace(np.concatenate(list(map(maps_through_panels, equations))), axis1=1, axis2=2)
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
    """Disturbances along orbits of a sampled law with breakpoints, for panels that end there.

    Numerov's steps pass the breakpoints, which leaves errors of a tenth in a multiplier. Orbits of different speeds
    have one equation, those of another parameter one each: every one is of a drive of its own.
    """
    groups = [points] if problem.leaf == problem.omega_leaf else list(points[:, None])
    return [_equation(problem, group) for group in groups]


def _equation(problem: Any, points: Floats) -> Disturbances:
    """The variational equation J y'' + B y' + T'(u) y = 0 of orbits of one drive, in y and y'."""
    system = with_leaf(problem.system, problem.leaf, float(points[0, -1]))
    J, B, law = system.J, system.B, system.law
    stiff = law.stiffness(points[:, :-1] @ problem.synthesis)
    mean, half = float(np.mean(stiff)), 0.5 * B / J
    rates = [abs(half + np.sqrt(half * half - k / J + 0j)) for k in (mean, np.min(stiff), np.max(stiff))]
    a, b, c = np.array([[0.0, 1.0], [-mean / J, -2.0 * half]]), np.array([[0.0], [1.0 / J]]), np.array([[1.0, 0.0]])
    twists = all_orders(points[:, :-1], problem.stride)[:, None]
    speed = orbit_scales(problem, points[:, -1])[0] / problem.turns
    return Disturbances((law,), a, b, c, np.array([mean]), max(rates), twists, speed)


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
