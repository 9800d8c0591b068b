"""Filters of the torque that a loop of the motor commands: low-pass, notch and any other of second order."""

from typing import Any, NamedTuple

from ...base.law import has, torque_of, z_rate_of
from ...base.quantities import AngularSpeed, Ratio, checked, shown
from .controls import Lagged, Tuning, from_bandwidth, need_loop, states_inside


class LowPassFilter(NamedTuple):
    """Low-pass filter of second order: 1/(s^2/w^2 + 2 damping s/w + 1), w = `frequency` [rad/s]."""

    frequency: AngularSpeed
    damping: Ratio = 0.7

    def shape(self) -> Any:
        """Coefficients (w, a, b, h) of (h s^2 + b s + w^2)/(s^2 + a s + w^2)."""
        return self.frequency, 2.0 * self.damping * self.frequency, 0.0 * self.frequency, 0.0 * self.frequency

    def check(self) -> None:
        """Refuse numbers that are not positive (ValueError)."""
        _all_positive(self)


class NotchFilter(NamedTuple):
    """Notch filter: (s^2 + depth width s + w^2)/(s^2 + width s + w^2), w = `frequency` [rad/s].

    `width` [rad/s] is that of the band; `depth` is the gain at the frequency.
    """

    frequency: AngularSpeed
    width: AngularSpeed
    depth: Ratio = 0.1

    def shape(self) -> Any:
        """Coefficients (w, a, b, h) of (h s^2 + b s + w^2)/(s^2 + a s + w^2)."""
        return self.frequency, self.width, self.depth * self.width, 1.0 + 0.0 * self.frequency

    def check(self) -> None:
        """Refuse numbers that are not positive (ValueError)."""
        _all_positive(self)


class BiquadFilter(NamedTuple):
    """Filter of second order: (s^2/z^2 + 2 zero_damping s/z + 1)/(s^2/w^2 + 2 damping s/w + 1).

    w = `frequency` and z = `zero_frequency` [rad/s]: with z above w it lowers what is fast, and with z below it raises.
    """

    frequency: AngularSpeed
    damping: Ratio
    zero_frequency: AngularSpeed
    zero_damping: Ratio

    def shape(self) -> Any:
        """Coefficients (w, a, b, h) of (h s^2 + b s + w^2)/(s^2 + a s + w^2)."""
        w, share = self.frequency, self.frequency / self.zero_frequency
        return w, 2.0 * self.damping * w, 2.0 * self.zero_damping * share * w, share * share

    def check(self) -> None:
        """Refuse numbers that are not positive (ValueError)."""
        _all_positive(self)


def _all_positive(filter_: Any) -> None:
    for name, value in zip(filter_._fields, filter_, strict=True):
        if not value >= 0.0 or (value == 0.0 and name not in ("depth", "zero_damping")):
            raise ValueError(f"{type(filter_).__name__}.{name} is {value:g}; it must be positive")


FILTERS = (LowPassFilter, NotchFilter, BiquadFilter)


class Filtered(NamedTuple):
    """A loop whose torque goes through a filter: `LowPassFilter`, `NotchFilter` or `BiquadFilter`.

    The states [N*m] are the torque behind the low-pass w^2/(s^2 + a s + w^2), its rate over w, and those of the loop.
    """

    loop: Any
    filter: Any

    def states(self) -> int:
        """Number of internal states."""
        return 2 + states_inside(self)

    def torque(self, x: Any, v: Any, z: Any) -> Any:
        """Torque [N*m] against the deviation x [rad], its rate v [rad/s] and the states z [N*m]."""
        w, a, b, h = self.filter.shape()
        return h * torque_of(self.loop, x, v, z[2:]) + (1.0 - h) * z[0] + (b - h * a) / w * z[1]

    def z_rate(self, x: Any, v: Any, z: Any) -> Any:
        """Rates of the states."""
        w, a, _, _ = self.filter.shape()
        put_in = torque_of(self.loop, x, v, z[2:])
        return (w * z[1], w * (put_in - z[0]) - a * z[1], *z_rate_of(self.loop, x, v, z[2:]))

    def check(self) -> None:
        """Refuse what is no loop or no stable filter (TypeError, ValueError)."""
        need_loop(self)
        if isinstance(self.loop, Lagged):
            raise TypeError("Filtered.loop is Lagged; give the lag around the filters, as Lagged(Filtered(...), lag)")
        if not isinstance(self.filter, FILTERS):
            what = f"Filtered.filter is {shown(self.filter)}"
            raise TypeError(f"{what}; it must be a LowPassFilter, a NotchFilter or a BiquadFilter")
        self.filter.check()
        if has(self.loop, "inertia") and self.loop.inertia():
            raise ValueError("Filtered.loop has a gain K_d on the acceleration, which no filter takes; leave K_d out")


def around(loop: Any, lag: float = 0.0, filters: tuple[Any, ...] = ()) -> Any:
    """A loop whose torque goes through filters, one after the other, and then through the lag [s] of a current loop."""
    for item in filters:
        loop = Filtered(loop, item)
    return checked(Lagged(loop, lag) if lag else loop)


def control_of(loop: Any, inertia: float) -> Any:
    """Control of a loop as it was read, on the inertia [kg*m^2, motor side] that it turns."""
    if not isinstance(loop, Tuning):
        return loop
    found = from_bandwidth(loop.bandwidth, inertia, loop.damping, kind=loop.kind, lag=loop.lag)
    return around(found.loop if loop.lag else found, loop.lag, loop.filters)
