"""Pieces of a trajectory between two instants, as the measures of an ensemble see them: branch-free vector code."""

from typing import Any, NamedTuple

import numpy as np

from ...base.law import class_of
from ...base.quantities import States
from ...base.results import Floats
from ...compile.elementwise import larger, smaller
from ...compile.jit import chosen, kernel, kernel_as
from ...compile.maths_kernels import bits_of, float_of

ROUND = 1.5 * 2.0**52  # adding and subtracting it rounds to a whole number
LOG_OF_ONE = 2.0**20 + 1023.0  # what `_log2_by_bits` makes of the bits of 1


class Whole(NamedTuple):
    """Rule of a `Piece` whose integral is wanted by itself."""


class Even(NamedTuple):
    """Rule of a `Piece` that is one of many of one width: its integral is width times the value at its end."""


class Ends(NamedTuple):
    """Rule of a `Piece` that spans many even ones, of their width: its integral is what their sum lacks."""


class Piece(NamedTuple):
    """A stretch of a trajectory between two instants: phase, first state and its rate there, and what lies between.

    `rule` (`Whole`, `Even` or `Ends`) says how integrals over it are formed, `width` is its time [s], `omega` the base
    frequency [rad/s], `extreme` the extreme value of the first state inside, or any value there where it has none.
    """

    rule: Any
    phase0: Any
    x0: Any
    v0: Any
    phase1: Any
    x1: Any
    v1: Any
    width: Any
    omega: Any
    extreme: Any


@chosen
def integral(rule: Any, width: Any, f0: Any, slope0: Any, f1: Any, slope1: Any) -> Any:
    """Integral over a piece of this width of the cubic with these values and slopes at its ends (fourth order).

    Over even pieces all but the values cancel in the sum, up to the `Ends`.
    """
    return {Whole: _whole_integral, Even: _even_integral, Ends: _ends_integral}[class_of(rule)]


def _whole_integral(rule: Any, width: Floats, f0: Floats, slope0: Any, f1: Any, slope1: Any) -> Any:
    return width * (0.5 * (f0 + f1) + width / 12.0 * (slope0 - slope1))


def _even_integral(rule: Any, width: Floats, f0: Floats, slope0: Any, f1: Any, slope1: Any) -> Any:
    return width * f1


def _ends_integral(rule: Any, width: Floats, f0: Floats, slope0: Any, f1: Any, slope1: Any) -> Any:
    return width * (0.5 * (f0 - f1) + width / 12.0 * (slope0 - slope1))


@chosen
def harmonic_integrals(rule: Any, piece: Any, rate: Any, c0: Any, s0: Any, c1: Any, s1: Any) -> Any:
    """Choose, by the class of `rule`, the integrals of x cos and x sin over a piece at a rate of the angle.

    Cosine and sine are c0, s0 at the start and c1, s1 at the end. `Whole` integrates the chord of x exactly, however
    far the cosine turns meanwhile; `Even` and `Ends` are the trapezoidal sum and its ends.
    """
    return {Whole: _whole_harmonic, Even: _summed_harmonic, Ends: _summed_harmonic}[class_of(rule)]


def _summed_harmonic(rule: Any, piece: Piece, rate: Any, c0: Any, s0: Any, c1: Any, s1: Any) -> Any:
    x0, v0, x1, v1, width = piece.x0, piece.v0, piece.x1, piece.v1, piece.width
    even = integral(rule, width, x0 * c0, v0 * c0 - rate * x0 * s0, x1 * c1, v1 * c1 - rate * x1 * s1)
    odd = integral(rule, width, x0 * s0, v0 * s0 + rate * x0 * c0, x1 * s1, v1 * s1 + rate * x1 * c1)
    return even, odd


def _whole_harmonic(rule: Any, piece: Piece, rate: Any, c0: Any, s0: Any, c1: Any, s1: Any) -> Any:
    x0, x1, width = piece.x0, piece.x1, piece.width
    line = (x1 - x0) / larger(width, 1e-300)
    d0, d1, part = piece.v0 - line, piece.v1 - line, width * width / 12.0
    even = (x1 * s1 - x0 * s0 + line * (c1 - c0) / rate) / rate + part * (d0 * c0 - d1 * c1)
    odd = (x0 * c0 - x1 * c1 + line * (s1 - s0) / rate) / rate + part * (d0 * s0 - d1 * s1)
    return even, odd


