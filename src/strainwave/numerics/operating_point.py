"""The operating point: where a law carries a constant torque. Every part of the package asks here.

It is the torsion nearest to zero at which the torque is the mean one: of a law that rises at rest the first one on the
way from rest in the direction of the torque, where a slow load arrives and the stiffness is not negative. A law that
softens has a largest torque; beyond it there is no operating point. `loading` does the same for laws with memory.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..law import breakpoints_of
from ..results import Floats
from ..sentences import Angle, Sentence
from .roots import bracketed_root

# Torsions looked at, over that of the linear law: 1.2 % apart, and 5 % for means over a vibration, which are smooth.
FINE, COARSE = (np.concatenate([[0.0], np.geomspace(1e-6, 1e6, count)]) for count in (2401, 601))
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
SHRINKINGS, HALVINGS = 80, 60  # of an interval around a largest torque, and of one around a root: to the last bit
ROUNDING = 4e-16  # share of the mean torque by which a largest torque may fall short of it

Function = Callable[[Any], Any]


def operating_point(law: Any, mean: float) -> float:
    """Torsion [rad] nearest to zero at which a spring carries the mean torque [N*m].

    Raises
    ------
    ValueError
        If no torsion carries it; the sentence says how much the law carries.
    """
    offset = float(law.torque(0.0)) - mean
    if offset == 0.0:
        return 0.0

    def missing(x: Any) -> Any:
        return law.torque(x) - mean

    way = _way(law, np.array([offset]), np.array([float(law.stiffness(0.0))]), FINE)
    low, high = (float(end[0]) for end in _bracket(missing, way, ROUNDING * abs(mean)))
    if math.isnan(high):
        at, missed = _largest(lambda x: way.toward * missing(x), way.places)
        raise ValueError(too_much(law, mean, mean + float((way.toward * missed)[0]), float(at[0])))
    return root_between(lambda x: float(missing(x)), low, high, xtol=1e-300)


def operating_points(law: Any, mean: Any, wave: Any = 0.0) -> Floats:
    """Torsions (lanes,) [rad] nearest to zero at which springs carry their mean torques; nan where none does.

    Parameters
    ----------
    law : NamedTuple
        Law whose fields are numbers or arrays (lanes,).
    mean : (lanes,) array
        Mean torques [N*m].
    wave : (samples, 1) or (samples, lanes) array, optional
        Motion [rad] about the torsion, over whose samples the torque is averaged.
    """
    mean, wave = np.asarray(mean, float), np.asarray(wave, float)

    def missing(x: Any) -> Any:
        if not wave.ndim:
            return law.torque(x) - mean
        return np.mean(law.torque(x + wave.reshape(len(wave), *[1] * (np.ndim(x) - 1), -1)), axis=0) - mean

    offset = missing(np.zeros(len(mean))) + 0.0 * mean
    slope = law.stiffness(wave) + np.zeros(len(mean))
    slope = np.mean(slope, axis=0) if wave.ndim else slope
    way = _way(law, offset, slope, COARSE if wave.ndim else FINE)
    low, high = _bracket(missing, way, ROUNDING * np.abs(mean))
    with np.errstate(all="ignore"):
        rising = missing(high) >= missing(low)
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            beyond = (missing(middle) >= 0.0) == rising
            low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
    return np.where(offset == 0.0, 0.0, high)


def too_much(law: Any, mean: float, largest: float, at: float) -> str:
    """Sentence about a mean torque [N*m] that a law does not carry, whose largest torque is at a torsion [rad]."""
    return Sentence(
        f"{type(law).__name__} carries at most {largest:.6g} N*m, at {{}}, and the mean torque is {mean:.6g} N*m; "
        "lower the mean torque or stiffen the law",
        Angle(at, digits=3),
    )


def first_reached(f: Function, places: Floats, slack: Any = 0.0) -> tuple[Floats, Floats]:
    """Places (lanes,) between which functions first reach zero from below on their ways; nan where they do not.

    A summit between two places counts too.

    Parameters
    ----------
    f : callable
        Values (..., lanes) at places (..., lanes).
    places : (n, lanes) array
        The ways, rising or falling.
    slack : (lanes,) array or float
        How far below zero a summit may stay and count as zero.
    """
    with np.errstate(all="ignore"):
        values = np.asarray(f(places), float) + 0.0 * places[0]
        values = np.where(np.isnan(values), -np.inf, values)
        reached = values >= 0.0
        some, first = reached.any(axis=0), reached.argmax(axis=0)
        if some.all():
            values = values[: first.max() + 2]
        lanes = np.arange(values.shape[1])
        low, high = (np.where(some, places[i, lanes], np.nan) for i in (first - 1, first))
        first = np.where(some, first, len(values))
        tops = _summits(values, first)
        while tops.any():
            j = tops.argmax(axis=0) + 1
            place, value = _summit(f, places[j - 1, lanes], places[j + 1, lanes])
            good = tops.any(axis=0) & (value >= -slack)
            low = np.where(good, np.where(value > 0.0, places[j - 1, lanes], place), low)
            high = np.where(good, place, high)
            tops[j - 1, lanes] = False
            tops[:, good] = False
    return low, high


def root_between(f: Callable[[float], float], low: float, high: float, *, xtol: float) -> float:
    """Root in what `first_reached` gives: `high` where that is no bracket, at a summit or by rounding."""
    return high if f(low) * f(high) >= 0.0 else bracketed_root(f, low, high, xtol=xtol)


class _Way(NamedTuple):
    """Places (n, lanes) [rad] from rest in the direction `toward` of the torque, and where the law falls at rest."""

    places: Floats
    toward: Floats
    falls: Any


def _way(law: Any, offset: Floats, slope: Floats, grid: Floats) -> _Way:
    """Way from rest, where the torque lies by an offset [N*m] above the mean one and has a slope [N*m/rad]."""
    toward = np.where(offset < 0.0, 1.0, -1.0)
    breaks = [np.abs(place) for place in breakpoints_of(law)]  # how far to look for the stiffness behind a gap
    far = np.max(np.array(np.broadcast_arrays(*breaks)), axis=0) if breaks else 1.0
    with np.errstate(all="ignore"):
        reach = np.where(offset == 0.0, 1.0, np.where(slope > 0.0, np.abs(offset) / slope, far))
    return _Way(toward * reach * grid[:, None], toward, slope < 0.0)


def _bracket(missing: Function, way: _Way, slack: Any) -> tuple[Floats, Floats]:
    """Bracket of the root nearest to zero; a law that falls at rest may have it on either side."""

    def below(x: Any) -> Any:
        return way.toward * missing(x)

    low, high = first_reached(below, way.places, slack)
    if not way.falls.any():
        return low, high
    other = first_reached(below, -way.places, slack)
    nearer = way.falls & ~np.isnan(other[1]) & ~(np.abs(high) <= np.abs(other[1]))
    return np.where(nearer, other[0], low), np.where(nearer, other[1], high)


def _summits(values: Floats, first: Any) -> Any:
    """Which inner values (n - 2, lanes) stand at a summit that may reach zero before the values do.

    A parabola through a sample and its neighbours rises above it by an eighth of what the lower one falls at most.
    """
    before, here, after = values[:-2], values[1:-1], values[2:]
    tops = (here > before) & (here >= after) & (np.arange(1, len(values) - 1)[:, None] < first)
    return tops & (2.0 * here >= np.minimum(before, after)) if tops.any() else tops


def _largest(f: Function, places: Floats) -> tuple[Floats, Floats]:
    """Place and value (lanes,) of the largest value on the ways."""
    with np.errstate(all="ignore"):
        values = np.nan_to_num(f(places), nan=-np.inf, posinf=-np.inf)
        j, lanes = np.clip(values.argmax(axis=0), 1, len(values) - 2), np.arange(values.shape[1])
        return _summit(f, places[j - 1, lanes], places[j + 1, lanes])


def _summit(f: Function, a: Floats, b: Floats) -> tuple[Floats, Floats]:
    """Place and value of the largest value between places, by golden sections."""
    left, right = b - GOLDEN * (b - a), a + GOLDEN * (b - a)
    f_left, f_right = f(left), f(right)
    for _ in range(SHRINKINGS):
        higher = f_left > f_right
        a, b = np.where(higher, a, left), np.where(higher, right, b)
        left, right = b - GOLDEN * (b - a), a + GOLDEN * (b - a)
        f_left, f_right = f(left), f(right)
    return np.where(f_left > f_right, left, right), np.maximum(f_left, f_right)
