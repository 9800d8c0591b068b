"""What drives the slow flow of a predictor, in scalar code: by formula, or by samples of the law along the motion.

A force has `rate(drive, omega, amplitude, z)`, the rate z' [rad/s] at a speed [rad/s] of the base angle and a factor on
the torque lines, with a tuple of the amplitudes [rad] of the small harmonics; and `motion(drive, small, omega, angle,
free)`, the sum [rad] of such small harmonics and its derivative [rad/s] at a base angle and, without resonance, an
angle of the free part. The equations are those of `cubic`, `averaging`, `second_order` and `second_order_forms`.
"""

from typing import Any, NamedTuple

from ....compile.jit import kernel
from ....maths import cos, sin
from ..setting import NEAR

STIFFEST = 1e-3  # least determinant of what z'' makes of the rate: far outside all validity it may vanish


class ForcedLine(NamedTuple):
    """One line of the forcing, of integer order, as amplitude times exp(i phase).

    `harmonic` is its multiple of the angle of the samples, `soft` 1 for the line at Omega and 0 for all others; the
    torque is over J [rad/s^2], the kinematic error in rad.
    """

    order: int
    harmonic: int
    soft: float
    torque_re: float
    torque_im: float
    error_re: float
    error_im: float


class LinearDrive(NamedTuple):
    """The linear problem about the operating point.

    u0 is the mean torsion [rad], `ratio` Omega/omega (0 without resonance), `size` an amplitude that matters [rad].
    """

    u0: float
    omega_0: float
    mu: float
    ratio: float
    size: float
    lines: tuple[ForcedLine, ...]


@kernel
def fast_speed(drive: Any, omega: Any) -> Any:
    """Omega [rad/s]: the speed of the fast angle."""
    return drive.ratio * omega if drive.ratio > 0.0 else drive.omega_0


@kernel
def forcing(line: Any, omega: Any, amplitude: Any) -> Any:
    """A line of torque/J - omega^2 e'' [rad/s^2]."""
    speed = line.order * omega
    square = speed * speed
    return complex(
        amplitude * line.torque_re + square * line.error_re, amplitude * line.torque_im + square * line.error_im
    )


@kernel
def hard(drive: Any, line: Any, omega: Any, amplitude: Any) -> Any:
    """Forced amplitude [rad] of a line; 0 of the soft one."""
    speed, pull = line.order * omega, drive.omega_0 * drive.omega_0
    gap, least = pull - speed * speed, 2.0 * NEAR * pull
    if abs(gap) < least:
        gap = least if gap >= 0.0 else -least
    force, per_gap = forcing(line, omega, amplitude), (1.0 - line.soft) / gap
    return complex(per_gap * force.real, per_gap * force.imag)


@kernel
def soft(drive: Any, omega: Any, amplitude: Any) -> Any:
    """The soft line [rad/s^2]."""
    total = 0j
    for i in range(len(drive.lines)):
        force = forcing(drive.lines[i], omega, amplitude)
        total += complex(drive.lines[i].soft * force.real, drive.lines[i].soft * force.imag)
    return total


@kernel
def turned(angle: Any) -> Any:
    """exp(i angle)."""
    return complex(cos(angle), sin(angle))


@kernel
def power(b: Any, n: Any) -> Any:
    """Integer power of a number on the unit circle."""
    total, left = 1.0 + 0j, abs(n)
    while left > 0:
        if left & 1:
            total *= b
        b *= b
        left >>= 1
    return total if n >= 0 else total.conjugate()


@kernel
def with_inertia(rate: Any, by_re: Any, by_im: Any, carrier: Any) -> Any:
    """Rate z' of z'' + carrier z' = carrier rate, from the derivatives of `rate` to Re z and Im z."""
    by_re, by_im = by_re / carrier, by_im / carrier
    a, b, c, d = 1.0 + by_re.real, by_im.real, by_re.imag, 1.0 + by_im.imag
    det = a * d - b * c
    if not abs(det) > STIFFEST:
        det = STIFFEST
    return complex((d * rate.real - b * rate.imag) / det, (a * rate.imag - c * rate.real) / det)


class FirstOrderCubic(NamedTuple):
    """First order of the cubic law under one line, see `cubic`; kappa = alpha omega_0 [1/(rad^2 s)].

    `superharmonic` and `subharmonic` are 1 in that regime and 0 otherwise.
    """

    kappa: float
    superharmonic: float
    subharmonic: float

    def rate(self, drive: Any, omega: Any, amplitude: Any, z: Any) -> Any:
        """Rate z' [rad/s], and the small harmonics [rad]."""
        c, force, y = hard(drive, drive.lines[0], omega, amplitude), soft(drive, omega, amplitude), z.conjugate()
        zz, cc = z.real * z.real + z.imag * z.imag, c.real * c.real + c.imag * c.imag
        shift = fast_speed(drive, omega) - drive.omega_0 - self.kappa * (0.375 * zz + 0.75 * cc)
        push = c * (0.125 * self.superharmonic * c * c + 0.375 * self.subharmonic * y * y)
        push = complex(
            self.kappa * push.real - 0.5 * force.real / drive.omega_0,
            self.kappa * push.imag - 0.5 * force.imag / drive.omega_0,
        )
        return complex(
            shift * z.imag - 0.5 * drive.mu * z.real - push.imag, push.real - 0.5 * drive.mu * z.imag - shift * z.real
        ), ()

    def motion(self, _drive: Any, _small: Any, _omega: Any, _angle: Any, _free: Any) -> Any:
        """Nothing: first order has no small harmonics."""
        return 0.0, 0.0
