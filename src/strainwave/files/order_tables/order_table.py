"""`OrderTable`: the one canonical form of what cancels an error order by order, with its files.

The formats of order tables by name: a new one is its class and a line here.
"""

import os
from collections.abc import Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, Self

from ...base.archive import as_file, atomic
from ...base.quantities import number, shown
from ...base.sentences import on_screen
from ...model.excitation import Harmonic, Harmonics, KinematicError, Line
from ..yaml_text import FileError, Problem, as_path, complaint, text_of
from .content import OrderContent, counted, merged, positive
from .format import OrderFormat, TableResidual, encoded, with_options
from .formats.beckhoff import Beckhoff, TwinCat
from .formats.code import CHeader, StructuredText
from .formats.linuxcnc import HalComponent, LinuxCnc
from .formats.plain import CsvGrid, CsvLines, CsvPoints, JsonFile
from .formats.points_a_turn import Moteus, OnStepX, Sinumerik
from .points import Unfit, said_by

LARGEST = 16 * 1024 * 1024

CLASSES: tuple[type[OrderFormat], ...] = (
    JsonFile, CsvLines, CsvPoints, CsvGrid, CHeader, StructuredText, Beckhoff, Moteus, LinuxCnc, HalComponent, TwinCat,
    Sinumerik, OnStepX,
)  # fmt: skip
FORMATS = MappingProxyType({cls.name: cls for cls in CLASSES})
BY_ENDING = MappingProxyType({".json": "json", ".csv": "csv", ".h": "c"})


def named(name: str) -> type[OrderFormat]:
    """Format of a name (ValueError)."""
    if name not in FORMATS:
        raise ValueError(f"{shown(name)} is no format of order tables; known are {', '.join(FORMATS)}")
    return FORMATS[name]


def recognised(text: str) -> type[OrderFormat] | None:
    """The format that a text looks like, if there is one."""
    return next((cls for cls in CLASSES if cls.recognises(text)), None)


