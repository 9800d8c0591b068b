"""The kinematic error in a condensed problem: of the base angle alone, or of the motor's own angle.

Where the error follows the motor's deviation delta, x = u + e(phase + delta), and the gear's torque T acts on delta as
-e'(phase + delta) T. Both are smooth functions of time: T is taken from the balance of x, T = F - D P, which holds for
every law, with corners too; e, e' and e'' are sampled.
"""

from typing import Any, NamedTuple

import numpy as np

from ....compile.jit import elementwise, kernel_as
from ....results import Floats
from ..fourier import extend_series, multiply_rows
from ..linear_algebra import add, copy, fill, row_times
from .pencil import add_on_the_left, add_stiffness, add_times


class Prescribed(NamedTuple):
    """Error (2H+1,) of the base angle alone, for a motor that is held or a gear that has none."""

    error: Floats

    def positions(self, factor: float, z: Any, x: Any) -> None:
        """Write the coefficients of x = u + e."""
        copy(z[: len(x)], x)
        add(factor, self.error, x)
        x[0] += (1.0 - factor) * self.error[0]

    def react(self, problem: Any, blocks: Any, r: Any) -> None:
        """The motor feels no torque through the error."""

    def linearise(self, problem: Any, blocks: Any, jacobian: Any, slope: Any) -> None:
        """Nothing follows the motor."""


def _sample_error_loops(lines: Any, factor: float, angles: Any, delta: Any, value: Any, slope: Any, bend: Any) -> None:
    for i in range(len(angles)):
        e, de, dde = lines[0, 1], 0.0, 0.0
        for j in range(1, lines.shape[0]):
            order = lines[j, 0]
            a = order * (angles[i] + delta[i])
            c, s = np.cos(a), np.sin(a)
            wave = factor * (lines[j, 1] * c + lines[j, 2] * s)
            e += wave
            de += factor * order * (lines[j, 2] * c - lines[j, 1] * s)
            dde -= order * order * wave
        value[i], slope[i], bend[i] = e, de, dde


@kernel_as(_sample_error_loops)
def sample_error(lines: Any, factor: float, angles: Any, delta: Any, value: Any, slope: Any, bend: Any) -> None:
    """Write e, e' and e'' at the motor's angles, the base angles [rad] and its deviation; `lines` are rows order, c, s."""
    order, even, odd = lines[1:].T[:, :, None]
    a = order * (angles + delta)
    c, s = np.cos(a), np.sin(a)
    value[:] = lines[0, 1] + factor * np.sum(even * c + odd * s, axis=0)
    slope[:] = factor * np.sum(order * (odd * c - even * s), axis=0)
    bend[:] = -factor * np.sum(order * order * (even * c + odd * s), axis=0)


def _multiplied_loops(a: Any, b: Any, out: Any) -> None:
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            f = a[i, j]
            for m in range(b.shape[1]):
                out[i, m] += f * b[j, m]


@kernel_as(_multiplied_loops)
def add_multiplied(a: Any, b: Any, out: Any) -> None:
    """Add the product of two matrices to out."""
    out += a @ b


@elementwise
def multiply(v: Any, out: Any) -> Any:
    """Multiply the entries of out by those of v."""
    return out * v


class Following(NamedTuple):
    """Error of the motor's own angle, as lines (order, cosine, sine; the mean first), with buffers.

    `error` is that of the base angle alone.
    """

    error: Floats
    lines: Floats
    angles: Floats
    synthesis: Floats
    analysis: Floats
    double: Floats
    value: Floats
    slope: Floats
    bend: Floats
    torque: Floats
    mixed: Floats
    series: Floats
    wide: Floats
    gc: Floats
    gs: Floats
    first: Floats
    second: Floats
    change: Floats

    def positions(self, factor: float, z: Any, x: Any) -> None:
        """Write the coefficients of x = u + e(phase + delta); the last block of z is delta."""
        size = len(x)
        at = len(z) - 1 - size
        row_times(z[at : at + size], self.synthesis, self.torque)
        sample_error(self.lines, factor, self.angles, self.torque, self.value, self.slope, self.bend)
        row_times(self.value, self.analysis, x)
        add(1.0, z[:size], x)

    def gear_torque(self, s: Any, n: int, blocks: Any) -> None:
        """Write the coefficients and samples of T = F - D P, the balance of x."""
        fill(0.0, self.change)
        add_stiffness(s, n, 0.0, blocks, blocks[0], self.change)
        size = len(self.series)
        for i in range(size):
            self.series[i] = -self.change[i]
        row_times(self.series, self.synthesis, self.torque)

    def react(self, problem: Any, blocks: Any, r: Any) -> None:
        """Subtract e' T from the motor's block of r."""
        size = len(self.series)
        self.gear_torque(problem.s, problem.pencil.inertia.shape[0], blocks)
        copy(self.torque, self.mixed)
        multiply(self.slope, self.mixed)
        row_times(self.mixed, self.analysis, self.series)
        at = (blocks.shape[0] - 1) * size
        for i in range(size):
            r[at + i] -= self.series[i]

    def linearise(self, problem: Any, blocks: Any, jacobian: Any, slope: Any) -> None:
        """Add what follows the motor to the derivatives by the coefficients and by omega."""
        size, last, n = len(self.series), blocks.shape[0] - 1, problem.pencil.inertia.shape[0]
        at, h = last * size, len(self.series) // 2
        self.gear_torque(problem.s, n, blocks)
        row_times(self.slope, self.double, self.wide)
        extend_series(self.wide, h, self.gc, self.gs)
        multiply_rows(self.gc, self.gs, h, 1, self.first)
        copy(self.torque, self.mixed)
        multiply(self.bend, self.mixed)
        row_times(self.mixed, self.double, self.wide)
        extend_series(self.wide, h, self.gc, self.gs)
        multiply_rows(self.gc, self.gs, h, 1, self.second)
        for i in range(last + 1):
            add_times(problem.s, i, 0, self.first, jacobian[i * size : (i + 1) * size, at : at + size])
        motor = jacobian[at : at + size]
        for j in range(last):
            add_on_the_left(self.first, problem.s, 0, j, motor[:, j * size : (j + 1) * size])
        own = motor[:, at : at + size]
        add_multiplied(self.first, jacobian[:size, at : at + size], own)
        for i in range(size):
            add(-1.0, self.second[i], own[i])
        fill(0.0, self.change)
        add_stiffness(problem.d, n, 0.0, blocks, blocks[0], self.change)
        for i in range(size):
            for j in range(size):
                slope[at + i] += self.first[i, j] * self.change[j]


def following(lines: Floats, angles: Floats, synthesis: Floats, back: Floats, double: Floats, count: int) -> Following:
    """Buffers of an error that follows the motor, for `count` blocks of unknowns."""
    samples, size = len(angles), len(synthesis)
    wide = 2 * size - 1
    some = [np.empty(samples) for _ in range(5)]
    none = np.zeros(samples)
    sample_error(lines, 1.0, angles, none, *some[:3])
    return Following(
        some[0] @ back, lines, angles, synthesis, back, double, *some, np.empty(size), np.empty(wide), np.empty(wide), np.empty(wide),
        np.empty((size, size)), np.empty((size, size)), np.empty(count * size),
    )  # fmt: skip
