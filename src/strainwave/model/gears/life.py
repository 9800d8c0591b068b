"""Life of the wave generator's bearing, by which a strain wave gear ages."""

import math

from ...base.quantities import number
from ...base.units import RPM
from .gear import Gear

# L10 [h] at rated torque and speed, a fifth of the printed L50.
LONG, USUAL = 10_000.0, 7_000.0
LONG_SERIES = ("CSG", "SHG")
RATED_SPEED = 2000.0 * RPM


def bearing_life(gear: Gear, average_torque: float, average_speed: float) -> float | None:
    """Hours after which one bearing in ten has failed: L10 = L_n (T_rated/T_av)^3 (n_rated/n_av).

    L_n is 10 000 h for the series CSG and SHG, 7000 h for the others; n_rated is 2000 rpm.

    Parameters
    ----------
    gear : Gear
        The record.
    average_torque : float
        Cubic mean of the torque in the gear, weighted by the turns of the input [N*m, output side] (`cubic_mean`).
    average_speed : float
        Mean size of the input speed over the whole time, dwells included [rad/s, motor side].

    Returns
    -------
    float or None
        Hours; None where the record has no rated torque, or nothing turns under torque.

    Raises
    ------
    ValueError
        If a number is not finite.

    References
    ----------
    Harmonic Drive LLC, CSF/CSG catalogue, p. 14, eq. 8; Harmonic Drive SE, engineering data 1019658 (2014), sec. 4.1.2:
    L50 is 50 000 h for CSG and SHG, 35 000 h for HFUC, HFUS, CSD, CSF and SHD, and L10 about a fifth of it.
    """
    torque = abs(number("average_torque [N*m]", average_torque))
    speed = abs(number("average_speed [rad/s]", average_speed))
    if gear.rated_torque is None or not torque * speed > 0.0:
        return None
    hours, share = LONG if gear.series in LONG_SERIES else USUAL, gear.rated_torque / torque
    hours *= share * share * share * (RATED_SPEED / speed)
    return hours if math.isfinite(hours) else None
