"""Loops that keep the motor on its reference: a sampled PD loop, a cascade, and a slow loop on the load's angle."""

from typing import Any, NamedTuple

from ...base.protocols import need
from ...base.quantities import Damping, Inertia, Ratio, Time, TorsionalStiffness
from .measurement import known, moved


class SampledPD(NamedTuple):
    """PD position loop: torque -K_p (motor - reference) - K_d of its rate + J of the reference's acceleration.

    The rate is the difference of two samples over the `period`, behind a first-order filter with the time constant
    `filter`. Its memory is the last deviation, the filtered rate, and whether there was a sample.
    """

    K_p: TorsionalStiffness
    K_d: Damping
    period: Time
    filter: Time = 0.0
    J: Inertia = 0.0

    def start(self) -> Any:
        """Memory before the first sample."""
        return 0.0, 0.0, 0.0

    def update(self, state: Any, m: Any) -> Any:
        """Memory after a sample, and the torque [N*m]."""
        last, slow, begun = state
        deviation = m.motor - m.reference
        raw = begun * (deviation - last) / self.period
        rate = slow + (raw - slow) * (self.period / (self.period + self.filter))
        torque = self.J * m.acceleration - self.K_p * deviation - self.K_d * rate
        return (deviation, rate, 1.0 + 0.0 * begun), torque

    def check(self) -> None:
        """Refuse gains that are negative and a period that is not positive (ValueError)."""
        not_negative(self)


class Cascade(NamedTuple):
    """P loop of the angle around a PI loop of the speed, with the reference's speed and acceleration fed forward.

    Speed to follow: K_v (reference - motor) + its speed. Where the motor's torque was limited, the integral gives back
    what was not applied with its own time constant K_p/K_i (back-calculation; Astrom & Hagglund, PID Controllers, 2nd
    ed. 1995, sec. 3.5): not what a controller around it added. Its memory is the last deviation, the filtered rate,
    whether there was a sample, and the integral.
    """

    K_v: Any
    K_p: Damping
    K_i: TorsionalStiffness
    period: Time
    filter: Time = 0.0
    J: Inertia = 0.0

    def start(self) -> Any:
        """Memory before the first sample."""
        return 0.0, 0.0, 0.0, 0.0

    def update(self, state: Any, m: Any) -> Any:
        """Memory after a sample, and the torque [N*m]."""
        last, slow, begun, integral = state
        deviation = m.motor - m.reference
        raw = begun * (deviation - last) / self.period
        rate = slow + (raw - slow) * (self.period / (self.period + self.filter))
        lag = -self.K_v * deviation - rate
        integral = integral + self.period * (self.K_i * lag + self.K_i / self.K_p * m.cut)
        torque = self.J * m.acceleration + self.K_p * lag + integral
        return (deviation, rate, 1.0 + 0.0 * begun, integral), torque

    def check(self) -> None:
        """Refuse gains that are negative and a period that is not positive (ValueError)."""
        not_negative(self)
        if not self.K_p > 0.0:
            raise ValueError(f"Cascade.K_p is {self.K_p:g}; the speed loop needs a positive gain")


class LoadIntegral(NamedTuple):
    """Slow loop on the load's angle: it moves the reference of `loop` by N times the integral of the pointing error.

    With the gain g [1/s] a steady pointing error decays as exp(-g t). A sample without the load's angle leaves the
    integral as it is.
    """

    loop: Any
    N: Ratio
    gain: Any
    period: Time

    def start(self) -> Any:
        """Memory before the first sample."""
        return self.loop.start(), 0.0

    def update(self, state: Any, m: Any) -> Any:
        """Memory after a sample, and the torque [N*m]."""
        inner, shift = state
        shift = shift + self.period * self.gain * known(m.reference / self.N - m.load)
        inner, torque = self.loop.update(inner, moved(m, self.N * shift, 0.0, 0.0))
        return (inner, shift), torque

    def check(self) -> None:
        """Refuse a loop that is none (TypeError), a gain that is not positive and a gain too high (ValueError)."""
        is_controller("LoadIntegral.loop", self.loop)
        if not 0.0 < self.gain * self.period < 1.0:
            raise ValueError(
                f"LoadIntegral.gain is {self.gain:g} 1/s; it must be above 0 and below {1.0 / self.period:g} 1/s, once "
                "a sample"
            )


def is_controller(name: str, thing: Any) -> None:
    """Refuse what has not the methods of a controller (TypeError)."""
    for method in ("start", "update"):
        need(name, thing, method)


def not_negative(controller: Any) -> None:
    """Refuse negative gains and a period that is not positive (ValueError)."""
    name = type(controller).__name__
    for field, value in zip(controller._fields, controller, strict=True):
        if isinstance(value, float) and not value >= 0.0:
            raise ValueError(f"{name}.{field} is {value:g}; give its size, the loop has the minus sign")
    if not controller.period > 0.0:
        raise ValueError(f"{name}.period is {controller.period:g} s; a sample takes a positive time")
