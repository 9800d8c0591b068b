"""File formats of order tables, and what they leave of one; a new format is one class and one line in `order_table`.

A format's fields are its options: `table.write(path, format="moteus", torque_constant=0.05)`.
"""

import dataclasses
import math
import re
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from inspect import get_annotations
from typing import Any, ClassVar, NamedTuple, get_type_hints

import numpy as np

from ...base.quantities import positive_count, shown
from ...base.results import Floats
from .content import OrderContent
from .points import MARK, MOST_POINTS, highest_order, motion, points_for, remarks, sampled

QUANTITY = {"rad": "an angle in rad", "N*m": "a torque in N*m"}
OVERSAMPLING = 15  # of the points, and of the period of the highest order; odd: halfway between points too
MOST_SAMPLES = 1_000_000

Motion = Callable[[Floats, bool], Floats]  # values at angles of the shaft [rad], in backward motion or not


class Held(NamedTuple):
    """What a format holds of a table.

    Attributes
    ----------
    stored, exact : callable
        Value by angle of the shaft [rad] and direction: of the numbers in the file, and of the same before rounding.
    numbers : Any
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
    numbers: Any
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
    dropped : tuple of float
        Orders that were left out, as the format counts them: not whole where they are of the output's turn.
    dropped_rms : float
        Root mean square of these.
    entries, size : int
        Points or lines that the machine holds, both directions of motion together, and their bytes in it.
    """

    unit: str
    rms: float
    peak: float
    table: float
    quantum: float
    quantisation: float
    interpolation: float
    points: int | None
    dropped: tuple[float, ...]
    dropped_rms: float
    entries: int = 0
    size: int = 0

    def sentences(self) -> list[str]:
        """The residual in words, one line a fact."""
        unit, kind = self.unit, "lines" if self.points is None else "points"
        share = f" ({100.0 * self.rms / self.table:.3g} % of the table)" if self.table > 0.0 else ""
        lines = [f"file minus table: {self.rms:.3g} {unit} rms{share}, {self.peak:.3g} {unit} peak"]
        if self.quantum > 0.0:
            lines.append(f"of it by rounding to {self.quantum:.3g} {unit}: {self.quantisation:.3g} {unit} rms")
        if self.points is not None:
            lines.append(f"of it by straight lines between {self.points} points: {self.interpolation:.3g} {unit} rms")
        if self.dropped:
            orders = ", ".join(f"{order:.6g}" for order in self.dropped)
            lines.append(f"of it by orders left out ({orders}): {self.dropped_rms:.3g} {unit} rms")
        return [*lines, f"{kind} in the machine: {self.entries}, {self.size} bytes"]

    def __str__(self) -> str:
        return "\n".join(self.sentences())


def residual_of(
    whole: OrderContent, fitted: OrderContent, held: Held, dropped: tuple[int, ...], with_mean: bool
) -> TableResidual:
    """Predict what is left of a table (`whole`) when a file holds what it can of `fitted`, on a fine grid.

    A table over the output's turn may be held over that of the motor, as far as it repeats there.
    """
    turns = 1.0 if whole.turn == fitted.turn else whole.ratio or 1.0
    highest = max((*whole.orders, 1))
    fine = OVERSAMPLING * max(highest * held.turns, round(turns) * (held.points or 0))
    angle = 2.0 * math.pi * held.turns * (np.arange(min(fine, MOST_SAMPLES)) + 0.5) / min(fine, MOST_SAMPLES)
    parts = []
    for backward in whole.sides:
        table, kept = whole.one_direction(angle, backward), fitted.one_direction(turns * angle, backward)
        stored, exact = held.stored(turns * angle, backward), held.exact(turns * angle, backward)
        rows = np.array([table - stored, table, stored - exact, kept - exact])
        if not with_mean:
            rows -= np.mean(rows, axis=1, keepdims=True)
        parts.append((*np.sqrt(np.mean(rows * rows, axis=1)), np.max(np.abs(rows[0]))))
    rms, size, rounding, straight, peak = np.max(np.array(parts), axis=0).tolist()
    lost = dataclasses.replace(whole.keep(dropped), mean=0.0, mean_backward=0.0).rms
    orders = dropped if turns == 1.0 else tuple(order / turns for order in dropped)
    return TableResidual(whole.unit, rms, peak, size, held.quantum, rounding, straight, held.points, orders, lost)


