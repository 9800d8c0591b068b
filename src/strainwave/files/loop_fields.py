"""The loop of a project's motor: by bandwidth and damping, or by gains; and either with the lag of a current loop."""

import re
from collections.abc import Callable
from typing import Annotated, Any

from pydantic import BeforeValidator
from pydantic_core import PydanticCustomError

from ..base.quantities import checked
from ..model.train.controls import HERTZ, KINDS, USUAL, Lagged, Tuning, control_of
from .entries import Wrong, loop_types, near, number, read_entry, refusal
from .yaml_text import shown

EXAMPLE_LOOP = "{bandwidth: 30 Hz, damping: 0.7}"
TUNED = ("type", "bandwidth", "damping", "lag")
GAINS = ("K_p", "K_i", "K_d")


def bandwidth(value: Any) -> float:
    """Read a bandwidth, "30 Hz" or "188 rad/s", in rad/s (ValueError): of a loop, unlike a shaft, it may be in Hz."""
    if isinstance(value, str) and "rad" in value:
        return number(value, "rad/s", "positive")
    if isinstance(value, str) and re.search("rpm|rev|turn|deg", value):
        raise ValueError(f"{shown(value)} is a speed of a shaft, not a bandwidth; write 30 Hz or 188 rad/s")
    return HERTZ * number(value, "Hz", "positive")


def _kind(value: Any) -> str:
    word = value.removesuffix("_loop") if isinstance(value, str) else ""
    if word not in KINDS:
        raise ValueError(f"{shown(value)} is not known{near(value, list(KINDS))}")
    return word


READERS: dict[str, Callable[[Any], Any]] = {
    "type": _kind,
    "bandwidth": bandwidth,
    "damping": lambda value: number(value, "", "positive"),
    "lag": lambda value: number(value, "s", "positive"),
}


def read_loop(value: Any) -> Any:
    """Read a loop: a `Tuning`, whose gains follow from the inertia, or a control with gains (PydanticCustomError)."""
    if isinstance(value, dict) and {"bandwidth", "damping"} & set(value):
        return _tuned(value)
    gains, lag, wrong = value, None, list[Wrong]()
    if isinstance(value, dict):
        gains = {name: item for name, item in value.items() if name != "lag"}
        if gains.get("type") in KINDS:
            gains["type"] += "_loop"
        lag = _read("lag", value["lag"], wrong) if "lag" in value else None
    try:
        loop = read_entry(gains, loop_types(), EXAMPLE_LOOP)
    except PydanticCustomError as error:
        raise refusal(*(error.context or {})["problems"], *wrong) from None
    if wrong:
        raise refusal(*wrong)
    return loop if lag is None else checked(Lagged(loop, lag))


def _tuned(value: dict[str, Any]) -> Tuning:
    wrong: list[Wrong] = []
    given = {name: _read(name, item, wrong) for name, item in value.items() if name in TUNED}
    if "bandwidth" not in value:
        wrong.append(Wrong(("bandwidth",), "is missing; write it, for example 30 Hz"))
    for name in value:
        if name in GAINS:
            said = "is a gain, and bandwidth and damping give the gains already; remove one or the other"
            wrong.append(Wrong((name,), said, True))
        elif name not in TUNED:
            wrong.append(Wrong((name,), f"unknown field; known: {', '.join(TUNED)}", True))
    if wrong:
        raise refusal(*wrong)
    kind, damping = given.get("type", USUAL.kind), given.get("damping", USUAL.damping)
    tuning = Tuning(given["bandwidth"], damping, kind, given.get("lag", 0.0))
    try:
        control_of(tuning, 1.0)
    except ValueError as error:
        raise refusal(Wrong(("bandwidth",), f"is too large: {error}")) from None
    return tuning


def _read(name: str, value: Any, wrong: list[Wrong]) -> Any:
    try:
        return None if value is None else READERS[name](value)
    except ValueError as error:
        return wrong.append(Wrong((name,), str(error)))


Loop = Annotated[Any, BeforeValidator(read_loop)]
