"""Harmonic balance: the equations that the Fourier coefficients of a periodic orbit satisfy, and their Jacobian.

A problem is a NamedTuple with `residual(z, work, r)` and `linearise(z, work, jacobian, slope)`, where z holds the
coefficients (blocks: mean, cosines, sines) and, last, the parameter that may vary. `SecondOrder` works on the torsion u
alone (velocity eliminated); the nonlinear torque is sampled at 4H+4 points of the common period (alternating
frequency/time).

Krack & Gross 2019, Harmonic Balance for Nonlinear Vibration Problems, secs. 2.2-2.4 (AFT) and 3.2 (Jacobian).
"""

import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ...compile.jit import kernel_as, routine, sampled
from ...results import Floats
from ...tree import with_leaf
from .fourier import analysis, extend, from_blocks, multiply_rows, orders, synthesis, to_blocks
from .linear_algebra import copy, extremes, fill, padded, row_times
from .piecewise import crossings_for, is_piecewise_linear

# In the place of a leaf, at a fixed frequency: the parameter is the logarithm of a factor of all that alternates, or a
# constant torque [N*m] beside that of the excitation; with LINE - k it is added to the factor 1 of line k alone.
STRENGTH, CONSTANT, LINE = -2, -3, -3


@sampled
def law_torque(law: Any, u: Any) -> Any:
    """Torque of the law at every sample."""
    return law.torque(u)


@sampled
def law_stiffness(law: Any, u: Any) -> Any:
    """Stiffness of the law at every sample."""
    return law.stiffness(u)


@sampled
def torque_samples(excitation: Any, angle: Any) -> Any:
    """Torque of the excitation at every angle."""
    return excitation.torque(angle)


@sampled
def error_samples(error: Any, angle: Any) -> Any:
    """Kinematic error at every angle."""
    return error.value(angle)


def _add_linear_loops(J: float, B: float, w: float, stride: int, z: Any, torque: Any, error: Any, r: Any) -> None:
    h = len(r) // 2
    r[0] -= torque[0]
    for k in range(1, h + 1):
        kw = (1 + stride * (k - 1)) * w
        inertia = J * kw * kw
        damping = B * kw
        c, s = z[k], z[h + k]
        r[k] += -inertia * (c + error[k]) + damping * s - torque[k]
        r[h + k] += -inertia * (s + error[h + k]) - damping * c - torque[h + k]


@kernel_as(_add_linear_loops)
def add_linear(J: float, B: float, w: float, stride: int, z: Any, torque: Any, error: Any, r: Any) -> None:
    """Add J u'' + B u' - tau + J e'' in Fourier coefficients."""
    h = len(r) // 2
    kw = w * orders(h, stride)
    inertia, damping = J * kw * kw, B * kw
    c, s = z[1 : h + 1], z[h + 1 : 2 * h + 1]
    r -= torque
    r[1 : h + 1] += damping * s - inertia * (c + error[1 : h + 1])
    r[h + 1 :] -= damping * c + inertia * (s + error[h + 1 :])


def _add_linear_jacobian_loops(J: float, B: float, w: float, stride: int, h: int, out: Any) -> None:
    for k in range(1, h + 1):
        kw = (1 + stride * (k - 1)) * w
        out[k, k] -= J * kw * kw
        out[h + k, h + k] -= J * kw * kw
        out[k, h + k] += B * kw
        out[h + k, k] -= B * kw


@kernel_as(_add_linear_jacobian_loops)
def add_linear_jacobian(J: float, B: float, w: float, stride: int, h: int, out: Any) -> None:
    """Add the Jacobian of J u'' + B u'."""
    k = np.arange(1, h + 1)
    kw = w * orders(h, stride)
    inertia, damping = J * kw * kw, B * kw
    out[k, k] -= inertia
    out[h + k, h + k] -= inertia
    out[k, h + k] += damping
    out[h + k, k] -= damping


