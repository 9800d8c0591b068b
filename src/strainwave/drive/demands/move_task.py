"""Move that a project file asks for, and what the motor is given beside its loop."""

from typing import Any, Literal, NamedTuple

from ...base.quantities import Ratio, choice
from .payload import Payload


class Feedforward(NamedTuple):
    """Feedforward of a move, as shares of what the motor's model needs: 1 is exact.

    `acceleration` is the torque of all inertias, rigid; `gravity` that which a constant torque and the angles of the
    shafts take at rest; `friction` what their drags add at the speed of the reference, of a law with memory the part
    that depends on the speed alone; `speed` is the share of the reference's speed in that which the speed loop follows.

    The torque joins that of the loop `at` its "reference", before torque filters and the lag of the current loop, or
    behind them, at the "motor".
    """

    acceleration: Ratio = 0.0
    gravity: Ratio = 0.0
    friction: Ratio = 0.0
    speed: Ratio = 1.0
    at: Literal["reference", "motor"] = "reference"

    def check(self) -> None:
        """Refuse negative shares, and another place (ValueError)."""
        choice("Feedforward.at", self.at, "reference", "motor")
        for name, value in zip(self._fields[:-1], self[:-1], strict=True):
            if not value >= 0.0:
                raise ValueError(f"Feedforward.{name} is {value:g}; it must be zero or more, 1 is exact")


class Task(NamedTuple):
    """Move of a project file: parts of the profile, angle at the begin [rad], payload, window [rad].

    `files` has for every part the name of its file, empty where it is in the project file itself; `feedforward` is what
    the motor is given beside its loop.
    """

    profile: tuple[Any, ...] = ()
    start: float | None = None
    payload: Payload | None = None
    window: float | None = None
    files: tuple[str, ...] = ()
    feedforward: Feedforward | None = None
