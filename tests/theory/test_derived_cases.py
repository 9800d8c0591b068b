"""The four cases that SymPy derives are the closed forms that run, the corrected formulas and the true motion."""

from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve
from second_order_form import second_order_form

import strainwave as sw
from strainwave.theory.slow_flow.closed_forms import CubicFlow

CASES = {"none": 0, "primary": 1, "superharmonic": 2, "subharmonic": 3}
DRIVEN = tuple(CASES)[1:]


@pytest.fixture(scope="module")
def derived():
    found = sw.theory.derive()
    assert len(found.cases) == 4  # derived here, once
    return found


@pytest.fixture(scope="module")
def s(derived):
    return derived.symbols


def turns(case, s):
    """Phase of z = a exp(-i phase), and what its rate is."""
    q = case.resonance.q
    return (s.phase / q, case.phase_rate / q) if q else (-s.beta, -case.phase_rate)


@pytest.mark.parametrize("kind", CASES)
def test_the_derived_rates_are_the_closed_form_itself_run_on_symbols(derived, s, kind):
    case = derived.cases[CASES[kind]]
    q = case.resonance.q
    fast = (q * s.omega_0 + s.sigma) / q if q else s.omega_0  # p omega/q
    forced = np.array([s.C if kind != "primary" else 0], dtype=object)
    law = sw.Cubic(s.K, s.alpha)
    setting = SimpleNamespace(
        mu=s.mu, omega_0=s.omega_0, fast=fast, soft=s.soft, hard=forced, system=SimpleNamespace(law=law)
    )
    phase, rate = turns(case, s)
    z = s.amplitude * sp.exp(-sp.I * phase)
    by_closed_form = sp.nsimplify(sp.sympify(CubicFlow(setting, kind).rates(z)), rational=True)
    by_derivation = (case.amplitude_rate - sp.I * s.amplitude * rate) * sp.exp(-sp.I * phase)
    off = sp.expand_complex(sp.expand((by_closed_form - by_derivation) * sp.exp(sp.I * phase)))
    assert sp.simplify(off) == 0


@pytest.mark.parametrize("kind", CASES)
def test_the_secular_terms_of_the_cube_are_those_of_its_harmonics(derived, s, kind):
    """Other algebra: the cube as a polynomial in the rotations of z and C, as for the second order."""
    case = derived.cases[CASES[kind]]
    form = second_order_form(case.resonance.ratio)
    c2, c3, z, z_bar, c, c_bar = form.symbols
    phase, _ = turns(case, s)
    wave = s.amplitude * sp.exp(-sp.I * phase)
    values = {c2: 0, c3: s.alpha * s.omega_0**2, z: wave, z_bar: sp.conjugate(wave), c: s.C, c_bar: s.C}
    cube = -form.on_fast.subs(values) / 2 * sp.exp(sp.I * phase)
    linear = {s.alpha: 0} if kind != "primary" else {s.alpha: 0, s.soft: 0}
    beta = (s.sigma * s.T_1 - s.phase) / case.resonance.q if case.resonance.q else s.beta
    own = (case.secular - case.secular.subs(linear)).subs({s.beta: beta, s.soft: 0})
    assert sp.simplify(sp.expand_complex(sp.expand(own) - sp.expand(cube))) == 0


def test_the_frequency_responses_are_the_corrected_ones(derived, s):
    """Errata E4, E5 and E6; as printed they lack alpha, and the last one has its coefficients swapped."""
    a, k, C, sigma, mu = s.amplitude, s.alpha * s.omega_0, s.C, s.sigma, s.mu
    R = sp.Rational
    corrected = (
        (mu**2 / 4 + (sigma - R(3, 8) * k * a**2) ** 2) * a**2 - s.soft**2 / (4 * s.omega_0**2),
        (mu**2 / 4 + (sigma - R(3, 4) * k * C**2 - R(3, 8) * k * a**2) ** 2) * a**2 - (k * C**3 / 8) ** 2,
        R(9, 4) * mu**2 + (sigma - R(9, 4) * k * C**2 - R(9, 8) * k * a**2) ** 2 - (R(9, 8) * k * C * a) ** 2,
    )
    printed = (
        corrected[0].subs(s.alpha, 1),
        corrected[1].subs(s.alpha, 1),
        R(9, 4) * mu**2
        + (sigma - R(9, 8) * s.omega_0 * C**2 - R(9, 4) * s.omega_0**2 * a**2) ** 2
        - (R(9, 8) * s.omega_0 * C * a) ** 2,
    )
    for case, right, wrong in zip(derived.cases[1:], corrected, printed, strict=True):
        own = case.response.lhs - case.response.rhs
        assert sp.expand(own - right) == 0
        assert sp.expand(own - wrong) != 0