@routine
def clean_mean(series: Any) -> None:
    """Remove the rounding from the mean of a series without one: in the play of a gear nothing holds against it."""
    top = 0.0
    for i in range(1, len(series)):
        top = max(top, abs(series[i]))
    if abs(series[0]) < 1e-14 * top:
        series[0] = 0.0


@routine
def vary(leaf: int, value: float, torque: Any, error: Any, derive: bool) -> None:
    """Change series of torque and error (blocks) as the virtual leaf says, or into derivatives by its parameter."""
    h = len(torque) // 2
    torque[0] = (1.0 if leaf == CONSTANT else 0.0) if derive else torque[0] + (value if leaf == CONSTANT else 0.0)
    for k in range(1, h + 1):
        mine, rest = leaf == LINE - k, 0.0 if derive else 1.0
        factor = np.exp(value) if leaf == STRENGTH else (rest * value + 1.0 if mine else rest)
        torque[k] *= factor
        torque[h + k] *= factor
        error[k] *= factor
        error[h + k] *= factor


class Sampling(NamedTuple):
    """Fourier coefficients of T(u) for a smooth law, by alternating frequency/time; g, gc and gs are buffers.

    With stride 2 the series has odd harmonics alone and T is odd: samples over half a turn tell all.
    """

    analysis: Floats
    analysis_double: Floats
    samples: Floats
    g: Floats
    gc: Floats
    gs: Floats
    stride: int

    def torque_series(self, law: Any, z: Any, u: Any, r: Any) -> None:
        """Coefficients of T(u) from the samples of u."""
        law_torque(law, u, self.samples)
        row_times(self.samples, self.analysis, r)

    def stiffness_product(self, law: Any, u: Any, jacobian: Any) -> None:
        """Matrix that multiplies a series by T'(u)."""
        h = len(self.g) // 4
        law_stiffness(law, u, self.samples)
        row_times(self.samples, self.analysis_double, self.g)
        extend(self.g, h, self.gc, self.gs)
        multiply_rows(self.gc, self.gs, h, self.stride, jacobian)

    def slack(self, law: Any, u: Any) -> float:
        """Middle [rad] of an orbit to which the law gives no torque at all, where any mean is in balance; else 0."""
        low, high = extremes(self.samples)  # as `torque_series` left them
        if self.stride > 1 or self.samples[low] != 0.0 or self.samples[high] != 0.0:
            return 0.0
        low, high = extremes(u)
        return float(0.5 * (u[low] + u[high]))

    def hill_trace(self, system: Any, z: Any, u: Any, w: float) -> float:
        """Trace of the period map of z'' + (T'(u)/J - (B/2J)^2) z = 0 by Numerov's rule on the samples u."""
        steps = len(u)
        scale = (2.0 * math.pi / (self.stride * steps) / w) ** 2 / 12.0
        shift = 0.25 * (system.B / system.J) ** 2
        w0, w1, v0, v1 = 1.0, 0.0, 0.0, 1.0  # two columns of the period map
        for i in range(steps):
            t = 12.0 / (1.0 + scale * (system.law.stiffness(u[i]) / system.J - shift)) - 10.0
            w0, w1 = t * w0 - w1, w0
            v0, v1 = t * v0 - v1, v0
        trace = w0 + v1
        return trace if self.stride == 1 else trace * trace - 2.0  # of two equal halves


class Work(NamedTuple):
    """Buffers of one solver, so that nothing is allocated in its loop."""

    u: Floats
    f: Floats
    tau: Floats
    error: Floats
    z: Floats
    r: Floats
    column: Floats
    spare: Floats


def all_orders(problem: Any, series: Floats) -> Floats:
    """Coefficients (points, in blocks) of a problem with those of the orders it leaves out."""
    if problem.stride == 1:
        return series
    h = series.shape[1] // 2
    out = np.zeros((len(series), 4 * h - 1))
    out[:, 1 : 2 * h : 2], out[:, 2 * h :: 2] = series[:, 1 : h + 1], series[:, h + 1 :]
    return out


