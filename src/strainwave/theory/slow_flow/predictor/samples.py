"""Rate of the slow amplitude in a controller's predictor: forces from samples of the law over one period.

They serve any law torque(x) and any lines; `formulas` serves those laws that need no samples.
"""

from typing import Any, NamedTuple

from ....base.quantities import Reals, States
from ....compile.jit import kernel
from ..second_order_forms import answer
from .linear_drive import LinearDrive, fast_speed, first_rate, hard, power, soft, turned, with_inertia

SLOTS = 6  # small harmonics; written out below: Numba builds no tuple in a loop, and an array would take memory


@kernel
def first_motion(drive: Any, omega: Reals, amplitude: Reals, fast: Any, z: complex, b: Any) -> Any:
    """E and Re(z E) + F [rad] where the angle of the samples has turned by b."""
    turn = power(b, fast)
    w = z.real * turn.real - z.imag * turn.imag
    for i in range(len(drive.lines)):
        line = drive.lines[i]
        c, wave = hard(drive, line, omega, amplitude), power(b, line.harmonic)
        w += c.real * wave.real - c.imag * wave.imag
    return turn, w


class FirstOrderSamples(NamedTuple):
    """First order by samples, see `averaging`: `points` of them, a turn of (cosine, sine) apart, E at `fast` times.

    `share` is the speed of the angle of the samples over omega.
    """

    law: Any
    J: float
    points: int
    cosine: float
    sine: float
    fast: int
    share: float

    def rate(self, drive: LinearDrive, omega: Reals, amplitude: Reals, z: complex) -> Any:
        """Rate z' [rad/s], and the small harmonics [rad]."""
        offset, stiffness = self.law.torque(drive.u0), self.J * drive.omega_0 * drive.omega_0
        b, step, total = 1.0 + 0j, complex(self.cosine, self.sine), 0j
        for _ in range(self.points):
            turn, w = first_motion(drive, omega, amplitude, self.fast, z, b)
            n = self.law.torque(drive.u0 + w) - offset - stiffness * w
            total += complex(n * turn.real, -n * turn.imag)
            b *= step
        mean = total * (1.0 / (drive.omega_0 * self.J * self.points))
        return first_rate(drive, omega, amplitude, z, mean), ()

    def motion(self, _drive: Any, _small: Any, _omega: Any, _angle: Any, _free: Any) -> Any:
        """Nothing: first order has no small harmonics."""
        return 0.0, 0.0


@kernel
def product(a: Any, b: Any) -> Any:
    """Products of the slots of two tuples."""
    return a[0] * b[0], a[1] * b[1], a[2] * b[2], a[3] * b[3], a[4] * b[4], a[5] * b[5]


@kernel
def shifted(a: complex, h: Reals, b: complex) -> Any:
    """Return a + h b for complex numbers a and b and a number h."""
    return complex(a.real + h * b.real, a.imag + h * b.imag)


@kernel
def added(a: Any, h: Reals, b: Any) -> Any:
    """Return a + h b for the slots of two tuples."""
    first = shifted(a[0], h, b[0]), shifted(a[1], h, b[1]), shifted(a[2], h, b[2])
    return (*first, shifted(a[3], h, b[3]), shifted(a[4], h, b[4]), shifted(a[5], h, b[5]))


@kernel
def powers(b: complex, n: States) -> Any:
    """Powers of a number on the unit circle, one a slot."""
    return power(b, n[0]), power(b, n[1]), power(b, n[2]), power(b, n[3]), power(b, n[4]), power(b, n[5])


@kernel
def real_sum(a: Any, b: Any) -> Any:
    """Real part of the sum of products of two tuples."""
    total = a[0].real * b[0].real - a[0].imag * b[0].imag
    for i in range(1, SLOTS):
        total += a[i].real * b[i].real - a[i].imag * b[i].imag
    return total


@kernel
def slot(force: Any, drive: LinearDrive, omega: Reals, amplitude: Reals, n: complex, i: Any) -> Any:
    """Small harmonic [rad] in a slot, from the torque's harmonic over J [rad/s^2] there."""
    speed = force.share * force.numbers[i] * omega
    for j in range(len(drive.lines)):
        line = drive.lines[j]
        if line.harmonic == force.numbers[i]:
            c = hard(drive, line, omega, amplitude)
            n += complex(-drive.mu * speed * c.imag, drive.mu * speed * c.real)
    return force.weights[i] * answer(n, drive.omega_0 * drive.omega_0, drive.mu, speed)


