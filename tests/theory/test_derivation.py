"""The symbolic derivation is the numerical model: the library's own `rhs` is run on SymPy symbols and compared."""

from typing import Any, NamedTuple

import numpy as np
import pytest
import sympy as sp

import strainwave as sw
from strainwave.model.orders import MEMBERS
from strainwave.theory.derivation.steps import symbols


@pytest.fixture(scope="module")
def derived():
    return sw.theory.derive()


@pytest.fixture(scope="module")
def s(derived):
    return derived.symbols


def law_of(name, s):
    c2, c3 = sp.symbols("c_2 c_3", real=True)
    return {"cubic": sw.Cubic(s.K, s.alpha), "polynomial": sw.Polynomial((0, s.K, c2, c3))}[name]


def difference(equation, derived, law, values, system):
    """The acceleration by `equation` less the one by `system.rhs`, both on symbols."""
    s = derived.symbols
    acceleration = sp.solve(derived.explicit(equation), s.a)[0]
    error = system.error.value(s.theta_m)
    slope = sp.diff(s.e(s.theta_m), s.theta_m)
    acceleration = acceleration.subs(slope, system.error.slope(s.theta_m))
    acceleration = acceleration.replace(s.f, lambda u: law.torque(u) / s.K).subs(s.e(s.theta_m), error).subs(values)
    _, by_model = system.rhs(s.theta_m, (s.x, s.v))
    return sp.simplify(sp.nsimplify(acceleration - by_model))


@pytest.mark.parametrize("name", ["cubic", "polynomial"])
def test_free_motor_equation_is_what_the_numerical_model_integrates(derived, s, name):
    a, b, mean = sp.symbols("a b c", real=True)
    motor, load = sw.Harmonic(a, 1, 0, mean), sw.Harmonic(b, 2, s.alpha)
    law = law_of(name, s)
    drive = sw.Drive(s.J_m, s.J_l, s.N, s.B, law)
    system = drive.error_equation(motor_torque=motor, load_torque=load, omega=s.omega)
    torques = {s.T_m: motor.torque(s.theta_m), s.T_l: load.torque(s.theta_m)}
    assert difference(derived.error_equation, derived, law, torques, system) == 0
    # the comparison sees an error: without the load torque it fails
    assert difference(derived.error_equation, derived, law, torques | {s.T_l: 0}, system) != 0


def test_cubic_equation_is_the_general_one_with_the_cubic_law(derived, s):
    general = derived.error_equation.replace(s.f, lambda u: u + s.alpha * u**3)
    assert sp.simplify(general.lhs - derived.cubic_equation.lhs) == 0
    assert general.rhs == derived.cubic_equation.rhs


@pytest.mark.parametrize("name", ["cubic", "polynomial"])
def test_held_motor_equation_with_kinematic_error_is_what_the_numerical_model_integrates(derived, s, name):
    a, b, phase = sp.symbols("a b phi", real=True)
    load, error = sw.Harmonic(b, 1, phase, s.alpha), sw.KinematicError((sw.Line(2, a, phase), sw.Line(4, b)))
    law = law_of(name, s)
    drive = sw.Drive(s.J_m, s.J_l, s.N, s.B, law)
    system = drive.error_equation(load_torque=load, kinematic_error=error, omega=s.omega, motor="held")
    assert difference(derived.held_equation, derived, law, {s.T_l: load.torque(s.theta_m)}, system) == 0
    # the comparison sees an error: the inertia of the free motor is another one
    assert difference(derived.held_equation, derived, law, {s.T_l: 0}, system) != 0


def test_free_motor_equation_with_kinematic_error_drops_the_named_terms_and_no_other(derived, s):
    a, b = sp.symbols("a b", real=True)
    law = law_of("cubic", s)
    error, motor = sw.KinematicError((sw.Line(2, a),)), sw.Harmonic(b)
    drive = sw.Drive(s.J_m, s.J_l, s.N, s.B, law)
    system = drive.error_equation(motor_torque=motor, kinematic_error=error, omega=s.omega)
    torques = {s.T_m: motor.torque(s.theta_m), s.T_l: 0}
    assert difference(derived.free_reduced, derived, law, torques, system) == 0
    left_out = derived.free_equation.lhs - derived.free_reduced.lhs
    assert sp.simplify(left_out - sum(derived.free_dropped)) == 0
    assert all(sp.simplify(term) != 0 for term in derived.free_dropped)


def test_dropped_reaction_of_the_motor_is_of_order_n_times_the_error_slope(derived, s):
    slope = sp.diff(s.e(s.theta_m), s.theta_m)
    share = sp.simplify(derived.explicit(-derived.free_dropped[0] / (s.J * slope)) * derived.J)
    spring = s.B * (s.v - slope * s.theta_m_rate) + s.K * s.f(s.x - s.e(s.theta_m))
    assert sp.simplify(share / spring - s.N * s.J_l / (s.N**2 * s.J_m + s.J_l)) == 0


