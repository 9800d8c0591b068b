"""Notch filter in the torque of a loop."""

from math import cos, pi, sin
from typing import Any, NamedTuple

from ...base.quantities import number
from .loops import is_controller


class Notch(NamedTuple):
    """The torque of `loop` behind a filter of second order; `notch` makes it from a frequency and a width.

    y = b0 x + b1 x1 + b2 x2 - a1 y1 - a2 y2, with x the torque of the loop now and one and two samples ago. Its memory
    is that of the loop and x1, x2, y1, y2.
    """

    loop: Any
    b0: float
    b1: float
    b2: float
    a1: float
    a2: float

    def start(self) -> Any:
        """Memory before the first sample."""
        return self.loop.start(), 0.0, 0.0, 0.0, 0.0

    def update(self, state: Any, m: Any) -> Any:
        """Memory after a sample, and the torque [N*m]."""
        inner, x1, x2, y1, y2 = state
        inner, x = self.loop.update(inner, m)
        y = self.b0 * x + self.b1 * x1 + self.b2 * x2 - self.a1 * y1 - self.a2 * y2
        return (inner, x, x1, y, y1), y

    def check(self) -> None:
        """Refuse a loop that is none (TypeError)."""
        is_controller("Notch.loop", self.loop)


def notch(loop: Any, frequency: float, period: float, *, width: float = 0.5, depth: float = 0.0) -> Notch:
    """Return a loop with a notch in its torque: gain `depth` at a frequency, 1 far from it.

    Parameters
    ----------
    loop : controller
        What gives the torque.
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
    if not omega * Ts < pi:
        raise ValueError(
            f"frequency is {omega:g} rad/s; samples every {Ts:g} s carry none above {pi / Ts:g} rad/s: sample faster, "
            "or lower it"
        )
    c, s = cos(omega * Ts), 0.5 * width * sin(omega * Ts)
    a0 = 1.0 + s
    found = Notch(
        loop, (1.0 + depth * s) / a0, -2.0 * c / a0, (1.0 - depth * s) / a0, -2.0 * c / a0, (1.0 - s) / a0
    )  # fmt: skip
    found.check()
    return found
