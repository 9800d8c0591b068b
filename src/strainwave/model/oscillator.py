"""The dynamic error equation J x'' + B u' + T(u) = tau(phase), with u = x - e(phase), and that of a gear that varies.

J x'' + b(theta, u') u' + (1 + k(theta)) T(u) = tau(theta): the stiffness of a strain wave gear repeats with its wave
generator (Gu, Tong, Huang & Li 2021, extrica.com article 21633: forced parametric vibration with two periods), its
damping with angle, speed of the torsion and temperature. k is a sum of lines of integer order on the base angle.
"""

import math
from typing import Any, NamedTuple

from ..base.above import above
from ..base.law import breakpoints_of, check_law, depends, kinks_of, losses_of, share, states_of, torque_of, z_rate_of
from ..base.protocols import joint_orders, lacking, need, scaled
from ..base.quantities import SMALLEST, Angle, AngularSpeed, Damping, Inertia, Ratio, Reals, States, shown
from ..compile.maths import cos, exp, sin
from .excitation import NoError, _refuse_high, scaled_torque
from .laws.dry import refuse_dry
from .laws.friction import Kelvin, PerKelvin, refuse_heat
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

    def _repr_html_(self) -> str:
        """Numbers in a notebook."""
        return str(above("card")(self))

    def torsion(self, phase: Reals, y: States) -> Any:
        """Torsion u = x - e(phase) [rad]."""
        return y[0] - self.error.value(phase)

    def rhs(self, phase: Reals, y: States) -> Any:
        """Time derivatives (x', x'', z' ...) of the state y = (x, x', z ...) at the base phase [rad]."""
        v, z = y[1], y[2:]
        u = y[0] - self.error.value(phase)
        du = v - self.omega * self.error.slope(phase)
        torque = torque_of(self.law, u, du, z)
        return (v, (self.excitation.torque(phase) - self.B * du - torque) / self.J, *z_rate_of(self.law, u, du, z))

    def jacobian(self, phase: Reals, y: States) -> Any:
        """Rows of the derivative of `rhs` with respect to the state: ((0, 1), (-T'(u)/J, -B/J)); of a law torque(x)."""
        u = y[0] - self.error.value(phase)
        stiffness = self.law.stiffness(u)
        return (0.0 * stiffness, 1.0 + 0.0 * stiffness), (-stiffness / self.J, -self.B / self.J + 0.0 * stiffness)

    def breakpoints(self) -> tuple[float, ...]:
        """Torsions [rad] where the law is not smooth (none for a law that does not say)."""
        return tuple(breakpoints_of(self.law))

    def kinks(self, phase: Reals, y: States) -> Any:
        """Functions that vanish where the law is not smooth."""
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
        if not self.J >= SMALLEST:
            raise ValueError(f"Oscillator.J is {self.J:g} kg*m**2; an inertia must be positive, {SMALLEST:g} up")
        need("Oscillator.law", self.law, "torque")
        need("Oscillator.excitation", self.excitation, "torque(angle)")
        need("Oscillator.error", self.error, "value(angle)", "slope(angle)")
        check_law("Oscillator.law", self.law)
        refuse_dry("Oscillator.law", self.law)


class FreeOfError(NamedTuple):
    """Oscillator whose gear has no kinematic error; its torques are divided by the inertia."""

    B: Any
    law: Any
    excitation: Any
    omega: Any

    def rhs(self, phase: Reals, y: States) -> Any:
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

    def rhs(self, phase: Reals, y: States) -> Any:
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

    def torsion(self, phase: Reals, y: States) -> Any:
        """Torsion of the system."""
        return self.system.torsion(phase, y)

    def rhs(self, phase: Reals, y: States) -> Any:
        """Rates of the states, and the powers [W]."""
        system, v = self.system, y[1]
        z = share(system.law, y[2:])
        u = system.torsion(phase, y)
        error_rate = system.omega * system.error.slope(phase)
        du = v - error_rate
        gear = system.B * du + torque_of(system.law, u, du, z)
        works = (system.excitation.torque(phase) * v, -gear * error_rate, system.B * du * du)
        return system.rhs(phase, (y[0], v, *z)) + works + losses_of(system.law, u, du, z)


