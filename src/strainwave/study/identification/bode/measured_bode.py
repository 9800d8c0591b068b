"""A Bode plot as it was measured: from frequencies and values, or from records of the closed loop by the instrument."""

from dataclasses import dataclass
from math import nan, pi
from typing import ClassVar, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike
from scipy.ndimage import uniform_filter1d

from ....base.facts import Fact
from ....base.quantities import array_of, choice, complex_numbers, number, numbers
from ....base.records import Along, Labelled, Result
from ....base.results import Complexes, Floats
from ....model.train.controls import HERTZ
from ..channels import even_step
from .measured_margins import MeasuredMargins, measured_margins

Quantity = Literal["plant", "open loop", "closed loop"]
Estimator = Literal["H1", "instrument", "unknown"]

FEWEST_FREQUENCIES = 8
PERIOD_DIFFERENCE = 1e-3  # of a reference's power: by how much its periods may differ
SEGMENTS = 8  # of a record whose reference does not repeat
EXCITED_POWER = 1e-6  # of the largest power of the reference: below it a frequency is not excited
TORQUE_DEVIATIONS = 5.0  # deviations of the noise by which the torque must follow the reference
NOISE_WIDTH = 9  # frequencies over which the power of the noise is averaged
BIAS_WIDTH = 25  # frequencies over which the bias of H1 is averaged
CLEAR_DEVIATIONS, LEAST_DIFFERENCE = 3.0, 0.02  # deviations and relative difference from which on two estimates differ
BY = {
    "H1": "it is the plain H1 = S_uy/S_uu: with the loop closed the noise that is fed back pulls it towards the "
    "inverse of the controller; give the records of reference, torque and speed, whose instrument has no such bias",
    "unknown": "the estimator is unknown: in closed loop a plain H1 is biased where the noise is large",
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class MeasuredBode(Result):
    """A measured frequency response of a motor in its loop.

    Attributes
    ----------
    omega : (n,) array
        Frequencies [rad/s], ascending.
    value : (n,) complex array
        The response: of the "plant" the motor's speed over its torque [rad/(N*m*s)]; without phases its size.
    deviation : (n,) array
        Standard deviation of the value, in its unit; nan where it is not known.
    quantity : {"plant", "open loop", "closed loop"}
        What it is: P, the loop gain L cut at the motor's torque, or L/(1 + L).
    phased : bool
        Whether the phase was measured.
    amplitude : float
        Amplitude of the excitation, in any one unit; nan where it is not known.
    notes : tuple of str
        What was assumed, a sentence each.
    hold : float
        Time [s] for which the torque is constant, from sample to sample; 0 of a continuous one.
    """

    rows: ClassVar[str] = "frequency"
    places: ClassVar[Along] = {"frequency": {"omega": "rad/s"}}

    omega: Floats
    value: Complexes
    deviation: Floats
    quantity: str
    phased: bool
    amplitude: float = nan
    notes: tuple[str, ...] = ()
    hold: float = 0.0

    @property
    def decibels(self) -> Floats:
        """Size (n,) in dB."""
        return np.asarray(20.0 * np.log10(np.maximum(np.abs(self.value), 1e-300)))

    @property
    def degrees(self) -> Floats:
        """Phase (n,) in degrees, continuous along the frequencies; nan where it was not measured."""
        return (
            np.asarray(np.unwrap(np.angle(self.value)) * 180.0 / pi) if self.phased else np.full(len(self.omega), nan)
        )

    def margins(self) -> MeasuredMargins:
        """Margins of the loop between its lowest and highest frequency; of a closed loop T the open one is T/(1 - T).

        Raises
        ------
        ValueError
            If it is a Bode plot of the plant, or without phases.
        """
        return measured_margins(self)

    def variables(self) -> Labelled:
        """Values and their deviations."""
        unit = "rad/(N*m*s)" if self.quantity == "plant" else ""
        return {"value": ("frequency", self.value, unit), "deviation": ("frequency", self.deviation, unit)}

    def facts(self) -> tuple[Fact, ...]:
        """Measured places and assumptions."""
        low, high = self.omega[[0, -1]].tolist()
        text = (
            f"Measured Bode plot of the {{}}: {len(self.omega)} frequencies, {low / HERTZ:.4g} .. {high / HERTZ:.4g} Hz"
        )
        return (
            Fact("quantity", self.quantity, text), Fact("from_rad_per_s", low), Fact("to_rad_per_s", high),
            Fact("phased", self.phased, "" if self.phased else "no phase was measured: only magnitudes are compared"),
            Fact("notes", self.notes, "{}"),
        )  # fmt: skip


def measured_bode(
    omega: ArrayLike, value: ArrayLike, *, quantity: Quantity = "plant", phased: bool = True,
    deviation: ArrayLike | None = None, amplitude: float | None = None,
    estimator: Estimator = "unknown", notes: tuple[str, ...] = (),
) -> MeasuredBode:  # fmt: skip
    """Take a measured frequency response as it is.

    Parameters
    ----------
    omega : (n,) array_like
        Frequencies [rad/s], positive; they are sorted.
    value : (n,) array_like
        Complex response, or its size where `phased` is false: of the "plant" speed over torque [rad/(N*m*s)].
    quantity : {"plant", "open loop", "closed loop"}
        What was measured.
    phased : bool
        Whether the phase is known.
    deviation : (n,) array_like, optional
        Standard deviations of the values.
    amplitude : float, optional
        Amplitude of the excitation, by which two measurements are compared.
    estimator : {"H1", "instrument", "unknown"}
        How it was estimated; a note says what that means for a closed loop.
    notes : tuple of str
        More notes.

    Returns
    -------
    MeasuredBode
        `value` (n,), complex, in the unit of `quantity` (plant [rad/(N*m*s)], loop gain [1]), over `omega` (n,)
        [rad/s], and `notes` on what was assumed.

    Raises
    ------
    ValueError
        If there are fewer than 8 frequencies, one is not positive or there twice, or a value is 0.
    """
    choice("quantity", quantity, *get_args(Quantity))
    choice("estimator", estimator, *get_args(Estimator))
    w, z = numbers("omega [rad/s]", omega), complex_numbers("value", value)
    noise = np.full(len(w), nan) if deviation is None else array_of("deviation", deviation, len(w))
    if len(w) < FEWEST_FREQUENCIES or z.shape != w.shape:
        raise ValueError(
            f"there are {len(w)} frequencies and {z.size} values; give {FEWEST_FREQUENCIES} or more, a value for each"
        )
    order = np.argsort(w, kind="stable")
    w, z, noise = w[order], z[order], noise[order]
    wrong = np.append(w[0] <= 0.0, np.diff(w) <= 0.0)
    if np.any(wrong):
        raise ValueError(f"omega has {w[wrong][0]:.6g} rad/s; frequencies must be positive, each there once")
    if not np.all(z):
        raise ValueError(f"the value at {w[z == 0.0][0]:.6g} rad/s is 0; leave the frequency out")
    bias = () if quantity == "closed loop" or estimator not in BY else (BY[estimator],)
    size = nan if amplitude is None else number("amplitude", amplitude, positive=True)
    return MeasuredBode(w, z, noise, quantity, phased, size, (*notes, *bias))


def bode_of_records(
    time: ArrayLike, reference: ArrayLike, torque: ArrayLike, speed: ArrayLike, *, held: bool = True,
    amplitude: float | None = None, notes: tuple[str, ...] = (),
) -> MeasuredBode:  # fmt: skip
    """Estimate the plant from records of its closed loop, the reference being the instrument: P = S_ry/S_ru.

    The plain H1 = S_uy/S_uu is biased, as the torque u holds the noise that the loop feeds back; the reference r does
    not. A reference that repeats is cut into its periods, the first left out, which leaves no leakage; another into
    half-overlapping segments with Hann's window.

    Parameters
    ----------
    time : (n,) array_like
        Times [s] in equal steps.
    reference, torque, speed : (n,) array_like
        What excites the loop, in any unit; torque [N*m] and speed [rad/s] of the motor.
    held : bool
        Whether the torque is constant from one sample to the next, as a controller gives it.
    amplitude, notes
        As of `measured_bode`.

    Returns
    -------
    MeasuredBode
        `value` (n,), complex, of the plant: motor speed over its torque [rad/(N*m*s)], with its `deviation` (n,) in
        the same unit, at the frequencies `omega` (n,) [rad/s] that are excited and where the noise leaves the plant.
        The deviations are those of the noise averaged over 9 frequencies; one of the `notes` says by how much H1
        would be off.

    Raises
    ------
    ValueError
        If the records do not fit, the steps are uneven, or nothing is excited.

    References
    ----------
    Pintelon & Schoukens 2012, System Identification: A Frequency Domain Approach, sec. 2.7 (periodic excitation in
    closed loop); Wellstead 1981, Automatica 17(1), 89-106 (indirect method).
    """
    t = numbers("time [s]", time)
    named = {"reference": reference, "torque [N*m]": torque, "speed [rad/s]": speed}
    rows = np.array([array_of(name, values, len(t)) for name, values in named.items()])
    step = even_step("the record", t)
    omega, (r, u, y), cut = _spectra(rows, step)
    if not np.ptp(rows[2]) > 0.0:
        raise ValueError(f"the speed is {rows[2, 0]:g} rad/s throughout; use a record in which the motor moves")
    S_ru, S_ry, power = np.sum(r.conj() * u, axis=0), np.sum(r.conj() * y, axis=0), np.sum(np.abs(r) ** 2, axis=0)
    P = S_ry / S_ru
    # averaged, as a weight with the torque's own noise would let in the bias of H1
    deviation = _noise(y - P * u, power) / np.sqrt(_mean(np.abs(S_ru) ** 2, NOISE_WIDTH))
    clear = np.abs(S_ru) > TORQUE_DEVIATIONS * _noise(u - S_ru / power * r, power)
    if np.sum(clear) < FEWEST_FREQUENCIES:
        raise ValueError(
            f"the torque follows the reference above its noise at {np.sum(clear)} frequencies; excite it more"
        )
    plain = np.sum(u.conj() * y, axis=0) / np.sum(np.abs(u) ** 2, axis=0)
    bias = _bias_sentence(omega[clear], (plain / P - 1.0)[clear], (deviation / np.abs(P))[clear])
    hidden = f"{np.sum(~clear)} of {len(clear)} frequencies, with too much noise were omitted"
    hold = f"the torque is assumed constant between samples, for {1e3 * step:.4g} ms"
    remarks = (*notes, cut, bias, *[hold][: int(held)], *[hidden][: int(not np.all(clear))])
    size = nan if amplitude is None else number("amplitude", amplitude, positive=True)
    return MeasuredBode(omega[clear], P[clear], deviation[clear], "plant", True, size, remarks, step if held else 0.0)


def _mean(values: Floats, count: int) -> Floats:
    """Mean (..., n) over so many neighbours."""
    return np.asarray(uniform_filter1d(values, min(count, values.shape[-1]), axis=-1, mode="nearest"))


def _noise(left: Complexes, power: Floats) -> Floats:
    """Standard deviation of sums over segments of the reference times what it leaves (segments, n) of a signal."""
    return np.asarray(np.sqrt(_mean(np.sum(np.abs(left) ** 2, axis=0), NOISE_WIDTH) / (len(left) - 1) * power))


def _bias_sentence(omega: Floats, difference: Complexes, deviation: Floats) -> str:
    """Sentence on the largest relative difference (n,) of H1 from the instrument's estimate, above its noise.

    Both the difference and the relative standard deviation (n,) of the estimate are averaged over neighbours.
    """
    size = np.hypot(*_mean(np.stack([difference.real, difference.imag]), BIAS_WIDTH))
    noise = np.sqrt(_mean(deviation**2, BIAS_WIDTH) / BIAS_WIDTH)
    sure = size > np.maximum(CLEAR_DEVIATIONS * noise, LEAST_DIFFERENCE)
    if not np.any(sure):
        return "a plain H1 estimate differs by less than the noise"
    worst = int(np.argmax(size * sure))
    return (
        f"a plain H1 estimate would be biased by noise in the loop: by {100.0 * size[worst]:.3g} % around "
        f"{omega[worst] / HERTZ:.4g} Hz"
    )


def _period(reference: Floats) -> int:
    """Samples after which a reference repeats; 0 where it does not twice."""
    r, n = reference - np.mean(reference), len(reference)
    products = np.fft.irfft(np.abs(np.fft.rfft(r, 2 * n)) ** 2, 2 * n)
    power, lags = np.append(0.0, np.cumsum(r * r)), np.arange(2 * FEWEST_FREQUENCIES, n // 2 + 1)
    both = power[n - lags] + power[n] - power[lags]
    return int(next(iter(lags[both - 2.0 * products[lags] <= PERIOD_DIFFERENCE * both]), 0))


def _spectra(rows: Floats, step: float) -> tuple[Floats, Complexes, str]:
    """Excited frequencies [rad/s], coefficients (rows, segments, frequencies), and a sentence on the cutting.

    Whole periods of the reference are taken, the first left out to settle; without a period, overlapping Hann windows.
    """
    n, size = rows.shape[1], _period(rows[0])
    starts, window = n - size * np.arange(1, n // max(size, 1) + 1)[::-1], np.ones(size)
    cut = f"{max(len(starts) - 1, 2)} periods of {size * step:.4g} s of the reference were used"
    if len(starts) > 2:
        starts = starts[1:]
    if not size:
        size = 2 * (n // (SEGMENTS + 1))
        starts, window = np.arange(SEGMENTS) * (size // 2), np.hanning(size + 1)[:-1]
        cut = (
            f"the reference does not repeat: segments of {size * step:.3g} s with Hann's window smear what is narrower "
            f"than {2.0 / max(size * step, step):.3g} Hz; repeat the sweep"
        )
    if size < 2 * FEWEST_FREQUENCIES:
        raise ValueError(f"the records have {n} samples, which is too short; record several sweeps")
    parts = np.stack([rows[:, start : start + size] for start in starts], axis=1)
    table = np.fft.rfft((parts - np.mean(parts, axis=2, keepdims=True)) * window, axis=2)[:, :, 1:]
    power = np.sum(np.abs(table[0]) ** 2, axis=0)
    excited = (power > EXCITED_POWER * np.max(power)) & np.all(table[1] != 0.0, axis=0)
    if np.sum(excited) < FEWEST_FREQUENCIES:
        raise ValueError(f"the reference excites {np.sum(excited)} frequencies of the torque; sweep it, or add lines")
    omega = 2.0 * pi * np.arange(1, len(power) + 1) / (size * step)
    return omega[excited], table[:, :, excited], cut
