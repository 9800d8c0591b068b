"""Sampled loops that keep the motor on its reference, a PD loop and a cascade, and what stands around their torque.

Around it stand a disturbance observer, which takes away what turns the motor beside its own torque, and filters.
"""

from math import pi, tan
from typing import Any, NamedTuple

from ...base import quantities
from ...base.protocols import need
from ...base.quantities import checked, number
from ...compile.elementwise import select
from ...compile.jit import kernel
from ..laws.friction import positive


class Measurement(NamedTuple):
    """One sample: the motor's reference motion, the measured angles, and the torque after the last one's limit.

    `load` is the angle of the load on its own shaft; it is NaN where no encoder measures it. `cut` is what the limit
    did to the last torque: `applied` less the whole torque that was asked for, by all controllers around each other.
    """

    reference: quantities.Angle
    speed: quantities.AngularSpeed
    acceleration: quantities.AngularAcceleration
    motor: quantities.Angle
    load: quantities.Angle
    applied: quantities.Torque
    cut: quantities.Torque


@kernel
def moved(m: Any, angle: Any, speed: Any, acceleration: Any) -> Any:
    """The same sample with another motion to follow: the reference and what is added to it."""
    return Measurement(
        m.reference + angle, m.speed + speed, m.acceleration + acceleration, m.motor, m.load, m.applied,
        m.cut,
    )  # fmt: skip


@kernel
def number_or_zero(value: Any) -> Any:
    """Return a number, or 0 where it is NaN."""
    return select(value == value, value, 0.0)


class SampledPD(NamedTuple):
    """PD position loop: torque -K_p (motor - reference) - K_d of its rate + J of the reference's acceleration.

    The rate is the difference of two samples over the `period`, behind a first-order filter with the time constant
    `filter`. Its memory is the last deviation, the filtered rate, and whether there was a sample.
    """

    K_p: quantities.TorsionalStiffness
    K_d: quantities.Damping
    period: quantities.Time
    filter: quantities.Time = 0.0
    J: quantities.Inertia = 0.0

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
    """P or PI loop of the angle around a PI loop of the speed, with the reference's speed and acceleration fed forward.

    Speed to follow: K_v (e + K_x int e) + that of the reference, e = reference - motor; with K_x = 0 the loop of the
    angle is P. The integral of e waits while the torque is limited; that of the torque then gives back what was not
    applied with its own time constant K_p/K_i (back-calculation; Astrom & Hagglund, PID Controllers, 2nd ed. 1995, sec.
    3.5): not what a controller around it added. At the first sample it is the torque in force.

    Its memory is the last deviation, the filtered rate, whether there was a sample, and the integrals, the last of -e.
    """

    K_v: Any
    K_p: quantities.Damping
    K_i: quantities.TorsionalStiffness
    period: quantities.Time
    filter: quantities.Time = 0.0
    J: quantities.Inertia = 0.0
    K_x: quantities.Rate = 0.0

    def start(self) -> Any:
        """Memory before the first sample."""
        return 0.0, 0.0, 0.0, 0.0, 0.0

    def update(self, state: Any, m: Any) -> Any:
        """Memory after a sample, and the torque [N*m]."""
        last, slow, begun, integral, turned = state
        deviation = m.motor - m.reference
        raw = begun * (deviation - last) / self.period
        rate = slow + (raw - slow) * (self.period / (self.period + self.filter))
        integral = select(begun > 0.0, integral, m.applied)
        more = self.period * select(m.cut == 0.0, deviation, 0.0)
        turned = select(self.K_x > 0.0, turned + more, 0.0)  # without a K_x no state that stays where it is
        lag = -self.K_v * (deviation + self.K_x * turned) - rate
        integral = integral + self.period * (self.K_i * lag + self.K_i / self.K_p * m.cut)
        torque = self.J * m.acceleration + self.K_p * lag + integral
        return (deviation, rate, 1.0 + 0.0 * begun, integral, turned), torque

    def check(self) -> None:
        """Refuse gains that are negative and a period that is not positive (ValueError)."""
        not_negative(self)
        if not self.K_p > 0.0:
            raise ValueError(f"Cascade.K_p is {self.K_p:g}; the speed loop needs a positive gain")


def not_negative(controller: Any) -> None:
    """Refuse negative gains and a period that is not positive (ValueError)."""
    name = type(controller).__name__
    for field, value in zip(controller._fields, controller, strict=True):
        if not isinstance(value, tuple) and not number(f"{name}.{field}", value) >= 0.0:
            raise ValueError(f"{name}.{field} is {value:g}; give a positive value, the loop contains the minus sign")
    if not controller.period > 0.0:
        raise ValueError(f"{name}.period is {controller.period:g} s; the period must be positive")


