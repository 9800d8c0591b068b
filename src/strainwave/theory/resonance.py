"""Resonances that multiple scales can treat: p omega near q omega_0, with omega the speed of the base angle."""

from fractions import Fraction
from typing import Any, NamedTuple

from ..base.quantities import MOST_THINGS, shown


class Resonance(NamedTuple):
    """The resonance p omega ~ q omega_0 on the base angle; (0, 0) is no resonance at all.

    The response near omega_0 then has the fast angle (p/q) theta. A forcing line of order k has its primary resonance
    at Resonance(k, 1), its superharmonic one of the cubic law at (3 k, 1) and its subharmonic one at (k, 3).

    References
    ----------
    Nayfeh & Mook 1979, Nonlinear Oscillations, secs. 4.1.1-4.1.4.
    """

    p: int
    q: int

    @property
    def ratio(self) -> Fraction | None:
        """The number p/q by which the base angle advances the fast angle, in lowest terms; None without resonance."""
        return None if self == (0, 0) else Fraction(self.p, self.q)

    @classmethod
    def of(cls, pair: Any) -> "Resonance":
        """Return a pair p, q in lowest terms, with Python's own integers.

        Raises
        ------
        ValueError
            If it is none, or p or q is not a positive integer (or both 0).
        """
        if not (isinstance(pair, tuple | list) and len(pair) == 2):
            names = "PRIMARY, SUPERHARMONIC, SUBHARMONIC, NONRESONANT"
            raise ValueError(f"{shown(pair)} is no resonance; give {names} or a Resonance(p, q)")
        p, q = pair
        if p == q == 0:
            return NONRESONANT
        if not all(0 < n <= MOST_THINGS and n % 1 == 0 for n in pair):
            raise ValueError(
                f"Resonance({shown(p)}, {shown(q)}) must have two positive integers, {MOST_THINGS:g} at "
                "most, as in p omega ~ q omega_0; use strainwave.NONRESONANT where nothing resonates"
            )
        ratio = Fraction(int(p), int(q))
        return Resonance(ratio.numerator, ratio.denominator)

    def __str__(self) -> str:
        names = {(0, 0): "no resonance", (1, 1): "primary", (3, 1): "superharmonic", (1, 3): "subharmonic"}
        name = names.get((self.p, self.q), "resonance")
        return name if self == (0, 0) else f"{name} {self.p}:{self.q}"


PRIMARY = Resonance(1, 1)
SUPERHARMONIC = Resonance(3, 1)
SUBHARMONIC = Resonance(1, 3)
NONRESONANT = Resonance(0, 0)
