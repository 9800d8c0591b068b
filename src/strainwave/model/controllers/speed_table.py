"""A torque table over angle and speed: what cancels an error whose amplitude and phase change with the speed."""

from itertools import pairwise
from typing import Any, NamedTuple

from ...base.quantities import AngularSpeed, Time, Torque
from ...maths import cos, sin
from ..train.motion import MOST, polygon
from .loops import is_controller


class SpeedTable(NamedTuple):
    """The torque a(w) cos(k theta) + b(w) sin(k theta) is added to that of `loop`, w the speed of the reference.

    a and b are straight between up to 16 speeds, and constant outside. Several orders are tables around each other.
    """

    loop: Any
    speeds: tuple[AngularSpeed, ...]
    cosines: tuple[Torque, ...]
    sines: tuple[Torque, ...]
    order: int = 2
    lead: Time = 0.0

    def start(self) -> Any:
        """Memory before the first sample."""
        return self.loop.start()

    def update(self, state: Any, m: Any) -> Any:
        """Memory after a sample, and the torque [N*m]."""
        state, torque = self.loop.update(state, m)
        turn = self.order * (m.reference + self.lead * m.speed)
        a, b = polygon(self.speeds, self.cosines, m.speed), polygon(self.speeds, self.sines, m.speed)
        return state, torque + a * cos(turn) + b * sin(turn)

    def check(self) -> None:
        """Refuse a loop that is none (TypeError), and speeds that do not increase or fit the torques (ValueError)."""
        is_controller("SpeedTable.loop", self.loop)
        n = len(self.speeds)
        if not 2 <= n <= MOST or not n == len(self.cosines) == len(self.sines):
            raise ValueError(
                f"SpeedTable has {n} speeds, {len(self.cosines)} cosines and {len(self.sines)} sines; it needs from 2 "
                f"to {MOST} of each, equally many"
            )
        if not all(a < b for a, b in pairwise(self.speeds)):
            raise ValueError("SpeedTable.speeds do not increase; sort them")