class SecondOrder(NamedTuple):
    """Balance of J u'' + B u' + T(u) = tau - J e'' in the torsion u = x - e; an orbit takes `turns` turns.

    With stride 2 the unknowns are odd harmonics alone (and a mean of zero): u(phase + pi) = -u(phase).
    """

    system: Any
    leaf: int
    omega_leaf: int
    turns: int
    stride: int
    synthesis: Floats
    analysis: Floats
    angles: Floats
    tau: Floats
    error: Floats
    nonlinear: Any

    def forcing(self, system: Any, work: Any) -> None:
        """Coefficients of torque and kinematic error into `work`; only a frequency leaves them as they are."""
        if self.leaf == self.omega_leaf or self.leaf <= STRENGTH:
            copy(self.tau, work.tau)
            copy(self.error, work.error)
        else:
            torque_samples(system.excitation, self.angles, work.f)
            row_times(work.f, self.analysis, work.tau)
            clean_mean(work.tau)
            error_samples(system.error, self.angles, work.f)
            row_times(work.f, self.analysis, work.error)

    def residual(self, z: Any, work: Any, r: Any) -> None:
        """Residual [N*m] of every coefficient at z = (coefficients of u, parameter)."""
        n = self.synthesis.shape[0]
        system = with_leaf(self.system, self.leaf, z[n])
        self.forcing(system, work)
        if self.leaf <= STRENGTH:
            vary(self.leaf, z[n], work.tau, work.error, False)
        row_times(z, self.synthesis, work.u)
        self.nonlinear.torque_series(system.law, z, work.u, r)
        w = system.omega / self.turns
        add_linear(system.J, system.B, w, self.stride, z, work.tau, work.error, r)
        if work.tau[0] == 0.0:
            r[0] += system.J * w * w * self.nonlinear.slack(system.law, work.u)

    def linearise(self, z: Any, work: Any, jacobian: Any, slope: Any) -> None:
        """Derivatives of the residual by the coefficients and by the parameter; follows `residual` at the same z."""
        n = self.synthesis.shape[0]
        h = n // 2
        system = with_leaf(self.system, self.leaf, z[n])
        self.nonlinear.stiffness_product(system.law, work.u, jacobian)
        w = system.omega / self.turns
        inertia = system.J * w * w
        if self.stride > 1:
            jacobian[0, 0] = inertia
        elif abs(jacobian[0, 0]) < 1e-9 * inertia:  # nothing holds the mean in the play of a gear
            low, high = extremes(work.u)
            for j in range(n):
                jacobian[0, j] = 0.5 * inertia * (self.synthesis[j, low] + self.synthesis[j, high])
        add_linear_jacobian(system.J, system.B, w, self.stride, h, jacobian)
        if self.leaf == self.omega_leaf:
            fill(0.0, slope)
            per_turn = 1.0 / (w * self.turns)
            add_linear(2.0 * system.J * per_turn, system.B * per_turn, w, self.stride, z, slope, work.error, slope)
        elif self.leaf <= STRENGTH:
            self.forcing(system, work)
            vary(self.leaf, z[n], work.tau, work.error, True)
            fill(0.0, work.z)
            fill(0.0, slope)
            add_linear(system.J, 0.0, w, self.stride, work.z, work.tau, work.error, slope)
        else:
            self.parameter_slope(z, work, slope)

    def parameter_slope(self, z: Any, work: Any, slope: Any) -> None:
        """Derivative with respect to the parameter by a central difference."""
        n = self.synthesis.shape[0]
        d = 1e-6 * max(abs(z[n]), 1e-3)
        copy(z, work.z)
        for side in range(2):
            work.z[n] = z[n] - d if side == 0 else z[n] + d
            self.residual(work.z, work, work.spare)
            for i in range(n):
                slope[i] = (work.spare[i] - slope[i]) if side == 1 else work.spare[i]
        for i in range(n):
            slope[i] /= 2.0 * d

    def table(self, point: Floats) -> Floats:
        """Table (2H+1, 1) of a point: mean, cos 1, sin 1, ... of u."""
        return from_blocks(all_orders(self, point[None, :-1])[0])[:, None]

    def whole(self, table: Floats) -> Floats:
        """Table of x = u + e, which `find_orbit` takes."""
        error = from_blocks(all_orders(self, self.error[None, :])[0])[: len(table), None]
        out = table.copy()
        out[: len(error)] += error
        return out

    def highest(self) -> int:
        """Highest harmonic of an orbit."""
        return int(self.stride * (len(self.error) // 2 - 1) + 1)

    def fitted(self, table: Floats, value: float) -> Floats | None:
        """Point of a table, cut or filled up; None where the symmetry of the problem has no such orbit."""
        highest = self.highest()
        series = np.zeros(2 * highest + 1)
        series[: min(len(series), len(table))] = table[: len(series), 0]
        blocks = to_blocks(series)
        if self.stride > 1:
            even = np.r_[0, 2 : highest + 1 : 2, highest + 2 : 2 * highest + 1 : 2]
            if np.linalg.norm(blocks[even]) > 1e-6 * np.linalg.norm(blocks):
                return None
            blocks[0] = 0.0
            blocks = np.delete(blocks, even[1:])
        return np.append(blocks, value)


class Tables(NamedTuple):
    """What all problems with equal numbers of harmonics, samples and turns share."""

    angles: Floats
    synthesis: Floats
    analysis: Floats
    analysis_padded: Floats
    analysis_double: Floats


@lru_cache(maxsize=64)
def _tables(h: int, samples: int, turns: int, stride: int) -> Tables:
    angles = 2.0 * np.pi / stride * turns * np.arange(samples) / samples
    table = analysis(h, samples, stride)
    double = padded(analysis(2 * h, samples))
    return Tables(angles, synthesis(h, samples, stride), table, padded(table), double)


def second_order(
    system: Any, leaf: int, omega_leaf: int, harmonics: int, turns: int = 1, stride: int = 1
) -> SecondOrder:
    """Build the balance problem of an oscillator for a number of harmonics of omega/turns.

    With stride 2 only the odd ones of them are unknowns: for a smooth odd law under odd orders (see `is_half_wave`).
    """
    piecewise = is_piecewise_linear(system.law)
    samples = (8 * harmonics + 8 if piecewise else 4 * harmonics + 4) // stride
    h = (harmonics + 1) // stride if stride > 1 else harmonics
    tables = _tables(h, samples, turns, stride)
    angles, table = tables.angles, tables.analysis
    nothing = np.zeros(samples)
    tau = (system.excitation.torque(angles) + nothing) @ table
    error = (system.error.value(angles) + nothing) @ table
    clean_mean(tau)
    wide = 4 * h + 1
    nonlinear: Any
    if piecewise:
        nonlinear = crossings_for(h)
    else:
        buffers = np.empty(samples), np.empty(wide), np.empty(wide), np.empty(wide)
        nonlinear = Sampling(tables.analysis_padded, tables.analysis_double, *buffers, stride)
    return SecondOrder(
        system, leaf, omega_leaf, turns, stride, tables.synthesis, table, angles, tau, error, nonlinear
    )  # fmt: skip


def work_for(problem: Any) -> Any:
    """Buffers for a problem."""
    n, samples = len(problem.tau), problem.synthesis.shape[1]
    return Work(
        np.empty(samples), np.empty(samples), np.empty(n), np.empty(n), np.empty(n + 1), np.empty(n), np.empty(n),
        np.empty(n),
    )  # fmt: skip


def is_light(problem: Any) -> bool:
    """Whether NumPy follows a curve of this problem in a fraction of a second."""
    return isinstance(getattr(problem, "nonlinear", None), Sampling) and len(problem.tau) <= 33
