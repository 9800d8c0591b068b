"""Order tables: lines that cancel an error over a turn, written and read as JSON, CSV and C.

A line is amplitude cos(order angle + phase), amplitude 0-to-peak; `angle` is that of the shaft on whose turn the orders
count, and `speed` its rate. An encoder on that shaft reads angle - zero.
"""

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, Self

import numpy as np

from ..base.archive import atomic
from ..base.quantities import choice, number, positive_count, samples_of, shown
from ..base.results import Floats
from ..model.excitation import HIGHEST, Harmonic, Harmonics, Line
from ..model.orders import Pair, order_pair
from .order_files import MOST_POINTS, Unfit, from_text, to_c, to_csv, to_json
from .yaml_text import FileError, Problem, complaint, text_of

FORMATS = {"json": ".json", "csv": ".csv", "c": ".h"}
CHOICES = {
    "unit": ("rad", "N*m"), "turn": ("motor", "output"), "sign": ("correction", "error"),
    "direction": ("both", "forward", "backward"),
}  # fmt: skip
DIRECTIONS = ("forward", "backward")
FILE_BYTES = 16 * 1024 * 1024  # bytes of a file
MOST_SOURCE = 2000  # letters
ORDER_TOLERANCE = 1e-9  # largest distance of an order from a whole number
POINTS, PER_PERIOD = 64, 32  # points a turn, and a period of the highest order, where a caller gives no number


def format_of(path: str | os.PathLike[str], format: str | None) -> str:
    """Format of a file to be written, by its ending where none is given (ValueError)."""
    ending = Path(path).suffix
    form = format or next((name for name, usual in FORMATS.items() if usual == ending), ending)
    if form not in FORMATS:
        raise ValueError(f"{shown(form)} is not a format of order tables; formats: {', '.join(FORMATS)}")
    return form


