"""Friction laws: the torque that opposes a sliding speed v, across the gear or on one shaft.

`torque(x, v)` depends on the speed alone; `LuGre` has bristles as an internal state. In parallel with a spring they act
on the torsion's rate (`Parallel(spring, Coulomb(...))`); on the motor or load shaft the same laws take that shaft's
angle and speed. Torques are in N*m, speeds in rad/s, both of the shaft that the law sits on.
"""

from typing import Annotated, Any, NamedTuple

from ...base.quantities import Angle, AngularSpeed, Damping, Ratio, Reals, States, Torque, TorsionalStiffness, number
from ...compile.jit import kernel
from ...compile.maths import exp, sqrt
from .springs import outside

PerKelvin = Annotated[float, "1/K"]
PerTorque = Annotated[float, "1/(N*m)"]
Kelvin = Annotated[float, "K"]
QuadraticCoefficient = Annotated[float, "N*m*s**2/rad**2"]

TINY = 1e-300  # rad^2/s^2
HOTTEST = 20.0  # exponent of the viscosity: 570 K for oil


@kernel
def smooth_sign(v: Reals, width: Reals) -> Any:
    """Sign of v, smoothed: v/sqrt(v^2 + width^2); without a width its sign, 0 at rest."""
    return v / sqrt(v * v + width * width + TINY)


@kernel
def sliding_friction(v: Reals, low: Reals, high: Reals, speed: Reals) -> Any:
    """Friction torque that falls from `high` at rest to `low` well above `speed`."""
    return low + (high - low) * exp(-(v / speed) * (v / speed))


def positive(law: Any, *names: str) -> None:
    """Refuse fields of a law that are not positive (ValueError)."""
    for name in names:
        if not number(f"{type(law).__name__}.{name}", getattr(law, name)) > 0.0:
            raise ValueError(f"{type(law).__name__}.{name} is {getattr(law, name):g}; it must be positive")


def _not_negative(law: Any, *names: str) -> None:
    for name in names:
        if not getattr(law, name) >= 0.0:
            raise ValueError(f"{type(law).__name__}.{name} is {getattr(law, name):g}; it must not be negative")


def refuse_heat(law: Any) -> None:
    """Refuse a warming beyond all temperatures at which exp(-per_kelvin warming) could hold (ValueError)."""
    exponent = -law.per_kelvin * law.warming
    if not abs(exponent) <= HOTTEST:
        raise ValueError(
            f"{type(law).__name__}.warming is {law.warming:g} K, for {law.per_kelvin:g} 1/K the factor exp("
            f"{exponent:.3g}); the exponent must be within +-{HOTTEST:g}, give the kelvin above the reference "
            "temperature"
        )


def _rising(law: Any) -> None:
    positive(law, "T_c", "v_s")
    if not law.T_s >= law.T_c:
        raise ValueError(
            f"{type(law).__name__} has T_s = {law.T_s:g} and T_c = {law.T_c:g} N*m; break-away takes at least the "
            "torque of sliding: T_s >= T_c"
        )


class Viscous(NamedTuple):
    """Viscous friction T = B exp(-per_kelvin warming) (1 + per_torque |load|) v.

    B holds at the reference temperature without load; `warming` [K] is the temperature above it and `load` the torque
    that the gear transmits. The default 3.5 % per kelvin is that of gear oil viscosity, nu = 100 cSt exp(-0.035 (T -
    20 C)) in a published model of a strain wave gear (harmonic-drive-twin, MIT); seals and grease differ: measure.
    Analytic, odd.
    """

    B: Damping
    warming: Kelvin = 0.0
    load: Torque = 0.0
    per_kelvin: PerKelvin = 0.035
    per_torque: PerTorque = 0.0

    def torque(self, x: Reals, v: Reals) -> Any:
        """Torque [N*m] at the speed v [rad/s]."""
        return self.B * exp(-self.per_kelvin * self.warming) * (1.0 + self.per_torque * abs(self.load)) * v

    def stiffness(self, x: Reals) -> Any:
        """No stiffness: 0."""
        return 0.0 * x

    def check(self) -> None:
        """Refuse friction that drives, and a warming that no oil has seen (ValueError)."""
        _not_negative(self, "B", "per_torque")
        refuse_heat(self)