class Ripple(NamedTuple):
    """One line of a variation: depth cos(order * angle + phase), relative to the mean."""

    order: int
    depth: Ratio
    phase: Angle = 0.0

    def check(self) -> None:
        """Refuse an order below 1 (ValueError)."""
        if self.order < 1:
            raise ValueError(f"Ripple.order is {self.order}; it must be at least 1 (a constant part is the mean)")
        _refuse_high("Ripple", self.order)


class Variation(NamedTuple):
    """Factor 1 + sum of ripples depth_i cos(order_i angle + phase_i), of a stiffness or a damping; always positive."""

    ripples: tuple[Ripple, ...]

    def value(self, angle: Reals) -> Any:
        """Factor at the base angle [rad]."""
        total = 1.0 + 0.0 * angle
        for i in range(len(self.ripples)):
            ripple = self.ripples[i]
            total = total + ripple.depth * cos(ripple.order * angle + ripple.phase)
        return total

    def slope(self, angle: Reals) -> Any:
        """Derivative of the factor with respect to the base angle [1/rad]."""
        total = 0.0 * angle
        for i in range(len(self.ripples)):
            ripple = self.ripples[i]
            total = total - ripple.depth * ripple.order * sin(ripple.order * angle + ripple.phase)
        return total

    def orders(self) -> tuple[float, ...]:
        """The orders of all ripples."""
        return tuple(ripple.order for ripple in self.ripples)

    def depth(self) -> float:
        """Sum of the depths' sizes: the factor stays within 1 - depth and 1 + depth."""
        return sum(abs(ripple.depth) for ripple in self.ripples)

    def check(self) -> None:
        """Refuse ripples that could turn the factor negative (ValueError)."""
        if not self.depth() < 1.0:
            raise ValueError(
                f"the depths of a Variation add up to {self.depth():g}; they must stay below 1, or the stiffness or "
                "damping that varies could vanish"
            )


class NoVariation(NamedTuple):
    """A stiffness or damping that does not change with the angle: the factor 1."""

    def value(self, angle: Reals) -> Any:
        """Factor 1."""
        return 1.0 + 0.0 * angle

    def slope(self, angle: Reals) -> Any:
        """Derivative 0 [1/rad]."""
        return 0.0 * angle

    def orders(self) -> tuple[float, ...]:
        """None."""
        return ()

    def depth(self) -> float:
        """No depth: 0."""
        return 0.0


class GearDamping(NamedTuple):
    """Damping across the gear, of angle, speed and temperature: b = B exp(-per_kelvin warming) variation(theta) s(v).

    s(v) = fast + (1 - fast)/(1 + (v/v_fast)^2) leads from 1 at rest to `fast` well above the speed v_fast of the
    torsion: below 1 the lubricant thins, above 1 it thickens (a Cross law of exponent 2; numbers for gears are the
    user's). The torque b v grows with v everywhere where fast >= 1/9. `warming` [K] is the temperature above that at
    which B holds; for the default 3.5 % per kelvin see `Viscous`.
    """

    B: Damping
    variation: Any = NoVariation()
    warming: Kelvin = 0.0
    per_kelvin: PerKelvin = 0.035
    fast: Ratio = 1.0
    v_fast: AngularSpeed = 1.0

    def value(self, angle: Reals, v: Reals) -> Any:
        """Damping b [N*m*s/rad] at the base angle [rad] and the rate v [rad/s] of the torsion."""
        r = v / self.v_fast
        thinned = self.fast + (1.0 - self.fast) / (1.0 + r * r)
        return self.B * exp(-self.per_kelvin * self.warming) * self.variation.value(angle) * thinned

    def slope(self, angle: Reals, v: Reals) -> Any:
        """Derivative d(b v)/dv [N*m*s/rad] of the damping torque."""
        r = v / self.v_fast
        w = 1.0 + r * r
        thinned = self.fast + (1.0 - self.fast) * (1.0 - r * r) / (w * w)
        return self.B * exp(-self.per_kelvin * self.warming) * self.variation.value(angle) * thinned

    def orders(self) -> tuple[float, ...]:
        """Orders of the variation."""
        return tuple(self.variation.orders())

    def bounds(self) -> tuple[float, float]:
        """Bounds 0 <= b1 <= b <= b2 [N*m*s/rad] for all angles and speeds."""
        b, depth = self.B * math.exp(-self.per_kelvin * self.warming), self.variation.depth()
        return b * (1.0 - depth) * min(1.0, self.fast), b * (1.0 + depth) * max(1.0, self.fast)

    def check(self) -> None:
        """Refuse damping that drives, and a scale of speed that is none (ValueError)."""
        for name in ("B", "fast"):
            if not getattr(self, name) >= 0.0:
                raise ValueError(f"GearDamping.{name} is {getattr(self, name):g}; it must not be negative")
        if not self.v_fast > 0.0:
            raise ValueError(f"GearDamping.v_fast is {self.v_fast:g} rad/s; it must be positive")
        if lacking(self.variation, "value", "orders", "depth"):
            raise TypeError(
                f"GearDamping.variation is {shown(self.variation)}; it must be a Variation((Ripple(order, depth), "
                "...)) or NoVariation()"
            )
        refuse_heat(self)