def test_the_solutions_turn_with_the_forcing_and_the_free_phase_drifts(derived, s):
    """Errata E9 and E10: the carrier is omega, not omega_0, and beta is no constant."""
    a, t, forced = s.amplitude, s.t, s.C * sp.cos(s.omega * s.t)
    none, primary, superharmonic, subharmonic = derived.cases
    assert sp.simplify(primary.x - a * sp.cos(s.omega * t - s.phase)) == 0
    assert sp.simplify(superharmonic.x - a * sp.cos(3 * s.omega * t - s.phase) - forced) == 0
    assert sp.simplify(subharmonic.x - a * sp.cos((s.omega * t - s.phase) / 3) - forced) == 0
    decay = sp.exp(-s.mu * t / 2)
    drift = sp.integrate(none.phase_rate.subs(a, s.a_0 * decay), t)
    angle = s.omega_0 * t + s.beta_0 + drift - drift.subs(t, 0)
    assert sp.simplify(none.x - forced - s.a_0 * decay * sp.cos(angle)) == 0
    assert sp.simplify(none.C - s.A / (s.omega_0**2 - s.omega**2)) == 0


def random_system(resonance, seed):
    """Omega_0 is not 1, so that its powers show; the subharmonic case is one in which it exists."""
    rng = np.random.default_rng([54, *resonance, seed])
    J, omega_0, alpha, mu = rng.uniform((0.5, 0.5, 0.02, 1e-3), (3.0, 4.0, 0.1, 4e-3))
    law, q = sw.Cubic(J * omega_0**2, alpha), resonance.q
    at = resonance.q / resonance.p if q else rng.uniform(0.2, 0.5)
    C = rng.uniform(0.5, 1.2)
    detuned = rng.uniform(-0.2, 0.8)
    if q == 3:  # the subharmonic motion exists from 7/4 k C^2 on, k = 9/8 alpha omega_0, and a little more with damping
        detuned = (63.0 / 32.0 + rng.uniform(0.3, 1.5)) * C**2
    sigma = omega_0 * alpha * detuned
    omega = at * omega_0 + (sigma / resonance.p if q else 0.0)
    A = J * rng.uniform(0.3, 1.0) * mu * omega_0 if resonance == sw.PRIMARY else J * C * (omega_0**2 - omega**2)
    return sw.Oscillator(J, J * mu, law, sw.Harmonic(A), omega)


def numbers_of(case, s, expressions):
    """A function of a system, an amplitude, the article's phase and a time."""
    own = (s.mu, s.omega_0, s.alpha, s.omega, s.sigma, s.C, s.soft)
    call = sp.lambdify((*own, s.amplitude, s.phase, s.t), expressions, "numpy")
    p, q = case.resonance

    def values(system, a, phase, t=0.0):
        mu, omega_0, f = system.B / system.J, np.sqrt(system.law.K / system.J), system.excitation.amplitude / system.J
        C, sigma = f / (omega_0**2 - system.omega**2), p * system.omega - q * omega_0
        return call(mu, omega_0, system.law.alpha, system.omega, sigma, C, f, a, phase, t)

    return values


@pytest.mark.parametrize("kind", DRIVEN)
def test_every_steady_state_is_one_of_the_derived_equations_with_its_stability_and_motion(derived, s, kind):
    case = derived.cases[CASES[kind]]
    left, right = case.response.lhs, case.response.rhs
    parts = [left, right, case.amplitude_rate, case.phase_rate, case.determinant, case.trace, case.x]
    values, stable, count = numbers_of(case, s, parts), set(), 0
    times = np.linspace(0.0, 30.0, 7)
    for seed in range(60):
        system = random_system(case.resonance, seed)
        flow = sw.slow_flow(system, case.resonance)
        for state in flow.steady_states():
            a, phase = state.amplitude, state.phase * case.resonance.q
            if a == 0.0:
                assert state.stable  # as the row `stable: a = 0` says
                continue
            count += 1
            lhs, rhs, by_a, by_phase, determinant, trace, x = values(system, a, phase, times)
            assert lhs == pytest.approx(rhs, rel=1e-11)
            assert abs(by_a) < 1e-13 * system.omega * a
            assert abs(by_phase) < 1e-12 * system.omega
            assert state.stable is bool(trace < 0.0 and determinant > 0.0)
            assert x == pytest.approx(flow.steady_x(a * np.exp(-1j * state.phase), times), abs=1e-12)
            stable.add(state.stable)
    assert count >= 60
    assert stable == {True, False}