class OrderTable(OrderContent):
    """Orders that cancel an error, with all that a machine must know to add them rightly; read and written as files.

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
        Turns of the motor per turn of the output; needed to change the turn.
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
        Where the numbers come from.
    """

    @classmethod
    def of(cls, error: object, *, backward: Any = None, **fields: Any) -> Self:
        """Order table of a kinematic error, an error scan, a torque over an angle, or any lines.

        Parameters
        ----------
        error, backward : KinematicError, ErrorScan, Harmonic, Harmonics, or sequence of Line
            What has `lines` with order, amplitude and phase, such lines, or a torque; `backward` where backward motion
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
        is_torque = isinstance(error, Harmonic | Harmonics)
        usual: dict[str, Any] = {"unit": "N*m" if is_torque else "rad", "mean": _mean_of(error)}
        sets = {"lines": _lines_of(error)}
        if backward is not None:
            sets["backward"], usual["mean_backward"] = _lines_of(backward), _mean_of(backward)
        broken = [line.order for lines in sets.values() for line in lines if line.order % 1]
        if broken and "turn" not in fields:
            if (ratio := fields.get("ratio")) is None:
                raise ValueError(
                    f"order {broken[0]:.6g} is a line of the output's turn; give the ratio, and the table counts there"
                )
            ratio = number("ratio of an order table", ratio, positive=True)
            sets = {name: merged(counted(lines, ratio, "output", ratio)) for name, lines in sets.items()}
            usual["turn"] = "output"
        return cls(**usual | sets | fields)

    def torque(self) -> Harmonics:
        """The correction as a torque over the angle of the table, as `TorqueTable` adds it `delay` ahead.

        Raises
        ------
        ValueError
            If the table is an angle, has no lines, or differs between the directions of motion.
        """
        if self.unit != "N*m":
            raise ValueError("the table is an angle in rad, no torque; only a table in N*m is one")
        lines, mean = self._alike("a torque over an angle"), self.mean
        terms = [Harmonic(line.amplitude, line.order, line.phase) for line in lines]
        sign = 1.0 if self.sign == "correction" else -1.0
        terms[0] = terms[0]._replace(mean=mean)
        return Harmonics(tuple(term._replace(amplitude=sign * term.amplitude, mean=sign * term.mean) for term in terms))

    def kinematic_error(self) -> KinematicError:
        """The lines as a kinematic error on the turn of the table; a constant part has no effect there.

        Raises
        ------
        ValueError
            If the table is a torque, has no lines, or differs between the directions of motion.
        """
        if self.unit != "rad":
            raise ValueError("the table is a torque in N*m, no kinematic error; only a table in rad is one")
        return KinematicError(self._alike("a kinematic error"))

    def _alike(self, target: str) -> tuple[Line, ...]:
        """The lines, if there are any and they are those of both directions."""
        if self.backward is not None or self.direction != "both":
            raise ValueError(
                f"the table differs between forward and backward motion, {target} does not; choose with one_way"
            )
        if not self.lines:
            raise ValueError(f"the table has no lines, {target} needs one; leave it out")
        return self.lines

    def residual(self, format: str | OrderFormat, *, drop: bool = False, **options: Any) -> TableResidual:
        """What a format leaves of the table, without writing a file; arguments as of `write`."""
        return encoded(_format(format, options), self, drop)[1]

    def write(
        self, path: str | os.PathLike[str], format: str | OrderFormat | None = None, *, drop: bool = False,
        **options: Any,
    ) -> TableResidual:  # fmt: skip
        """Write the table for a machine and say what the file leaves of it; it appears when it is complete.

        Parameters
        ----------
        path : str or path
            File.
        format : str or OrderFormat, optional
            json, csv, points, grid, c, st, beckhoff, moteus, linuxcnc, hal, twincat, sinumerik, onstepx. Default: by
            the ending .json, .csv (lines) or .h (C).
        drop : bool
            Whether orders that the format cannot hold are left out, the weakest first, in place of a refusal.
        **options
            Of the format: `points`, `torque_constant`, `axis`, ...

        Returns
        -------
        TableResidual
            Of the very numbers in the file: rounding, straight lines between points, orders left out.

        Raises
        ------
        ValueError
            If the format cannot hold the table, or is not known.
        FileNotFoundError
            If there is no such folder.
        """
        path = as_file(path)
        if format is None:
            format = BY_ENDING.get(path.suffix)
            if format is None:
                raise ValueError(f"{shown(path.name)} does not tell the format; give one of {', '.join(FORMATS)}")
        text, left = encoded(_format(format, options), self, drop)
        with atomic(path) as part:
            Path(part).write_text(text, encoding="utf-8", newline="\n")
        return left

    @classmethod
    def read(cls, path: str | os.PathLike[str], format: str | OrderFormat | None = None, **options: Any) -> Self:
        """Read a table from any of the formats.

        Points become lines by a discrete Fourier series, which gives every point back; `keep` and `strongest` leave the
        rounding out.

        Parameters
        ----------
        path : str or path
            File of at most 16 MiB.
        format : str or OrderFormat, optional
            Default: recognised by the content.
        **options
            Of the format, where the file itself does not tell them.

        Raises
        ------
        FileError
            If the file is no table; a ValueError with one line, `file:line:column: field: fact, value, remedy`.
        ValueError
            If an option is missing or wrong.
        """
        path = as_path(path)
        text = text_of(path, "table of orders", LARGEST).replace("\r\n", "\n")
        if format is None:
            found = recognised(text)
            if found is None:
                said = f"is no order table that is recognised; give format, one of {', '.join(FORMATS)}"
                raise FileError(complaint(path, [Problem(1, 1, "file", said)]))
            format = found.name
        try:
            if isinstance(format, str):
                told = {name: value for name, value in said_by(text)[1].items() if name not in options}
                format = _format(format, told | options)
            return cls(**vars(format.parse(text)))
        except Unfit as unfit:
            raise FileError(complaint(path, [unfit.args[0]])) from None
        except (ValueError, TypeError) as error:
            raise FileError(complaint(path, [Problem(1, 1, "file", str(error))])) from None

    def __str__(self) -> str:
        what = "kinematic error" if (self.sign, self.unit) == ("error", "rad") else self.sign
        rows = [
            f"Order table: {what} in {self.unit}, orders per turn of the {self.turn}"
            + ("" if self.ratio is None else f", ratio {self.ratio:g}")
            + (", pairs (motor, output)" if self.pairs else "")
        ]
        pairs = dict(zip(self.orders, self.pairs or (), strict=False))
        for name, mean, lines in (("forward", self.mean, self.lines), ("backward", self.mean_backward, self.backward)):
            if lines is None:
                continue
            head = name if self.backward is not None else f"direction {self.direction}"
            rows.append(f"  {head}: " + (f"constant part {mean:.4g}, " if mean else "") + f"{len(lines)} orders")
            for line in lines:
                turns = f"  ({pairs[line.order][0]}, {pairs[line.order][1]})" if line.order in pairs else ""
                rows.append(f"{line.order:>8}  {line.amplitude:<12.4g} at {line.phase:.4f} rad{turns}")
        rows.append(f"  encoder's index at {self.zero:.6g} rad, delay {self.delay:.4g} s")
        if self.speeds is not None or self.load is not None:
            low, high = self.speeds or (0.0, float("inf"))
            load = "" if self.load is None else f", {self.load:g} N*m on the load"
            rows.append(f"  holds for {low:.6g} .. {high:.6g} rad/s of the motor{load}")
        return on_screen("\n".join([*rows, *([f"  source: {self.source}"] if self.source else [])]))

    __repr__ = __str__


def _format(form: str | OrderFormat, options: dict[str, Any]) -> OrderFormat:
    if isinstance(form, OrderFormat):
        if options:
            raise ValueError(f"{form.title} is given with its options already; leave out {', '.join(options)}")
        return form
    if not isinstance(form, str):
        raise TypeError(f"format is {shown(form)}; give one of {', '.join(FORMATS)}, or an OrderFormat")
    return with_options(named(form), options)


def _whole(order: object) -> Any:
    """An order that a fit gives as a float."""
    return int(order) if isinstance(order, float) and order.is_integer() else order


def _terms_of(thing: object) -> Any:
    """What has order, amplitude and phase in an error, a torque or a sequence; None where there is nothing such."""
    if isinstance(thing, Harmonic):
        return (thing,)
    if isinstance(thing, Harmonics):
        return thing.terms
    return thing if isinstance(thing, Sequence) and not hasattr(thing, "lines") else getattr(thing, "lines", None)


def _mean_of(thing: object) -> float:
    """Constant part of a torque; that of an error has no effect."""
    return float(sum(term.mean for term in _terms_of(thing))) if isinstance(thing, Harmonic | Harmonics) else 0.0


def _lines_of(thing: object) -> tuple[Line, ...]:
    lines = _terms_of(thing)
    if not isinstance(lines, Sequence) or not all(hasattr(line, "order") for line in lines):
        raise TypeError(f"{shown(thing)} has no lines of orders; give a KinematicError, an ErrorScan, or lines")
    sizes = [(number("amplitude", line.amplitude), number("phase", line.phase)) for line in lines]
    return positive([Line(_whole(number("order", line.order)), *size) for line, size in zip(lines, sizes, strict=True)])
