"""Loops as they are specified, by bandwidth and damping, and the gains that this gives on an inertia."""

from math import pi, sqrt
from typing import Any, Literal, NamedTuple

from ...quantities import AngularSpeed, Ratio, Time, number, shown
from .controls import Lagged, PositionLoop, SpeedLoop

FASTEST = 0.5  # bandwidth [rad/s] times lag [s]: there the lag takes 27 degrees of phase
HERTZ = 2.0 * pi  # rad/s
KINDS = ("position", "speed")


class Tuning(NamedTuple):
    """Bandwidth [rad/s], damping ratio and kind of a loop, and the lag [s] of its current loop."""

    bandwidth: AngularSpeed
    damping: Ratio = 0.7
    kind: Literal["position", "speed"] = "position"
    lag: Time = 0.0

    def __str__(self) -> str:
        lag = f", lag {1e3 * self.lag:.4g} ms" if self.lag else ""
        return f"{self.kind} loop of {self.bandwidth / HERTZ:.4g} Hz, damping {self.damping:.3g}{lag}"


USUAL = Tuning(30.0 * HERTZ)


def from_bandwidth(
    bandwidth: float,
    inertia: float,
    damping: float = USUAL.damping,
    *,
    kind: Literal["position", "speed"] = "position",
    lag: float = 0.0,
) -> Any:
    """Return the loop with a bandwidth omega_b and a damping ratio zeta on the inertia that it turns.

    On a rigid drive the closed loop is J s^2 + 2 zeta omega_n J s + J omega_n^2. A position loop has omega_n = omega_b:
    K_p = J omega_b^2, K_d = 2 zeta J omega_b. A speed loop has 2 zeta omega_n = omega_b, where its proportional part
    crosses over: K_p = J omega_b, K_i = K_p omega_b/(4 zeta^2), which with zeta = 1 is the usual K_p omega_b/4.

    Parameters
    ----------
    bandwidth : float
        omega_b [rad/s].
    inertia : float
        J [kg*m^2, motor side]: that of the motor with the wave generator, and that of the rigid load over N^2.
    damping : float
        Damping ratio zeta of the poles.
    kind : {"position", "speed"}
        A PD loop of the angle, or a PI loop of the speed.
    lag : float
        First-order lag [s] of the torque, that of the current loop; 0 for none.

    Returns
    -------
    PositionLoop or SpeedLoop, or Lagged of one

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
    if kind not in KINDS:
        raise ValueError(f"kind is {shown(kind)}; it must be 'position' or 'speed'")
    if lag < 0.0:
        raise ValueError(f"lag [s] is {lag:g}; it must be zero or more")
    if omega * lag > FASTEST:
        raise ValueError(
            f"a bandwidth of {omega / HERTZ:.4g} Hz is above half the inverse lag, {FASTEST / lag / HERTZ:.4g} Hz for "
            f"{1e3 * lag:.4g} ms; lower the bandwidth, or the lag"
        )
    position = PositionLoop(J * omega * omega, 2.0 * zeta * J * omega)
    loop = position if kind == "position" else SpeedLoop(J * omega, 0.25 * J * omega * omega / (zeta * zeta))
    return Lagged(loop, lag) if lag else loop


def tuning_of(control: Any, inertia: float) -> Tuning | None:
    """Bandwidth and damping that the gains of a loop give on an inertia [kg*m^2], as `from_bandwidth` takes them.

    A gain K_d of a speed loop counts as inertia. None of another control, and of one without damping or stiffness.
    """
    loop, lag = (control.loop, control.lag) if isinstance(control, Lagged) else (control, 0.0)
    if isinstance(loop, PositionLoop) and loop.K_p > 0.0 and loop.K_d > 0.0:
        return Tuning(sqrt(loop.K_p / inertia), 0.5 * loop.K_d / sqrt(loop.K_p * inertia), "position", lag)
    if isinstance(loop, SpeedLoop) and loop.K_p > 0.0 and loop.K_i > 0.0:
        J = inertia + loop.K_d
        return Tuning(loop.K_p / J, 0.5 * loop.K_p / sqrt(loop.K_i * J), "speed", lag)
    return None