@pytest.mark.parametrize("kind", ["primary", "superharmonic"])
def test_the_determinant_vanishes_where_the_response_has_a_vertical_tangent(derived, s, kind):
    case = derived.cases[CASES[kind]]
    slope = sp.diff(case.response.lhs - case.response.rhs, s.amplitude) / (2 * s.amplitude)
    assert sp.expand(slope - case.determinant) == 0


def test_the_free_part_without_resonance_is_the_integrated_motion_by_its_drift_alone(derived, s):
    """The article's printed numbers at 10.47 rad/s from rest over 5/mu: 4.2 % RMS with beta', 54.6 % without (E10)."""
    case, mu, omega_0, omega, A = derived.cases[0], 0.129, 37.2, 10.47, 380.228
    C = A / (omega_0**2 - omega**2)
    system = sw.Oscillator(1.0, mu, sw.Cubic(omega_0**2, 0.1), sw.Harmonic(A), omega)
    values = {s.mu: mu, s.omega_0: omega_0, s.alpha: 0.1, s.C: C, s.omega: omega}
    x, v = (sp.lambdify((s.t, s.a_0, s.beta_0), e.subs(values)) for e in (case.x, sp.diff(case.x, s.t)))
    a_0, beta_0 = fsolve(lambda free: [x(0.0, *free), v(0.0, *free)], [C, np.pi], xtol=1e-13)
    t = np.linspace(0.0, 5.0 / mu, 8001)
    start, span = (0.0, 0.0), (0.0, float(t[-1]))
    true = solve_ivp(lambda u, y: system.rhs(omega * u, y), span, start, "DOP853", t, rtol=1e-9, atol=1e-12).y[0]
    constant = a_0 * np.exp(-mu * t / 2.0) * np.cos(omega_0 * t + beta_0) + C * np.cos(omega * t)

    def off(motion):
        return np.sqrt(np.mean((motion - true) ** 2) / np.mean(true**2))

    assert off(x(t, a_0, beta_0)) == pytest.approx(0.042, abs=5e-4)
    assert off(constant) == pytest.approx(0.546, abs=5e-4)
    assert x(t, a_0, beta_0) == pytest.approx(sw.slow_flow(system, sw.NONRESONANT).x(t), abs=1e-9)


def test_text_latex_and_mathml_have_every_case_and_every_step(derived):
    text, tex = str(derived), derived.latex()
    titles = [part.title for part in derived.parts]
    names = ("no resonance", "primary 1:1", "superharmonic 3:1", "subharmonic 1:3")
    assert titles[1:] == [f"Case {n}: {name}" for n, name in enumerate(names, 1)]
    assert text.count("\n\n") == tex.count("\n\n") == 4
    assert tex.count(r"\begin{aligned}") == tex.count(r"\end{aligned}") == 5
    for part in derived.parts:
        steps = [title for title, *_ in part.rows()]
        assert len(steps) == len(set(steps))
        assert steps == [title for title, _ in part.mathml()]
        assert [name for name in (part.title, *steps) if name not in text or f"{{{name}" not in tex] == []
        for _, formula in part.mathml():
            ElementTree.fromstring(f"<math>{formula.replace('&', '&amp;')}</math>")  # XML has fewer entities than HTML
            assert "'" not in formula
            assert "<mo>-</mo>" not in formula
    needed = {"secular terms", "amplitude", "rate of phase", "frequency response", "Jacobian", "x(t) for epsilon = 1"}
    for case in derived.cases:
        assert needed <= {title for title, *_ in case.rows()}
    assert "a' = -a*mu/2 + f*sin(phi)/(2*omega_0)" in text
    assert "x = C*cos(omega*t) + a*cos(omega*t/3 - phi/3)" in text