class VaryingOscillator(NamedTuple):
    """Dynamic error x of a drive whose stiffness follows the base angle and whose damping is an object of its own.

    J x'' + b(phase, u') u' + (1 + k(phase)) T(u) = tau(phase), u = x - e(phase), phase = omega t. `damping` has
    `value(angle, v)` and `slope(angle, v)` as `GearDamping`, `variation` is the factor 1 + k with `value(angle)`; the
    law is a spring torque(x). The state is (x [rad], x' [rad/s]).
    """

    J: Inertia
    damping: Any
    law: Any
    excitation: Any
    omega: AngularSpeed
    error: Any = NoError()
    variation: Any = NoVariation()

    def torsion(self, phase: Reals, y: States) -> Any:
        """Torsion u = x - e(phase) [rad]."""
        return y[0] - self.error.value(phase)

    def rhs(self, phase: Reals, y: States) -> Any:
        """Time derivatives (x', x'') of the state y = (x, x') at the base phase [rad]."""
        u = y[0] - self.error.value(phase)
        du = y[1] - self.omega * self.error.slope(phase)
        torque = self.damping.value(phase, du) * du + self.variation.value(phase) * self.law.torque(u)
        return y[1], (self.excitation.torque(phase) - torque) / self.J

    def jacobian(self, phase: Reals, y: States) -> Any:
        """Rows of the derivative of `rhs` with respect to the state."""
        u = y[0] - self.error.value(phase)
        du = y[1] - self.omega * self.error.slope(phase)
        stiffness = self.variation.value(phase) * self.law.stiffness(u)
        damping = self.damping.slope(phase, du) + 0.0 * stiffness
        return (0.0 * stiffness, 1.0 + 0.0 * stiffness), (-stiffness / self.J, -damping / self.J)

    def breakpoints(self) -> tuple[float, ...]:
        """Torsions [rad] where the law is not smooth (none for a law that does not say)."""
        return tuple(breakpoints_of(self.law))

    def state_names(self) -> tuple[str, ...]:
        """Names of the states, in order."""
        return ("x", "x'")

    def orders(self) -> tuple[float, ...]:
        """Orders of the excitation, the kinematic error, the stiffness and the damping on the base angle."""
        return joint_orders(self.excitation, self.error, self.variation, self.damping)

    def check(self) -> None:
        """Refuse an inertia that is not positive (ValueError), parts without their methods and laws with friction."""
        if not self.J >= SMALLEST:
            raise ValueError(f"VaryingOscillator.J is {self.J:g} kg*m**2; an inertia must be positive")
        need("VaryingOscillator.law", self.law, "torque")
        need("VaryingOscillator.excitation", self.excitation, "torque(angle)")
        need("VaryingOscillator.error", self.error, "value(angle)", "slope(angle)")
        remedy = "; write GearDamping(B) for a constant damping"
        need("VaryingOscillator.damping", self.damping, "value(angle, v)", "slope(angle, v)", remedy=remedy)
        need("VaryingOscillator.variation", self.variation, "value(angle)")
        check_law("VaryingOscillator.law", self.law)
        if depends(self.law) != 1:
            raise TypeError(
                f"VaryingOscillator.law is a {type(self.law).__name__}, which has friction or memory; it takes a "
                "spring torque(x): give the friction to `damping`, or use an Oscillator"
            )
