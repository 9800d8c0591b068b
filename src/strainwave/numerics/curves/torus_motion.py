"""Motion of two turns: its beat in every turn of the motor, and its states."""

import math
from fractions import Fraction
from typing import Any

import numpy as np

from ...base.results import Booleans, Floats
from ..balance.condensed.pencil import to_complex
from .torus_problem import Torus

PER_WAVE, FEWEST, BESIDE = 24, 96, 3  # samples in a period of the highest wave, at least; beside one for a polynomial
STARTING, STARTED = 384, 192  # angles at least where the smallest turn may begin, and the largest
SCREEN_SAMPLES = 64  # samples that tell whether a turn may be the largest
REFINED = 4  # steps of Newton's method
SMALL_WAVE = 1e-2  # of the largest wave: those below it do not count for the steps
SAMPLES = 250_000  # of motions at a time: these stay in the cache
WAVES = 2_000  # of motions whose coordinates are found at a time
LARGEST_TURNS = 1000  # turns of the motor after which motor and output stand as before, at most, or of one output turn


def turns_of(ratio: float) -> int:
    """Motor turns after which motor and output stand as before, or most nearly so where these are too many."""
    return Fraction(ratio).limit_denominator(max(1, int(LARGEST_TURNS / ratio))).numerator


def largest_in_turns(waves: Any, pairs: Any, ratio: float) -> Floats:
    """Largest oscillation (n, turns) of motions over a turn of the motor that begins in each turn.

    The oscillation is the largest |x - mean| from the angle where the turn begins, any angle, to a turn later. The
    motions have the complex amplitudes `waves` (n, P + 1) of `pairs` (P + 1, 2), the first of them (0, 0). Crests are
    those of polynomials through seven samples, right to 1e-6 of the largest wave; one within a sample of an end of a
    turn may count to either side of it.
    """
    return _sizes(largest_of_turns, waves, pairs, ratio, STARTED)


def smallest_in_turns(waves: Any, pairs: Any, ratio: float) -> Floats:
    """Smallest oscillation (n, turns), as `largest_in_turns`."""
    return _sizes(smallest_of_turns, waves, pairs, ratio, STARTING)


