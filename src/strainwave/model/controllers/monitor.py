"""Monitors: amplitude and phase of orders in a signal at a known angle, and frequency where no angle is known.

A monitor is a NamedTuple of floats with `start()` and, like a controller, an update from sample to sample.
"""

from math import log
from typing import Any, NamedTuple

from ...base.quantities import AngularSpeed, Reals, States, Time
from ...compile.elementwise import larger, smaller
from ...compile.maths import cos, sin, sqrt
from .loops import number_or_zero


class Average(NamedTuple):
    """Mean of a signal, with the rate at which it follows [1/s]: the innermost of nested demodulators."""

    bandwidth: AngularSpeed
    period: Time

    def start(self) -> Any:
        """Memory before the first sample: the mean."""
        return (0.0,)

    def expected(self, state: States, _angle: Reals) -> Any:
        """Expected signal at an angle [rad]."""
        return state[0]

    def corrected(self, state: States, _angle: Reals, innovation: Reals) -> Any:
        """Memory after a sample that is off what was expected."""
        return (state[0] + self.period * self.bandwidth * innovation,)

    def written(self, state: Any, out: Any, k: Any) -> Any:
        """Write the mean to row 0 of column k; return the next row."""
        out[0, k] = state[0]
        return 1


class Demodulator(NamedTuple):
    """Cosine and sine amplitude of an order of the angle in a signal: c cos(k angle) + s sin(k angle).

    c' = 2 b cos(k angle) e and s' = 2 b sin(k angle) e, with the rate b = `bandwidth` [1/s] and e the signal less what
    is expected. `below` is what else is in the signal: another `Demodulator`, and innermost an `Average`. All orders
    share e, so that none leaks into another where the signal has no more than these.

    An amplitude converges as exp(-b t) for b well below the distance of the orders. White noise of variance s^2 in the
    signal gives c and s the variance `noise_gain` s^2 = b h s^2, h the period. An amplitude that grows with a rate r
    lags by r/b.
    """

    below: Any
    bandwidth: AngularSpeed
    period: Time
    order: int = 2

    def start(self) -> Any:
        """Memory before the first sample: that of `below`, c and s."""
        return self.below.start(), 0.0, 0.0

    def expected(self, state: Any, angle: Reals) -> Any:
        """Expected signal at an angle [rad]."""
        turn = self.order * angle
        return self.below.expected(state[0], angle) + state[1] * cos(turn) + state[2] * sin(turn)

    def corrected(self, state: Any, angle: Reals, innovation: Reals) -> Any:
        """Memory after a sample that is off what was expected."""
        turn, step = self.order * angle, 2.0 * self.period * self.bandwidth * innovation
        below = self.below.corrected(state[0], angle, innovation)
        return below, state[1] + step * cos(turn), state[2] + step * sin(turn)

    def update(self, state: Any, angle: Reals, signal: Reals) -> Any:
        """Memory after a sample at an angle [rad]; a NaN leaves it as it is."""
        return self.corrected(state, angle, number_or_zero(signal - self.expected(state, angle)))

    def written(self, state: Any, out: Any, k: Any) -> Any:
        """Write what is below, c and s to column k, row by row; return the next row."""
        row = self.below.written(state[0], out, k)
        out[row, k] = state[1]
        out[row + 1, k] = state[2]
        return row + 2

    def settling(self, share: float = 0.01) -> float:
        """Time [s] after which a share of the first error is left."""
        return -log(share) / self.bandwidth

    def noise_gain(self) -> float:
        """Variance of c and of s over the variance of white noise in the signal."""
        return self.bandwidth * self.period

    def check(self) -> None:
        """Refuse a rate that is not positive or too quick for the samples, and an order below 1 (ValueError)."""
        together, inner = 2.0 * self.bandwidth, self.below
        while not isinstance(inner, Average):
            together, inner = together + 2.0 * inner.bandwidth, inner.below
        together += inner.bandwidth
        if not self.bandwidth > 0.0 or not together * self.period < 1.0:
            raise ValueError(
                f"Demodulator.bandwidth is {self.bandwidth:g} 1/s, with all orders {together:g} 1/s; it must be above "
                f"0 and together below the rate of samples, {1.0 / self.period:g} 1/s"
            )
        if self.order < 1:
            raise ValueError(f"Demodulator.order is {self.order}; it must be at least 1")


