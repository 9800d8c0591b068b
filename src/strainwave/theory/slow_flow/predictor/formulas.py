"""Forces of a predictor by formula: the cubic law at first order, a square and a cube at second, under one line."""

from typing import Any, NamedTuple

from ....base.quantities import Reals
from ....compile.jit import kernel
from .linear_drive import LinearDrive, fast_speed, first_rate, hard, power, soft, turned, with_inertia

STEP = 1e-6  # of the amplitude: forward differences


class FirstOrderCubic(NamedTuple):
    """First order of the cubic law under one line, see `closed_forms`; kappa = alpha omega_0 [1/(rad^2 s)].

    `superharmonic` and `subharmonic` are 1 in that regime and 0 otherwise.
    """

    kappa: float
    superharmonic: float
    subharmonic: float

    def rate(self, drive: LinearDrive, omega: Reals, amplitude: Reals, z: complex) -> Any:
        """Rate z' [rad/s], and the small harmonics [rad]."""
        c, y = hard(drive, drive.lines[0], omega, amplitude), z.conjugate()
        zz, cc = z.real * z.real + z.imag * z.imag, c.real * c.real + c.imag * c.imag
        resonant = 0.125 * self.superharmonic * c * c + 0.375 * self.subharmonic * y * y
        mean = self.kappa * ((0.375 * zz + 0.75 * cc) * z + c * resonant)
        return first_rate(drive, omega, amplitude, z, mean), ()

    def motion(self, _drive: Any, _small: Any, _omega: Any, _angle: Any, _free: Any) -> Any:
        """Nothing: first order has no small harmonics."""
        return 0.0, 0.0


@kernel
def speeds(form: Any, drive: LinearDrive, omega: Reals) -> Any:
    """Speeds [rad/s] of the two angles of a formula."""
    other = omega * drive.lines[0].order
    return (drive.omega_0, other) if drive.ratio == 0.0 else (form.share * omega, other)


class SecondOrderFormula(NamedTuple):
    """Second order by a formula.

    `square` [1/(rad s^2)] and `cube` [1/(rad^2 s^2)] are those of the law over J, `share` the speed of the formula's
    first angle over omega.
    """

    square: float
    cube: float
    share: float
    formula: Any

    def rate(self, drive: LinearDrive, omega: Reals, amplitude: Reals, z: complex) -> Any:
        """Rate z' [rad/s] by a formula of second order, and the small harmonics [rad]."""
        fast, pull = fast_speed(drive, omega), drive.omega_0 * drive.omega_0
        carrier, linear = complex(drive.mu, 2.0 * fast), complex(pull - fast * fast, drive.mu * fast)
        w, v = speeds(self, drive, omega)
        c = hard(drive, drive.lines[0], omega, amplitude)
        step = STEP * (abs(z.real) + abs(z.imag) + 1e-3 * drive.size)
        centre = ahead = aside = 0j
        for i in range(3):  # a step aside in the imaginary part, one ahead in the real part, at last z itself
            point = z + complex(step if i == 1 else 0.0, step if i == 0 else 0.0)
            small, first, back = self.formula.values(self.square, self.cube, pull, drive.mu, w, v, point, c)
            centre, ahead, aside = -(linear * point + first + back), centre, ahead
        rate, by_re, by_im = centre + soft(drive, omega, amplitude), (ahead - centre) / step, (aside - centre) / step
        return with_inertia(rate / carrier, by_re / carrier, by_im / carrier, carrier), (small[0] + 0j, *small[1:])

    def motion(self, drive: Any, small: Any, omega: Any, angle: Any, free: Any) -> Any:
        """Sum of the small harmonics [rad] of a formula, and its derivative [rad/s]."""
        w, v = speeds(self, drive, omega)
        first, second = turned(free if drive.ratio == 0.0 else self.share * angle), turned(drive.lines[0].order * angle)
        value = rate = 0.0
        for i in range(len(small)):
            m, n = self.formula.numbers[i]
            wave = small[i] * power(first, m) * power(second, n)
            value += wave.real
            rate -= (m * w + n * v) * wave.imag
        return value, rate
