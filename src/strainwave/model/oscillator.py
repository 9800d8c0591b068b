"""The dynamic error equation J x'' + B u' + T(u) = tau(phase), with u = x - e(phase)."""

from typing import Any, NamedTuple

from ..base.law import breakpoints_of, check_law, kinks_of, losses_of, share, states_of, torque_of, z_rate_of
from ..base.protocols import joint_orders, need, scaled
from ..base.quantities import LARGEST, AngularSpeed, Damping, Inertia
from .excitation import NoError, scaled_torque
from .laws.hysteresis import scaled_law


class Oscillator(NamedTuple):
    """Dynamic error x of a drive whose gear has the law T, the damping B and the kinematic error e.

    J x'' + B u' + T(u) = tau(phase), u = x - e(phase), phase = omega t (article eq. for x, with the kinematic error of
    Ghorbel, Gandhi & Alpeter 2001). The state is (x [rad], x' [rad/s]) and after them the internal states of a law
    with memory; the law sees the torsion u and, where it depends on it, its rate u'.
    """

    J: Inertia
    B: Damping
    law: Any
    excitation: Any
    omega: AngularSpeed
    error: Any = NoError()

    def torsion(self, phase: Any, y: Any) -> Any:
        """Torsion u = x - e(phase) [rad]."""
        return y[0] - self.error.value(phase)

    def rhs(self, phase: Any, y: Any) -> Any:
        """Time derivatives (x', x'', z' ...) of the state y = (x, x', z ...) at the base phase [rad]."""
        v, z = y[1], y[2:]
        u = y[0] - self.error.value(phase)
        du = v - self.omega * self.error.slope(phase)
        torque = torque_of(self.law, u, du, z)
        return (v, (self.excitation.torque(phase) - self.B * du - torque) / self.J, *z_rate_of(self.law, u, du, z))

    def jacobian(self, phase: Any, y: Any) -> Any:
        """Rows of the derivative of `rhs` with respect to the state: ((0, 1), (-T'(u)/J, -B/J)); of a law torque(x)."""
        u = y[0] - self.error.value(phase)
        stiffness = self.law.stiffness(u)
        return (0.0 * stiffness, 1.0 + 0.0 * stiffness), (-stiffness / self.J, -self.B / self.J + 0.0 * stiffness)

    def breakpoints(self) -> tuple[float, ...]:
        """Torsions [rad] where the law is not smooth (none for a law that does not say)."""
        return tuple(breakpoints_of(self.law))

    def kinks(self, phase: Any, y: Any) -> Any:
        """What vanishes where the law is not smooth."""
        rate = y[1] - self.omega * self.error.slope(phase)
        return kinks_of(self.law, self.torsion(phase, y), rate, y[2:])

    def state_names(self) -> tuple[str, ...]:
        """Names of the states, in order."""
        return ("x", "x'", *(f"z{i + 1}" for i in range(states_of(self.law))))

    def orders(self) -> tuple[float, ...]:
        """Orders of the excitation and of the kinematic error on the base angle."""
        return joint_orders(self.excitation, self.error)

    def prepared(self) -> Any:
        """The same system for many steps: its parts prepared and divided by J."""
        per_J = 1.0 / self.J
        parts = self.B * per_J, scaled_law(self.law, per_J), scaled_torque(self.excitation, per_J), self.omega
        if isinstance(self.error, NoError):
            return FreeOfError(*parts)
        return WithError(*parts, scaled(self.error, 1.0, lambda error, _: error))

    def check(self) -> None:
        """Refuse an inertia that is not positive (ValueError) and parts without the methods needed (TypeError)."""
        if not self.J >= 1.0 / LARGEST:
            raise ValueError(f"Oscillator.J is {self.J:g} kg*m**2; an inertia must be positive, {1 / LARGEST:g} up")
        need("Oscillator.law", self.law, "torque")
        need("Oscillator.excitation", self.excitation, "torque")
        need("Oscillator.error", self.error, "value", "slope")
        check_law("Oscillator.law", self.law)


class FreeOfError(NamedTuple):
    """Oscillator whose gear has no kinematic error; its torques are divided by the inertia."""

    B: Any
    law: Any
    excitation: Any
    omega: Any

    def rhs(self, phase: Any, y: Any) -> Any:
        """Time derivatives of the state y at the base phase [rad]."""
        x, v, z = y[0], y[1], y[2:]
        torque = torque_of(self.law, x, v, z)
        return (v, self.excitation.torque(phase) - self.B * v - torque, *z_rate_of(self.law, x, v, z))


class WithError(NamedTuple):
    """Oscillator whose gear has a kinematic error; its torques are divided by the inertia."""

    B: Any
    law: Any
    excitation: Any
    omega: Any
    error: Any

    def rhs(self, phase: Any, y: Any) -> Any:
        """Time derivatives of the state y at the base phase [rad]."""
        v, z = y[1], y[2:]
        u = y[0] - self.error.value(phase)
        du = v - self.omega * self.error.slope(phase)
        torque = torque_of(self.law, u, du, z)
        return (v, self.excitation.torque(phase) - self.B * du - torque, *z_rate_of(self.law, u, du, z))


class Powers(NamedTuple):
    """An oscillator's states and after them its works and losses: excitation, error, damping, parts of the law."""

    system: Any

    @property
    def omega(self) -> float:
        """Base speed [rad/s] of the system."""
        return float(self.system.omega)

    def breakpoints(self) -> tuple[float, ...]:
        """Torsions where the law is not smooth."""
        return tuple(self.system.breakpoints())

    def torsion(self, phase: Any, y: Any) -> Any:
        """Torsion of the system."""
        return self.system.torsion(phase, y)

    def rhs(self, phase: Any, y: Any) -> Any:
        """Rates of the states, and the powers [W]."""
        system, v = self.system, y[1]
        z = share(system.law, y[2:])
        u = system.torsion(phase, y)
        error_rate = system.omega * system.error.slope(phase)
        du = v - error_rate
        gear = system.B * du + torque_of(system.law, u, du, z)
        works = (system.excitation.torque(phase) * v, -gear * error_rate, system.B * du * du)
        return system.rhs(phase, (y[0], v, *z)) + works + losses_of(system.law, u, du, z)
