"""Intervals of speed [rad/s]: spans (low, high), or arrays (n, 2) of them, ascending and apart."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from math import log, sqrt

import numpy as np
from numpy.typing import NDArray

from ...base.number_text import number
from ...base.results import Floats
from ...drive.speeds import BASES, Speeds

NARROW_WIDTH = 1e-3  # relative width of a band below which it is none: a step of the curve, or what rounding leaves
FOLD_WIDTH = 1e-3  # relative width within which a motion at a fold may be found stable or not

Span = tuple[float, float]


def between(bands: Iterable[tuple[float, ...]], within: Span, narrow: float = NARROW_WIDTH) -> tuple[Span, ...]:
    """Parts of a range that no band covers; bands are ascending and apart, relatively `narrow` parts are left out."""
    pieces = list(pairwise([within[0], *(end for band in bands for end in band), within[1]]))[::2]
    return tuple((float(low), float(high)) for low, high in pieces if high > low * (1.0 + narrow) or len(pieces) == 1)


def merged(bands: Iterable[tuple[float, ...]]) -> tuple[Span, ...]:
    """Bands of speed, ascending and apart."""
    bands_apart: list[list[float]] = []
    for low, high in sorted(bands):
        if bands_apart and low <= bands_apart[-1][1]:
            bands_apart[-1][1] = max(bands_apart[-1][1], high)
        else:
            bands_apart.append([low, high])
    return tuple((low, high) for low, high in bands_apart)


def hulls_between(first: tuple[Span, ...], second: tuple[Span, ...]) -> Iterator[Span]:
    """Hulls of the bands of two torques that belong together: each with the nearest of the other torque."""
    for bands, others in ((first, second), (second, first)):
        for band in bands:
            if others:
                nearest = min(others, key=lambda other: abs(log(_middle(other) / _middle(band))))
                yield min(band[0], nearest[0]), max(band[1], nearest[1])


def swept(first: Floats, second: Floats) -> list[Span]:
    """Bands of two loads, and what those that belong together pass between the loads."""
    left, right = [tuple((float(low), float(high)) for low, high in bands) for bands in (first, second)]
    return [*left, *right, *hulls_between(left, right)]


def gaps(spans: list[Span], within: Span) -> list[Span]:
    """Parts of a range that no span covers; gaps narrower than a fold is sharp are left out."""
    return list(between(clipped(spans, within), within, FOLD_WIDTH))


def clipped(spans: list[Span], within: Span) -> Floats:
    """Intervals inside a range, merged."""
    inside = [(max(low, within[0]), min(high, within[1])) for low, high in spans]
    return as_intervals(merged([span for span in inside if span[0] < span[1]]))


def complement(intervals: Floats, within: Span) -> Floats:
    """Intervals of a range that are not among these."""
    return as_intervals(between(intervals, within, 0.0))


def common(first: Floats, second: Floats) -> Floats:
    """Intersection of two sets of intervals."""
    pairs = [(max(a, c), min(b, d)) for a, b in first for c, d in second]
    return as_intervals(merged([pair for pair in pairs if pair[0] < pair[1]]))


def as_intervals(spans: object) -> Floats:
    """Array (n, 2) of spans."""
    return np.array(spans, float).reshape(-1, 2)


def holds(intervals: Floats, omega: Floats) -> NDArray[np.bool_]:
    """True if speeds (n,) lie in the intervals, (n,) bool."""
    inside = (omega[:, None] >= intervals[:, 0]) & (omega[:, None] <= intervals[:, 1])
    return np.asarray(np.any(inside, axis=1))


def windows(forbidden: Sequence[Floats], span: Span, joined: Sequence[bool]) -> Floats:
    """Speeds allowed under all loads; bands of two neighbours that are `joined`, (n - 1,) flags, enclose none."""
    pairs = [pair for pair, both in zip(pairwise(forbidden), joined, strict=True) if both]
    bands = [band for first, second in (*((one, one) for one in forbidden), *pairs) for band in swept(first, second)]
    return as_intervals(between(clipped(bands, span), span))


def listed(intervals: Floats, axis: Speeds = BASES["motor"]) -> str:
    """Intervals of a speed, in rpm of the motor or rad/s of a forcing."""
    return ", ".join(f"{number(low * axis.scale, 5)} to {axis.said(high, 5)}" for low, high in np.asarray(intervals))


def _middle(band: Span) -> float:
    return sqrt(band[0] * band[1])
