"""First-order multiple scales: closed forms, averaging integrals, steady states, transients, refusals."""

import math
import re
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.theory.slow_flow.averaging import averaged_flow
from strainwave.theory.slow_flow.closed_forms import CubicFlow, kind_of
from strainwave.theory.slow_flow.setting import setting
from strainwave.theory.slow_flow.states import fixed_points

# OSCILATE's Duffing example (cases T4, T5), and Nayfeh & Mook 1979, sec. 4.1.4 (T7)
T4 = sw.Oscillator(1.0, 0.01, sw.Cubic(1.0, 0.2), sw.Harmonic(0.01), 1.075)
T7 = sw.Oscillator(1.0, 0.01, sw.Cubic(1.0, 0.2), sw.Harmonic(2.0), 3.15)
SUPER = sw.Oscillator(1.0, 0.02, sw.Cubic(1.0, 0.3), sw.Harmonic(0.6, phase=0.4), 0.345)
# a vendor's stiffness (CSF-40-50), kinematic error of order 2 at the wave generator
GEAR = sw.Oscillator(
    0.6030927835, 9.82317898446, sw.PiecewiseLinear(1e5, 1.4e5, 1.8e5, 54.0, 196.0), sw.Harmonic(0.0), 235.0,
    sw.KinematicError((sw.Line(2, 1.1e-4),)),
)  # fmt: skip


class Tanh(NamedTuple):
    """A user's saturating law: only what multiple scales ask for."""

    K: float
    c: float

    def torque(self, x):
        return self.K * np.tanh(self.c * x) / self.c

    def stiffness(self, x):
        return self.K / np.cosh(self.c * x) ** 2


def amplitudes(flow):
    return [state.amplitude for state in flow.steady_states()]


def both_flows(system, resonance):
    s = setting(system, sw.Resonance.of(resonance))
    return CubicFlow(s, kind_of(s)), averaged_flow(s)


CASES = [
    pytest.param(T7._replace(omega=0.2), sw.NONRESONANT, id="non-resonant"),
    pytest.param(T4, sw.PRIMARY, id="primary"),
    pytest.param(SUPER, sw.SUPERHARMONIC, id="superharmonic"),
    pytest.param(T7, sw.SUBHARMONIC, id="subharmonic"),
    pytest.param(
        T7._replace(omega=0.1, excitation=sw.Harmonic(1.0, 2, 0.3)), sw.NONRESONANT, id="non-resonant, order 2"
    ),
    pytest.param(
        T4._replace(omega=0.53, excitation=sw.Harmonic(0.01, 2, 0.7)), sw.Resonance(2, 1), id="primary, order 2"
    ),
    pytest.param(
        SUPER._replace(omega=0.17, excitation=sw.Harmonic(0.6, 2, 0.7)), sw.Resonance(6, 1), id="superharmonic, order 2"
    ),
    pytest.param(
        T7._replace(omega=1.58, excitation=sw.Harmonic(2.0, 2, 0.7)), sw.Resonance(2, 3), id="subharmonic, order 2"
    ),
    pytest.param(
        T7._replace(omega=1.05, excitation=sw.Harmonic(2.0, 3, 0.7)), sw.Resonance(3, 3), id="subharmonic, order 3"
    ),
    pytest.param(
        SUPER._replace(excitation=sw.Harmonic(0.0), error=sw.KinematicError((sw.Line(1, 0.4, 0.2),))),
        sw.SUPERHARMONIC,
        id="superharmonic of a kinematic error",
    ),
]


@pytest.mark.parametrize(("system", "resonance"), CASES)
def test_closed_forms_equal_the_averaging_integrals(system, resonance):
    closed, integral = both_flows(system, resonance)
    z = np.array([0.3 + 0.2j, 1.0 - 2.0j, -0.5j, 0.01 + 0.0j])
    assert np.max(np.abs(closed.rates(z) - integral.rates(z)) / np.abs(closed.rates(z))) < 1e-12
    scale = np.max(np.abs(closed.jacobian(z)))
    assert np.max(np.abs(closed.jacobian(z) - integral.jacobian(z))) < 1e-12 * scale


