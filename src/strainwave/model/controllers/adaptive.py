"""Adaptive feedforward cancellation at an order of the motor's angle."""

from typing import Any, NamedTuple

from ...base.choices import select
from ...base.quantities import Angle, Ratio, Time, Torque
from ...maths import cos, sin, sqrt
from .loops import is_controller
from .measurement import known


class AdaptiveCancellation(NamedTuple):
    """A torque a cos(k theta) + b sin(k theta) is added to that of `loop`, with a and b found by themselves.

    They follow the measured error y: a' = -g y cos(k theta + phi), b' = -g y sin(k theta + phi), with the gain g
    [N*m/(rad s)] and the phase phi of the plant from this torque to y at the frequency k theta'. y is the pointing
    error of the load, theta_ref/N - theta_l, where `on_load` is 1, or the motor's deviation over N where it is 0. In
    backward motion the plant's phase counts the other way along the angle, -phi. The amplitude converges with the rate
    g |G| cos(phi_G - phi)/2: it diverges where the phase is more than 90 deg off (Sacks, Bodson & Khosla, Experimental
    results of adaptive periodic disturbance cancellation in a high performance magnetic disk drive, J. Dyn. Sys. Meas.
    Control 118(3), 1996, 416-424).

    Its guard: where the amplitude passes `most`, the torque is dropped for good, and `tripped` of its memory is 1. Its
    memory is that of the loop, a, b and `tripped`.
    """

    loop: Any
    N: Ratio
    gain: Any
    phase: Angle
    most: Torque
    period: Time
    order: int = 2
    on_load: int = 1

    def start(self) -> Any:
        """Memory before the first sample."""
        return self.loop.start(), 0.0, 0.0, 0.0

    def update(self, state: Any, m: Any) -> Any:
        """Memory after a sample, and the torque [N*m]."""
        inner, a, b, tripped = state
        angle = self.order * m.reference
        inner, torque = self.loop.update(inner, m)
        added = (1.0 - tripped) * (a * cos(angle) + b * sin(angle))
        seen = self.on_load * known(m.reference / self.N - m.load) + (1 - self.on_load) * (
            (m.reference - m.motor) / self.N
        )
        step, late = self.period * self.gain * seen, angle + select(m.speed < 0.0, -self.phase, self.phase)
        a, b = a - step * cos(late), b - step * sin(late)
        tripped = select(sqrt(a * a + b * b) > self.most, 1.0, tripped)
        return (inner, (1.0 - tripped) * a, (1.0 - tripped) * b, tripped), torque + added

    def check(self) -> None:
        """Refuse a loop that is none (TypeError), and a gain or a limit that is not positive (ValueError)."""
        is_controller("AdaptiveCancellation.loop", self.loop)
        for name in ("gain", "most", "period"):
            value = getattr(self, name)
            if not value > 0.0:
                raise ValueError(f"AdaptiveCancellation.{name} is {value:g}; it must be positive")
        if self.order < 1:
            raise ValueError(f"AdaptiveCancellation.order is {self.order}; it must be at least 1")
