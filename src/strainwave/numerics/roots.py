"""Roots of a function in a bracket or along a path, and of polynomials.

`next_place` and `narrow` serve callers that evaluate the function themselves.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from ..base.results import Floats
from ..compile.jit import routine

GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
SHRINKINGS = 80  # of an interval around a largest torque: to the last bit
Function = Callable[[Any], Any]
STEPS = 200  # of a bracket, at most
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
    """Next place for a value, no nearer to an end of the bracket than the tolerance."""
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


def first_reached(f: Function, places: Floats, slack: float = 0.0) -> tuple[float, float]:
    """Places between which a function first reaches zero from below on its way; nan where it does not.

    A summit between two places counts too.

    Parameters
    ----------
    f : callable
        Values at places, one or (n,).
    places : (n,) array
        The way, rising or falling.
    slack : float
        Distance below zero at which a summit counts as zero.
    """
    with np.errstate(all="ignore"):
        values = np.asarray(f(places), float) + 0.0 * places[0]
        values = np.where(np.isnan(values), -np.inf, values)
        reached = np.flatnonzero(values >= 0.0)
        first = int(reached[0]) if len(reached) else len(values)
        for j in _summits(values[: first + 1]).tolist():
            summit, value = _summit(f, places[j - 1], places[j + 1])
            if value >= -slack:
                return (float(places[j - 1]) if value > 0.0 else summit), summit
    return (float(places[first - 1]), float(places[first])) if len(reached) else (math.nan, math.nan)


def root_between(f: Callable[[float], float], low: float, high: float, *, xtol: float) -> float:
    """Root in what `first_reached` gives: `high` where that is no bracket, at a summit or by rounding."""
    return high if f(low) * f(high) >= 0.0 else bracketed_root(f, low, high, xtol=xtol)


def _summits(values: Floats) -> Any:
    """Places of inner values (n,) that stand at a summit that may reach zero before the values do.

    A parabola through a sample and its neighbours rises above it by an eighth of what the lower one falls at most.
    """
    before, middle, after = values[:-2], values[1:-1], values[2:]
    return 1 + np.flatnonzero((middle > before) & (middle >= after) & (2.0 * middle >= np.minimum(before, after)))


def _largest(f: Function, places: Floats) -> tuple[float, float]:
    """Place and value of the largest value on the way."""
    with np.errstate(all="ignore"):
        values = np.nan_to_num(f(places), nan=-np.inf, posinf=-np.inf)
        j = min(max(int(values.argmax()), 1), len(values) - 2)
        return _summit(f, places[j - 1], places[j + 1])


def _summit(f: Function, a: Any, b: Any) -> tuple[float, float]:
    """Place and value of the largest value between places, by golden sections."""
    left, right = b - GOLDEN * (b - a), a + GOLDEN * (b - a)
    f_left, f_right = f(left), f(right)
    for _ in range(SHRINKINGS):
        a, b = (a, right) if f_left > f_right else (left, b)
        left, right = b - GOLDEN * (b - a), a + GOLDEN * (b - a)
        f_left, f_right = f(left), f(right)
    return (float(left), float(f_left)) if f_left > f_right else (float(right), float(f_right))
