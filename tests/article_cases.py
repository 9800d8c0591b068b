"""The source article's four cases with the parameters of its Table 3, "derived", and those that its text prints.

The article's equation is x'' + mu x' + omega_0^2 (x + alpha x^3) = A cos(omega t). Its text prints mu = 0.129 1/s and
omega_0 = 37.2 rad/s; its own Table 3 (`HDC_40_050`) gives others. The values are those of a check of the article by
DOP853 at a relative tolerance of 1e-11, from rest, over about 30/mu. It took its largest values at output times: the
true ones are up to 0.03 % higher.
"""

from typing import NamedTuple

import strainwave as sw

A = 380.228  # T_m/(N J_m) for T_m = 10 N m [rad/s^2]


def derived(omega):
    return sw.HDC_40_050.error_equation(motor_torque=sw.Harmonic(10.0), omega=omega)


def printed(omega):
    return sw.Oscillator(1.0, 0.129, sw.Cubic(37.2**2, 0.1), sw.Harmonic(A), omega)


class Case(NamedTuple):
    """A row: the largest |x| from rest, and of the steady motion the peak and the amplitudes at omega and 3 omega."""

    system: sw.Oscillator
    largest: str
    peak: str
    at_omega: str
    at_3_omega: str | None


OMEGA_0 = sw.HDC_40_050.omega_0
CASES = {
    "derived, non-resonant": Case(derived(10.47), "5.107e-3", "2.5599e-3", "2.5599e-3", "4.2e-10"),
    "derived, primary": Case(derived(OMEGA_0), "0.47996", "0.32364", "0.32353", "1.060e-4"),
    "derived, superharmonic": Case(derived(OMEGA_0 / 3), "4.4267e-3", "2.8777e-3", "2.8777e-3", "6.51e-7"),
    "derived, subharmonic": Case(derived(3 * OMEGA_0), "4.9215e-4", "3.1975e-4", "3.1975e-4", None),
    "printed, non-resonant": Case(printed(10.47), "0.56958", "0.29412", "0.29630", "2.166e-3"),
    "printed, primary": Case(printed(37.2), "2.3688", "1.5494", "1.5375", "1.189e-2"),
    "printed, superharmonic": Case(printed(12.4), "0.47662", "0.27762", "0.30692", "4.903e-2"),
    "printed, subharmonic": Case(printed(111.6), "5.2850e-2", "3.4346e-2", "3.4346e-2", None),
}


def half_digit(text):
    """Half a unit of the last digit of a number."""
    mantissa, _, exponent = text.partition("e")
    decimals = len(mantissa.partition(".")[2])
    return 0.5 * 10.0 ** (int(exponent or 0) - decimals)