def test_exact_free_equation_without_error_is_the_error_equation(derived, s):
    without = derived.free_equation.subs(s.e, sp.Lambda(s.x, 0)).doit()
    acceleration = sp.solve(derived.explicit(without), s.a)[0]
    assert sp.simplify(acceleration - sp.solve(derived.explicit(derived.error_equation), s.a)[0]) == 0


def test_coefficients_are_those_of_the_drive(derived, s):
    drive = sw.Drive(s.J_m, s.J_l, s.N, s.B, sw.Linear(s.K))
    assert sp.simplify(derived.J - drive.J) == 0
    assert sp.simplify(derived.mu - drive.mu) == 0
    assert sp.simplify(derived.omega_0_squared - s.K / drive.J) == 0


def test_lagrange_gives_the_printed_equations_of_motion(derived, s):
    # the article: J_m theta_m'' + (K f + B x')/N = T_m, J_l theta_l'' - K f - B x' = T_l (no kinematic error)
    x, v = s.theta_m / s.N - s.theta_l, s.theta_m_rate / s.N - s.theta_l_rate
    spring = s.K * s.f(x) + s.B * v
    no_error = {s.e: sp.Lambda(s.x, 0)}
    motor, load = (side.lhs.subs(no_error).doit() for side in (derived.motor_equation, derived.load_equation))
    assert sp.simplify(motor - (s.J_m * s.theta_m_acceleration + spring / s.N)) == 0
    assert sp.simplify(load - (s.J_l * s.theta_l_acceleration - spring)) == 0
    assert (derived.motor_equation.rhs, derived.load_equation.rhs) == (s.T_m, s.T_l)


def test_energy_balance_of_the_equations_of_motion(derived, s):
    """Torques times speeds are the change of both energies plus the loss 2 D, with kinematic error too."""
    states = (s.theta_m, s.theta_l, s.theta_m_rate, s.theta_l_rate)
    rates = (s.theta_m_rate, s.theta_l_rate, s.theta_m_acceleration, s.theta_l_acceleration)
    energy = derived.kinetic + derived.potential
    change = sum(sp.diff(energy, state) * rate for state, rate in zip(states, rates, strict=True))
    power = derived.motor_equation.lhs * s.theta_m_rate + derived.load_equation.lhs * s.theta_l_rate
    assert sp.simplify(power - change - 2 * derived.dissipation) == 0


def test_holding_torque_carries_the_spring_torque_through_the_ratio(derived, s):
    rest = {s.omega: 0, s.v: 0}
    static = derived.held_motor_torque.subs(s.e, sp.Lambda(s.x, 0)).doit().subs(rest)
    assert sp.simplify(static - s.K * s.f(s.x) / s.N) == 0


def test_latex_contains_every_symbol(derived):
    tex = derived.aligned()
    assert tex.startswith(r"\begin{aligned}")
    marks = (
        r"\ddot{x}",
        r"\dot{x}",
        r"\ddot{\theta}_m",
        r"\ddot{\theta}_l",
        r"\mu",
        r"\omega_{0}^{2}",
        r"\alpha x^{3}",
    )
    marks += ("J_{m}", "J_{l}", "N", "B", "K", "T_{m}", "T_{l}", r"f{\left(x \right)}", r"e'(\theta_m)", r"\int")
    assert [mark for mark in marks if mark not in tex] == []
    assert tex.count(r"\left") == tex.count(r"\right")
    assert "'" not in tex.replace(r"e'(\theta_m)", "")


class ArrangedEquations(NamedTuple):
    """Equations of a gear whose members are arranged in one way, all angles and torques in the motor's sense."""

    symbols: Any
    ratio: Any
    torsion: Any
    T: Any
    T_f: Any
    motor: Any
    load: Any
    reaction: Any


def derive_arrangement(arrangement):
    """Derive what a gear does to motor, load and housing, from its teeth and d'Alembert's principle.

    The teeth tie the turns of the members, z1 (w_fs - w_wg) = z2 (w_cs - w_wg), the fixed one's among them, which a
    torque T_f from the housing holds. The torque T in the gear does the virtual work -T du.
    """
    s = symbols()
    T, T_f, theta_f = sp.symbols("T T_f theta_f", real=True)
    angles = {arrangement.driven: s.theta_m, arrangement.fixed: theta_f, arrangement.output: sp.Symbol("theta_o")}
    wave, flex, circular = [angles[member] for member in MEMBERS]
    teeth = sp.Eq(2 * s.N * (flex - wave), (2 * s.N + 2) * (circular - wave))
    rigid = sp.solve(teeth, angles[arrangement.output])[0]
    torsion = rigid - s.theta_l - s.e(s.theta_m - theta_f)
    held = {theta_f: 0}
    by_motor = sp.factor(sp.diff(torsion, s.theta_m).subs(held).doit())
    by_housing = sp.factor(sp.diff(torsion, theta_f).subs(held).doit())
    return ArrangedEquations(
        s, sp.factor(1 / sp.diff(rigid, s.theta_m)), torsion.subs(held), T, T_f,
        sp.Eq(s.J_m * s.theta_m_acceleration + by_motor * T, s.T_m), sp.Eq(s.J_l * s.theta_l_acceleration - T, s.T_l),
        sp.Eq(by_housing * T, T_f),
    )  # fmt: skip


