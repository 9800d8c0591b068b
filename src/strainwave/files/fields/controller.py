"""The group `controller` of a project file: when the drive's own controller samples, and what its encoders give."""

import math
import re
from collections.abc import Iterator
from typing import Any, ClassVar, Literal

from ...base.quantities import checked
from ...drive.asked import MotorLimits
from ...model.controllers.closed_loop import Sampling
from ..yaml_text import shown
from .kinds import Either, Quantity, Schema, Text, Whole, Wrong
from .rows import Fields, Group, field

MOST_BITS = 40
STEPS = Whole(
    2, 2**MOST_BITS, "write steps a turn, for example 65536", f"is not between 2 and 2^{MOST_BITS} steps a turn"
)


class EncoderSpec(Group):
    """Steps a turn, and noise."""

    steps: int | None = field(STEPS, "65536", "Steps of a turn.")
    noise: float = field(Quantity("rad", "not negative"), "2 arcsec", "Standard deviation of the noise.")

    conditions: ClassVar[Schema] = {"minProperties": 1}

    @property
    def numbers(self) -> tuple[float, float]:
        """Angle of a step, 0 without steps, and standard deviation of the noise [rad]."""
        return math.tau / self.steps if self.steps else 0.0, self.noise or 0.0

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
    found = re.fullmatch(r"([0-9]{1,3})[ -]?bits?", text.strip())
    if not found:
        raise ValueError(f"{shown(text)} is not an encoder; write 16 bit, or {{steps: 65536, noise: 2 arcsec}}")
    bits = int(found[1])
    if not 1 <= bits <= MOST_BITS:
        raise ValueError(f"{text!r} is not between 1 and {MOST_BITS} bit; write for example 16 bit")
    return EncoderSpec(steps=2**bits)


BITS = Text(_bits, lambda: {"pattern": "^\\s*[0-9]{1,2}[ -]?bits?\\s*$", "examples": ["16 bit"]}, "an encoder")


class ControllerSpec(Group):
    """Samples and encoders of the drive's own controller."""

    period: float = field(Quantity("s", "positive"), "250 us", "Time from sample to sample.", "250 us")
    delay: float | None = field(Quantity("s", "not negative"), "250 us",
        "Time from a sample to the torque that it gives; without it one period.")  # fmt: skip
    motor_encoder: EncoderSpec = field(Either(BITS, Fields(EncoderSpec)), "16 bit",
        "Encoder on the motor's shaft, by its bits or by the steps of a turn and its noise.", "16 bit")  # fmt: skip
    load_encoder: EncoderSpec | Literal["none"] = field(Either(BITS, Fields(EncoderSpec), word="none"),
        "24 bit", "Encoder on the load's shaft, or none.", "none")  # fmt: skip
    loss: float = field(Quantity("", "not negative"), "0.1 %", "Share of the motor's samples that are lost.", 0)

    def sampling(self, limits: MotorLimits | None = None) -> Sampling:
        """The samples, with the largest torque of the motor where that is known."""
        load = (0.0, 0.0) if self.load_encoder == "none" else self.load_encoder.numbers
        quantum, noise = self.motor_encoder.numbers
        sampling: Sampling = checked(
            Sampling(
                period=self.period,
                delay=self.period if self.delay is None else self.delay,
                motor_quantum=quantum,
                motor_noise=noise,
                load_quantum=load[0],
                load_noise=load[1],
                loss=float(self.loss),
                load_encoder=int(self.load_encoder != "none"),
            )
        )
        most = math.inf if limits is None else limits.torque
        return sampling._replace(limit=most) if math.isfinite(most) else sampling

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