@dataclass(frozen=True)
class OrderFormat(ABC):
    """A file format of order tables.

    Attributes
    ----------
    name, title : str
        As callers write it, and in words.
    unit, turn : str or None
        The quantity it holds and the turn that its orders count on, where it has one alone.
    own_sign : bool
        Whether the file says what its sign is; other formats hold corrections.
    both_ways : bool
        Whether it can hold other lines, or none, for backward motion.
    with_delay, with_mean : bool
        Whether it can hold a delay and a constant part; where a constant has no effect, `needs_mean` is false.
    most_lines : int or None
        How many orders it holds at most.
    width : int
        Bytes of a line or a point in the machine.
    begin : str
        Pattern of the begin of a file without remarks.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    unit: ClassVar[str | None] = None
    turn: ClassVar[str | None] = None
    own_sign: ClassVar[bool] = False
    both_ways: ClassVar[bool] = False
    with_delay: ClassVar[bool] = False
    with_mean: ClassVar[bool] = True
    needs_mean: ClassVar[bool] = True
    most_lines: ClassVar[int | None] = None
    width: ClassVar[int] = 24
    begin: ClassVar[str] = "(?!)"

    def __init_subclass__(cls, **facts: object) -> None:
        """Take the attributes of a format from the line of its class."""
        super().__init_subclass__()
        known = sorted({name for base in cls.__mro__ for name in get_annotations(base)})
        for name, fact in facts.items():
            if name not in known:
                raise TypeError(f"{cls.__name__} has no attribute {name}; a format has {', '.join(known)}")
            setattr(cls, name, fact)

    @abstractmethod
    def store(self, table: OrderContent) -> Held:
        """Round a fitted table to the numbers of the file."""

    @abstractmethod
    def text(self, table: OrderContent, held: Held, comments: list[str]) -> str:
        """Write the file, with remarks where the format has any."""

    @abstractmethod
    def parse(self, text: str) -> OrderContent:
        """Read a file back (Unfit, ValueError)."""

    @classmethod
    def recognises(cls, text: str) -> bool:
        """Whether a text says at its head, or at its end, that it is of this format, or begins like a file of it."""
        mark = re.compile(rf"{MARK}: {cls.name}(?: \*\))?\n")
        return any(mark.search(part) for part in (text[:4000], text[-4000:])) or re.match(cls.begin, text) is not None

    def entries(self, table: OrderContent, held: Held) -> int:
        """Lines or points that the machine holds of a fitted table, both directions of motion together."""
        lines = len(table.lines) + len(table.backward or ())
        return lines if held.points is None else len(table.sides) * held.points

    def highest(self, table: OrderContent) -> int | None:
        """Highest order that the file can hold, if there is a limit."""
        return None

    def why_highest(self, table: OrderContent) -> str:
        """What sets this limit."""
        return "the format's limit"

    def fitted(self, table: OrderContent, drop: bool) -> tuple[OrderContent, OrderContent, tuple[int, ...]]:
        """The table as this format counts it, what of it the file will hold, and the orders that are left out.

        Raises
        ------
        ValueError
            If the format cannot hold it.
        """
        if self.unit is not None and table.unit != self.unit:
            raise ValueError(
                f"the table is {QUANTITY[table.unit]} and {self.title} holds {QUANTITY[self.unit]}; "
                f"take a format for {'angles' if table.unit == 'rad' else 'torques'}"
            )
        if not self.both_ways and len(table.sides) > 1:
            raise ValueError(
                f"the table differs between forward and backward motion and {self.title} holds one set; choose it with "
                "one_way('forward'), one_way('backward') or one_way('mean')"
            )
        if not self.with_delay and table.delay != 0.0:
            raise ValueError(
                f"the table has a delay of {table.delay:g} s, whose phase depends on the speed, and {self.title} knows "
                "no speed; choose one with at_speed(...)"
            )
        content = whole = table if self.own_sign else table.correction()
        turns = (table.ratio or 1.0) if drop and (table.turn, self.turn) == ("output", "motor") else 1.0
        if turns != 1.0:
            content = whole.keep(order for order in whole.orders if order % turns == 0.0).on_turn("motor")
        elif self.turn is not None:
            content = whole = whole.on_turn(self.turn)  # type: ignore[arg-type]
        if self.needs_mean and not self.with_mean and (whole.mean or whole.mean_backward):
            raise ValueError(
                f"the table has a constant part of {whole.mean:g} {whole.unit} and {self.title} holds none; "
                "set mean to 0 and add it to the command elsewhere"
            )
        content = content.keep(set(content.orders) - set(self._too_high(content, drop)))
        if self.most_lines is not None and len(content.orders) > self.most_lines:
            if not drop:
                raise ValueError(
                    f"the table has {len(content.orders)} orders and {self.title} holds {self.most_lines}; take "
                    f"strongest({self.most_lines}), or let the weakest be left out with drop"
                )
            content = content.strongest(self.most_lines)
        dropped = set(whole.orders) - {round(turns * order) for order in content.orders}
        return whole, content, tuple(sorted(dropped))

    def _too_high(self, table: OrderContent, drop: bool) -> tuple[int, ...]:
        highest = self.highest(table)
        high = () if highest is None else tuple(order for order in table.orders if order > highest)
        if high and not drop:
            raise ValueError(
                f"order {high[-1]} of the table is above {highest}, the highest that {self.title} "
                f"holds ({self.why_highest(table)}); leave it out with keep(...) or drop"
            )
        return high

    def options(self) -> dict[str, Any]:
        """The options that are set, by name."""
        return {f.name: getattr(self, f.name) for f in dataclasses.fields(self) if getattr(self, f.name) is not None}


class WithPoints(OrderFormat):
    """A format with points a turn beside its lines, or instead of them; its option `points` sets how many.

    Attributes
    ----------
    ends : int
        Whether the last point repeats the first: 0 or 1.
    more : str
        How a file holds higher orders.
    """

    points: int | None
    width: ClassVar[int] = 8
    ends: ClassVar[int] = 0
    more: ClassVar[str] = f"; give more points, at most {MOST_POINTS}"

    def __post_init__(self) -> None:
        if self.points is not None:
            positive_count("points", self.points, MOST_POINTS + self.ends)

    def most(self) -> int:
        """How many points a file holds at most."""
        return MOST_POINTS + self.ends

    def turns(self, table: OrderContent) -> int:
        """Turns of the table's shaft over which the points go."""
        return 1

    def count(self, table: OrderContent) -> int:
        """Points over these turns, without the last one where it repeats the first."""
        return (self.points or points_for(table, self.most() - self.ends, self.turns(table)) + self.ends) - self.ends

    def highest(self, table: OrderContent) -> int:
        """Two points a period."""
        return highest_order(self.count(table), self.turns(table))

    def why_highest(self, table: OrderContent) -> str:
        """The number of points."""
        return f"two of its {self.count(table) + self.ends} points a period{self.more}"


