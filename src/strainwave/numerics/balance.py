"""Harmonic balance: the equations that the Fourier coefficients of a periodic orbit satisfy, and their Jacobian.

A problem is a NamedTuple with `residual(z, work, r)` and `linearise(z, work, jacobian, slope)`, where z holds the
coefficients (blocks: mean, cosines, sines) and, last, the parameter that may vary. `SecondOrder` works on the torsion u
alone (velocity eliminated); the nonlinear torque is sampled at 4H+4 points of the common period (alternating
frequency/time).

Krack & Gross 2019, Harmonic Balance for Nonlinear Vibration Problems, secs. 2.2-2.4 (AFT) and 3.2 (Jacobian).
"""

from typing import Any, NamedTuple

import numpy as np

from .._jit import kernel, kernel_as, with_leaf
from ..results import Floats
from .fourier import analysis, synthesis
from .linear import copy, fill, row_times


def _law_torque_loops(law: Any, u: Any, out: Any) -> None:
    for i in range(u.shape[0]):
        out[i] = law.torque(u[i])


@kernel_as(_law_torque_loops)
def law_torque(law: Any, u: Any, out: Any) -> None:
    """Torque of the law at every sample."""
    out[:] = law.torque(u)


def _law_stiffness_loops(law: Any, u: Any, out: Any) -> None:
    for i in range(u.shape[0]):
        out[i] = law.stiffness(u[i])


@kernel_as(_law_stiffness_loops)
def law_stiffness(law: Any, u: Any, out: Any) -> None:
    """Stiffness of the law at every sample."""
    out[:] = law.stiffness(u)


def _torque_samples_loops(excitation: Any, angles: Any, out: Any) -> None:
    for i in range(angles.shape[0]):
        out[i] = excitation.torque(angles[i])


@kernel_as(_torque_samples_loops)
def torque_samples(excitation: Any, angles: Any, out: Any) -> None:
    """Torque of the excitation at every angle."""
    out[:] = excitation.torque(angles)


def _error_samples_loops(error: Any, angles: Any, out: Any) -> None:
    for i in range(angles.shape[0]):
        out[i] = error.value(angles[i])


@kernel_as(_error_samples_loops)
def error_samples(error: Any, angles: Any, out: Any) -> None:
    """Kinematic error at every angle."""
    out[:] = error.value(angles)


def _multiply_rows_loops(gc: Any, gs: Any, h: int, out: Any) -> None:
    # gc[2H + j], gs[2H + j]: cosine and sine coefficients of the factor, extended evenly and oddly to negative j.
    o = 2 * h
    out[0, 0] = 0.5 * gc[o]
    for m in range(1, h + 1):
        out[0, m] = 0.5 * gc[o + m]
        out[0, h + m] = 0.5 * gs[o + m]
        out[m, 0] = gc[o + m]
        out[h + m, 0] = gs[o + m]
    for k in range(1, h + 1):
        for m in range(1, h + 1):
            out[k, m] = 0.5 * (gc[o + m - k] + gc[o + k + m])
            out[k, h + m] = 0.5 * (gs[o + k + m] + gs[o + m - k])
            out[h + k, m] = 0.5 * (gs[o + k + m] - gs[o + m - k])
            out[h + k, h + m] = 0.5 * (gc[o + m - k] - gc[o + k + m])


@kernel_as(_multiply_rows_loops)
def multiply_rows(gc: Any, gs: Any, h: int, out: Any) -> None:
    """Matrix that multiplies a series by the factor with extended coefficients gc, gs: Toeplitz plus Hankel blocks."""
    k = np.arange(1, h + 1)
    o = 2 * h
    difference, total = o + k[None, :] - k[:, None], o + k[None, :] + k[:, None]
    n = 2 * h + 1
    out[0, 0], out[0, 1 : h + 1], out[0, h + 1 : n] = 0.5 * gc[o], 0.5 * gc[o + k], 0.5 * gs[o + k]
    out[1 : h + 1, 0], out[h + 1 : n, 0] = gc[o + k], gs[o + k]
    out[1 : h + 1, 1 : h + 1] = 0.5 * (gc[difference] + gc[total])
    out[1 : h + 1, h + 1 : n] = 0.5 * (gs[total] + gs[difference])
    out[h + 1 : n, 1 : h + 1] = 0.5 * (gs[total] - gs[difference])
    out[h + 1 : n, h + 1 : n] = 0.5 * (gc[difference] - gc[total])


def _extend_loops(g: Any, h: int, gc: Any, gs: Any) -> None:
    o = 2 * h
    gc[o] = 2.0 * g[0]
    gs[o] = 0.0
    for j in range(1, o + 1):
        gc[o + j] = g[j]
        gc[o - j] = g[j]
        gs[o + j] = g[o + j]
        gs[o - j] = -g[o + j]


@kernel_as(_extend_loops)
def extend(g: Any, h: int, gc: Any, gs: Any) -> None:
    """Extend the coefficients g (blocks, 2H harmonics) to negative indices; the mean counts twice."""
    o = 2 * h
    gc[o], gc[o + 1 :], gc[:o] = 2.0 * g[0], g[1 : o + 1], g[o:0:-1]
    gs[o], gs[o + 1 :], gs[:o] = 0.0, g[o + 1 :], -g[:o:-1]


def _add_linear_loops(J: float, B: float, w: float, h: int, z: Any, torque: Any, error: Any, r: Any) -> None:
    r[0] -= torque[0]
    for k in range(1, h + 1):
        kw = k * w
        inertia = J * kw * kw
        damping = B * kw
        c, s = z[k], z[h + k]
        r[k] += -inertia * (c + error[k]) + damping * s - torque[k]
        r[h + k] += -inertia * (s + error[h + k]) - damping * c - torque[h + k]