@dataclass(frozen=True)
class OrderTable:
    """Orders that cancel an error, with all that is needed to add them rightly; read and written as files.

    Attributes
    ----------
    lines : tuple of Line
        Order (from 1, each once), amplitude (0-to-peak, not negative) and phase [rad]: those of both directions, or of
        forward motion where there are lines of backward motion too.
    unit : {"rad", "N*m"}
        An angle on the output side, or a torque at the motor.
    turn : {"motor", "output"}
        Shaft on whose turn the orders count: the motor's is that of the wave generator.
    ratio : float or None
        Turns of the motor per turn of the output.
    zero : float
        Angle of that shaft [rad] at the encoder's index: the encoder reads angle - zero.
    sign : {"correction", "error"}
        A correction is added to the commanded angle of the output or to the torque of the motor. An error is what the
        gear does: theta_m/N - theta_l, whose correction is the same number; or a disturbing torque at the motor, whose
        correction is its negative.
    direction : {"both", "forward", "backward"}
        Directions of motion in which the table holds; in the other it gives 0.
    backward : tuple of Line or None
        Lines of backward motion where they are other ones.
    mean, mean_backward : float
        Constant part, in the unit of the table.
    delay : float
        Time [s] between reading the angle and the effect, not negative: the table is read at angle + speed delay.
    speeds : (float, float) or None
        Speeds of the motor [rad/s] for which the table holds, lowest and highest of the absolute value.
    load : float or None
        Torque on the load [N*m] for which it holds.
    source : str
        Source of the numbers.
    """

    lines: tuple[Line, ...]
    unit: str = "rad"
    turn: str = "motor"
    ratio: float | None = None
    zero: float = 0.0
    sign: str = "correction"
    direction: str = "both"
    backward: tuple[Line, ...] | None = None
    mean: float = 0.0
    mean_backward: float = 0.0
    delay: float = 0.0
    speeds: tuple[float, float] | None = None
    load: float | None = None
    source: str = ""

    def __post_init__(self) -> None:
        for name, choices in CHOICES.items():
            choice(f"{name} of an order table", getattr(self, name), *choices)
        values: dict[str, Any] = {"lines": _checked("lines", self.lines)}
        for name in ("zero", "mean", "mean_backward", "delay", "ratio", "load"):
            if (value := getattr(self, name)) is not None or name not in ("ratio", "load"):
                values[name] = number(f"{name} of an order table", value, positive=name == "ratio")
        if self.delay < 0.0:
            raise ValueError(f"delay of an order table is {self.delay:g} s; it must not be negative")
        if self.backward is not None:
            values["backward"] = _checked("backward", self.backward)
        if self.backward is not None and self.direction != "both":
            raise ValueError(f"an order table with backward lines has the direction {self.direction!r}, not 'both'")
        if self.backward is None and self.mean_backward != 0.0:
            raise ValueError("an order table has mean_backward and no backward lines; give backward=() beside it")
        if self.speeds is not None:
            values["speeds"] = _range(self.speeds)
        if not isinstance(self.source, str) or len(self.source) > MOST_SOURCE:
            raise ValueError(f"source of an order table is {shown(self.source)}; give up to {MOST_SOURCE} letters")
        for name, value in values.items():
            object.__setattr__(self, name, value)

    @classmethod
    def of(cls, error: object, *, backward: Any = None, **fields: Any) -> Self:
        """Order table of a kinematic error, an error scan, a torque over an angle, or any lines.

        Parameters
        ----------
        error, backward : KinematicError, ErrorScan, Harmonic, Harmonics, or sequence of Line
            Object with `lines` of order, amplitude and phase, such lines, or a torque; `backward` where backward motion
            differs. Negative amplitudes become half a turn of phase, lines of one order are added. A delay that a fit
            has found is that of its measurement and is not taken over. Where one is of the output's turn, of order j +
            k/N, the table counts on that turn, where its order is j N + k: it needs the ratio N.
        **fields
            The other attributes: unit, turn, ratio, zero, ... In rad by default, a torque in N*m; a kinematic error is
            its own correction, theta_m = N (theta_reference + e).

        Returns
        -------
        OrderTable

        Raises
        ------
        TypeError, ValueError
            If there are no lines, or a field is wrong.
        """
        given: dict[str, Any] = {"unit": "N*m" if isinstance(error, Harmonic | Harmonics) else "rad"}
        sets = {"lines": _terms(error)} | ({} if backward is None else {"backward": _terms(backward)})
        broken = [line.order for lines in sets.values() for line in lines if line.order % 1]
        turns = 1.0
        if broken and "turn" not in fields:
            if fields.get("ratio") is None:
                raise ValueError(f"order {broken[0]:.6g} is a line of the output's turn; give the ratio of the gear")
            turns, given["turn"] = number("ratio of an order table", fields["ratio"], positive=True), "output"
        given |= {name: _merged(lines, turns) for name, lines in sets.items()}
        return cls(**given | {"mean": _mean(error), "mean_backward": _mean(backward)} | fields)

    @property
    def orders(self) -> tuple[int, ...]:
        """All orders, ascending."""
        return tuple(sorted({line.order for line in (*self.lines, *(self.backward or ()))}))

    @property
    def pairs(self) -> tuple[Pair, ...] | None:
        """Repeats (j, k) per turn of motor and output of every order j N + k of a table on the output's turn.

        None where the orders count on the motor's turn, or the ratio is not known or not whole.
        """
        if self.turn == "motor" or self.ratio is None or self.ratio % 1:
            return None
        return tuple(order_pair(order / self.ratio, self.ratio) for order in self.orders)

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
        v = samples_of("speed [rad/s]", speed)
        led = samples_of("angle [rad]", angle) + self.delay * v
        if not np.all(np.isfinite(led)):
            raise ValueError("angle or speed of an order table is not finite; hold the last value")
        held = np.where(v < 0.0, self._one_way(led, "backward"), self._one_way(led, "forward"))
        return float(held) if held.ndim == 0 else held

    def _acting(self, direction: str) -> tuple[float, tuple[Line, ...]]:
        """Constant and lines in a direction of motion."""
        if self.direction not in ("both", direction):
            return 0.0, ()
        if direction == "backward" and self.backward is not None:
            return self.mean_backward, self.backward
        return self.mean, self.lines

    def _one_way(self, angle: Floats, direction: str) -> Floats:
        """Values in one direction of motion at angles of the shaft [rad], without the delay."""
        mean, lines = self._acting(direction)
        total = np.full(np.shape(angle), mean)
        for line in lines:
            total = total + line.amplitude * np.cos(line.order * angle + line.phase)
        return total

    def at_speed(self, speed: float) -> Self:
        """The table of one speed: its delay becomes phase, +order speed delay forward and the negative backward.

        Parameters
        ----------
        speed : float
            Absolute speed of the shaft of `turn` [rad/s].
        """
        ahead = abs(number("speed", speed)) * self.delay
        if self.delay == 0.0:
            return self
        if self.direction != "both":
            one = _shifted(self.lines, -ahead if self.direction == "backward" else ahead)
            return replace(self, lines=one, delay=0.0)
        mean, lines = self._acting("backward")
        sides = _shifted(self.lines, ahead), _shifted(lines, -ahead)
        return replace(self, lines=sides[0], backward=sides[1], mean_backward=mean, delay=0.0)

    def write(
        self, path: str | os.PathLike[str], format: str | None = None, *, points: int | None = None,
        prefix: str = "order_table",
    ) -> None:  # fmt: skip
        """Write the table as a file, which appears when it is complete.

        Parameters
        ----------
        path : str or path
            File.
        format : {"json", "csv", "c"}, optional
            JSON of lines; CSV of points at equidistant angles of the encoder over a turn, with a column for backward
            motion where it differs; C99 header with the functions PREFIX_value(angle, speed), a sum of cosines, and
            PREFIX_lookup(angle, speed), straight lines between points. Default: by the ending .json, .csv or .h.
        points : int, optional
            Points a turn of CSV and C. Default: 32 a period of the highest order, at least 64.
        prefix : str
            Begin of all names in C.

        Raises
        ------
        ValueError
            If the format is not known, or cannot hold the table.
        FileNotFoundError
            If there is no such folder.
        """
        path, form = Path(path), format_of(path, format)
        if form == "csv" and self.delay != 0.0:
            raise ValueError(
                f"the table has a delay of {self.delay:g} s, whose phase depends on the speed, and points know no "
                "speed; choose one with at_speed(...)"
            )
        table = {field.name: getattr(self, field.name) for field in fields(self)}
        if form == "json":
            text = to_json(table)
        elif form == "csv":
            columns = len(set(map(self._acting, DIRECTIONS)))
            text = to_csv(table, [self._points(d, points) for d in DIRECTIONS[:columns]])
        else:
            text = to_c(table, {d: (*self._acting(d), self._points(d, points)) for d in DIRECTIONS}, prefix)
        with atomic(path) as part:
            Path(part).write_text(text, encoding="utf-8", newline="\n")

    def _points(self, direction: str, points: int | None) -> list[float]:
        """Values at equidistant angles of the encoder in a direction of motion."""
        highest = max(self.orders, default=1)
        count = positive_count("points", points or min(MOST_POINTS, max(POINTS, PER_PERIOD * highest)), MOST_POINTS)
        if count <= 2 * highest:
            raise ValueError(
                f"{count} points a turn hold no order {highest}, which takes more than two a period; give more points"
            )
        return list(self._one_way(self.zero + 2.0 * math.pi * np.arange(count) / count, direction).tolist())

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Self:
        """Read a table from a file of `write`, or from CSV of points of another program; the content tells which.

        Points become lines by a discrete Fourier series, which gives every point back. Of a C header the comments at
        its head are read, which hold the lines.

        Parameters
        ----------
        path : str or path
            File of at most 16 MiB.

        Raises
        ------
        FileError
            If the file is no table; a ValueError with one line, `file:line:column: field: fact, value, remedy`.
        """
        path = Path(path)
        text = text_of(path, "table of orders", FILE_BYTES)
        try:
            return cls(**from_text(text, [field.name for field in fields(cls)]))
        except (ValueError, TypeError) as error:
            problem = error.args[0] if isinstance(error, Unfit) else Problem(1, 1, "file", str(error))
            raise FileError(complaint(path, [problem])) from None


