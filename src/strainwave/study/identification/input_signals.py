"""`Signal`: a measured quantity inside a model, and the polynomials that it is between two samples."""

from typing import Any, Literal, NamedTuple

import numpy as np

from ...base.results import Floats

Between = Literal["band-limited", "linear", "held"]
TAPS = 48  # samples to either side that a band-limited value is made of
WIDTH = 8.0  # of the Gaussian window in samples: 80 % of half the sample rate passes with an error of 3e-6
START, COEFFICIENTS, DEGREE = 5, 6, 5  # places of a `Signal`'s leaves, and the degree of its polynomial


class Signal(NamedTuple):
    """offset + gain u(t - delay), u being a polynomial of s = (t - start)/length of the piece, t = angle/omega.

    It stands for a torque or for a motion. Whoever integrates writes `start` and the coefficients c0 ... c5 of each
    piece; of the delay they hold all but a small rest, so that u(t - delay) = u(t) - delay u'(t).
    """

    gain: float = 1.0
    offset: float = 0.0
    delay: float = 0.0
    per_omega: float = 1.0
    per_length: float = 1.0
    start: float = 0.0
    c0: float = 0.0
    c1: float = 0.0
    c2: float = 0.0
    c3: float = 0.0
    c4: float = 0.0
    c5: float = 0.0

    def torque(self, angle: Any) -> Any:
        """Torque at the base angle [rad]."""
        return self.value(angle)

    def value(self, angle: Any) -> Any:
        """Value at the base angle [rad]."""
        s = (angle * self.per_omega - self.start) * self.per_length
        u = self.c0 + s * (self.c1 + s * (self.c2 + s * (self.c3 + s * (self.c4 + s * self.c5))))
        return self.offset + self.gain * (u - self.delay * self.per_length * self.rate(s))

    def slope(self, angle: Any) -> Any:
        """Derivative by the base angle."""
        s = (angle * self.per_omega - self.start) * self.per_length
        rate = self.rate(s) - self.delay * self.per_length * self.bend(s)
        return self.gain * self.per_length * self.per_omega * rate

    def curvature(self, angle: Any) -> Any:
        """Second derivative by the base angle."""
        per_angle = self.per_length * self.per_omega
        return self.gain * per_angle * per_angle * self.bend((angle * self.per_omega - self.start) * self.per_length)

    def rate(self, s: Any) -> Any:
        """Derivative of u by s."""
        return self.c1 + s * (2.0 * self.c2 + s * (3.0 * self.c3 + s * (4.0 * self.c4 + s * 5.0 * self.c5)))

    def bend(self, s: Any) -> Any:
        """Second derivative of u by s."""
        return 2.0 * self.c2 + s * (6.0 * self.c3 + s * (12.0 * self.c4 + s * 20.0 * self.c5))

    def orders(self) -> tuple[int, ...]:
        """None: it repeats with no angle."""
        return ()

    def scaled(self, factor: Any) -> "Signal":
        """The same signal times a factor."""
        return self._replace(gain=self.gain * factor, offset=self.offset * factor)


def places_of(model: Any) -> list[int]:
    """Place of the first leaf of each `Signal` among the leaves of a model."""
    places, _ = _places(model, 0)
    return places


def _places(thing: Any, leaf: int) -> tuple[list[int], int]:
    if isinstance(thing, Signal):
        return [leaf], leaf + len(thing)
    if isinstance(thing, tuple):
        places: list[int] = []
        for item in thing:
            inner, leaf = _places(item, leaf)
            places += inner
        return places, leaf
    return [], leaf if isinstance(thing, int | np.integer) else leaf + 1