class Coulomb(NamedTuple):
    """Dry friction T = T_c sign v, at rest whatever up to T_c holds the shaft.

    Beside the spring of a gear, between two shafts, it is T_c v/sqrt(v^2 + width^2), smoothed over the speed `width`:
    at v = width it is 71 % of T_c, at 10 widths 99.5 %, and under a torque below T_c it creeps; take a width well below
    the speeds that matter, or `LuGre`. Give a shaft none. Odd.
    """

    T_c: Torque
    width: AngularSpeed = 0.0

    def torque(self, x: Reals, v: Reals) -> Any:
        """Torque [N*m] at the speed v [rad/s]."""
        return self.T_c * smooth_sign(v, self.width)

    def sliding(self, v: Reals) -> Any:
        """Torque [N*m] against a slip at the speed v [rad/s]; at 0 that which begins it."""
        return self.T_c + 0.0 * v

    def stiffness(self, x: Reals) -> Any:
        """No stiffness: 0."""
        return 0.0 * x

    def check(self) -> None:
        """Refuse friction that drives, and a negative width (ValueError)."""
        _not_negative(self, "T_c", "width")


class QuadraticDamping(NamedTuple):
    """Damping T = D |v| v: the drag of what churns, and losses that grow with the motion. Odd; C1."""

    D: QuadraticCoefficient

    def torque(self, x: Reals, v: Any) -> Any:
        """Torque [N*m] at the speed v [rad/s]."""
        return self.D * abs(v) * v

    def stiffness(self, x: Reals) -> Any:
        """No stiffness: 0."""
        return 0.0 * x

    def check(self) -> None:
        """Refuse damping that drives (ValueError)."""
        _not_negative(self, "D")


class ContactDamping(NamedTuple):
    """Damping in contact alone: T = B v min((|x| - half_gap)/rise, 1) for |x| > half_gap, 0 within.

    It stands beside a `Backlash` or a `Play` of that gap, whose drive has B = 0: that B acts across the gap too. The
    contact takes hold over a torsion `rise` beyond the gap. Odd; C0.
    """

    B: Damping
    half_gap: Angle
    rise: Angle

    def torque(self, x: Reals, v: Reals) -> Any:
        """Torque [N*m] at torsion x [rad] and its rate v [rad/s]."""
        share: Any = abs(outside(x, self.half_gap)) / self.rise
        return self.B * v * 0.5 * (share + 1.0 - abs(share - 1.0))

    def stiffness(self, x: Reals) -> Any:
        """No stiffness: 0."""
        return 0.0 * x

    def breakpoints(self) -> tuple[float, ...]:
        """Torsions [rad] at the edges of the gap, and where the damping is whole."""
        edge = self.half_gap + self.rise
        return (-edge, -self.half_gap, self.half_gap, edge)

    def check(self) -> None:
        """Refuse damping that drives, a negative gap and a rise that is not positive (ValueError)."""
        _not_negative(self, "B", "half_gap")
        positive(self, "rise")


class Stribeck(NamedTuple):
    """Dry friction that falls from T_s to T_c as the surfaces part: T = s(v) (T_c + (T_s - T_c) exp(-(v/v_s)^2)).

    s(v) is the sign of v, on a shaft that sticks, or smoothed over a `width` between shafts, as in `Coulomb`. The
    falling part is negative damping: it can keep a stick-slip motion going. Odd.

    Armstrong-Helouvry, Dupont & Canudas de Wit 1994, Automatica 30(7), 1083-1138 (survey, with the Stribeck curve).
    """

    T_c: Torque
    T_s: Torque
    v_s: AngularSpeed
    width: AngularSpeed = 0.0

    def torque(self, x: Reals, v: Reals) -> Any:
        """Torque [N*m] at the speed v [rad/s]."""
        return smooth_sign(v, self.width) * self.sliding(v)

    def sliding(self, v: Reals) -> Any:
        """Torque [N*m] against a slip at the speed v [rad/s]; at 0 that which begins it."""
        return sliding_friction(v, self.T_c, self.T_s, self.v_s)

    def stiffness(self, x: Reals) -> Any:
        """No stiffness: 0."""
        return 0.0 * x

    def check(self) -> None:
        """Refuse a break-away torque below the sliding one, and a width that hides the fall (ValueError)."""
        _rising(self)
        _not_negative(self, "width")
        if not self.width < self.v_s:
            raise ValueError(
                f"Stribeck.width is {self.width:g} rad/s and v_s {self.v_s:g} rad/s; the width must be smaller, or the "
                "break-away torque is never seen"
            )


