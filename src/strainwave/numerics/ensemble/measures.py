"""Measures that an ensemble keeps of every trajectory: a few numbers, accumulated while it runs.

A measure is a NamedTuple with `start()`, the tuple of its sums before the first step, `update(sums, piece)`, the sums
after a piece of the trajectory, and `results(sums, time)`, the variables that come of them. It sees pieces of the first
state between two instants, never the whole. Instead of these three, or beside them, it may have

- `of_end(y)`, variables from the states (states, lanes) at the end, nan where a lane was lost,
- `order()`, the highest order that the steps must resolve,
- `unit()`, that of its variables, where it is not that of the first state,
- `check()`, which refuses parameters out of range.
"""

from typing import Any, NamedTuple

import numpy as np

from ...base.quantities import LARGEST, Reals, States, shown
from ...base.results import Floats
from ...compile.elementwise import larger, smaller
from ...compile.maths import cos, sin
from .pieces import Piece, harmonic_integrals, integral


class Peak(NamedTuple):
    """Largest |x| of the first state, refined between steps where its rate changes sign: variable `peak`."""

    def start(self) -> Any:
        """Sums before the first piece."""
        return (0.0,)

    def update(self, sums: States, piece: Piece) -> Any:
        """Sums after a piece."""
        return (larger(larger(abs(piece.x1), abs(piece.extreme)), sums[0]),)

    def results(self, sums: States, time: Reals) -> dict[str, Any]:
        """Variables from the sums (rows) over a time [s]."""
        return {"peak": sums[0]}


class Extremes(NamedTuple):
    """Smallest and largest value of the first state, refined between steps: variables `lowest`, `highest`."""

    def start(self) -> Any:
        """Sums before the first piece."""
        return 1e300, -1e300

    def update(self, sums: States, piece: Piece) -> Any:
        """Sums after a piece."""
        low, high = smaller(piece.x1, piece.extreme), larger(piece.x1, piece.extreme)
        return smaller(low, sums[0]), larger(high, sums[1])

    def results(self, sums: States, time: Reals) -> dict[str, Any]:
        """Variables from the sums (rows) over a time [s]."""
        return {"lowest": sums[0], "highest": sums[1]}


class Rms(NamedTuple):
    """Root mean square of the first state: variable `rms`."""

    def start(self) -> Any:
        """Sums before the first piece."""
        return (0.0,)

    def update(self, sums: States, piece: Piece) -> Any:
        """Sums after a piece."""
        x0, x1 = piece.x0, piece.x1
        part = integral(piece.rule, piece.width, x0 * x0, 2.0 * x0 * piece.v0, x1 * x1, 2.0 * x1 * piece.v1)
        return (sums[0] + part,)

    def results(self, sums: States, time: Reals) -> dict[str, Any]:
        """Variables from the sums (rows) over a time [s]."""
        return {"rms": np.sqrt(sums[0] / time)}


class Mean(NamedTuple):
    """Mean of the first state: variable `mean`."""

    def start(self) -> Any:
        """Sums before the first piece."""
        return (0.0,)

    def update(self, sums: States, piece: Piece) -> Any:
        """Sums after a piece."""
        return (sums[0] + integral(piece.rule, piece.width, piece.x0, piece.v0, piece.x1, piece.v1),)

    def results(self, sums: States, time: Reals) -> dict[str, Any]:
        """Variables from the sums (rows) over a time [s]."""
        return {"mean": sums[0] / time}


class Amplitude(NamedTuple):
    """Amplitude, 0-to-peak, of the harmonic of order k of the first state over whole periods: `amplitude_k`."""

    k: int

    def start(self) -> Any:
        """Sums before the first piece."""
        return 0.0, 0.0

    def update(self, sums: States, piece: Piece) -> Any:
        """Sums after a piece."""
        c0, s0 = cos(self.k * piece.phase0), sin(self.k * piece.phase0)
        c1, s1 = cos(self.k * piece.phase1), sin(self.k * piece.phase1)
        even, odd = harmonic_integrals(piece.rule, piece, self.k * piece.omega, c0, s0, c1, s1)
        return sums[0] + even, sums[1] + odd

    def results(self, sums: States, time: Reals) -> dict[str, Any]:
        """Variables from the sums (rows) over a time [s]."""
        return {f"amplitude_{self.k}": 2.0 * np.hypot(sums[0], sums[1]) / time}

    def order(self) -> int:
        """Order that the steps must resolve."""
        return self.k

    def check(self) -> None:
        """Refuse an order below 1 (ValueError)."""
        if not 1 <= self.k <= LARGEST or self.k % 1:
            raise ValueError(
                f"Amplitude.k is {shown(self.k)}; it must be a whole number of at least 1, at most {LARGEST:g} (mean: "
                "sw.numerics.Mean())"
            )


class Final(NamedTuple):
    """State at the end: variable `final` over lane and state. It needs no sums."""

    def of_end(self, y: Floats) -> dict[str, Any]:
        """Variables from the states at the end."""
        return {"final": y}
