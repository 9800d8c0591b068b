"""The error equation derived by SymPy from the energies of the drive, with Lagrange's equations.

Symbols: theta_m and theta_l are the motor and load angles, x = theta_m/N - theta_l the dynamic error,
u = x - e(theta_m) the torsion, f the shape of the torsion law T(u) = K f(u). T_m and T_l are torques along +theta_m and
+theta_l, so that a load that resists the motion has T_l < 0. A prime is a time derivative; e' is de/dtheta_m.

Sources: Goldstein, Poole & Safko, Classical Mechanics, 3rd ed., sec. 1.5 (Lagrange's equations with Rayleigh's
dissipation function); Ghorbel, Gandhi & Alpeter 2001 (kinematic error). Only this module needs SymPy.
"""

from collections import namedtuple
from functools import cached_property
from typing import Any

from . import sp
from .cases import DerivedCase, cases
from .steps import Row, Steps, Symbols, symbols


class Derivation(
    Steps,
    namedtuple(
        "Derivation",
        "symbols kinetic potential dissipation motor_equation load_equation error_equation cubic_equation "
        "free_equation free_reduced free_dropped held_equation held_motor_torque J mu omega_0_squared F F_printed",
    ),
):
    """The error equation and the steps to it, as SymPy expressions in `symbols` (SI units, angles in rad).

    The equations are written with the symbols J, mu, omega_0 and F; `explicit` puts the drive's parameters in.

    Attributes
    ----------
    symbols : Symbols
        Symbols of the expressions.
    kinetic, potential, dissipation : Expr
        Kinetic energy [J], potential energy [J] and Rayleigh's dissipation function [W].
    motor_equation, load_equation : Eq
        Lagrange's equations of both coordinates [N*m], exact, with kinematic error.
    error_equation, cubic_equation : Eq
        Motor free, no kinematic error, exact: x'' + mu x' + omega_0^2 f(x) = F [rad/s^2], for any f and for
        f = x + alpha x^3.
    free_equation : Eq
        Motor free, with kinematic error, exact [N*m]: J x'' + (1 - J e'/(N J_m)) (B u' + K f(u)) = J F.
    free_reduced : Eq
        Equation that is solved instead: J x'' + B u' + K f(u) = J F with theta_m' = omega constant inside e.
    free_dropped : tuple of Expr
        Terms of the left side [N*m] that `free_reduced` leaves out: the motor's answer to the changing ratio (of order
        N e'), and the speed ripple theta_m' - omega.
    held_equation : Eq
        Motor held at constant speed omega, with kinematic error, exact [N*m]: J_l x'' + B u' + K f(u) = -T_l.
    held_motor_torque : Expr
        Motor torque that holding the speed takes [N*m].
    J, mu, omega_0_squared, F : Expr
        Inertia [kg m^2], damping parameter [1/s], squared natural frequency [rad^2/s^2] and forcing [rad/s^2] of
        `error_equation`.
    F_printed : Expr
        The forcing as the article prints it, without the factor N in front of T_l (erratum E1).
    """

    def explicit(self, expression: Any) -> Any:
        """Replace J, mu, omega_0 and F in an equation or expression by what they stand for."""
        s = self.symbols
        return expression.subs({s.J: self.J, s.mu: self.mu, s.omega_0: sp.sqrt(self.omega_0_squared), s.F: self.F})

    @cached_property
    def cases(self) -> tuple[DerivedCase, ...]:
        """The four cases of multiple scales of `cubic_equation`; computed when they are asked for, in seconds."""
        return cases(self.symbols, self.cubic_equation.lhs)

    @property
    def title(self) -> str:
        """Title of the equations of motion."""
        return "Error equation of a strain wave gear drive"

    @property
    def parts(self) -> tuple[Steps, ...]:
        """The error equation, and the four cases."""
        return (self, *self.cases)

    def rows(self) -> list[Row]:
        """Steps to the error equation."""
        s = self.symbols
        named = {
            "dynamic error": (s.x, s.theta_m / s.N - s.theta_l),
            "kinetic energy": (sp.Symbol("T"), self.kinetic),
            "potential energy": (sp.Symbol("U"), self.potential),
            "dissipation function": (sp.Symbol("D"), self.dissipation),
            "motor": self.motor_equation.args,
            "load": self.load_equation.args,
            "motor free": self.error_equation.args,
            "motor free, cubic": self.cubic_equation.args,
            "inertia": (s.J, self.J),
            "damping": (s.mu, self.mu),
            "natural frequency": (s.omega_0**2, self.omega_0_squared),
            "forcing": (s.F, self.F),
            "forcing as printed": (sp.Symbol("F_printed"), self.F_printed),
            "motor free, e": self.free_equation.args,
            "motor free, e, reduced": self.free_reduced.args,
            "dropped, reaction": (sp.Symbol("d_1"), self.free_dropped[0]),
            "dropped, speed ripple": (sp.Symbol("d_2"), self.free_dropped[1]),
            "motor held, e": self.held_equation.args,
            "motor held, torque": (s.T_m, self.held_motor_torque),
        }
        return [(title, left, "=", right) for title, (left, right) in named.items()]