@pytest.mark.parametrize(("system", "resonance"), CASES[1:])
def test_scan_of_the_plane_finds_the_same_states_as_the_polynomials(system, resonance):
    closed, integral = both_flows(system, resonance)
    expected, found = fixed_points(closed), fixed_points(integral)
    assert [abs(z) for z in found] == pytest.approx([abs(z) for z in expected], rel=1e-9)
    assert np.angle(found) == pytest.approx(np.angle(expected), abs=1e-7)


@pytest.mark.parametrize("omega", [1.0225, 1.03, 1.05, 1.075])
def test_all_three_primary_states_are_found_and_the_middle_one_is_unstable(omega):
    system = T4._replace(omega=omega)
    states = sw.slow_flow(system, sw.PRIMARY).steady_states()
    assert [state.stable for state in states] == [True, False, True]
    for state in states:
        z = state.amplitude * np.exp(-1j * state.phase)
        assert abs(sw.slow_flow(system, sw.PRIMARY).rates(z)) < 1e-14


@pytest.mark.parametrize(
    "law", [sw.Cubic(1.0, 0.2), sw.Polynomial((0.0, 1.0, 0.1, 0.2, 0.05)), Tanh(1.0, 0.7), GEAR.law]
)
def test_jacobian_is_the_derivative_of_the_rates(law):
    scale = 1.0 if law is not GEAR.law else 1e-3
    system = sw.Oscillator(1.0, 0.05, law, sw.Harmonic(0.1 * float(law.stiffness(0.0)) * scale, 1, 0.0, 0.0), 1.0)
    omega = 0.9 * math.sqrt(float(law.stiffness(0.0)))
    flow = averaged_flow(setting(system._replace(omega=omega, B=0.05 * omega), sw.PRIMARY))
    for z in (0.7 * scale * np.exp(0.4j), 1.3 * scale * np.exp(-2.1j)):
        d = 1e-5 * scale
        numeric = [(flow.rates(z + step) - flow.rates(z - step)) / (2.0 * d) for step in (d, 1j * d)]
        matrix = np.array([[numeric[0].real, numeric[1].real], [numeric[0].imag, numeric[1].imag]])
        assert flow.jacobian(z) == pytest.approx(matrix, abs=1e-8 * omega)


def test_polar_form_follows_the_published_equations():
    """a' = -mu a/2 + <N sin eta>/(J omega_0) - <S sin eta>/omega_0; a (Omega - omega_0 - phase') with cos eta."""
    a, phase, omega = 0.8, 0.6, 1.02
    system = sw.Oscillator(2.0, 0.06, sw.Polynomial((0.0, 2.0, 0.3, 0.4)), sw.Harmonic(0.2, 1, 0.5), omega)
    flow = sw.slow_flow(system, sw.PRIMARY)
    theta = np.linspace(0.0, 2.0 * np.pi, 257)[:-1]
    eta = theta - phase
    u = a * np.cos(eta)
    n = system.law.torque(u) - 2.0 * u
    soft = 0.1 * np.cos(theta + 0.5)
    a_rate = -0.5 * 0.03 * a + np.mean(n * np.sin(eta)) / 2.0 - np.mean(soft * np.sin(eta))
    phase_rate = omega - 1.0 - (np.mean(n * np.cos(eta)) / 2.0 - np.mean(soft * np.cos(eta))) / a
    rate = complex(flow.rates(a * np.exp(-1j * phase))) * np.exp(1j * phase)
    assert rate.real == pytest.approx(a_rate, rel=1e-12)
    assert -rate.imag / a == pytest.approx(phase_rate, rel=1e-12)


def test_subharmonic_existence_condition_decides_as_the_states_do():
    for B in (0.01, 0.02, 0.03, 0.05):
        flow = sw.slow_flow(T7._replace(B=B), sw.SUBHARMONIC)
        assert flow.exists() == ("does not exist" not in flow.existence)
        assert flow.exists() == (B < 0.025)  # k C^2 (4 sigma - 7 k C^2) = 5.888e-3 against 9 mu^2
    assert "5.88837e-05" not in flow.existence
    assert "0.00588837 against 0.0225" in flow.existence


