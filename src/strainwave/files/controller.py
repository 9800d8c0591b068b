"""The group `controller` of a project file: when the drive's own controller samples, and what its encoders give.

An encoder is given by its steps a turn, "16 bit" or {steps: 65536, noise: 2 arcsec}: that of the motor on the motor's
shaft, that of the load on the load's.
"""

import math
import re
from collections.abc import Callable
from typing import Annotated, Any, NamedTuple

from pydantic import BeforeValidator
from pydantic_core import PydanticCustomError

from ..base.quantities import checked
from ..drive.asked import MotorLimits
from ..model.controllers.closed_loop import Sampling
from .entries import Wrong, about, number, refusal, whole
from .yaml_text import shown

EXAMPLE = "{period: 250 us, delay: 250 us, motor_encoder: 16 bit, load_encoder: 24 bit}"
NONE = "none"
MOST_BITS = 40
PERIOD, NO_LIMIT = 250e-6, 1e9  # s; N*m, that of `Sampling`


class Encoder(NamedTuple):
    """Steps a turn, 0 for an angle without steps, and the standard deviation of the noise [rad]."""

    steps: int
    noise: float = 0.0

    @property
    def quantum(self) -> float:
        """Angle of a step [rad]."""
        return math.tau / self.steps if self.steps else 0.0


USUAL = Encoder(2**16)


def _steps(value: Any) -> int:
    steps = whole(value, "write steps a turn, for example 65536")
    if not 2 <= steps <= 2**MOST_BITS:
        raise ValueError(f"{value!r} is not between 2 and 2^{MOST_BITS} steps a turn")
    return steps


def _noise(value: Any) -> float:
    return number(value, "rad", "not negative")


PARTS: dict[str, Callable[[Any], Any]] = {"steps": _steps, "noise": _noise}


def encoder(value: Any) -> Encoder:
    """Read an encoder, "16 bit" or {steps: 65536, noise: 2 arcsec} (ValueError, PydanticCustomError)."""
    if isinstance(value, dict):
        return _encoder_of(value)
    found = re.fullmatch(r"([0-9]{1,3})[ -]?bits?", value.strip()) if isinstance(value, str) else None
    if not found:
        raise ValueError(f"{shown(value)} is not an encoder; write 16 bit, or {{steps: 65536, noise: 2 arcsec}}")
    bits = int(found[1])
    if not 1 <= bits <= MOST_BITS:
        raise ValueError(f"{value!r} is not between 1 and {MOST_BITS} bit; write for example 16 bit")
    return Encoder(2**bits)


def _encoder_of(value: dict[str, Any]) -> Encoder:
    wrong = [Wrong((name,), f"unknown field; known: {', '.join(PARTS)}", True) for name in value if name not in PARTS]
    given: dict[str, Any] = {}
    for name, item in value.items():
        if name in PARTS:
            _read(PARTS[name], name, item, given, wrong)
    if not given and not wrong:
        wrong.append(Wrong(("steps",), "is missing; write steps a turn, for example 65536"))
    if wrong:
        raise refusal(*wrong)
    return Encoder(given.get("steps", 0), given.get("noise", 0.0))


def _load_encoder(value: Any) -> Encoder | None:
    return None if value == NONE else encoder(value)


READERS: dict[str, Callable[[Any], Any]] = {
    "period": lambda value: number(value, "s", "positive"),
    "delay": lambda value: number(value, "s", "not negative"),
    "motor_encoder": encoder,
    "load_encoder": _load_encoder,
    "loss": lambda value: number(value, "", "not negative"),
}


def _read(reader: Callable[[Any], Any], name: str, value: Any, given: dict[str, Any], wrong: list[Wrong]) -> None:
    """Read one field into `given`, or add to `wrong` what is wrong with it; an empty one was told of before."""
    if value is None:
        wrong.append(Wrong((name,), ""))
        return
    try:
        given[name] = reader(value)
    except PydanticCustomError as error:
        below = (error.context or {})["problems"]
        wrong.extend(one._replace(keys=(name, *one.keys)) for one in below)
    except ValueError as error:
        wrong.append(Wrong((name,), str(error)))


def read_controller(value: Any) -> Sampling:
    """Read the group as a `Sampling` without a limit of the torque (PydanticCustomError with all that is wrong).

    Without a delay there is one of a period; without encoders the motor has one of 16 bit, and the load none.
    """
    if not isinstance(value, dict):
        raise ValueError(f"{shown(value)} is not a group of fields; write for example {EXAMPLE}")
    wrong = [
        Wrong((name,), f"unknown field; known: {', '.join(READERS)}", True) for name in value if name not in READERS
    ]
    given: dict[str, Any] = {}
    for name, item in value.items():
        if name in READERS:
            _read(READERS[name], name, item, given, wrong)
    if wrong:
        raise refusal(*wrong)
    motor, load = given.get("motor_encoder", USUAL), given.get("load_encoder")
    period = given.get("period", PERIOD)
    known = load or Encoder(0)
    try:
        sampling: Sampling = checked(
            Sampling(
                period=period,
                delay=given.get("delay", period),
                motor_quantum=motor.quantum,
                motor_noise=motor.noise,
                load_quantum=known.quantum,
                load_noise=known.noise,
                loss=given.get("loss", 0.0),
                load_encoder=int(load is not None),
            )
        )
    except ValueError as error:
        raise refusal(about(error, Sampling, given)) from None
    return sampling


def limited(sampling: Sampling | None, limits: MotorLimits | None) -> Sampling | None:
    """The sampling with the largest torque of the motor, where that is known."""
    most = math.inf if limits is None else limits.torque
    return sampling._replace(limit=most) if sampling is not None and math.isfinite(most) else sampling


def controller_text(sampling: Sampling) -> str:
    """Write a sampling as the group of a project file; its limit is that of the motor."""
    load = _encoder_text(sampling.load_quantum, sampling.load_noise) if sampling.load_encoder else NONE
    loss = f", loss: {sampling.loss!r}" if sampling.loss else ""
    return (
        f"{{period: {sampling.period!r} s, delay: {sampling.delay!r} s, "
        f"motor_encoder: {_encoder_text(sampling.motor_quantum, sampling.motor_noise)}, load_encoder: {load}{loss}}}"
    )


def _encoder_text(quantum: float, noise: float) -> str:
    fields = [f"steps: {round(math.tau / quantum)}"] if quantum else []
    fields += [f"noise: {noise!r} rad"] if noise or not quantum else []
    return f"{{{', '.join(fields)}}}"


Controller = Annotated[Sampling, BeforeValidator(read_controller)]