class OfPoints(WithPoints):
    """A format of points alone, in a unit of its own.

    Attributes
    ----------
    decimals : int or None
        That are kept of a value.
    """

    decimals: ClassVar[int | None] = None

    def size(self) -> float:
        """Unit of the file in that of the table."""
        return 1.0

    def start(self, table: OrderContent) -> float:
        """Angle [rad] of the first point."""
        return 0.0

    def kept(self, values: Floats) -> Floats:
        """Values as the machine keeps them, in the unit of the file."""
        return values

    def store(self, table: OrderContent) -> Held:
        """Sample the table, in the unit of the file, and round."""
        size, count, turns = self.size(), self.count(table), self.turns(table)
        exact = sampled(table, count, turns=turns, start=self.start(table))
        straight, points = motion(exact, table.zero), exact._replace(values=exact.values * (1.0 / size))
        if self.decimals is None:
            return Held(straight, straight, points, 0.0, count + self.ends, turns)
        step = 10.0**-self.decimals
        points = points._replace(values=step * np.round(points.values / step))
        stored = motion(points._replace(values=size * self.kept(points.values)), table.zero)
        return Held(stored, straight, points, step * abs(size), count + self.ends, turns)


class Exact(OrderFormat, both_ways=True, with_delay=True):
    """A format that holds the numbers of a table as they are."""

    def store(self, table: OrderContent) -> Held:
        """Keep everything as it is."""
        return Held(table.one_direction, table.one_direction, table)


def encoded(form: OrderFormat, table: OrderContent, drop: bool = False) -> tuple[str, TableResidual]:
    """Text of a file and the residual that it leaves.

    Raises
    ------
    ValueError
        If the format cannot hold the table, or nothing of it would be left.
    """
    whole, content, dropped = form.fitted(table, drop)
    held = form.store(content)
    left, count = residual_of(whole, content, held, dropped, form.needs_mean), form.entries(content, held)
    left = left._replace(entries=count, size=count * form.width)
    if left.table > 0.0 and not left.rms < left.table:
        raise ValueError(
            f"{form.title} would leave {left.rms:.3g} {left.unit} rms of a table of {left.table:.3g} {left.unit} "
            f"rms and so correct nothing (its step is {left.quantum:.3g} {left.unit}); take a finer format"
        )
    return form.text(content, held, remarks(form.name, content, left.sentences(), form.options())), left


def with_options(cls: type[OrderFormat], options: dict[str, Any]) -> OrderFormat:
    """A format with its options, of which texts are read as what they must be (ValueError)."""
    fields, hints = dataclasses.fields(cls), get_type_hints(cls)
    names = [f.name for f in fields]
    for name, value in options.items():
        if name not in names:
            raise ValueError(f"{cls.title} has no option {shown(name)}; it has {', '.join(names) or 'none'}")
        if isinstance(value, str) and hints[name] is not str:
            options = options | {name: _read(name, value, str(hints[name]))}
    if needed := [f.name for f in fields if f.default is dataclasses.MISSING and f.name not in options]:
        raise ValueError(f"{cls.title} needs the option {needed[0]}; give it")
    return cls(**options)


def _read(name: str, text: str, hint: str) -> Any:
    try:
        if "tuple" in hint:
            return tuple(float(part) for part in text.replace(",", " ").split())
        return int(text) if "int" in hint and "float" not in hint else float(text)
    except ValueError:
        raise ValueError(f"option {name} is {shown(text)}; write a number") from None