class Tracker(NamedTuple):
    """Frequency, amplitude and phase of the strongest line of a signal whose angle is not known.

    An oscillator (v, q) of the frequency w is kept on the signal: e is the signal less v and its mean m. v grows
    by g w e, and w by -r g w e q/(v^2 + q^2): a second-order generalised integrator with a frequency-locked loop
    (Rodriguez, Luna, Candela, Mujal, Teodorescu & Blaabjerg, Multiresonant frequency-locked loop for grid
    synchronization of power converters under distorted grid conditions, IEEE Trans. Ind. Electron. 58(1), 2011,
    127-138). With the gain g the amplitude converges with the rate b = g w/2, and the frequency with the slower root of
    s^2 + b (s + r), which is the rate r where r is well below b/4. w stays between `low` and `high` [rad/s]; it finds a
    line within that range.

    In a run-up, whose frequency grows by a [rad/s^2], the phase lags by a/(r b) and the frequency by a/r: with the
    phase error d and the frequency error f, d' = f - b d and f' = a - r b d. White noise of variance s^2 in the
    signal gives the amplitude A the variance `noise_gain` s^2 = b h s^2, h the period, and the frequency r^2 b h
    s^2/A^2.
    """

    low: AngularSpeed
    high: AngularSpeed
    rate: AngularSpeed
    period: Time
    gain: Any = 0.3

    def start(self) -> Any:
        """Memory before the first sample: v, q, m and the frequency [rad/s], in the middle of its range."""
        return 0.0, 0.0, 0.0, 0.5 * (self.low + self.high)

    def update(self, state: States, signal: Reals) -> Any:
        """Memory after a sample: v, q, m and the frequency [rad/s]; over a NaN the oscillator goes on."""
        v0, q0, mean, w = state
        c, s = cos(w * self.period), sin(w * self.period)
        v, q = c * v0 - s * q0, s * v0 + c * q0
        e = number_or_zero(signal - v - mean)
        step = self.gain * w * self.period * e
        size = v * v + q * q
        turned = self.rate * self.gain * w * self.period * e * q / larger(size, 1e-300)
        w = larger(smaller(w - turned, self.high), self.low)
        return v + step, q, mean + 0.2 * step, w

    def amplitude(self, state: States) -> Any:
        """Amplitude, 0 to peak, of the line."""
        return sqrt(state[0] * state[0] + state[1] * state[1])

    def settling(self, share: float = 0.01, omega: float | None = None) -> float:
        """Time [s] after which a share of a small first error of frequency and amplitude is left.

        `omega` is the frequency of the line [rad/s]; by default that end of the range where it takes longer.
        """
        if omega is None:
            return max(self.settling(share, self.low), self.settling(share, self.high))
        b = 0.5 * self.gain * omega
        return -2.0 * log(share) / float(b - sqrt(larger(b * b - 4.0 * b * self.rate, 0.0)))

    def noise_gain(self, omega: float) -> float:
        """Variance of the amplitude over that of white noise in the signal, at the line's frequency `omega` [rad/s]."""
        return float(0.5 * self.gain * omega * self.period)

    def check(self) -> None:
        """Refuse a range without width, and samples too slow for it (ValueError)."""
        if not 0.0 < self.low < self.high:
            raise ValueError(f"Tracker goes from {self.low:g} to {self.high:g} rad/s; 0 < low < high is required")
        if not self.high * self.period < 1.0:
            raise ValueError(
                f"Tracker.high is {self.high:g} rad/s; samples every {self.period:g} s follow up to "
                f"{1.0 / self.period:g} rad/s"
            )
