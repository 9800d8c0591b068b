"""Forces of a predictor by the formulas of second order, for a law with a square and a cube under one line.

There is a class for each formula of `second_order_forms`, so that compiled code finds it by its type.
"""

from typing import Any, NamedTuple

from ....compile.jit import kernel
from ..second_order_forms import half, nonresonant, primary, subharmonic, superharmonic, twofold
from .forces import fast_speed, hard, power, soft, turned, with_inertia

STEP = 1e-6  # of the amplitude: forward differences


class Primary(NamedTuple):
    """The line is on E."""

    def values(self, c2: Any, c3: Any, k: Any, mu: Any, w: Any, v: Any, z: Any, c: Any) -> Any:
        """Small harmonics, and what is on E [rad/s^2] at first and at second order."""
        return primary(c2, c3, k, mu, w, v, z, c)


class Superharmonic(NamedTuple):
    """E = L^3."""

    def values(self, c2: Any, c3: Any, k: Any, mu: Any, w: Any, v: Any, z: Any, c: Any) -> Any:
        """Small harmonics, and what is on E [rad/s^2] at first and at second order."""
        return superharmonic(c2, c3, k, mu, w, v, z, c)


class Subharmonic(NamedTuple):
    """L = E^3."""

    def values(self, c2: Any, c3: Any, k: Any, mu: Any, w: Any, v: Any, z: Any, c: Any) -> Any:
        """Small harmonics, and what is on E [rad/s^2] at first and at second order."""
        return subharmonic(c2, c3, k, mu, w, v, z, c)


class Twofold(NamedTuple):
    """E = L^2."""

    def values(self, c2: Any, c3: Any, k: Any, mu: Any, w: Any, v: Any, z: Any, c: Any) -> Any:
        """Small harmonics, and what is on E [rad/s^2] at first and at second order."""
        return twofold(c2, c3, k, mu, w, v, z, c)


class Half(NamedTuple):
    """L = E^2."""

    def values(self, c2: Any, c3: Any, k: Any, mu: Any, w: Any, v: Any, z: Any, c: Any) -> Any:
        """Small harmonics, and what is on E [rad/s^2] at first and at second order."""
        return half(c2, c3, k, mu, w, v, z, c)


class Nonresonant(NamedTuple):
    """E and L turn freely."""

    def values(self, c2: Any, c3: Any, k: Any, mu: Any, w: Any, v: Any, z: Any, c: Any) -> Any:
        """Small harmonics, and what is on E [rad/s^2] at first and at second order."""
        return nonresonant(c2, c3, k, mu, w, v, z, c)


@kernel
def speeds(form: Any, drive: Any, omega: Any) -> Any:
    """Speeds [rad/s] of the two angles of a formula."""
    other = omega * drive.lines[0].order
    return (drive.omega_0, other) if drive.ratio == 0.0 else (form.share * omega, other)


class SecondOrderFormula(NamedTuple):
    """Second order by a formula.

    `square` [1/(rad s^2)] and `cube` [1/(rad^2 s^2)] are those of the law over J, `share` the speed of the formula's
    first angle over omega, `numbers` the multiples of its two angles on the small harmonics.
    """

    square: float
    cube: float
    share: float
    numbers: tuple[tuple[int, int], ...]
    formula: Any

    def rate(self, drive: Any, omega: Any, amplitude: Any, z: Any) -> Any:
        """Rate z' [rad/s] by a formula of second order, and the small harmonics [rad]."""
        fast, pull = fast_speed(drive, omega), drive.omega_0 * drive.omega_0
        carrier, linear = complex(drive.mu, 2.0 * fast), complex(pull - fast * fast, drive.mu * fast)
        w, v = speeds(self, drive, omega)
        c = hard(drive, drive.lines[0], omega, amplitude)
        step = STEP * (abs(z.real) + abs(z.imag) + 1e-3 * drive.size)
        here = ahead = aside = 0j
        for i in range(3):
            there = z + complex(step if i == 1 else 0.0, step if i == 0 else 0.0)
            found, first, back = self.formula.values(self.square, self.cube, pull, drive.mu, w, v, there, c)
            here, ahead, aside = -(linear * there + first + back), here, ahead
        rate, by_re, by_im = here + soft(drive, omega, amplitude), (ahead - here) / step, (aside - here) / step
        return with_inertia(rate / carrier, by_re / carrier, by_im / carrier, carrier), (found[0] + 0j, *found[1:])

    def motion(self, drive: Any, small: Any, omega: Any, angle: Any, free: Any) -> Any:
        """Sum of the small harmonics [rad] of a formula, and its derivative [rad/s]."""
        w, v = speeds(self, drive, omega)
        first, second = turned(free if drive.ratio == 0.0 else self.share * angle), turned(drive.lines[0].order * angle)
        value = rate = 0.0
        for i in range(len(small)):
            m, n = self.numbers[i]
            wave = small[i] * power(first, m) * power(second, n)
            value += wave.real
            rate -= (m * w + n * v) * wave.imag
        return value, rate
