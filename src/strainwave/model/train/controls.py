"""Controls that keep the motor on its reference motion: laws of the motor's deviation from it, which they oppose.

A control has the methods of a law, `torque(x, v)` or, with states of its own, `torque(x, v, z)` with `z_rate(x, v, z)`
and `states`: x [rad] and v [rad/s] are the deviations of the motor's angle and speed from its reference, the torque
[N*m] counts against them. It may have `inertia()` [kg*m^2], which counts against the deviation of the acceleration.
`Held` alone has none of these: it prescribes the motion. Loops are made by bandwidth and damping on an inertia, too.
"""

from math import isclose, sqrt
from typing import Any, Literal, NamedTuple

from ...base import quantities
from ...base.law import class_of, depends, has, share, states_of, torque_of, z_rate_of
from ...base.protocols import Control, lacking
from ...base.quantities import Reals, number
from ...base.units import HERTZ as HERTZ
from ...compile.jit import chosen
from .commanded import TorqueDriven

FASTEST = 0.5  # bandwidth [rad/s] times lag [s]: there the lag takes 27 degrees of phase
KINDS = ("position", "speed", "cascade")
OUTER_GAIN = 0.25  # of the bandwidth of a cascade's speed loop: the gain K_v of the position loop around it


class Free(NamedTuple):
    """No control: the motor is driven by its torque alone."""

    def torque(self, x: Any, v: Any) -> Any:
        """Torque [N*m]: 0."""
        return 0.0


FREE = Free()


class Held(NamedTuple):
    """An ideal speed loop: the motor follows its reference motion whatever torque that takes."""


class PositionLoop(NamedTuple):
    """PD position loop on the motor: torque -K_p (theta_m - reference) - K_d (theta_m' - reference').

    It acts where it measures: with gains that are not negative it puts in no energy and cannot make the train unstable.
    """

    K_p: quantities.TorsionalStiffness
    K_d: quantities.Damping

    def torque(self, x: Reals, v: Reals) -> Any:
        """Torque [N*m] against the deviation x [rad] and its rate v [rad/s]."""
        return self.K_p * x + self.K_d * v

    def check(self) -> None:
        """Refuse gains with which the loop drives away from its reference (ValueError)."""
        _gains_not_negative(self)


class SpeedLoop(NamedTuple):
    """PID speed loop on the motor, with the speed error w = theta_m' - reference': torque -K_p w - K_i int w - K_d w'.

    K_d [kg m^2] acts as inertia. With K_i the integral is the angle theta_m - reference of the state.
    """

    K_p: quantities.Damping
    K_i: quantities.TorsionalStiffness = 0.0
    K_d: quantities.Inertia = 0.0

    def torque(self, x: Reals, v: Reals) -> Any:
        """Torque [N*m] against the deviation x [rad] and its rate v [rad/s]."""
        return self.K_i * x + self.K_p * v

    def inertia(self) -> Any:
        """Torque against the acceleration of the deviation [kg*m^2]."""
        return self.K_d

    def check(self) -> None:
        """Refuse gains with which the loop drives away from its reference (ValueError)."""
        _gains_not_negative(self)


class CascadeLoop(NamedTuple):
    """P position loop around a PI speed loop, as servo drives have it: torque -K_p (w + int w/T_n), w = v + K_v x.

    x and v are the deviations from the reference, whose speed is fed forward. The one state z [rad] is the integral of
    w: it holds any mean torque, so that the motor's angle stays on its reference in the mean.
    """

    K_v: quantities.Rate
    K_p: quantities.Damping
    T_n: quantities.Time

    def states(self) -> int:
        """Number of internal states."""
        return 1

    def torque(self, x: Reals, v: Reals, z: Any) -> Any:
        """Torque [N*m] against the deviation x [rad], its rate v [rad/s] and the integral z = (z,) [rad]."""
        return self.K_p * (v + self.K_v * x + z[0] / self.T_n)

    def z_rate(self, x: Reals, v: Reals, z: Any) -> Any:
        """Rate (z',) [rad/s] of the integral."""
        return (v + self.K_v * x + 0.0 * z[0],)

    def check(self) -> None:
        """Refuse gains and a time that are not positive (ValueError)."""
        for name, value in zip(self._fields, self, strict=True):
            if not value > 0.0:
                remedy = "without a position or an integral part take a SpeedLoop or a PositionLoop"
                raise ValueError(f"CascadeLoop.{name} is {value:g}; it must be positive, {remedy}")