@kernel
def bending(law: Any, v: Any, z: Any) -> Any:
    """Rate [rad/s] of the bristles' deflection z [rad] of a `LuGre` law."""
    return v - law.sigma_0 * abs(v) * z / sliding_friction(v, law.T_c, law.T_s, law.v_s)


class LuGre(NamedTuple):
    """Bristles that bend and slip: T = sigma_0 z + sigma_1 z' + sigma_2 v, z' = v - sigma_0 |v| z/g(v).

    g(v) = T_c + (T_s - T_c) exp(-(v/v_s)^2); z [rad] is the bristles' deflection, at most T_s/sigma_0. At a steady
    speed T = g(v) sign v + sigma_2 v; before it slips it is a spring of stiffness sigma_0. E = sigma_0 z^2/2 is stored,
    sigma_0^2 |v| z^2/g + sigma_1 z' v + sigma_2 v^2 is lost, which is never negative where sigma_2 >= sigma_1 (T_s -
    T_c)/T_c and else may be for moments (Barabanov & Ortega 2000, IEEE Trans. Automatic Control 45(4), 830-832). Odd;
    C0.

    Canudas de Wit, Olsson, Astrom & Lischinsky 1995, IEEE Trans. Automatic Control 40(3), 419-425.
    """

    sigma_0: TorsionalStiffness
    sigma_1: Damping
    sigma_2: Damping
    T_c: Torque
    T_s: Torque
    v_s: AngularSpeed

    def states(self) -> int:
        """Number of internal states."""
        return 1

    def torque(self, x: Reals, v: Reals, z: States) -> Any:
        """Torque [N*m] at the speed v [rad/s] and z = (z,) [rad]."""
        return self.sigma_0 * z[0] + self.sigma_1 * bending(self, v, z[0]) + self.sigma_2 * v

    def z_rate(self, x: Reals, v: Reals, z: States) -> Any:
        """Rate (z',) [rad/s] of the deflection."""
        return (bending(self, v, z[0]),)

    def kinks(self, x: Reals, v: Reals, z: States) -> tuple[Any, ...]:
        """Function that vanishes where z' has a corner: the speed v [rad/s]."""
        return (v,)

    def stiffness(self, x: Reals) -> Any:
        """Stiffness sigma_0 [N*m/rad] before it slips."""
        return self.sigma_0 + 0.0 * x

    def spring_stiffness(self, x: Reals) -> Any:
        """No stiffness once it slips: 0."""
        return 0.0 * x

    def energy(self, x: Reals, z: States) -> Any:
        """Energy stored [J] in the bristles."""
        return 0.5 * self.sigma_0 * z[0] * z[0]

    def losses(self, x: Reals, v: Reals, z: States) -> Any:
        """Power [W] turned into heat, in a tuple."""
        z_rate = bending(self, v, z[0])
        return (self.sigma_0 * z[0] * (v - z_rate) + self.sigma_1 * z_rate * v + self.sigma_2 * v * v,)

    def check(self) -> None:
        """Refuse bristles without stiffness, and friction that drives (ValueError)."""
        positive(self, "sigma_0")
        _not_negative(self, "sigma_1", "sigma_2")
        _rising(self)


class NoFriction(NamedTuple):
    """The meshing loses nothing."""

    def torque(self, T: Reals, v: Reals) -> Any:
        """Torque [N*m, output side]: 0."""
        return 0.0


NO_FRICTION = NoFriction()


class LoadFriction(NamedTuple):
    """Load-proportional friction T_f = mu |T| v/sqrt(v^2 + width^2): mu |T| sign v, smoothed over the speed `width`.

    `Gear.load_friction` gives mu from a catalogue's efficiency. Without any other friction the efficiency is
    1/(1 + mu) where the motor drives and 1 - mu where the load does.
    """

    mu: Ratio
    width: AngularSpeed = 1.0

    def torque(self, T: Any, v: Any) -> Any:
        """Torque [N*m, output side] against the motor's turning, at the torque T [N*m] and the motor's speed v."""
        return self.mu * abs(T) * smooth_sign(v, self.width)

    def check(self) -> None:
        """Refuse friction that drives, and a gear that its own friction locks (ValueError)."""
        positive(self, "width")
        if not 0.0 <= self.mu < 1.0:
            raise ValueError(
                f"LoadFriction.mu is {self.mu:g}; it must be from 0 up to 1, where the load can no longer drive the "
                "motor; give a share of the transmitted torque, for example 0.08"
            )
