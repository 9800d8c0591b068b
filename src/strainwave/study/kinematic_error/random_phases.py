"""Sums of lines with unknown phases: random draws of them, and the peak-to-peak of each."""

import math
from functools import reduce
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...results import Floats

OVERSAMPLING = 32
CHUNK = 2_000_000  # values evaluated at a time


class Phasors(NamedTuple):
    """Sources on one base turn: distinct orders, which of them each source has, amplitudes, phases (nan: unknown)."""

    orders: NDArray[np.int64]
    place: NDArray[np.int64]
    amplitudes: Floats
    phases: Floats


def draw(phasors: Phasors, draws: int, seed: int) -> NDArray[np.complex128]:
    """Complex amplitudes (draws, orders) with unknown phases drawn uniformly."""
    drawn = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, (draws, len(phasors.phases)))
    phases = np.where(np.isnan(phasors.phases), drawn, phasors.phases)
    total = np.zeros((draws, len(phasors.orders)), complex)
    for i, place in enumerate(phasors.place):
        total[:, place] += phasors.amplitudes[i] * np.exp(1j * phases[:, i])
    return total


def span(orders: NDArray[np.int64], amplitudes: NDArray[np.complex128]) -> Floats:
    """Peak-to-peak (draws,) of the sums of Re(amplitudes exp(i orders t)).

    Extremes of a grid, refined by Newton's method: exact but where two extremes differ by less than 0.5 % of the whole,
    and then to that.

    Parameters
    ----------
    orders : (m,) int array
        Ascending.
    amplitudes : (draws, m) complex array
        Amplitudes and phases.
    """
    k = orders // reduce(math.gcd, (int(order) for order in orders))
    n = OVERSAMPLING * int(k[-1])
    size = max(1, CHUNK // n)
    spans = [_span(k, amplitudes[i : i + size], n) for i in range(0, len(amplitudes), size)]
    return np.concatenate(spans)


def _span(k: NDArray[np.int64], c: NDArray[np.complex128], n: int) -> Floats:
    series = np.zeros((len(c), n // 2 + 1), complex)
    series[:, k] = 0.5 * n * c
    values = np.fft.irfft(series, n, axis=1)
    ends = []
    for sign, tops in ((1.0, np.argmax(values, axis=1)), (-1.0, np.argmin(values, axis=1))):
        start = 2.0 * np.pi / n * tops[:, None]
        t = start
        for _ in range(3):
            turned = sign * c * np.exp(1j * k * t)
            slope = -(turned.imag * k).sum(1, keepdims=True)
            bend = -(turned.real * k * k).sum(1, keepdims=True)
            step = np.divide(slope, bend, out=np.zeros_like(slope), where=bend < 0.0)
            t = np.clip(t - step, start - 2.0 * np.pi / n, start + 2.0 * np.pi / n)
        refined = (sign * c * np.exp(1j * k * t)).real.sum(1)
        ends.append(np.maximum(refined, sign * values[np.arange(len(c)), tops]))
    return np.asarray(ends[0] + ends[1])
