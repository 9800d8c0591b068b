"""Groups of a project file: `excitation`, `controller`, and `scatter` with `scatter_correlation`."""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np

from ...base.quantities import checked
from ...drive.demands.motor_limits import MotorLimits, curve_fault
from ...model.controllers.closed_loop import Sampling
from ...model.excitation import Line
from ...model.orders import order_pair
from ..yaml_text import shown
from . import kinds
from .kinds import Either, Entry, Items, Kind, Quantity, Schema, Whole, Wrong
from .rows import Fields, Group, Points, field, needed

MOST_LINES = 64
CATALOGUE = "catalogue"  # in place of an accuracy: the one that the gear's record gives
UNPRINTED = "60 arcsec"  # in place of an accuracy: that of a first project of a gear whose record gives none
WORST = 1.0  # deg: an accuracy class is at most 3 arcmin in catalogues
LINE = "{order: 2, amplitude: 23 arcsec}"
TORQUE_LINE = "{order: 1, amplitude: 0.1 N*m}"
TORQUE = Quantity("N*m")
ORDER = Whole(
    1, 1000, "write how often the line repeats per turn, for example 2",
    "is not between 1 and 1000; a constant part belongs in 'mean'",
)  # fmt: skip


def ascending(low: float, high: float, what: str) -> Iterator[Wrong]:
    """Refuse a range whose end is not above its begin."""
    if low >= high:
        remedy = f"write the one {what} alone" if low == high else f"write the smaller {what} after 'from'"
        yield Wrong(("to",), f"the range does not ascend; {remedy}")


class OrderPair(Group):
    """Order of a line of two turns, the wave generator's and the output's, which counts along its own motion.

    An oval spline that turns with the output has 2 and 2 (order 2 + 2/N) with the circular spline fixed, whose output
    runs against the motor; 2 and -2 (2 - 2/N) with the flexspline fixed and the ratio N + 1.
    """

    wave_generator: int = field(Whole(0, 1000, beyond="is not between 0 and 1000"), "2",
        "Periods per turn of the wave generator.", 0)  # fmt: skip
    output: int = needed(Whole(-10_000, 10_000, beyond="is not between -10000 and 10000"), "2",
        "Periods per turn of the output, in its direction of motion: for an oval spline that turns with it, 2 with "
        "fixed circular spline, -2 with fixed flexspline.")  # fmt: skip


class LineAmplitude(Group):
    """Amplitude of a line that grows with the mean torque in the gear, or is another one in backward motion."""

    at_rest: float = needed(Quantity("rad", "not negative"), "20 arcsec", "Amplitude at zero torque, 0-to-peak.")
    per_torque: float = field(Quantity("rad/(N*m)"), "0.1 arcsec/(N*m)",
        "Increase of the amplitude per mean gear torque (load torque with opposite sign).", 0.0)  # fmt: skip
    backward: float | None = field(Quantity("rad", "not negative"), "17 arcsec",
        "Amplitude at zero torque in backward motion. Default: as in forward motion.", None)  # fmt: skip


class ErrorLine(Group):
    """One line of the kinematic error."""

    order: int | OrderPair = needed(Either(ORDER, Fields(OrderPair)), "2",
        "Periods per turn of the base angle; for both turns {wave_generator: 2, output: 2}.")  # fmt: skip
    amplitude: float | LineAmplitude = needed(
        Either(Quantity("rad", "not negative"), Fields(LineAmplitude)), "23 arcsec",
        "Amplitude, 0-to-peak; for one that grows with torque: {at_rest: 20 arcsec, per_torque: 0.1 arcsec/(N*m)}."
    )  # fmt: skip
    phase: float = field(kinds.PHASE, "90 deg", "Phase of the cosine of this order.", 0.0)

    def line(self, ratio: float = math.nan, *, backward: bool = False) -> Line:
        """The line as an object of the model, in a gear of that ratio without a torque; of either direction."""
        of, size = self.order, self.amplitude
        order = of.wave_generator + of.output / ratio if isinstance(of, OrderPair) else of
        if not isinstance(size, LineAmplitude):
            return Line(order, size, self.phase)
        return Line(order, size.backward if backward and size.backward is not None else size.at_rest, self.phase)

    @property
    def alike(self) -> bool:
        """True for a line that is the same in both directions of motion."""
        return not isinstance(self.amplitude, LineAmplitude) or self.amplitude.backward is None

    @property
    def per_torque(self) -> float:
        """Growth of the amplitude [rad/(N*m)]."""
        return self.amplitude.per_torque if isinstance(self.amplitude, LineAmplitude) else 0.0

    @classmethod
    def of(
        cls, line: Any, ratio: float = math.nan, per_torque: float = 0.0, backward: float | None = None
    ) -> "ErrorLine":  # fmt: skip
        """A line with a size, the phase moved by half a turn where the amplitude is negative."""
        phase, order = line.phase if line.amplitude >= 0.0 else line.phase + math.pi, line.order
        if order % 1:
            turns = order_pair(order, ratio)
            counted: OrderPair | int = OrderPair(wave_generator=turns[0] or None, output=turns[1])
        else:
            counted = int(order)
        backward = None if backward == line.amplitude else backward
        plain = not per_torque and backward is None
        loaded = LineAmplitude(at_rest=line.amplitude, per_torque=per_torque or None, backward=backward)
        return cls(order=counted, amplitude=abs(line.amplitude) if plain else loaded, phase=phase or None)


