"""Torque and stiffness of the springs of a harmonic balance, each over the harmonics of its own twist.

The torque of a smooth law is found by alternating frequency/time: Krack & Gross 2019, Harmonic Balance for Nonlinear
Vibration Problems, secs. 2.4 (AFT) and 3.2 (Jacobian).
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...base.results import Floats
from ...compile.calls import MATRIX, VECTOR, at, call, value
from ...compile.jit import entries, kernel_as
from ..addressed import law_at, stiffnesses, torques
from .fourier import extend_series, multiply_rows
from .linear_algebra import extremes, row_times
from .piecewise import crossings_for, is_piecewise_linear


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

    def is_sampled(self) -> bool:
        """True: the torque is sampled."""
        return True

    def torque_series(self, law: Any, z: Floats, u: Floats, r: Floats) -> None:
        """Coefficients of T(u) from the samples of u."""
        torques(law, u, self.samples)
        row_times(self.samples, self.analysis, r)

    def stiffness_product(self, law: Any, u: Floats, jacobian: Floats) -> None:
        """Matrix that multiplies a series by T'(u)."""
        h = len(self.g) // 4
        stiffnesses(law, u, self.samples)
        row_times(self.samples, self.analysis_double, self.g)
        extend_series(self.g, h, self.gc, self.gs)
        multiply_rows(self.gc, self.gs, h, self.stride, jacobian)

    def slack(self, u: Floats) -> float:
        """Middle [rad] of an orbit to which the law gives no torque at all, where any mean is in balance; else 0."""
        if self.stride > 1 or self.samples[0] != 0.0:  # as `torque_series` left them
            return 0.0
        low, high = extremes(self.samples)
        if self.samples[low] != 0.0 or self.samples[high] != 0.0:
            return 0.0
        low, high = extremes(u)
        return float(0.5 * (u[low] + u[high]))

    def hill_trace(self, law: Any, J: float, B: float, w: float, z: Floats, u: Floats, q: Floats) -> float:
        """Trace of the period map of z'' + (T'(u)/J - (B/2J)^2) z = 0 by Numerov's rule on the samples u; q: buffer."""
        steps = len(u)
        scale = (2.0 * math.pi / (self.stride * steps) / w) ** 2 / 12.0
        shift, factor = 1.0 - scale * 0.25 * (B / J) ** 2, scale / J
        stiffnesses(law, u, q)
        for i in range(steps):
            q[i] = 12.0 / (shift + factor * q[i]) - 10.0
        w0, w1, v0, v1 = 1.0, 0.0, 0.0, 1.0  # two columns of the period map
        for i in range(steps):
            w0, w1 = q[i] * w0 - w1, w0
            v0, v1 = q[i] * v0 - v1, v0
        trace = w0 + v1
        return trace if self.stride == 1 else trace * trace - 2.0  # of two equal halves


class Spring(NamedTuple):
    """A law with its torque in the balance (`Crossings` or `Sampling`) and the samples of its twist."""

    law: Any
    nonlinear: Any
    samples: Floats

    def torques(self, z: Floats, synthesis: Floats, r: Floats) -> None:
        """Write the coefficients of the torque to r from those of the twist, with which z begins."""
        self = at(self)
        row_times(z, synthesis, self.samples)
        self.nonlinear.torque_series(self.law, z, self.samples, r)

    def stiffness(self, first: int, size: int, jacobian: Floats) -> None:
        """Write their derivatives to a block on the diagonal; follows `torques` at the same twist."""
        self = at(self)
        block = jacobian[first : first + size, first : first + size]
        self.nonlinear.stiffness_product(self.law, self.samples, block)

    def slack(self) -> float:
        """Middle [rad] of an orbit in the play of the law, where any mean is in balance; 0 in contact."""
        self = at(self)
        return float(self.nonlinear.slack(self.samples))

    def hill(self, J: float, B: float, w: float, z: Floats, u: Floats, q: Floats) -> float:
        """Trace of Hill's period map along a motion z with the samples u; q is a buffer as long as u."""
        self = at(self)
        return float(self.nonlinear.hill_trace(self.law, J, B, w, z, u, q))