@chosen
def updated(measures: Any, sums: Any, piece: Piece) -> Any:
    """Sums of several measures (tuples) after a piece."""
    return _first_and_rest if len(measures) else _nothing


def _first_and_rest(measures: Any, sums: Any, piece: Piece) -> Any:
    return (measures[0].update(sums[0], piece), *updated(measures[1:], sums[1:], piece))


def _nothing(measures: Any, sums: Any, piece: Piece) -> Any:
    return ()


def _one_over_by_bits(x: Any) -> Any:
    r = float_of(0x7FDE623822FC16E6 - bits_of(x))
    return r * (2.0 - x * r)


@kernel_as(_one_over_by_bits, inline=True)
def about_one_over(x: Floats) -> Any:
    """1/x of a positive number to 2 %, in a fifth of the time of a division."""
    return 1.0 / x


def _log2_by_bits(x: Any) -> Any:
    # 2^52 + 2^32 (1023 + logarithm): no integer is converted
    shifted = float_of((bits_of(x) >> 20) | 0x4330000000000000)
    return shifted * 2.0**-32 - LOG_OF_ONE


@kernel_as(_log2_by_bits, inline=True)
def about_log2(x: Floats) -> Any:
    """Binary logarithm of a positive number to 0.09: the straight line between powers of two, which its bits are."""
    return np.log2(x)


def _two_to_by_bits(x: Any) -> Any:
    n = (x + ROUND) - ROUND
    r = x - n
    return float_of((bits_of(n + ROUND) + 1023) << 52) * (1.0 + r * (0.6931 + r * (0.2402 + r * 0.0555)))


@kernel_as(_two_to_by_bits, inline=True)
def about_two_to(x: Floats) -> Any:
    """2^x to 0.1 %, for x from -1022 to 1023."""
    return np.exp2(x)


@kernel
def vertex(x0: Any, v0: Any, x1: Any, v1: Any, h: Any) -> Any:
    """Value of the cubic through two points with rates v, h apart, where the rate passes zero between them.

    Branch-free: the place is where the straight line through both rates vanishes; an error in it counts by its square.
    Where the rate keeps its sign, a value between those of the points.
    """
    s = abs(v0) * about_one_over(abs(v0) + 1e-290 + abs(v1))  # 0 at rest
    r, rise = 1.0 - s, x1 - x0
    return x0 + s * (rise + r * ((h * v0 - rise) * r - (h * v1 - rise) * s))


@kernel
def smooth_vertex(x0: Any, v0: Any, a0: Any, x1: Any, v1: Any, a1: Any, h: Any) -> Any:
    """`vertex` of the quintic through two points with rates v and accelerations a, for the long steps of high order."""
    fall = v0 - v1
    square = fall * fall
    rough = about_one_over(square)
    per_fall = fall * (rough * (2.0 - square * rough))
    s = smaller(larger(v0 * per_fall, 0.0), 1.0)
    r = 1.0 - s
    v = v0 - s * fall + s * r * ((h * a0 + fall) * r - (h * a1 + fall) * s)  # of the cubic through the rates
    s = smaller(larger(s + v * per_fall, 0.0), 1.0)
    r, rise = 1.0 - s, x1 - x0
    cubic = x0 + s * (rise + r * ((h * v0 - rise) * r - (h * v1 - rise) * s))
    bend0 = h * h * a0 - 6.0 * rise + 4.0 * h * v0 + 2.0 * h * v1
    bend1 = h * h * a1 + 6.0 * rise - 2.0 * h * v0 - 4.0 * h * v1
    return cubic + 0.5 * s * s * r * r * (bend0 * r + bend1 * s)


class Smooth(NamedTuple):
    """Kind of a system whose second state is the rate of the first."""

    def extreme(self, y: States, rate: States, y1: States, rate1: States, h: Any) -> Any:
        """Extreme value of the first state between two instants h [s] apart, with the rates of all states there."""
        return smooth_vertex(y[0], rate[0], rate[1], y1[0], rate1[0], rate1[1], h)


class General(NamedTuple):
    """Kind of a system of whose states nothing is known."""

    def extreme(self, y: States, rate: States, y1: States, rate1: States, h: Any) -> Any:
        """Extreme value of the first state, as `Smooth` has it."""
        return vertex(y[0], rate[0], y1[0], rate1[0], h)
