"""Filters of the torque that a loop of the motor commands: low-pass, notch, moving average, any of second order.

The integral of a cascade's position loop, and the encoder on which it is closed.
"""

from math import factorial, pi
from typing import Any, Literal, NamedTuple

import numpy as np

from ...base.law import has, torque_of, z_rate_of
from ...base.quantities import AngularSpeed, Ratio, Reals, States, Time, checked, shown
from .controls import CascadeLoop, Lagged, Tuning, controlled, core_of, from_bandwidth, need_loop, states_inside


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


class MovingAverageFilter(NamedTuple):
    """Mean over the last `time` T [s]: (1 - exp(-s T))/(s T), to the order of two biquads.

    These have its zeros at 1/T and 2/T [Hz] and its series up to (s T)^4, so that its delay T/2 is exact. They are
    within 0.002 of it up to 0.3/T, within 0.055 up to 1/T and within 0.16 beyond, where its own gain is at most 0.22.
    """

    time: Time

    def sections(self) -> tuple[BiquadFilter, ...]:
        """Both biquads."""
        z = 2.0 * pi / self.time * np.array([1.0, 2.0])
        top = np.polymul(*([(self.time * one) ** -2, 0.0, 1.0] for one in z))[::-1]
        bottom: list[float] = []
        for i in range(5):  # numerator = denominator times the series of (1 - exp(-x))/x
            bottom.append(top[i] - sum(bottom[j] * (-1) ** (i - j) / factorial(i - j + 1) for j in range(i)))
        poles = [complex(pole) / self.time for pole in np.roots(bottom[::-1]) if pole.imag > 0.0]
        pairs = zip(sorted(poles, key=abs, reverse=True), z.tolist(), strict=True)
        return tuple(BiquadFilter(abs(p), -p.real / abs(p), zero, 0.0) for p, zero in pairs)

    def check(self) -> None:
        """Refuse a time that is not positive (ValueError)."""
        _all_positive(self)


class PositionIntegral(NamedTuple):
    """A `CascadeLoop` whose position loop is PI: K_v (x + int x/T_p) in the place of K_v x.

    The first state [rad s] is the integral of the deviation x; those of the loop follow. Under a torque that grows
    evenly x goes to 0, too.
    """

    loop: Any
    T_p: Time

    def states(self) -> int:
        """Number of internal states."""
        return 1 + states_inside(self)

    def torque(self, x: Reals, v: Reals, z: States) -> Any:
        """Torque [N*m] against the deviation x [rad], its rate v [rad/s] and the states z."""
        return torque_of(self.loop, x + z[0] / self.T_p, v, z[1:])

    def z_rate(self, x: Reals, v: Reals, z: States) -> Any:
        """Rates of the states."""
        return (1.0 * x, *z_rate_of(self.loop, x + z[0] / self.T_p, v, z[1:]))

    def check(self) -> None:
        """Refuse a loop without a position loop of its own, and a time that is not positive (ValueError)."""
        if not isinstance(self.loop, CascadeLoop):
            fact = f"PositionIntegral.loop is {shown(self.loop)}"
            raise ValueError(f"{fact}; it must be a CascadeLoop, in whose position loop T_p stands")
        self.loop.check()
        if not self.T_p > 0.0:
            fact = f"PositionIntegral.T_p is {self.T_p:g} s"
            raise ValueError(f"{fact}; it must be positive, without a T_p give the loop itself")


class Filtered(NamedTuple):
    """A loop whose torque goes through a filter: `LowPassFilter`, `NotchFilter` or `BiquadFilter`.

    The states [N*m] are the torque behind the low-pass w^2/(s^2 + a s + w^2), its rate over w, and those of the loop.
    """

    loop: Any
    filter: Any

    def states(self) -> int:
        """Number of internal states."""
        return 2 + states_inside(self)

    def torque(self, x: Reals, v: Reals, z: States) -> Any:
        """Torque [N*m] against the deviation x [rad], its rate v [rad/s] and the states z [N*m]."""
        w, a, b, h = self.filter.shape()
        return h * torque_of(self.loop, x, v, z[2:]) + (1.0 - h) * z[0] + (b - h * a) / w * z[1]

    def z_rate(self, x: Reals, v: Reals, z: States) -> Any:
        """Rates of the states."""
        w, a, _, _ = self.filter.shape()
        put_in = torque_of(self.loop, x, v, z[2:])
        return (w * z[1], w * (put_in - z[0]) - a * z[1], *z_rate_of(self.loop, x, v, z[2:]))

    def check(self) -> None:
        """Refuse what is no loop or no stable filter (TypeError, ValueError)."""
        need_loop(self)
        if isinstance(self.loop, Lagged):
            raise TypeError("Filtered.loop is Lagged; give the lag around the filters, as Lagged(Filtered(...), lag)")
        if not isinstance(self.filter, FILTERS[:-1]):
            fact = f"Filtered.filter is {shown(self.filter)}"
            both = "; of a MovingAverageFilter give its sections(), one Filtered around the other"
            remedy = both * isinstance(self.filter, MovingAverageFilter)
            raise TypeError(f"{fact}; it must be a LowPassFilter, a NotchFilter or a BiquadFilter{remedy}")
        self.filter.check()
        if has(self.loop, "inertia") and self.loop.inertia():
            raise ValueError("Filtered.loop has a gain K_d on the acceleration, which no filter takes; leave K_d out")


