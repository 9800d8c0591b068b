"""The error between motor and load as the sum of its parts: pure kinematic error and torsion.

x = theta_m/N - theta_l = e + u: the gear's geometry and its twist under torque. Vendors' angular transmission error
(ATE) is theta_l - theta_m/N = -x.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...base.law import repeating
from ...base.quantities import checked, positive_count
from ...base.results import Floats, Orbit
from ...model.error_spectrum import extremes
from ...model.oscillator import Oscillator
from ...numerics.operating_point import operating_point

LEAST_SAMPLES = 256
PER_PERIOD = 8  # samples a period of the highest harmonic
HARMONIC_SHARE = 1e-13  # share of the whole below which a harmonic is rounding


@dataclass(frozen=True, eq=False)
class ErrorParts:
    """Parts of the error over one period, on a uniform grid.

    Attributes
    ----------
    phase : (n,) array
        Base angle [rad].
    pure : (n,) array
        Kinematic error e [rad].
    torsion : (n,) array
        Torsion u [rad], its mean included.
    total : (n,) array
        Error x = e + u [rad] between motor and load.
    pure_peak_to_peak, torsion_peak_to_peak, total_peak_to_peak : float
        Peak-to-peak of each [rad]; that of the total is no sum, it depends on their phases.
    """

    phase: Floats
    pure: Floats
    torsion: Floats
    total: Floats
    pure_peak_to_peak: float
    torsion_peak_to_peak: float
    total_peak_to_peak: float

    @property
    def ate(self) -> Floats:
        """Vendors' angular transmission error theta_l - theta_m/N = -x [rad]; a resisting load makes it negative."""
        return -self.total

    @property
    def wind_up(self) -> float:
        """Mean torsion [rad]."""
        return float(np.mean(self.torsion))

    def __str__(self) -> str:
        mean = float(np.mean(self.total))
        return (
            f"error between motor and load {self.total_peak_to_peak:.4g} rad peak-to-peak about a mean of {mean:.4g} "
            "rad\n"
            f"  pure kinematic error {self.pure_peak_to_peak:.4g} rad peak-to-peak\n"
            f"  torsion {self.torsion_peak_to_peak:.4g} rad peak-to-peak about a mean of {self.wind_up:.4g} rad"
        )


def error_parts(system: Oscillator, orbit: Orbit | None = None) -> ErrorParts:
    """Separate the error between motor and load into the pure kinematic error and the torsion.

    Parameters
    ----------
    system : Oscillator
        The error equation.
    orbit : Orbit, optional
        Its periodic motion. Default: the gear turned slowly, so that the law carries the torque of the excitation at
        every angle (quasi-static); for a given static torque T the excitation is Harmonic(0, mean=T).

    Returns
    -------
    ErrorParts
        Over the orbit's period, or over one turn.

    Raises
    ------
    ValueError
        If the orbit is none, or belongs to another speed, or the law cannot carry the torque.
    TypeError
        If the law depends on more than the torsion and no orbit is given.

    References
    ----------
    Ghorbel, Gandhi & Alpeter 2001, J. Mech. Des. 123(1), 90-97 (pure kinematic error and torsional flexibility).
    """
    system = repeating("error_parts", checked(system))
    orders = [int(k) for k in system.orders()] or [1]
    if orbit is None:
        n = _samples(max(orders), 1)
        phase: Floats = np.linspace(0.0, 2.0 * np.pi, n, endpoint=False)
        pure = np.broadcast_to(np.asarray(system.error.value(phase), float), phase.shape)
        torques, index = np.unique(_torques(system.excitation, phase), return_inverse=True)
        torsion: Floats = np.array([_twist_under(system.law, float(T)) for T in torques])[index]
        total = pure + torsion
    else:
        if not orbit.status.found:
            raise ValueError(f"no orbit was found: {orbit.message}")
        if not np.isclose(orbit.omega, system.omega, rtol=1e-9, atol=0.0):
            raise ValueError(
                f"the orbit belongs to omega = {orbit.omega:g} rad/s and the system to {system.omega:g}; "
                "replaced(system, {'omega': orbit.omega}) moves it"
            )
        n = _samples(max(*orders, len(orbit.coefficients) // 2), orbit.period)
        phase = np.linspace(0.0, 2.0 * np.pi * orbit.period, n, endpoint=False)
        pure = np.broadcast_to(np.asarray(system.error.value(phase), float), phase.shape)
        total = np.asarray(orbit.state(phase)[0], float)
        torsion = total - pure
    return ErrorParts(phase, np.array(pure), torsion, total, *(_peak_to_peak(part) for part in (pure, torsion, total)))


def _samples(highest: int, period: int) -> int:
    return max(LEAST_SAMPLES, PER_PERIOD * positive_count("harmonic", highest)) * period


def _torques(excitation: Any, phase: Floats) -> Floats:
    return np.broadcast_to(np.asarray(excitation.torque(phase), float), phase.shape)


def _twist_under(law: Any, torque: float) -> float:
    try:
        return operating_point(law, torque)
    except TypeError:
        raise TypeError(
            f"{type(law).__name__} depends on more than the torsion, so a torque has no unique twist; give an orbit"
        ) from None


def _peak_to_peak(samples: Floats) -> float:
    """Peak-to-peak of the series through uniform samples of a whole period."""
    series = np.fft.rfft(samples)[1:] * 2.0 / len(samples)
    size = np.abs(series)
    if not len(size) or float(np.max(np.abs(samples))) == 0.0:
        return 0.0
    kept = np.flatnonzero(size > HARMONIC_SHARE * float(np.max(np.abs(samples))))
    low, high = extremes(kept + 1, series[kept].real, -series[kept].imag)
    return high - low