def test_existence_says_the_least_and_the_largest_excitation():
    """At the ends that it names two states merge: none just outside, two just inside."""
    said = sw.slow_flow(T7, sw.SUBHARMONIC).existence
    least, largest = map(float, re.search(r"it takes ([\d.e-]+) to ([\d.e-]+) times this excitation", said).groups())
    assert "sigma = omega - 3 omega_0" in said
    amounts = map(float, re.search(r"an amplitude of ([\d.e-]+) to ([\d.e-]+) N\*m", said).groups())
    assert list(amounts) == pytest.approx([2.0 * least, 2.0 * largest], rel=1e-5)
    for factor, exists in (
        (0.99 * least, False),
        (1.01 * least, True),
        (0.99 * largest, True),
        (1.01 * largest, False),
    ):
        assert sw.slow_flow(T7._replace(excitation=sw.Harmonic(2.0 * factor)), sw.SUBHARMONIC).exists() is exists


@pytest.mark.parametrize(("alpha", "side"), [(0.2, 1.0), (-0.2, -1.0)])
def test_existence_says_the_detuning_below_which_no_excitation_gives_a_subharmonic(alpha, side):
    """It is 3/2 sqrt 7 mu, where 7 y^2 - 4 sigma y + 9 mu^2 has a double root y = k C^2 = 2 sigma/7."""
    mu, least = 0.01, 1.5 * math.sqrt(7.0) * 0.01
    for factor, can in ((0.999, False), (1.001, True)):
        sigma = side * factor * least
        C = math.sqrt(2.0 * sigma / 7.0 / (9.0 / 8.0 * alpha))  # the most favourable one
        forcing = sw.Harmonic(C * ((3.0 + sigma) ** 2 - 1.0))
        flow = sw.slow_flow(sw.Oscillator(1.0, mu, sw.Cubic(1.0, alpha), forcing, 3.0 + sigma), sw.SUBHARMONIC)
        assert flow.exists() is can
        assert ("no excitation gives it" in flow.existence) is not can
        if not can:  # at the double root C is that of this excitation, at a speed 1 per mille of sigma away
            times = float(re.search(r"and there ([\d.e-]+) times this excitation", flow.existence).group(1))
            assert times == pytest.approx(1.0, abs=1e-3)
        assert (f"sigma {'>= ' if alpha > 0.0 else '<= -'}{least:.6g}" in flow.existence) is not can


def test_resonances_on_the_base_angle_are_the_same_for_every_order_of_the_line():
    once = sw.slow_flow(T7, sw.SUBHARMONIC)
    thrice = sw.slow_flow(T7._replace(omega=1.05, excitation=sw.Harmonic(2.0, 3)), sw.Resonance(1, 1))
    assert amplitudes(once) == pytest.approx(amplitudes(thrice), rel=1e-12)


def test_mean_torque_moves_the_operating_point():
    """At u0 the cubic law is T(u0) + T'(u0) w + 3 K alpha u0 w^2 + K alpha w^3."""
    law = sw.Cubic(1.0, 0.3)
    flow = sw.slow_flow(sw.Oscillator(1.0, 0.02, law, sw.Harmonic(0.02, 1, 0.0, 0.5), 1.05), sw.PRIMARY)
    u0 = flow.mean_torsion
    assert law.torque(u0) == pytest.approx(0.5, rel=1e-14)
    assert flow.omega_0 == pytest.approx(math.sqrt(1.0 + 0.9 * u0**2), rel=1e-14)
    shifted = sw.Polynomial((0.0, law.stiffness(u0), 3.0 * 0.3 * u0, 0.3))
    same = sw.slow_flow(sw.Oscillator(1.0, 0.02, shifted, sw.Harmonic(0.02), 1.05), sw.PRIMARY)
    assert amplitudes(flow) == pytest.approx(amplitudes(same), rel=1e-10)