def _checked(name: str, lines: object) -> tuple[Line, ...]:
    """Lines with whole orders, each once, finite amplitudes that are not negative, and finite phases (ValueError)."""
    if not isinstance(lines, Sequence) or not all(isinstance(line, Line) for line in lines):
        raise TypeError(f"{name} of an order table are {shown(lines)}; give lines, each an order, amplitude and phase")
    result: dict[int, Line] = {}
    for line in lines:
        order = positive_count("an order of an order table", line.order, HIGHEST)
        size = number(f"the amplitude of order {order}", line.amplitude)
        if size < 0.0:
            raise ValueError(
                f"the amplitude of order {order} is {size:g}; use a positive one and a phase of half a turn"
            )
        if order in result:
            raise ValueError(f"order {order} appears twice in the {name} of an order table; add both lines")
        result[order] = Line(order, size, number(f"the phase of order {order}", line.phase))
    return tuple(result.values())


def _range(speeds: object) -> tuple[float, float]:
    if not isinstance(speeds, Sequence) or len(speeds) != 2:
        raise ValueError(f"speeds of an order table are {shown(speeds)}; give the lowest and the highest, rad/s")
    low, high = [number("a speed of an order table", speed) for speed in speeds]
    if not 0.0 <= low <= high:
        raise ValueError(f"speeds of an order table are {low:g} .. {high:g} rad/s; they must be 0 <= lowest <= highest")
    return low, high


def _terms(thing: Any) -> list[Line]:
    """Lines of an error, a torque or a sequence (ValueError)."""
    terms = (thing,) if isinstance(thing, Harmonic) else getattr(thing, "terms", getattr(thing, "lines", thing))
    return [Line(*(number(name, getattr(line, name)) for name in Line._fields)) for line in terms]


def _mean(thing: object) -> float:
    """Constant part of a torque; that of an error has no effect."""
    terms = thing.terms if isinstance(thing, Harmonics) else (thing,)
    return float(sum(term.mean for term in terms if isinstance(term, Harmonic)))


def _merged(lines: Sequence[Line], turns: float) -> tuple[Line, ...]:
    """Lines whose orders are counted on another turn, ascending; those of one order are added (ValueError)."""
    groups: dict[int, list[Line]] = {}
    for line in lines:
        order = line.order * turns
        if abs(order - round(order)) > ORDER_TOLERANCE * max(1.0, order):
            fault = f"order {line.order:.6g} is {order:.6g} on the turn of the table, not a whole number; remove it"
            raise ValueError(fault)
        groups.setdefault(round(order), []).append(line)
    merged = []
    for order, (line, *others) in sorted(groups.items()):
        if others or line.amplitude < 0.0:
            c = sum(one.amplitude * complex(math.cos(one.phase), math.sin(one.phase)) for one in (line, *others))
            line = Line(order, abs(c), math.atan2(c.imag, c.real))
        merged.append(line._replace(order=order))
    return tuple(merged)


def _shifted(lines: Sequence[Line], ahead: float) -> tuple[Line, ...]:
    """Lines of a function that is read ahead by an angle [rad]."""
    return tuple(line._replace(phase=line.phase + line.order * ahead) for line in lines)