class Lagged(NamedTuple):
    """A loop whose torque follows with the first-order lag of its current loop: lag T' + T = torque of the loop.

    `loop` is a `PositionLoop`, a `SpeedLoop`, a `CascadeLoop`, or one that is `Filtered`. The first state z [N*m] is T
    less the part K_d v/lag that answers an acceleration at once, so that none is differentiated: T = z + K_d v/lag,
    z' = (torque of the loop - T)/lag; those of the loop follow. A lag can make a train unstable that a `PositionLoop`
    or a `SpeedLoop` alone does not.
    """

    loop: Any
    lag: quantities.Time

    def states(self) -> int:
        """Number of internal states."""
        return 1 + states_inside(self)

    def torque(self, x: Reals, v: Reals, z: Any) -> Any:
        """Torque [N*m] against the deviation, of its rate v [rad/s] and the states z, the first [N*m]."""
        return z[0] + inertia_of(self.loop) / self.lag * v

    def z_rate(self, x: Reals, v: Reals, z: Any) -> Any:
        """Rates of the internal states, the first [N*m/s]."""
        wanted = torque_of(self.loop, x, v, z[1:])
        return ((wanted - self.torque(x, v, z)) / self.lag, *z_rate_of(self.loop, x, v, z[1:]))

    def check(self) -> None:
        """Refuse a lag that is not positive (ValueError) and a loop of another kind (TypeError)."""
        if not self.lag > 0.0:
            raise ValueError(f"Lagged.lag is {self.lag:g} s; it must be positive, without a lag give the loop itself")
        need_loop(self)
        if isinstance(self.loop, Lagged):
            raise TypeError("Lagged.loop is Lagged; one loop has one lag: give the sum of both")


@chosen
def commanded(control: Any, y: Any, torque: Any) -> Any:
    """State of a train with another commanded torque: behind the torque of the motor where that follows with a lag."""
    return _behind_lag if class_of(control) is Lagged else _at_once


def _at_once(control: Any, y: Any, torque: Any) -> Any:
    return (y[0], y[1], y[2], y[3], torque, *y[5:])


def _behind_lag(control: Any, y: Any, torque: Any) -> Any:
    return (y[0], y[1], y[2], y[3], y[4], torque, *y[6:])


def states_inside(control: Any) -> int:
    """Number of states of the loop inside a lag or a filter, whose first field it is."""
    return states_of((control.types if hasattr(control, "instance_class") else control)[0])


def need_loop(control: Any) -> None:
    """Refuse what is no loop of the motor inside a lag or a filter (TypeError)."""
    loop = control.loop
    complete = not lacking(loop, "rhs")
    if complete or lacking(loop, "torque") or depends(loop) < 2 or isinstance(loop, Free | TorqueDriven):
        fact = f"{type(control).__name__}.loop is {quantities.shown(loop)}"
        raise TypeError(f"{fact}; it must be a PositionLoop, a SpeedLoop or a CascadeLoop, or one of these Filtered")
    if not lacking(loop, "check"):
        loop.check()


def core_of(control: Any) -> Any:
    """The loop inside the lags and filters of its torque."""
    return core_of(control.loop) if _is_around(control) else control


def with_core(control: Any, core: Any) -> Any:
    """Another loop inside the same lags and filters."""
    return control._replace(loop=with_core(control.loop, core)) if _is_around(control) else core


def _is_around(control: Any) -> bool:
    """True for a lag, a filter, an integral or an encoder, whose fields begin with its loop."""
    return getattr(control, "_fields", ())[:1] == ("loop",)


class Nudged(NamedTuple):
    """A free motor with a loop far too weak to matter, by which the stability of its mean speed is judged."""

    K_p: quantities.Damping
    K_i: quantities.TorsionalStiffness

    def torque(self, x: Reals, v: Reals) -> Any:
        """Torque [N*m] against the deviation x [rad] and its rate v [rad/s]."""
        return self.K_i * x + self.K_p * v