def test_quadratic_law_has_the_two_to_one_superharmonic_of_its_text_book_formula():
    """Nayfeh & Mook 1979, sec. 4.2: T = K (x + c x^2) drives 2 omega by c omega_0^2 C^2/2."""
    c, A, B, omega = 0.3, 0.3, 0.02, 0.503
    flow = sw.slow_flow(sw.Oscillator(1.0, B, sw.Polynomial((0.0, 1.0, c)), sw.Harmonic(A), omega), sw.Resonance(2, 1))
    C = A / (1.0 - omega**2)
    expected = 0.25 * c * C**2 / math.hypot(0.5 * B, 2.0 * omega - 1.0)
    assert amplitudes(flow) == pytest.approx([expected], rel=1e-10)


def test_law_of_a_user_needs_torque_and_stiffness_only():
    flow = sw.slow_flow(sw.Oscillator(1.0, 0.05, Tanh(1.0, 0.2), sw.Harmonic(0.05), 0.99), sw.PRIMARY)
    # tanh(c x)/c = x - c^2 x^3/3 + 2 c^4 x^5/15: a cubic with alpha = -c^2/3 to leading order
    cubic = sw.slow_flow(sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, -0.04 / 3.0), sw.Harmonic(0.05), 0.99), sw.PRIMARY)
    assert amplitudes(flow) == pytest.approx(amplitudes(cubic), rel=2e-3)
    assert amplitudes(flow) != pytest.approx(amplitudes(cubic), rel=1e-6)


def test_gear_with_kinematic_error_has_three_states_between_its_folds():
    """T19's drive at 235 rad/s: exact orbits have u peaks .00236525 stable, .00174831 unstable, .00043690 stable."""
    states = sw.slow_flow(GEAR, sw.Resonance(2, 1)).steady_states()
    assert [state.stable for state in states] == [True, False, True]
    assert [state.amplitude for state in states] == pytest.approx([0.00236525, 0.00174831, 0.00043690], rel=0.2)


def test_averages_of_a_gear_have_no_quadrature_error():
    """Kinks cost the trapezoid rule about 1e-7 at 4096 points; the exact means are those of infinitely many."""
    flow = sw.slow_flow(GEAR, sw.Resonance(2, 1))
    assert flow.certificate().quadrature_error == 0.0
    z, law = 2e-3 * np.exp(0.7j), GEAR.law
    psi = 2.0 * np.pi * (np.arange(1 << 20) + 0.5) / (1 << 20)
    beyond = law.torque((z * np.exp(1j * psi)).real) - law.K1 * (z * np.exp(1j * psi)).real
    soft = (2.0 * GEAR.omega) ** 2 * 1.1e-4
    pull = np.mean(beyond * np.exp(-1j * psi)) / GEAR.J - 0.5 * soft
    expected = -(0.5 * flow.mu + 1j * (2.0 * GEAR.omega - flow.omega_0)) * z + 1j * pull / flow.omega_0
    assert complex(flow.rates(z)) == pytest.approx(expected, rel=1e-10)


def test_backbone_of_the_cubic_law_is_its_parabola():
    a = np.array([0.0, 0.1, 0.5, 1.0])
    assert sw.slow_flow(T4, sw.PRIMARY).backbone(a) == pytest.approx(1.0 + 0.075 * a**2, rel=1e-13)


def test_backbone_of_a_gear_leaves_omega_0_at_the_first_breakpoint():
    flow = sw.slow_flow(GEAR, sw.Resonance(2, 1))
    first = 54.0 / 1e5
    low, high = flow.backbone([0.99 * first, 1.2 * first])
    assert low == pytest.approx(flow.omega_0, rel=1e-14)
    assert high > flow.omega_0 * 1.001


@pytest.mark.parametrize(("system", "resonance"), CASES)
def test_transient_starts_from_the_physical_state(system, resonance):
    evolution = sw.slow_flow(system, resonance).evolve((0.1, -0.03), [1.7, 2.0])
    assert evolution.x[0] == pytest.approx(0.1, abs=1e-13)
    assert evolution.rate[0] == pytest.approx(-0.03, abs=1e-12)


@pytest.mark.parametrize(("system", "resonance"), CASES)
def test_rate_of_a_transient_is_the_derivative_of_x(system, resonance):
    t = np.linspace(0.0, 3.0, 3001)
    evolution = sw.slow_flow(system, resonance).evolve((0.1, 0.0), t)
    numeric = (evolution.x[2:] - evolution.x[:-2]) / (t[2:] - t[:-2])
    assert evolution.rate[1:-1] == pytest.approx(numeric, abs=1e-5)


