"""The second order of multiple scales by SymPy, for a law with a square and a cube about the operating point.

With w = u - u0 the equation is w'' + mu w' + omega_0^2 w + c2 w^2 + c3 w^3 = lines. The first order is the motion
w = Re(z E) + Re(c L), E the fast angle's and L the forcing line's rotation. Every harmonic of c2 w^2 + c3 w^3 off E
drives a small harmonic w_m of its own, and the slope 2 c2 w + 3 c3 w^2 times those harmonics acts back on E
(Nayfeh & Mook 1979, Nonlinear Oscillations, sec. 2.3.3 for the free, 4.1 and 4.2 for the forced oscillation).
"""

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import sympy as sp

OFFSET = 16  # makes the exponents of a Laurent polynomial positive


@dataclass(frozen=True, eq=False)
class SecondOrderForm:
    """The harmonics of one resonance, as SymPy expressions in `symbols`.

    Attributes
    ----------
    symbols : tuple of Symbol
        c2, c3, z, conj(z), c, conj(c).
    on_fast : Expr
        Amplitude of the harmonic of c2 w^2 + c3 w^3 on E: the first order.
    others : dict
        Amplitudes of its other harmonics, by (multiple of the base angle, multiple of the line's angle); the second
        number is 0 where a resonance makes one angle of both.
    back : Expr
        Amplitude on E of the slope times the small harmonics: the second order.
    small : dict
        Symbols of the small harmonics and of their conjugates in `back`, by the same numbers.
    """

    symbols: tuple[Any, ...]
    on_fast: Any
    others: dict[tuple[int, int], Any]
    back: Any
    small: dict[tuple[int, int], tuple[Any, Any]]


def second_order_form(ratio: Fraction | None) -> SecondOrderForm:
    """Derive the harmonics of one resonance.

    Parameters
    ----------
    ratio : Fraction or None
        Fast angle over the line's angle: 3 in the superharmonic case. 1 is the primary case, in which the line is soft
        and c absent; None is no resonance, in which the two angles are independent.

    References
    ----------
    Nayfeh & Mook 1979, Nonlinear Oscillations, secs. 4.1 and 4.2.
    """
    c2, c3, z, z_bar, c, c_bar, x, y = sp.symbols("c2 c3 z z_bar c c_bar x y")
    fast, line = (x, y) if ratio is None else (x**ratio.numerator, x**ratio.denominator)
    at_fast = (1, 0) if ratio is None else (ratio.numerator, 0)
    w = (z * fast + z_bar / fast) / 2
    if ratio != 1:
        w += (c * line + c_bar / line) / 2
    force = _harmonics(c2 * w**2 + c3 * w**3, x, y)
    others = {m: amplitude for m, amplitude in force.items() if m != at_fast}
    small = {m: (sp.Symbol(_name("w", m)), sp.Symbol(_name("w_bar", m))) for m in others}
    correction = sum(
        value if m == (0, 0) else (value * x ** m[0] * y ** m[1] + bar / (x ** m[0] * y ** m[1])) / 2
        for m, (value, bar) in small.items()
    )
    back = _harmonics((2 * c2 * w + 3 * c3 * w**2) * correction, x, y)[at_fast]
    return SecondOrderForm((c2, c3, z, z_bar, c, c_bar), force[at_fast], others, back, small)


def _harmonics(wave: Any, x: Any, y: Any) -> dict[tuple[int, int], Any]:
    """Amplitudes of a real wave by harmonic: the mean, and twice the coefficient of every other positive one."""
    polynomial = sp.Poly(sp.expand(wave * (x * y) ** OFFSET), x, y)
    shifted = {(m - OFFSET, n - OFFSET): value for (m, n), value in polynomial.terms()}
    return {m: value * (1 if m == (0, 0) else 2) for m, value in sorted(shifted.items()) if m >= (0, 0)}


def _name(stem: str, m: tuple[int, int]) -> str:
    return f"{stem}_{m[0]}_{m[1]}"
