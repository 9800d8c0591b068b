"""Amplitude, frequency and decay of a free vibration, window by window.

In a window of a few cycles the motion is Re((z_0 + z_1 s + z_2 s^2) exp(i w s)) with harmonics 2 and 3 and an offset,
s the time from the middle: least squares give amplitude |z_0|, frequency w + Im(z_1/z_0) and decay rate -Re(z_1/z_0).
All samples count, so that the deviations are smaller than those of zero crossings and peaks by the square root of the
samples in a quarter cycle; z_2 takes the change of frequency inside the window.
"""

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from ...base.quantities import SMALLEST, numbers
from ...base.results import Floats
from .intervals import spread
from .run import refuse_descending

CYCLES = 3.0  # of a window, and fewer in a short record
FEWEST = 3  # windows
PER_CYCLE = 6.0  # samples at least
TURN = 0.35  # of the last extreme: where a motion to the other side counts as half a cycle
OUT_OF_NOISE = 5.0  # deviations of the noise: a smaller amplitude ends the decay
LOUDEST = 0.02  # of the record's range: noise that is allowed for
MISSED = 1.6  # of the half cycle before: there is one between
AGAIN = 1.6  # of the last half cycles: a larger motion after the end is another decay
HEAVY = 0.04  # damping ratio up to which averaging is right to about its square
PASSES = 4  # of the frequency in each window
RISE = 4.0  # deviations
STILL = 0.03  # relative change of amplitude
ASIDE = 0.15  # of a window's power that is no vibration of one frequency


class Waves(NamedTuple):
    """Windows (m,) of a vibration: middle [s], amplitude of its first harmonic, angular frequency, decay rate [1/s].

    Attributes
    ----------
    time, amplitude, omega, rate : (m,) arrays
        The motion is about amplitude cos(omega t); rate is -(d amplitude/dt)/amplitude.
    amplitude_deviation, omega_deviation, rate_deviation : (m,) arrays
        Their standard deviations.
    phase : (m,) array
        Of the first harmonic in the middle of the window, between -pi and pi [rad].
    offset : float
        Mean of the windows' offsets.
    end : int
        Sample before which the motion is out of the noise.
    """

    time: Floats
    amplitude: Floats
    omega: Floats
    rate: Floats
    amplitude_deviation: Floats
    omega_deviation: Floats
    rate_deviation: Floats
    phase: Floats
    offset: float
    end: int


def checked_record(time: Any, value: Any) -> tuple[Floats, Floats]:
    """Times and values of a measured motion, or say in one sentence what is wrong with them (ValueError)."""
    t, y = numbers("time [s]", time), numbers("value", value)
    if len(t) != len(y):
        raise ValueError(f"there are {len(t)} times and {len(y)} values; give one value for each time")
    refuse_descending(t)
    if not np.ptp(y) > SMALLEST:
        raise ValueError(f"the value is {y[0]:g} in all {len(y)} samples: there is no motion; record a free decay")
    return t, y


