"""Natural frequencies of many drives at once, about the torsion that carries their mean torque."""

from typing import Any

import numpy as np

from .._dispatch import is_spring
from ..quantities import replace
from ..results import Floats

ANGLES = 2.0 * np.pi * np.arange(64)[:, None] / 64
STEPS = 60


def natural_frequencies(system: Any, drives: dict[str, Floats], amplitude: float = 0.0) -> Floats:
    """Free vibration [rad/s] of every drive (drives,), small or of an amplitude [rad]; nan where nothing restores.

    With an amplitude a, one harmonic: J a omega^2 = (1/pi) integral of T(u0 + a cos p) cos p dp, where u0 is the mean
    that carries the mean torque at this amplitude (describing function; Nayfeh & Mook 1979, sec. 2.3.4). For a cubic
    law whose frequency has risen by 10 % its error is below 0.1 %; `backbone` is exact.

    Raises
    ------
    TypeError
        If the law has friction or memory.
    """
    if not is_spring(system):
        raise TypeError(f"{type(system.law).__name__} has friction or memory; natural frequencies need a law torque(x)")
    members = replace(system, drives)
    count = len(next(iter(drives.values())))
    mean = np.mean(np.broadcast_to(members.excitation.torque(ANGLES), (64, count)), axis=0)
    law, wave = members.law, amplitude * np.cos(ANGLES)

    def missing(u: Floats) -> Floats:
        return np.asarray(np.mean(np.broadcast_to(law.torque(u + wave), (64, count)), axis=0) - mean, float)

    u0 = _root(missing, np.zeros(count))
    if amplitude > 0.0:
        pull = 2.0 * np.mean(law.torque(u0 + wave) * np.cos(ANGLES), axis=0) / amplitude
    else:
        pull = np.broadcast_to(law.stiffness(u0), (count,))
    with np.errstate(invalid="ignore"):
        return np.asarray(np.sqrt(np.where(pull > 0.0, pull, np.nan) / members.J))


def driven_orders(system: Any) -> tuple[int, ...]:
    """Orders above 0 of the excitation and the kinematic error whose amplitude is not 0."""
    orders = [k for k in system.orders() if k > 0]
    angles = 2.0 * np.pi * np.arange(8 * max([1, *orders])) / (8 * max([1, *orders]))
    parts = (system.excitation.torque(angles), system.error.value(angles))
    spectra = [np.abs(np.fft.rfft(np.broadcast_to(part, angles.shape))) for part in parts]
    return tuple(k for k in orders if any(s[k] > 1e-9 * np.max(s[1:]) for s in spectra))


def _root(missing: Any, start: Floats) -> Floats:
    """Torsion (drives,) at which nothing is missing, by bisection; nan where none is found."""
    if not np.any(missing(start)):
        return start
    low, high = start - 1e-6, start + 1e-6
    for _ in range(60):
        open_ends = missing(low) * missing(high) > 0.0
        if not np.any(open_ends):
            break
        low, high = np.where(open_ends, 2.0 * low, low), np.where(open_ends, 2.0 * high, high)
    rising = missing(high) > 0.0
    good = missing(low) * missing(high) <= 0.0
    for _ in range(STEPS):
        middle = 0.5 * (low + high)
        over = (missing(middle) > 0.0) == rising
        low, high = np.where(over, low, middle), np.where(over, middle, high)
    return np.where(good, 0.5 * (low + high), np.nan)
