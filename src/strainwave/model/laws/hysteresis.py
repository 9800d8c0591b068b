"""Laws with memory: Bouc-Wen hysteresis, and laws side by side.

Such a law is a NamedTuple with `torque(x, v, z)`, `z_rate(x, v, z)` = the tuple of dz/dt, `energy(x, z)` = what it
stores, and `losses(x, v, z)` = the tuple of the powers that it turns into heat, so that T v = dE/dt + losses. x is the
torsion [rad], v its rate [rad/s], z the tuple of internal states; their number is `states`.
"""

from typing import Any, NamedTuple

from ...base.law import (
    breakpoints_of,
    check_law,
    energy_of,
    kinks_of,
    losses_of,
    share,
    spring_stiffness,
    tail,
    torque_of,
    z_rate_of,
)
from ...base.protocols import Law, need, scaled
from ...base.quantities import Angle, Ratio, Reals, States, TorsionalStiffness
from ...compile.jit import kernel
from ...compile.maths import sign
from .friction import positive

SHARPEST = 50  # n: every unit costs a multiplication in every step, and the sharper knee smaller steps


@kernel
def yielded(z: Any, yield_twist: Any, n: int) -> Any:
    """Return |z/yield_twist|^n by multiplication: a float power costs 24 times as much."""
    share_of_yield = abs(z / yield_twist)
    power = share_of_yield
    for _ in range(n - 1):
        power = power * share_of_yield
    return power


class BoucWen(NamedTuple):
    """Hysteresis T = ratio K x + (1 - ratio) K z, z' = A v - |z/x_y|^n (beta |v| sign z + gamma v); x_y: yield twist.

    The one internal state z [rad] starts along x with the slope A and levels off at x_y (A/(beta + gamma))^(1/n). A,
    beta and gamma are dimensionless. Rate-independent; odd; C0. It dissipates at every moment:
    E = K (ratio x^2 + (1 - ratio) z^2/A)/2 is stored, and T v - dE/dt = (1 - ratio) (K/A) |z/x_y|^n (beta |v z| +
    gamma v z) >= (1 - ratio) (K/A) |z/x_y|^n |v z| (beta - |gamma|) >= 0 where |gamma| <= beta, which `check` asks for.

    Bouc 1967, Proc. 4th Conf. Nonlinear Oscillations, Prague; Wen 1976, J. Eng. Mech. Div. ASCE 102(2), 249-263;
    Ismail, Ikhouane & Rodellar 2009, Arch. Comput. Methods Eng. 16(2), 161-188 (survey).
    """

    K: TorsionalStiffness
    ratio: Ratio
    yield_twist: Angle
    A: Ratio = 1.0
    beta: Ratio = 0.5
    gamma: Ratio = 0.5
    n: int = 1

    def states(self) -> int:
        """Number of internal states."""
        return 1

    def torque(self, x: Reals, v: Reals, z: States) -> Any:
        """Torque [N*m] at torsion x [rad], its rate v [rad/s] and z = (z,) [rad]."""
        return self.ratio * self.K * x + (1.0 - self.ratio) * self.K * z[0]

    def z_rate(self, x: Reals, v: Any, z: States) -> Any:
        """Rate (z',) [rad/s] of the internal state."""
        slip = self.beta * abs(v) * sign(z[0]) + self.gamma * v
        return (self.A * v - yielded(z[0], self.yield_twist, self.n) * slip,)

    def kinks(self, x: Reals, v: Reals, z: States) -> tuple[Any, ...]:
        """Functions that vanish where z' is not smooth: v [rad/s] and z [rad]."""
        return v, z[0]

    def stiffness(self, x: Reals) -> Any:
        """Stiffness [N*m/rad] before it yields (z = 0): K (ratio + (1 - ratio) A)."""
        return self.K * (self.ratio + (1.0 - self.ratio) * self.A) + 0.0 * x

    def spring_stiffness(self, x: Reals) -> Any:
        """Stiffness [N*m/rad] after it has yielded: ratio K."""
        return self.ratio * self.K + 0.0 * x

    def energy(self, x: Reals, z: States) -> Any:
        """Energy stored [J]."""
        return 0.5 * self.K * (self.ratio * x * x + (1.0 - self.ratio) * z[0] * z[0] / self.A)

    def losses(self, x: Reals, v: Reals, z: States) -> Any:
        """Power [W] turned into heat, in a tuple; never negative."""
        power = abs(v * z[0]) * (self.beta + self.gamma * sign(v * z[0]))  # in this form never below zero by rounding
        return ((1.0 - self.ratio) * self.K / self.A * yielded(z[0], self.yield_twist, self.n) * power,)

    def scaled(self, factor: Reals) -> "Yielding":
        """The same law times a factor, without divisions."""
        K = self.K * factor
        parts = self.ratio * K, (1.0 - self.ratio) * K, self.A, 1.0 / self.yield_twist, self.beta, self.gamma
        return Yielding(*parts, (1,) * self.n)

    def check(self) -> None:
        """Refuse what is no hysteresis or creates energy (ValueError)."""
        positive(self, "K", "yield_twist", "A")
        if not 0.0 <= self.ratio <= 1.0:
            raise ValueError(f"BoucWen.ratio is {self.ratio:g}; it is the elastic share of the torque, from 0 to 1")
        if self.n < 1:
            raise ValueError(f"BoucWen.n is {self.n}; it must be a whole number of at least 1")
        if self.n > SHARPEST:
            raise ValueError(
                f"BoucWen.n is {self.n}; it must be at most {SHARPEST}, whose knee is already within 2 % of a sharp one"
            )
        if abs(self.gamma) > self.beta:
            raise ValueError(
                f"BoucWen has gamma = {self.gamma:g} and beta = {self.beta:g}; with |gamma| > beta it creates energy, "
                "use |gamma| <= beta"
            )


