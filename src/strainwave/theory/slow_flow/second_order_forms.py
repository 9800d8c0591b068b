"""Second order in closed form: a law with a square and a cube under one forcing line, resonance by resonance.

The law is T(u0 + w)/J = T(u0)/J + omega_0^2 w + c2 w^2 + c3 w^3, the first-order motion w = Re(z E) + Re(c L), E the
rotation of the fast angle and L that of the forcing line. A test derives what stands here by SymPy and compares the
two. Each form has the `numbers` of its small harmonics, as multiples of w and of v, and takes

    c2, c3   [1/(rad s^2)], [1/(rad^2 s^2)]   the law's square and cube over J
    k        [1/s^2]                          omega_0^2
    mu       [1/s]                            B/J
    w, v     [rad/s]                          speed of the base angle (of E without resonance), of L where it is free
    z, c     [rad]                            complex amplitudes on E and on L

and returns three things: the amplitudes [rad] of the small harmonics, in the order of its numbers; the amplitude
[rad/s^2] of c2 w^2 + c3 w^3 on E, the first order; and what the small harmonics add to it, the second. They serve
numbers and arrays.
"""

from fractions import Fraction
from typing import Any, NamedTuple

from ...compile.jit import kernel

Numbers = tuple[tuple[int, int], ...]


@kernel
def answer(force: Any, k: Any, mu: Any, speed: Any) -> Any:
    """Harmonic [rad] that a harmonic of the torque over J [rad/s^2] drives at a speed [rad/s]."""
    return -force / (k - speed * speed + 1j * mu * speed)


@kernel
def _square(z: Any) -> Any:
    return z.real * z.real + z.imag * z.imag


def _of_one_angle(*multiples: int) -> Numbers:
    return tuple((m, 0) for m in multiples)


class Primary(NamedTuple):
    """The line is on E."""

    numbers: Numbers = _of_one_angle(0, 2, 3)

    def values(self, c2: Any, c3: Any, k: Any, mu: Any, w: Any, _v: Any, z: Any, _c: Any) -> Any:
        """Small harmonics, and what is on E [rad/s^2] at first and at second order."""
        zz = _square(z)
        w0 = -0.5 * c2 * zz / k
        w2 = answer(0.5 * c2 * z * z, k, mu, 2.0 * w)
        w3 = answer(0.25 * c3 * z * z * z, k, mu, 3.0 * w)
        y = z.conjugate()
        back = c2 * (2.0 * w0 * z + w2 * y) + 0.75 * c3 * w3 * y * y
        return (w0, w2, w3), 0.75 * c3 * zz * z, back


class Superharmonic(NamedTuple):
    """E = L^3."""

    numbers: Numbers = _of_one_angle(0, 1, 2, 4, 5, 6, 7, 9)

    def values(self, c2: Any, c3: Any, k: Any, mu: Any, w: Any, _v: Any, z: Any, c: Any) -> Any:
        """Small harmonics, and what is on E [rad/s^2] at first and at second order."""
        y, d, zz, cc = z.conjugate(), c.conjugate(), _square(z), _square(c)
        w0 = -0.5 * c2 * (cc + zz) / k
        w1 = answer(0.75 * c3 * (cc * c + 2.0 * zz * c + d * d * z) + 1j * mu * w * c, k, mu, w)
        w2 = answer(c2 * (0.5 * c * c + d * z), k, mu, 2.0 * w)
        w4 = answer(c2 * c * z, k, mu, 4.0 * w)
        w5 = answer(0.75 * c3 * (c * c + d * z) * z, k, mu, 5.0 * w)
        w6 = answer(0.5 * c2 * z * z, k, mu, 6.0 * w)
        w7 = answer(0.75 * c3 * c * z * z, k, mu, 7.0 * w)
        w9 = answer(0.25 * c3 * z * z * z, k, mu, 9.0 * w)
        by_square = c * w2 + d * w4 + 2.0 * w0 * z + w6 * y
        by_cube = (c * c + 2.0 * d * z) * w1 + 2.0 * c * z * w1.conjugate() + (2.0 * c * y + d * d) * w5
        by_cube = by_cube + 2.0 * d * y * w7 + y * y * w9
        on_fast = c3 * (0.25 * c * c * c + 1.5 * cc * z + 0.75 * zz * z)
        return (w0, w1, w2, w4, w5, w6, w7, w9), on_fast, c2 * by_square + 0.75 * c3 * by_cube


