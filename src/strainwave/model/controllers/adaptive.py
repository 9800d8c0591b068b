"""Adaptive feedforward cancellation at an order of the motor's angle.

Repetitive control over the angle: what the error did at this angle a turn ago is taken away now.
"""

from math import pi
from typing import Any, NamedTuple

from ...base.protocols import need
from ...base.quantities import Angle, Order, Ratio, Reals, States, Time, Torque
from ...compile.elementwise import entry, select, with_entry
from ...compile.jit import kernel
from ...compile.maths import cos, sin, sqrt
from ..laws.friction import positive
from .loops import Measurement, number_or_zero


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
    order: Order = 2
    on_load: int = 1

    def start(self) -> Any:
        """Memory before the first sample."""
        return self.loop.start(), 0.0, 0.0, 0.0

    def update(self, state: Any, m: Measurement) -> Any:
        """Memory after a sample, and the torque [N*m]."""
        inner, a, b, tripped = state
        angle = self.order * m.reference
        inner, torque = self.loop.update(inner, m)
        added = (1.0 - tripped) * (a * cos(angle) + b * sin(angle))
        seen = self.on_load * number_or_zero(m.reference / self.N - m.load) + (1 - self.on_load) * (
            (m.reference - m.motor) / self.N
        )
        step, late = self.period * self.gain * seen, angle + select(m.speed < 0.0, -self.phase, self.phase)
        a, b = a - step * cos(late), b - step * sin(late)
        tripped = select(sqrt(a * a + b * b) > self.most, 1.0, tripped)
        return (inner, (1.0 - tripped) * a, (1.0 - tripped) * b, tripped), torque + added

    def check(self) -> None:
        """Refuse a loop that is none (TypeError), and a gain or a limit that is not positive (ValueError)."""
        need("AdaptiveCancellation.loop", self.loop, "start", "update(state, measurement)")
        positive(self, "N", "gain", "most", "period")
        if not self.order > 0:
            raise ValueError(f"AdaptiveCancellation.order is {self.order}; it must be above 0")


CELLS = 64  # of a turn of the motor
ROUND = 6755399441055744.0  # 1.5 * 2^52: adding and subtracting it rounds to a whole number


@kernel
def cell_of(angle: Reals) -> Any:
    """Position of an angle [rad] on the turn, from 0 to below the number of cells."""
    turns = angle * (0.5 / pi)
    share = turns - ((turns + ROUND) - ROUND)
    share = select(share < 0.0, share + 1.0, share)
    return CELLS * select((share >= 0.0) & (share < 1.0), share, 0.0)  # 0 of an angle that is none, or beyond counting


@kernel
def straight(cells: States, position: Reals) -> Any:
    """Value of a table over the turn at a position, straight between the middles of its cells."""
    shifted = position + (CELLS - 0.5)
    low = floor_of(shifted)
    share, left = shifted - low, around(low)
    return (1.0 - share) * entry(cells, left) + share * entry(cells, around(left + 1.0))


@kernel
def floor_of(x: Reals) -> Any:
    """Largest whole number that is not above x."""
    nearest = (x + ROUND) - ROUND
    return nearest - select(nearest > x, 1.0, 0.0)


@kernel
def around(cell: Reals) -> Any:
    """A cell of this turn or the next one, as one of this turn."""
    return select(cell >= CELLS, cell - CELLS, cell)


class Repetitive(NamedTuple):
    """A torque over the turn of the motor is added to that of `loop`, and learned from turn to turn.

    The turn has 64 cells. In every sample the cell of the reference's angle grows by g y over the period, y the
    pointing error of the load theta_ref/N - theta_l, and moves by the share `smooth` towards the mean of its
    neighbours, which takes away what is too fine. The torque is that of the angle `lead` [rad] ahead of the motion.

    G is the plant from the torque to y at the frequency k theta'. At an order k of M cells the table converges, for a
    small gain, where g Re(-G e^(i k lead)) + smooth (1 - cos(2 pi k/M))/period is positive (Hara, Yamamoto, Omata &
    Nakano, Repetitive control system: a new type servo system for periodic exogenous signals, IEEE Trans. Autom.
    Control 33(7), 1988, 659-668; here over the angle instead of the time).

    Its guard: where a cell passes `most`, the torque is dropped for good and `tripped` is 1. Its memory is that of the
    loop, the cells and `tripped`.
    """

    loop: Any
    N: Ratio
    gain: Any
    lead: Angle
    smooth: Ratio
    most: Torque
    period: Time

    def start(self) -> Any:
        """Memory before the first sample."""
        return self.loop.start(), (0.0,) * 64, 0.0

    def update(self, state: Any, m: Measurement) -> Any:
        """Memory after a sample, and the torque [N*m]."""
        inner, cells, tripped = state
        inner, torque = self.loop.update(inner, m)
        added = (1.0 - tripped) * straight(cells, cell_of(m.reference + select(m.speed < 0.0, -self.lead, self.lead)))
        i = floor_of(cell_of(m.reference))
        seen = number_or_zero(m.reference / self.N - m.load)
        middle = 0.5 * (entry(cells, around(i + 1.0)) + entry(cells, around(i + (CELLS - 1.0))))
        cell = entry(cells, i)
        value = cell + self.smooth * (middle - cell) + self.period * self.gain * seen
        tripped = select(abs(value) > self.most, 1.0, tripped)
        return (inner, with_entry(cells, i, value), tripped), torque + added

    def check(self) -> None:
        """Refuse a loop that is none (TypeError), and numbers out of range (ValueError)."""
        need("Repetitive.loop", self.loop, "start", "update(state, measurement)")
        positive(self, "N", "gain", "most", "period")
        if not 0.0 <= self.smooth <= 1.0:
            raise ValueError(f"Repetitive.smooth is {self.smooth:g}; it is a share, from 0 to 1")