def test_transient_settles_on_a_stable_steady_state():
    flow = sw.slow_flow(T4._replace(B=0.1, excitation=sw.Harmonic(0.1)), sw.PRIMARY)
    evolution = flow.evolve((0.0, 0.0), np.linspace(0.0, 600.0, 601))
    best = min(flow.steady_states(), key=lambda state: abs(state.amplitude - evolution.amplitude[-1]))
    assert best.stable
    assert evolution.amplitude[-1] == pytest.approx(best.amplitude, rel=1e-9)
    assert np.exp(1j * evolution.phase[-1]) == pytest.approx(np.exp(1j * best.phase), abs=1e-8)


@pytest.mark.parametrize("start", [(0.0, 0.0), (1.2, 0.0)])
def test_attractor_is_where_the_transient_ends(start):
    flow = sw.slow_flow(T4._replace(B=0.1, excitation=sw.Harmonic(0.1)), sw.PRIMARY)
    t = np.linspace(0.0, 600.0, 20001)
    run = flow.evolve(start, t)
    at = int(np.searchsorted(t, 50.0))  # exp(-mu t/2) = 8 % of the transient are left
    z = flow.attractor(run.amplitude[at] * np.exp(-1j * run.phase[at]))
    assert z is not None
    assert flow.steady_x(z, t[-100:]) == pytest.approx(run.x[-100:], abs=1e-8)


def test_attractor_of_an_undamped_or_undecided_transient_is_not_claimed():
    bistable = sw.slow_flow(T4, sw.PRIMARY)
    (upper, *_, lower) = [s.amplitude * np.exp(-1j * s.phase) for s in bistable.steady_states()]
    assert bistable.attractor(upper) == pytest.approx(upper, rel=1e-12)
    assert bistable.attractor(lower) == pytest.approx(lower, rel=1e-12)
    assert bistable.attractor(0.5 * (upper + lower)) is None
    assert sw.slow_flow(T4._replace(B=0.0, omega=0.5), sw.NONRESONANT).attractor(0.1 + 0j) is None


def test_free_vibration_decays_and_drifts_as_e3_says():
    system = sw.Oscillator(1.0, 0.02, sw.Cubic(1.0, 0.1), sw.Harmonic(0.0), 1.0)
    t = np.linspace(0.0, 100.0, 201)
    evolution = sw.slow_flow(system, sw.NONRESONANT).evolve((0.5, 0.0), t)
    a0 = evolution.amplitude[0]
    assert evolution.amplitude == pytest.approx(a0 * np.exp(-0.01 * t), rel=1e-12)
    drift = 0.0375 * a0**2 * (1.0 - np.exp(-0.02 * t)) / 0.02  # integral of 3/8 alpha omega_0 a^2
    assert evolution.phase - evolution.phase[0] == pytest.approx(-drift, abs=1e-9)


def test_x_starts_at_time_zero_whatever_the_first_sample():
    flow = sw.slow_flow(T4, sw.PRIMARY)
    t = np.linspace(0.0, 20.0, 11)
    assert flow.x(t[3:], (0.1, 0.0)) == pytest.approx(flow.x(t, (0.1, 0.0))[3:], rel=1e-8)
    assert float(flow.x(20.0, (0.1, 0.0))) == pytest.approx(flow.x(t, (0.1, 0.0))[-1], rel=1e-8)
    assert flow.x(0.0, (0.1, 0.0)) == 0.1


def transient_error(epsilon, resonance):
    """Largest error over a time 2/epsilon, relative to the largest |x|; mu, alpha, soft forcing of order epsilon."""
    near = 1.0 + 0.2 * epsilon
    omega, A = (near, 0.5 * epsilon) if resonance == sw.PRIMARY else (near / 3.0, 0.6)
    system = sw.Oscillator(1.0, epsilon, sw.Cubic(1.0, epsilon), sw.Harmonic(A), omega)
    t = np.linspace(0.0, 2.0 / epsilon, 2000)
    span, start = (0.0, t[-1]), (0.3, 0.0)
    exact = solve_ivp(lambda s, y: system.rhs(omega * s, y), span, start, "DOP853", t, rtol=1e-9, atol=1e-12).y[0]
    return np.max(np.abs(sw.slow_flow(system, resonance).x(t, (0.3, 0.0)) - exact)) / np.max(np.abs(exact))