class TorqueLine(ErrorLine):
    """One line of a torque."""

    order: int = needed(ORDER, "1", "Periods of the line per turn of the base angle.")
    amplitude: float = needed(Quantity("N*m", "not negative"), "0.1 N*m", "Amplitude of the line, 0-to-peak.")


class TorqueRange(Group):
    """A mean torque that lies anywhere between two, as that of gravity on an arm does."""

    from_: float = needed(TORQUE, "-60 N*m", "Lower end of the range.")
    to: float = needed(TORQUE, "60 N*m", "Upper end of the range.")

    def check(self) -> Iterator[Wrong]:
        """Refuse a range that does not ascend."""
        return ascending(self.from_, self.to, "torque")


class TorqueSpec(Group):
    """Torque on a free motor, on the motor side."""

    mean: float | TorqueRange = field(TORQUE, "5 N*m", "Mean of the torque.", 0.0)
    lines: tuple[TorqueLine, ...] = field(Items(Fields(TorqueLine), high=MOST_LINES), f"[{TORQUE_LINE}]",
        "Lines of the torque.", ())  # fmt: skip

    @property
    def range(self) -> tuple[float, float] | None:
        """Least and largest mean [N*m] where the file gives a range of them."""
        return (self.mean.from_, self.mean.to) if isinstance(self.mean, TorqueRange) else None


class LoadTorqueSpec(TorqueSpec):
    """Torque on the load, on the output side; a resisting torque is negative."""

    mean: float | TorqueRange = field(Either(TORQUE, Fields(TorqueRange)), "{from: -60 N*m, to: 60 N*m}",
        "Mean of the torque, or its range (for example gravity on an arm).", 0.0)  # fmt: skip


def _accuracy(angle: float, text: str) -> None:
    if angle > math.radians(WORST) * (1.0 + 1e-9):
        raise ValueError(f"{text!r} is above {WORST:g} deg, and catalogues have 0.5 to 3 arcmin; check the unit")


ACCURACY = kinds.Accuracy("rad", "positive", CATALOGUE, _accuracy)


class ExcitationSpec(Group):
    """Excitation of the error; something periodic must be there."""

    accuracy: float | str | None = field(ACCURACY, "1 arcmin",
        "Accuracy of the gear, peak-to-peak, instead of lines; at most 1 deg, or catalogue or special of the catalogue."
    )  # fmt: skip
    kinematic_error: tuple[ErrorLine, ...] = field(Items(Fields(ErrorLine), high=MOST_LINES), f"[{LINE}]",
        "Lines of the kinematic error, on the output side.", ())  # fmt: skip
    motor_torque: TorqueSpec | None = field(TorqueSpec, f"{{mean: 5 N*m, lines: [{TORQUE_LINE}]}}")
    load_torque: LoadTorqueSpec | None = field(LoadTorqueSpec, f"{{mean: 5 N*m, lines: [{TORQUE_LINE}]}}")


YOURS, ASSUMED, MEASURED = "yours", "assumed", "measured"  # beside CATALOGUE: where a number comes from
MOST_SOURCES = 1000  # one for every number of a long file
MOST_SCATTER = 0.3  # beyond it a normal distribution has values near zero
MOST_OF_PHASE = 1.0  # rad
SAME, NO_VARIANCE = 1e-9, 1e-5  # of correlations: equal, and what their rounding may do to a variance