ARRANGEMENTS = {
    # fixed, output: u, the torques of T on the motor and of the housing, written by hand
    ("circular spline", "flexspline"): lambda N, m, e, de: (-m / N - e, -1 / N - de, 1 + 1 / N + de),
    ("flexspline", "circular spline"): lambda N, m, e, de: (m / (N + 1) - e, 1 / (N + 1) - de, N / (N + 1) + de),
    ("wave generator", "circular spline"): lambda N, m, e, de: (
        N * m / (N + 1) - e,
        N / (N + 1) - de,
        1 / (N + 1) + de,
    ),
    ("wave generator", "flexspline"): lambda N, m, e, de: ((N + 1) * m / N - e, (N + 1) / N - de, -1 / N + de),
    ("circular spline", "wave generator"): lambda N, m, e, de: (-N * m - e, -N - de, 1 + N + de),
    ("flexspline", "wave generator"): lambda N, m, e, de: ((N + 1) * m - e, N + 1 - de, -N + de),
}


@pytest.mark.parametrize(("members", "by_hand"), ARRANGEMENTS.items(), ids=map(" - ".join, ARRANGEMENTS))
def test_the_equations_of_an_arrangement_are_those_written_by_hand(members, by_hand):
    arrangement = sw.gears.Arrangement(*members)
    found = derive_arrangement(arrangement)
    s, e = found.symbols, found.symbols.e(found.symbols.theta_m)
    u, on_motor, of_housing = by_hand(s.N, s.theta_m, e, sp.diff(e, s.theta_m))
    pairs = (
        (found.torsion, u - s.theta_l),
        (found.motor.lhs, s.J_m * s.theta_m_acceleration + on_motor * found.T),
        (found.load.lhs, s.J_l * s.theta_l_acceleration - found.T),
        (found.reaction.lhs, of_housing * found.T),
    )
    for own, other in pairs:
        assert sp.simplify(own - other) == 0
    assert found.ratio.subs(s.N, 50) == sp.Rational(*arrangement.ratio(50).as_integer_ratio())
    rigid = found.reaction.lhs.subs(e, 0).doit().subs({s.N: 50, found.T: 1})
    # what the housing holds is what the gear puts on the fixed member
    assert rigid == -sp.Rational(*arrangement.torques(50)[arrangement.fixed].as_integer_ratio())


@pytest.mark.parametrize("members", ARRANGEMENTS, ids=map(" - ".join, ARRANGEMENTS))
def test_power_and_angular_momentum_of_an_arrangement_are_in_balance(members):
    found = derive_arrangement(sw.gears.Arrangement(*members))
    s, N, J_m, J_l, K, B = found.symbols, 50, 2e-4, 1.3, 2e4, 15.0
    e = 1e-4 * sp.cos(2 * s.theta_m + 0.3)
    torsion = found.torsion.subs(s.e(s.theta_m), e).subs(s.N, N)
    rate = sp.diff(torsion, s.theta_m) * s.theta_m_rate + sp.diff(torsion, s.theta_l) * s.theta_l_rate
    T = K * torsion + B * rate
    values = {found.T: T, s.N: N, s.J_m: J_m, s.J_l: J_l, s.T_m: 0.4, s.T_l: -7}
    own = [s.theta_m, s.theta_l, s.theta_m_rate, s.theta_l_rate]
    accelerations = [
        sp.solve(equation.subs(s.e(s.theta_m), e).doit().subs(values), a)[0]
        for equation, a in ((found.motor, s.theta_m_acceleration), (found.load, s.theta_l_acceleration))
    ]
    reaction = found.reaction.lhs.subs(s.e(s.theta_m), e).doit().subs(values)
    rng = np.random.default_rng(38)
    numbers = sp.lambdify(own, [*accelerations, reaction, T, torsion, rate])
    for m, load, w_m, w_l in rng.normal(size=(20, 4)) * [1.0, 1e-3, 60.0, 1.0]:
        a_m, a_l, T_f, through, u, du = numbers(m, load, w_m, w_l)
        change = J_m * w_m * a_m + J_l * w_l * a_l + K * u * du  # of the energies
        scale = abs(through * du) + abs(0.4 * w_m) + abs(7 * w_l)
        assert abs(0.4 * w_m - 7 * w_l - change - B * du * du) < 1e-9 * scale
        assert abs(0.4 - 7 + T_f - J_m * a_m - J_l * a_l) < 1e-9 * (abs(through) + 7)
