"""Linear drive about its operating point, in scalar code: its lines, and the rate of its slow flow under a force."""

from typing import Any, NamedTuple

from ....base.quantities import Reals
from ....compile.jit import kernel
from ....compile.maths import cos, sin
from ..setting import NEAR_RESONANCE

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
def fast_speed(drive: LinearDrive, omega: Reals) -> Any:
    """Omega [rad/s]: the speed of the fast angle."""
    return drive.ratio * omega if drive.ratio > 0.0 else drive.omega_0


@kernel
def forcing(line: ForcedLine, omega: Reals, amplitude: Reals) -> Any:
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
    gap, least = pull - speed * speed, 2.0 * NEAR_RESONANCE * pull
    if abs(gap) < least:
        gap = least if gap >= 0.0 else -least
    force, per_gap = forcing(line, omega, amplitude), (1.0 - line.soft) / gap
    return complex(per_gap * force.real, per_gap * force.imag)


@kernel
def soft(drive: LinearDrive, omega: Reals, amplitude: Reals) -> Any:
    """The soft line [rad/s^2]."""
    total = 0j
    for i in range(len(drive.lines)):
        force = forcing(drive.lines[i], omega, amplitude)
        total += complex(drive.lines[i].soft * force.real, drive.lines[i].soft * force.imag)
    return total


@kernel
def turned(angle: Reals) -> Any:
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
def with_inertia(rate: complex, by_re: complex, by_im: complex, carrier: complex) -> Any:
    """Rate z' of z'' + carrier z' = carrier rate, from the derivatives of `rate` to Re z and Im z."""
    by_re, by_im = by_re / carrier, by_im / carrier
    a, b, c, d = 1.0 + by_re.real, by_im.real, by_re.imag, 1.0 + by_im.imag
    det = a * d - b * c
    if not abs(det) > STIFFEST:
        det = STIFFEST
    return complex((d * rate.real - b * rate.imag) / det, (a * rate.imag - c * rate.real) / det)


@kernel
def first_rate(drive: LinearDrive, omega: Reals, amplitude: Reals, z: complex, mean: complex) -> Any:
    """Rate z' [rad/s] of first order under a mean force over omega_0 [rad/s], see `averaging`."""
    push = mean - soft(drive, omega, amplitude) * (0.5 / drive.omega_0)
    return -complex(0.5 * drive.mu, fast_speed(drive, omega) - drive.omega_0) * z + 1j * push
