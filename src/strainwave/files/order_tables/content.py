"""What an order table says: lines on a turn, their quantity, and all that a machine must know to add them rightly.

A line is amplitude cos(order angle + phase), amplitude 0-to-peak; `angle` is that of the shaft on whose turn the orders
count, and `speed` its rate. An encoder on that shaft reads angle - zero.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, Self, get_args

import numpy as np

from ...base.arguments import typed
from ...base.quantities import number, positive_count, reals, samples_of, shown
from ...base.results import Floats
from ...model.excitation import HIGHEST, Line
from ...model.orders import Pair, order_pair

Unit = Literal["rad", "N*m"]
Turn = Literal["motor", "output"]
Sign = Literal["correction", "error"]
Direction = Literal["both", "forward", "backward"]
Way = Literal["forward", "backward", "mean"]

CHOICES = {"unit": get_args(Unit), "turn": get_args(Turn), "sign": get_args(Sign), "direction": get_args(Direction)}
MOST_SOURCE = 2000  # letters
NEARLY = 1e-9  # how far an order may be from a whole number


@dataclass(frozen=True)
class OrderContent:
    """Fields and arithmetic of an `OrderTable`, which says what each is and adds reading and writing."""

    lines: tuple[Line, ...]
    unit: Unit = "rad"
    turn: Turn = "motor"
    ratio: float | None = None
    zero: float = 0.0
    sign: Sign = "correction"
    direction: Direction = "both"
    backward: tuple[Line, ...] | None = None
    mean: float = 0.0
    mean_backward: float = 0.0
    delay: float = 0.0
    speeds: tuple[float, float] | None = None
    load: float | None = None
    source: str = ""

    def __post_init__(self) -> None:
        values: dict[str, Any] = {"lines": checked_lines("lines", self.lines)}
        for name, choices in CHOICES.items():
            if not (isinstance(value := getattr(self, name), str) and value in choices):
                text = ", ".join(map(repr, choices))
                raise ValueError(f"{name} of an order table is {shown(value)}; it must be one of {text}")
        for name in ("zero", "mean", "mean_backward", "delay"):
            values[name] = number(f"{name} of an order table", getattr(self, name))
        for name in ("ratio", "load"):
            if (value := getattr(self, name)) is not None:
                values[name] = number(f"{name} of an order table", value, positive=name == "ratio")
        if values["delay"] < 0.0:
            raise ValueError(f"delay of an order table is {values['delay']:g} s; it must not be negative")
        if self.backward is not None:
            values["backward"] = checked_lines("backward", self.backward)
            if self.direction != "both":
                raise ValueError(
                    f"an order table with backward lines has the direction {self.direction!r}; it must be 'both'"
                )
        elif values["mean_backward"] != 0.0:
            raise ValueError("an order table has mean_backward and no backward lines; give backward=() beside it")
        if self.speeds is not None:
            values["speeds"] = _checked_speeds(self.speeds)
        if not isinstance(self.source, str):
            raise TypeError(f"source of an order table is {shown(self.source)}; write it as text")
        if len(self.source) > MOST_SOURCE:
            raise ValueError(f"source of an order table has {len(self.source)} letters; it may have {MOST_SOURCE}")
        for name, value in values.items():
            object.__setattr__(self, name, value)

    @property
    def orders(self) -> tuple[int, ...]:
        """All orders, ascending."""
        return tuple(sorted({line.order for line in (*self.lines, *(self.backward or ()))}))

    @property
    def sides(self) -> tuple[bool, ...]:
        """Directions of motion in which it differs: forward (False) alone, or backward (True) too."""
        return (False,) if self.backward is None and self.direction == "both" else (False, True)

    @property
    def rms(self) -> float:
        """Root mean square over a turn, of the direction where it is larger, in the unit of the table."""
        sets = [(self.mean, self.lines), (self.mean_backward, self.backward or ())]
        return max(math.hypot(mean, *(line.amplitude / math.sqrt(2.0) for line in lines)) for mean, lines in sets)

    def value(self, angle: Any, speed: Any = 0.0) -> Any:
        """Value of the table at an angle, read ahead by its delay.

        Parameters
        ----------
        angle : float or array
            Angle of the shaft of `turn` [rad].
        speed : float or array
            Speed of the same shaft [rad/s]; its sign is the direction of motion, 0 counts as forward.

        Returns
        -------
        float or array
            In `unit`; 0 in a direction in which the table does not hold.

        Raises
        ------
        ValueError
            If angle or speed is not finite.
        """
        v = _finite("speed [rad/s]", speed)
        led = _finite("angle [rad]", angle) + self.delay * v
        held = np.where(v < 0.0, self.one_direction(led, True), self.one_direction(led, False))
        return float(held) if held.ndim == 0 else held

    @typed
    def one_direction(self, angle: Floats, backward: bool) -> Floats:
        """Value in one direction of motion at angles of the shaft [rad], without the delay."""
        angle = _finite("angle [rad]", angle)
        if self.direction == ("forward" if backward else "backward"):
            return 0.0 * angle
        if backward and self.backward is not None:
            return summed(self.mean_backward, self.backward, angle)
        return summed(self.mean, self.lines, angle)

    def covers(self, speed: float, load: float | None = None) -> bool:
        """Whether the table holds at a speed of the motor [rad/s] and, if given, a torque on the load [N*m]."""
        low, high = self.speeds or (0.0, math.inf)
        within = low <= abs(number("speed", speed)) <= high
        return within and (load is None or self.load is None or load == self.load)

    def correction(self) -> Self:
        """The same table as what is to be added to the command."""
        if self.sign == "correction":
            return self
        if self.unit == "rad":
            return replace(self, sign="correction")
        back = None if self.backward is None else _negative(self.backward)
        return replace(
            self, sign="correction", lines=_negative(self.lines), backward=back, mean=-self.mean,
            mean_backward=-self.mean_backward,
        )  # fmt: skip

    def at_speed(self, speed: float) -> Self:
        """The table of one speed: its delay becomes phase, +order speed delay forward and the negative backward.

        Parameters
        ----------
        speed : float
            Absolute speed of the shaft of `turn` [rad/s].
        """
        v = abs(number("speed", speed))
        if self.delay == 0.0:
            return self
        ahead = v * self.delay
        sign = -1.0 if self.direction == "backward" else 1.0
        back = None
        if self.direction == "both":
            back = shifted(self.lines if self.backward is None else self.backward, -ahead)
        mean = self.mean if self.backward is None and back is not None else self.mean_backward
        return replace(
            self, lines=shifted(self.lines, sign * ahead), backward=back, mean_backward=mean, delay=0.0
        )  # fmt: skip

    @typed
    def one_way(self, way: Way) -> Self:
        """One set of lines for both directions: that of forward motion, of backward motion, or the mean of the two."""
        one_set: dict[str, Any] = {"direction": "both", "backward": None, "mean_backward": 0.0}
        if self.backward is None:
            if way != "mean" and self.direction not in ("both", way):
                raise ValueError(f"the table holds in the direction {self.direction!r} alone; it has no lines {way}")
            return replace(self, **one_set)
        if way == "forward":
            return replace(self, **one_set)
        if way == "backward":
            return replace(self, **one_set | {"lines": self.backward, "mean": self.mean_backward})
        halves = [line._replace(amplitude=0.5 * line.amplitude) for line in (*self.lines, *self.backward)]
        mean = 0.5 * (self.mean + self.mean_backward)
        return replace(self, **one_set | {"lines": merged(halves), "mean": mean})

    @property
    def pairs(self) -> tuple[Pair, ...] | None:
        """Repeats (j, k) per turn of motor and output of every order j N + k of a table on the output's turn.

        None where the orders count on the motor's turn, or the ratio is not known or not whole.
        """
        if self.turn == "motor" or self.ratio is None or self.ratio % 1:
            return None
        return tuple(order_pair(order / self.ratio, self.ratio) for order in self.orders)

    @typed
    def on_turn(self, turn: Turn) -> Self:
        """The same table with its orders on the turn of the other shaft.

        Raises
        ------
        ValueError
            If the ratio is missing, or an order is no whole number there.
        """
        if turn == self.turn:
            return self
        if self.ratio is None:
            raise ValueError(
                f"the orders count on the {self.turn} turn and are wanted on the {turn} turn; give the table its ratio"
            )
        factor = self.ratio if turn == "output" else 1.0 / self.ratio
        lines = counted(self.lines, factor, turn, self.ratio)
        backward = None if self.backward is None else counted(self.backward, factor, turn, self.ratio)
        return replace(self, turn=turn, lines=lines, backward=backward, zero=self.zero / factor)

    @typed
    def keep(self, orders: Iterable[int]) -> Self:
        """The table with these orders alone."""
        kept = {positive_count("an order", order, HIGHEST) for order in orders}
        lines = tuple(line for line in self.lines if line.order in kept)
        back = None if self.backward is None else tuple(line for line in self.backward if line.order in kept)
        return replace(self, lines=lines, backward=back)

    def strongest(self, count: int) -> Self:
        """The table with its so many strongest orders alone, by the larger amplitude of the two directions."""
        positive_count("count", count)
        sizes: dict[int, float] = {}
        for line in (*self.lines, *(self.backward or ())):
            sizes[line.order] = max(sizes.get(line.order, 0.0), line.amplitude)
        return self.keep(sorted(sizes, key=lambda order: (-sizes[order], order))[:count])


def checked_lines(name: str, lines: object) -> tuple[Line, ...]:
    """Lines with whole orders, each once, finite amplitudes that are not negative, and finite phases (ValueError)."""
    if not isinstance(lines, Sequence) or isinstance(lines, Line | str):
        raise TypeError(f"{name} of an order table are {shown(lines)}; write (Line(order, amplitude, phase), ...)")
    result, orders = [], set()
    for line in lines:
        if not isinstance(line, Line):
            raise TypeError(f"{name} of an order table hold {shown(line)}; write Line(order, amplitude, phase)")
        order = positive_count("an order of an order table", line.order, HIGHEST)
        size = number(f"the amplitude of order {order}", line.amplitude)
        if size < 0.0:
            raise ValueError(f"the amplitude of order {order} is {size:g}; give it 0-to-peak and half a turn in phase")
        if order in orders:
            raise ValueError(f"order {order} is twice in the {name} of an order table; add the two to one line")
        orders.add(order)
        result.append(Line(order, size, number(f"the phase of order {order}", line.phase)))
    return tuple(result)


def _finite(name: str, values: Any) -> Floats:
    if not np.all(np.isfinite(reals(values))):
        raise ValueError("an order table was asked for an angle or a speed that is not finite; hold the last value")
    return samples_of(name, values)


def _checked_speeds(speeds: object) -> tuple[float, float]:
    if not isinstance(speeds, Sequence) or len(speeds) != 2:
        raise ValueError(f"speeds of an order table are {shown(speeds)}; give the lowest and the highest, rad/s")
    low, high = [number("a speed of an order table", speed) for speed in speeds]
    if not 0.0 <= low <= high:
        raise ValueError(f"speeds of an order table are {low:g} .. {high:g} rad/s; they must be 0 <= lowest <= highest")
    return low, high


def summed(mean: float, lines: Sequence[Line], angle: Floats) -> Floats:
    """Sum of a constant and lines at angles [rad]."""
    total = mean + 0.0 * angle
    for line in lines:
        total = total + line.amplitude * np.cos(line.order * angle + line.phase)
    return np.asarray(total)


def shifted(lines: Sequence[Line], ahead: float) -> tuple[Line, ...]:
    """Lines of a function that is read ahead by an angle [rad]."""
    return tuple(line._replace(phase=line.phase + line.order * ahead) for line in lines)


def merged(lines: Sequence[Line]) -> tuple[Line, ...]:
    """Lines of one order each: those of the same order added, ascending."""
    sums: dict[int, complex] = {}
    for line in lines:
        turned = complex(math.cos(line.phase), math.sin(line.phase))
        sums[line.order] = sums.get(line.order, 0j) + line.amplitude * turned
    return tuple(Line(k, abs(c), math.atan2(c.imag, c.real)) for k, c in sorted(sums.items()))


def positive(lines: Sequence[Line]) -> tuple[Line, ...]:
    """Lines with amplitudes that are not negative; lines of one order are added."""
    if len({line.order for line in lines}) < len(lines):
        return merged(lines)
    return _negative(lines, only=True)


def _negative(lines: Sequence[Line], only: bool = False) -> tuple[Line, ...]:
    """The negative of lines (`only`: of those alone whose amplitude is negative), as half a turn of phase."""
    return tuple(
        Line(line.order, abs(line.amplitude), line.phase - math.copysign(math.pi, line.phase))
        if line.amplitude < 0.0 or not only
        else line
        for line in lines
    )


def counted(lines: Sequence[Line], factor: float, turn: str, ratio: float) -> tuple[Line, ...]:
    """Lines with their orders times a factor, on the turn of the other shaft (ValueError)."""
    result = []
    for line in lines:
        order = line.order * factor
        if abs(order - round(order)) > NEARLY * max(1.0, order) or round(order) < 1:
            raise ValueError(
                f"order {line.order:.6g} is {order:.6g} on the {turn} turn at the ratio {ratio:g}, no whole number; "
                "leave it out with keep(...) or drop"
            )
        if round(order) > HIGHEST:
            raise ValueError(
                f"order {line.order:.6g} is {order:.6g} on the {turn} turn, above {HIGHEST}; leave it out with "
                "keep(...)"
            )
        result.append(line._replace(order=round(order)))
    return tuple(result)