class LoadEncoder(NamedTuple):
    """A cascade whose position loop is closed on an encoder of the load, its speed loop on that of the motor.

    x is then N theta_l less the motor's reference, theta_l behind all couplings: the motor's deviation - N (x and the
    twists of couplings). v is the motor's.
    """

    loop: Any

    def states(self) -> int:
        """Number of internal states."""
        return states_inside(self)

    def torque(self, x: Reals, v: Reals, z: States) -> Any:
        """Torque [N*m] against the load's deviation x [rad, motor side] and the rate v [rad/s] of the motor's."""
        return torque_of(self.loop, x, v, z)

    def z_rate(self, x: Reals, v: Reals, z: States) -> Any:
        """Rates of the states."""
        return z_rate_of(self.loop, x, v, z)

    def at_load(self) -> bool:
        """True if the train gives the load's deviation."""
        return True

    def respond(self, J: Reals, torque: Reals, excitation: Reals, reference: States, deviation: States, z: Any) -> Any:
        """Result of `controlled`."""
        return controlled(self.loop, J, torque, excitation, reference, deviation, z)

    def check(self) -> None:
        """Refuse what is no cascade (TypeError)."""
        _need_cascade(self)


class MixedEncoders(NamedTuple):
    """A cascade whose position loop sees the load below a `frequency` w [rad/s] and the motor above (dual loop).

    The first state [rad] is the sum of the load's deviation behind the low-pass w/(s + w) and of the motor's behind the
    high-pass s/(s + w): z' = v + w (x - z), x as of a `LoadEncoder`. Those of the loop follow.
    """

    loop: Any
    frequency: AngularSpeed

    def states(self) -> int:
        """Number of internal states."""
        return 1 + states_inside(self)

    def torque(self, x: Reals, v: Reals, z: States) -> Any:  # noqa: ARG002
        """Torque [N*m] against the load's deviation x [rad, motor side] and the rate v [rad/s] of the motor's."""
        return torque_of(self.loop, z[0], v, z[1:])

    def z_rate(self, x: Reals, v: Reals, z: States) -> Any:
        """Rates of the states."""
        return (v + self.frequency * (x - z[0]), *z_rate_of(self.loop, z[0], v, z[1:]))

    def at_load(self) -> bool:
        """True if the train gives the load's deviation."""
        return True

    def respond(self, J: Reals, torque: Reals, excitation: Reals, reference: States, deviation: States, z: Any) -> Any:
        """Result of `controlled`."""
        (x, v), seen = deviation, z[0]
        fast, given, rates = controlled(self.loop, J, torque, excitation, reference, (seen, v), z[1:])
        return fast, given, (rates[0], rates[1], v + self.frequency * (x - seen), *rates[2:])

    def check(self) -> None:
        """Refuse what is no cascade (TypeError), and a frequency that is not positive (ValueError)."""
        _need_cascade(self)
        if not self.frequency > 0.0:
            fact = f"MixedEncoders.frequency is {self.frequency:g} rad/s"
            raise ValueError(f"{fact}; it must be positive, for the load alone take a LoadEncoder")


def _need_cascade(control: Any) -> None:
    need_loop(control)
    if not isinstance(core_of(control), CascadeLoop):
        fact = f"{type(control).__name__}.loop is {shown(control.loop)}"
        raise TypeError(f"{fact}; an encoder of the load needs a CascadeLoop, which has a position and a speed loop")
    if hasattr(control.loop, "at_load"):
        raise TypeError(f"{type(control).__name__}.loop has an encoder of the load already; give one")


FILTERS = (LowPassFilter, NotchFilter, BiquadFilter, MovingAverageFilter)


def around(
    loop: Any, lag: float = 0.0, filters: tuple[Any, ...] = (), T_p: float = 0.0,
    encoder: Literal["motor", "load", "both"] = "motor", mixing_frequency: float = 0.0,
) -> Any:  # fmt: skip
    """A loop whose torque goes through filters, one after the other, and then through the lag [s] of a current loop.

    With an integral time T_p [s] its position loop, that of a cascade, is PI; it is closed on an `encoder`, or on
    both, mixed at a frequency [rad/s].
    """
    loop = PositionIntegral(loop, T_p) if T_p else loop
    for item in filters:
        for section in item.sections() if isinstance(item, MovingAverageFilter) else (item,):
            loop = Filtered(loop, section)
    loop = Lagged(loop, lag) if lag else loop
    if encoder == "motor":
        return checked(loop)
    return checked(LoadEncoder(loop) if encoder == "load" else MixedEncoders(loop, mixing_frequency))


def apart(control: Any) -> tuple[Any, dict[str, Any]]:
    """The loop within a control, and the arguments with which `around` makes the control of it."""
    fields, filters, core = dict[str, Any](), list[Any](), control
    while isinstance(core, Lagged | Filtered | PositionIntegral | LoadEncoder | MixedEncoders):
        if isinstance(core, Filtered):
            filters = [core.filter, *filters]
        elif isinstance(core, LoadEncoder):
            fields["encoder"] = "load"
        elif isinstance(core, MixedEncoders):
            fields |= {"encoder": "both", "mixing_frequency": core.frequency}
        else:
            fields |= {key: item for key, item in core._asdict().items() if key != "loop"}
        core = core.loop
    return core, fields | ({"filters": tuple(filters)} if filters else {})


def control_of(loop: Any, inertia: float) -> Any:
    """Control of a loop as it was read, on the inertia [kg*m^2, motor side] that it turns."""
    if not isinstance(loop, Tuning):
        return loop
    control = from_bandwidth(loop.bandwidth, inertia, loop.damping, kind=loop.kind, lag=loop.lag)
    return around(
        control.loop if loop.lag else control, loop.lag, loop.filters, loop.T_p, loop.encoder, loop.mixing_frequency
    )