def _sizes(measure: Any, waves: Any, pairs: Any, ratio: float, starting: int) -> Floats:
    """A measure (n, turns) of x and its mean in every turn of motions (n, pairs), from so many places of a turn."""
    order = pairs @ np.array([1.0, 1.0 / ratio])
    means, places = _of_means(order), _places(waves, order, starting)
    parts = _parts(waves, pairs, ratio, places)
    # x and its means over a turn are summed together: the lower half of each is the means
    both = (_in_turns(np.concatenate([part, means * part]), pairs, ratio, places) for part in parts)
    sizes = [measure(*np.split(each, 2)) for each in both]
    return np.tile(np.concatenate(sizes), (1, turns_of(ratio) // sizes[0].shape[1]))


def largest_oscillations(waves: Any, pairs: Any, ratio: float) -> Floats:
    """Largest oscillation (n,) of motions, as `largest_in_turns`, from those turns that may have it."""
    return _among(waves, pairs, ratio, STARTED, _may_be_largest, largest_of_turns, np.maximum)


def smallest_oscillations(waves: Any, pairs: Any, ratio: float) -> Floats:
    """Smallest oscillation (n,) of motions, as `smallest_in_turns`, from those turns that may have it."""
    return _among(waves, pairs, ratio, STARTING, _may_be_smallest, smallest_of_turns, np.minimum)


def _among(
    waves: Any, pairs: Any, ratio: float, starting: int, may_be: Any, measure: Any, extreme: np.ufunc
) -> Floats:  # fmt: skip
    """A measure (n,) of motions from those turns that may have its extreme.

    Few samples of a turn leave bounds of its oscillation: between them a wave bends by its order squared at most.
    """
    order, sizes = pairs @ np.array([1.0, 1.0 / ratio]), []
    means, places = _of_means(order), _places(waves, order, starting)
    for part in _parts(waves, pairs, ratio, places):
        both = np.concatenate([part, means * part])
        x, mean = np.split(_in_turns(both, pairs, ratio, SCREEN_SAMPLES)[..., BESIDE:-BESIDE], 2)
        missed = np.square(np.pi / SCREEN_SAMPLES) * (np.abs(part) @ np.square(order))[:, None]
        number, turn = np.nonzero(may_be(x, mean[:, :-1], missed))
        twice = np.concatenate([number, number + len(part)]), np.tile(turn, 2)
        rows = np.split(_in_turns(both, pairs, ratio, places, twice), 2)
        sizes.append(extreme.reduceat(measure(*rows)[:, 0], np.searchsorted(number, np.arange(len(part)))))
    return np.concatenate(sizes)


def _may_be_largest(x: Floats, mean: Floats, missed: Floats) -> Booleans:
    high, low = x.max(axis=2), x.min(axis=2)
    above = np.maximum(high[:, :-1], high[:, 1:]) - mean.min(axis=2)
    below = mean.max(axis=2) - np.minimum(low[:, :-1], low[:, 1:])
    sure = np.maximum(high[:, :-1] - mean[..., 0], mean[..., 0] - low[:, :-1]).max(axis=1, keepdims=True)
    return np.asarray(np.maximum(above, below) + missed >= sure)


def _may_be_smallest(x: Floats, mean: Floats, missed: Floats) -> Booleans:
    (high, later_high), (low, later_low) = _extremes_of_turns(x)
    size = np.maximum(np.maximum(high, later_high) - mean, mean - np.minimum(low, later_low))
    above = np.maximum(high[..., 1:], later_high[..., :-1]) - np.maximum(mean[..., 1:], mean[..., :-1])
    below = np.minimum(mean[..., 1:], mean[..., :-1]) - np.minimum(low[..., 1:], later_low[..., :-1])
    least = np.maximum(above, below).min(axis=2) - missed  # between two samples the turn holds all but these
    return np.asarray(least <= size.min(axis=(1, 2))[:, None] + missed)


def _of_means(order: Floats) -> Any:
    """Factors (P + 1,) that make of waves those of the mean over the turn that begins at each angle."""
    means = np.ones(len(order), complex)
    np.divide(np.exp(2j * np.pi * order) - 1.0, 2j * np.pi * order, out=means, where=order != 0.0)
    return means


def largest_sizes(waves: Any, pairs: Any, ratio: float) -> Floats:
    """Largest |x| (n,) of motions, as `largest_in_turns`."""
    places = _places(waves, pairs @ np.array([1.0, 1.0 / ratio]), FEWEST)
    parts = (_in_turns(part, pairs, ratio, places) for part in _parts(waves, pairs, ratio, places))
    return np.concatenate([np.abs(with_extremes(x)).max(axis=(1, 2)) for x in parts])


def largest_of_turns(x: Floats, mean: Floats) -> Floats:
    """Largest oscillation (n, turns) from samples (n, turns + 1, samples + 1 + 2 `BESIDE`).

    `mean` is that of the turn that begins at each sample. A turn from any sample is the end of one and the beginning of
    the next. Where the oscillation is largest, a crest of x - mean is at an end of the turn, or the mean is an extreme.
    """
    tops, bottoms = _extremes_of_turns(with_extremes(x))
    extreme, rise = with_extremes(mean)[:, :-1], np.diff(mean[:, :-1, BESIDE - 1 : 1 - BESIDE])
    inside = np.maximum(np.maximum(*tops) - extreme, extreme - np.minimum(*bottoms))
    inside[..., 1:-1] *= rise[..., 1:-2] * rise[..., 2:-1] <= 0.0
    inside = inside.max(axis=2)
    ends = [np.abs(with_extremes(part - mean[:, :-1])).max(axis=2) for part in (x[:, :-1], x[:, 1:])]
    return np.asarray(np.maximum(inside, np.maximum(*ends)))


def smallest_of_turns(x: Floats, mean: Floats) -> Floats:
    """Smallest oscillation (n, turns), as `largest_of_turns`."""
    drift = mean[:, :-1, BESIDE:-BESIDE]
    tops, bottoms = map(np.array, _extremes_of_turns(with_extremes(x)))
    falling, rising = np.maximum(tops - drift, drift - bottoms)
    apart = falling - rising  # the smaller the turn, the nearer are what leaves it and what comes in
    step, crosses = np.diff(apart), (apart[..., :-1] > 0.0) & (apart[..., 1:] < 0.0)
    between = falling[..., :-1] - np.diff(falling) * apart[..., :-1] / np.where(crosses, step, 1.0)
    smallest = np.where(crosses, between, np.inf).min(axis=2)
    return np.asarray(np.minimum(smallest, np.maximum(falling, rising).min(axis=2)))


def _extremes_of_turns(x: Floats) -> tuple[tuple[Floats, Floats], tuple[Floats, Floats]]:
    """Highest and lowest values from each sample to the end of its turn, and from there to a turn after it."""
    before, after = x[:, :-1, ::-1], x[:, 1:]
    tops = np.maximum.accumulate(before, axis=2)[..., ::-1], np.maximum.accumulate(after, axis=2)
    return tops, (np.minimum.accumulate(before, axis=2)[..., ::-1], np.minimum.accumulate(after, axis=2))


def _places(waves: Any, order: Floats, least: int) -> int:
    """Samples of a turn: of each wave so many that a polynomial through seven misses 1e-6 of the largest wave."""
    sizes = np.abs(waves[:, 1:])
    share = np.max(sizes / (np.max(sizes, axis=1, keepdims=True) + 1e-300), axis=0, initial=0.0)
    return max(least, math.ceil(PER_WAVE * float(np.max(np.abs(order[1:]) * share ** (1.0 / 7.0), initial=0.0))))


def _repeats(pairs: Any, ratio: float) -> int:
    """Turns of the motor after which motions of these pairs repeat."""
    return turns_of(ratio) // math.gcd(turns_of(ratio), *pairs[:, 1].tolist())


def _parts(waves: Any, pairs: Any, ratio: float, places: int) -> list[Any]:
    """Motions so many at a time that their samples fit."""
    batch = max(1, SAMPLES // ((_repeats(pairs, ratio) + 1) * places))
    return np.array_split(waves, math.ceil(len(waves) / batch))


def _in_turns(waves: Any, pairs: Any, ratio: float, places: int, only: Any = None) -> Floats:
    """Samples (n, turns + 1, samples) of motions until they repeat, `BESIDE` of them before and after each turn.

    `only` those motions (m,) in those turns (m,), with the turn after each: (m, 2, samples).
    """
    order, (ks, group) = pairs @ np.array([1.0, 1.0 / ratio]), np.unique(pairs[:, 1], return_inverse=True)
    theta = 2.0 * np.pi / places * np.arange(-BESIDE, places + BESIDE + 1)
    table = np.exp(1j * np.outer(order, theta))
    turned = np.exp(2j * np.pi / ratio * np.outer(np.arange(_repeats(pairs, ratio) + 1), ks))
    turned = np.concatenate([turned.real, -turned.imag], axis=1)
    along = np.stack([waves[:, group == i] @ table[group == i] for i in range(len(ks))], axis=1)
    along = np.concatenate([along.real, along.imag], axis=1)
    if only is None:
        return np.asarray(turned @ along)
    chosen = [turned[only[1][only[0] == i][:, None] + np.arange(2)] @ along[i] for i in range(len(waves))]
    return np.concatenate(chosen)


def with_extremes(values: Floats) -> Floats:
    """Samples (n, turns, samples) without those beside a turn; those at crests are as high as these."""
    inner = values[..., BESIDE:-BESIDE].copy()
    after, before = values[..., BESIDE + 1 : 1 - BESIDE], values[..., BESIDE - 1 : -BESIDE - 1]
    crests = np.nonzero((after - inner) * (inner - before) <= 0.0)
    s = np.arange(-BESIDE, BESIDE + 1)
    c = np.linalg.inv(np.vander(s, increasing=True)) @ values[crests[0], crests[1], crests[2] + BESIDE + s[:, None]]
    slope, x = np.arange(1, len(c))[:, None] * c[1:], np.zeros(len(crests[0]))
    bend = np.arange(1, len(slope))[:, None] * slope[1:]
    for _ in range(REFINED):
        step = np.divide(polyval(x, slope), polyval(x, bend), out=np.zeros_like(x), where=c[2] != 0.0)
        x = np.clip(x - step, -1.0, 1.0)
    inner[crests] = polyval(x, c)
    return np.asarray(inner)


def polyval(x: Floats, c: Floats) -> Floats:
    """Values (n,) of polynomials with coefficients c (degree + 1, n), the constant ones first."""
    value = np.zeros_like(x)
    for row in c[::-1]:
        value = value * x + row
    return value


def pointing(problem: Torus, points: Floats) -> Any:
    """Complex amplitudes (n, P + 1) of the pointing error in motions."""
    parts = np.array_split(points, math.ceil(len(points) * len(problem.pairs) / WAVES))
    return np.concatenate([problem.coordinates(part) @ problem.part.values[0] for part in parts])


def states_at(problem: Torus, points: Floats, phase: Floats) -> list[Floats]:
    """States (states, n) of the system in each of some motions at base angles (n,) [rad]."""
    turned = np.outer(problem.orders, phase)
    part, even, odd, result = problem.part, np.cos(turned), np.sin(turned), []
    for z in points:
        waves = problem.coordinates(z)
        rates = waves * (1j * problem.orders * z[-1])[:, None]
        state = part.values @ waves.T + part.rates @ rates.T
        result.append(state.real @ even - state.imag @ odd)
    return result


def along_turns(problem: Torus, points: Floats, beats: int) -> tuple[Floats, list[Floats]]:
    """Angles (n,) [rad] of the motor until motions repeat, and the states (states, n) of each at them."""
    count = turns_of(problem.ratio)
    count //= math.gcd(count, beats)
    places = max(FEWEST, PER_WAVE * math.ceil(float(np.max(highest(problem, points)))))
    angles: Floats = 2.0 * np.pi / places * np.arange(float(count * places))
    return angles, states_at(problem, points, angles)


def highest(problem: Torus, points: Floats) -> Floats:
    """Highest orders (n,) of the waves that count in motions."""
    sizes = np.abs(to_complex(problem.blocks(points))).max(axis=0)[:, 1:]
    counted = sizes > SMALL_WAVE * sizes.max(axis=1, keepdims=True)
    return np.asarray(np.max(np.abs(problem.orders[1:]) * counted, axis=1))