class Radians(float):
    """Standard deviation of a phase [rad], which has no size of its own; those of other numbers are relative."""


@dataclass(frozen=True)
class Deviation(Kind):
    """A standard deviation: relative to the number itself, or the angle of a phase."""

    def read(self, value: object, entry: Entry) -> Any:
        try:
            share = kinds.number(value, "", "positive")
        except ValueError:
            if not (isinstance(value, str) and re.search(r"[A-Za-z°]\s*$", value)):
                raise
            angle = kinds.number(value, "rad", "positive")
            if angle > MOST_OF_PHASE:
                sentence = f"{value!r} is more than {MOST_OF_PHASE:g} rad; write one standard deviation"
                raise ValueError(sentence) from None
            return Radians(angle)
        if share > MOST_SCATTER:
            raise ValueError(f"{value!r} is more than {100 * MOST_SCATTER:g} %; write one standard deviation, as 5 %")
        return share

    def schema(self) -> Schema:
        share = Quantity("", "positive", ends=(("maximum", MOST_SCATTER),))
        return {"anyOf": [share.schema(), Quantity("rad", "positive").schema()]}

    def text(self, value: object) -> str:
        return f"{float(value)!r} rad" if isinstance(value, Radians) else repr(value)


@dataclass(frozen=True)
class Named(Kind):
    """Values of one kind by names."""

    kind: Kind
    high: int = 32

    def read(self, value: object, entry: Entry) -> Any:
        if not isinstance(value, dict):
            raise kinds.NotOfKind("a group of fields")
        if not 1 <= len(value) <= self.high:
            raise ValueError(f"has {len(value)} items; write at {f'most {self.high}' if value else 'least 1'}")
        return {key: kinds.read(self.kind, item, entry.inside(key)) for key, item in value.items()}

    def schema(self) -> Schema:
        counts = {"minProperties": 1, "maxProperties": self.high}
        return {"type": "object", "additionalProperties": self.kind.schema(), **counts}

    def text(self, value: Any) -> str:
        return "{" + ", ".join(f"{key}: {self.kind.text(item)}" for key, item in value.items()) + "}"


@dataclass(frozen=True)
class Correlation(Kind):
    """A correlation matrix: equal on both sides of its diagonal of ones, and no variance below zero."""

    def read(self, rows: object, entry: Entry) -> tuple[tuple[float, ...], ...]:
        if not isinstance(rows, list) or not all(isinstance(row, list) for row in rows):
            raise ValueError("is no list of rows; write for example [[1, -0.5], [-0.5, 1]]")
        table = tuple(tuple(kinds.number(value, "") for value in row) for row in rows)
        if any(len(row) != len(table) for row in table):
            fault = f"has {len(table)} rows, not all with {len(table)} numbers; write one for each of 'scatter'"
            raise ValueError(fault)
        matrix = np.array(table)
        if np.any(np.abs(matrix - matrix.T) > SAME) or np.any(np.abs(np.diag(matrix) - 1.0) > SAME):
            fault = "is not the same on both sides of a diagonal of ones; write for example [[1, -0.5], [-0.5, 1]]"
            raise ValueError(fault)
        if len(table) and (least := float(np.linalg.eigvalsh(matrix)[0])) < -NO_VARIANCE:
            fault = f"gives a sum of the numbers a variance of {least:.2g}, below zero; write smaller correlations"
            raise ValueError(fault)
        return table

    def schema(self) -> Schema:
        return Items(Items(Quantity())).schema()

    def text(self, value: Any) -> str:
        return repr([list(row) for row in value])


MOST_BITS = 40
STEPS = Whole(
    2, 2**MOST_BITS, "write steps a turn, for example 65536", f"is not between 2 and 2^{MOST_BITS} steps a turn"
)


class EncoderSpec(Group):
    """Steps a turn, and noise."""

    steps: int | None = field(STEPS, "65536", "Steps per turn.")
    noise: float = field(Quantity("rad", "not negative"), "2 arcsec", "Standard deviation of the encoder noise.")

    conditions: ClassVar[Schema] = {"minProperties": 1}

    @property
    def quantum(self) -> float:
        """Angle of a step [rad]; 0 without steps."""
        return math.tau / self.steps if self.steps else 0.0

    @staticmethod
    def of(quantum: float, noise: float) -> "EncoderSpec":
        """The encoder of these numbers [rad]."""
        steps = round(math.tau / quantum) if quantum else None
        return EncoderSpec(steps=steps, noise=noise if noise or not quantum else None)

    def check(self) -> Iterator[Wrong]:
        """Refuse an encoder of which nothing is known."""
        if not self.given:
            yield Wrong(("steps",), "is missing; write steps a turn, for example 65536")


