"""The torque of a smooth law in the balance equations, by alternating frequency/time.

Krack & Gross 2019, Harmonic Balance for Nonlinear Vibration Problems, secs. 2.4 (AFT) and 3.2 (Jacobian).
"""

import math
from typing import Any, NamedTuple

from ...results import Floats
from ..addressed import stiffnesses, torques
from .fourier import extend_series, multiply_rows
from .linear_algebra import extremes, row_times


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
        """Whether the torque is sampled: yes."""
        return True

    def torque_series(self, law: Any, z: Any, u: Any, r: Any) -> None:
        """Coefficients of T(u) from the samples of u."""
        torques(law, u, self.samples)
        row_times(self.samples, self.analysis, r)

    def stiffness_product(self, law: Any, u: Any, jacobian: Any) -> None:
        """Matrix that multiplies a series by T'(u)."""
        h = len(self.g) // 4
        stiffnesses(law, u, self.samples)
        row_times(self.samples, self.analysis_double, self.g)
        extend_series(self.g, h, self.gc, self.gs)
        multiply_rows(self.gc, self.gs, h, self.stride, jacobian)

    def slack(self, u: Any) -> float:
        """Middle [rad] of an orbit to which the law gives no torque at all, where any mean is in balance; else 0."""
        if self.stride > 1 or self.samples[0] != 0.0:  # as `torque_series` left them
            return 0.0
        low, high = extremes(self.samples)
        if self.samples[low] != 0.0 or self.samples[high] != 0.0:
            return 0.0
        low, high = extremes(u)
        return float(0.5 * (u[low] + u[high]))

    def hill_trace(self, law: Any, J: float, B: float, w: float, z: Any, u: Any, q: Any) -> float:
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