class Subharmonic(NamedTuple):
    """L = E^3."""

    numbers: Numbers = _of_one_angle(0, 2, 3, 4, 5, 6, 7, 9)

    def values(self, c2: Any, c3: Any, k: Any, mu: Any, w: Any, _v: Any, z: Any, c: Any) -> Any:
        """Small harmonics, and what is on E [rad/s^2] at first and at second order."""
        y, d, zz, cc = z.conjugate(), c.conjugate(), _square(z), _square(c)
        w0 = -0.5 * c2 * (cc + zz) / k
        w2 = answer(c2 * (c * y + 0.5 * z * z), k, mu, 2.0 * w)
        w3 = answer(c3 * (0.75 * cc * c + 1.5 * zz * c + 0.25 * z * z * z) + 3j * mu * w * c, k, mu, 3.0 * w)
        w4 = answer(c2 * c * z, k, mu, 4.0 * w)
        w5 = answer(0.75 * c3 * (c * y + z * z) * c, k, mu, 5.0 * w)
        w6 = answer(0.5 * c2 * c * c, k, mu, 6.0 * w)
        w7 = answer(0.75 * c3 * c * c * z, k, mu, 7.0 * w)
        w9 = answer(0.25 * c3 * c * c * c, k, mu, 9.0 * w)
        by_square = c * w2.conjugate() + d * w4 + 2.0 * w0 * z + w2 * y
        by_cube = 2.0 * c * z * w3.conjugate() + (2.0 * d * z + y * y) * w3
        by_cube = by_cube + c * c * w5.conjugate() + 2.0 * d * y * w5 + d * d * w7
        on_fast = c3 * (1.5 * cc * z + 0.75 * c * y * y + 0.75 * zz * z)
        return (w0, w2, w3, w4, w5, w6, w7, w9), on_fast, c2 * by_square + 0.75 * c3 * by_cube


class Twofold(NamedTuple):
    """E = L^2, the superharmonic of a square."""

    numbers: Numbers = _of_one_angle(0, 1, 3, 4, 5, 6)

    def values(self, c2: Any, c3: Any, k: Any, mu: Any, w: Any, _v: Any, z: Any, c: Any) -> Any:
        """Small harmonics, and what is on E [rad/s^2] at first and at second order."""
        y, d, zz, cc = z.conjugate(), c.conjugate(), _square(z), _square(c)
        w0 = -(0.5 * c2 * (cc + zz) + 0.75 * c3 * (c * c * y).real) / k
        w1 = answer(c2 * d * z + c3 * (0.75 * cc + 1.5 * zz) * c + 1j * mu * w * c, k, mu, w)
        w3 = answer(c2 * c * z + c3 * (0.25 * c * c * c + 0.75 * d * z * z), k, mu, 3.0 * w)
        w4 = answer((0.75 * c3 * c * c + 0.5 * c2 * z) * z, k, mu, 4.0 * w)
        w5 = answer(0.75 * c3 * c * z * z, k, mu, 5.0 * w)
        w6 = answer(0.25 * c3 * z * z * z, k, mu, 6.0 * w)
        by_square = c * w1 + d * w3 + 2.0 * w0 * z + w4 * y
        by_cube = 2.0 * c * z * w1.conjugate() + 2.0 * d * z * w1 + 2.0 * c * c * w0 + 2.0 * c * y * w3
        by_cube = by_cube + d * d * w4 + 2.0 * d * y * w5 + y * y * w6
        on_fast = 0.5 * c2 * c * c + c3 * (1.5 * cc * z + 0.75 * zz * z)
        return (w0, w1, w3, w4, w5, w6), on_fast, c2 * by_square + 0.75 * c3 * by_cube