class DisturbanceObserver(NamedTuple):
    """The torque d beside the motor's own, in J theta_m'' = tau + d, is estimated and subtracted from that of `loop`.

    d' = g (J theta_m'' - tau - d): the estimate follows with the bandwidth g [rad/s], without differentiating a speed
    (Ohnishi, Shibata & Murakami, Motion control for advanced mechatronics, IEEE/ASME Trans. Mechatronics 1(1), 1996,
    56-67). tau is the torque after its limit. It makes the motor stiff: the load then has the error of a held motor.
    Its memory is that of the loop, the last deviation, whether there was a sample, and the observer's state.
    """

    loop: Any
    J: quantities.Inertia
    bandwidth: quantities.AngularSpeed
    period: quantities.Time

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
        need("DisturbanceObserver.loop", self.loop, "start", "update(state, measurement)")
        positive(self, "period")
        if not 0.0 < self.bandwidth * self.period < 1.0:
            raise ValueError(
                f"DisturbanceObserver.bandwidth is {self.bandwidth:g} rad/s; it must be above 0 and below "
                f"{1.0 / self.period:g} rad/s (one per sampling period)"
            )


class Notch(NamedTuple):
    """The torque of `loop` behind a filter of second order; `notch` makes it from a frequency and a width.

    y = b0 x + b1 x1 + b2 x2 - a1 y1 - a2 y2, with x the torque of the loop now and one and two samples ago. It begins
    as if the first x had been before: a filter with gain 1 at rest leaves a torque that holds a load. Its memory is
    that of the loop, x1, x2, y1, y2, and whether there was a sample.
    """

    loop: Any
    b0: float
    b1: float
    b2: float
    a1: float
    a2: float

    def start(self) -> Any:
        """Memory before the first sample."""
        return self.loop.start(), 0.0, 0.0, 0.0, 0.0, 0.0

    def update(self, state: Any, m: Any) -> Any:
        """Memory after a sample, and the torque [N*m]."""
        inner, x1, x2, y1, y2, begun = state
        inner, x = self.loop.update(inner, m)
        x1, x2 = select(begun > 0.0, x1, x), select(begun > 0.0, x2, x)
        y1, y2 = select(begun > 0.0, y1, x), select(begun > 0.0, y2, x)
        y = self.b0 * x + self.b1 * x1 + self.b2 * x2 - self.a1 * y1 - self.a2 * y2
        return (inner, x, x1, y, y1, 1.0 + 0.0 * begun), y

    def check(self) -> None:
        """Refuse a loop that is none (TypeError)."""
        need("Notch.loop", self.loop, "start", "update(state, measurement)")


def sampled_filter(loop: Any, shape: tuple[float, float, float, float], period: float) -> Notch:
    """The torque of a loop behind a filter of second order, sampled every `period` [s].

    The filter is (h s^2 + b s + w^2)/(s^2 + a s + w^2), its `shape` (w, a, b, h) with w [rad/s]. By the bilinear
    transform s is c (z - 1)/(z + 1), with the c that keeps gain and phase at w; see `notch`.
    """
    w, a, b, h = shape
    if not w * period < pi:
        raise ValueError(
            f"the frequency of a filter is {w:g} rad/s; samples every {period:g} s carry none above "
            f"{pi / period:g} rad/s: sample faster, or lower it"
        )
    c = w / tan(0.5 * w * period)
    above = h * c * c + b * c + w * w, 2.0 * (w * w - h * c * c), h * c * c - b * c + w * w
    first, *below = c * c + a * c + w * w, 2.0 * (w * w - c * c), c * c - a * c + w * w
    return Notch(loop, *(coefficient / first for coefficient in (*above, *below)))


def notch(loop: Any, frequency: float, period: float, *, width: float = 0.5, depth: float = 0.0) -> Notch:
    """Return a loop with a notch in its torque: gain `depth` at a frequency, 1 far from it.

    Parameters
    ----------
    loop : controller
        Controller that gives the torque.
    frequency : float
        Centre [rad/s].
    period : float
        Sample period [s].
    width : float
        Distance between the frequencies of gain 1/sqrt(2), over the centre.
    depth : float
        Gain at the centre, from 0 to 1.

    Returns
    -------
    Notch
        A controller with the torque [N*m] of `loop` behind the filter; it stands wherever `loop` does.

    Raises
    ------
    ValueError
        If the frequency is not between 0 and half the rate of samples, or another number is out of range.

    References
    ----------
    The bilinear transform with its frequency kept at the centre: Franklin, Powell & Workman, Digital Control of Dynamic
    Systems, 3rd ed. 1998, sec. 6.1.3.
    """
    omega = number("frequency [rad/s]", frequency, positive=True)
    Ts, width = number("period [s]", period, positive=True), number("width", width, positive=True)
    depth = number("depth", depth)
    if not 0.0 <= depth <= 1.0:
        raise ValueError(f"depth is {depth:g}; it must be from 0 to 1")
    result: Notch = checked(sampled_filter(loop, (omega, width * omega, depth * width * omega, 1.0), Ts))
    return result