def _gains_not_negative(control: Any) -> None:
    name = type(control).__name__
    for gain, value in zip(control._fields, control, strict=True):
        if not value >= 0.0:
            raise ValueError(
                f"{name}.{gain} is {value:g}; with a negative gain the loop pushes the motor away from its reference: "
                "give its size, the loop has the minus sign"
            )


@chosen
def motor_states(control: Control, y: Any) -> Any:
    """Deviation (angle [rad], speed [rad/s]) of the motor from its reference, and the states of the train after it."""
    return _without_motor if class_of(control) is Held else _with_motor


def _without_motor(control: Control, y: Any) -> Any:
    return (0.0 * y[0], 0.0 * y[0]), y[2:]


def _with_motor(control: Control, y: Any) -> Any:
    return (y[2], y[3]), y[4:]


@chosen
def off_reference(control: Control, y: Any) -> Any:
    """Deviation (angle [rad], speed [rad/s]) of the motor as the load points wrong by it: none without a reference."""
    return _with_none if class_of(control) in (Held, Free, Nudged) else _with_all


def _with_none(control: Control, y: Any) -> Any:
    return 0.0 * y[0], 0.0 * y[1]


def _with_all(control: Control, y: Any) -> Any:
    return motor_states(control, y)[0]


@chosen
def controlled(control: Any, J: Reals, torque: Reals, excitation: Reals, reference: Any, deviation: Any, z: Any) -> Any:
    """Acceleration [rad/s^2] of a motor under its control and other torques, torque [N*m] of the control, own rates.

    `excitation` [N*m] is the torque of the motor beside its control, `torque` what else turns it; `reference` is the
    speed, the acceleration and the angle of its reference; z begins with the states of the control. A control may have
    this as `respond`.
    """
    if class_of(control) is Held:
        return _prescribed
    return _by_itself if has(control, "respond") else _driven


def _prescribed(control: Any, J: Any, torque: Any, excitation: Any, reference: Any, deviation: Any, z: Any) -> Any:
    return reference[1], J * reference[1] - torque - excitation, ()


def _by_itself(control: Any, J: Reals, torque: Reals, excitation: Reals, reference: Any, deviation: Any, z: Any) -> Any:
    return control.respond(J, torque, excitation, reference, deviation, z)


def _driven(control: Any, J: Reals, torque: Reals, excitation: Reals, reference: Any, deviation: Any, z: Any) -> Any:
    x, v = deviation
    states, heavy = share(control, z), inertia_of(control)
    against = torque_of(control, x, v, states)
    acceleration = (excitation + torque - against + heavy * reference[1]) / (J + heavy)
    relative = acceleration - reference[1]
    return acceleration, -against - heavy * relative, (v, relative, *z_rate_of(control, x, v, states))


@chosen
def inertia_of(control: Control) -> Any:
    """Torque [kg*m^2] of a control against the acceleration of the deviation; 0 of one that does not say."""
    return _own_inertia if has(control, "inertia") else _no_inertia


def _own_inertia(control: Any) -> Any:
    return control.inertia()


def _no_inertia(control: Control) -> Any:
    return 0.0


class Tuning(NamedTuple):
    """Bandwidth [rad/s], damping ratio, kind and T_p [s] of a loop; lag [s] and filters of its torque; its encoder."""

    bandwidth: quantities.AngularSpeed
    damping: quantities.Ratio = 0.7
    kind: Literal["position", "speed", "cascade"] = "position"
    lag: quantities.Time = 0.0
    filters: tuple[Any, ...] = ()
    T_p: quantities.Time = 0.0
    encoder: Literal["motor", "load", "both"] = "motor"
    mixing_frequency: quantities.AngularSpeed = 0.0

    def __str__(self) -> str:
        lag = f", lag {1e3 * self.lag:.4g} ms" if self.lag else ""
        name = "cascade" if self.kind == "cascade" else f"{self.kind} loop"
        return f"{name} of {self.bandwidth / HERTZ:.4g} Hz, damping {self.damping:.3g}{lag}"


USUAL = Tuning(30.0 * HERTZ)