def decaying_waves(time: Floats, value: Floats) -> Waves:
    """Amplitude, frequency and decay in windows of a free decay; see the head of this file.

    Raises
    ------
    ValueError
        If there are too few cycles or samples, the amplitude does not decay, or two frequencies beat.
    """
    middle = float(np.mean(value[-max(len(value) // 4, 1) :]))  # the end is nearest to rest
    turns, end = _half_cycles(value - middle, _noise(value))
    if len(turns) < 6:
        raise ValueError(
            f"the motion has {len(turns) / 2:g} cycles above the noise; a free decay needs 3 or more, record it longer "
            "or start it larger"
        )
    turn_times = time[turns]
    per_cycle = 2.0 * float(np.mean(np.diff(turns)))
    if per_cycle < PER_CYCLE:
        raise ValueError(f"there are {per_cycle:.3g} samples a cycle; a free decay needs {PER_CYCLE:g} or more")
    count = max(FEWEST, int(0.5 * (len(turns) - 1) / min(CYCLES, 0.5 * (len(turns) - 1) / FEWEST)))
    edges = np.interp(np.linspace(0.0, len(turns) - 1, count + 1), np.arange(len(turns)), turn_times)
    rows = []
    for a, b in pairwise(edges):
        inside = (time >= a) & (time < b)
        half = np.interp([a, b], turn_times, np.arange(len(turns)))
        rows.append(_window(time[inside], value[inside], 0.5 * (a + b), np.pi * (half[1] - half[0]) / (b - a)))
    table = np.array(rows).T
    left, last = table[9], _lightly_damped(table)
    if last < count:
        table, left, end = table[:, :last], left[:last], int(np.searchsorted(time, edges[last]))
    found = Waves._make([*table[:8], float(np.mean(table[8])), end])
    _refuse(found, left)
    return found


def _lightly_damped(table: Floats) -> int:
    """Number of windows before the damping is too much for averaging, as dry friction is for small amplitudes."""
    ratio, deviation = table[3] / table[2], table[6] / table[2]
    heavy = np.flatnonzero(ratio - 2.0 * deviation > HEAVY)
    last = int(heavy[0]) if len(heavy) else len(ratio)
    if last < FEWEST:
        raise ValueError(
            f"the damping ratio is {100.0 * ratio[last]:.2g} % in window {last + 1}; a decay is fitted up to "
            f"{100.0 * HEAVY:g} %: start it larger, or take identify, which integrates the equation"
        )
    return last


def _noise(value: Floats) -> float:
    """Deviation of white noise on a smooth motion, from third differences; coarse samples have these too."""
    if len(value) < 5:
        return 0.0
    return float(min(np.median(np.abs(np.diff(value, 3))) / 0.6745 / np.sqrt(20.0), LOUDEST * np.ptp(value)))


def _half_cycles(y: Floats, noise: float) -> tuple[np.ndarray[Any, np.dtype[np.int64]], int]:
    """Samples of the zero crossings, one for each half cycle, and where the motion ends in the noise."""
    crossings: list[int] = []
    side, extreme, crossing, least = 0.0, 0.0, 0, OUT_OF_NOISE * noise
    for i, v in enumerate(y.tolist()):
        if side * v > 0.0 or side == 0.0:
            crossing, extreme = i + 1, max(extreme, abs(v))
            side = side or (1.0 if v > 0.0 else -1.0)
        elif abs(v) > max(TURN * extreme, least):
            if len(crossings) > 2 and crossing - crossings[-1] > MISSED * (crossings[-1] - crossings[-2]) + 2:
                break  # half cycles that did not leave the noise lie between
            crossings.append(crossing)
            side, extreme = -side, abs(v)
    start, end = crossings[-2] if len(crossings) > 1 else 0, min(crossings[-1] + 1 if crossings else 0, len(y))
    before, after = float(np.max(np.abs(y[start:end]), initial=0.0)), float(np.max(np.abs(y[end:]), initial=0.0))
    if len(crossings) > 2 and after > max(AGAIN * before, least):
        raise ValueError(
            f"the motion fades to {before:.4g} and comes back to {after:.4g}: two frequencies beat or it is pushed "
            "again; filter one mode out, or cut the record to one decay"
        )
    return np.array(crossings, np.int64), end


def _window(t: Floats, y: Floats, middle: float, omega: float) -> list[float]:
    """Row of `Waves` with the share of the power that is left; see the head of this file."""
    s = t - middle
    harmonics = 3 if len(s) > 24 else 1
    scale = 0.5 * float(np.ptp(s)) or 1.0
    for _ in range(PASSES):
        wave = np.exp(1j * omega * s)
        parts = [wave, wave * (s / scale), wave * (s / scale) ** 2, *(wave**k for k in range(2, harmonics + 1))]
        table = np.column_stack([np.ones(len(s)), *(part for w in parts for part in (w.real, -w.imag))])
        p = np.linalg.lstsq(table, y, rcond=None)[0]
        z0, z1 = complex(p[1], p[2]), complex(p[3], p[4]) / scale
        omega += (z1 / z0).imag
    omega -= (z1 / z0).imag  # the last table's
    residual = y - table @ p
    covariance = spread(table, residual).covariance[1:5, 1:5]
    units = np.array([1.0, 1j, 1.0 / scale, 1j / scale])
    ratio = np.concatenate([-z1 / z0**2 * units[:2], units[2:] / z0])
    rows = np.array([[*(units[:2] / z0).real, 0.0, 0.0], ratio.imag, -ratio.real])
    deviations = np.sqrt(np.einsum("ij,jk,ik->i", rows, covariance, rows))
    size, off = abs(z0), float(residual @ residual) / max(float(np.sum((y - p[0]) ** 2)), 1e-300)
    return [
        middle, size, omega + (z1 / z0).imag, -(z1 / z0).real, size * deviations[0], deviations[1], deviations[2],
        float(np.angle(z0)), float(p[0]), off,
    ]  # fmt: skip


def _refuse(waves: Waves, left: Floats) -> None:
    """Refuse what is no free decay of one frequency (ValueError)."""
    size, deviation = waves.amplitude, waves.amplitude_deviation
    rise = np.diff(size) - RISE * np.hypot(deviation[1:], deviation[:-1]) - STILL * size[:-1]
    if np.any(rise > 0.0):
        at = int(np.argmax(rise))
        raise ValueError(
            f"the amplitude rises from {size[at]:.4g} at {waves.time[at]:.4g} s to {size[at + 1]:.4g} at "
            f"{waves.time[at + 1]:.4g} s: two frequencies beat or the motion is driven; filter one mode out, or cut "
            "the record to where it is free"
        )
    if size[-1] > (1.0 - STILL) * size[0]:
        raise ValueError(
            f"the amplitude goes from {size[0]:.4g} to {size[-1]:.4g}: the motion does not decay; record it longer"
        )
    if np.median(left) > ASIDE:
        raise ValueError(
            f"{100.0 * np.median(left):.2g} % of the motion's power is not a vibration of one frequency: noise or a "
            "second mode; filter one mode out"
        )