@kernel
def small_harmonics(force: Any, drive: Any, omega: Reals, amplitude: Reals, z: complex) -> Any:
    """Amplitudes [rad] of the small harmonics that the law's torque along the first-order motion drives."""
    mean_torque, pull = force.law.torque(drive.u0), drive.omega_0 * drive.omega_0
    b, step = 1.0 + 0j, complex(force.cosine, force.sine)
    turns, steps = powers(b, force.numbers), powers(step, force.numbers)
    n = (0j, 0j, 0j, 0j, 0j, 0j)
    for _ in range(force.points):
        _, w = first_motion(drive, omega, amplitude, force.fast, z, b)
        excess = (force.law.torque(drive.u0 + w) - mean_torque) / force.J - pull * w
        n = added(n, excess, turns)
        b *= step
        turns = product(turns, steps)
    scale = 2.0 / force.points
    return (
        slot(force, drive, omega, amplitude, scale * n[0].conjugate(), 0),
        slot(force, drive, omega, amplitude, scale * n[1].conjugate(), 1),
        slot(force, drive, omega, amplitude, scale * n[2].conjugate(), 2),
        slot(force, drive, omega, amplitude, scale * n[3].conjugate(), 3),
        slot(force, drive, omega, amplitude, scale * n[4].conjugate(), 4),
        slot(force, drive, omega, amplitude, scale * n[5].conjugate(), 5),
    )


class SecondOrderSamples(NamedTuple):
    """Second order by samples, see `second_order`, with the `SLOTS` largest small harmonics.

    `numbers` are their multiples of the angle of the samples, `weights` 1/2 for the mean, 1 for others, 0 for none.
    """

    law: Any
    J: float
    points: int
    cosine: float
    sine: float
    fast: int
    share: float
    numbers: tuple[int, ...]
    weights: tuple[float, ...]

    def rate(self, drive: LinearDrive, omega: Reals, amplitude: Reals, z: complex) -> Any:
        """Rate z' [rad/s], and the small harmonics [rad]; z'' is that at constant ones, which is of second order."""
        small = small_harmonics(self, drive, omega, amplitude, z)
        mean_torque, pull, per_J = self.law.torque(drive.u0), drive.omega_0 * drive.omega_0, 1.0 / self.J
        b, step = 1.0 + 0j, complex(self.cosine, self.sine)
        turns, steps = powers(b, self.numbers), powers(step, self.numbers)
        back, mean, twice = 0j, 0.0, 0j
        for _ in range(self.points):
            turn, w = first_motion(drive, omega, amplitude, self.fast, z, b)
            w += real_sum(small, turns)
            n = (self.law.torque(drive.u0 + w) - mean_torque) * per_J - pull * w
            slope = self.law.stiffness(drive.u0 + w) * per_J - pull
            back += complex(n * turn.real, -n * turn.imag)
            mean += slope
            twice += slope * (turn * turn).conjugate()
            b *= step
            turns = product(turns, steps)
        fast, scale = fast_speed(drive, omega), 1.0 / self.points
        carrier, linear = complex(drive.mu, 2.0 * fast), complex(pull - fast * fast, drive.mu * fast)
        balance = soft(drive, omega, amplitude) - linear * z - 2.0 * scale * back
        by_re = -(linear + scale * (mean + twice)) / carrier
        by_im = -1j * (linear + scale * (mean - twice)) / carrier
        return with_inertia(balance / carrier, by_re, by_im, carrier), small

    def motion(self, _drive: Any, small: Any, omega: Any, angle: Any, _free: Any) -> Any:
        """Sum of the small harmonics [rad], and its derivative [rad/s]."""
        b, value, rate = turned(self.share * angle), 0.0, 0.0
        for i in range(SLOTS):
            wave = small[i] * power(b, self.numbers[i])
            value += wave.real
            rate -= self.share * self.numbers[i] * omega * wave.imag
        return value, rate
