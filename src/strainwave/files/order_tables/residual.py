"""What a format leaves of an order table: rounding, straight lines between points, and orders that it cannot hold."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...results import Floats
from .content import OrderContent
from .points import Points, motion

OVERSAMPLING = 15  # of the points, and of the period of the highest order; odd: halfway between points too
MOST_SAMPLES = 1_000_000

Motion = Callable[[Floats, bool], Floats]  # values at angles of the shaft [rad], in backward motion or not


class Held(NamedTuple):
    """What a format holds of a table.

    Attributes
    ----------
    stored, exact : callable
        Value by angle of the shaft [rad] and direction: of the numbers in the file, and of the same before rounding.
    numbers : object
        The numbers that go into the file, as the format wants them.
    quantum : float
        Step of the stored values, in the unit of the table; 0 where they are floating-point numbers of 64 bits.
    points : int or None
        Points over `turns` turns, where there are such.
    turns : int
        Turns over which the file goes.
    """

    stored: Motion
    exact: Motion
    numbers: object
    quantum: float = 0.0
    points: int | None = None
    turns: int = 1


class TableResidual(NamedTuple):
    """What a format leaves of an order table, as predicted from the very numbers of the file.

    Attributes
    ----------
    unit : str
        Of all that follows: rad on the output side, or N*m at the motor.
    rms, peak : float
        Of table minus file over a turn, in the direction where it is larger; without their means where a constant part
        has no effect on the machine.
    table : float
        Root mean square of the table itself.
    quantum : float
        Step of the stored values.
    quantisation : float
        Root mean square that rounding alone leaves.
    interpolation : float
        Root mean square that straight lines between exact points leave.
    points : int or None
        Points in the file, where there are such.
    dropped : tuple of int
        Orders that were left out, as the format counts them.
    dropped_rms : float
        Root mean square of these.
    """

    unit: str
    rms: float
    peak: float
    table: float
    quantum: float
    quantisation: float
    interpolation: float
    points: int | None
    dropped: tuple[int, ...]
    dropped_rms: float

    def sentences(self) -> list[str]:
        """The residual in words, one line a fact."""
        share = f" ({100.0 * self.rms / self.table:.3g} % of the table)" if self.table > 0.0 else ""
        said = [f"file minus table: {self.rms:.3g} {self.unit} rms{share}, {self.peak:.3g} {self.unit} peak"]
        if self.quantum > 0.0:
            said.append(f"of it by rounding to {self.quantum:.3g} {self.unit}: {self.quantisation:.3g} {self.unit} rms")
        if self.points is not None:
            said.append(
                f"of it by straight lines between {self.points} points: {self.interpolation:.3g} {self.unit} rms"
            )
        if self.dropped:
            orders = ", ".join(map(str, self.dropped))
            said.append(f"of it by orders left out ({orders}): {self.dropped_rms:.3g} {self.unit} rms")
        return said

    def __str__(self) -> str:
        return "\n".join(self.sentences())


def residual_of(
    whole: OrderContent, fitted: OrderContent, held: Held, dropped: tuple[int, ...], with_mean: bool
) -> TableResidual:
    """Predict what is left of a table (`whole`) when a file holds what it can of `fitted`, on a fine grid."""
    highest = max((*whole.orders, 1))
    fine = OVERSAMPLING * max(highest * held.turns, held.points or 0)
    angle = 2.0 * math.pi * held.turns * (np.arange(min(fine, MOST_SAMPLES)) + 0.5) / min(fine, MOST_SAMPLES)
    parts = []
    for backward in (False, True) if whole.backward is not None or whole.direction != "both" else (False,):
        table, kept = (one.one_direction(angle, backward) for one in (whole, fitted))
        stored, exact = held.stored(angle, backward), held.exact(angle, backward)
        rows = np.array([table - stored, table, stored - exact, kept - exact])
        if not with_mean:
            rows -= np.mean(rows, axis=1, keepdims=True)
        parts.append((*np.sqrt(np.mean(rows * rows, axis=1)).tolist(), float(np.max(np.abs(rows[0])))))
    rms, size, rounding, straight, peak = np.max(np.array(parts), axis=0).tolist()
    lost = whole.keep(dropped) if dropped else None
    return TableResidual(
        whole.unit, rms, peak, size, held.quantum, rounding, straight, held.points, dropped,
        0.0 if lost is None else _lines_rms(lost),
    )  # fmt: skip


def lookup_remark(table: OrderContent, points: Points) -> str:
    """What straight lines between points leave of a table that the file also holds as a function."""
    content = Held(motion(points, table.zero), table.one_direction, points, points=len(points.forward))
    left = residual_of(table, table, content, (), True)
    return f"lookup: straight lines between {left.points} points leave {left.rms:.3g} {left.unit} rms"


def _lines_rms(table: OrderContent) -> float:
    sets = (table.lines, table.backward or ())
    return max(math.hypot(*(line.amplitude / math.sqrt(2.0) for line in lines)) for lines in sets)
