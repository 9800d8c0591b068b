"""Noise of measurements: numbers that are drawn anew for every sample and are the same in every run.

A number is a function of its seed, lane and place alone (the mixing function of Steele, Lea & Flood, Fast splittable
pseudorandom number generators, OOPSLA 2014): runs are reproducible to the bit, whatever thread computes a lane.
"""

import numpy as np

from ..compile.jit import kernel, kernel_as

_GOLDEN, _FIRST, _SECOND = 0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB
_ALL, _PIECE = 2**64 - 1, 0xFFFF
_SCALE = 3.0**0.5 / 65536.0  # the sum of four numbers, each even over 2^16, has the variance 2^32/3


def _mixed(place: int, shift: int) -> float:
    x = np.uint64(place) * np.uint64(_GOLDEN) + np.uint64(_GOLDEN)
    x = (x ^ (x >> np.uint64(30))) * np.uint64(_FIRST)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(_SECOND)
    x = x ^ (x >> np.uint64(31))
    return float(np.int64((x >> np.uint64(shift)) & np.uint64(_PIECE)))


@kernel_as(_mixed)
def piece(place: int, shift: int) -> float:
    """Whole number below 2^16 that belongs to a place: 16 bits, from bit `shift` on, of its 64 mixed ones."""
    x = (int(place) + 1) * _GOLDEN & _ALL
    x = (x ^ (x >> 30)) * _FIRST & _ALL
    x = (x ^ (x >> 27)) * _SECOND & _ALL
    x ^= x >> 31
    return float((x >> shift) & _PIECE)


@kernel
def place_of(seed: int, lane: int, sample: int, channel: int) -> int:
    """Place of a channel (0 to 3) in a sample of a lane."""
    return ((seed * 1048583 + lane) * 268435399 + sample) * 4 + channel


@kernel
def noise(seed: int, lane: int, sample: int, channel: int) -> float:
    """Noise of mean 0 and deviation 1, at most 3.46 in size: a sum of four even numbers."""
    at = place_of(seed, lane, sample, channel)
    return (piece(at, 0) + piece(at, 16) + piece(at, 32) + piece(at, 48) - 131070.0) * _SCALE


@kernel
def even(seed: int, lane: int, sample: int, channel: int) -> float:
    """Number that is evenly spread from 0 to 1."""
    return (piece(place_of(seed, lane, sample, channel), 0) + 0.5) / 65536.0
