"""The largest value over a period, between all samples: of a Fourier series, and of any values.

Coefficients are listed as results have them: mean, cos 1, sin 1, cos 2, sin 2, ...
"""

import math
from collections.abc import Callable
from functools import wraps
from threading import Lock
from typing import Any, ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..compile.jit import kernel, kernel_as, run

PER_HARMONIC, STEPS = 32, 3  # samples in a period of the highest harmonic; steps of Newton's method from the largest
SEARCH_POINTS = 17  # places between two others at which a highest one is looked for
MOST_BYTES = 4_000_000  # of the tables of a function that are remembered
P = ParamSpec("P")
Tables = TypeVar("Tables", bound="NDArray[np.float64] | tuple[NDArray[np.float64], ...]")


def remembered(function: Callable[P, Tables]) -> Callable[P, Tables]:
    """Function of an array or a tuple of arrays that remembers those it gave last, up to `MOST_BYTES` of them."""
    tables: dict[Any, Tables] = {}
    lock = Lock()

    def size(table: Tables) -> int:
        return table.nbytes if isinstance(table, np.ndarray) else sum(array.nbytes for array in table)

    @wraps(function)
    def recalled(*arguments: P.args, **named: P.kwargs) -> Tables:
        key = (arguments, *named.items())
        with lock:
            if key in tables:
                tables[key] = tables.pop(key)  # the last one: the first is the one that was used longest ago
                return tables[key]
        table = function(*arguments, **named)
        with lock:
            tables[key] = table
            while len(tables) > 1 and sum(map(size, tables.values())) > MOST_BYTES:
                del tables[next(iter(tables))]
        return table

    return recalled


