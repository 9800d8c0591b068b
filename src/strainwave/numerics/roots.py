"""Root of one function in a bracket."""

import math
from collections.abc import Callable

STEPS = 200


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

    References
    ----------
    Chandrupatla 1997, Adv. Eng. Software 28, 145-149: inverse quadratic interpolation where it is safe, else bisection.
    """
    fa, fb = f(a), f(b)
    if fa * fb > 0.0:
        raise ValueError(f"f has one sign at both ends of ({a:g}, {b:g}): {fa:g} and {fb:g}; widen the bracket")
    share, c, fc = 0.5, a, fa
    for _ in range(STEPS):
        best, least = (a, fa) if abs(fa) < abs(fb) else (b, fb)
        room = abs(b - a)
        tolerance = (xtol + rtol * abs(best)) / room if room > 0.0 else 1.0
        if tolerance >= 0.5 or least == 0.0:
            break
        x = a + min(1.0 - tolerance, max(tolerance, share)) * (b - a)
        fx = f(x)
        if math.copysign(1.0, fx) == math.copysign(1.0, fa):
            c, fc = a, fa
        else:
            c, b, fc, fb = b, a, fb, fa
        a, fa = x, fx
        xi, phi = (a - b) / (c - b), (fa - fb) / (fc - fb)
        share = 0.5
        if phi * phi < xi and (1.0 - phi) ** 2 < 1.0 - xi:
            share = fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
    return a if abs(fa) < abs(fb) else b