@kernel_as(_add_linear_loops)
def add_linear(J: float, B: float, w: float, h: int, z: Any, torque: Any, error: Any, r: Any) -> None:
    """Add J u'' + B u' - tau + J e'' in Fourier coefficients."""
    kw = w * np.arange(1, h + 1)
    c, s = z[1 : h + 1], z[h + 1 : 2 * h + 1]
    r -= torque
    r[1 : h + 1] += -J * kw * kw * (c + error[1 : h + 1]) + B * kw * s
    r[h + 1 :] += -J * kw * kw * (s + error[h + 1 :]) - B * kw * c


def _add_linear_jacobian_loops(J: float, B: float, w: float, h: int, out: Any) -> None:
    for k in range(1, h + 1):
        kw = k * w
        out[k, k] -= J * kw * kw
        out[h + k, h + k] -= J * kw * kw
        out[k, h + k] += B * kw
        out[h + k, k] -= B * kw


@kernel_as(_add_linear_jacobian_loops)
def add_linear_jacobian(J: float, B: float, w: float, h: int, out: Any) -> None:
    """Add the Jacobian of J u'' + B u'."""
    k = np.arange(1, h + 1)
    out[k, k] -= J * (w * k) ** 2
    out[h + k, h + k] -= J * (w * k) ** 2
    out[k, h + k] += B * w * k
    out[h + k, k] -= B * w * k


class Work(NamedTuple):
    """Buffers of one solver, so that nothing is allocated in its loop."""

    u: Floats
    f: Floats
    g: Floats
    gc: Floats
    gs: Floats
    tau: Floats
    error: Floats
    z: Floats
    r: Floats
    column: Floats
    spare: Floats


class SecondOrder(NamedTuple):
    """Balance of J u'' + B u' + T(u) = tau - J e'' in the torsion u = x - e; an orbit takes `turns` turns."""

    system: Any
    leaf: int
    omega_leaf: int
    turns: int
    synthesis: Floats
    analysis: Floats
    analysis_double: Floats
    angles: Floats
    tau: Floats
    error: Floats

    def forcing(self, system: Any, work: Any) -> None:
        """Coefficients of torque and kinematic error into `work`; only a frequency leaves them as they are."""
        if self.leaf == self.omega_leaf:
            copy(self.tau, work.tau)
            copy(self.error, work.error)
        else:
            torque_samples(system.excitation, self.angles, work.f)
            row_times(work.f, self.analysis, work.tau)
            error_samples(system.error, self.angles, work.f)
            row_times(work.f, self.analysis, work.error)

    def residual(self, z: Any, work: Any, r: Any) -> None:
        """Residual [N*m] of every coefficient at z = (coefficients of u, parameter)."""
        n = self.synthesis.shape[0]
        system = with_leaf(self.system, self.leaf, z[n])
        self.forcing(system, work)
        row_times(z, self.synthesis, work.u)
        law_torque(system.law, work.u, work.f)
        row_times(work.f, self.analysis, r)
        add_linear(system.J, system.B, system.omega / self.turns, n // 2, z, work.tau, work.error, r)

    def linearise(self, z: Any, work: Any, jacobian: Any, slope: Any) -> None:
        """Derivatives of the residual by the coefficients and by the parameter; follows `residual` at the same z."""
        n = self.synthesis.shape[0]
        h = n // 2
        system = with_leaf(self.system, self.leaf, z[n])
        law_stiffness(system.law, work.u, work.f)
        row_times(work.f, self.analysis_double, work.g)
        extend(work.g, h, work.gc, work.gs)
        multiply_rows(work.gc, work.gs, h, jacobian)
        w = system.omega / self.turns
        add_linear_jacobian(system.J, system.B, w, h, jacobian)
        if self.leaf == self.omega_leaf:
            fill(0.0, slope)
            per_turn = 1.0 / (w * self.turns)
            add_linear(2.0 * system.J * per_turn, system.B * per_turn, w, h, z, slope, work.error, slope)
        else:
            self.parameter_slope(z, work, slope)

    def parameter_slope(self, z: Any, work: Any, slope: Any) -> None:
        """Derivative with respect to the parameter by a central difference."""
        n = self.synthesis.shape[0]
        d = 1e-6 * max(abs(z[n]), 1e-3)
        copy(z, work.z)
        work.z[n] = z[n] + d
        self.residual(work.z, work, slope)
        work.z[n] = z[n] - d
        self.residual(work.z, work, work.spare)
        for i in range(n):
            slope[i] = (slope[i] - work.spare[i]) / (2.0 * d)


def second_order(system: Any, leaf: int, omega_leaf: int, harmonics: int, turns: int = 1) -> SecondOrder:
    """Build the balance problem of an oscillator for a number of harmonics of omega/turns."""
    samples = 4 * harmonics + 4
    angles = 2.0 * np.pi * turns * np.arange(samples) / samples
    table = analysis(harmonics, samples)
    torque = np.broadcast_to(np.asarray(system.excitation.torque(angles), float), angles.shape)
    error = np.broadcast_to(np.asarray(system.error.value(angles), float), angles.shape)
    return SecondOrder(
        system, leaf, omega_leaf, turns, synthesis(harmonics, samples), table, analysis(2 * harmonics, samples),
        angles, torque @ table, error @ table,
    )  # fmt: skip


@kernel
def work_for(problem: Any) -> Any:
    """Buffers for a problem."""
    n, samples = problem.synthesis.shape
    return Work(
        np.empty(samples), np.empty(samples), np.empty(2 * n - 1), np.empty(2 * n - 1), np.empty(2 * n - 1),
        np.empty(n), np.empty(n), np.empty(n + 1), np.empty(n), np.empty(n), np.empty(n),
    )  # fmt: skip