def from_bandwidth(
    bandwidth: float,
    inertia: float,
    damping: float = USUAL.damping,
    *,
    kind: Literal["position", "speed", "cascade"] = "position",
    lag: float = 0.0,
) -> Any:
    """Return the loop with a bandwidth omega_b and a damping ratio zeta on the inertia that it turns.

    On a rigid drive the closed loop is J s^2 + 2 zeta omega_n J s + J omega_n^2. A position loop has omega_n = omega_b:
    K_p = J omega_b^2, K_d = 2 zeta J omega_b. A speed loop has 2 zeta omega_n = omega_b, where its proportional part
    crosses over: K_p = J omega_b, K_i = K_p omega_b/(4 zeta^2), which with zeta = 1 is the usual K_p omega_b/4. A
    cascade has this speed loop, T_n = K_p/K_i = 4 zeta^2/omega_b, and K_v = omega_b/4 around it.

    Parameters
    ----------
    bandwidth : float
        omega_b [rad/s].
    inertia : float
        J [kg*m^2, motor side]: that of the motor with the wave generator, and that of the rigid load over N^2.
    damping : float
        Damping ratio zeta of the poles.
    kind : {"position", "speed", "cascade"}
        A PD loop of the angle, a PI loop of the speed, or a P loop of the angle around it.
    lag : float
        First-order lag [s] of the torque, that of the current loop; 0 for none.

    Returns
    -------
    PositionLoop, SpeedLoop or CascadeLoop, or Lagged of one
        With its gains in SI, as its class says (`K_p` [N*m/rad], `K_d` [N*m*s/rad] of a PositionLoop).

    Raises
    ------
    ValueError
        If a number is not positive, the kind is another, or the bandwidth is beyond half the inverse lag.

    References
    ----------
    Franklin, Powell & Emami-Naeini, Feedback Control of Dynamic Systems, 6th ed. 2010, ch. 3 (poles of second order)
    and 4.3 (PID control).
    """
    J = number("inertia [kg*m^2]", inertia, positive=True)
    omega, zeta = number("bandwidth [rad/s]", bandwidth, positive=True), number("damping", damping, positive=True)
    lag = number("lag [s]", lag)
    quantities.choice("kind", kind, *KINDS)
    if lag < 0.0:
        raise ValueError(f"lag [s] is {lag:g}; it must be zero or more")
    if omega * lag > FASTEST:
        raise ValueError(
            f"a bandwidth of {omega / HERTZ:.4g} Hz is above half the inverse lag, {FASTEST / lag / HERTZ:.4g} Hz for "
            f"{1e3 * lag:.4g} ms; lower the bandwidth, or the lag"
        )
    loop: Any = PositionLoop(J * omega * omega, 2.0 * zeta * J * omega)
    if kind == "speed":
        loop = SpeedLoop(J * omega, 0.25 * J * omega * omega / (zeta * zeta))
    elif kind == "cascade":
        loop = CascadeLoop(OUTER_GAIN * omega, J * omega, 4.0 * zeta * zeta / omega)
    return Lagged(loop, lag) if lag else loop


def tuning_of(control: Control, inertia: float) -> Tuning | None:
    """Bandwidth and damping that the gains of a loop give on an inertia [kg*m^2], as `from_bandwidth` takes them.

    A gain K_d of a speed loop counts as inertia. None of another control, of one without damping or stiffness, and of a
    cascade with another K_v.
    """
    loop, lag = (control.loop, control.lag) if isinstance(control, Lagged) else (control, 0.0)
    if isinstance(loop, PositionLoop) and loop.K_p > 0.0 and loop.K_d > 0.0:
        return Tuning(sqrt(loop.K_p / inertia), 0.5 * loop.K_d / sqrt(loop.K_p * inertia), "position", lag)
    if isinstance(loop, SpeedLoop) and loop.K_p > 0.0 and loop.K_i > 0.0:
        J = inertia + loop.K_d
        return Tuning(loop.K_p / J, 0.5 * loop.K_p / sqrt(loop.K_i * J), "speed", lag)
    if isinstance(loop, CascadeLoop) and isclose(loop.K_v, OUTER_GAIN * loop.K_p / inertia, rel_tol=1e-9):
        return Tuning(loop.K_p / inertia, 0.5 * sqrt(loop.T_n * loop.K_p / inertia), "cascade", lag)
    return None
