"""The kinematic error in a condensed problem: of the base angle alone, or of the motor's own angle.

Where the error follows the motor's deviation delta, x = u + e(phase + delta), and the gear's torque T acts on delta as
-e'(phase + delta) T. Both are smooth functions of time: T is taken from the balance of x, T = F - D P, which holds for
every law, with corners too; e, e' and e'' are sampled.
Its methods get the tables of synthesis and analysis and the base angles of the samples, and the dynamic stiffness s.
"""

from typing import Any, NamedTuple

import numpy as np

from ....base.results import Floats
from ....compile.array_functions import elementwise
from ....compile.jit import kernel_as, routine
from ..fourier import extend_series, multiply_rows
from ..linear_algebra import add, copy, fill, padded, row_times
from ..piecewise import add_product
from .pencil import add_on_the_left, add_stiffness, add_times


def _sample_error_loops(
    lines: Any, factor: float, angles: Floats, delta: Floats, value: Floats, slope: Floats, bend: Floats
) -> None:
    for i in range(len(angles)):
        e, de, dde, a, last = lines[0, 1], 0.0, 0.0, angles[i] + delta[i], 0.0
        lowest, cosine, sine, c, s = 0.0, 1.0, 0.0, 1.0, 0.0
        for j in range(1, lines.shape[0]):
            order = lines[j, 0]
            if j > 1 and order - last == lowest:  # orders are often multiples: no more sines and cosines
                c, s = c * cosine - s * sine, c * sine + s * cosine
            else:
                c, s = np.cos(order * a), np.sin(order * a)
            if j == 1:
                lowest, cosine, sine = order, c, s
            last = order
            wave = factor * (lines[j, 1] * c + lines[j, 2] * s)
            e += wave
            de += factor * order * (lines[j, 2] * c - lines[j, 1] * s)
            dde -= order * order * wave
        value[i], slope[i], bend[i] = e, de, dde


@kernel_as(_sample_error_loops)
def sample_error(
    lines: Floats, factor: float, angles: Floats, delta: Floats, value: Floats, slope: Floats, bend: Floats
) -> None:
    """Write e, e' and e'' at base angles [rad] and deviations of the motor; `lines` are rows order, cosine, sine."""
    order, even, odd = lines[1:].T[:, :, None]
    a = order * (angles + delta)
    c, s = np.cos(a), np.sin(a)
    value[:] = lines[0, 1] + factor * np.sum(even * c + odd * s, axis=0)
    slope[:] = factor * np.sum(order * (odd * c - even * s), axis=0)
    bend[:] = -factor * np.sum(order * order * (even * c + odd * s), axis=0)


def _multiplied_loops(a: Floats, b: Floats, out: Floats) -> None:
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            f = a[i, j]
            for m in range(b.shape[1]):
                out[i, m] += f * b[j, m]


@kernel_as(_multiplied_loops)
def add_multiplied(a: Floats, b: Floats, out: Floats) -> None:
    """Add the product of two matrices to out."""
    out += a @ b


@elementwise
def multiply(v: Any, out: Any) -> Any:
    """Multiply the entries of out by those of v."""
    return out * v


VALUE, SLOPE, BEND, TORQUE, MIXED = range(5)  # rows of the samples: e, e', e'' and T