def _lagrange(s: Symbols, kinetic: Any, potential: Any, dissipation: Any, coordinate: str) -> Any:
    """d/dt dT/dq' - dT/dq + dU/dq + dD/dq' of the coordinate `theta_m` or `theta_l`."""
    q, rate = getattr(s, coordinate), getattr(s, coordinate + "_rate")
    momentum = sp.diff(kinetic, rate)
    states = (s.theta_m, s.theta_l, s.theta_m_rate, s.theta_l_rate)
    rates = (s.theta_m_rate, s.theta_l_rate, s.theta_m_acceleration, s.theta_l_acceleration)
    rise = sum(sp.diff(momentum, state) * its_rate for state, its_rate in zip(states, rates, strict=True))
    return rise - sp.diff(kinetic, q) + sp.diff(potential, q) + sp.factor_terms(sp.diff(dissipation, rate))


def derive() -> Derivation:
    """Derive the error equation of a drive from its energies, symbolically.

    Returns
    -------
    Derivation
        Expressions of SymPy: the equations of motion [N*m], the error equation with the motor free and held
        (`error_equation` [rad/s^2], `free_equation` and `held_equation` [N*m]), and its coefficients J [kg*m^2], mu
        [1/s], `omega_0_squared` [1/s^2]. `str` prints them, `latex()` typesets them.

    Raises
    ------
    ModuleNotFoundError
        If SymPy (the extra `sym`) is not installed.

    References
    ----------
    Corrects the article's F(t): F = T_m/(N J_m) - T_l/J_l (erratum E1).
    """
    s = symbols()
    torsion = s.theta_m / s.N - s.theta_l - s.e(s.theta_m)
    torsion_rate = sp.diff(torsion, s.theta_m) * s.theta_m_rate + sp.diff(torsion, s.theta_l) * s.theta_l_rate
    dummy = sp.Symbol("s", real=True)
    kinetic = s.J_m * s.theta_m_rate**2 / 2 + s.J_l * s.theta_l_rate**2 / 2
    potential = sp.Integral(s.K * s.f(dummy), (dummy, 0, torsion))
    dissipation = s.B * torsion_rate**2 / 2
    motor = sp.Eq(_lagrange(s, kinetic, potential, dissipation, "theta_m"), s.T_m)
    load = sp.Eq(_lagrange(s, kinetic, potential, dissipation, "theta_l"), s.T_l)

    free, load_acceleration, to_error = _error_acceleration(s, motor, load)
    plain = sp.expand(free.subs(s.e, sp.Lambda(dummy, 0)).doit())
    mu = sp.factor(-plain.coeff(s.v))
    omega_0_squared = sp.factor(-plain.coeff(s.f(s.x)))

    # the same with kinematic error: stated in the form of a textbook, and checked against x'' itself
    slope, shape = sp.diff(s.e(s.theta_m), s.theta_m), s.K * s.f(s.x - s.e(s.theta_m))
    exact, steady = [s.B * (s.v - slope * rate) + shape for rate in (s.theta_m_rate, s.omega)]
    reaction = s.J * slope / (s.N * s.J_m) * exact
    hold = {s.theta_m_acceleration: 0, s.theta_m_rate: s.omega}
    result = Derivation(
        s, kinetic, potential, dissipation, motor, load,
        sp.Eq(s.a + s.mu * s.v + s.omega_0**2 * s.f(s.x), s.F),
        sp.Eq(s.a + s.mu * s.v + s.omega_0**2 * (s.x + s.alpha * s.x**3), s.F),
        sp.Eq(s.J * s.a + (1 - s.J * slope / (s.N * s.J_m)) * exact, s.J * s.F), sp.Eq(s.J * s.a + steady, s.J * s.F),
        (-reaction, -s.B * slope * (s.theta_m_rate - s.omega)), sp.Eq(s.J_l * s.a + steady, -s.T_l),
        (1 / s.N - slope) * steady, sp.factor(s.B / mu), mu, omega_0_squared, plain.subs({s.v: 0, s.f(s.x): 0}),
        (s.T_m * s.J_l - s.T_l * s.J_m) / (s.N * s.J_m * s.J_l),
    )  # fmt: skip
    _check(result.explicit(result.error_equation), s.a, plain)
    _check(result.explicit(result.free_equation), s.a, free)
    _check(result.held_equation, s.a, -load_acceleration.subs(hold))
    _check(sp.Eq(result.held_motor_torque, s.T_m), s.T_m, motor.lhs.subs(to_error).subs(hold))
    return result


def _error_acceleration(s: Symbols, motor: Any, load: Any) -> tuple[Any, Any, dict[Any, Any]]:
    """Return x'' and theta_l'' with the motor free, in the coordinates theta_m and x, and the change to them."""
    to_error = {s.theta_l: s.theta_m / s.N - s.x, s.theta_l_rate: s.theta_m_rate / s.N - s.v}
    motor_acceleration = sp.solve(motor, s.theta_m_acceleration)[0].subs(to_error)
    load_acceleration = sp.solve(load, s.theta_l_acceleration)[0].subs(to_error)
    return motor_acceleration / s.N - load_acceleration, load_acceleration, to_error


def _check(equation: Any, unknown: Any, derived: Any) -> None:
    """Refuse an equation whose solution for `unknown` is not what Lagrange's equations gave."""
    stated = sp.solve(equation, unknown)[0]
    if sp.simplify(stated - derived) != 0:
        raise ArithmeticError(f"{equation} does not follow from Lagrange's equations; they give {unknown} = {derived}")
