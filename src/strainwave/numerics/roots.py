"""Root of one function in a bracket, also one that asks for the values and is told them; roots of polynomials.

Chandrupatla 1997, Adv. Eng. Software 28, 145-149: inverse quadratic interpolation where it is safe, else bisection.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from ..compile.jit import routine
from ..results import Floats

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