class Springs(NamedTuple):
    """The springs, one after the other, and the samples of the first one's twist."""

    springs: tuple[Spring, ...]
    samples: Floats

    def torques(self, size: int, z: Floats, synthesis: Floats, r: Floats) -> None:
        """Write the coefficients of the torques to r, block by block, from those of the twists in z."""
        for i, spring in enumerate(self.springs):
            spring.torques(z[i * size : (i + 1) * size + 1], synthesis, r[i * size : (i + 1) * size])

    def stiffnesses(self, size: int, jacobian: Floats) -> None:
        """Write their derivatives to the blocks on the diagonal; follows `torques` at the same twists."""
        for i, spring in enumerate(self.springs):
            spring.stiffness(i * size, size, jacobian)

    def slack(self) -> float:
        """Middle [rad] of an orbit in the play of the first law; 0 in contact."""
        return self.springs[0].slack()

    def hill(self, J: float, B: float, w: float, z: Floats, u: Floats, q: Floats) -> float:
        """Trace of Hill's period map of the first spring."""
        return self.springs[0].hill(J, B, w, z, u, q)

    def is_sampled(self) -> bool:
        """True if the torque of the first law is sampled; otherwise it is exact."""
        return bool(self.springs[0].nonlinear.is_sampled())

    def addressed(self, words: Callable[[Any], int], law_words: int = 0) -> "SpringsAt":
        """The springs for machine code; with the address of its law's words a single one, with its `hill` too."""
        rows = []
        kinds = (VECTOR, MATRIX, VECTOR), (int, int, MATRIX), (), (*[float] * 3, *[VECTOR] * 3)
        functions = Spring.torques, Spring.stiffness, Spring.slack, Spring.hill if law_words else None
        for spring in self.springs:
            native = spring._replace(law=law_at(spring.law, law_words or words(spring.law)))
            rows.append((words(native), *entries(native, *zip(functions, kinds, strict=True))))
        return SpringsAt(np.array(rows, np.int64), self.samples)


class SpringsAt(NamedTuple):
    """Springs by the addresses of their words, torques, stiffnesses, slacks and period maps (springs, 5)."""

    places: Any
    samples: Floats

    def torques(self, size: int, z: Floats, synthesis: Floats, r: Floats) -> None:
        """Write the coefficients of the torques."""
        for i in range(len(self.places)):
            block = z[i * size : (i + 1) * size + 1], synthesis, r[i * size : (i + 1) * size]
            call(self.places[i, 1], self.places[i, 0], block)

    def stiffnesses(self, size: int, jacobian: Floats) -> None:
        """Write their derivatives."""
        for i in range(len(self.places)):
            call(self.places[i, 2], self.places[i, 0], (i * size, size, jacobian))

    def slack(self) -> float:
        """Middle [rad] of an orbit in the play of the first law."""
        return value(self.places[0, 3], self.places[0, 0], ())

    def hill(self, J: float, B: float, w: float, z: Floats, u: Floats, q: Floats) -> float:
        """Trace of Hill's period map of the first spring."""
        return value(self.places[0, 4], self.places[0, 0], (J, B, w, z, u, q))


@kernel_as(lambda springs, law: springs, inline=True)
def of_law(springs: Springs, law: Any) -> Any:
    """A single spring with a law whose numbers may be others; in machine code they are in its words already."""
    return springs._replace(springs=(springs.springs[0]._replace(law=law),))


def springs_for(
    laws: tuple[Any, ...], harmonics: int, samples: int, back: Floats, double: Floats, stride: int = 1
) -> Springs:  # fmt: skip
    """The laws with their buffers; `back` and `double` are padded tables of the samples' analysis."""
    springs = []
    for law in laws:
        nonlinear: Any
        if is_piecewise_linear(law):
            nonlinear = crossings_for(law, harmonics)
        else:
            wide = np.empty(4 * harmonics + 1), np.empty(4 * harmonics + 1), np.empty(4 * harmonics + 1)
            nonlinear = Sampling(back, double, np.empty(samples), *wide, stride)
        springs.append(Spring(law, nonlinear, np.empty(samples)))
    return Springs(tuple(springs), springs[0].samples)