class Gear(NamedTuple):
    """Error as lines (order, cosine, sine; the mean first), with buffers.

    `follows` is 1 where it follows the motor's own angle, and 0 where the motor is held or there is none: then the gear
    acts on the motor by nothing. `error` is that of the base angle alone, `double` the analysis of twice the harmonics.
    """

    follows: int
    error: Floats
    lines: Floats
    double: Floats
    samples: Floats
    wide: Floats
    products: Floats
    series: Floats
    change: Floats

    def positions(self, tables: Any, factor: float, z: Floats, x: Floats) -> None:
        """Write the coefficients of x = u + e(phase + delta); the last block of z is delta."""
        size, samples = len(x), self.samples
        if self.follows == 0:
            copy(z[:size], x)
            add(factor, self.error, x)
            x[0] += (1.0 - factor) * self.error[0]
            return
        start = len(z) - 1 - size
        row_times(z[start : start + size], tables[0], samples[TORQUE])
        sample_error(self.lines, factor, tables[2], samples[TORQUE], samples[VALUE], samples[SLOPE], samples[BEND])
        row_times(samples[VALUE], tables[1], x)
        add(1.0, z[:size], x)

    def gear_torque(self, synthesis: Floats, s: Any, blocks: Floats) -> None:
        """Write the coefficients and samples of T = F - D P, the balance of x."""
        fill(0.0, self.change)
        add_stiffness(s, 0.0, blocks, blocks[0], self.change)
        for i in range(len(self.series)):
            self.series[i] = -self.change[i]
        row_times(self.series, synthesis, self.samples[TORQUE])

    def react(self, tables: Any, s: Any, blocks: Floats, r: Floats) -> None:
        """Subtract e' T from the motor's block of r."""
        if self.follows == 0:
            return
        self.gear_torque(tables[0], s, blocks)
        copy(self.samples[TORQUE], self.samples[MIXED])
        multiply(self.samples[SLOPE], self.samples[MIXED])
        row_times(self.samples[MIXED], tables[1], self.series)
        size = len(self.series)
        start = (blocks.shape[0] - 1) * size
        for i in range(size):
            r[start + i] -= self.series[i]

    def multiply_by(self, samples: Floats, product: Floats) -> None:
        """Write the matrix that multiplies a series by what has these samples."""
        even, odd = self.wide[1], self.wide[2]
        h = len(self.series) // 2
        row_times(samples, self.double, self.wide[0])
        extend_series(self.wide[0], h, even, odd)
        multiply_rows(even, odd, h, 1, product)

    def linearise(self, tables: Any, s: Any, blocks: Floats, jacobian: Floats) -> None:
        """Add what follows the motor to the derivatives by the coefficients."""
        if self.follows == 0:
            return
        size, last = len(self.series), blocks.shape[0] - 1
        start = last * size
        first, second = self.products[0], self.products[1]
        self.gear_torque(tables[0], s, blocks)
        self.multiply_by(self.samples[SLOPE], first)
        copy(self.samples[TORQUE], self.samples[MIXED])
        multiply(self.samples[BEND], self.samples[MIXED])
        self.multiply_by(self.samples[MIXED], second)
        for i in range(last + 1):
            add_times(s, i, 0, first, jacobian[i * size : (i + 1) * size, start : start + size])
        motor = jacobian[start : start + size]
        for j in range(last):
            add_on_the_left(first, s, 0, j, motor[:, j * size : (j + 1) * size])
        corner = motor[:, start : start + size]
        add_multiplied(first, jacobian[:size, start : start + size], corner)
        for i in range(size):
            add(-1.0, second[i], corner[i])

    def of_mean(self, share: float, row: Floats) -> None:
        """Add a share of the derivatives of the mean of e by the motor's block; follows `linearise`."""
        if self.follows > 0:
            add(share, self.products[0][0], row)

    def by_speed(self, change: Any, blocks: Floats, slope: Floats) -> None:
        """Add what the motor feels of T to the derivative by omega; follows `linearise`."""
        if self.follows == 0:
            return
        fill(0.0, self.change)
        add_stiffness(change, 0.0, blocks, blocks[0], self.change)
        size = len(self.series)
        start = (blocks.shape[0] - 1) * size
        add_product(self.products[0], self.change, slope[start : start + size])

    def by_strength(self, tables: Any, s: Any, factor: float, blocks: Floats, slope: Floats) -> None:
        """Add the derivative by the logarithm of the factor of all that alternates; follows `linearise`."""
        if self.follows == 0:
            fill(0.0, blocks[0])
            add(factor, self.error, blocks[0])
            alternating(s, blocks, slope)
            return
        size = len(self.series)
        start = (blocks.shape[0] - 1) * size
        copy(self.samples[TORQUE], self.samples[MIXED])
        multiply(self.samples[SLOPE], self.samples[MIXED])
        row_times(self.samples[MIXED], tables[1], self.series)
        row_times(self.samples[VALUE], tables[1], blocks[0])
        blocks[0, 0] -= self.lines[0, 1]
        alternating(s, blocks, slope)
        copy(slope[:size], self.change[:size])
        for i in range(size):
            slope[start + i] -= self.series[i]
        add_product(self.products[0], self.change, slope[start : start + size])


@routine
def alternating(s: Any, blocks: Floats, slope: Floats) -> None:
    """Add D x - F to a derivative, x in the first block and of F what alternates; the other blocks are overwritten."""
    n, size = s.shape[1], blocks.shape[1]
    for i in range(1, blocks.shape[0]):
        fill(0.0, blocks[i])
    add_stiffness(s, 0.0, blocks, blocks[0], slope)
    for i in range(blocks.shape[0]):
        slope[i * size] += s[0, i, n].real


def gear_of(follows: bool, lines: Floats, error: Floats, angles: Floats, double: Floats, count: int) -> Gear:
    """Buffers of an error with such coefficients, for `count` blocks of unknowns."""
    samples, size = len(angles), len(error)
    return Gear(
        int(follows), error, lines, padded(double), np.zeros((5, samples)), np.empty((3, 2 * size - 1)),
        np.empty((2, size, size)), np.empty(size), np.empty(count * size),
    )  # fmt: skip