def largest_size(coefficients: NDArray[np.float64]) -> NDArray[np.float64]:
    """Largest absolute values (n,) over the period of series (n, 2H+1), the sizes at their extremes."""
    count, width = coefficients.shape
    if width < 2 or not count:
        return np.asarray(np.abs(coefficients[:, 0]))
    out = np.empty(count)
    run(largest_in, np.ascontiguousarray(coefficients), _waves(width // 2), out, light=True)
    return out


@remembered
def _waves(harmonics: int) -> NDArray[np.float64]:
    """Table (2H, samples) of cos 1, sin 1, cos 2, ... at the samples of a period."""
    angles = 2.0 * np.pi / (PER_HARMONIC * harmonics) * np.arange(PER_HARMONIC * harmonics)
    turns = np.arange(1, harmonics + 1)[:, None] * angles
    return np.stack([np.cos(turns), np.sin(turns)], axis=1).reshape(2 * harmonics, -1)


def _largest_loops(c: NDArray[np.float64], waves: NDArray[np.float64], largest: NDArray[np.float64]) -> None:
    rows, samples = waves.shape
    step = 2.0 * math.pi / samples
    even, odd, sizes = np.empty(samples), np.empty(samples), np.empty(samples)
    for p in range(c.shape[0]):
        alternates = c[p, 0] == 0.0
        for k in range(3, rows, 4):
            alternates = alternates and c[p, k] == 0.0 and c[p, k + 1] == 0.0
        half = samples // (4 if alternates else 2) + 1
        for j in range(half):
            even[j], odd[j] = c[p, 0], 0.0
        for i in range(0, rows, 4 if alternates else 2):
            for j in range(half):
                even[j] += c[p, i + 1] * waves[i, j]
                odd[j] += c[p, i + 2] * waves[i + 1, j]
        # cosines are even over the period, sines are odd: the larger of both halves; of odd harmonics alone of all four
        for j in range(half):
            sizes[j] = abs(even[j]) + abs(odd[j])
        best = 0
        for j in range(1, half):
            if sizes[j] > sizes[best]:
                best = j
        angle, between = (step if even[best] * odd[best] >= 0.0 else -step) * best, 0.0
        for n in range(STEPS + 1):
            cos, sin = math.cos(angle), math.sin(angle)
            cosine, sine, between, slope, bend = cos, sin, c[p, 0], 0.0, 0.0
            for k in range(1, rows // 2 + 1):
                a, b = c[p, 2 * k - 1], c[p, 2 * k]
                between += a * cosine + b * sine
                slope += k * (b * cosine - a * sine)
                bend -= k * k * (a * cosine + b * sine)
                cosine, sine = cosine * cos - sine * sin, cosine * sin + sine * cos
            if n < STEPS and bend != 0.0:
                angle -= min(step, max(-step, slope / bend))
        largest[p] = max(sizes[best], abs(between))


@kernel_as(_largest_loops)
def largest_in(c: NDArray[np.float64], waves: NDArray[np.float64], largest: NDArray[np.float64]) -> None:
    """Write the largest absolute values of series, from samples and, between these, by Newton's method."""
    harmonics, step = len(waves) // 2, 2.0 * np.pi / waves.shape[1]
    samples = c[:, :1] + c[:, 1:] @ waves
    best = np.argmax(np.abs(samples), axis=1)
    waves = c[:, 1::2] - 1j * c[:, 2::2]
    k, angle = np.arange(1, harmonics + 1), step * best
    for _ in range(STEPS):  # for a zero of the slope, a step never further than to the next sample
        terms = waves * _turned(angle, harmonics)
        slope, bend = np.sum(-k * terms.imag, axis=1), np.sum(-k * k * terms.real, axis=1)
        angle -= np.clip(np.divide(slope, bend, out=np.zeros(len(c)), where=bend != 0.0), -step, step)
    between = np.abs(c[:, 0] + np.sum((waves * _turned(angle, harmonics)).real, axis=1))
    largest[:] = np.maximum(np.abs(samples[np.arange(len(c)), best]), between)


def _turned(angle: NDArray[np.float64], harmonics: int) -> NDArray[np.complex128]:
    """Powers exp(i k angle) (n, harmonics) of k = 1, 2, ..."""
    powers = np.empty((len(angle), harmonics), complex)
    powers[:, 0] = turn = np.exp(1j * angle)
    for k in range(1, harmonics):
        np.multiply(powers[:, k - 1], turn, out=powers[:, k])
    return powers


def oscillation(coefficients: NDArray[np.float64]) -> NDArray[np.float64]:
    """Largest distances (n,) from the mean over the period of series (n, 2H+1)."""
    waves = coefficients.copy()
    waves[:, 0] = 0.0
    return largest_size(waves)


def highest_between(
    arc: NDArray[np.float64], series: NDArray[np.float64], low: float, high: float, from_mean: bool
) -> tuple[float, float]:
    """Place in low .. high where the largest size is highest, and the size there, on the polynomial through series.

    The series (n, 2H+1) are those at places (n,) of an arc; `from_mean` counts sizes from the mean.
    """
    out = np.empty(2)
    waves = _waves(series.shape[1] // 2)
    run(highest_in, arc, np.ascontiguousarray(series), waves, low, high, from_mean, out, light=True)
    return float(out[0]), float(out[1])


def highest_in(arc: Any, series: Any, waves: Any, low: float, high: float, from_mean: bool, peak: Any) -> None:
    """Write the place and the size of what `highest_between` gives; `waves` is the table of all harmonics."""
    places, values, rows = np.empty(SEARCH_POINTS), np.empty(SEARCH_POINTS), np.empty((SEARCH_POINTS, series.shape[1]))
    best = 1
    for _ in range(2):
        for j in range(SEARCH_POINTS):
            places[j] = low + (high - low) * j / (SEARCH_POINTS - 1)
            interpolate(arc, places[j], series, rows[j])
            if from_mean:
                rows[j, 0] = 0.0
        largest_in(rows, waves, values)
        best = min(max(int(np.argmax(values)), 1), SEARCH_POINTS - 2)
        low, high = places[best - 1], places[best + 1]
    bend, rise = values[best - 1] - 2.0 * values[best] + values[best + 1], values[best - 1] - values[best + 1]
    if bend < 0.0:
        peak[0], peak[1] = places[best] + 0.25 * rise * (high - low) / bend, values[best] - rise * rise / (8.0 * bend)
    else:
        peak[0], peak[1] = places[best], values[best]


def _interpolate_loops(arc: Any, s: float, series: Any, values: Any) -> None:
    weights = weights_at(arc, s)
    for i in range(len(values)):
        values[i] = 0.0
        for a in range(len(arc)):
            values[i] += weights[a] * series[a, i]


@kernel_as(_interpolate_loops)
def interpolate(arc: NDArray[np.float64], s: float, series: Any, values: NDArray[np.float64]) -> None:
    """Write values (m,) at s of the polynomial through series (n, m) at places (n,) of an arc."""
    values[:] = weights_at(arc, s) @ series


@kernel
def weights_at(arc: Any, s: float) -> NDArray[np.float64]:
    """Weights (n,) at s of values at places (n,) of an arc, of the polynomial through them (Lagrange)."""
    weights = np.empty(len(arc))
    for a in range(len(arc)):
        weight = 1.0
        for b in range(len(arc)):
            if b != a:
                weight *= (s - arc[b]) / (arc[a] - arc[b])
        weights[a] = weight
    return weights


def largest_of_samples(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Largest absolute values (n,) over a period of what has these samples (n, places), equally spaced.

    That is the vertex of the parabola through the largest sample and those beside it, or that sample where the bends
    there and next to it differ by more than a factor of 2, as beside a jump or a corner.
    """
    sizes = np.abs(values)
    places = np.argmax(sizes, axis=1)[:, None] + np.arange(-2, 3)
    around = np.take_along_axis(sizes, places % sizes.shape[1], axis=1)
    return np.array([_vertex(*five) for five in around.tolist()])


def sizes_of_samples(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Sizes (n,) of equally spaced samples, those at crests as high as between them, as `largest_of_samples` has it."""
    sizes = np.abs(values)
    bend, rise, inner = -np.diff(sizes, 2), sizes[3:-1] - sizes[1:-3], sizes[2:-2]
    around = np.stack([bend[:-2], bend[1:-1], bend[2:]])
    low, high = np.min(around, axis=0), np.max(around, axis=0)
    crest = (inner >= sizes[1:-3]) & (inner >= sizes[3:-1]) & (low > 0.0) & (high <= 2.0 * low)
    sizes[2:-2] = np.where(crest, inner + rise**2 / (8.0 * np.where(crest, around[1], 1.0)), inner)
    return sizes


def _vertex(a: float, b: float, c: float, d: float, e: float) -> float:
    left, bend, right = 2.0 * b - a - c, 2.0 * c - b - d, 2.0 * d - c - e
    low, high = min(left, bend, right), max(left, bend, right)
    return c + (d - b) ** 2 / (8.0 * bend) if low > 0.0 and high <= 2.0 * low else c