@pytest.mark.parametrize("resonance", [sw.PRIMARY, sw.SUPERHARMONIC])
def test_error_of_the_transient_falls_with_epsilon(resonance):
    epsilons = 0.16 * 0.5 ** np.arange(5)  # more than a decade
    errors = [transient_error(float(e), resonance) for e in epsilons]
    slope = np.polyfit(np.log(epsilons), np.log(errors), 1)[0]
    assert slope > 0.95
    assert errors[-1] < 0.02


@given(st.floats(0.2, 5.0), st.floats(0.3, 3.0))
def test_scaling_angle_and_time_changes_nothing_but_the_units(angle, time):
    """x = angle X and t = T/time: J, K, alpha and the forcing follow; amplitudes scale with the angle."""
    system = T4._replace(omega=1.05)
    law = sw.Cubic(time**2, 0.2 / angle**2)
    scaled = sw.Oscillator(1.0, 0.01 * time, law, sw.Harmonic(0.01 * angle * time**2), 1.05 * time)
    expected = [angle * a for a in amplitudes(sw.slow_flow(system, sw.PRIMARY))]
    assert amplitudes(sw.slow_flow(scaled, sw.PRIMARY)) == pytest.approx(expected, rel=1e-9)


def test_without_damping_at_a_linear_resonance_a_sentence_says_so():
    flow = sw.slow_flow(sw.Oscillator(1.0, 0.0, sw.Linear(1.0), sw.Harmonic(0.5), 1.0), sw.PRIMARY)
    with pytest.raises(sw.SolveError, match="without damping the amplitude grows without bound"):
        flow.steady_states()
    grown = flow.evolve((0.0, 0.0), np.linspace(0.0, 50.0, 101))
    assert grown.amplitude[-1] == pytest.approx(0.25 * 50.0, rel=0.03)  # f t/(2 omega_0)


def test_undamped_states_are_not_called_stable():
    states = sw.slow_flow(T4._replace(B=0.0, omega=1.1), sw.PRIMARY).steady_states()
    assert [state.stable for state in states] == [False, False, False]


@pytest.mark.parametrize(
    ("system", "resonance", "words"),
    [
        (
            T4,
            sw.Resonance(2, 1),
            "2:1 resonance does not appear at first order .* Resonance\\(1, 1\\), Resonance\\(3, 1\\)",
        ),
        (T4._replace(excitation=sw.Harmonic(0.0)), sw.PRIMARY, "no line; use NONRESONANT"),
        (T4._replace(law=sw.Linear(1.0)), sw.SUPERHARMONIC, "does not appear at first order"),
        (T4._replace(law=sw.Polynomial((0.0, -1.0))), sw.PRIMARY, "omega_0 is undefined.*add a mean torque"),
        (T4._replace(omega=1.0), sw.SUPERHARMONIC, "line of order 1 sits on omega_0.*Resonance\\(1, 1\\)"),
        (T4._replace(omega=0.5, excitation=sw.Harmonic(1.0, 2)), sw.NONRESONANT, "line of order 2 sits on omega_0"),
        (
            T4._replace(law=sw.Cubic(1.0, -0.2), excitation=sw.Harmonic(0.1, mean=5.0)),
            sw.PRIMARY,
            "carries at most 0.8606",
        ),
        (T4._replace(J=0.0), sw.PRIMARY, "J is 0 kg.* an inertia must be positive"),
        (T4._replace(B=math.nan), sw.PRIMARY, "B is nan; it must be finite"),
        (T4, sw.Resonance(0, 1), "two positive integers"),
        (T4, sw.Resonance(1, -3), "two positive integers"),
    ],
)
def test_what_first_order_does_not_know_is_refused_with_a_remedy(system, resonance, words):
    with pytest.raises(ValueError, match=words):
        sw.slow_flow(system, resonance)