def pieces(samples: Floats, parts: int, between: Between, delay: float = 0.0) -> Floats:
    """Polynomials (parts (n - 1), 6) of a signal, `parts` equal pieces between two samples, ascending powers of s.

    Band-limited, a piece is the polynomial of fifth degree with the values, slopes and curvatures at its ends of the
    sinc series with a Gaussian window; held or linear, it is just that.

    Parameters
    ----------
    samples : (n,) array
        At equal distances.
    parts : int
        Pieces between two samples.
    between : {"band-limited", "linear", "held"}
        What the signal does there.
    delay : float
        In samples; before the first sample the signal goes on by its point reflection there.
    """
    nodes = np.arange(parts * (len(samples) - 1) + 1) / parts - delay
    table = np.zeros((len(nodes) - 1, DEGREE + 1))
    if between == "held":
        table[:, 0] = samples[np.clip(np.floor(nodes[:-1] + 1e-9), 0, len(samples) - 1).astype(int)]
        return table
    if between == "linear":
        values = np.interp(nodes, np.arange(len(samples)), samples)
        table[:, 0], table[:, 1] = values[:-1], np.diff(values)
        return table
    u, du, ddu = resampled(samples, parts, delay)
    du, ddu = du / parts, ddu / parts**2
    rise, c, d, e, f = np.diff(u), du[:-1], du[1:], ddu[:-1], ddu[1:]
    table[:, 0], table[:, 1], table[:, 2] = u[:-1], c, 0.5 * e
    table[:, 3] = 10.0 * rise - 6.0 * c - 4.0 * d - 1.5 * e + 0.5 * f
    table[:, 4] = -15.0 * rise + 8.0 * c + 7.0 * d + 1.5 * e - f
    table[:, 5] = 6.0 * rise - 3.0 * (c + d) - 0.5 * (e - f)
    return table


def resampled(samples: Floats, parts: int = 1, delay: float = 0.0) -> tuple[Floats, Floats, Floats]:
    """Values of a band-limited signal and its first two derivatives by samples, at k/parts - delay, k = 0 ... .

    The straight line through both ends is taken out before and put back after.
    """
    n = len(samples)
    line = samples[0] + (samples[-1] - samples[0]) * np.arange(n) / max(n - 1, 1)
    remainder = samples - line
    shift = int(np.floor(-delay))
    reach = TAPS + 1 + abs(shift)
    around = _reflected(remainder, reach)
    count = parts * (n - 1) + 1
    table = np.empty((3, count))
    for k in range(parts):
        extra, fraction = divmod(k / parts - delay - shift, 1.0)
        first = reach + shift + int(extra) - TAPS
        many = -(-(count - k) // parts)
        stretch = around[first : first + many + 2 * TAPS]
        for row, weights in zip(table, _weights(fraction), strict=True):
            row[k::parts] = np.convolve(stretch, weights[::-1], "valid")
    slope = (samples[-1] - samples[0]) / max(n - 1, 1)
    table[0] += samples[0] + slope * (np.arange(count) / parts - delay)
    table[1] += slope
    return table[0], table[1], table[2]


def _reflected(remainder: Floats, reach: int) -> Floats:
    """A signal that is 0 at both ends, with its point reflections before and after."""
    turn = np.concatenate([remainder[:-1], -remainder[:0:-1]]) if len(remainder) > 1 else np.zeros(1)
    return turn[np.arange(-reach, len(remainder) + reach) % len(turn)]


def _weights(fraction: float) -> Floats:
    """Weights (3, 2 TAPS + 1) of the samples around, at a fraction of a sample: value, first and second derivative."""
    x = fraction - np.arange(-TAPS, TAPS + 1)
    small = np.abs(x) < 1e-6
    z = np.where(small, 1.0, x)
    sinc = np.sinc(x)
    first = np.where(small, -(np.pi**2) * x / 3.0, (np.cos(np.pi * z) - sinc) / z)
    second = np.where(small, -(np.pi**2) / 3.0, -(np.pi**2) * sinc - 2.0 * first / z)
    window = np.exp(-0.5 * (x / WIDTH) ** 2)
    slope, bend = -x / WIDTH**2 * window, (x * x / WIDTH**4 - 1.0 / WIDTH**2) * window
    values = sinc * window
    return np.array(
        [values / np.sum(values), first * window + sinc * slope, second * window + 2.0 * first * slope + sinc * bend]
    )