def _bits(text: str) -> Any:
    match = re.fullmatch(r"([0-9]{1,3})[ -]?bits?", text.strip())
    if not match:
        raise ValueError(f"{shown(text)} is not an encoder; write 16 bit, or {{steps: 65536, noise: 2 arcsec}}")
    bits = int(match[1])
    if not 1 <= bits <= MOST_BITS:
        raise ValueError(f"{text!r} is not between 1 and {MOST_BITS} bit; write for example 16 bit")
    return EncoderSpec(steps=2**bits)


BITS = kinds.Text(_bits, lambda: {"pattern": "^\\s*[0-9]{1,2}[ -]?bits?\\s*$", "examples": ["16 bit"]}, "an encoder")


@dataclass(frozen=True)
class TorqueCurve(Points):
    """Points of a motor's torque over its speed, or the name of a CSV file that has them."""

    units: tuple[str, str] = ("rad/s", "N*m")
    pair: str = "a speed and a torque; write [3000 rpm, 1.2 N*m]"

    def read(self, value: object, entry: Entry) -> Any:
        if isinstance(value, str):
            return kinds.FILE_NAME.read(value, entry)
        points = super().read(value, entry)
        complete = all(point and None not in point for point in points)  # a fault in a point is reported there
        if fault := curve_fault(points) if complete else "":
            raise ValueError(fault)
        return points

    def schema(self) -> Schema:
        return {"anyOf": [super().schema(), kinds.FILE_NAME.schema()]}

    def text(self, value: Any) -> str:
        return kinds.FILE_NAME.text(value) if isinstance(value, str) else super().text(value)

    def example(self) -> str:
        return "points such as [[0 rpm, 2 N*m], [3000 rpm, 1.2 N*m]], or the name of a CSV file"


class ControllerSpec(Group):
    """Samples and encoders of the drive's own controller."""

    period: float = field(Quantity("s", "positive"), "250 us", "Sampling period of the controller.", "250 us")
    delay: float | None = field(Quantity("s", "not negative"), "250 us",
        "Time from a sample to its torque output. Default: one period.")  # fmt: skip
    motor_encoder: EncoderSpec = field(Either(BITS, Fields(EncoderSpec)), "16 bit",
        "Encoder on the motor shaft: bits, or steps per turn and noise.", "16 bit")  # fmt: skip
    load_encoder: EncoderSpec | Literal["none"] = field(Either(BITS, Fields(EncoderSpec), word="none"),
        "24 bit", "Encoder on the load's shaft, or none.", "none")  # fmt: skip
    loss: float = field(Quantity("", "not negative"), "0.1 %", "Fraction of lost samples of the motor encoder.", 0)

    def sampling(self, limits: MotorLimits | None = None) -> Sampling:
        """The samples, with the largest torque of the motor where that is known."""
        load = EncoderSpec() if self.load_encoder == "none" else self.load_encoder
        sampling = checked(Sampling(
            period=self.period, delay=self.period if self.delay is None else self.delay, loss=float(self.loss),
            motor_quantum=self.motor_encoder.quantum, motor_noise=self.motor_encoder.noise or 0.0,
            load_quantum=load.quantum, load_noise=load.noise or 0.0, load_encoder=int(self.load_encoder != "none"),
        ))  # fmt: skip
        largest = math.inf if limits is None else limits.most
        return sampling._replace(limit=largest) if math.isfinite(largest) else sampling

    @staticmethod
    def of(sampling: Sampling) -> "ControllerSpec":
        """The group of samples; their limit is that of the motor."""
        load = EncoderSpec.of(sampling.load_quantum, sampling.load_noise) if sampling.load_encoder else "none"
        return ControllerSpec(
            period=sampling.period,
            delay=sampling.delay,
            motor_encoder=EncoderSpec.of(sampling.motor_quantum, sampling.motor_noise),
            load_encoder=load,
            loss=sampling.loss or None,
        )

    def check(self) -> Iterator[Wrong]:
        """Refuse what no loop can do with."""
        self.sampling()
        yield from ()
