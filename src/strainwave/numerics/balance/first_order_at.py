"""The balance of `FirstOrder` in machine code: compiled once for all systems, whose rates it calls by address.

It does what `FirstOrder` and `fourier` do in NumPy, sample by sample. Series are tables (2H+1, states) in the units of
the states; `waves` are 1, cos psi, ..., cos H psi, sin psi, ..., sin H psi at a place psi of the period.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...base.protocols import omega_of
from ...base.results import Floats
from ...compile.address import word_of_leaf, words_of
from ...compile.calls import MATRIX, VECTOR, at
from ...compile.jit import entries, routine
from ..addressed import EquationsAt, SeveralAt, corner_distances, several_at
from ..roots import FA, FB, SHARE, A, B, narrow, next_place
from .fourier import CLOSE, LOOKED, PHASE, PLACES, WEIGHTS, extend_series, multiply_rows
from .linear_algebra import add, copy, fill
from .linear_part import STRENGTH
from .rates import strengthened

CHANGE, LEAST_SIZE = 1e-6, 1e-3  # of a parameter for its derivative, and the least size that it is taken to have


class FirstOrderAt(NamedTuple):
    """A `FirstOrder` by the address of its system, with buffers.

    `parameter` (1,) is the place of the parameter among the words of the system, or a spare one. `turn` are the angles
    of the mean that a strength leaves, `gauss` the places and weights of a panel. `psi` and `weights` (room,) are the
    samples of the latest motion, `count` (1,) their number and `states` (room, n) what the motion is there.
    """

    system: SeveralAt
    parameter: Floats
    is_speed: bool
    is_strength: bool
    speed: float
    turns: float
    harmonics: int
    kinks: int
    sizes: Floats
    steps: Floats
    turn: Floats
    gauss: Floats
    psi: Floats
    weights: Floats
    states: Floats
    count: Any

    def size(self) -> int:
        """Number of coefficients."""
        return len(self.sizes) * (2 * self.harmonics + 1)

    def take(self, z: Floats) -> Any:
        """Set the parameter, the last entry of z, and return the series, the strength and the speed of harmonic 1."""
        n, rows = len(self.sizes), 2 * self.harmonics + 1
        value = z[n * rows]
        series, strength, speed = np.empty((rows, n)), 1.0, self.speed
        for j in range(n):
            for k in range(rows):
                series[k, j] = z[j * rows + k] * self.sizes[j]
        self.parameter[0] = value
        if self.is_speed:
            speed = value
        elif self.is_strength:
            strength = math.exp(value)
        return series, strength, speed / self.turns

    def rates(self, psi: float, y: Floats, strength: float, w: Floats) -> None:
        """Write the rates in several states y (n, states) to w[0]; w (3, n, states) is a buffer."""
        strengthened(self.system, self.turns * psi, y, self.turn, strength, w)

    def slopes(self, psi: float, y: Floats, w: Floats, strength: float, derivatives: Floats) -> None:
        """Write the derivatives (states, states) of the rates in the state y by differences; w (4, 2n, n): buffer."""
        n = len(self.sizes)
        for i in range(2 * n):
            for j in range(n):
                w[3, i, j] = y[j]
        for j in range(n):
            w[3, j, j] += self.steps[j]
            w[3, n + j, j] -= self.steps[j]
        self.rates(psi, w[3], strength, w)
        for j in range(n):
            for i in range(n):
                derivatives[i, j] = (w[0, j, i] - w[0, n + j, i]) / (2.0 * self.steps[j])

    def sample(self, series: Floats) -> None:
        """Find the samples of a motion, and what it is there."""
        if self.kinks == 0:
            self.count[0] = len(self.psi)
            for i in range(len(self.psi)):
                self.psi[i] = 2.0 * math.pi * i / len(self.psi)
                self.weights[i] = 1.0 / len(self.psi)
        else:
            room = len(self.psi) // self.gauss.shape[1]
            first, width = np.empty(room), np.empty(room)
            pieces = pieces_of(self, series, PHASE / self.harmonics, first, width)
            places = self.gauss.shape[1]
            for i in range(pieces):
                for j in range(places):
                    self.psi[i * places + j] = first[i] + 0.5 * width[i] * (1.0 + self.gauss[0, j])
                    self.weights[i * places + j] = width[i] * self.gauss[1, j] / (4.0 * math.pi)
            self.count[0] = pieces * places
        for i in range(self.count[0]):
            state_at(series, self.psi[i], self.states[i])

    def equations(self, z: Floats, r: Floats) -> None:
        """Residual of every coefficient, in units of the state's size a second."""
        self = at(self)
        n, h = len(self.sizes), self.harmonics
        rows = 2 * h + 1
        series, strength, speed = self.take(z)
        self.sample(series)
        w, waves = np.empty((3, 1, n)), np.empty(rows)
        fill(0.0, r[: n * rows])
        for i in range(self.count[0]):
            self.rates(self.psi[i], self.states[i : i + 1], strength, w)
            write_waves(self.psi[i], waves)
            for j in range(n):
                add(-self.weights[i] * w[0, 0, j], waves, r[j * rows : (j + 1) * rows])
        for j in range(n):
            block = r[j * rows : (j + 1) * rows]
            block[0] /= self.sizes[j]
            for k in range(1, h + 1):
                block[k] = 2.0 * block[k] / self.sizes[j] + speed * k * z[j * rows + h + k]
                block[h + k] = 2.0 * block[h + k] / self.sizes[j] - speed * k * z[j * rows + k]

    def stiffness(self, z: Floats, jacobian: Floats) -> None:
        """Derivatives of the residual by the coefficients; follows `equations` at the same z."""
        self = at(self)
        n, h = len(self.sizes), self.harmonics
        rows, wide = 2 * h + 1, 4 * h + 1
        _, strength, speed = self.take(z)
        w, slopes, waves = np.empty((4, 2 * n, n)), np.empty((n, n)), np.empty(wide)
        products, cosines, sines = np.zeros((n * n, wide)), np.empty(wide), np.empty(wide)
        for i in range(self.count[0]):
            self.slopes(self.psi[i], self.states[i], w, strength, slopes)
            write_waves(self.psi[i], waves)
            for j in range(n * n):
                if slopes[j // n, j % n] != 0.0:
                    add(self.weights[i] * slopes[j // n, j % n], waves, products[j])
        for j in range(n * n):
            row, column = j // n, j % n
            unit = -self.sizes[column] / self.sizes[row]
            products[j, 0] *= unit
            for k in range(1, wide):
                products[j, k] *= 2.0 * unit
            extend_series(products[j], h, cosines, sines)
            block = jacobian[row * rows : (row + 1) * rows, column * rows : (column + 1) * rows]
            multiply_rows(cosines, sines, h, 1, block)
            if row == column:
                for k in range(1, h + 1):
                    block[k, h + k] += speed * k
                    block[h + k, k] -= speed * k

    def by_parameter(self, z: Floats, slope: Floats) -> None:
        """Derivative of the residual by the parameter: a central difference at the samples of `equations`."""
        self = at(self)
        n, h = len(self.sizes), self.harmonics
        rows, value = 2 * h + 1, z[len(self.sizes) * (2 * h + 1)]
        d = CHANGE * max(abs(value), LEAST_SIZE)
        w, before, waves = np.empty((3, 1, n)), np.empty(n), np.empty(rows)
        after_strength, before_strength = 1.0, 1.0
        if self.is_strength:
            after_strength, before_strength = math.exp(value + d), math.exp(value - d)
        fill(0.0, slope[: n * rows])
        for i in range(self.count[0]):
            y = self.states[i : i + 1]
            self.parameter[0] = value - d
            self.rates(self.psi[i], y, before_strength, w)
            copy(w[0, 0], before)
            self.parameter[0] = value + d
            self.rates(self.psi[i], y, after_strength, w)
            write_waves(self.psi[i], waves)
            for j in range(n):
                change = (w[0, 0, j] - before[j]) / (2.0 * d * self.sizes[j])
                add(-self.weights[i] * change, waves, slope[j * rows : (j + 1) * rows])
        self.parameter[0] = value
        faster = 1.0 / self.turns if self.is_speed else 0.0
        for j in range(n):
            block = slope[j * rows : (j + 1) * rows]
            for k in range(1, h + 1):
                block[k] = 2.0 * block[k] + faster * k * z[j * rows + h + k]
                block[h + k] = 2.0 * block[h + k] - faster * k * z[j * rows + k]


@routine
def write_waves(psi: float, waves: Floats) -> None:
    """Write 1, cosines and sines of the multiples of an angle [rad]."""
    h, cosine, sine, c, s = len(waves) // 2, math.cos(psi), math.sin(psi), 1.0, 0.0
    waves[0] = 1.0
    for k in range(1, h + 1):
        c, s = c * cosine - s * sine, s * cosine + c * sine
        waves[k], waves[h + k] = c, s


@routine
def state_at(series: Floats, psi: float, state: Floats) -> None:
    """Write the state of a motion at a place [rad]."""
    h, cosine, sine, c, s = len(series) // 2, math.cos(psi), math.sin(psi), 1.0, 0.0
    copy(series[0], state)
    for k in range(1, h + 1):
        c, s = c * cosine - s * sine, s * cosine + c * sine
        for j in range(len(state)):
            state[j] += c * series[k, j] + s * series[h + k, j]


@routine
def crossings_of(problem: Any, series: Floats, crossings: Floats) -> int:
    """Write the places [rad] where distances from corners change sign along a motion, in order; returns how many."""
    count, states, places = 0, len(problem.sizes), LOOKED * (problem.harmonics + 1)
    state, d, bracket = np.empty(states), np.empty((3, problem.kinks)), np.empty(5)
    for i in range(places + 1):
        psi = 2.0 * math.pi * (i % places) / places
        state_at(series, psi, state)
        corner_distances(problem.system, problem.turns * psi, state, d[0])
        for k in range(problem.kinks):
            if i > 0 and (d[0, k] < 0.0) != (d[1, k] < 0.0):
                low, high = 2.0 * math.pi * (i - 1) / places, 2.0 * math.pi * i / places
                bracket[A], bracket[FA], bracket[B], bracket[FB], bracket[SHARE] = low, d[1, k], high, d[0, k], 0.5
                while abs(bracket[B] - bracket[A]) > CLOSE and bracket[FA] != 0.0:
                    psi = next_place(bracket, 0.5 * CLOSE)
                    state_at(series, psi, state)
                    corner_distances(problem.system, problem.turns * psi, state, d[2])
                    narrow(bracket, psi, d[2, k])
                crossing, j = bracket[A] % (2.0 * math.pi), count
                while j > 0 and crossings[j - 1] > crossing:
                    crossings[j] = crossings[j - 1]
                    j -= 1
                crossings[j] = crossing
                count += 1
        copy(d[0], d[1])
    return count


@routine
def pieces_of(problem: Any, series: Floats, longest: float, first: Floats, width: Floats) -> int:
    """Write starts and lengths [rad] of pieces of a period, none above `longest`, cut at kinks; returns how many."""
    cuts = np.empty(problem.kinks * LOOKED * (problem.harmonics + 1) + 1)
    ends, count = int(crossings_of(problem, series, cuts)), 0
    if ends == 0:
        cuts[0], ends = 0.0, 1
    cuts[ends] = cuts[0] + 2.0 * math.pi
    for i in range(ends):
        length = cuts[i + 1] - cuts[i]
        parts = max(1, math.ceil(length / longest))
        for j in range(parts):
            first[count], width[count] = cuts[i] + j * length / parts, length / parts
            count += 1
    return count


def native(problem: Any, kinks: int, words: Callable[[Any], int]) -> FirstOrderAt:
    """A `FirstOrder` problem with so many kinks for machine code."""
    system, n, h = problem.system, len(problem.sizes), problem.harmonics()
    memory, parameter = words_of(system), np.zeros(1)
    if problem.leaf != STRENGTH:
        word = word_of_leaf(system, problem.leaf)
        parameter = memory.view(np.float64)[word : word + 1]
    system_at = several_at(system, words(memory), n, kinks)
    gauss, panel = np.array([PLACES, WEIGHTS]), 2.0 * math.pi * h / PHASE
    room = len(problem.angles)
    if kinks:
        room = gauss.shape[1] * (kinks * LOOKED * (h + 1) + math.ceil(panel) + 2)
    virtual = problem.leaf == STRENGTH
    return FirstOrderAt(
        system_at, parameter, problem.leaf == problem.omega_leaf, virtual, float(omega_of(system)),
        float(problem.turns), h, kinks, np.ascontiguousarray(problem.sizes), problem.steps(),
        problem.angles_of_mean() if virtual else np.empty(0), gauss,
        np.empty(room), np.empty(room), np.empty((room, n)), np.zeros(1, np.int64),
    )  # fmt: skip


def equations_of(problem: FirstOrderAt, words: Callable[[Any], int]) -> EquationsAt:
    """The equations of the problem for continuation: no preparation, and their derivative by the parameter."""
    vectors, kind = (VECTOR, VECTOR), FirstOrderAt
    functions = (kind.equations, vectors), (kind.stiffness, (VECTOR, MATRIX)), (kind.by_parameter, vectors)
    places = entries(problem, *functions)
    mean = np.zeros(2 * problem.harmonics + 1)
    return EquationsAt(words(problem), 0, places[0], places[1], places[2], mean, np.empty(0))