class Half(NamedTuple):
    """L = E^2, the subharmonic of a square."""

    numbers: Numbers = _of_one_angle(0, 2, 3, 4, 5, 6)

    def values(self, c2: Any, c3: Any, k: Any, mu: Any, w: Any, _v: Any, z: Any, c: Any) -> Any:
        """Small harmonics, and what is on E [rad/s^2] at first and at second order."""
        y, d, zz, cc = z.conjugate(), c.conjugate(), _square(z), _square(c)
        w0 = -(0.5 * c2 * (cc + zz) + 0.75 * c3 * (d * z * z).real) / k
        w2 = answer(0.5 * c2 * z * z + c3 * (0.75 * cc + 1.5 * zz) * c + 2j * mu * w * c, k, mu, 2.0 * w)
        w3 = answer(c2 * c * z + c3 * (0.75 * c * c * y + 0.25 * z * z * z), k, mu, 3.0 * w)
        w4 = answer((0.5 * c2 * c + 0.75 * c3 * z * z) * c, k, mu, 4.0 * w)
        w5 = answer(0.75 * c3 * c * c * z, k, mu, 5.0 * w)
        w6 = answer(0.25 * c3 * c * c * c, k, mu, 6.0 * w)
        by_square = d * w3 + 2.0 * w0 * z + w2 * y
        by_cube = 2.0 * c * z * w2.conjugate() + 2.0 * d * z * w2 + c * c * w3.conjugate() + y * y * w3
        by_cube = by_cube + 4.0 * c * y * w0 + d * d * w5 + 2.0 * d * y * w4
        on_fast = c2 * c * y + c3 * (1.5 * cc * z + 0.75 * zz * z)
        return (w0, w2, w3, w4, w5, w6), on_fast, c2 * by_square + 0.75 * c3 * by_cube


class Nonresonant(NamedTuple):
    """E and L turn freely."""

    numbers: Numbers = (
        (0, 0), (0, 1), (0, 2), (0, 3), (1, -2), (1, -1), (1, 1), (1, 2), (2, -1), (2, 0), (2, 1), (3, 0),
    )  # fmt: skip

    def values(self, c2: Any, c3: Any, k: Any, mu: Any, w: Any, v: Any, z: Any, c: Any) -> Any:
        """Small harmonics, and what is on E [rad/s^2] at first and at second order."""
        y, d, zz, cc = z.conjugate(), c.conjugate(), _square(z), _square(c)
        w00 = -0.5 * c2 * (cc + zz) / k
        w01 = answer(c3 * (0.75 * cc + 1.5 * zz) * c + 1j * mu * v * c, k, mu, v)
        w02 = answer(0.5 * c2 * c * c, k, mu, 2.0 * v)
        w03 = answer(0.25 * c3 * c * c * c, k, mu, 3.0 * v)
        w1m2 = answer(0.75 * c3 * d * d * z, k, mu, w - 2.0 * v)
        w1m1 = answer(c2 * d * z, k, mu, w - v)
        w11 = answer(c2 * c * z, k, mu, w + v)
        w12 = answer(0.75 * c3 * c * c * z, k, mu, w + 2.0 * v)
        w2m1 = answer(0.75 * c3 * d * z * z, k, mu, 2.0 * w - v)
        w20 = answer(0.5 * c2 * z * z, k, mu, 2.0 * w)
        w21 = answer(0.75 * c3 * c * z * z, k, mu, 2.0 * w + v)
        w30 = answer(0.25 * c3 * z * z * z, k, mu, 3.0 * w)
        by_square = c * w1m1 + d * w11 + 2.0 * w00 * z + w20 * y
        by_cube = 2.0 * c * z * w01.conjugate() + 2.0 * d * z * w01 + c * c * w1m2 + 2.0 * c * y * w2m1
        by_cube = by_cube + d * d * w12 + 2.0 * d * y * w21 + y * y * w30
        small = (w00, w01, w02, w03, w1m2, w1m1, w11, w12, w2m1, w20, w21, w30)
        on_fast = c3 * (1.5 * cc * z + 0.75 * zz * z)
        return small, on_fast, c2 * by_square + 0.75 * c3 * by_cube


FORMS: dict[Fraction | None, Any] = {
    Fraction(1): Primary(),
    Fraction(3): Superharmonic(),
    Fraction(1, 3): Subharmonic(),
    Fraction(2): Twofold(),
    Fraction(1, 2): Half(),
    None: Nonresonant(),
}
