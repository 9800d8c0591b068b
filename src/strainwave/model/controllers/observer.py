"""Disturbance observer: what turns the motor beside its own torque is estimated and taken away."""

from typing import Any, NamedTuple

from ...base.quantities import AngularSpeed, Inertia, Time
from .loops import is_controller


class DisturbanceObserver(NamedTuple):
    """The torque d beside the motor's own, in J theta_m'' = tau + d, is estimated and subtracted from that of `loop`.

    d' = g (J theta_m'' - tau - d): the estimate follows with the bandwidth g [rad/s], without differentiating a speed
    (Ohnishi, Shibata & Murakami, Motion control for advanced mechatronics, IEEE/ASME Trans. Mechatronics 1(1), 1996,
    56-67). tau is the torque after its limit. It makes the motor stiff: the load then has the error of a held motor.
    Its memory is that of the loop, the last deviation, whether there was a sample, and the observer's state.
    """

    loop: Any
    J: Inertia
    bandwidth: AngularSpeed
    period: Time

    def start(self) -> Any:
        """Memory before the first sample."""
        return self.loop.start(), 0.0, 0.0, 0.0

    def update(self, state: Any, m: Any) -> Any:
        """Memory after a sample, and the torque [N*m]."""
        inner, last, begun, z = state
        deviation = m.motor - m.reference
        inner, torque = self.loop.update(inner, m)
        momentum = self.J * begun * (deviation - last) / self.period
        d = self.bandwidth * (momentum - z)
        z = z + self.period * (m.applied - self.J * m.acceleration + d)
        return (inner, deviation, 1.0 + 0.0 * begun, z), torque - begun * d

    def check(self) -> None:
        """Refuse a loop that is none (TypeError), and a bandwidth above what the samples allow (ValueError)."""
        is_controller("DisturbanceObserver.loop", self.loop)
        if not 0.0 < self.bandwidth * self.period < 1.0:
            raise ValueError(
                f"DisturbanceObserver.bandwidth is {self.bandwidth:g} rad/s; it must be above 0 and below "
                f"{1.0 / self.period:g} rad/s, once a sample"
            )