def test_other_orders_and_bad_requests_are_refused():
    with pytest.raises(ValueError, match="give 1 or 2"):
        sw.slow_flow(T4, sw.PRIMARY, order=3)
    flow = sw.slow_flow(T4, sw.PRIMARY)
    with pytest.raises(ValueError, match="2 finite numbers"):
        flow.evolve((0.0, math.nan), 1.0)
    with pytest.raises(ValueError, match="increasing"):
        flow.evolve((0.0, 0.0), [1.0, 0.5])
    with pytest.raises(ValueError, match="low < high"):
        flow.response((2.0, 1.0))
    with pytest.raises(ValueError, match=r"the band \[rad/s\] is .*; it must be two finite numbers"):
        flow.response((math.nan, 2.0))
    with pytest.raises(ValueError, match="samples; name the times, or an earlier end"):
        flow.evolve((0.0, 0.0), 1e50)
    with pytest.raises(ValueError, match="must be 2 finite numbers"):
        flow.x(0.0, (math.nan, 1.0))


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"J": 1e300}, r"Oscillator\.J is 1e\+300; it must not exceed 1e\+60"),
        ({"J": 1e-300}, r"Oscillator\.J is 1e-300 .* 1e-60 up"),
        ({"B": 1e300}, r"Oscillator\.B is 1e\+300; it must not exceed 1e\+60"),
        ({"J": 1e-55, "law.K": 1e55}, r"omega_0 \[rad/s\] is 1e\+55, outside the supported range; check the units"),
        ({"law.alpha": 1e50}, "the torque at 0.18 rad over its linear part is .*, outside the supported range"),
        ({"excitation.amplitude": 1e-50}, r"the soft line over omega_0\^2 \[rad\] is 1e-50"),
    ],
)
def test_sizes_that_no_float_bears_are_refused_with_the_quantity(changes, sentence):
    with pytest.raises(ValueError, match=sentence):
        sw.slow_flow(sw.replaced(T4, {"excitation.amplitude": 0.18, "law.K": 1.0, "J": 1.0} | changes), sw.PRIMARY)


@pytest.mark.parametrize("law", [sw.Cubic(1.0, 0.1), sw.Polynomial((0.0, 1.0, 0.0, 0.1))], ids=["closed", "averaged"])
def test_rest_is_no_steady_state_of_a_driven_resonance_however_small_the_damping(law):
    """The amplitude f/(mu omega_0) that sets a scale grows without bound as mu falls; rest must not hide under it."""
    system = sw.Oscillator(1.0, 1e-14, law, sw.Harmonic(0.18), 1.0)
    assert all(state.amplitude > 0.1 for state in sw.slow_flow(system, sw.PRIMARY).steady_states())


def test_a_cubic_term_below_rounding_leaves_the_linear_response():
    system = sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, 1e-40), sw.Harmonic(0.18), 1.3)
    (state,) = sw.slow_flow(system, sw.PRIMARY).steady_states()
    assert state.amplitude == pytest.approx(0.09 / math.hypot(0.025, 0.3), rel=1e-12)


def test_lines_of_a_high_order_stay_alone():
    system = sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, 0.1), sw.Harmonic(0.1, order=1000), 8e-4)
    assert sw.slow_flow(system, sw.Resonance(1000, 1)).closed_form  # serves one line only


def test_a_resonance_of_very_high_order_is_refused():
    with pytest.raises(ValueError, match="has the harmonic 1000000 of the common period"):
        sw.slow_flow(T4, sw.Resonance(10**6, 1))


def test_backlash_under_a_mean_torque_is_a_spring_until_it_opens():
    system = sw.Oscillator(1.0, 0.1, sw.Backlash(1.0, 0.5), sw.Harmonic(0.05, mean=0.6), 0.9)
    flow = sw.slow_flow(system, sw.PRIMARY)
    assert flow.mean_torsion == pytest.approx(1.1, rel=1e-13)
    # at first order the amplitude of a linear oscillator: f/2/hypot(mu/2, detuning)
    assert amplitudes(flow) == pytest.approx([0.025 / math.hypot(0.05, 0.1)], rel=1e-9)
