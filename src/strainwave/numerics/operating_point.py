"""The operating point: where a law carries a constant torque. Every part of the package asks here.

It is the torsion nearest to zero at which the torque is the mean one: of a law that rises at rest the first one on the
way from rest in the direction of the torque, where a slow load arrives and the stiffness is not negative. A law that
softens has a largest torque; beyond it there is no operating point. `loading` does the same for laws with memory.

Root of one function in a bracket, also one that asks for the values and is told them; roots of polynomials.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..base.law import breakpoints_of
from ..base.quantities import shown
from ..base.results import Floats
from ..base.sentences import Angle, Sentence
from ..compile.jit import routine

# Torsions looked at, over that of the linear law: 1.2 % apart, and 5 % for means over a vibration, which are smooth.
FINE = np.append(0.0, np.geomspace(1e-6, 1e6, 2401))
COARSE = np.append(0.0, np.geomspace(1e-6, 1e6, 601))
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
SHRINKINGS, HALVINGS = 80, 60  # of an interval around a largest torque, and of one around a root: to the last bit
ROUNDING = 4e-16  # share of the mean torque by which a largest torque may fall short of it

Function = Callable[[Any], Any]

STEPS = 200
OVERLAP = 1.1  # of the large and the small roots
NEARLY_REAL = 1e-3  # imaginary over real part of a root that rounding may have split off a double real one
A, FA, B, FB, SHARE = range(5)  # of a bracket: its latest place, its other end, and where between them to look next


def bracketed_root(f: Callable[[float], float], a: float, b: float, *, xtol: float, rtol: float = 1e-15) -> float:
    """Root of a continuous function between a and b, where it has opposite signs or is 0.

    Parameters
    ----------
    f : callable
        Function of one number.
    a, b : float
        Ends of the bracket.
    xtol, rtol : float
        The root is right to xtol + rtol |root|.

    Raises
    ------
    ValueError
        If f has the same sign at both ends.
    """
    fa, fb = f(a), f(b)
    if fa * fb > 0.0:
        raise ValueError(f"f has one sign at both ends of ({a:g}, {b:g}): {fa:g} and {fb:g}; widen the bracket")
    bracket = [a, fa, b, fb, 0.5]
    for _ in range(STEPS):
        a, fa, b, fb, _share = bracket
        best, least = (a, fa) if abs(fa) < abs(fb) else (b, fb)
        tolerance = xtol + rtol * abs(best)
        if 2.0 * tolerance >= abs(b - a) or least == 0.0:
            break
        x = next_place(bracket, tolerance)
        narrow(bracket, x, f(x))
    return bracket[A] if abs(bracket[FA]) < abs(bracket[FB]) else bracket[B]


@routine
def next_place(bracket: Any, tolerance: float) -> float:
    """Where to ask for a value next, no nearer to an end of the bracket than the tolerance."""
    width = bracket[B] - bracket[A]
    least = min(0.5, tolerance / abs(width))
    return float(bracket[A] + min(1.0 - least, max(least, bracket[SHARE])) * width)


@routine
def narrow(bracket: Any, x: float, fx: float) -> None:
    """Make a place inside the latest of the bracket."""
    a, fa, b, fb = bracket[A], bracket[FA], bracket[B], bracket[FB]
    c, fc = a, fa
    if math.copysign(1.0, fx) != math.copysign(1.0, fa):
        c, b, fc, fb = b, a, fb, fa
    xi, phi = (x - b) / (c - b), (fx - fb) / (fc - fb)
    share = 0.5
    if phi * phi < xi and (1.0 - phi) ** 2 < 1.0 - xi:
        share = fx / (fb - fx) * fc / (fb - fc) + (c - x) / (b - x) * fx / (fc - fx) * fb / (fc - fb)
    bracket[A], bracket[FA], bracket[B], bracket[FB], bracket[SHARE] = x, fx, b, fb, share


def positive_roots(*coefficients: Any) -> Floats:
    """Positive real roots of many polynomials at once, as eigenvalues of companion matrices.

    The large ones are those of the polynomial, the small ones those of the polynomial of 1/s: each is right to its own
    size.

    Parameters
    ----------
    coefficients : (...) arrays
        Highest power first; the first ones may be 0. There are no roots where the last one is.

    Returns
    -------
    (2 degree, ...) array
        Not finite where there are fewer. A root may be listed twice. A pair that rounding may have split off a double
        root is listed too: it is to be corrected, and may be none.
    """
    with np.errstate(all="ignore"):
        c = np.stack(np.broadcast_arrays(*coefficients), axis=-1).astype(float)
        mean = np.abs(c[..., -1] / c[..., 0]) ** (1.0 / (c.shape[-1] - 1))
        large, small = _positive(c), 1.0 / _positive(c[..., ::-1])
        large[~(large > mean / OVERLAP)], small[~(small < mean * OVERLAP)] = np.nan, np.nan
        return np.where(c[..., -1] != 0.0, np.concatenate([large, small]), np.nan)


def _positive(c: Floats) -> Floats:
    """Nearly real positive roots (degree, ...) of polynomials (..., degree + 1), highest power first."""
    powers = np.arange(1.0, c.shape[-1])
    monic = c[..., 1:] / c[..., :1]
    size = np.max(np.abs(monic) ** (1.0 / powers), axis=-1)
    sound = np.isfinite(size) & (size > 0.0)
    scaled = monic / np.where(sound, size, 1.0)[..., None] ** powers
    companion = np.zeros((*sound.shape, len(powers), len(powers)))
    companion[..., 0, :] = np.where(sound[..., None], -scaled, 0.0)
    companion[..., np.arange(1, len(powers)), np.arange(len(powers) - 1)] = 1.0
    root = np.linalg.eigvals(companion).astype(complex)
    good = sound[..., None] & (root.real > 0.0) & (np.abs(root.imag) <= NEARLY_REAL * root.real)
    return np.moveaxis(np.where(good, (root.real + root.imag) * size[..., None], np.nan), -1, 0)


def operating_point(law: Any, mean: float) -> float:
    """Torsion [rad] nearest to zero at which a spring carries the mean torque [N*m].

    Raises
    ------
    ValueError
        If no torsion carries it; the sentence says how much the law carries.
    """
    if not hasattr(law, "torque"):
        raise TypeError(f"{shown(law)} has no torque; give a law, such as Cubic(1.0, 0.1)")
    offset = float(law.torque(0.0)) - mean
    if offset == 0.0:
        return 0.0

    def missing(x: Any) -> Any:
        return law.torque(x) - mean

    way = _way(law, np.array([offset]), np.array([float(law.stiffness(0.0))]), FINE)
    (low,), (high,) = _bracket(missing, way, ROUNDING * abs(mean))
    if math.isnan(high):
        at, missed = _largest(lambda x: way.toward * missing(x), way.places)
        raise ValueError(too_much(law, mean, mean + float((way.toward * missed)[0]), float(at[0])))
    return root_between(lambda x: float(missing(x)), float(low), float(high), xtol=1e-300)


def operating_points(law: Any, mean: Floats, wave: Any = 0.0) -> Floats:
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

    def missing(x: Floats) -> Any:
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


def first_reached(f: Function, places: Floats, slack: Floats | float = 0.0) -> tuple[Floats, Floats]:
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
        low, high = np.where(some, [places[first - 1, lanes], places[first, lanes]], np.nan)
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


def _bracket(missing: Function, scan: _Way, slack: Floats | float) -> tuple[Floats, Floats]:
    """Bracket of the root nearest to zero; a law that falls at rest may have it on either side."""

    def crossed(x: Floats) -> Any:
        return scan.toward * missing(x)

    low, high = first_reached(crossed, scan.places, slack)
    if not scan.falls.any():
        return low, high
    opposite = first_reached(crossed, -scan.places, slack)
    nearer = scan.falls & ~np.isnan(opposite[1]) & ~(np.abs(high) <= np.abs(opposite[1]))
    return np.where(nearer, opposite[0], low), np.where(nearer, opposite[1], high)


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