class Yielding(NamedTuple):
    """`BoucWen` without divisions; its exponent is the length of a tuple, which the compiler knows."""

    elastic: Any
    plastic: Any
    A: Any
    per_yield: Any
    beta: Any
    gamma: Any
    exponent: tuple[int, ...]

    def states(self) -> int:
        """Number of internal states."""
        return 1

    def torque(self, x: Reals, v: Reals, z: States) -> Any:
        """Torque [N*m] at torsion x [rad], its rate v [rad/s] and z = (z,) [rad]."""
        return self.elastic * x + self.plastic * z[0]

    def z_rate(self, x: Reals, v: Reals, z: States) -> Any:
        """Rate (z',) [rad/s] of the internal state."""
        size = abs(z[0] * self.per_yield)
        level = size
        for _ in range(len(self.exponent) - 1):
            level = level * size
        return (self.A * v - level * (self.beta * abs(v) * sign(z[0]) + self.gamma * v),)


class Parallel(NamedTuple):
    """Two laws side by side, of any kind: the torque is the sum, each has its own internal states.

    z holds the states of the first, then those of the second. Nest it for more:
    `Parallel(spring, Parallel(BoucWen(...), Viscous(...)))`.
    """

    first: Any
    second: Any

    def torque(self, x: Reals, v: Reals, z: States) -> Any:
        """Torque [N*m] at torsion x [rad], its rate v [rad/s] and the states z of both laws."""
        first = torque_of(self.first, x, v, share(self.first, z))
        return first + torque_of(self.second, x, v, tail(self.first, z))

    def z_rate(self, x: Reals, v: Reals, z: States) -> Any:
        """Rates of the states of both laws."""
        first = z_rate_of(self.first, x, v, share(self.first, z))
        return first + z_rate_of(self.second, x, v, tail(self.first, z))

    def stiffness(self, x: Reals) -> Any:
        """Sum of the stiffnesses [N*m/rad] at torsion x [rad]."""
        return self.first.stiffness(x) + self.second.stiffness(x)

    def spring_stiffness(self, x: Reals) -> Any:
        """Sum of the stiffnesses [N*m/rad] of the springs at torsion x [rad]."""
        return spring_stiffness(self.first, x) + spring_stiffness(self.second, x)

    def energy(self, x: Reals, z: States) -> Any:
        """Energy stored [J] in both laws."""
        return energy_of(self.first, x, share(self.first, z)) + energy_of(self.second, x, tail(self.first, z))

    def losses(self, x: Reals, v: Reals, z: States) -> Any:
        """Powers [W] that the parts turn into heat, one for each part that can."""
        first = losses_of(self.first, x, v, share(self.first, z))
        return first + losses_of(self.second, x, v, tail(self.first, z))

    def breakpoints(self) -> tuple[float, ...]:
        """Torsions [rad] where a law of the two is not smooth."""
        return tuple(sorted({x for law in self for x in breakpoints_of(law)}))

    def kinks(self, x: Reals, v: Reals, z: States) -> Any:
        """Functions that vanish where a law of the two is not smooth."""
        first = kinks_of(self.first, x, v, share(self.first, z))
        return first + kinks_of(self.second, x, v, tail(self.first, z))

    def scaled(self, factor: Reals) -> "Parallel":
        """The same laws times a factor."""
        return Parallel(scaled_law(self.first, factor), scaled_law(self.second, factor))

    def check(self) -> None:
        """Refuse parts that are no laws (TypeError)."""
        for name, law in zip(self._fields, self, strict=True):
            need(f"Parallel.{name}", law, "torque")
            check_law(f"Parallel.{name}", law)


def scaled_law(law: Law, factor: Reals) -> Any:
    """Law whose torque is that of another times a factor, in its form for many steps."""
    return scaled(law, factor, Geared)


class Geared(NamedTuple):
    """Law of any kind whose torque is multiplied by a factor."""

    law: Any
    factor: Any

    def torque(self, x: Reals, v: Reals, z: States) -> Any:
        """Torque at torsion x [rad], its rate v [rad/s] and the law's states z."""
        return self.factor * torque_of(self.law, x, v, z)

    def z_rate(self, x: Reals, v: Reals, z: States) -> Any:
        """Rates of the law's states."""
        return z_rate_of(self.law, x, v, z)
